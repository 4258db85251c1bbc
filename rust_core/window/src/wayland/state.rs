//! The connection to the compositor, and what it has told so far.

use std::io::Read;
use std::os::fd::OwnedFd;

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
use wayland_protocols::wp::viewporter::client::wp_viewport::WpViewport;
use wayland_protocols::wp::viewporter::client::wp_viewporter::WpViewporter;
use wayland_protocols::xdg::shell::client::xdg_surface::{self, XdgSurface};
use wayland_protocols::xdg::shell::client::xdg_toplevel::{self, XdgToplevel};
use wayland_protocols::xdg::shell::client::xdg_wm_base::{self, XdgWmBase};
use wayland_protocols::xdg::xdg_output::zv1::client::zxdg_output_manager_v1::ZxdgOutputManagerV1;
use wayland_protocols::xdg::xdg_output::zv1::client::zxdg_output_v1::{self, ZxdgOutputV1};

use super::keymap::Keymap;
use super::outputs::Outputs;
use crate::run::SystemEvent;
use crate::shared_pixels::SharedSlot;
use crate::WindowError;

/// The shift key among the modifiers of a keyboard (that of the core X protocol, which keymaps keep).
const SHIFT: u32 = 1;
/// The newest version of wl_output that is understood.
const OUTPUT_VERSION: u32 = 4;

/// A connection to the compositor that `WAYLAND_DISPLAY` names.
pub(super) struct Session {
    pub(super) queue: EventQueue<State>,
    pub(super) globals: GlobalList,
    pub(super) state: State,
}

/// What the compositor has told.
#[derive(Default)]
pub(super) struct State {
    pub(super) outputs: Outputs,
    /// What it has to be answered to, or reported.
    pub(super) events: Vec<SystemEvent>,
    /// The surface's size in the desktop's units, once it may be drawn.
    pub(super) configured: Option<(i32, i32)>,
    /// The size that goes with the next acknowledged change.
    pending_size: (i32, i32),
    /// The pictures that were read since this was last taken.
    pub(super) released: Vec<SharedSlot>,
    described: Option<ZxdgOutputManagerV1>,
    keyboard: Option<WlKeyboard>,
    pointer: Option<WlPointer>,
    keymap: Keymap,
    is_shifted: bool,
}

impl Session {
    /// Connects and learns of the outputs.
    pub(super) fn open() -> Result<Self, WindowError> {
        let none = |error: &dyn std::fmt::Display| {
            let text = format!("no Wayland compositor: {error} (WAYLAND_DISPLAY must name a running display)");
            WindowError::NoDisplay(text)
        };
        let connection = Connection::connect_to_env().map_err(|error| none(&error))?;
        let (globals, queue) = registry_queue_init::<State>(&connection).map_err(|error| none(&error))?;
        let handle = queue.handle();
        // Without its manager there are no places in the desktop.
        let described = globals.bind::<ZxdgOutputManagerV1, _, _>(&handle, 1..=3, ()).ok();
        let mut state = State { described, ..State::default() };
        let known = globals.contents().clone_list();
        for global in known.iter().filter(|global| global.interface == WlOutput::interface().name) {
            state.add_output(globals.registry(), global.name, global.version, &handle);
        }
        // A seat is optional: a compositor without keys.
        let _ = globals.bind::<WlSeat, _, _>(&handle, 1..=5, ());
        let mut session = Self { queue, globals, state };
        session.round_trip()?;
        session.round_trip()?;
        Ok(session)
    }

    /// Waits until the compositor has answered everything.
    pub(super) fn round_trip(&mut self) -> Result<(), WindowError> {
        self.queue.roundtrip(&mut self.state).map(drop).map_err(lost)
    }
}

/// The connection broke.
#[expect(clippy::needless_pass_by_value, reason = "for map_err")]
pub(super) fn lost(error: DispatchError) -> WindowError {
    WindowError::Lost(format!("the Wayland compositor is gone ({error})"))
}

/// The connection broke.
pub(super) fn lost_connection(error: WaylandError) -> WindowError {
    lost(DispatchError::Backend(error))
}

impl State {
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

impl Dispatch<WlRegistry, GlobalListContents> for State {
    fn event(
        state: &mut Self,
        registry: &WlRegistry,
        event: wl_registry::Event,
        _: &GlobalListContents,
        _: &Connection,
        handle: &QueueHandle<Self>,
    ) {
        match event {
            wl_registry::Event::Global { name, interface, version } if interface == WlOutput::interface().name => {
                state.add_output(registry, name, version, handle);
            }
            wl_registry::Event::GlobalRemove { name } if state.outputs.remove(name) => state.report_monitors(),
            _ => {}
        }
    }
}

impl Dispatch<WlOutput, ()> for State {
    fn event(
        state: &mut Self,
        proxy: &WlOutput,
        event: wl_output::Event,
        _: &(),
        _: &Connection,
        _: &QueueHandle<Self>,
    ) {
        if matches!(event, wl_output::Event::Done) {
            state.report_monitors();
        }
        state.outputs.apply(proxy, event);
    }
}

impl Dispatch<ZxdgOutputV1, ()> for State {
    fn event(
        state: &mut Self,
        proxy: &ZxdgOutputV1,
        event: zxdg_output_v1::Event,
        _: &(),
        _: &Connection,
        _: &QueueHandle<Self>,
    ) {
        state.outputs.apply_described(proxy, event);
    }
}

impl Dispatch<WlSeat, ()> for State {
    fn event(
        state: &mut Self,
        seat: &WlSeat,
        event: wl_seat::Event,
        _: &(),
        _: &Connection,
        handle: &QueueHandle<Self>,
    ) {
        let wl_seat::Event::Capabilities { capabilities: WEnum::Value(capabilities) } = event else { return };
        if capabilities.contains(Capability::Keyboard) && state.keyboard.is_none() {
            state.keyboard = Some(seat.get_keyboard(handle, ()));
        }
        if capabilities.contains(Capability::Pointer) && state.pointer.is_none() {
            state.pointer = Some(seat.get_pointer(handle, ()));
        }
    }
}

impl Dispatch<WlPointer, ()> for State {
    fn event(
        _: &mut Self,
        pointer: &WlPointer,
        event: wl_pointer::Event,
        _: &(),
        _: &Connection,
        _: &QueueHandle<Self>,
    ) {
        if let wl_pointer::Event::Enter { serial, .. } = event {
            pointer.set_cursor(serial, None, 0, 0);
        }
    }
}

impl Dispatch<WlKeyboard, ()> for State {
    fn event(
        state: &mut Self,
        _: &WlKeyboard,
        event: wl_keyboard::Event,
        _: &(),
        _: &Connection,
        _: &QueueHandle<Self>,
    ) {
        match event {
            wl_keyboard::Event::Keymap { format: WEnum::Value(KeymapFormat::XkbV1), fd, size } => {
                state.keymap = read_keymap(fd, size);
            }
            wl_keyboard::Event::Modifiers { mods_depressed, .. } => state.is_shifted = mods_depressed & SHIFT != 0,
            wl_keyboard::Event::Key { key, state: WEnum::Value(KeyState::Pressed), .. } => {
                let symbol = state.keymap.keysym(key, state.is_shifted);
                state.events.extend(symbol.map(SystemEvent::Key));
            }
            _ => {}
        }
    }
}

/// The keymap in a file that the compositor shares; one without keys if it cannot be read.
fn read_keymap(file: OwnedFd, size: u32) -> Keymap {
    use std::io::Seek;
    let mut file = std::fs::File::from(file);
    let mut text = Vec::new();
    // Several clients may share the file and its place.
    let read = file.rewind().and_then(|()| file.take(size.into()).read_to_end(&mut text));
    if let Err(error) = read {
        log::warn!("the keyboard's layout cannot be read, so that keys do nothing: {error}");
    }
    Keymap::parse(&String::from_utf8_lossy(&text))
}

impl Dispatch<XdgWmBase, ()> for State {
    fn event(_: &mut Self, base: &XdgWmBase, event: xdg_wm_base::Event, _: &(), _: &Connection, _: &QueueHandle<Self>) {
        if let xdg_wm_base::Event::Ping { serial } = event {
            base.pong(serial);
        }
    }
}

impl Dispatch<XdgSurface, ()> for State {
    fn event(
        state: &mut Self,
        surface: &XdgSurface,
        event: xdg_surface::Event,
        _: &(),
        _: &Connection,
        _: &QueueHandle<Self>,
    ) {
        if let xdg_surface::Event::Configure { serial } = event {
            surface.ack_configure(serial);
            state.configured = Some(state.pending_size);
            state.events.push(SystemEvent::Expose);
        }
    }
}

impl Dispatch<XdgToplevel, ()> for State {
    fn event(
        state: &mut Self,
        _: &XdgToplevel,
        event: xdg_toplevel::Event,
        _: &(),
        _: &Connection,
        _: &QueueHandle<Self>,
    ) {
        match event {
            xdg_toplevel::Event::Configure { width, height, .. } => state.pending_size = (width, height),
            xdg_toplevel::Event::Close => state.events.push(SystemEvent::Close),
            _ => {}
        }
    }
}

impl Dispatch<WlBuffer, SharedSlot> for State {
    fn event(
        state: &mut Self,
        _: &WlBuffer,
        event: wl_buffer::Event,
        slot: &SharedSlot,
        _: &Connection,
        _: &QueueHandle<Self>,
    ) {
        if matches!(event, wl_buffer::Event::Release) {
            state.released.push(*slot);
        }
    }
}

delegate_noop!(State: ignore WlCompositor);
delegate_noop!(State: ignore WlShm);
delegate_noop!(State: ignore WlShmPool);
delegate_noop!(State: ignore WlSurface);
delegate_noop!(State: ignore WpViewporter);
delegate_noop!(State: ignore WpViewport);
delegate_noop!(State: ignore ZwpIdleInhibitManagerV1);
delegate_noop!(State: ignore ZwpIdleInhibitorV1);
delegate_noop!(State: ignore ZxdgOutputManagerV1);
