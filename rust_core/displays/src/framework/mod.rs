//! Common parts of all displays: the scene's state, the trait of one, the world around them, and their statuses.

pub(crate) mod arrivals;
pub(crate) mod display;
pub(crate) mod entry;
pub(crate) mod frame;
pub(crate) mod in_view;
pub(crate) mod lookups;
pub(crate) mod message_cache;
pub(crate) mod message_display;
pub(crate) mod not_drawn;
pub(crate) mod report;
pub(crate) mod scene_state;
pub(crate) mod status;
#[cfg(test)]
pub(crate) mod test_world;
pub(crate) mod waiting_messages;
pub(crate) mod world;
