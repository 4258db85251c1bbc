//! The projector's window: a picture full screen on a chosen monitor, pixel for pixel.
//!
//! [`run`] opens the window on the calling thread, which must be the main thread, and stays until the user presses
//! Escape or q, closes it, or the [`PictureSink`] is told to close it. Other threads hand pictures to the sink; only the
//! newest is kept, and the window is drawn when a new picture comes or the window system asks for it, so a picture
//! that stands still costs nothing.
//!
//! Nothing is ever scaled, because a projection fits the world only while picture pixel (u, v) is screen pixel (u, v):
//! all sizes here are physical pixels, whatever the desktop's scale factor. A picture of another size than the
//! monitor is shown at the top left on black, and warned about once for each size.
//!
//! On Wayland, and on X11 under a window manager that knows EWMH, the window system makes the window full screen. On
//! an X server without one the window covers the monitor by itself: it has exactly the monitor's place and size, and
//! is not offered to a manager (override-redirect).

use std::collections::HashSet;
use std::num::NonZeroU32;
use std::path::PathBuf;
use std::rc::Rc;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use softbuffer::SoftBufferError;
use winit::application::ApplicationHandler;
use winit::dpi::{PhysicalPosition, PhysicalSize};
use winit::error::EventLoopError;
use winit::event::{ElementState, KeyEvent, StartCause, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoop, EventLoopProxy, OwnedDisplayHandle};
use winit::keyboard::{Key, NamedKey};
use winit::monitor::MonitorHandle;
use winit::platform::x11::{ActiveEventLoopExtX11, WindowAttributesExtX11};
use winit::raw_window_handle::{HasWindowHandle, RawWindowHandle};
use winit::window::{Fullscreen, Window, WindowAttributes, WindowId};

use crate::png::{write_png, PngError, PngFormat};
use crate::window_monitor::{MonitorChoice, MonitorError, MonitorInfo};
use crate::window_picture::{rgb_bytes, ScreenPicture};
use crate::window_x11::X11Session;

/// How long the window system has to put the window in its place before a wrong place is warned about.
const SETTLE_TIME: Duration = Duration::from_millis(1500);
/// How often the window is looked at while it settles.
const SETTLE_STEP: Duration = Duration::from_millis(100);

/// What the window shows and where.
#[derive(Debug, Clone)]
pub struct WindowOptions {
    /// Where the pictures come from, for the window's title and for warnings: a topic.
    pub source: String,
    /// The monitor to cover.
    pub monitor: MonitorChoice,
    /// A PNG file that gets what the window shows once the first picture is on the screen.
    pub screenshot: Option<PathBuf>,
}

/// Why there is no window, or no longer one.
#[derive(Debug, thiserror::Error)]
pub enum WindowError {
    /// There is no window system, or it broke off.
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
        /// What the window system says.
        reason: String,
    },
    /// The pixels cannot be brought to the window.
    #[error("cannot draw on monitor {monitor}: {reason}")]
    Draw {
        /// The monitor.
        monitor: MonitorInfo,
        /// What the window system says.
        reason: String,
    },
    /// The screenshot cannot be written.
    #[error(transparent)]
    Screenshot(#[from] PngError),
}

/// What other threads tell the window.
#[derive(Debug, Clone, Copy)]
enum Wake {
    NewPicture,
    Close,
}

/// The end of the window that other threads hold: they give it pictures and close it.
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
/// `start` is called once, when the window stands, with the sink for pictures. It must not block: it starts threads.
///
/// # Errors
/// [`WindowError`] when there is no display, no such monitor, or the window system refuses the window.
pub fn run(options: WindowOptions, start: impl FnOnce(PictureSink)) -> Result<(), WindowError> {
    let event_loop = EventLoop::<Wake>::with_user_event().build().map_err(event_loop_error)?;
    let sink = PictureSink { newest: Arc::default(), proxy: event_loop.create_proxy() };
    let mut application = Application {
        display: event_loop.owned_display_handle(),
        screenshot: options.screenshot.clone(),
        options,
        start: Some(start),
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

/// winit begins its messages with the place in its sources, `os error at FILE:LINE: `, which helps no user.
fn without_place(message: &str) -> String {
    let rest = message.strip_prefix("os error at ").and_then(|rest| rest.split_once(": "));
    rest.map_or(message, |(_, reason)| reason).trim_end_matches('.').to_owned()
}

fn draw_error(monitor: &MonitorInfo, error: &SoftBufferError) -> WindowError {
    WindowError::Draw { monitor: monitor.clone(), reason: error.to_string() }
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

fn monitors(event_loop: &ActiveEventLoop) -> Vec<(MonitorInfo, MonitorHandle)> {
    let primary = event_loop.primary_monitor();
    event_loop
        .available_monitors()
        .map(|handle| {
            let position = handle.position();
            let size = handle.size();
            let info = MonitorInfo {
                name: handle.name().unwrap_or_default(),
                position_px: (position.x, position.y),
                size_px: (size.width, size.height),
                is_primary: primary.as_ref() == Some(&handle),
            };
            (info, handle)
        })
        .collect()
}

struct Application<F> {
    options: WindowOptions,
    display: OwnedDisplayHandle,
    start: Option<F>,
    sink: PictureSink,
    open: Option<OpenWindow>,
    picture: Option<ScreenPicture>,
    screenshot: Option<PathBuf>,
    /// Sizes (of the picture, of the monitor) whose difference was warned about.
    warned_sizes: HashSet<((u32, u32), (u32, u32))>,
    failure: Option<WindowError>,
}

/// The window with its surface and what is known of its place.
struct OpenWindow {
    surface: softbuffer::Surface<OwnedDisplayHandle, Rc<Window>>,
    window: Rc<Window>,
    monitor: MonitorInfo,
    x11: Option<X11Session>,
    placed_by_itself: bool,
    settle: Option<Settle>,
}

/// The time after opening in which the window comes to its place.
#[derive(Clone, Copy)]
struct Settle {
    next_look: Instant,
    deadline: Instant,
}

impl OpenWindow {
    fn open(
        event_loop: &ActiveEventLoop,
        display: OwnedDisplayHandle,
        options: &WindowOptions,
    ) -> Result<Self, WindowError> {
        let mut monitors = monitors(event_loop);
        let infos: Vec<MonitorInfo> = monitors.iter().map(|(info, _)| info.clone()).collect();
        let chosen = options.monitor.resolve(&infos)?;
        let (monitor, handle) = monitors.swap_remove(chosen);
        log::info!("{} on monitor {monitor}", options.source);

        let x11 = event_loop.is_x11().then(X11Session::open).flatten();
        let placed_by_itself = x11.as_ref().is_some_and(|x11| !x11.has_fullscreen_manager());
        let attributes = attributes(&options.source, &monitor, handle, placed_by_itself);
        let window = event_loop.create_window(attributes).map_err(|error| WindowError::Open {
            monitor: monitor.clone(),
            reason: without_place(&error.to_string()),
        })?;
        let window = Rc::new(window);
        window.set_cursor_visible(false);
        if let Some(x11) = &x11 {
            x11.keep_screen_awake();
        }
        let surface = softbuffer::Context::new(display)
            .and_then(|context| softbuffer::Surface::new(&context, Rc::clone(&window)))
            .map_err(|error| draw_error(&monitor, &error))?;
        let now = Instant::now();
        Ok(Self {
            surface,
            window,
            monitor,
            x11,
            placed_by_itself,
            settle: Some(Settle { next_look: now, deadline: now + SETTLE_TIME }),
        })
    }

    /// Draws the picture (black without one); gives the size of the surface and a copy of its pixels when `copy`.
    fn draw(&mut self, picture: Option<&ScreenPicture>, copy: bool) -> Result<Option<Shown>, WindowError> {
        let size = self.window.inner_size();
        let (Some(width), Some(height)) = (NonZeroU32::new(size.width), NonZeroU32::new(size.height)) else {
            return Ok(None);
        };
        let mut draw = || {
            self.surface.resize(width, height)?;
            let mut buffer = self.surface.buffer_mut()?;
            match picture {
                Some(picture) => picture.draw_unscaled(&mut buffer, size.width),
                None => buffer.fill(0),
            }
            let pixels = copy.then(|| buffer.to_vec());
            self.window.pre_present_notify();
            buffer.present()?;
            Ok(pixels)
        };
        let pixels = draw().map_err(|error: SoftBufferError| draw_error(&self.monitor, &error))?;
        Ok(pixels.map(|pixels| Shown { size_px: (size.width, size.height), pixels }))
    }

    /// Looks whether the window is where it should be and has the keyboard; warns when time is up and it is not.
    fn look(&mut self, now: Instant) -> ControlFlow {
        let Some(settle) = self.settle else {
            return ControlFlow::Wait;
        };
        if now < settle.next_look {
            return ControlFlow::WaitUntil(settle.next_look);
        }
        let has_keyboard = !self.placed_by_itself || self.take_keyboard();
        let place = self.place_px();
        let in_place =
            self.window_size_px() == self.monitor.size_px && place.is_none_or(|p| p == self.monitor.position_px);
        if now < settle.deadline {
            // The window may still be moved, so a good place is final only when time is up.
            let next_look = now + SETTLE_STEP;
            self.settle = Some(Settle { next_look, ..settle });
            return ControlFlow::WaitUntil(next_look);
        }
        self.settle = None;
        if !in_place {
            let (width, height) = self.window_size_px();
            let (x, y) = place.unwrap_or_default();
            log::warn!(
                "THE WINDOW DOES NOT COVER ITS MONITOR: it is {width}x{height}{x:+}{y:+}, the monitor {}; \
                 the projection will not fit",
                self.monitor
            );
        }
        if !has_keyboard {
            log::warn!("the window does not get the keyboard; end with Ctrl-C instead of Escape");
        }
        ControlFlow::Wait
    }

    fn window_size_px(&self) -> (u32, u32) {
        let size = self.window.inner_size();
        (size.width, size.height)
    }

    /// Where the window system says that the window is; Wayland does not say.
    fn place_px(&self) -> Option<(i32, i32)> {
        self.window.inner_position().ok().map(|place| (place.x, place.y))
    }

    fn take_keyboard(&self) -> bool {
        let (Some(x11), Ok(handle)) = (&self.x11, self.window.window_handle()) else {
            return true;
        };
        match handle.as_raw() {
            RawWindowHandle::Xlib(handle) => u32::try_from(handle.window).is_ok_and(|id| x11.focus(id)),
            RawWindowHandle::Xcb(handle) => x11.focus(handle.window.get()),
            _ => true,
        }
    }
}

/// What stands on the screen.
struct Shown {
    size_px: (u32, u32),
    pixels: Vec<u32>,
}

fn attributes(source: &str, monitor: &MonitorInfo, handle: MonitorHandle, placed_by_itself: bool) -> WindowAttributes {
    let (x, y) = monitor.position_px;
    let (width, height) = monitor.size_px;
    let attributes = Window::default_attributes()
        .with_title(source)
        .with_decorations(false)
        .with_position(PhysicalPosition::new(x, y))
        .with_inner_size(PhysicalSize::new(width, height));
    if placed_by_itself {
        attributes.with_override_redirect(true)
    } else {
        attributes.with_fullscreen(Some(Fullscreen::Borderless(Some(handle))))
    }
}

impl<F> Application<F> {
    fn draw(&mut self) -> Result<(), WindowError> {
        let Some(open) = &mut self.open else {
            return Ok(());
        };
        let wants_copy =
            self.screenshot.is_some() && self.picture.is_some() && open.window_size_px() == open.monitor.size_px;
        let shown = open.draw(self.picture.as_ref(), wants_copy)?;
        if let (Some(shown), Some(path)) = (shown, self.screenshot.take_if(|_| wants_copy)) {
            let (width, height) = shown.size_px;
            write_png(&path, width, height, PngFormat::Rgb8, &rgb_bytes(&shown.pixels))?;
            log::info!("saved what the window shows: {}", path.display());
        }
        Ok(())
    }

    /// Warns, once for each size, about a picture that is not as large as the monitor.
    fn compare_sizes(&mut self) {
        let (Some(open), Some(picture)) = (&self.open, &self.picture) else {
            return;
        };
        let (picture_size, monitor_size) = (picture.size_px(), open.monitor.size_px);
        if picture_size != monitor_size && self.warned_sizes.insert((picture_size, monitor_size)) {
            let (width, height) = picture_size;
            log::warn!(
                "THE PICTURE ON {} IS {width}x{height} PIXELS, THE MONITOR IS {}: it is shown unscaled at the top \
                 left; set the CameraInfo (or the monitor's mode) so that both are the same",
                self.options.source,
                open.monitor
            );
        }
    }

    /// Ends with an error, or goes on.
    fn settle_result(&mut self, event_loop: &ActiveEventLoop, result: Result<(), WindowError>) {
        if let Err(error) = result {
            self.failure = Some(error);
            event_loop.exit();
        }
    }
}

impl<F: FnOnce(PictureSink)> ApplicationHandler<Wake> for Application<F> {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        if self.open.is_some() {
            return;
        }
        match OpenWindow::open(event_loop, self.display.clone(), &self.options) {
            Ok(open) => {
                open.window.request_redraw();
                self.open = Some(open);
                if let Some(start) = self.start.take() {
                    start(self.sink.clone());
                }
            }
            Err(error) => self.settle_result(event_loop, Err(error)),
        }
    }

    fn new_events(&mut self, event_loop: &ActiveEventLoop, _: StartCause) {
        if let Some(open) = &mut self.open {
            event_loop.set_control_flow(open.look(Instant::now()));
        }
    }

    fn user_event(&mut self, event_loop: &ActiveEventLoop, wake: Wake) {
        match wake {
            Wake::Close => event_loop.exit(),
            Wake::NewPicture => {
                if let Some(picture) = self.sink.take() {
                    self.picture = Some(picture);
                    self.compare_sizes();
                    if let Some(open) = &self.open {
                        open.window.request_redraw();
                    }
                }
            }
        }
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        match event {
            WindowEvent::CloseRequested | WindowEvent::Destroyed => event_loop.exit(),
            WindowEvent::KeyboardInput {
                event: KeyEvent { logical_key, state: ElementState::Pressed, .. }, ..
            } if is_quit_key(&logical_key) => event_loop.exit(),
            WindowEvent::Resized(_) | WindowEvent::ScaleFactorChanged { .. } => {
                // A monitor whose mode changes resizes its full-screen window: look at both anew.
                if let Some(open) = &mut self.open {
                    let place = open.monitor.position_px;
                    let name = open.monitor.name.clone();
                    let found = monitors(event_loop)
                        .into_iter()
                        .map(|(info, _)| info)
                        .find(|info| info.name == name && info.position_px == place);
                    if let Some(monitor) = found {
                        open.monitor = monitor;
                    }
                    open.window.request_redraw();
                }
                self.compare_sizes();
            }
            WindowEvent::RedrawRequested => {
                let result = self.draw();
                self.settle_result(event_loop, result);
            }
            _ => {}
        }
    }
}

fn is_quit_key(key: &Key) -> bool {
    match key {
        Key::Named(NamedKey::Escape) => true,
        Key::Character(text) => text.eq_ignore_ascii_case("q"),
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_lose_the_place_in_the_librarys_sources() {
        assert_eq!(without_place("os error at /x/y.rs:7: DISPLAY: not set."), "DISPLAY: not set");
        assert_eq!(without_place("something else: bad"), "something else: bad");
    }

    #[test]
    fn escape_and_q_quit_and_nothing_else() {
        assert!(is_quit_key(&Key::Named(NamedKey::Escape)));
        assert!(is_quit_key(&Key::Character("q".into())));
        assert!(is_quit_key(&Key::Character("Q".into())));
        assert!(!is_quit_key(&Key::Character("w".into())));
        assert!(!is_quit_key(&Key::Named(NamedKey::Enter)));
    }
}
