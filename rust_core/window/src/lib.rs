//! The projector's window: a picture full screen on a chosen monitor, pixel for pixel.
//!
//! [`run`] opens the window on the calling thread, which must be the main thread, and stays until the user presses
//! Escape or q, closes it, or [`PictureSink::close`] is called. Other threads hand pictures to the sink; only the
//! newest is kept, and the window is drawn when a new picture arrives or the window system requests it, so an unchanged
//! picture costs nothing. [`run_interactive`] also reports keys and the monitor, for programs that draw to its size.
//!
//! Nothing is ever scaled, because a projection fits the world only while picture pixel (u, v) is screen pixel (u, v):
//! all sizes here are physical pixels, whatever the desktop's scale factor. If picture and monitor
//! differ in size, the picture is shown at the top left on black, and a warning is printed once for each size.

#![forbid(unsafe_code)]

mod coverage;
mod keys;
mod monitor;
mod open;
mod screen_picture;
pub mod test_pictures;
mod x11;

pub use keys::WindowKey;
pub use monitor::{list as list_lines, MonitorChoice, MonitorError, MonitorInfo};
pub use screen_picture::{PictureError, ReceivedPicture, ScreenPicture};

use std::collections::HashSet;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use winit::application::ApplicationHandler;
use winit::error::EventLoopError;
use winit::event::{ElementState, KeyEvent, StartCause, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoop, EventLoopProxy, OwnedDisplayHandle};
use winit::window::WindowId;

use crate::keys::is_quit_key;
use crate::open::{monitors, OpenWindow};
use crate::screen_picture::rgb_bytes;
use rcs_files::picture_file::{self, PictureFileError};
use rcs_scene::{Encoding, Picture};

/// What the window shows and where.
#[derive(Debug, Clone)]
pub struct WindowOptions {
    /// The topic of the pictures, for the window's title and for warnings.
    pub source: String,
    /// The monitor to cover.
    pub monitor: MonitorChoice,
    /// A PNG or JPEG file to save the window's pixels to, once the first picture is on the screen.
    pub screenshot: Option<PathBuf>,
}

/// Why the window could not be opened, or had to be closed.
#[derive(Debug, thiserror::Error)]
pub enum WindowError {
    /// There is no window system, or the connection to it broke.
    #[error("no window: {0} (DISPLAY or WAYLAND_DISPLAY must name a running display)")]
    EventLoop(String),
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
    /// The pixels cannot be brought to the window.
    #[error("cannot draw on monitor {monitor}: {reason}")]
    Draw {
        /// The monitor.
        monitor: MonitorInfo,
        /// The window system's error.
        reason: String,
    },
    /// The screenshot cannot be written.
    #[error(transparent)]
    Screenshot(#[from] PictureFileError),
}

/// What other threads ask of the window.
#[derive(Debug, Clone, Copy)]
enum Wake {
    NewPicture,
    Close,
}

/// The window's handle for other threads, which show pictures with it and close the window.
#[derive(Debug, Clone)]
pub struct PictureSink {
    newest: Arc<Mutex<Option<ScreenPicture>>>,
    proxy: EventLoopProxy<Wake>,
}

impl PictureSink {
    /// Shows a picture, in place of one that was not drawn yet.
    pub fn show(&self, picture: ScreenPicture) {
        let replaced = self.lock().replace(picture);
        // One wake-up is enough for any number of pictures; an error means that the window is closed already.
        if replaced.is_none() {
            let _ = self.proxy.send_event(Wake::NewPicture);
        }
    }

    /// Closes the window; [`run`] returns.
    pub fn close(&self) {
        let _ = self.proxy.send_event(Wake::Close);
    }

    fn take(&self) -> Option<ScreenPicture> {
        self.lock().take()
    }

    fn lock(&self) -> MutexGuard<'_, Option<ScreenPicture>> {
        self.newest.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Opens the window and shows pictures until it is closed.
///
/// `start` is called once, when the window is open, with the sink for pictures. It must not block: it starts threads.
///
/// # Errors
/// [`WindowError`] when there is no display, no such monitor, or the window system refuses the window.
pub fn run(options: WindowOptions, start: impl FnOnce(PictureSink)) -> Result<(), WindowError> {
    let mut start = Some(start);
    run_interactive(options, |_, sink| {
        // The first event is that it is open.
        if let Some(start) = start.take() {
            start(sink.clone());
        }
    })
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

/// Opens the window and shows pictures until it is closed, as [`run`]. `handle` is called on this thread for each event
/// and may show pictures at once; it must not block.
///
/// # Errors
/// [`WindowError`] when there is no display, no such monitor, or the window system refuses the window.
pub fn run_interactive(
    options: WindowOptions,
    handle: impl FnMut(UserEvent<'_>, &PictureSink),
) -> Result<(), WindowError> {
    let event_loop = EventLoop::<Wake>::with_user_event().build().map_err(event_loop_error)?;
    let sink = PictureSink { newest: Arc::default(), proxy: event_loop.create_proxy() };
    let mut application = Application {
        display: event_loop.owned_display_handle(),
        screenshot: options.screenshot.clone(),
        options,
        handle,
        sink,
        open: None,
        picture: None,
        warned_sizes: HashSet::new(),
        failure: None,
    };
    event_loop.run_app(&mut application).map_err(event_loop_error)?;
    application.failure.map_or(Ok(()), Err)
}

#[expect(clippy::needless_pass_by_value, reason = "for map_err")]
fn event_loop_error(error: EventLoopError) -> WindowError {
    WindowError::EventLoop(without_place(&error.to_string()))
}

/// winit begins its messages with a place in its source code, `os error at FILE:LINE: `, which helps no user.
pub(crate) fn without_place(message: &str) -> String {
    let rest = message.strip_prefix("os error at ").and_then(|rest| rest.split_once(": "));
    rest.map_or(message, |(_, reason)| reason).trim_end_matches('.').to_owned()
}

/// All monitors, in the order in which [`MonitorChoice`] counts them.
///
/// # Errors
/// [`WindowError::EventLoop`] when there is no display.
pub fn list_monitors() -> Result<Vec<MonitorInfo>, WindowError> {
    struct Lister(Vec<MonitorInfo>);
    impl ApplicationHandler<Wake> for Lister {
        fn resumed(&mut self, event_loop: &ActiveEventLoop) {
            self.0 = monitors(event_loop).into_iter().map(|(info, _)| info).collect();
            event_loop.exit();
        }
        fn window_event(&mut self, _: &ActiveEventLoop, _: WindowId, _: WindowEvent) {}
    }
    let mut lister = Lister(Vec::new());
    let event_loop = EventLoop::<Wake>::with_user_event().build().map_err(event_loop_error)?;
    event_loop.run_app(&mut lister).map_err(event_loop_error)?;
    Ok(lister.0)
}

struct Application<F> {
    options: WindowOptions,
    display: OwnedDisplayHandle,
    handle: F,
    sink: PictureSink,
    open: Option<OpenWindow>,
    picture: Option<ScreenPicture>,
    screenshot: Option<PathBuf>,
    /// Sizes (of the picture, of the monitor) that a warning was printed for.
    warned_sizes: HashSet<((u32, u32), (u32, u32))>,
    failure: Option<WindowError>,
}

impl<F> Application<F> {
    fn draw(&mut self) -> Result<(), WindowError> {
        let Some(open) = &mut self.open else {
            return Ok(());
        };
        let wants_copy = self.screenshot.is_some() && self.picture.is_some() && open.has_monitors_size();
        let shown = open.draw(self.picture.as_ref(), wants_copy)?;
        if let (Some(shown), Some(path)) = (shown, self.screenshot.take_if(|_| wants_copy)) {
            let (width_px, height_px) = shown.size_px;
            let data = rgb_bytes(&shown.pixels);
            picture_file::write(&path, &Picture { width_px, height_px, encoding: Encoding::Rgb8, data })?;
            log::info!("saved what the window shows: {}", path.display());
        }
        Ok(())
    }

    /// Takes the newest picture, if there is a new one, and requests a redraw.
    fn take_picture(&mut self) {
        if let Some(picture) = self.sink.take() {
            self.picture = Some(picture);
            self.compare_sizes();
        }
        if let Some(open) = &self.open {
            open.request_redraw();
        }
    }

    /// Prints a warning, once for each size, if picture and monitor differ in size.
    fn compare_sizes(&mut self) {
        let (Some(open), Some(picture)) = (&self.open, &self.picture) else {
            return;
        };
        let (picture_size, monitor_size) = (picture.size_px(), open.monitor().size_px);
        if picture_size != monitor_size && self.warned_sizes.insert((picture_size, monitor_size)) {
            let (width, height) = picture_size;
            log::warn!(
                "THE PICTURE ON {} IS {width}x{height} PIXELS, THE MONITOR IS {}: it is shown unscaled at the top \
                 left; set the CameraInfo (or the monitor's mode) so that both are the same",
                self.options.source,
                open.monitor()
            );
        }
    }

    /// Ends with an error, or goes on.
    fn end_on_error(&mut self, event_loop: &ActiveEventLoop, result: Result<(), WindowError>) {
        if let Err(error) = result {
            self.failure = Some(error);
            event_loop.exit();
        }
    }
}

impl<F: FnMut(UserEvent<'_>, &PictureSink)> ApplicationHandler<Wake> for Application<F> {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        if self.open.is_some() {
            return;
        }
        match OpenWindow::open(event_loop, self.display.clone(), &self.options) {
            Ok(open) => {
                let open = self.open.insert(open);
                // Whatever becomes of the window: a manager that just starts can miss it, and then no event comes.
                event_loop.set_control_flow(ControlFlow::WaitUntil(open.next_poll()));
                (self.handle)(UserEvent::Opened(open.monitor()), &self.sink);
            }
            Err(error) => self.end_on_error(event_loop, Err(error)),
        }
    }

    fn new_events(&mut self, event_loop: &ActiveEventLoop, _: StartCause) {
        let Some(open) = &mut self.open else {
            return;
        };
        let now = Instant::now();
        let is_due = now >= open.next_poll();
        if is_due && open.poll(event_loop, now) {
            (self.handle)(UserEvent::MonitorChanged(open.monitor()), &self.sink);
            self.compare_sizes();
        }
        if is_due {
            // Makes up for what a busy display server lost: an exposure, a wake-up.
            self.take_picture();
        }
        if let Some(open) = &self.open {
            event_loop.set_control_flow(ControlFlow::WaitUntil(open.next_poll()));
        }
    }

    fn user_event(&mut self, event_loop: &ActiveEventLoop, wake: Wake) {
        match wake {
            Wake::Close => event_loop.exit(),
            Wake::NewPicture => self.take_picture(),
        }
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        match event {
            WindowEvent::CloseRequested | WindowEvent::Destroyed => event_loop.exit(),
            WindowEvent::KeyboardInput {
                event: KeyEvent { logical_key, state: ElementState::Pressed, .. }, ..
            } => {
                if is_quit_key(&logical_key) {
                    event_loop.exit();
                } else if let Some(key) = WindowKey::from_winit(&logical_key) {
                    (self.handle)(UserEvent::Key(key), &self.sink);
                }
            }
            WindowEvent::Resized(_) | WindowEvent::ScaleFactorChanged { .. } => {
                if let Some(open) = &self.open {
                    open.request_redraw();
                }
            }
            WindowEvent::RedrawRequested => {
                let result = self.draw();
                self.end_on_error(event_loop, result);
            }
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_lose_the_place_in_winits_source_code() {
        assert_eq!(without_place("os error at /x/y.rs:7: DISPLAY: not set."), "DISPLAY: not set");
        assert_eq!(without_place("something else: bad"), "something else: bad");
    }
}
