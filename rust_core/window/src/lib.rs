//! The projector's window: a picture full screen on a chosen monitor, pixel for pixel.
//!
//! [`run`] opens the window on the calling thread, whichever that is, and stays until the user presses Escape or q,
//! closes it, or [`PictureSink::close`] is called. Other threads hand pictures to the sink; only the newest is kept,
//! and the window is drawn when a new picture arrives or the window system requests it, so an unchanged picture costs
//! nothing. [`run_interactive`] also reports keys and the monitor, for programs that draw to its size; [`run_with`] can
//! be called again when the window system went away and came back.
//!
//! Nothing is ever scaled, because a projection fits the world only while picture pixel (u, v) is screen pixel (u, v):
//! all sizes here are physical pixels, whatever the desktop's scale factor. If picture and monitor
//! differ in size, the picture is shown at the top left on black, and a warning is printed once for each size.
//!
//! ```text
//!   sink ──► run: content (picture | black | test picture) ──► SystemWindow: x11 | wayland ──► shared pixels
//! ```

#![forbid(unsafe_code)]

mod content;
mod coverage;
mod identify;
mod keys;
mod light;
mod monitor;
mod refresh;
mod run;
mod screen_picture;
mod shared_pixels;
mod sink;
pub mod test_pictures;
mod watch;
mod wayland;
mod x11;

pub use identify::identify;
pub use keys::WindowKey;
pub use light::{Light, LitPicture, Mask, WindowPermit};
pub use monitor::{list as list_lines, MonitorChoice, MonitorError, MonitorInfo};
pub use refresh::Refresh;
pub use run::UserEvent;
pub use screen_picture::{PictureError, ReceivedPicture, ScreenPicture};
pub use sink::PictureSink;

use std::path::PathBuf;
use std::time::{Duration, Instant};

use rcs_files::picture_file::PictureFileError;
use rustix::event::Timespec;

use crate::run::{Keys, SystemWindow};
use crate::wayland::WaylandWindow;
use crate::x11::{X11Session, X11Window};

/// What the window shows and where.
#[derive(Debug, Clone, Default)]
pub struct WindowOptions {
    /// The topic of the pictures, for the window's title and for warnings.
    pub source: String,
    /// The monitor to cover.
    pub monitor: MonitorChoice,
    /// A PNG or JPEG file to save the window's pixels to, once the first picture is on the screen.
    pub screenshot: Option<PathBuf>,
    /// The window becomes black when no picture came for so long; zero: never.
    pub stale_timeout: Option<Duration>,
    /// What test pictures may light while there is no picture that says so, or pictures have stopped coming.
    pub test_light: Light,
    /// Whether a monitor that runs another mode is set to its native one; otherwise there is a warning.
    pub set_mode: bool,
}

/// Why the window could not be opened, or had to be closed.
#[derive(Debug, thiserror::Error)]
pub enum WindowError {
    /// There is no window system, or it does not take this window.
    #[error("no window: {0}")]
    NoDisplay(String),
    /// The connection to the window system broke.
    #[error("the window is lost: {0}")]
    Lost(String),
    /// The monitor that was asked for does not exist.
    #[error(transparent)]
    Monitor(#[from] MonitorError),
    /// The window system refuses the window.
    #[error("cannot open a window on monitor {monitor}: {reason}")]
    Open {
        /// The monitor.
        monitor: MonitorInfo,
        /// The window system's error.
        reason: String,
    },
    /// The screenshot cannot be written.
    #[error(transparent)]
    Screenshot(#[from] PictureFileError),
    /// The system has no descriptor or no memory left.
    #[error("no window: {0}")]
    System(#[from] std::io::Error),
}

/// Opens the window and shows pictures until it is closed. Its keys: space or p pauses, b is black, t shows test
/// pictures, each until it is pressed again and as far as a [`WindowPermit`] allows it.
///
/// `start` is called once, when the window is open, with the sink for pictures. It must not block: it starts threads.
///
/// # Errors
/// [`WindowError`] when there is no display, no such monitor, or the window system refuses the window or goes away.
pub fn run(options: &WindowOptions, start: impl FnOnce(PictureSink)) -> Result<(), WindowError> {
    let mut start = Some(start);
    run_with(options, &PictureSink::new()?, |_, sink| {
        // The first event is that it is open.
        if let Some(start) = start.take() {
            start(sink.clone());
        }
    })
}

/// Opens the window and shows the sink's pictures until it is closed, as [`run`]. `handle` is called on this thread for
/// each event; it must not block.
///
/// # Errors
/// As for [`run`].
pub fn run_with(
    options: &WindowOptions,
    sink: &PictureSink,
    mut handle: impl FnMut(UserEvent<'_>, &PictureSink),
) -> Result<(), WindowError> {
    run::run(open(options)?.as_mut(), options, Keys::Window, sink, &mut handle)
}

/// Opens the window and shows pictures until it is closed, as [`run`]; all keys but those that end it are the
/// program's. `handle` is called on this thread for each event and may show pictures at once; it must not block.
///
/// # Errors
/// As for [`run`].
pub fn run_interactive(
    options: &WindowOptions,
    mut handle: impl FnMut(UserEvent<'_>, &PictureSink),
) -> Result<(), WindowError> {
    run::run(open(options)?.as_mut(), options, Keys::Program, &PictureSink::new()?, &mut handle)
}

/// Opens a window: on Wayland if the environment names a compositor, else on X11.
fn open(options: &WindowOptions) -> Result<Box<dyn SystemWindow>, WindowError> {
    Ok(if wayland::is_named() { Box::new(WaylandWindow::open(options)?) } else { Box::new(X11Window::open(options)?) })
}

/// Keeps the window of another program, which has this title, over a monitor until `is_ending`: full screen, without
/// decoration. The window may come late, go, and come again. On X11 only.
///
/// # Errors
/// [`WindowError::NoDisplay`] without an X server, [`WindowError::Lost`] when it goes away.
pub fn keep_over(title: &str, monitor: &MonitorChoice, is_ending: impl Fn() -> bool) -> Result<(), WindowError> {
    x11::keep_over(title, monitor, &is_ending)
}

/// All monitors, in the order in which [`MonitorChoice`] counts them.
///
/// # Errors
/// [`WindowError::NoDisplay`] when there is no display.
pub fn list_monitors() -> Result<Vec<MonitorInfo>, WindowError> {
    if wayland::is_named() {
        return wayland::monitors();
    }
    Ok(X11Session::open()?.monitors())
}

/// A time to wait for, as the kernel takes it.
fn timeout_until(until: Instant) -> Timespec {
    let left = until.saturating_duration_since(Instant::now());
    let seconds = i64::try_from(left.as_secs()).unwrap_or(i64::MAX);
    Timespec { tv_sec: seconds, tv_nsec: left.subsec_nanos().into() }
}
