//! Pictures on their way out: PNG files and a projector's window. And what the node says of itself.

pub mod diagnostics_topic;
pub mod image_topic;
pub mod png;
pub mod sockets;
pub mod window;
pub mod window_monitor;
mod window_open;
pub mod window_picture;
mod window_place;
mod window_x11;
