//! Keeps the window of another program over a monitor: full screen if there is a window manager, without decoration.
//!
//! The window is found by its title, in the window manager's list (EWMH's `_NET_CLIENT_LIST`), or without a window
//! manager among the root window's children.

use std::thread::sleep;
use std::time::{Duration, Instant};

use x11rb::connection::Connection;
use x11rb::protocol::xproto::{AtomEnum, ConnectionExt as _, MapState, PropMode, StackMode, Window};
use x11rb::wrapper::ConnectionExt as _;

use super::session::X11Session;
use crate::error::WindowError;
use crate::monitor::{MonitorChoice, MonitorError, MonitorInfo};
use crate::watch::DesktopRect;

/// Poll period.
const PERIOD: Duration = Duration::from_millis(200);
/// Time in which a window manager places the window.
const SETTLE_TIME: Duration = Duration::from_millis(800);
/// Attempts to place the window before a warning.
const MAX_ATTEMPTS: u32 = 5;

/// The window that is kept over the monitor.
struct KeptWindow {
    window: Window,
    attempts: u32,
    next: Instant,
}

/// Keeps the window with this title over a monitor until `is_ending`.
///
/// # Errors
/// [`WindowError`] when there is no X server, or when it goes away.
pub(crate) fn keep_over(title: &str, choice: &MonitorChoice, is_ending: &dyn Fn() -> bool) -> Result<(), WindowError> {
    let session = X11Session::open()?;
    let mut kept: Option<KeptWindow> = None;
    let mut last_error: Option<MonitorError> = None;
    while !is_ending() {
        session.connection.sync().map_err(X11Session::lost)?;
        match session.monitor(choice) {
            Ok(monitor) => {
                last_error = None;
                kept = keep(&session, title, &monitor, kept)?;
            }
            Err(error) if last_error.as_ref() == Some(&error) => {}
            Err(error) => {
                log::warn!("{error}; waiting for it");
                last_error = Some(error);
            }
        }
        sleep(PERIOD);
    }
    Ok(())
}

/// Checks the window once.
fn keep(
    session: &X11Session,
    title: &str,
    monitor: &MonitorInfo,
    kept: Option<KeptWindow>,
) -> Result<Option<KeptWindow>, WindowError> {
    let Some(window) = session.window_titled(title) else { return Ok(None) };
    let now = Instant::now();
    let mut kept = kept.filter(|kept| kept.window == window).unwrap_or_else(|| {
        log::info!("window '{title}' on monitor {monitor}");
        session.undecorate(window);
        KeptWindow { window, attempts: 0, next: now }
    });
    let wanted = DesktopRect { position_px: Some(monitor.position_px), size_px: monitor.size_px };
    if session.place_of(window) == Some(wanted) {
        kept.attempts = 0;
    } else if now >= kept.next && kept.attempts < MAX_ATTEMPTS {
        kept.attempts += 1;
        kept.next = now + SETTLE_TIME;
        session.cover_again(window, monitor, !session.has_fullscreen_manager(), Some(StackMode::ABOVE))?;
    } else if now >= kept.next && kept.attempts == MAX_ATTEMPTS {
        kept.attempts += 1;
        log::warn!("WINDOW '{title}' DOES NOT COVER MONITOR {monitor}: its program does not let it");
    }
    Ok(Some(kept))
}

impl X11Session {
    fn monitor(&self, choice: &MonitorChoice) -> Result<MonitorInfo, MonitorError> {
        let mut monitors = self.monitors();
        let index = choice.resolve(&monitors)?;
        Ok(monitors.swap_remove(index))
    }

    /// The newest window on the screen with this title.
    fn window_titled(&self, title: &str) -> Option<Window> {
        let listed = || self.property(self.root(), self.atom("_NET_CLIENT_LIST")?, AtomEnum::WINDOW);
        let children = || Some(self.connection.query_tree(self.root()).ok()?.reply().ok()?.children);
        let windows = if self.has_fullscreen_manager() { listed() } else { children() }?;
        windows.into_iter().rev().find(|window| self.is_viewable(*window) && self.has_title(*window, title))
    }

    pub(super) fn is_viewable(&self, window: Window) -> bool {
        self.map_state(window) == Some(MapState::VIEWABLE)
    }

    pub(super) fn has_title(&self, window: Window, title: &str) -> bool {
        let is_title = |property: u32| {
            let cookie = self.connection.get_property(false, window, property, AtomEnum::ANY, 0, 1024).ok()?;
            Some(cookie.reply().ok()?.value == title.as_bytes())
        };
        let names = [self.atom("_NET_WM_NAME"), Some(AtomEnum::WM_NAME.into())];
        names.into_iter().flatten().any(|property| is_title(property).unwrap_or(false))
    }

    /// Asks the window manager for no title bar and no border.
    fn undecorate(&self, window: Window) {
        let Some(motif) = self.atom("_MOTIF_WM_HINTS") else { return };
        // On failure a border remains, which full screen hides.
        let _ = self.connection.change_property32(PropMode::REPLACE, window, motif, motif, &[2, 0, 0, 0, 0]);
        let _ = self.connection.flush();
    }
}
