//! The loaded config at work: its displays and cameras, the topics that feed them, and their statuses.

pub mod camera_pose;
pub(crate) mod lazy_streams;
pub(crate) mod status_log;
pub(crate) mod status_tree;
pub(crate) mod subscriptions;
pub(crate) mod visibility;

pub use camera_pose::{camera, renderer_view};
pub use rcs_displays::SceneState;
