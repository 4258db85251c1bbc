//! Refresh times of a monitor by the extension Present: the server reports the number of the last refresh and its time
//! (MSC and UST, in microseconds of the kernel's monotonic clock, which [`Instant`] reads as well).

use std::time::{Duration, Instant};

use rustix::time::{clock_gettime, ClockId};
use x11rb::connection::{Connection, RequestConnection};
use x11rb::protocol::present::{self, CompleteKind, CompleteNotifyEvent, ConnectionExt as _, EventMask};
use x11rb::protocol::xproto::Window;

use super::session::X11Session;
use crate::refresh::Refresh;

/// Largest difference of a reported time from now; a time beyond it is of another clock.
const MAX_DIFFERENCE: Duration = Duration::from_secs(10);

/// Measures the refreshes of a window's monitor.
pub(super) struct RefreshWatch {
    window: Window,
    /// Time between two refreshes by the monitor's mode; `None` for a virtual screen.
    nominal: Option<Duration>,
    first: Option<(u64, u64)>,
    refresh: Option<Refresh>,
}

impl RefreshWatch {
    /// A measurement for a window; `nominal` is the time between two refreshes by its monitor's mode.
    pub(super) fn new(session: &X11Session, window: Window, nominal: Option<Duration>) -> Self {
        let select = || {
            session.connection.extension_information(present::X11_EXTENSION_NAME).ok()??;
            let id = session.connection.generate_id().ok()?;
            session.connection.present_select_input(id, window, EventMask::COMPLETE_NOTIFY).ok()?.check().ok()
        };
        let nominal = nominal.filter(|_| select().is_some());
        Self { window, nominal, first: None, refresh: None }
    }

    /// Requests the last refresh.
    pub(super) fn request(&self, session: &X11Session) {
        if self.nominal.is_some() {
            // Without an answer the last one counts.
            let _ = session.connection.present_notify_msc(self.window, 0, 0, 0, 0);
            let _ = session.connection.flush();
        }
    }

    /// Takes the server's answer.
    pub(super) fn take(&mut self, event: &CompleteNotifyEvent) {
        let (CompleteKind::NOTIFY_MSC, Some(nominal), Some(at)) = (event.kind, self.nominal, instant(event.ust)) else {
            return;
        };
        let (first_ust, first_msc) = *self.first.get_or_insert((event.ust, event.msc));
        let count = u32::try_from(event.msc.saturating_sub(first_msc)).unwrap_or(0);
        let passed = Duration::from_micros(event.ust.saturating_sub(first_ust));
        let measured = passed.checked_div(count).filter(|measured| is_near(*measured, nominal));
        self.refresh = Refresh::new(at, measured.unwrap_or(nominal));
    }

    /// The monitor's refresh, if the server has reported it.
    pub(super) fn refresh(&self) -> Option<Refresh> {
        self.refresh
    }
}

fn is_near(measured: Duration, nominal: Duration) -> bool {
    measured.abs_diff(nominal) < nominal / 20
}

/// A time of the kernel's monotonic clock, in microseconds.
fn instant(ust: u64) -> Option<Instant> {
    let (now, clock) = (Instant::now(), clock_gettime(ClockId::Monotonic));
    let clock = Duration::new(u64::try_from(clock.tv_sec).ok()?, u32::try_from(clock.tv_nsec).ok()?);
    let ust = Duration::from_micros(ust);
    if clock.abs_diff(ust) > MAX_DIFFERENCE {
        return None;
    }
    if ust > clock {
        now.checked_add(ust - clock)
    } else {
        now.checked_sub(clock - ust)
    }
}
