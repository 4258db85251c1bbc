//! Ages of measurements: masks, depth images, received images. A measurement is never a constant.

use std::time::{Duration, Instant};

use rcs_transforms::Time;

use crate::evidence::Condition;

/// The present time by both clocks.
#[derive(Clone, Copy, Debug)]
pub struct Now {
    /// ROS time; zero before a simulation's first.
    pub ros: Time,
    /// The computer's clock.
    pub steady: Instant,
    /// The end of the last pause of the process, if there was one: see [`Pulse`](crate::Pulse).
    pub resumed: Option<Instant>,
}

/// When something was measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Measured {
    /// Its stamp; zero if it has none.
    pub stamp: Time,
    /// Its arrival.
    pub received: Instant,
}

impl Measured {
    /// Whether it is current: not older than `limit` by its stamp (without one by its arrival), nor longer here, nor
    /// stamped later than `limit` from now. Without a stamp, it counts only if it has not waited while the process
    /// stood still.
    pub fn condition(&self, what: &str, limit: Duration, now: Now) -> Condition {
        let limit_secs = limit.as_secs_f64();
        let since_received = now.steady.saturating_duration_since(self.received);
        let has_stamp = !self.stamp.is_zero() && !now.ros.is_zero();
        let since_stamp = if has_stamp { now.ros.saturating_since(self.stamp) } else { Duration::ZERO };
        if has_stamp && self.stamp.saturating_since(now.ros) > limit {
            let ahead_secs = self.stamp.saturating_since(now.ros).as_secs_f64();
            return Condition::Dark(format!("{what}: its stamp is {ahead_secs:.1} s ahead of the clock"));
        }
        let may_have_waited = |resumed: Instant| self.received < resumed + limit;
        if !has_stamp && now.resumed.is_some_and(may_have_waited) {
            return Condition::Dark(format!("{what}: the process was paused, and its messages have no stamp"));
        }
        match limit.checked_sub(since_received.max(since_stamp)) {
            Some(left) if !left.is_zero() => Condition::Until(now.steady + left),
            _ if since_stamp > limit && since_received < limit => Condition::Dark(format!(
                "{what}: its stamp is {:.1} s old, more than {limit_secs} s",
                since_stamp.as_secs_f64()
            )),
            _ => Condition::Dark(format!("{what}: no data of the last {limit_secs} s")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(start: Instant, secs: f64) -> Now {
        let ros = Time::from_secs_f64(100.0 + secs);
        Now { ros, steady: start + Duration::from_secs_f64(secs), resumed: None }
    }

    fn is_current(measured: Measured, now: Now) -> bool {
        matches!(measured.condition("mask", Duration::from_secs(1), now), Condition::Until(_))
    }

    #[test]
    fn it_ages_by_its_stamp_and_by_its_arrival() {
        let start = Instant::now();
        let measured = |stamp: f64| Measured { stamp: Time::from_secs_f64(stamp), received: start };
        assert!(is_current(measured(100.0), at(start, 0.9)) && !is_current(measured(100.0), at(start, 1.0)));
        assert!(is_current(measured(99.5), at(start, 0.4)) && !is_current(measured(99.5), at(start, 0.6)));
        assert!(is_current(measured(0.0), at(start, 0.9)) && !is_current(measured(0.0), at(start, 1.0)));
        let still = Now { ros: Time::from_secs_f64(100.0), ..at(start, 1.0) };
        assert!(!is_current(measured(100.0), still), "a simulation that stands still");
    }

    #[test]
    fn a_stamp_that_is_far_ahead_is_unknown() {
        let start = Instant::now();
        let measured = |stamp: f64| Measured { stamp: Time::from_secs_f64(stamp), received: start };
        assert!(is_current(measured(100.9), at(start, 0.0)) && !is_current(measured(101.1), at(start, 0.0)));
        let Condition::Dark(why) = measured(105.0).condition("mask", Duration::from_secs(1), at(start, 0.0)) else {
            panic!("lit")
        };
        assert_eq!(why, "mask: its stamp is 5.0 s ahead of the clock");
    }

    #[test]
    fn without_a_stamp_it_is_void_if_it_may_have_waited_while_the_process_stood_still() {
        let start = Instant::now();
        let paused = |secs: f64, stamp: f64, received: f64| {
            let received = start + Duration::from_secs_f64(received);
            let now = Now { resumed: Some(start + Duration::from_secs(10)), ..at(start, secs) };
            is_current(Measured { stamp: Time::from_secs_f64(stamp), received }, now)
        };
        assert!(!paused(10.0, 0.0, 10.0) && !paused(11.2, 0.0, 10.9) && paused(11.2, 0.0, 11.1));
        assert!(paused(10.1, 110.0, 10.0) && !paused(10.1, 104.0, 10.0));
    }
}
