//! The event loop of a window on any window system: waits for events, and draws the content.

use std::collections::HashSet;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use rcs_files::image_file;
use rcs_light::Lit;
use rcs_scene::{Encoding, Image};

use crate::content::WindowContent;
use crate::dead_man::{DeadManSwitch, WindowRole};
use crate::error::WindowError;
use crate::keys::{is_quit_key, WindowKey};
use crate::monitor::MonitorInfo;
use crate::on_screen::OnScreen;
use crate::screen_image::{rgb_bytes, ImageError, ScreenImage};
use crate::sink::{ImageSink, SunkImage};
use crate::system_window::{SystemEvent, SystemWindow, WindowOptions};

/// An event for the program.
#[derive(Debug, Clone, Copy)]
pub enum UserEvent<'a> {
    /// The window is open on this monitor: the first event.
    Opened(&'a MonitorInfo),
    /// The monitor's position or size changed.
    MonitorChanged(&'a MonitorInfo),
    /// The user pressed a key other than Escape and q, or holds it down.
    Key {
        /// The key.
        key: WindowKey,
        /// `true` if it is held down: whoever toggles something waits for the next press.
        is_repeat: bool,
    },
}

/// Runs an open window until it is closed.
pub(crate) fn run(
    window: &mut dyn SystemWindow,
    options: &WindowOptions,
    (sink, switch): (&ImageSink, &mut DeadManSwitch),
    handle: &mut dyn FnMut(UserEvent<'_>, &ImageSink),
) -> Result<(), WindowError> {
    switch.report();
    handle(UserEvent::Opened(window.monitor()), sink);
    let mut painter = WindowPainter::new(options);
    while !sink.is_closing() {
        let now = Instant::now();
        if now >= window.next_check() {
            painter.check(window, sink, handle)?;
            // A busy display server may have lost pixels.
            painter.is_due = true;
        }
        if switch.restart_if_back(window.is_there(), options, sink) {
            window.come_to_front()?;
            painter.is_due = true;
        }
        painter.take_image(sink, window.monitor());
        if let Some(grant) = sink.take_renewed() {
            painter.content.renew(&grant);
        }
        painter.is_due |= painter.content.check(Instant::now());
        painter.draw_if_due(window)?;
        let until = painter.content.next_check().map_or(window.next_check(), |at| at.min(window.next_check()));
        let until = switch.beat(Instant::now()).map_or(until, |at| at.min(until));
        let events = window.wait(sink.wake_fd(), until)?;
        sink.clear_wake();
        sink.set_refresh(window.refresh());
        for event in events {
            match event {
                SystemEvent::Close if options.role.takes_keyboard() => return Ok(()),
                SystemEvent::Key { keysym, .. } if is_quit_key(keysym) && options.role.takes_keyboard() => {
                    return Ok(())
                }
                SystemEvent::Key { keysym, is_repeat } => {
                    let Some(key) = WindowKey::from_keysym(keysym) else { continue };
                    handle(UserEvent::Key { key, is_repeat }, sink);
                }
                SystemEvent::Monitors => {
                    painter.check(window, sink, handle)?;
                    painter.is_due = true;
                }
                SystemEvent::Expose | SystemEvent::Close => painter.is_due = true,
            }
        }
    }
    Ok(())
}

/// Draws the content of a window.
struct WindowPainter<'a> {
    source: &'a str,
    content: WindowContent,
    /// Size of the newest image.
    shown_px: Option<(u32, u32)>,
    /// Scratch buffer for the next image.
    scratch: Option<ScreenImage>,
    /// The image that was converted last. Holding it keeps its address from being reused.
    last_drawn: Option<Lit<Arc<Image>>>,
    last_error: Option<ImageError>,
    /// Pixels of the window's size, for content of another size.
    composed: Vec<u32>,
    screenshot: Option<PathBuf>,
    /// Sizes of image and monitor for which a warning was logged.
    warned_sizes: HashSet<((u32, u32), (u32, u32))>,
    is_due: bool,
    /// Hears when the newest image is on the screen.
    on_screen: Option<Arc<dyn OnScreen>>,
    role: WindowRole,
}

impl<'a> WindowPainter<'a> {
    fn new(options: &'a WindowOptions) -> Self {
        Self {
            source: &options.source,
            content: WindowContent::default(),
            shown_px: None,
            scratch: None,
            last_drawn: None,
            last_error: None,
            composed: Vec::new(),
            screenshot: options.screenshot.clone(),
            warned_sizes: HashSet::new(),
            is_due: true,
            on_screen: None,
            role: options.role.clone(),
        }
    }

    /// Checks that the window covers its monitor.
    fn check(
        &mut self,
        window: &mut dyn SystemWindow,
        sink: &ImageSink,
        handle: &mut dyn FnMut(UserEvent<'_>, &ImageSink),
    ) -> Result<(), WindowError> {
        if window.check(Instant::now())? {
            handle(UserEvent::MonitorChanged(window.monitor()), sink);
            if let Some(size) = self.shown_px {
                self.compare_sizes(size, window.monitor());
            }
        }
        Ok(())
    }

    /// Takes the newest image from the sink, if there is a new one.
    fn take_image(&mut self, sink: &ImageSink, monitor: &MonitorInfo) {
        let image = match sink.take() {
            None => return,
            Some(SunkImage::Nothing) => {
                self.content.clear();
                (self.last_drawn, self.on_screen, self.is_due) = (None, None, true);
                return;
            }
            Some(SunkImage::Read(image)) => image,
            Some(SunkImage::Drawn(source, on_screen)) => {
                let is_same = self.last_drawn.as_ref().is_some_and(|last| last.is_same(&source));
                // Also while it is not shown: what hears of it is told when the window has what it shows then.
                self.is_due |= on_screen.is_some();
                self.on_screen = on_screen.or(self.on_screen.take().filter(|_| is_same));
                if is_same && self.content.renew(source.grant()) {
                    return;
                }
                let Ok(image) = source.convert(|image| self.read(image).map(Arc::new).ok_or(())) else { return };
                self.last_drawn = Some(source);
                image
            }
        };
        self.shown_px = image.content(Instant::now()).map(|image| image.size_px()).or(self.shown_px);
        let old = self.content.take(image);
        self.scratch = old.or(self.scratch.take());
        self.is_due = true;
        self.shown_px.into_iter().for_each(|size| self.compare_sizes(size, monitor));
    }

    fn read(&mut self, drawn: &Image) -> Option<ScreenImage> {
        let mut image = self.scratch.take().unwrap_or_default();
        match image.read(&drawn.into()) {
            Ok(()) => {
                self.last_error = None;
                Some(image)
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

    /// Logs a warning, once for each size, if image and monitor differ in size.
    fn compare_sizes(&mut self, image_px: (u32, u32), monitor: &MonitorInfo) {
        let sizes = (image_px, monitor.size_px);
        if image_px != monitor.size_px && self.warned_sizes.insert(sizes) {
            let (width, height) = image_px;
            log::warn!(
                "THE PICTURE ON {} IS {width}x{height} PIXELS, THE MONITOR IS {monitor}: it is shown unscaled at the \
                 top left; set the CameraInfo (or the monitor's mode) so that both are the same",
                self.source,
            );
        }
    }

    /// Draws the content if that is due and the window system is ready.
    fn draw_if_due(&mut self, window: &mut dyn SystemWindow) -> Result<(), WindowError> {
        let size = window.size_px();
        if !self.is_due || size.0 == 0 || size.1 == 0 || !window.is_ready() {
            return Ok(());
        }
        self.is_due = false;
        let image = self.content.on_screen(Instant::now());
        let is_image = image.is_some();
        let pixels = match image {
            Some(image) if image.size_px() == size => image.pixels(),
            image => {
                self.composed.resize(size.0 as usize * size.1 as usize, 0);
                match image {
                    Some(image) => image.draw_unscaled(&mut self.composed, size.0),
                    None => self.composed.fill(0),
                }
                &self.composed
            }
        };
        window.present(pixels, self.on_screen.take().or_else(|| self.role.listener()))?;
        if is_image && size == window.monitor().size_px {
            if let Some(path) = self.screenshot.take() {
                let (width_px, height_px) = size;
                let data = rgb_bytes(pixels);
                image_file::write(&path, &Image { width_px, height_px, encoding: Encoding::Rgb8, data })?;
                log::info!("saved the window's pixels: {}", path.display());
            }
        }
        Ok(())
    }
}
