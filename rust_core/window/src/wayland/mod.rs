//! The window on a Wayland compositor, over a connection of its own in Rust.
//!
//! The compositor makes the surface full screen on the output that is asked for. The picture has as many pixels as the
//! output's mode; the viewport protocol says that they fill the surface, so that each is one of the output's, whatever
//! the desktop's scale factor.

mod keymap;
mod outputs;
mod state;
mod window;

pub(crate) use window::WaylandWindow;

use crate::monitor::MonitorInfo;
use crate::WindowError;

/// Whether the environment names a compositor.
pub(crate) fn is_named() -> bool {
    let is_set = |name| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    is_set("WAYLAND_DISPLAY") || is_set("WAYLAND_SOCKET")
}

/// The monitors, in the order in which the compositor names them.
///
/// # Errors
/// [`WindowError::NoDisplay`].
pub(crate) fn monitors() -> Result<Vec<MonitorInfo>, WindowError> {
    Ok(state::Session::open()?.state.outputs.monitors())
}
