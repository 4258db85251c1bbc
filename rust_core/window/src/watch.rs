//! The window's monitor: its mode, position and presence, and keeping the window over it. Shared by all window systems.
//!
//! A window system needs a moment to place a new window. Later the monitor may change its mode, or vanish and come back
//! (a projector that is switched off and on), and window managers then leave the window on another monitor. The window
//! is checked often at first and every two seconds later.

use std::time::{Duration, Instant};

use crate::monitor::MonitorInfo;

/// Time in which the window system places the window.
const SETTLE_TIME: Duration = Duration::from_millis(1500);
/// Period of checks while the window settles.
const SETTLE_PERIOD: Duration = Duration::from_millis(100);
/// Period of later checks.
const WATCH_PERIOD: Duration = Duration::from_secs(2);
/// Attempts in a row to place the window.
const MAX_ATTEMPTS: u32 = 3;

/// State of the window's monitor between two checks.
#[derive(Debug, Clone)]
pub(crate) struct MonitorWatch {
    monitor: MonitorInfo,
    is_gone: bool,
    placed_at: Instant,
    next_check: Instant,
    attempts: u32,
    has_warned: bool,
}

/// Result of a check.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct MonitorCheck {
    /// `true` if the monitor's position or size changed.
    pub(crate) is_changed: bool,
    /// The action on the window.
    pub(crate) action: WindowAction,
    /// `true` at the end of the time in which the window system places the window.
    pub(crate) has_settled: bool,
}

/// An action on the window.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum WindowAction {
    /// No action.
    Leave,
    /// Place it on its monitor again.
    CoverAgain,
    /// Hide it: its monitor is gone, and it must not appear on another one.
    Hide,
}

impl MonitorWatch {
    /// A watch for a window that was just opened on this monitor.
    pub(crate) fn new(monitor: MonitorInfo, now: Instant) -> Self {
        Self { monitor, is_gone: false, placed_at: now, next_check: now, attempts: 0, has_warned: false }
    }

    /// The monitor at the last check.
    pub(crate) fn monitor(&self) -> &MonitorInfo {
        &self.monitor
    }

    /// `true` if the monitor is present.
    pub(crate) fn is_there(&self) -> bool {
        !self.is_gone
    }

    /// Time of the next check.
    pub(crate) fn next_check(&self) -> Instant {
        self.next_check
    }

    /// `true` while the window system places the window.
    pub(crate) fn is_settling(&self, now: Instant) -> bool {
        now < self.placed_at + SETTLE_TIME
    }

    /// Checks the window's place against the monitor of the same name among `found`. `place` is `None` while the window
    /// is not on the screen.
    pub(crate) fn check(&mut self, now: Instant, found: &[MonitorInfo], place: Option<DesktopRect>) -> MonitorCheck {
        let known = found.iter().find(|info| info.name == self.monitor.name);
        let was_gone = std::mem::replace(&mut self.is_gone, known.is_none());
        let is_same = |info: &MonitorInfo| DesktopRect::of(info) == DesktopRect::of(&self.monitor);
        let is_changed = known.is_some_and(|info| !is_same(info));
        if let Some(known) = known {
            self.monitor.clone_from(known);
        }
        if was_gone && !self.is_gone {
            log::info!("monitor {} is back", self.monitor);
        } else if is_changed {
            log::info!("the monitor is now {}", self.monitor);
        }
        let was_settling = self.is_settling(now);
        let action = self.action(now, was_gone, place);
        self.next_check = now + if self.is_settling(now) { SETTLE_PERIOD } else { WATCH_PERIOD };
        MonitorCheck { is_changed, action, has_settled: was_settling && !self.is_settling(self.next_check) }
    }

    fn action(&mut self, now: Instant, was_gone: bool, place: Option<DesktopRect>) -> WindowAction {
        if self.is_gone && was_gone {
            return WindowAction::Leave;
        }
        if self.is_gone {
            log::warn!("monitor {} is gone; waiting for it", self.monitor);
            return WindowAction::Hide;
        }
        let is_in_place = place.is_some_and(|place| place.covers(&self.monitor));
        if was_gone || is_in_place {
            self.attempts = 0;
            self.has_warned = false;
        }
        if is_in_place || (self.is_settling(now) && !was_gone) {
            return WindowAction::Leave;
        }
        if self.attempts < MAX_ATTEMPTS {
            self.attempts += 1;
            self.placed_at = now;
            return WindowAction::CoverAgain;
        }
        if !std::mem::replace(&mut self.has_warned, true) {
            let place = place.map_or_else(|| "not on the screen".to_owned(), |place| place.to_string());
            log::warn!(
                "THE WINDOW DOES NOT COVER ITS MONITOR: it is {place}, the monitor {}; the projection does not fit",
                self.monitor
            );
        }
        WindowAction::Leave
    }
}

/// A rectangle in the desktop.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct DesktopRect {
    /// `None` where the window system does not report it.
    pub(crate) position_px: Option<(i32, i32)>,
    pub(crate) size_px: (u32, u32),
}

impl DesktopRect {
    fn of(monitor: &MonitorInfo) -> Self {
        Self { position_px: Some(monitor.position_px), size_px: monitor.size_px }
    }

    pub(crate) fn covers(self, monitor: &MonitorInfo) -> bool {
        self.size_px == monitor.size_px && self.position_px.is_none_or(|position| position == monitor.position_px)
    }
}

impl std::fmt::Display for DesktopRect {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (width, height) = self.size_px;
        let (x, y) = self.position_px.unwrap_or_default();
        write!(f, "{width}x{height}{x:+}{y:+}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn monitor(width_px: u32) -> MonitorInfo {
        MonitorInfo { name: "HDMI-1".to_owned(), size_px: (width_px, 800), ..MonitorInfo::default() }
    }

    /// Checks `checks` times, each when it is due; the actions other than [`WindowAction::Leave`].
    fn actions(watch: &mut MonitorWatch, checks: usize, is_there: bool, is_in_place: bool) -> Vec<WindowAction> {
        let found = [monitor(1280)];
        let found = if is_there { &found[..] } else { &[] };
        let size_px = if is_in_place { (1280, 800) } else { (640, 480) };
        let place = Some(DesktopRect { position_px: Some((0, 0)), size_px });
        let check = |_| watch.check(watch.next_check(), found, place).action;
        (0..checks).map(check).filter(|action| *action != WindowAction::Leave).collect()
    }

    #[test]
    fn a_window_in_its_place_is_left_alone_and_checked_seldom() {
        let mut watch = MonitorWatch::new(monitor(1280), Instant::now());
        assert_eq!(actions(&mut watch, 30, true, true), []);
        let before = watch.next_check();
        assert_eq!(actions(&mut watch, 1, true, true), []);
        assert_eq!(watch.next_check() - before, WATCH_PERIOD);
    }

    #[test]
    fn the_window_system_has_time_before_the_window_is_placed_again() {
        let start = Instant::now();
        let mut watch = MonitorWatch::new(monitor(1280), start);
        let mut action = |time| watch.check(start + time, &[monitor(1280)], None).action;
        assert_eq!(action(SETTLE_TIME / 2), WindowAction::Leave);
        assert_eq!(action(SETTLE_TIME), WindowAction::CoverAgain);
        assert_eq!(action(SETTLE_TIME * 3 / 2), WindowAction::Leave);
    }

    #[test]
    fn a_window_that_stays_misplaced_is_warned_about_once() {
        let mut watch = MonitorWatch::new(monitor(1280), Instant::now());
        let expected = [WindowAction::CoverAgain; 3];
        assert_eq!(actions(&mut watch, 200, true, false), expected);
        assert!(watch.has_warned);
        assert_eq!(actions(&mut watch, 1, true, true), []);
        assert!(!watch.has_warned);
        assert_eq!(actions(&mut watch, 200, true, false), expected, "after a good time it is tried again");
    }

    #[test]
    fn a_monitor_that_vanishes_is_warned_about_once_and_covered_when_it_is_back() {
        let mut watch = MonitorWatch::new(monitor(1280), Instant::now());
        assert_eq!(actions(&mut watch, 40, true, true), []);
        assert_eq!(actions(&mut watch, 40, false, false), [WindowAction::Hide]);
        assert_eq!(actions(&mut watch, 1, true, false), [WindowAction::CoverAgain]);
        assert_eq!(actions(&mut watch, 40, true, true), []);
    }

    #[test]
    fn a_window_whose_monitor_is_gone_is_hidden_and_put_back_on_the_monitor_as_it_returns() {
        let start = Instant::now();
        let later = |seconds: u64| start + Duration::from_secs(seconds);
        let mut watch = MonitorWatch::new(monitor(1280), start);
        let covered = Some(DesktopRect { position_px: Some((0, 0)), size_px: (1280, 800) });
        assert_eq!(watch.check(later(3), &[monitor(1280)], covered).action, WindowAction::Leave);
        assert_eq!(watch.check(later(5), &[], covered).action, WindowAction::Hide);
        assert!(!watch.is_there());
        assert_eq!(watch.check(later(7), &[], None).action, WindowAction::Leave);
        let back = watch.check(later(9), &[monitor(1024)], None);
        assert_eq!((back.action, back.is_changed), (WindowAction::CoverAgain, true));
        assert_eq!(watch.monitor().size_px, (1024, 800));
    }
}
