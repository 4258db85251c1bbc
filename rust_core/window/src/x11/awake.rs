//! Keeps the screen from blanking while the window is open.
//!
//! With the extension MIT-SCREEN-SAVER the timers of screen saver and power saving are suspended; the server ends that
//! with the connection. Without it both are switched off, and restored at the end. A sleeping monitor is woken. Screen
//! lockers watch the time of the last input, which is reset periodically.

use std::time::{Duration, Instant};

use x11rb::connection::{Connection, RequestConnection};
use x11rb::protocol::dpms::{self, ConnectionExt as _, DPMSMode};
use x11rb::protocol::screensaver::{self, ConnectionExt as _};
use x11rb::protocol::xproto::{Blanking, ConnectionExt as _, Exposures, GetScreenSaverReply, ScreenSaver};

use super::session::X11Session;

/// Period of resetting the time of the last input, shorter than any locker's timeout.
const PERIOD: Duration = Duration::from_secs(30);

/// Keeps the screen awake.
pub(super) struct Awake {
    next: Instant,
    /// The timers that were switched off because they could not be suspended.
    switched_off: Option<Timers>,
}

struct Timers {
    screen_saver: Option<GetScreenSaverReply>,
    had_power_saving: bool,
}

impl Awake {
    /// Keeps the screen awake from now on.
    pub(super) fn start(session: &X11Session, now: Instant) -> Self {
        let switched_off = (!suspend(session)).then(|| switch_off(session));
        let mut awake = Self { next: now, switched_off };
        awake.keep(session, now);
        awake
    }

    /// Wakes the screen, if that is due.
    pub(super) fn keep(&mut self, session: &X11Session, now: Instant) {
        if now < self.next {
            return;
        }
        self.next = now + PERIOD;
        // A request fails where there is nothing to wake.
        let _ = session.connection.force_screen_saver(ScreenSaver::RESET);
        if power_saving(session).is_some_and(|info| info.state && info.power_level != DPMSMode::ON) {
            let _ = session.connection.dpms_force_level(DPMSMode::ON);
        }
    }

    /// Restores timers that were switched off.
    pub(super) fn end(&self, session: &X11Session) {
        let Some(timers) = &self.switched_off else { return };
        if let Some(saver) = &timers.screen_saver {
            let seconds = |time: u16| i16::try_from(time).unwrap_or(-1);
            let (timeout, interval) = (seconds(saver.timeout), seconds(saver.interval));
            let (blanking, exposures) = (saver.prefer_blanking, saver.allow_exposures);
            let _ = session.connection.set_screen_saver(timeout, interval, blanking, exposures);
        }
        if timers.had_power_saving {
            let _ = session.connection.dpms_enable();
        }
        let _ = session.connection.flush();
    }
}

fn suspend(session: &X11Session) -> bool {
    let suspend = || {
        session.connection.extension_information(screensaver::X11_EXTENSION_NAME).ok()??;
        session.connection.screensaver_query_version(1, 1).ok()?.reply().ok()?;
        session.connection.screensaver_suspend(1).ok()?.check().ok()
    };
    suspend().is_some()
}

fn switch_off(session: &X11Session) -> Timers {
    let screen_saver = session.connection.get_screen_saver().ok().and_then(|cookie| cookie.reply().ok());
    let _ = session.connection.set_screen_saver(0, 0, Blanking::DEFAULT, Exposures::DEFAULT);
    let had_power_saving = power_saving(session).is_some_and(|info| info.state);
    if had_power_saving {
        let _ = session.connection.dpms_disable();
    }
    Timers { screen_saver, had_power_saving }
}

fn power_saving(session: &X11Session) -> Option<dpms::InfoReply> {
    session.connection.extension_information(dpms::X11_EXTENSION_NAME).ok()??;
    session.connection.dpms_info().ok()?.reply().ok()
}
