//! What all displays share: their set, the contract of one, the world around them, and what they report.

pub(crate) mod arrivals;
pub(crate) mod display;
pub(crate) mod frame;
pub(crate) mod in_view;
pub(crate) mod message_display;
pub(crate) mod placed;
pub(crate) mod recall;
pub(crate) mod report;
pub(crate) mod set;
pub(crate) mod status;
pub(crate) mod world;
