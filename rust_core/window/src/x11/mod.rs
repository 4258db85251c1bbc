//! The window on an X server, over a connection in Rust.
//!
//! Xlib ends the process when the server goes away: here that is an error, and a node can go on without its window and
//! open it again. The connection needs no main thread.

mod awake;
mod grab;
mod inspect;
mod keep_over;
mod keyboard;
mod modes;
mod monitors;
mod pixel_format;
mod place;
mod refresh;
mod session;
mod transfer;
mod window;

pub use grab::ScreenGrabber;
pub(crate) use inspect::inspect;
pub(crate) use keep_over::keep_over;
pub(crate) use session::X11Session;
pub(crate) use window::X11Window;
