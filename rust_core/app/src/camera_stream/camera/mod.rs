//! One camera of the node: its place in the config, its settings, and the frames that it publishes.

pub(crate) mod frame;
pub(crate) mod health;
pub(crate) mod latency;
pub(crate) mod oriented_frames;
pub(crate) mod oriented_info;
pub(crate) mod output;
pub(crate) mod pacing;
pub(crate) mod plan;
pub(crate) mod progress;
pub(crate) mod reconfigurable;
pub(crate) mod runtime_settings;
