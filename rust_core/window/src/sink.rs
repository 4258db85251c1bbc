//! The window's handle for other threads: the newest image and the request to close, with a descriptor that wakes the
//! window's thread.

use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Instant;

use rcs_light::{Grant, Lit};
use rcs_process::lock;
use rcs_scene::Image;
use rustix::event::{eventfd, EventfdFlags};
use rustix::io::{read, write};

use crate::on_screen::OnScreen;
use crate::refresh::Refresh;
use crate::screen_image::ScreenImage;
use crate::switch_pipe::SwitchPipe;

/// An image in the sink.
#[derive(Debug, Clone)]
pub(crate) enum SunkImage {
    /// A converted image.
    Read(Lit<Arc<ScreenImage>>),
    /// A drawn image, which the window's thread converts, and what hears when it is on the screen.
    Drawn(Lit<Arc<Image>>, Option<Arc<dyn OnScreen>>),
    /// Black.
    Nothing,
}

/// The window's handle for other threads, to show images and to close the window.
#[derive(Debug, Clone)]
pub struct ImageSink(Arc<SinkState>);

#[derive(Debug)]
struct SinkState {
    /// The newest image, and since when the window has not taken one.
    newest: Mutex<Option<(SunkImage, Instant)>>,
    is_closing: AtomicBool,
    refresh: Mutex<Option<Refresh>>,
    /// The last grant of the newest image.
    renewed: Mutex<Option<Grant>>,
    /// Hears of the end of a window with a dead-man's switch.
    switch: Mutex<Option<Arc<SwitchPipe>>>,
    /// An eventfd.
    wake: OwnedFd,
}

impl ImageSink {
    /// A sink for [`crate::run_with`]: images may be shown before the window is open, and it may be opened again.
    ///
    /// # Errors
    /// The process has no descriptors left.
    pub fn new() -> std::io::Result<Self> {
        let wake = eventfd(0, EventfdFlags::CLOEXEC | EventfdFlags::NONBLOCK)?;
        Ok(Self(Arc::new(SinkState {
            newest: Mutex::default(),
            is_closing: AtomicBool::new(false),
            refresh: Mutex::default(),
            renewed: Mutex::default(),
            switch: Mutex::default(),
            wake,
        })))
    }

    /// Shows an image of a tool that a person runs at the projector; replaces one that was not drawn yet.
    pub fn show(&self, image: ScreenImage) {
        match Grant::of_tool().show(Arc::new(image)) {
            Some(lit) => self.show_lit(lit),
            None => self.clear(),
        }
    }

    /// Shows an image while its grant holds.
    pub fn show_lit(&self, image: Lit<Arc<ScreenImage>>) {
        self.hand_over(SunkImage::Read(image));
    }

    /// Shows a shared image while its grant holds; it is converted on the window's thread.
    pub fn show_drawn(&self, image: Lit<Arc<Image>>, on_screen: Option<Arc<dyn OnScreen>>) {
        self.hand_over(SunkImage::Drawn(image, on_screen));
    }

    /// Gives the newest image a later grant, so that it does not become black.
    pub fn renew(&self, grant: &Grant) {
        *lock(&self.0.renewed) = Some(grant.clone());
    }

    pub(crate) fn take_renewed(&self) -> Option<Grant> {
        lock(&self.0.renewed).take()
    }

    /// The refresh of the window's monitor; `None` if the display server does not report it.
    pub fn refresh(&self) -> Option<Refresh> {
        *lock(&self.0.refresh)
    }

    pub(crate) fn set_refresh(&self, refresh: Option<Refresh>) {
        *lock(&self.0.refresh) = refresh;
    }

    /// Shows black, until the next image.
    pub fn clear(&self) {
        self.hand_over(SunkImage::Nothing);
    }

    /// Closes the window; [`crate::run`] returns.
    pub fn close(&self) {
        self.0.is_closing.store(true, Ordering::Release);
        // Here, because the window's thread may wait for a display server that hangs.
        lock(&self.0.switch).iter().for_each(|switch| switch.end());
        self.wake();
    }

    pub(crate) fn set_switch(&self, switch: Option<Arc<SwitchPipe>>) {
        *lock(&self.0.switch) = switch;
    }

    /// `true` after [`ImageSink::close`].
    pub fn is_closing(&self) -> bool {
        self.0.is_closing.load(Ordering::Acquire)
    }

    fn hand_over(&self, mut image: SunkImage) {
        let mut newest = lock(&self.0.newest);
        let waiting_since = newest.as_ref().map(|(_, since)| *since);
        // The same image again, of which somebody still waits to hear.
        if let (SunkImage::Drawn(image, hears), Some((SunkImage::Drawn(last, heard), _))) = (&mut image, &mut *newest) {
            if image.is_same(last) {
                *hears = hears.take().or(heard.take());
            }
        }
        *newest = Some((image, waiting_since.unwrap_or_else(Instant::now)));
        drop(newest);
        // One wake-up is enough for any number of images.
        if waiting_since.is_none() {
            self.wake();
        }
    }

    /// Has the window check its grant now: the operator has said something.
    pub fn wake(&self) {
        // Fails only on overflow, when the descriptor is readable already.
        let _ = write(&self.0.wake, &1u64.to_ne_bytes());
    }

    /// Takes the newest image.
    pub(crate) fn take(&self) -> Option<SunkImage> {
        lock(&self.0.newest).take().map(|(image, _)| image)
    }

    /// Time since which an image waits for the window. An open window takes each at once, unless its display server
    /// hangs.
    pub fn waiting_since(&self) -> Option<Instant> {
        lock(&self.0.newest).as_ref().map(|(_, since)| *since)
    }

    /// The descriptor that becomes readable with an image or a request.
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
