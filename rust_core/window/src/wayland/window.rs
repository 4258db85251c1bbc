//! The open window on a Wayland compositor.

use std::os::fd::BorrowedFd;
use std::sync::Arc;
use std::time::Instant;

use rustix::event::{PollFd, PollFlags};
use wayland_client::protocol::wl_buffer::WlBuffer;
use wayland_client::protocol::wl_compositor::WlCompositor;
use wayland_client::protocol::wl_shm::{Format, WlShm};
use wayland_client::protocol::wl_surface::WlSurface;
use wayland_protocols::wp::idle_inhibit::zv1::client::zwp_idle_inhibit_manager_v1::ZwpIdleInhibitManagerV1;
use wayland_protocols::wp::idle_inhibit::zv1::client::zwp_idle_inhibitor_v1::ZwpIdleInhibitorV1;
use wayland_protocols::wp::presentation_time::client::wp_presentation::WpPresentation;
use wayland_protocols::wp::viewporter::client::wp_viewport::WpViewport;
use wayland_protocols::wp::viewporter::client::wp_viewporter::WpViewporter;
use wayland_protocols::xdg::shell::client::xdg_surface::XdgSurface;
use wayland_protocols::xdg::shell::client::xdg_toplevel::XdgToplevel;
use wayland_protocols::xdg::shell::client::xdg_wm_base::XdgWmBase;

use super::state::{lost, lost_connection, CompositorState, WaylandSession};
use crate::error::WindowError;
use crate::monitor::MonitorInfo;
use crate::on_screen::OnScreen;
use crate::shared_pixels::{SharedPixels, PIXEL_BYTES};
use crate::system_window::{poll_until, SystemEvent, SystemWindow, WindowOptions};
use crate::watch::{DesktopRect, MonitorWatch, WindowAction};

/// A window on a compositor, over one output.
pub(crate) struct WaylandWindow {
    session: WaylandSession,
    globals: Globals,
    title: String,
    watch: MonitorWatch,
    /// `None` while the monitor is gone.
    active: Option<ActiveSurface>,
}

/// The compositor's global objects.
struct Globals {
    compositor: WlCompositor,
    memory: WlShm,
    shell: XdgWmBase,
    viewports: Option<WpViewporter>,
    idle: Option<ZwpIdleInhibitManagerV1>,
    /// Reports when images are on the screen.
    presentation: Option<WpPresentation>,
}

/// The surface on the screen.
struct ActiveSurface {
    surface: WlSurface,
    shell_surface: XdgSurface,
    toplevel: XdgToplevel,
    viewport: Option<WpViewport>,
    inhibitor: Option<ZwpIdleInhibitorV1>,
    buffers: Option<SurfaceBuffers>,
}

/// Two images in shared memory; dropping it destroys the compositor's objects for them.
struct SurfaceBuffers {
    pixels: SharedPixels,
    slots: [WlBuffer; 2],
}

impl Drop for SurfaceBuffers {
    fn drop(&mut self) {
        self.slots.iter().for_each(WlBuffer::destroy);
    }
}

impl WaylandWindow {
    /// Opens the window on the monitor that the options choose.
    pub(crate) fn open(options: &WindowOptions) -> Result<Self, WindowError> {
        let session = WaylandSession::open()?;
        let mut monitors = session.state.outputs.monitors();
        let monitor = monitors.swap_remove(options.monitor.resolve(&monitors)?);
        log::info!("{} on monitor {monitor}", options.source);
        if let Some([native, current]) = session.state.outputs.other_mode(&monitor.name) {
            log::warn!(
                "MONITOR {} RUNS {current}, ITS NATIVE MODE IS {native}: it scales each picture; set that mode in the \
                 desktop's settings (Wayland does not let a program do it)",
                monitor.name
            );
        }
        let globals = Globals::bind(&session)?;
        let watch = MonitorWatch::new(monitor, Instant::now());
        let mut window = Self { session, globals, title: options.source.clone(), watch, active: None };
        window.show()?;
        Ok(window)
    }

    /// Shows the window.
    fn show(&mut self) -> Result<(), WindowError> {
        self.hide();
        let handle = self.session.queue.handle();
        let globals = &self.globals;
        let surface = globals.compositor.create_surface(&handle, ());
        let shell_surface = globals.shell.get_xdg_surface(&surface, &handle, ());
        let toplevel = shell_surface.get_toplevel(&handle, ());
        toplevel.set_title(self.title.clone());
        toplevel.set_app_id("projector_window".to_owned());
        toplevel.set_fullscreen(self.session.state.outputs.proxy(&self.watch.monitor().name));
        let viewport = globals.viewports.as_ref().map(|viewports| viewports.get_viewport(&surface, &handle, ()));
        let inhibitor = globals.idle.as_ref().map(|idle| idle.create_inhibitor(&surface, &handle, ()));
        surface.commit();
        self.active = Some(ActiveSurface { surface, shell_surface, toplevel, viewport, inhibitor, buffers: None });
        self.session.queue.flush().map_err(lost_connection)
    }

    /// Hides the window; its objects are destroyed from the top.
    fn hide(&mut self) {
        let Some(active) = self.active.take() else { return };
        active.inhibitor.iter().for_each(ZwpIdleInhibitorV1::destroy);
        active.viewport.iter().for_each(WpViewport::destroy);
        active.toplevel.destroy();
        active.shell_surface.destroy();
        active.surface.destroy();
        self.session.state.configured = None;
    }

    /// Handles the compositor's pending events.
    fn take_events(&mut self) -> Result<Vec<SystemEvent>, WindowError> {
        self.session.queue.dispatch_pending(&mut self.session.state).map_err(lost)?;
        let buffers = self.active.as_mut().and_then(|active| active.buffers.as_mut());
        let released = std::mem::take(&mut self.session.state.released);
        if let Some(buffers) = buffers {
            released.into_iter().for_each(|slot| buffers.pixels.end_reading(slot));
        }
        Ok(std::mem::take(&mut self.session.state.events))
    }
}

impl Globals {
    fn bind(session: &WaylandSession) -> Result<Self, WindowError> {
        let handle = session.queue.handle();
        let missing = |error: &dyn std::fmt::Display| WindowError::NoDisplay(format!("the compositor: {error}"));
        Ok(Self {
            compositor: session.globals.bind(&handle, 1..=4, ()).map_err(|error| missing(&error))?,
            memory: session.globals.bind(&handle, 1..=1, ()).map_err(|error| missing(&error))?,
            shell: session.globals.bind(&handle, 1..=1, ()).map_err(|error| missing(&error))?,
            viewports: session.globals.bind(&handle, 1..=1, ()).ok(),
            idle: session.globals.bind(&handle, 1..=1, ()).ok(),
            presentation: session.globals.bind(&handle, 1..=1, ()).ok(),
        })
    }
}

impl ActiveSurface {
    /// Memory for images of this size.
    fn buffers(
        &mut self,
        size_px: (u32, u32),
        memory: &WlShm,
        handle: &wayland_client::QueueHandle<CompositorState>,
    ) -> Result<&mut SurfaceBuffers, WindowError> {
        let known = self.buffers.take();
        let buffers = match known {
            Some(buffers) if buffers.pixels.size_px() == size_px => buffers,
            _ => SurfaceBuffers::new(size_px, memory, handle)?,
        };
        Ok(self.buffers.insert(buffers))
    }
}

impl SurfaceBuffers {
    fn new(
        size_px: (u32, u32),
        memory: &WlShm,
        handle: &wayland_client::QueueHandle<CompositorState>,
    ) -> Result<Self, WindowError> {
        let pixels = SharedPixels::new(size_px)?;
        let side = |value: u64| i32::try_from(value).unwrap_or(i32::MAX);
        let (width, height) = (side(size_px.0.into()), side(size_px.1.into()));
        let stride = side(u64::from(size_px.0) * u64::from(PIXEL_BYTES));
        let pool = memory.create_pool(pixels.fd(), side(pixels.offset(2)), handle, ());
        let slot = |slot: usize| {
            let of_slot = pixels.shared_slot(slot);
            pool.create_buffer(side(pixels.offset(slot)), width, height, stride, Format::Xrgb8888, handle, of_slot)
        };
        let slots = [slot(0), slot(1)];
        pool.destroy();
        Ok(Self { pixels, slots })
    }
}

impl SystemWindow for WaylandWindow {
    fn monitor(&self) -> &MonitorInfo {
        self.watch.monitor()
    }

    fn is_there(&self) -> bool {
        self.watch.is_there()
    }

    fn come_to_front(&mut self) -> Result<(), WindowError> {
        self.show()
    }

    fn size_px(&self) -> (u32, u32) {
        // The configured size is in the desktop's units; the surface has the output's pixels.
        if self.active.is_some() && self.session.state.configured.is_some() {
            self.watch.monitor().size_px
        } else {
            (0, 0)
        }
    }

    fn is_ready(&self) -> bool {
        let buffers = self.active.as_ref().and_then(|active| active.buffers.as_ref());
        buffers.is_none_or(|buffers| buffers.pixels.free_slot().is_some())
    }

    fn present(&mut self, pixels: &[u32], on_screen: Option<Arc<dyn OnScreen>>) -> Result<(), WindowError> {
        let (size, handle) = (self.size_px(), self.session.queue.handle());
        let (Some(active), Some(desktop_size)) = (&mut self.active, self.session.state.configured) else {
            return Ok(());
        };
        let buffers = active.buffers(size, &self.globals.memory, &handle)?;
        let Some(slot) = buffers.pixels.free_slot() else { return Ok(()) };
        buffers.pixels.write(slot, pixels)?;
        buffers.pixels.begin_reading(slot);
        let buffer = buffers.slots.get(slot).cloned();
        if let (Some(viewport), (width, height)) = (&active.viewport, desktop_size) {
            if width > 0 && height > 0 {
                viewport.set_destination(width, height);
            }
        }
        active.surface.attach(buffer.as_ref(), 0, 0);
        active.surface.damage(0, 0, i32::MAX, i32::MAX);
        let presentation = self.globals.presentation.as_ref();
        let unreported = match (presentation, on_screen) {
            (Some(presentation), Some(listener)) => {
                presentation.feedback(&active.surface, &handle, listener);
                None
            }
            (_, on_screen) => on_screen,
        };
        active.surface.commit();
        self.session.queue.flush().map_err(lost_connection)?;
        unreported.iter().for_each(|listener| listener.shown());
        Ok(())
    }

    fn wait(&mut self, wake: BorrowedFd<'_>, until: Instant) -> Result<Vec<SystemEvent>, WindowError> {
        let events = self.take_events()?;
        if !events.is_empty() {
            return Ok(events);
        }
        self.session.queue.flush().map_err(lost_connection)?;
        if let Some(guard) = self.session.queue.prepare_read() {
            let compositor = guard.connection_fd();
            let mut fds =
                [PollFd::from_borrowed_fd(compositor, PollFlags::IN), PollFd::from_borrowed_fd(wake, PollFlags::IN)];
            poll_until(&mut fds, until)?;
            let is_readable = !fds[0].revents().is_empty();
            if is_readable {
                guard.read().map_err(lost_connection)?;
            }
        }
        self.take_events()
    }

    fn next_check(&self) -> Instant {
        self.watch.next_check()
    }

    fn check(&mut self, now: Instant) -> Result<bool, WindowError> {
        self.session.round_trip()?;
        let monitors = self.session.state.outputs.monitors();
        let place = self.session.state.configured.filter(|_| self.active.is_some());
        // A compositor does not report a surface's position; full screen it has the output's size.
        let place = place.map(|_| DesktopRect { position_px: None, size_px: self.watch.monitor().size_px });
        let found = self.watch.check(now, &monitors, place);
        match found.action {
            WindowAction::Leave => {}
            WindowAction::Hide => self.hide(),
            WindowAction::CoverAgain => self.show()?,
        }
        self.session.queue.flush().map_err(lost_connection)?;
        Ok(found.is_changed)
    }
}
