//! Keeping the window over its monitor.
//!
//! A window system needs a moment to place a new window. Later the monitor may change its mode, or vanish and come back
//! (a projector that is switched off and on), and window managers then leave the window on another monitor. The window is
//! polled, often at first and every two seconds later, and [`CoverageWatch`] decides what to do. It is independent of the
//! window system, for tests.

use std::time::{Duration, Instant};

/// Time in which the window system places the window.
const SETTLE_TIME: Duration = Duration::from_millis(1500);
/// Poll period while the window settles.
const SETTLE_PERIOD: Duration = Duration::from_millis(100);
/// Poll period later.
const WATCH_PERIOD: Duration = Duration::from_secs(2);
/// Attempts in a row to place the window.
const MAX_ATTEMPTS: u32 = 3;

/// Reaction to a poll.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum CoverageStep {
    /// No reaction.
    Nothing,
    /// Place the window on its monitor again.
    CoverAgain,
    /// Warn that the window does not cover its monitor.
    WarnMisplaced,
    /// Warn that the monitor is gone.
    WarnMonitorGone,
}

/// State between two polls.
#[derive(Debug, Clone)]
pub(crate) struct CoverageWatch {
    placed_at: Instant,
    next_poll: Instant,
    attempts: u32,
    has_warned: bool,
    is_gone: bool,
}

impl CoverageWatch {
    /// A watch for a window that was just opened.
    pub(crate) fn new(now: Instant) -> Self {
        Self { placed_at: now, next_poll: now, attempts: 0, has_warned: false, is_gone: false }
    }

    /// Time of the next poll.
    pub(crate) fn next_poll(&self) -> Instant {
        self.next_poll
    }

    /// `true` while the window system still has time to place the window.
    pub(crate) fn is_settling(&self, now: Instant) -> bool {
        now < self.placed_at + SETTLE_TIME
    }

    /// The reaction, given whether the monitor exists and whether the window covers it exactly.
    pub(crate) fn poll(&mut self, now: Instant, is_monitor_there: bool, is_in_place: bool) -> CoverageStep {
        let step = self.step(now, is_monitor_there, is_in_place);
        self.next_poll = now + if self.is_settling(now) { SETTLE_PERIOD } else { WATCH_PERIOD };
        step
    }

    fn step(&mut self, now: Instant, is_monitor_there: bool, is_in_place: bool) -> CoverageStep {
        let was_gone = std::mem::replace(&mut self.is_gone, !is_monitor_there);
        if !is_monitor_there {
            return if was_gone { CoverageStep::Nothing } else { CoverageStep::WarnMonitorGone };
        }
        if was_gone || is_in_place {
            self.attempts = 0;
            self.has_warned = false;
        }
        if is_in_place || (self.is_settling(now) && !was_gone) {
            return CoverageStep::Nothing;
        }
        if self.attempts < MAX_ATTEMPTS {
            self.attempts += 1;
            self.placed_at = now;
            return CoverageStep::CoverAgain;
        }
        if std::mem::replace(&mut self.has_warned, true) {
            return CoverageStep::Nothing;
        }
        CoverageStep::WarnMisplaced
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Polls `polls` times, each when it is due; the steps other than [`CoverageStep::Nothing`].
    fn steps(watch: &mut CoverageWatch, polls: usize, there: bool, in_place: bool) -> Vec<CoverageStep> {
        let poll = |_| {
            let now = watch.next_poll();
            watch.poll(now, there, in_place)
        };
        (0..polls).map(poll).filter(|step| *step != CoverageStep::Nothing).collect()
    }

    #[test]
    fn a_window_in_its_place_is_left_alone_and_polled_seldom() {
        let start = Instant::now();
        let mut watch = CoverageWatch::new(start);
        assert_eq!(steps(&mut watch, 30, true, true), []);
        let before = watch.next_poll();
        watch.poll(before, true, true);
        assert_eq!(watch.next_poll() - before, WATCH_PERIOD);
    }

    #[test]
    fn the_window_system_has_time_before_the_window_is_put_in_its_place_again() {
        let start = Instant::now();
        let mut watch = CoverageWatch::new(start);
        assert_eq!(watch.poll(start + SETTLE_TIME / 2, true, false), CoverageStep::Nothing);
        assert_eq!(watch.poll(start + SETTLE_TIME, true, false), CoverageStep::CoverAgain);
        assert_eq!(watch.poll(start + SETTLE_TIME * 3 / 2, true, false), CoverageStep::Nothing);
    }

    #[test]
    fn a_window_that_stays_misplaced_is_warned_about_once() {
        let mut watch = CoverageWatch::new(Instant::now());
        let mut expected = vec![CoverageStep::CoverAgain; 3];
        expected.push(CoverageStep::WarnMisplaced);
        assert_eq!(steps(&mut watch, 200, true, false), expected);
        assert_eq!(steps(&mut watch, 1, true, true), []);
        assert_eq!(steps(&mut watch, 200, true, false), expected, "after a good time it is tried again");
    }

    #[test]
    fn a_monitor_that_vanishes_is_warned_about_once_and_covered_when_it_is_back() {
        let mut watch = CoverageWatch::new(Instant::now());
        assert_eq!(steps(&mut watch, 40, true, true), []);
        assert_eq!(steps(&mut watch, 40, false, false), [CoverageStep::WarnMonitorGone]);
        assert_eq!(steps(&mut watch, 1, true, false), [CoverageStep::CoverAgain]);
        assert_eq!(steps(&mut watch, 40, true, true), []);
    }
}
