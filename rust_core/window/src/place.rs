//! When the window has to be put on its monitor again.
//!
//! A window system needs a moment to put a new window in its place. Later the monitor may change its mode, or vanish
//! and come back (a projector that is switched off and on), and window managers then leave the window on another
//! monitor. [`Placement`] is asked at every look at the window, often at first and every two seconds later, what is to
//! be done. It knows no window system, so that it can be tested without one.

use std::time::{Duration, Instant};

/// How long the window system has to put the window in its place.
const SETTLE_TIME: Duration = Duration::from_millis(1500);
/// Time between looks while the window settles.
const SETTLE_PERIOD: Duration = Duration::from_millis(100);
/// Time between looks later.
const WATCH_PERIOD: Duration = Duration::from_secs(2);
/// How many times in a row the window is placed again before that is given up.
const MOST_ATTEMPTS: u32 = 3;

/// What is to be done.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum PlaceStep {
    /// Nothing.
    Nothing,
    /// Put the window on its monitor again.
    PlaceAgain,
    /// Say that the window does not cover its monitor.
    SayMisplaced,
    /// Say that the monitor is gone.
    SayGone,
}

/// The state between two looks.
#[derive(Debug, Clone)]
pub(crate) struct Placement {
    placed_at: Instant,
    next_look: Instant,
    attempts: u32,
    has_said_misplaced: bool,
    is_gone: bool,
}

impl Placement {
    /// For a window that was just opened.
    pub(crate) fn new(now: Instant) -> Self {
        Self { placed_at: now, next_look: now, attempts: 0, has_said_misplaced: false, is_gone: false }
    }

    /// When the window is to be looked at again.
    pub(crate) fn next_look(&self) -> Instant {
        self.next_look
    }

    /// Whether the window system still has time to place the window.
    pub(crate) fn is_settling(&self, now: Instant) -> bool {
        now < self.placed_at + SETTLE_TIME
    }

    /// What to do about a window whose monitor is there or not and that covers it exactly or not.
    pub(crate) fn look(&mut self, now: Instant, is_monitor_there: bool, is_in_place: bool) -> PlaceStep {
        let step = self.step(now, is_monitor_there, is_in_place);
        self.next_look = now + if self.is_settling(now) { SETTLE_PERIOD } else { WATCH_PERIOD };
        step
    }

    fn step(&mut self, now: Instant, is_monitor_there: bool, is_in_place: bool) -> PlaceStep {
        let was_gone = std::mem::replace(&mut self.is_gone, !is_monitor_there);
        if !is_monitor_there {
            return if was_gone { PlaceStep::Nothing } else { PlaceStep::SayGone };
        }
        if was_gone || is_in_place {
            self.attempts = 0;
            self.has_said_misplaced = false;
        }
        if is_in_place || (self.is_settling(now) && !was_gone) {
            return PlaceStep::Nothing;
        }
        if self.attempts < MOST_ATTEMPTS {
            self.attempts += 1;
            self.placed_at = now;
            return PlaceStep::PlaceAgain;
        }
        if std::mem::replace(&mut self.has_said_misplaced, true) {
            return PlaceStep::Nothing;
        }
        PlaceStep::SayMisplaced
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Looks whenever the placement wants to, for a while; gives the steps that are something.
    fn steps(placement: &mut Placement, looks: usize, there: bool, in_place: bool) -> Vec<PlaceStep> {
        let look = |_| {
            let now = placement.next_look();
            placement.look(now, there, in_place)
        };
        (0..looks).map(look).filter(|step| *step != PlaceStep::Nothing).collect()
    }

    #[test]
    fn a_window_in_its_place_is_left_alone_and_looked_at_rarely() {
        let start = Instant::now();
        let mut placement = Placement::new(start);
        assert_eq!(steps(&mut placement, 30, true, true), []);
        let before = placement.next_look();
        placement.look(before, true, true);
        assert_eq!(placement.next_look() - before, WATCH_PERIOD);
    }

    #[test]
    fn the_window_system_gets_time_before_the_window_is_placed_again() {
        let start = Instant::now();
        let mut placement = Placement::new(start);
        assert_eq!(placement.look(start + SETTLE_TIME / 2, true, false), PlaceStep::Nothing);
        assert_eq!(placement.look(start + SETTLE_TIME, true, false), PlaceStep::PlaceAgain);
        assert_eq!(placement.look(start + SETTLE_TIME * 3 / 2, true, false), PlaceStep::Nothing);
    }

    #[test]
    fn a_window_that_stays_misplaced_is_said_once() {
        let mut placement = Placement::new(Instant::now());
        let mut expected = vec![PlaceStep::PlaceAgain; 3];
        expected.push(PlaceStep::SayMisplaced);
        assert_eq!(steps(&mut placement, 200, true, false), expected);
        assert_eq!(steps(&mut placement, 1, true, true), []);
        assert_eq!(steps(&mut placement, 200, true, false), expected, "after a good time it is tried again");
    }

    #[test]
    fn a_monitor_that_vanishes_is_said_once_and_gets_its_window_back() {
        let mut placement = Placement::new(Instant::now());
        assert_eq!(steps(&mut placement, 40, true, true), []);
        assert_eq!(steps(&mut placement, 40, false, false), [PlaceStep::SayGone]);
        assert_eq!(steps(&mut placement, 1, true, false), [PlaceStep::PlaceAgain]);
        assert_eq!(steps(&mut placement, 40, true, true), []);
    }
}
