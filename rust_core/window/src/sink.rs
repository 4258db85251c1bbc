//! The window's handle for other threads: the newest picture and the request to close, with a descriptor that wakes the
//! window's thread.

use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use rcs_scene::lock;
use rustix::event::{eventfd, EventfdFlags};
use rustix::io::{read, write};

use crate::light::{LitPicture, WindowPermit, WindowView};
use crate::refresh::Refresh;
use crate::screen_picture::ScreenPicture;

/// A picture in the sink.
#[derive(Debug, Clone)]
pub(crate) enum SunkPicture {
    /// A converted picture.
    Read(ScreenPicture, WindowPermit),
    /// A drawn picture, which the window's thread converts.
    Drawn(LitPicture),
    /// Black.
    Nothing,
}

/// The window's handle for other threads, to show pictures and to close the window.
#[derive(Debug, Clone)]
pub struct PictureSink(Arc<SinkState>);

#[derive(Debug)]
struct SinkState {
    /// The newest picture, and since when the window has not taken one.
    newest: Mutex<Option<(SunkPicture, Instant)>>,
    is_closing: AtomicBool,
    refresh: Mutex<Option<Refresh>>,
    /// The view that the program has selected; `None`: keys select it.
    view: Mutex<Option<WindowView>>,
    /// Overrides the options.
    stale_timeout: Mutex<Option<Duration>>,
    /// Time of the last confirmation that the picture is current.
    confirmed: Mutex<Option<Instant>>,
    /// An eventfd.
    wake: OwnedFd,
}

impl PictureSink {
    /// A sink for [`crate::run_with`]: pictures may be shown before the window is open, and it may be opened again.
    ///
    /// # Errors
    /// The process has no descriptors left.
    pub fn new() -> std::io::Result<Self> {
        let wake = eventfd(0, EventfdFlags::CLOEXEC | EventfdFlags::NONBLOCK)?;
        Ok(Self(Arc::new(SinkState {
            newest: Mutex::default(),
            is_closing: AtomicBool::new(false),
            refresh: Mutex::default(),
            view: Mutex::default(),
            stale_timeout: Mutex::default(),
            confirmed: Mutex::default(),
            wake,
        })))
    }

    /// Shows a picture; replaces one that was not drawn yet.
    pub fn show(&self, picture: ScreenPicture) {
        self.show_permitted(picture, WindowPermit::default());
    }

    /// Shows a picture, with limits of content in its place.
    pub fn show_permitted(&self, picture: ScreenPicture, permit: WindowPermit) {
        self.hand_over(SunkPicture::Read(picture, permit));
    }

    /// Shows a shared picture; it is converted on the window's thread.
    pub fn show_drawn(&self, picture: LitPicture) {
        self.hand_over(SunkPicture::Drawn(picture));
    }

    /// Selects the view of a window whose keys the program handles.
    pub fn set_view(&self, view: WindowView) {
        if lock(&self.0.view).replace(view) != Some(view) {
            self.wake();
        }
    }

    pub(crate) fn view(&self) -> Option<WindowView> {
        *lock(&self.0.view)
    }

    /// Overrides the options' time without a picture after which the window becomes black; zero: never.
    pub fn set_stale_timeout(&self, timeout: Duration) {
        *lock(&self.0.stale_timeout) = Some(timeout);
        self.wake();
    }

    pub(crate) fn stale_timeout(&self) -> Option<Duration> {
        *lock(&self.0.stale_timeout)
    }

    /// Confirms that the newest picture is current, so that it does not become stale.
    pub fn confirm(&self) {
        *lock(&self.0.confirmed) = Some(Instant::now());
    }

    pub(crate) fn confirmed(&self) -> Option<Instant> {
        *lock(&self.0.confirmed)
    }

    /// The refresh of the window's monitor; `None` if the display server does not report it.
    pub fn refresh(&self) -> Option<Refresh> {
        *lock(&self.0.refresh)
    }

    pub(crate) fn set_refresh(&self, refresh: Option<Refresh>) {
        *lock(&self.0.refresh) = refresh;
    }

    /// Shows black, until the next picture.
    pub fn clear(&self) {
        self.hand_over(SunkPicture::Nothing);
    }

    /// Closes the window; [`crate::run`] returns.
    pub fn close(&self) {
        self.0.is_closing.store(true, Ordering::Release);
        self.wake();
    }

    /// `true` after [`PictureSink::close`].
    pub fn is_closing(&self) -> bool {
        self.0.is_closing.load(Ordering::Acquire)
    }

    fn hand_over(&self, mut picture: SunkPicture) {
        let mut newest = lock(&self.0.newest);
        let waiting_since = newest.as_ref().map(|(_, since)| *since);
        // The same picture again, of which somebody still waits to hear.
        if let (SunkPicture::Drawn(picture), Some((SunkPicture::Drawn(last), _))) = (&mut picture, &mut *newest) {
            if Arc::ptr_eq(&picture.picture, &last.picture) {
                picture.on_screen = picture.on_screen.take().or(last.on_screen.take());
            }
        }
        *newest = Some((picture, waiting_since.unwrap_or_else(Instant::now)));
        drop(newest);
        // One wake-up is enough for any number of pictures.
        if waiting_since.is_none() {
            self.wake();
        }
    }

    fn wake(&self) {
        // Fails only on overflow, when the descriptor is readable already.
        let _ = write(&self.0.wake, &1u64.to_ne_bytes());
    }

    /// Takes the newest picture.
    pub(crate) fn take(&self) -> Option<SunkPicture> {
        lock(&self.0.newest).take().map(|(picture, _)| picture)
    }

    /// Time since which a picture waits for the window. An open window takes each at once, unless its display server
    /// hangs.
    pub fn waiting_since(&self) -> Option<Instant> {
        lock(&self.0.newest).as_ref().map(|(_, since)| *since)
    }

    /// The descriptor that becomes readable with a picture or a request.
    pub(crate) fn wake_fd(&self) -> BorrowedFd<'_> {
        self.0.wake.as_fd()
    }

    /// Makes the descriptor unreadable again.
    pub(crate) fn clear_wake(&self) {
        let mut count = [0; 8];
        // Fails only if it was not readable.
        let _ = read(&self.0.wake, &mut count);
    }
}
