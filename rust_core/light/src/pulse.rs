//! Notices that the process did not run for a while: it was stopped, or the computer slept.

use std::sync::Mutex;
use std::time::{Duration, Instant};

use rcs_process::lock;

/// A longer time without a beat is a pause.
const PAUSE: Duration = Duration::from_millis(500);

/// The beats of a thread that is never busy for long.
#[derive(Debug)]
pub struct Pulse(Mutex<Beats>);

#[derive(Debug)]
struct Beats {
    last: Instant,
    resumed: Option<Instant>,
}

impl Pulse {
    /// Begins now.
    pub fn start(now: Instant) -> Self {
        Self(Mutex::new(Beats { last: now, resumed: None }))
    }

    /// Records that the process runs: to be called several times in [`PAUSE`].
    pub fn beat(&self, now: Instant) {
        let mut beats = lock(&self.0);
        beats.check(now);
        beats.last = beats.last.max(now);
    }

    /// The end of the last pause; also of one that the beating thread has not noticed yet.
    pub fn resumed(&self, now: Instant) -> Option<Instant> {
        let mut beats = lock(&self.0);
        beats.check(now);
        beats.resumed
    }
}

impl Beats {
    fn check(&mut self, now: Instant) {
        if now.saturating_duration_since(self.last) > PAUSE {
            self.resumed = Some(now);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_gap_between_beats_is_a_pause_whoever_notices_it_first() {
        let start = Instant::now();
        let after = |millis| start + Duration::from_millis(millis);
        let pulse = Pulse::start(start);
        (1..=10).for_each(|beat| pulse.beat(after(100 * beat)));
        assert_eq!(pulse.resumed(after(1400)), None);
        assert_eq!(pulse.resumed(after(1501)), Some(after(1501)));
        pulse.beat(after(1510));
        assert_eq!(pulse.resumed(after(1600)), Some(after(1510)));
        let pulse = Pulse::start(start);
        pulse.beat(after(6000));
        assert_eq!(pulse.resumed(after(6001)), Some(after(6000)));
    }
}
