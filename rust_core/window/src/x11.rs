//! What winit does not offer for X servers.
//!
//! winit makes a window full screen by asking the window manager (EWMH's `_NET_WM_STATE_FULLSCREEN`). A projector's X
//! server often has none ([`X11Session::has_fullscreen_manager`]); then the window covers the monitor by itself.
//! Without a manager the window is not given the keyboard either ([`X11Session::focus`]), and the screen saver must not
//! blank an unchanged picture ([`X11Session::keep_screen_awake`]). [`X11Session::monitors`] are the monitors as they
//! are now, and also those that winit does not know; winit's list can be that of the program's start.

use x11rb::connection::{Connection, RequestConnection};
use x11rb::protocol::randr::{ConnectionExt as _, MonitorInfo as MonitorReply};
use x11rb::protocol::screensaver::{self, ConnectionExt as _};
use x11rb::protocol::xinerama::{self, ConnectionExt as _, ScreenInfo};
use x11rb::protocol::xproto::{AtomEnum, ConnectionExt as _, InputFocus, MapState, Window};
use x11rb::rust_connection::RustConnection;

use crate::monitor::MonitorInfo;

/// A second connection to the X server that `DISPLAY` names, beside winit's own.
pub(crate) struct X11Session {
    connection: RustConnection,
    root: Window,
}

impl X11Session {
    /// Connects; `None` if that fails, because everything here is an aid only.
    pub(crate) fn open() -> Option<Self> {
        let (connection, screen) = x11rb::connect(None).ok()?;
        let root = connection.setup().roots.get(screen)?.root;
        Some(Self { connection, root })
    }

    /// Whether a window manager runs that makes windows full screen.
    ///
    /// By EWMH a manager is alive when the root window's `_NET_SUPPORTING_WM_CHECK` names a window that carries the
    /// same property with its own id (a dead manager leaves the first behind, not the second).
    pub(crate) fn has_fullscreen_manager(&self) -> bool {
        let check = || {
            let check_atom = self.atom("_NET_SUPPORTING_WM_CHECK")?;
            let manager = *self.property(self.root, check_atom, AtomEnum::WINDOW)?.first()?;
            let own_id = *self.property(manager, check_atom, AtomEnum::WINDOW)?.first()?;
            let fullscreen = self.atom("_NET_WM_STATE_FULLSCREEN")?;
            let supported = self.property(self.root, self.atom("_NET_SUPPORTED")?, AtomEnum::ATOM)?;
            Some(own_id == manager && supported.contains(&fullscreen))
        };
        check().unwrap_or(false)
    }

    /// Gives a window the keyboard; false while it is not on the screen yet.
    pub(crate) fn focus(&self, window: Window) -> bool {
        let focus = || {
            if self.map_state(window)? != MapState::VIEWABLE {
                return None;
            }
            let request = self.connection.set_input_focus(InputFocus::POINTER_ROOT, window, x11rb::CURRENT_TIME);
            request.ok()?.check().ok()
        };
        focus().is_some()
    }

    /// Whether a window is neither on the screen nor managed: one that the user iconified, or left on another desktop,
    /// carries the property `WM_STATE` with another value than 0 (ICCCM, section 4.1.3.1).
    pub(crate) fn is_withdrawn(&self, window: Window) -> bool {
        let state = || self.property(window, self.atom("WM_STATE")?, AtomEnum::ANY)?.first().copied();
        self.map_state(window) == Some(MapState::UNMAPPED) && state().unwrap_or(0) == 0
    }

    fn map_state(&self, window: Window) -> Option<MapState> {
        Some(self.connection.get_window_attributes(window).ok()?.reply().ok()?.map_state)
    }

    /// Keeps the screen saver and the monitor's power saving off for as long as this session lives.
    pub(crate) fn keep_screen_awake(&self) -> bool {
        let suspend = || {
            self.connection.extension_information(screensaver::X11_EXTENSION_NAME).ok()??;
            self.connection.screensaver_query_version(1, 1).ok()?.reply().ok()?;
            self.connection.screensaver_suspend(1).ok()?.check().ok()
        };
        suspend().is_some()
    }

    /// All monitors as they are now: the outputs of RandR, which winit knows as well, and the virtual ones that
    /// `xrandr --setmonitor` makes of parts of the desktop; or, where several screens are one desktop by Xinerama, its
    /// heads. Empty without both extensions.
    pub(crate) fn monitors(&self) -> Vec<MonitorInfo> {
        let mut monitors = self.outputs().unwrap_or_default();
        for monitor in self.named_monitors().unwrap_or_default() {
            match monitors.iter_mut().find(|output| output.name == monitor.name) {
                Some(output) => output.is_primary |= monitor.is_primary,
                None => monitors.push(monitor),
            }
        }
        // RandR's monitors are heads as well, so that more of those are Xinerama's own.
        let heads = self.heads().unwrap_or_default();
        if heads.len() > monitors.len() {
            heads
        } else {
            monitors
        }
    }

    /// The outputs that are on.
    fn outputs(&self) -> Option<Vec<MonitorInfo>> {
        let resources = self.connection.randr_get_screen_resources_current(self.root).ok()?.reply().ok()?;
        let primary = self.connection.randr_get_output_primary(self.root).ok()?.reply().ok()?.output;
        let time = resources.config_timestamp;
        let output = |crtc| {
            let crtc = self.connection.randr_get_crtc_info(crtc, time).ok()?.reply().ok()?;
            let id = *crtc.outputs.first()?;
            let output = self.connection.randr_get_output_info(id, time).ok()?.reply().ok()?;
            Some(MonitorInfo {
                name: String::from_utf8_lossy(&output.name).into_owned(),
                position_px: (crtc.x.into(), crtc.y.into()),
                size_px: (crtc.width.into(), crtc.height.into()),
                is_primary: id == primary,
                is_virtual: false,
            })
        };
        Some(resources.crtcs.into_iter().filter_map(output).filter(|output| output.size_px != (0, 0)).collect())
    }

    /// What RandR 1.5 calls monitors: one for each output, and those that a user named. The latter may share an
    /// output's place, have a part of it, or none.
    fn named_monitors(&self) -> Option<Vec<MonitorInfo>> {
        let version = self.connection.randr_query_version(1, 5).ok()?.reply().ok()?;
        if (version.major_version, version.minor_version) < (1, 5) {
            return None;
        }
        let found = self.connection.randr_get_monitors(self.root, false).ok()?.reply().ok()?;
        let monitor = |monitor: MonitorReply| {
            let name = self.connection.get_atom_name(monitor.name).ok()?.reply().ok()?.name;
            Some(MonitorInfo {
                name: String::from_utf8_lossy(&name).into_owned(),
                position_px: (monitor.x.into(), monitor.y.into()),
                size_px: (monitor.width.into(), monitor.height.into()),
                is_primary: monitor.primary,
                is_virtual: !monitor.automatic,
            })
        };
        // Those without outputs, as half a picture wall is, do not count as active.
        Some(found.monitors.into_iter().filter_map(monitor).filter(|monitor| monitor.size_px != (0, 0)).collect())
    }

    /// Xinerama's heads; they have no names, and the first is the primary one.
    fn heads(&self) -> Option<Vec<MonitorInfo>> {
        self.connection.extension_information(xinerama::X11_EXTENSION_NAME).ok()??;
        let is_active = self.connection.xinerama_is_active().ok()?.reply().ok()?.state != 0;
        let heads = self.connection.xinerama_query_screens().ok()?.reply().ok()?.screen_info;
        let head = |(index, head): (usize, ScreenInfo)| MonitorInfo {
            name: format!("head-{index}"),
            position_px: (head.x_org.into(), head.y_org.into()),
            size_px: (head.width.into(), head.height.into()),
            is_primary: index == 0,
            is_virtual: false,
        };
        Some(heads.into_iter().enumerate().map(head).filter(|_| is_active).collect())
    }

    fn atom(&self, name: &str) -> Option<u32> {
        let cookie = self.connection.intern_atom(false, name.as_bytes()).ok()?;
        Some(cookie.reply().ok()?.atom)
    }

    fn property(&self, window: Window, property: u32, kind: AtomEnum) -> Option<Vec<u32>> {
        let cookie = self.connection.get_property(false, window, property, kind, 0, 4096).ok()?;
        Some(cookie.reply().ok()?.value32()?.collect())
    }
}
