//! The projector's window: an image full screen on a chosen monitor, pixel for pixel.
//!
//! [`run_with`] opens the window on the calling thread and returns when the user presses Escape or q, closes it, or
//! [`ImageSink::close`] is called. Other threads pass images to the sink, each with its [grant](rcs_light::Grant);
//! only the newest is kept, and the window is drawn when one arrives, its grant ends, or the window system requests it.
//!
//! Nothing is scaled, because a projection fits the world only while image pixel (u, v) is screen pixel (u, v): all
//! sizes are physical pixels, independent of the desktop's scale factor. If image and monitor differ in size, the
//! image is drawn at the top left on black, and a warning is logged once for each size.
//!
//! ```text
//!   sink ──► run: content (image, while its grant holds | black) ──► SystemWindow: x11 | wayland ──► shared pixels
//! ```

#![forbid(unsafe_code)]
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod content;
mod dead_man;
mod error;
mod identify;
mod keys;
mod monitor;
mod on_screen;
mod open;
mod refresh;
mod report;
mod run;
mod screen_image;
mod shared_pixels;
mod sink;
mod switch_pipe;
mod system_window;
pub mod test_images;
mod watch;
mod wayland;
mod x11;

pub use dead_man::{run_black_window, BlackWindow, WindowRole};
pub use error::WindowError;
pub use identify::identify;
pub use keys::WindowKey;
pub use monitor::{list as list_lines, MonitorChoice, MonitorError, MonitorInfo};
pub use on_screen::OnScreen;
pub use open::{inspect_monitor, keep_over, list_monitors, run_interactive, run_with};
pub use refresh::Refresh;
pub use report::{MonitorMode, MonitorReport, Scan, WindowPlace};
pub use run::UserEvent;
pub use screen_image::{ImageError, ReceivedImage, ScreenImage};
pub use sink::ImageSink;
pub use system_window::WindowOptions;
pub use x11::ScreenGrabber;
