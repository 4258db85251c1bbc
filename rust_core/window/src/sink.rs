//! The window's handle for other threads: the newest picture and the wish to close, with a descriptor that wakes the
//! window's thread while it waits for its window system.

use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use rcs_scene::lock;
use rustix::event::{eventfd, EventfdFlags};
use rustix::io::{read, write};

use crate::light::{LitPicture, WindowPermit};
use crate::refresh::Refresh;
use crate::screen_picture::ScreenPicture;

/// A picture as it was handed over.
#[derive(Debug, Clone)]
pub(crate) enum Handed {
    /// Read already.
    Read(ScreenPicture, WindowPermit),
    /// As it was drawn; the window's thread reads it.
    Drawn(LitPicture),
    /// No picture: black.
    Nothing,
}

/// The window's handle for other threads, which show pictures with it and close the window.
#[derive(Debug, Clone)]
pub struct PictureSink(Arc<Inner>);

#[derive(Debug)]
struct Inner {
    /// With when the first was handed over of those that were not taken.
    newest: Mutex<Option<(Handed, Instant)>>,
    is_closing: AtomicBool,
    refresh: Mutex<Option<Refresh>>,
    /// In place of the options'.
    stale_timeout: Mutex<Option<Duration>>,
    /// When the last picture was last called current.
    confirmed: Mutex<Option<Instant>>,
    /// An event descriptor of the kernel's.
    wake: OwnedFd,
}

impl PictureSink {
    /// For a window that is opened with [`crate::run_with`]: pictures may be shown before it is open, and it may be
    /// opened again.
    ///
    /// # Errors
    /// When the process has no descriptors left.
    pub fn new() -> std::io::Result<Self> {
        let wake = eventfd(0, EventfdFlags::CLOEXEC | EventfdFlags::NONBLOCK)?;
        Ok(Self(Arc::new(Inner {
            newest: Mutex::default(),
            is_closing: AtomicBool::new(false),
            refresh: Mutex::default(),
            stale_timeout: Mutex::default(),
            confirmed: Mutex::default(),
            wake,
        })))
    }

    /// Shows a picture, in place of one that was not drawn yet.
    pub fn show(&self, picture: ScreenPicture) {
        self.show_permitted(picture, WindowPermit::default());
    }

    /// Shows a picture, and says what may be lit in its place.
    pub fn show_permitted(&self, picture: ScreenPicture, permit: WindowPermit) {
        self.hand_over(Handed::Read(picture, permit));
    }

    /// Shows a picture that others hold as well; it is read on the window's thread.
    pub fn show_drawn(&self, picture: LitPicture) {
        self.hand_over(Handed::Drawn(picture));
    }

    /// Has the window become black when no picture came for so long; zero: never. In place of the options' time.
    pub fn set_stale_timeout(&self, timeout: Duration) {
        *lock(&self.0.stale_timeout) = Some(timeout);
        self.wake();
    }

    pub(crate) fn stale_timeout(&self) -> Option<Duration> {
        *lock(&self.0.stale_timeout)
    }

    /// Says that the picture shown last is still current, so that it does not become stale.
    pub fn confirm(&self) {
        *lock(&self.0.confirmed) = Some(Instant::now());
    }

    pub(crate) fn confirmed(&self) -> Option<Instant> {
        *lock(&self.0.confirmed)
    }

    /// When the window's monitor is refreshed; `None` where the display server does not tell.
    pub fn refresh(&self) -> Option<Refresh> {
        *lock(&self.0.refresh)
    }

    pub(crate) fn set_refresh(&self, refresh: Option<Refresh>) {
        *lock(&self.0.refresh) = refresh;
    }

    /// Shows black, until the next picture.
    pub fn clear(&self) {
        self.hand_over(Handed::Nothing);
    }

    /// Closes the window; [`crate::run`] returns.
    pub fn close(&self) {
        self.0.is_closing.store(true, Ordering::Release);
        self.wake();
    }

    /// Whether the window was asked to close.
    pub fn is_closing(&self) -> bool {
        self.0.is_closing.load(Ordering::Acquire)
    }

    fn hand_over(&self, picture: Handed) {
        let mut newest = lock(&self.0.newest);
        let waiting_since = newest.as_ref().map(|(_, since)| *since);
        *newest = Some((picture, waiting_since.unwrap_or_else(Instant::now)));
        drop(newest);
        // One wake-up is enough for any number of pictures.
        if waiting_since.is_none() {
            self.wake();
        }
    }

    fn wake(&self) {
        // It fails only when it would overflow, and then it is readable already.
        let _ = write(&self.0.wake, &1u64.to_ne_bytes());
    }

    /// The newest picture, once.
    pub(crate) fn take(&self) -> Option<Handed> {
        lock(&self.0.newest).take().map(|(picture, _)| picture)
    }

    /// Since when there has been a picture that the window has not taken. An open window takes each at once, unless
    /// its display server does not answer.
    pub fn waiting_since(&self) -> Option<Instant> {
        lock(&self.0.newest).as_ref().map(|(_, since)| *since)
    }

    /// What becomes readable when something was asked of the window.
    pub(crate) fn wake_fd(&self) -> BorrowedFd<'_> {
        self.0.wake.as_fd()
    }

    /// Makes the descriptor unreadable again.
    pub(crate) fn clear_wake(&self) {
        let mut count = [0; 8];
        // An error means that it was not readable.
        let _ = read(&self.0.wake, &mut count);
    }
}
