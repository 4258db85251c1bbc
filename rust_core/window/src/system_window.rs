//! A window on one of the window systems: X11 or Wayland.

use std::os::fd::BorrowedFd;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

use rustix::event::{poll, PollFd, Timespec};
use rustix::io::Errno;
use xkeysym::Keysym;

use crate::dead_man::WindowRole;
use crate::error::WindowError;
use crate::monitor::{MonitorChoice, MonitorInfo};
use crate::on_screen::OnScreen;
use crate::refresh::Refresh;

/// Settings of a window.
#[derive(Debug, Clone, Default)]
pub struct WindowOptions {
    /// The topic of the images, for the window's title and for warnings.
    pub source: String,
    /// The monitor to cover.
    pub monitor: MonitorChoice,
    /// A PNG or JPEG file to save the window's pixels to, once the first image is on the screen.
    pub screenshot: Option<PathBuf>,
    /// Longest time for which a program grants light at once; `None` for a tool's own images.
    pub light_limit: Option<Duration>,
    /// `true` to set a monitor to its native mode; otherwise there is a warning if it runs another one.
    pub set_mode: bool,
    /// Role of the window on its monitor.
    pub role: WindowRole,
}

/// An open window on a window system.
pub(crate) trait SystemWindow {
    /// The monitor at the last check.
    fn monitor(&self) -> &MonitorInfo;

    /// `true` while the monitor is present.
    fn is_there(&self) -> bool;

    /// Brings the window to the front of others, by showing it anew.
    fn come_to_front(&mut self) -> Result<(), WindowError>;

    /// Current width and height of the window, pixels; zero while it is not on the screen.
    fn size_px(&self) -> (u32, u32);

    /// `true` if the window system accepts an image; otherwise an event follows when it does.
    fn is_ready(&self) -> bool;

    /// Brings pixels of the window's size to the screen, `0x00RRGGBB`, rows from the top. `on_screen` hears when they
    /// are there.
    fn present(&mut self, pixels: &[u32], on_screen: Option<Arc<dyn OnScreen>>) -> Result<(), WindowError>;

    /// The monitor's refresh, if the window system reports it.
    fn refresh(&self) -> Option<Refresh> {
        None
    }

    /// Waits for events, until `wake` is readable, or until a time. Returns the events.
    fn wait(&mut self, wake: BorrowedFd<'_>, until: Instant) -> Result<Vec<SystemEvent>, WindowError>;

    /// Time of the next [`check`](Self::check).
    fn next_check(&self) -> Instant;

    /// Checks that the window covers its monitor, and corrects its place. Returns `true` if the monitor's position or
    /// size changed.
    fn check(&mut self, now: Instant) -> Result<bool, WindowError>;
}

/// An event of the window system.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum SystemEvent {
    /// The window needs to be drawn, or is ready for it.
    Expose,
    /// A key was pressed, or repeats because it is held down.
    Key {
        /// The key's symbol.
        keysym: Keysym,
        /// `true` for a repetition.
        is_repeat: bool,
    },
    /// The monitors changed.
    Monitors,
    /// The user closed the window.
    Close,
}

/// Waits until a descriptor is readable, a signal arrives, or a time.
pub(crate) fn poll_until(descriptors: &mut [PollFd<'_>], until: Instant) -> Result<(), WindowError> {
    let left = until.saturating_duration_since(Instant::now());
    let seconds = i64::try_from(left.as_secs()).unwrap_or(i64::MAX);
    let timeout = Timespec { tv_sec: seconds, tv_nsec: left.subsec_nanos().into() };
    match poll(descriptors, Some(&timeout)) {
        Ok(_) | Err(Errno::INTR) => Ok(()),
        Err(error) => Err(WindowError::Lost(error.to_string())),
    }
}
