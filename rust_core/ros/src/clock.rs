//! ROS's time: the computer's, or that of `/clock` under `/use_sim_time`.

use rcs_messages::Time;
use std::sync::atomic::{AtomicI64, Ordering};
use std::time::{SystemTime, UNIX_EPOCH};

/// A clock that is read from any thread.
#[derive(Debug)]
pub struct RosClock {
    /// Simulated time, nanoseconds; negative without simulation.
    simulated_nanos: AtomicI64,
}

const REAL: i64 = -1;

impl RosClock {
    /// The computer's clock, or a simulated one, which is zero until the first [`set`](Self::set).
    pub fn new(simulated: bool) -> Self {
        Self { simulated_nanos: AtomicI64::new(if simulated { 0 } else { REAL }) }
    }

    /// `true` if the time is simulated.
    pub fn is_simulated(&self) -> bool {
        self.simulated_nanos.load(Ordering::Acquire) != REAL
    }

    /// Present time.
    pub fn now(&self) -> Time {
        match self.simulated_nanos.load(Ordering::Acquire) {
            REAL => Time::from_nanos(real_nanos()),
            nanos => Time::from_nanos(nanos),
        }
    }

    /// Sets the simulated time. Returns the times before and after a jump back.
    pub fn set(&self, time: Time) -> Option<(Time, Time)> {
        let before = self.simulated_nanos.swap(time.nanos(), Ordering::AcqRel);
        (time.nanos() < before).then(|| (Time::from_nanos(before), time))
    }
}

/// Clock for filling in the stamps of messages.
impl rosrust::Clock for RosClock {
    fn now(&self) -> Time {
        Self::now(self)
    }

    /// Never called: messages do not wait.
    fn sleep(&self, _: rosrust::Duration) {}

    /// Never called either.
    fn wait_until(&self, _: Time) {}
}

fn real_nanos() -> i64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    i64::try_from(since.as_nanos()).unwrap_or(i64::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_step_back_is_a_jump() {
        let clock = RosClock::new(true);
        let at = |sec| Time { sec, nsec: 0 };
        assert_eq!(clock.now(), at(0));
        assert_eq!(clock.set(at(5)), None);
        assert_eq!(clock.set(at(5)), None);
        assert_eq!(clock.set(at(3)), Some((at(5), at(3))));
        assert_eq!(clock.now(), at(3));
    }

    #[test]
    fn without_a_simulation_time_passes() {
        let clock = RosClock::new(false);
        assert!(!clock.is_simulated());
        assert!(clock.now().sec > 1_600_000_000);
    }
}
