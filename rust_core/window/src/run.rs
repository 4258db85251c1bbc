//! The window from its opening to its end, whatever the window system: waits for what happens, and draws what is to be
//! seen.

use std::collections::HashSet;
use std::os::fd::BorrowedFd;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use rcs_files::picture_file;
use rcs_scene::{Encoding, Picture};
use xkeysym::Keysym;

use crate::content::{Content, Face, Image};
use crate::keys::{is_quit_key, WindowKey};
use crate::light::{dim, LitPicture};
use crate::monitor::MonitorInfo;
use crate::refresh::Refresh;
use crate::screen_picture::{rgb_bytes, PictureError, ScreenPicture};
use crate::sink::{Handed, PictureSink};
use crate::test_pictures::TestPicture;
use crate::{WindowError, WindowOptions};

/// A window that is open, on one of the window systems.
pub(crate) trait SystemWindow {
    /// Its monitor, as it was checked last.
    fn monitor(&self) -> &MonitorInfo;

    /// Columns and rows of the window now; zero while it is not on the screen.
    fn size_px(&self) -> (u32, u32);

    /// Whether the window system takes a picture now; otherwise an event will tell.
    fn is_ready(&self) -> bool;

    /// Brings pixels of the window's size to the screen, `0x00RRGGBB`, rows from the top.
    fn present(&mut self, pixels: &[u32]) -> Result<(), WindowError>;

    /// When its monitor is refreshed, if the window system tells.
    fn refresh(&self) -> Option<Refresh> {
        None
    }

    /// Waits until something happens, `wake` is readable, or it is `until`. Returns what happened.
    fn wait(&mut self, wake: BorrowedFd<'_>, until: Instant) -> Result<Vec<SystemEvent>, WindowError>;

    /// When [`check`](Self::check) is to be called again.
    fn next_check(&self) -> Instant;

    /// Checks whether the window covers its monitor, and puts right what is not. Returns whether the monitor's position
    /// or size changed.
    fn check(&mut self, now: Instant) -> Result<bool, WindowError>;
}

/// What a window system reports.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum SystemEvent {
    /// The window has to be drawn again, or can be.
    Expose,
    /// A key was pressed, or is held down.
    Key(Keysym),
    /// The monitors changed.
    Monitors,
    /// The user closed the window.
    Close,
}

/// What happens to the window that a program may answer.
#[derive(Debug, Clone, Copy)]
pub enum UserEvent<'a> {
    /// The window is open on this monitor: the first event, and once.
    Opened(&'a MonitorInfo),
    /// The monitor has another position or size.
    MonitorChanged(&'a MonitorInfo),
    /// The user pressed a key, or holds it down.
    Key(WindowKey),
}

/// Who answers keys other than those that end the window.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Keys {
    /// The window: pause, black, test pictures.
    Window,
    /// The program.
    Program,
}

/// Runs an open window until it is closed.
pub(crate) fn run(
    window: &mut dyn SystemWindow,
    options: &WindowOptions,
    keys: Keys,
    sink: &PictureSink,
    handle: &mut dyn FnMut(UserEvent<'_>, &PictureSink),
) -> Result<(), WindowError> {
    handle(UserEvent::Opened(window.monitor()), sink);
    let mut shown = Shown::new(options);
    while !sink.is_closing() {
        let now = Instant::now();
        if now >= window.next_check() {
            shown.check(window, sink, handle)?;
            // Makes up for what a busy display server lost.
            shown.is_due = true;
        }
        if let Some(timeout) = sink.stale_timeout() {
            shown.content.set_stale_timeout(timeout);
        }
        shown.take_picture(sink, window.monitor(), now);
        shown.is_due |= sink.confirmed().is_some_and(|at| shown.content.confirm(at));
        shown.is_due |= shown.content.check(now);
        shown.draw_if_due(window)?;
        let until = shown.content.next_check().map_or(window.next_check(), |at| at.min(window.next_check()));
        let events = window.wait(sink.wake_fd(), until)?;
        sink.clear_wake();
        sink.set_refresh(window.refresh());
        for event in events {
            match event {
                SystemEvent::Close => return Ok(()),
                SystemEvent::Key(key) if is_quit_key(key) => return Ok(()),
                SystemEvent::Key(key) => {
                    let Some(key) = WindowKey::from_keysym(key) else { continue };
                    match keys {
                        Keys::Window => shown.is_due |= shown.content.press(key),
                        Keys::Program => handle(UserEvent::Key(key), sink),
                    }
                }
                SystemEvent::Monitors => {
                    shown.check(window, sink, handle)?;
                    shown.is_due = true;
                }
                SystemEvent::Expose => shown.is_due = true,
            }
        }
    }
    Ok(())
}

/// What is on the screen.
struct Shown<'a> {
    source: &'a str,
    content: Content,
    /// Where a picture was read into before, whose memory the next one takes.
    spare: Option<ScreenPicture>,
    /// The picture that was read last, as it was drawn.
    last_drawn: Option<Arc<Picture>>,
    last_error: Option<PictureError>,
    /// Pixels of the window's size, where picture and window differ.
    composed: Vec<u32>,
    screenshot: Option<PathBuf>,
    /// Sizes (of the picture, of the monitor) that a warning was logged for.
    warned_sizes: HashSet<((u32, u32), (u32, u32))>,
    is_due: bool,
}

impl<'a> Shown<'a> {
    fn new(options: &'a WindowOptions) -> Self {
        Self {
            source: &options.source,
            content: Content::new(options.stale_timeout, options.test_light.clone()),
            spare: None,
            last_drawn: None,
            last_error: None,
            composed: Vec::new(),
            screenshot: options.screenshot.clone(),
            warned_sizes: HashSet::new(),
            is_due: true,
        }
    }

    /// Checks the window's place.
    fn check(
        &mut self,
        window: &mut dyn SystemWindow,
        sink: &PictureSink,
        handle: &mut dyn FnMut(UserEvent<'_>, &PictureSink),
    ) -> Result<(), WindowError> {
        if window.check(Instant::now())? {
            handle(UserEvent::MonitorChanged(window.monitor()), sink);
            if let Some(size) = self.content.picture().map(ScreenPicture::size_px) {
                self.compare_sizes(size, window.monitor());
            }
        }
        Ok(())
    }

    /// Takes the newest picture, if there is a new one.
    fn take_picture(&mut self, sink: &PictureSink, monitor: &MonitorInfo, now: Instant) {
        let image = match sink.take() {
            None => return,
            Some(Handed::Nothing) => {
                self.is_due |= self.content.clear();
                self.last_drawn = None;
                return;
            }
            Some(Handed::Read(picture, permit)) => Image { picture, drawn: None, permit },
            Some(Handed::Drawn(LitPicture { picture: seen, drawn, permit })) => {
                if self.last_drawn.as_ref().is_some_and(|last| Arc::ptr_eq(last, &seen)) {
                    self.is_due |= self.content.repeat(&permit, now);
                    return;
                }
                let Some(picture) = self.read(&seen) else { return };
                // Kept, so that its memory cannot become another picture's.
                self.last_drawn = Some(seen);
                Image { picture, drawn, permit }
            }
        };
        let size = image.picture.size_px();
        let (old, is_changed) = self.content.take(image, now);
        self.spare = old.or(self.spare.take());
        self.is_due |= is_changed;
        self.compare_sizes(size, monitor);
    }

    fn read(&mut self, drawn: &Picture) -> Option<ScreenPicture> {
        let mut picture = self.spare.take().unwrap_or_default();
        match picture.read(&drawn.into()) {
            Ok(()) => {
                self.last_error = None;
                Some(picture)
            }
            Err(error) => {
                if self.last_error.as_ref() != Some(&error) {
                    log::error!("{}: {error}", self.source);
                    self.last_error = Some(error);
                }
                None
            }
        }
    }

    /// Logs a warning, once for each size, if picture and monitor differ in size.
    fn compare_sizes(&mut self, picture_px: (u32, u32), monitor: &MonitorInfo) {
        let sizes = (picture_px, monitor.size_px);
        if picture_px != monitor.size_px && self.warned_sizes.insert(sizes) {
            let (width, height) = picture_px;
            log::warn!(
                "THE PICTURE ON {} IS {width}x{height} PIXELS, THE MONITOR IS {monitor}: it is shown unscaled at the \
                 top left; set the CameraInfo (or the monitor's mode) so that both are the same",
                self.source,
            );
        }
    }

    /// Draws what is to be seen, as soon as the window system takes it.
    fn draw_if_due(&mut self, window: &mut dyn SystemWindow) -> Result<(), WindowError> {
        let size = window.size_px();
        if !self.is_due || size.0 == 0 || size.1 == 0 || !window.is_ready() {
            return Ok(());
        }
        self.is_due = false;
        let is_picture = matches!(self.content.face(), Face::Picture(_));
        let pixels = match self.content.face() {
            Face::Picture(picture) if picture.size_px() == size => picture.pixels(),
            face => {
                self.composed.resize(size.0 as usize * size.1 as usize, 0);
                compose(face, window.monitor(), &mut self.composed, size);
                &self.composed
            }
        };
        window.present(pixels)?;
        if is_picture && size == window.monitor().size_px {
            if let Some(path) = self.screenshot.take() {
                let (width_px, height_px) = size;
                let data = rgb_bytes(pixels);
                picture_file::write(&path, &Picture { width_px, height_px, encoding: Encoding::Rgb8, data })?;
                log::info!("saved what the window shows: {}", path.display());
            }
        }
        Ok(())
    }
}

/// Lays what is to be seen on pixels of the window's size.
fn compose(face: Face<'_>, monitor: &MonitorInfo, pixels: &mut [u32], (width_px, height_px): (u32, u32)) {
    match face {
        Face::Black => pixels.fill(0),
        Face::Picture(picture) => picture.draw_unscaled(pixels, width_px),
        Face::Test(test, mask) => match test_picture(test, monitor, [width_px, height_px]) {
            Ok(picture) => {
                picture.draw_unscaled(pixels, width_px);
                if let Some(mask) = mask {
                    dim(pixels, &mask.shares([width_px, height_px]).data);
                }
            }
            Err(_) => pixels.fill(0),
        },
    }
}

fn test_picture(test: TestPicture, monitor: &MonitorInfo, size_px: [u32; 2]) -> Result<ScreenPicture, PictureError> {
    ScreenPicture::from_picture(&test.draw(size_px, &monitor.name))
}
