//! The window on a Wayland compositor, over a connection in Rust.
//!
//! The compositor makes the surface full screen on the chosen output. The image has the pixels of the output's mode;
//! with the viewport protocol they fill the surface one to one, independent of the desktop's scale factor.

mod keymap;
mod outputs;
mod state;
mod window;

pub(crate) use window::WaylandWindow;

use crate::error::WindowError;
use crate::monitor::MonitorInfo;
use crate::report::MonitorMode;

/// `true` if the environment names a compositor.
pub(crate) fn is_named() -> bool {
    let is_set = |name| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    is_set("WAYLAND_DISPLAY") || is_set("WAYLAND_SOCKET")
}

/// The monitors, in the compositor's order.
///
/// # Errors
/// [`WindowError::NoDisplay`].
pub(crate) fn monitors() -> Result<Vec<MonitorInfo>, WindowError> {
    Ok(state::WaylandSession::open()?.state.outputs.monitors())
}

/// Native and current mode of a monitor that runs another mode than its native one.
///
/// # Errors
/// [`WindowError::NoDisplay`].
pub(crate) fn other_mode(name: &str) -> Result<Option<[MonitorMode; 2]>, WindowError> {
    Ok(state::WaylandSession::open()?.state.outputs.other_mode(name))
}
