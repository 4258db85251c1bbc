//! One camera of the node: its place in the config, its settings, and the frames that it publishes.

mod brightness;
mod buffers;
pub(crate) mod connections;
mod dimmer;
pub(crate) mod frame;
mod granting;
mod health;
mod idle;
pub(crate) mod latency;
pub(crate) mod light_check;
pub(crate) mod oriented_frames;
pub(crate) mod oriented_info;
pub(crate) mod output;
mod pacing;
mod page_view;
pub(crate) mod plan;
pub(crate) mod rearrange;
mod reconfigurable;
mod runtime_settings;
mod substitute;
mod timing;
