//! The connection to the compositor, and the state that it has reported.

use std::io::Read;
use std::os::fd::OwnedFd;
use std::sync::Arc;

use wayland_client::backend::WaylandError;
use wayland_client::globals::{registry_queue_init, GlobalList, GlobalListContents};
use wayland_client::protocol::wl_buffer::{self, WlBuffer};
use wayland_client::protocol::wl_compositor::WlCompositor;
use wayland_client::protocol::wl_keyboard::{self, KeyState, KeymapFormat, WlKeyboard};
use wayland_client::protocol::wl_output::{self, WlOutput};
use wayland_client::protocol::wl_pointer::{self, WlPointer};
use wayland_client::protocol::wl_registry::{self, WlRegistry};
use wayland_client::protocol::wl_seat::{self, Capability, WlSeat};
use wayland_client::protocol::wl_shm::WlShm;
use wayland_client::protocol::wl_shm_pool::WlShmPool;
use wayland_client::protocol::wl_surface::WlSurface;
use wayland_client::{delegate_noop, Connection, Dispatch, DispatchError, EventQueue, Proxy, QueueHandle, WEnum};
use wayland_protocols::wp::idle_inhibit::zv1::client::zwp_idle_inhibit_manager_v1::ZwpIdleInhibitManagerV1;
use wayland_protocols::wp::idle_inhibit::zv1::client::zwp_idle_inhibitor_v1::ZwpIdleInhibitorV1;
use wayland_protocols::wp::presentation_time::client::wp_presentation::WpPresentation;
use wayland_protocols::wp::presentation_time::client::wp_presentation_feedback::{self, WpPresentationFeedback};
use wayland_protocols::wp::viewporter::client::wp_viewport::WpViewport;
use wayland_protocols::wp::viewporter::client::wp_viewporter::WpViewporter;
use wayland_protocols::xdg::shell::client::xdg_surface::{self, XdgSurface};
use wayland_protocols::xdg::shell::client::xdg_toplevel::{self, XdgToplevel};
use wayland_protocols::xdg::shell::client::xdg_wm_base::{self, XdgWmBase};
use wayland_protocols::xdg::xdg_output::zv1::client::zxdg_output_manager_v1::ZxdgOutputManagerV1;
use wayland_protocols::xdg::xdg_output::zv1::client::zxdg_output_v1::ZxdgOutputV1;

use super::keymap::Keymap;
use super::outputs::WaylandOutputs;
use crate::error::WindowError;
use crate::on_screen::OnScreen;
use crate::shared_pixels::SharedSlot;
use crate::system_window::SystemEvent;

/// The shift key's modifier bit, as in the core X protocol.
const SHIFT: u32 = 1;
/// Newest supported version of wl_output.
const OUTPUT_VERSION: u32 = 4;

/// A connection to the compositor that `WAYLAND_DISPLAY` names.
pub(super) struct WaylandSession {
    pub(super) queue: EventQueue<CompositorState>,
    pub(super) globals: GlobalList,
    pub(super) state: CompositorState,
}

/// The compositor's state.
#[derive(Default)]
pub(super) struct CompositorState {
    pub(super) outputs: WaylandOutputs,
    /// Events to be handled.
    pub(super) events: Vec<SystemEvent>,
    /// The surface's size in the desktop's units, once it is configured.
    pub(super) configured: Option<(i32, i32)>,
    /// The size in the next configuration.
    pending_size: (i32, i32),
    /// Images that the compositor has released.
    pub(super) released: Vec<SharedSlot>,
    described: Option<ZxdgOutputManagerV1>,
    keyboard: Option<WlKeyboard>,
    pointer: Option<WlPointer>,
    keymap: Keymap,
    is_shifted: bool,
}

impl WaylandSession {
    /// Connects and reads the outputs.
    pub(super) fn open() -> Result<Self, WindowError> {
        let none = |error: &dyn std::fmt::Display| {
            let text = format!("no Wayland compositor: {error} (WAYLAND_DISPLAY must name a running display)");
            WindowError::NoDisplay(text)
        };
        let connection = Connection::connect_to_env().map_err(|error| none(&error))?;
        let (globals, queue) = registry_queue_init::<CompositorState>(&connection).map_err(|error| none(&error))?;
        let handle = queue.handle();
        // Without it, positions in the desktop are unknown.
        let described = globals.bind::<ZxdgOutputManagerV1, _, _>(&handle, 1..=3, ()).ok();
        let mut state = CompositorState { described, ..CompositorState::default() };
        let known = globals.contents().clone_list();
        for global in known.iter().filter(|global| global.interface == WlOutput::interface().name) {
            state.add_output(globals.registry(), global.name, global.version, &handle);
        }
        // A compositor without keys has no seat.
        let _ = globals.bind::<WlSeat, _, _>(&handle, 1..=5, ());
        let mut session = Self { queue, globals, state };
        session.round_trip()?;
        session.round_trip()?;
        Ok(session)
    }

    /// Waits until the compositor has answered all requests.
    pub(super) fn round_trip(&mut self) -> Result<(), WindowError> {
        self.queue.roundtrip(&mut self.state).map(drop).map_err(lost)
    }
}

/// The error of a broken connection.
#[expect(clippy::needless_pass_by_value, reason = "for map_err")]
pub(super) fn lost(error: DispatchError) -> WindowError {
    WindowError::Lost(format!("the Wayland compositor is gone ({error})"))
}

/// The error of a broken connection.
pub(super) fn lost_connection(error: WaylandError) -> WindowError {
    lost(DispatchError::Backend(error))
}

impl CompositorState {
    fn add_output(&mut self, registry: &WlRegistry, name: u32, version: u32, handle: &QueueHandle<Self>) {
        self.outputs.add(name, registry.bind(name, version.min(OUTPUT_VERSION), handle, ()));
        if let Some(manager) = &self.described {
            self.outputs.describe(|output| manager.get_xdg_output(output, handle, ()));
        }
    }

    fn report_monitors(&mut self) {
        if !self.events.contains(&SystemEvent::Monitors) {
            self.events.push(SystemEvent::Monitors);
        }
    }
}

/// Implements [`Dispatch`] for the events of an object, with state, object, event, the object's data and the queue.
macro_rules! on_event {
    (
        $object:ty, $data:ty,
        |$state:pat_param, $proxy:pat_param, $event:pat_param, $user:pat_param, $queue:pat_param| $body:block
    ) => {
        impl Dispatch<$object, $data> for CompositorState {
            fn event(
                $state: &mut Self,
                $proxy: &$object,
                $event: <$object as Proxy>::Event,
                $user: &$data,
                _: &Connection,
                $queue: &QueueHandle<Self>,
            ) $body
        }
    };
}

on_event!(WlRegistry, GlobalListContents, |state, registry, event, _, handle| {
    match event {
        wl_registry::Event::Global { name, interface, version } if interface == WlOutput::interface().name => {
            state.add_output(registry, name, version, handle);
        }
        wl_registry::Event::GlobalRemove { name } if state.outputs.remove(name) => state.report_monitors(),
        _ => {}
    }
});

on_event!(WlOutput, (), |state, proxy, event, _, _| {
    if matches!(event, wl_output::Event::Done) {
        state.report_monitors();
    }
    state.outputs.apply(proxy, event);
});

on_event!(ZxdgOutputV1, (), |state, proxy, event, _, _| {
    state.outputs.apply_described(proxy, event);
});

on_event!(WlSeat, (), |state, seat, event, _, handle| {
    let wl_seat::Event::Capabilities { capabilities: WEnum::Value(capabilities) } = event else { return };
    if capabilities.contains(Capability::Keyboard) && state.keyboard.is_none() {
        state.keyboard = Some(seat.get_keyboard(handle, ()));
    }
    if capabilities.contains(Capability::Pointer) && state.pointer.is_none() {
        state.pointer = Some(seat.get_pointer(handle, ()));
    }
});

on_event!(WlPointer, (), |_, pointer, event, _, _| {
    if let wl_pointer::Event::Enter { serial, .. } = event {
        pointer.set_cursor(serial, None, 0, 0);
    }
});

on_event!(WlKeyboard, (), |state, _, event, _, _| {
    match event {
        wl_keyboard::Event::Keymap { format: WEnum::Value(KeymapFormat::XkbV1), fd, size } => {
            state.keymap = read_keymap(fd, size);
        }
        wl_keyboard::Event::Modifiers { mods_depressed, .. } => state.is_shifted = mods_depressed & SHIFT != 0,
        wl_keyboard::Event::Key { key, state: WEnum::Value(KeyState::Pressed), .. } => {
            let symbol = state.keymap.keysym(key, state.is_shifted);
            // A compositor does not repeat keys.
            state.events.extend(symbol.map(|keysym| SystemEvent::Key { keysym, is_repeat: false }));
        }
        _ => {}
    }
});

on_event!(WpPresentationFeedback, Arc<dyn OnScreen>, |_, _, event, listener, _| {
    if let wp_presentation_feedback::Event::Presented { .. } = event {
        listener.shown();
    }
});

/// The keymap in the compositor's shared file; without keys if it cannot be read.
fn read_keymap(file: OwnedFd, size: u32) -> Keymap {
    use std::io::Seek;
    let mut file = std::fs::File::from(file);
    let mut text = Vec::new();
    // Clients may share the file and its position.
    let read = file.rewind().and_then(|()| file.take(size.into()).read_to_end(&mut text));
    if let Err(error) = read {
        log::warn!("cannot read the keyboard's layout, so keys do nothing: {error}");
    }
    Keymap::parse(&String::from_utf8_lossy(&text))
}

on_event!(XdgWmBase, (), |_, base, event, _, _| {
    if let xdg_wm_base::Event::Ping { serial } = event {
        base.pong(serial);
    }
});

on_event!(XdgSurface, (), |state, surface, event, _, _| {
    if let xdg_surface::Event::Configure { serial } = event {
        surface.ack_configure(serial);
        state.configured = Some(state.pending_size);
        state.events.push(SystemEvent::Expose);
    }
});

on_event!(XdgToplevel, (), |state, _, event, _, _| {
    match event {
        xdg_toplevel::Event::Configure { width, height, .. } => state.pending_size = (width, height),
        xdg_toplevel::Event::Close => state.events.push(SystemEvent::Close),
        _ => {}
    }
});

on_event!(WlBuffer, SharedSlot, |state, _, event, slot, _| {
    if matches!(event, wl_buffer::Event::Release) {
        state.released.push(*slot);
    }
});

delegate_noop!(CompositorState: ignore WlCompositor);
delegate_noop!(CompositorState: ignore WlShm);
delegate_noop!(CompositorState: ignore WlShmPool);
delegate_noop!(CompositorState: ignore WlSurface);
// Names the clock of the reported times, which are just past when they come.
delegate_noop!(CompositorState: ignore WpPresentation);
delegate_noop!(CompositorState: ignore WpViewporter);
delegate_noop!(CompositorState: ignore WpViewport);
delegate_noop!(CompositorState: ignore ZwpIdleInhibitManagerV1);
delegate_noop!(CompositorState: ignore ZwpIdleInhibitorV1);
delegate_noop!(CompositorState: ignore ZxdgOutputManagerV1);
