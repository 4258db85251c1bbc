//! Placing the window on its monitor.
//!
//! A window manager that supports EWMH makes the window full screen, on the monitor on which it lies. Without one, and
//! on a monitor that window managers do not know (a virtual one, or one of Xinerama's heads), the window places itself:
//! it has exactly the monitor's position and size, and is not offered to a manager (override-redirect).

use x11rb::connection::Connection;
use x11rb::cookie::VoidCookie;
use x11rb::errors::ConnectionError;
use x11rb::properties::{WmSizeHints, WmSizeHintsSpecification};
use x11rb::protocol::xproto::{
    AtomEnum, ClientMessageEvent, ConfigureWindowAux, ConnectionExt as _, CreateWindowAux, EventMask, PropMode,
    Rectangle, StackMode, UnmapNotifyEvent, Window, WindowClass, UNMAP_NOTIFY_EVENT,
};
use x11rb::rust_connection::RustConnection;
use x11rb::wrapper::ConnectionExt as _;

use super::session::X11Session;
use crate::error::WindowError;
use crate::monitor::MonitorInfo;
use crate::system_window::WindowOptions;
use crate::watch::DesktopRect;

/// Instance and class of this package's windows (ICCCM's `WM_CLASS`).
pub(super) const WINDOW_CLASS: &[u8] = b"projector_window\0projector_window\0";
/// Instance and class of the black windows of a dead-man's switch.
const BLACK_WINDOW_CLASS: &[u8] = b"black_window\0black_window\0";

/// Actions of a message that changes `_NET_WM_STATE` (EWMH).
const REMOVE: u32 = 0;
const ADD: u32 = 1;
/// Source of such a message: an ordinary program (EWMH).
const FROM_PROGRAM: u32 = 1;

type Sent<'a> = Result<VoidCookie<'a, RustConnection>, ConnectionError>;

impl X11Session {
    /// Creates a black window with the monitor's position and size and an invisible pointer. It is not mapped yet.
    pub(super) fn create_window(
        &self,
        options: &WindowOptions,
        monitor: &MonitorInfo,
        placed_by_itself: bool,
    ) -> Result<Window, WindowError> {
        let create = || -> Result<Window, Box<dyn std::error::Error>> {
            let window = self.connection.generate_id()?;
            let (x, y, width, height) = rectangle(monitor);
            let keys = EventMask::KEY_PRESS | EventMask::KEY_RELEASE;
            let attributes = CreateWindowAux::new()
                .background_pixel(self.screen.black_pixel)
                .override_redirect(u32::from(placed_by_itself))
                .cursor(self.invisible_cursor()?)
                .event_mask(EventMask::EXPOSURE | EventMask::STRUCTURE_NOTIFY | keys);
            let (class, visual) = (WindowClass::INPUT_OUTPUT, self.screen.root_visual);
            let depth = self.screen.root_depth;
            self.connection
                .create_window(depth, window, self.root(), x, y, width, height, 0, class, visual, &attributes)?
                .check()?;
            self.describe(window, options)?;
            Ok(window)
        };
        create().map_err(|error| WindowError::Open { monitor: monitor.clone(), reason: error.to_string() })
    }

    /// A pointer of one transparent pixel.
    fn invisible_cursor(&self) -> Result<u32, Box<dyn std::error::Error>> {
        let (mask, cursor) = (self.connection.generate_id()?, self.connection.generate_id()?);
        let context = self.connection.generate_id()?;
        self.connection.create_pixmap(1, mask, self.root(), 1, 1)?;
        // A new context draws zeros.
        self.connection.create_gc(context, mask, &Default::default())?;
        let point = Rectangle { x: 0, y: 0, width: 1, height: 1 };
        self.connection.poly_fill_rectangle(mask, context, &[point])?;
        self.connection.create_cursor(cursor, mask, mask, 0, 0, 0, 0, 0, 0, 0, 0)?;
        self.connection.free_gc(context)?;
        self.connection.free_pixmap(mask)?;
        Ok(cursor)
    }

    /// Sets title and class, no decorations, the close protocol, and no compositing.
    fn describe(&self, window: Window, options: &WindowOptions) -> Result<(), Box<dyn std::error::Error>> {
        let atom = |name: &str| self.connection.intern_atom(false, name.as_bytes());
        let (utf8, net_name) = (atom("UTF8_STRING")?.reply()?.atom, atom("_NET_WM_NAME")?.reply()?.atom);
        let (protocols, delete) = (atom("WM_PROTOCOLS")?.reply()?.atom, atom("WM_DELETE_WINDOW")?.reply()?.atom);
        let (motif, bypass) =
            (atom("_MOTIF_WM_HINTS")?.reply()?.atom, atom("_NET_WM_BYPASS_COMPOSITOR")?.reply()?.atom);
        let (connection, title) = (&self.connection, &options.source);
        let class = if options.role.is_black() { BLACK_WINDOW_CLASS } else { WINDOW_CLASS };
        let replace = PropMode::REPLACE;
        connection.change_property8(replace, window, AtomEnum::WM_NAME, AtomEnum::STRING, title.as_bytes())?;
        connection.change_property8(replace, window, net_name, utf8, title.as_bytes())?;
        connection.change_property8(replace, window, AtomEnum::WM_CLASS, AtomEnum::STRING, class)?;
        connection.change_property32(replace, window, protocols, AtomEnum::ATOM, &[delete])?;
        // Flags: only the decorations are set, to none.
        connection.change_property32(replace, window, motif, motif, &[2, 0, 0, 0, 0])?;
        connection.change_property32(replace, window, bypass, AtomEnum::CARDINAL, &[1])?;
        Ok(())
    }

    /// Maps the window over its monitor.
    pub(super) fn map(&self, window: Window, monitor: &MonitorInfo, placed_by_itself: bool) -> Result<(), WindowError> {
        self.move_to(window, monitor, Some(StackMode::ABOVE)).map_err(Self::lost)?;
        if !placed_by_itself {
            let (x, y, width, height) = rectangle(monitor);
            let specification = WmSizeHintsSpecification::UserSpecified;
            let hints = WmSizeHints {
                position: Some((specification, x.into(), y.into())),
                size: Some((specification, width.into(), height.into())),
                ..WmSizeHints::default()
            };
            hints.set_normal_hints(&self.connection, window).map_err(Self::lost)?;
            if let (Some(state), Some(fullscreen)) = (self.atom("_NET_WM_STATE"), self.atom("_NET_WM_STATE_FULLSCREEN"))
            {
                let (replace, kind) = (PropMode::REPLACE, AtomEnum::ATOM);
                self.connection.change_property32(replace, window, state, kind, &[fullscreen]).map_err(Self::lost)?;
            }
        }
        self.connection.map_window(window).map_err(Self::lost)?;
        self.connection.flush().map_err(Self::lost)
    }

    /// Withdraws the window (ICCCM, section 4.1.4).
    pub(super) fn withdraw(&self, window: Window) -> Result<(), WindowError> {
        self.connection.unmap_window(window).map_err(Self::lost)?;
        let unmapped = UnmapNotifyEvent {
            response_type: UNMAP_NOTIFY_EVENT,
            sequence: 0,
            event: self.root(),
            window,
            from_configure: false,
        };
        self.send_to_manager(unmapped).map_err(Self::lost)?;
        self.connection.flush().map_err(Self::lost)
    }

    /// Moves a misplaced window to its monitor.
    pub(super) fn cover_again(
        &self,
        window: Window,
        monitor: &MonitorInfo,
        placed_by_itself: bool,
        stacking: Option<StackMode>,
    ) -> Result<(), WindowError> {
        if placed_by_itself {
            self.move_to(window, monitor, stacking).map_err(Self::lost)?;
        } else {
            // A window that is full screen already would not move.
            self.ask_for_fullscreen(window, REMOVE)?;
            self.move_to(window, monitor, stacking).map_err(Self::lost)?;
            self.ask_for_fullscreen(window, ADD)?;
        }
        self.connection.flush().map_err(Self::lost)
    }

    fn ask_for_fullscreen(&self, window: Window, change: u32) -> Result<(), WindowError> {
        let (Some(state), Some(fullscreen)) = (self.atom("_NET_WM_STATE"), self.atom("_NET_WM_STATE_FULLSCREEN"))
        else {
            return Ok(());
        };
        let message = ClientMessageEvent::new(32, window, state, [change, fullscreen, 0, FROM_PROGRAM, 0]);
        self.send_to_manager(message).map(drop).map_err(Self::lost)
    }

    fn send_to_manager(&self, event: impl Into<[u8; 32]>) -> Sent<'_> {
        let mask = EventMask::SUBSTRUCTURE_REDIRECT | EventMask::SUBSTRUCTURE_NOTIFY;
        self.connection.send_event(false, self.root(), mask, event)
    }

    /// Brings a window to the front of all others.
    pub(super) fn raise(&self, window: Window) -> Result<(), WindowError> {
        let front = ConfigureWindowAux::new().stack_mode(StackMode::ABOVE);
        self.connection.configure_window(window, &front).map_err(Self::lost)?;
        self.connection.flush().map_err(Self::lost)
    }

    fn move_to(
        &self,
        window: Window,
        monitor: &MonitorInfo,
        stacking: Option<StackMode>,
    ) -> Result<(), ConnectionError> {
        let (x, y, width, height) = rectangle(monitor);
        let place = ConfigureWindowAux::new().x(i32::from(x)).y(i32::from(y));
        let place = place.width(u32::from(width)).height(u32::from(height));
        let place = ConfigureWindowAux { stack_mode: stacking, ..place };
        self.connection.configure_window(window, &place).map(drop)
    }

    /// The window's rectangle in the desktop; `None` while it is not on the screen.
    pub(super) fn place_of(&self, window: Window) -> Option<DesktopRect> {
        if self.is_withdrawn(window) {
            return None;
        }
        let size = self.connection.get_geometry(window).ok()?.reply().ok()?;
        let at = self.connection.translate_coordinates(window, self.root(), 0, 0).ok()?.reply().ok()?;
        Some(DesktopRect {
            position_px: Some((at.dst_x.into(), at.dst_y.into())),
            size_px: (size.width.into(), size.height.into()),
        })
    }
}

/// Left, top, width and height in the protocol's types.
fn rectangle(monitor: &MonitorInfo) -> (i16, i16, u16, u16) {
    let place = |pixels: i32| i16::try_from(pixels).unwrap_or(0);
    let side = |pixels: u32| u16::try_from(pixels).unwrap_or(u16::MAX).max(1);
    let ((x, y), (width, height)) = (monitor.position_px, monitor.size_px);
    (place(x), place(y), side(width), side(height))
}
