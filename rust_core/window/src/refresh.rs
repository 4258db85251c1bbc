//! Refresh times of a screen: periodic, from a time that the display server reported.

use std::time::{Duration, Instant};

/// A screen's refresh.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Refresh {
    at: Instant,
    period: Duration,
}

impl Refresh {
    /// Refreshes at `at` and every `period` before and after; `None` for a period of zero.
    pub fn new(at: Instant, period: Duration) -> Option<Self> {
        (!period.is_zero()).then_some(Self { at, period })
    }

    /// The time between two refreshes.
    pub fn period(&self) -> Duration {
        self.period
    }

    /// The first refresh at or after `time`.
    pub fn next(&self, time: Instant) -> Instant {
        let nanos = self.period.as_nanos();
        let past = |nanos: u128| Duration::from_nanos(u64::try_from(nanos).unwrap_or(u64::MAX));
        if time >= self.at {
            let since = (time - self.at).as_nanos();
            time + past((nanos - since % nanos) % nanos)
        } else {
            time + past((self.at - time).as_nanos() % nanos)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn refreshes_go_on_at_the_period_before_and_after_the_known_one() {
        let start = Instant::now();
        let at = |millis| start + Duration::from_millis(millis);
        let refresh = Refresh::new(at(1005), Duration::from_millis(10)).unwrap();
        for (time, expected) in
            [(1005, 1005), (1006, 1015), (1015, 1015), (1000, 1005), (995, 995), (1, 5), (9999, 10005)]
        {
            assert_eq!(refresh.next(at(time)), at(expected), "{time}");
        }
        assert_eq!(Refresh::new(start, Duration::ZERO), None);
    }
}
