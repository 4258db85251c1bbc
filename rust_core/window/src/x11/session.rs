//! A connection to the X server, with queries by the window managers' conventions (ICCCM, EWMH).

use std::fmt::Display;

use x11rb::connection::Connection;
use x11rb::protocol::xproto::{Atom, AtomEnum, ConnectionExt as _, InputFocus, MapState, Screen, Window};
use x11rb::rust_connection::RustConnection;

use crate::error::WindowError;
use crate::wayland;

/// A connection to the X server that `DISPLAY` names.
pub(crate) struct X11Session {
    pub(super) connection: RustConnection,
    pub(super) screen: Screen,
}

impl X11Session {
    /// Connects.
    pub(crate) fn open() -> Result<Self, WindowError> {
        if std::env::var_os("DISPLAY").is_none() {
            let neither = if wayland::is_named() { "" } else { ", nor is WAYLAND_DISPLAY" };
            return Err(WindowError::NoDisplay(format!("DISPLAY is not set{neither}")));
        }
        let no_display = |reason: &dyn Display| {
            WindowError::NoDisplay(format!("{}: {reason} (DISPLAY must name a running display)", name()))
        };
        let (connection, screen) = x11rb::connect(None).map_err(|error| no_display(&error))?;
        let screen = connection.setup().roots.get(screen).ok_or_else(|| no_display(&"there is no such screen"))?;
        let screen = screen.clone();
        Ok(Self { connection, screen })
    }

    /// The root window.
    pub(super) fn root(&self) -> Window {
        self.screen.root
    }

    /// `true` if a window manager runs that supports full screen.
    ///
    /// By EWMH a manager is alive if the root window's `_NET_SUPPORTING_WM_CHECK` names a window that has the same
    /// property with its own id (a dead manager leaves only the first behind).
    pub(super) fn has_fullscreen_manager(&self) -> bool {
        let check = || {
            let check_atom = self.atom("_NET_SUPPORTING_WM_CHECK")?;
            let manager = *self.property(self.root(), check_atom, AtomEnum::WINDOW)?.first()?;
            let own_id = *self.property(manager, check_atom, AtomEnum::WINDOW)?.first()?;
            let fullscreen = self.atom("_NET_WM_STATE_FULLSCREEN")?;
            let supported = self.property(self.root(), self.atom("_NET_SUPPORTED")?, AtomEnum::ATOM)?;
            Some(own_id == manager && supported.contains(&fullscreen))
        };
        check().unwrap_or(false)
    }

    /// Sets the keyboard focus to a window; `false` while it is not viewable.
    pub(super) fn focus(&self, window: Window) -> bool {
        let focus = || {
            if self.map_state(window)? != MapState::VIEWABLE {
                return None;
            }
            let request = self.connection.set_input_focus(InputFocus::POINTER_ROOT, window, x11rb::CURRENT_TIME);
            request.ok()?.check().ok()
        };
        focus().is_some()
    }

    /// `true` if a window is neither on the screen nor managed. A window that is iconified or on another desktop has a
    /// property `WM_STATE` other than 0 (ICCCM, section 4.1.3.1).
    pub(super) fn is_withdrawn(&self, window: Window) -> bool {
        let state = || self.property(window, self.atom("WM_STATE")?, AtomEnum::ANY)?.first().copied();
        self.map_state(window) == Some(MapState::UNMAPPED) && state().unwrap_or(0) == 0
    }

    pub(super) fn map_state(&self, window: Window) -> Option<MapState> {
        Some(self.connection.get_window_attributes(window).ok()?.reply().ok()?.map_state)
    }

    pub(super) fn atom(&self, name: &str) -> Option<Atom> {
        let cookie = self.connection.intern_atom(false, name.as_bytes()).ok()?;
        Some(cookie.reply().ok()?.atom)
    }

    pub(super) fn property(&self, window: Window, property: Atom, kind: AtomEnum) -> Option<Vec<u32>> {
        let cookie = self.connection.get_property(false, window, property, kind, 0, 4096).ok()?;
        Some(cookie.reply().ok()?.value32()?.collect())
    }

    /// The error of a broken connection.
    pub(super) fn lost(error: impl Display) -> WindowError {
        WindowError::Lost(format!("X server {} is gone ({error})", name()))
    }
}

/// The display's name in the environment.
fn name() -> String {
    std::env::var("DISPLAY").map_or_else(|_| "DISPLAY is not set".to_owned(), |name| format!("DISPLAY {name}"))
}
