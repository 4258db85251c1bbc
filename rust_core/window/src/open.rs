//! The open window: its surface, its monitor and its keyboard.
//!
//! On Wayland, and on X11 under a window manager that knows EWMH, the window system makes the window full screen. On
//! an X server without one the window covers the monitor by itself: it has exactly the monitor's place and size, and
//! is not offered to a manager (override-redirect); so it does on a monitor that window managers do not know: a virtual
//! one, or one of Xinerama's heads. In all cases the window is watched, and put on its monitor again
//! when that changed its mode or came back.

use std::num::NonZeroU32;
use std::rc::Rc;
use std::time::Instant;

use softbuffer::SoftBufferError;
use winit::dpi::{PhysicalPosition, PhysicalSize};
use winit::event_loop::{ActiveEventLoop, OwnedDisplayHandle};
use winit::monitor::MonitorHandle;
use winit::platform::x11::{ActiveEventLoopExtX11, WindowAttributesExtX11};
use winit::raw_window_handle::{HasWindowHandle, RawWindowHandle};
use winit::window::{Fullscreen, Window, WindowAttributes};

use crate::coverage::{CoverageStep, CoverageWatch};
use crate::monitor::MonitorInfo;
use crate::screen_picture::ScreenPicture;
use crate::x11::X11Session;
use crate::{without_place, WindowError, WindowOptions};

/// All monitors, in the order in which they are counted. On X11, those that winit does not know are among them.
pub(crate) fn monitors(event_loop: &ActiveEventLoop) -> Vec<(MonitorInfo, Option<MonitorHandle>)> {
    let x11 = event_loop.is_x11().then(X11Session::open).flatten();
    all_monitors(event_loop, x11.as_ref())
}

fn all_monitors(event_loop: &ActiveEventLoop, x11: Option<&X11Session>) -> Vec<(MonitorInfo, Option<MonitorHandle>)> {
    let known = winit_monitors(event_loop);
    let all = x11.map(X11Session::monitors).unwrap_or_default();
    if all.is_empty() {
        return known.into_iter().map(|(info, handle)| (info, Some(handle))).collect();
    }
    let handle_of = |info: &MonitorInfo| {
        let same = |(known, _): &&(MonitorInfo, MonitorHandle)| known.name == info.name && !info.is_virtual;
        known.iter().find(same).map(|(_, handle)| handle.clone())
    };
    all.into_iter().map(|info| (info.clone(), handle_of(&info))).collect()
}

/// The monitors that winit knows.
fn winit_monitors(event_loop: &ActiveEventLoop) -> Vec<(MonitorInfo, MonitorHandle)> {
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
                is_virtual: false,
            };
            (info, handle)
        })
        .collect()
}

/// The window with its surface and what is known of its place.
pub(crate) struct OpenWindow {
    surface: softbuffer::Surface<OwnedDisplayHandle, Rc<Window>>,
    window: Rc<Window>,
    monitor: MonitorInfo,
    x11: Option<X11Session>,
    /// Whether no window manager puts it in its place.
    placed_by_itself: bool,
    has_keyboard: bool,
    is_monitor_gone: bool,
    coverage: CoverageWatch,
}

/// The pixels on the screen.
pub(crate) struct Shown {
    /// Columns and rows.
    pub(crate) size_px: (u32, u32),
    /// `0x00RRGGBB`, rows from the top.
    pub(crate) pixels: Vec<u32>,
}

impl OpenWindow {
    /// Opens the window on the monitor that the options choose.
    pub(crate) fn open(
        event_loop: &ActiveEventLoop,
        display: OwnedDisplayHandle,
        options: &WindowOptions,
    ) -> Result<Self, WindowError> {
        let x11 = event_loop.is_x11().then(X11Session::open).flatten();
        let mut monitors = all_monitors(event_loop, x11.as_ref());
        let infos: Vec<MonitorInfo> = monitors.iter().map(|(info, _)| info.clone()).collect();
        let chosen = options.monitor.resolve(&infos)?;
        let (monitor, handle) = monitors.swap_remove(chosen);
        log::info!("{} on monitor {monitor}", options.source);

        let is_unknown_to_managers = x11.is_some() && handle.is_none();
        let placed_by_itself = is_unknown_to_managers || x11.as_ref().is_some_and(|x11| !x11.has_fullscreen_manager());
        let attributes = attributes(&options.source, &monitor, handle, placed_by_itself);
        let window = event_loop.create_window(attributes).map_err(|error| WindowError::Open {
            monitor: monitor.clone(),
            reason: without_place(&error.to_string()),
        })?;
        let window = Rc::new(window);
        window.set_cursor_visible(false);
        if x11.as_ref().is_some_and(|x11| !x11.keep_screen_awake()) {
            log::info!("the X server has no screen saver extension; its power saving stays as it is");
        }
        let surface = softbuffer::Context::new(display)
            .and_then(|context| softbuffer::Surface::new(&context, Rc::clone(&window)))
            .map_err(|error| draw_error(&monitor, &error))?;
        window.request_redraw();
        let coverage = CoverageWatch::new(Instant::now());
        let has_keyboard = !placed_by_itself;
        let is_monitor_gone = false;
        Ok(Self { surface, window, monitor, x11, placed_by_itself, has_keyboard, is_monitor_gone, coverage })
    }

    /// The monitor as it was polled last.
    pub(crate) fn monitor(&self) -> &MonitorInfo {
        &self.monitor
    }

    /// Whether the window is as large as its monitor.
    pub(crate) fn has_monitors_size(&self) -> bool {
        self.size_px() == self.monitor.size_px
    }

    /// Requests a redraw from the window system.
    pub(crate) fn request_redraw(&self) {
        self.window.request_redraw();
    }

    /// Draws the picture (black without one); returns a copy of what is shown if `copy` is set.
    pub(crate) fn draw(&mut self, picture: Option<&ScreenPicture>, copy: bool) -> Result<Option<Shown>, WindowError> {
        let size_px = self.size_px();
        let (Some(width), Some(height)) = (NonZeroU32::new(size_px.0), NonZeroU32::new(size_px.1)) else {
            return Ok(None);
        };
        let mut draw = || {
            self.surface.resize(width, height)?;
            let mut buffer = self.surface.buffer_mut()?;
            match picture {
                Some(picture) => picture.draw_unscaled(&mut buffer, size_px.0),
                None => buffer.fill(0),
            }
            let pixels = copy.then(|| buffer.to_vec());
            self.window.pre_present_notify();
            buffer.present()?;
            Ok(pixels)
        };
        let pixels = draw().map_err(|error: SoftBufferError| draw_error(&self.monitor, &error))?;
        Ok(pixels.map(|pixels| Shown { size_px, pixels }))
    }

    /// When [`poll`](Self::poll) is to be called again.
    pub(crate) fn next_poll(&self) -> Instant {
        self.coverage.next_poll()
    }

    /// Checks whether the window covers its monitor and has the keyboard, and puts right what is not.
    /// Returns whether the monitor's position or size changed since the last poll.
    pub(crate) fn poll(&mut self, event_loop: &ActiveEventLoop, now: Instant) -> bool {
        let mut all = all_monitors(event_loop, self.x11.as_ref()).into_iter();
        let (found, handle) = all.find(|(info, _)| info.name == self.monitor.name).unzip();
        let geometry = found.map(|info: MonitorInfo| (info.position_px, info.size_px));
        let was_gone = std::mem::replace(&mut self.is_monitor_gone, geometry.is_none());
        let last_geometry = (self.monitor.position_px, self.monitor.size_px);
        let is_changed = geometry.is_some_and(|geometry| geometry != last_geometry);
        if let Some(geometry) = geometry {
            (self.monitor.position_px, self.monitor.size_px) = geometry;
        }
        if was_gone && !self.is_monitor_gone {
            log::info!("monitor {} is back", self.monitor);
        } else if is_changed {
            log::info!("the monitor is now {}", self.monitor);
        }
        self.has_keyboard = self.has_keyboard || self.take_keyboard();
        let was_settling = self.coverage.is_settling(now);
        match self.coverage.poll(now, geometry.is_some(), self.is_in_place()) {
            CoverageStep::Nothing => {}
            CoverageStep::CoverAgain => {
                self.cover_again(handle.flatten());
            }
            CoverageStep::WarnMisplaced => {
                let (width, height) = self.size_px();
                let (x, y) = self.place_px().unwrap_or_default();
                log::warn!(
                    "THE WINDOW DOES NOT COVER ITS MONITOR: it is {width}x{height}{x:+}{y:+}, the monitor {}; the \
                     projection does not fit",
                    self.monitor
                );
            }
            CoverageStep::WarnMonitorGone => log::warn!("monitor {} is gone; waiting for it", self.monitor),
        }
        if was_settling && !self.coverage.is_settling(self.coverage.next_poll()) && !self.has_keyboard {
            log::warn!("the window does not get the keyboard; end with Ctrl-C instead of Escape");
        }
        is_changed
    }

    fn cover_again(&self, handle: Option<MonitorHandle>) {
        if self.is_withdrawn() {
            // A window manager that just starts can take a new window down again.
            self.window.set_visible(false);
            self.window.set_visible(true);
        }
        if self.placed_by_itself {
            let ((x, y), (width, height)) = (self.monitor.position_px, self.monitor.size_px);
            self.window.set_outer_position(PhysicalPosition::new(x, y));
            // The answer is an event of its own.
            let _ = self.window.request_inner_size(PhysicalSize::new(width, height));
        } else {
            // A window that is full screen already would be left where it is.
            self.window.set_fullscreen(None);
            self.window.set_fullscreen(Some(Fullscreen::Borderless(handle)));
        }
        self.window.request_redraw();
    }

    fn is_in_place(&self) -> bool {
        !self.is_withdrawn()
            && self.has_monitors_size()
            && self.place_px().is_none_or(|place| place == self.monitor.position_px)
    }

    fn size_px(&self) -> (u32, u32) {
        let size = self.window.inner_size();
        (size.width, size.height)
    }

    /// The window's position as the window system reports it; Wayland does not.
    fn place_px(&self) -> Option<(i32, i32)> {
        self.window.inner_position().ok().map(|place| (place.x, place.y))
    }

    /// Whether the X server has the window neither on the screen nor iconified; other window systems do not report it.
    fn is_withdrawn(&self) -> bool {
        match (&self.x11, self.x11_id()) {
            (Some(x11), Some(id)) => x11.is_withdrawn(id),
            _ => false,
        }
    }

    /// Takes the keyboard, which without a window manager no one else gives to the window.
    fn take_keyboard(&self) -> bool {
        match (&self.x11, self.x11_id()) {
            (Some(x11), Some(id)) => x11.focus(id),
            _ => true,
        }
    }

    fn x11_id(&self) -> Option<u32> {
        match self.window.window_handle().ok()?.as_raw() {
            RawWindowHandle::Xlib(handle) => u32::try_from(handle.window).ok(),
            RawWindowHandle::Xcb(handle) => Some(handle.window.get()),
            _ => None,
        }
    }
}

fn draw_error(monitor: &MonitorInfo, error: &SoftBufferError) -> WindowError {
    WindowError::Draw { monitor: monitor.clone(), reason: error.to_string() }
}

fn attributes(
    source: &str,
    monitor: &MonitorInfo,
    handle: Option<MonitorHandle>,
    placed_by_itself: bool,
) -> WindowAttributes {
    let ((x, y), (width, height)) = (monitor.position_px, monitor.size_px);
    let attributes = Window::default_attributes()
        .with_title(source)
        .with_decorations(false)
        .with_position(PhysicalPosition::new(x, y))
        .with_inner_size(PhysicalSize::new(width, height));
    if placed_by_itself {
        attributes.with_override_redirect(true)
    } else {
        attributes.with_fullscreen(Some(Fullscreen::Borderless(handle)))
    }
}
