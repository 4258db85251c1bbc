//! Opening the window, on Wayland or X11.

use crate::dead_man::DeadManSwitch;
use crate::error::WindowError;
use crate::monitor::{MonitorChoice, MonitorInfo};
use crate::report::MonitorReport;
use crate::run::{run as run_window, UserEvent};
use crate::sink::ImageSink;
use crate::system_window::{SystemWindow, WindowOptions};
use crate::wayland::{self, WaylandWindow};
use crate::x11::{self, X11Session, X11Window};

/// Opens the window and shows the sink's images, each while its grant holds, until it is closed. Keys except Escape
/// and q are left to the program. `handle` is called on this thread for each event, the first of which is
/// [`UserEvent::Opened`]; it must not block.
///
/// # Errors
/// [`WindowError`] when there is no display, no such monitor, or the window system refuses the window or goes away.
pub fn run_with(
    options: &WindowOptions,
    sink: &ImageSink,
    mut handle: impl FnMut(UserEvent<'_>, &ImageSink),
) -> Result<(), WindowError> {
    // Before the window, which is to lie on the black one of the child process; it ends after it.
    let mut switch = DeadManSwitch::start(options, sink);
    run_window(open(options)?.as_mut(), options, (sink, &mut switch), &mut handle)
}

/// Opens the window and runs it until it is closed, as [`run_with`] does, with a sink of its own. `handle` may show
/// images at once.
///
/// # Errors
/// As for [`run_with`].
pub fn run_interactive(
    options: &WindowOptions,
    handle: impl FnMut(UserEvent<'_>, &ImageSink),
) -> Result<(), WindowError> {
    run_with(options, &ImageSink::new()?, handle)
}

/// Opens a window on Wayland if the environment names a compositor, else on X11.
fn open(options: &WindowOptions) -> Result<Box<dyn SystemWindow>, WindowError> {
    Ok(if wayland::is_named() { Box::new(WaylandWindow::open(options)?) } else { Box::new(X11Window::open(options)?) })
}

/// Keeps another program's window of this title over a monitor until `is_ending`: full screen, without decoration. The
/// window may open, close and open again. On X11 only.
///
/// # Errors
/// [`WindowError::NoDisplay`] without an X server, [`WindowError::Lost`] when it goes away.
pub fn keep_over(title: &str, monitor: &MonitorChoice, is_ending: impl Fn() -> bool) -> Result<(), WindowError> {
    x11::keep_over(title, monitor, &is_ending)
}

/// All monitors, in the order of [`MonitorChoice`]'s numbers.
///
/// # Errors
/// [`WindowError::NoDisplay`] when there is no display.
pub fn list_monitors() -> Result<Vec<MonitorInfo>, WindowError> {
    if wayland::is_named() {
        return wayland::monitors();
    }
    Ok(X11Session::open()?.monitors())
}

/// Inspects a monitor, and the windows of this package's programs, or those with a title. May wait for the window
/// system without limit.
///
/// # Errors
/// [`WindowError::NoDisplay`] when there is no display.
pub fn inspect_monitor(monitor: &MonitorInfo, title: Option<&str>) -> Result<MonitorReport, WindowError> {
    if wayland::is_named() {
        let other_mode = wayland::other_mode(&monitor.name)?;
        return Ok(MonitorReport { other_mode, ..MonitorReport::default() });
    }
    x11::inspect(monitor, title)
}
