//! A monitor's mode and the projector's window on it, for a diagnosis.

use x11rb::protocol::xproto::{AtomEnum, ConnectionExt as _, Window};

use super::modes::OutputModes;
use super::place::WINDOW_CLASS;
use super::session::X11Session;
use crate::error::WindowError;
use crate::monitor::MonitorInfo;
use crate::report::{MonitorReport, WindowPlace};
use crate::watch::DesktopRect;

/// Inspects a monitor, and the windows of this package's programs or, with a title, those that have it.
///
/// # Errors
/// [`WindowError::NoDisplay`] without an X server.
pub(crate) fn inspect(monitor: &MonitorInfo, title: Option<&str>) -> Result<MonitorReport, WindowError> {
    let session = X11Session::open()?;
    let modes = session.output_modes(&monitor.name);
    let other_mode = modes.as_ref().filter(|modes| !modes.is_native()).map(OutputModes::native_and_current);
    let is_wanted = |window: &Window| match title {
        Some(title) => session.has_title(*window, title),
        None => session.is_own(*window),
    };
    let windows = session.windows().into_iter().filter(|window| session.is_viewable(*window)).filter(is_wanted);
    let places: Vec<DesktopRect> = windows.filter_map(|window| session.place_of(window)).collect();
    let window = match places.first() {
        _ if places.iter().any(|place| place.covers(monitor)) => WindowPlace::Over,
        Some(place) => WindowPlace::Elsewhere(place.to_string()),
        None => WindowPlace::Missing,
    };
    Ok(MonitorReport { other_mode, is_scaled: modes.is_some_and(|modes| modes.is_scaled), window })
}

impl X11Session {
    /// The windows that a window manager lists, and the root window's children, which include those that are not
    /// managed.
    fn windows(&self) -> Vec<Window> {
        let listed = || self.property(self.root(), self.atom("_NET_CLIENT_LIST")?, AtomEnum::WINDOW);
        let children = || Some(self.connection.query_tree(self.root()).ok()?.reply().ok()?.children);
        listed().into_iter().chain(children()).flatten().collect()
    }

    /// `true` if a window is one of this package's.
    fn is_own(&self, window: Window) -> bool {
        let (property, kind) = (AtomEnum::WM_CLASS, AtomEnum::STRING);
        let class = || self.connection.get_property(false, window, property, kind, 0, 64).ok()?.reply().ok();
        class().is_some_and(|class| class.value == WINDOW_CLASS)
    }
}
