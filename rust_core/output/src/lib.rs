//! Pictures on their way out: PNG files and a projector's window.

pub mod png;
pub mod window;
pub mod window_monitor;
pub mod window_picture;
mod window_x11;
