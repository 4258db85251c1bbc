//! Changes of the window's monitor: its mode, position and presence. Shared by all window systems.

use std::time::Instant;

use crate::coverage::{CoverageStep, CoverageWatch};
use crate::monitor::MonitorInfo;

/// State of the window's monitor between two checks.
#[derive(Debug, Clone)]
pub(crate) struct MonitorWatch {
    monitor: MonitorInfo,
    is_gone: bool,
    coverage: CoverageWatch,
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
        Self { monitor, is_gone: false, coverage: CoverageWatch::new(now) }
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
        self.coverage.next_poll()
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
        let is_in_place = place.is_some_and(|place| place.covers(&self.monitor));
        let was_settling = self.coverage.is_settling(now);
        let action = match self.coverage.poll(now, !self.is_gone, is_in_place) {
            CoverageStep::Nothing => WindowAction::Leave,
            CoverageStep::CoverAgain => WindowAction::CoverAgain,
            CoverageStep::WarnMisplaced => {
                let place = place.map_or_else(|| "not on the screen".to_owned(), |place| place.to_string());
                log::warn!(
                    "THE WINDOW DOES NOT COVER ITS MONITOR: it is {place}, the monitor {}; the projection does not fit",
                    self.monitor
                );
                WindowAction::Leave
            }
            CoverageStep::WarnMonitorGone => {
                log::warn!("monitor {} is gone; waiting for it", self.monitor);
                WindowAction::Hide
            }
        };
        let has_settled = was_settling && !self.coverage.is_settling(self.coverage.next_poll());
        MonitorCheck { is_changed, action, has_settled }
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

    fn covers(self, monitor: &MonitorInfo) -> bool {
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
    use std::time::Duration;

    use super::*;

    fn monitor(width_px: u32) -> MonitorInfo {
        MonitorInfo { name: "HDMI-1".to_owned(), size_px: (width_px, 800), ..MonitorInfo::default() }
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
