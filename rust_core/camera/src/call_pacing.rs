//! Schedule of images for a program that is called regularly, such as rviz once per frame of its window.
//!
//! Images are due at moments one period apart, each served by the nearest call, so that in the long run the frame
//! rate is exact, or one image a call if there are fewer calls. (A minimum time since the last image would give 15
//! a second of 30 calls a second for a rate of 20.) After a pause, missed moments are forgotten: there is no burst.
//!
//! [`Schedule`](crate::Schedule) is for a program that can wake up whenever it wants to.

use std::time::Duration;

/// Weight of the newest interval between calls in their mean.
const NEWEST_WEIGHT: f64 = 0.2;

/// Delay that is caught up with, in intervals between calls.
const MOST_LATE: u32 = 2;
/// Delay that counts as a pause, in intervals between calls.
const PAUSE: u32 = 4;

/// Decides at which calls an image is due. Times count from any fixed moment.
#[derive(Clone, Copy, Debug)]
pub struct CallPacing {
    pace: Pace,
    triggered: bool,
    last_call: Option<Duration>,
    /// Mean time between calls.
    interval: Option<Duration>,
    /// Time of the next image of a frame rate; `None`: at once.
    next: Option<Duration>,
}

/// A CameraPub display's "Frame Rate".
#[derive(Clone, Copy, Debug, PartialEq)]
enum Pace {
    /// Below 0: at each call.
    EachCall,
    /// 0: only when triggered.
    OnTrigger,
    /// Above 0: once in this period.
    Every(Duration),
}

impl Default for CallPacing {
    /// An image at each call.
    fn default() -> Self {
        Self { pace: Pace::EachCall, triggered: false, last_call: None, interval: None, next: None }
    }
}

impl CallPacing {
    /// Sets a display's "Frame Rate" in images a second: below 0 at each call, at 0 (or NaN) only when triggered.
    pub fn set_frame_rate(&mut self, frame_rate_hz: f32) {
        let pace = if frame_rate_hz < 0.0 {
            Pace::EachCall
        } else if frame_rate_hz > 0.0 {
            let period = Duration::try_from_secs_f64(1.0 / f64::from(frame_rate_hz));
            Pace::Every(period.unwrap_or(Duration::MAX))
        } else {
            Pace::OnTrigger
        };
        if pace != self.pace {
            (self.pace, self.next) = (pace, None);
        }
    }

    /// Makes one image due at the next call, whatever the frame rate.
    pub fn trigger(&mut self) {
        self.triggered = true;
    }

    /// `true` if an image is due at this call. Without a subscriber (`watched`) only a triggered one is.
    pub fn is_due(&mut self, now: Duration, watched: bool) -> bool {
        self.note_call(now);
        self.triggered || watched && self.is_paced(now)
    }

    /// Records that an image was begun: the trigger is served, and the next image is timed. One that was only
    /// triggered moves no other.
    pub fn begin(&mut self, now: Duration) {
        if let Pace::Every(period) = self.pace {
            if self.is_paced(now) {
                self.next = Some(self.served(now).saturating_add(period));
            }
        }
        self.triggered = false;
    }

    /// The moment that an image at this call serves: the next one, unless that is long ago. Of the delay of irregular
    /// calls [`MOST_LATE`] is caught up with; after a pause, nothing.
    fn served(&self, now: Duration) -> Duration {
        let interval = self.interval.unwrap_or_default();
        match self.next {
            Some(next) if now.saturating_sub(next) <= interval.saturating_mul(PAUSE) => {
                next.max(now.saturating_sub(interval.saturating_mul(MOST_LATE)))
            }
            _ => now,
        }
    }

    fn is_paced(&self, now: Duration) -> bool {
        let half_interval = self.interval.unwrap_or_default() / 2;
        match self.pace {
            Pace::EachCall => true,
            Pace::OnTrigger => false,
            Pace::Every(_) => self.next.is_none_or(|next| now.saturating_add(half_interval) >= next),
        }
    }

    fn note_call(&mut self, now: Duration) {
        let Some(last) = self.last_call.replace(now) else { return };
        // A pause says nothing about the interval.
        let longest = match self.pace {
            Pace::Every(period) => period,
            Pace::EachCall | Pace::OnTrigger => Duration::from_secs(1),
        };
        let newest = now.saturating_sub(last).min(longest);
        let mean = self.interval.map_or(newest, |mean| {
            let secs = mean.as_secs_f64() * (1.0 - NEWEST_WEIGHT) + newest.as_secs_f64() * NEWEST_WEIGHT;
            Duration::try_from_secs_f64(secs).unwrap_or(newest)
        });
        self.interval = Some(mean);
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn at(secs: f64) -> Duration {
        Duration::from_secs_f64(secs)
    }

    /// Times at which images are begun, of calls at these times.
    fn begun(pacing: &mut CallPacing, calls: impl Iterator<Item = f64>) -> Vec<f64> {
        calls
            .filter(|call| {
                let is_due = pacing.is_due(at(*call), true);
                if is_due {
                    pacing.begin(at(*call));
                }
                is_due
            })
            .collect()
    }

    fn paced(frame_rate_hz: f32) -> CallPacing {
        let mut pacing = CallPacing::default();
        pacing.set_frame_rate(frame_rate_hz);
        pacing
    }

    /// Calls at a rate, each early or late by up to a share of their interval.
    fn calls(rate_hz: f64, secs: f64, jitter: f64) -> impl Iterator<Item = f64> {
        (0..(secs * rate_hz) as u32).map(move |i| {
            // Anything irregular that does not add up.
            let off = jitter * (f64::from(i) * 7.31).sin();
            (f64::from(i) + 1.0 + off) / rate_hz
        })
    }

    #[test]
    fn the_rate_is_the_asked_one_or_that_of_the_calls() {
        for jitter in [0.0, 0.05, 0.4] {
            for calls_hz in [15.0, 29.97, 30.0, 31.0, 60.0] {
                for rate_hz in [1.0, 7.0, 10.0, 15.0, 20.0, 25.0, 29.9, 30.0, 30.1, 33.0, 60.0, 100.0, 1e9] {
                    let images = begun(&mut paced(rate_hz), calls(calls_hz, 100.0, jitter)).len() as f64;
                    let expected = 100.0 * f64::from(rate_hz).min(calls_hz);
                    let off = (images - expected) / expected;
                    assert!(off.abs() < 0.011, "{rate_hz} Hz at {calls_hz} ± {jitter}: {images} not {expected}");
                }
            }
        }
    }

    #[test]
    fn twenty_of_thirty_calls_are_as_even_as_they_can_be() {
        let images = begun(&mut paced(20.0), calls(30.0, 10.0, 0.0));
        assert!((199..=201).contains(&images.len()), "{}", images.len());
        let gaps = images.windows(2).map(|pair| pair[1] - pair[0]);
        gaps.for_each(|gap| assert!((0.033..0.067).contains(&gap), "{gap}"));
    }

    #[test]
    fn after_a_pause_there_is_one_image_at_once_and_no_burst() {
        for pause in [0.12, 0.15, 0.5, 100.0] {
            let mut pacing = paced(20.0);
            begun(&mut pacing, calls(60.0, 1.0, 0.0));
            let begin = 1.0 + pause;
            let after = begun(&mut pacing, calls(60.0, 1.0, 0.0).map(|call| begin + call));
            assert!((after[0] - begin - 1.0 / 60.0).abs() < 1e-9);
            assert!(after[1] - after[0] > 0.03, "{pause}: {after:?}");
            assert!((19..=21).contains(&after.len()), "{pause}: {}", after.len());
        }
    }

    #[test]
    fn nobody_watching_means_no_image_and_the_first_watcher_gets_one_at_once() {
        let mut pacing = paced(10.0);
        for call in calls(30.0, 5.0, 0.0) {
            assert!(!pacing.is_due(at(call), false));
        }
        assert!(pacing.is_due(at(5.03), true));
        assert!(pacing.is_due(at(5.04), true), "until it is begun");
        pacing.begin(at(5.04));
        assert!(!pacing.is_due(at(5.07), true));
        let mut each = CallPacing::default();
        assert!(!each.is_due(at(1.0), false) && each.is_due(at(1.1), true));
    }

    #[test]
    fn a_trigger_makes_one_image_due_whatever_the_rate_and_the_watchers() {
        for rate_hz in [0.0, f32::NAN, 0.001, 1e-40] {
            let mut pacing = paced(rate_hz);
            if pacing.is_due(at(1.0), true) {
                pacing.begin(at(1.0));
            }
            assert!(!pacing.is_due(at(1.1), true), "{rate_hz}");
            pacing.trigger();
            pacing.trigger();
            assert!(pacing.is_due(at(1.2), false), "{rate_hz}");
            pacing.begin(at(1.2));
            assert!(!pacing.is_due(at(1.3), true), "{rate_hz}");
        }
    }

    #[test]
    fn a_triggered_image_moves_no_other() {
        let mut pacing = paced(1.0);
        assert!(pacing.is_due(at(1.0), true));
        pacing.begin(at(1.0));
        pacing.trigger();
        assert!(pacing.is_due(at(1.5), true));
        pacing.begin(at(1.5));
        assert!(!pacing.is_due(at(1.6), true));
        assert!(pacing.is_due(at(2.0), true));
    }

    #[test]
    fn a_new_rate_holds_at_once() {
        let mut pacing = paced(0.01);
        pacing.begin(at(0.0));
        pacing.set_frame_rate(10.0);
        assert!(pacing.is_due(at(0.1), true));
        pacing.begin(at(0.1));
        pacing.set_frame_rate(10.0);
        assert!(!pacing.is_due(at(0.12), true), "the same rate changes nothing");
    }

    proptest! {
        #[test]
        fn no_times_are_an_error(
            times in proptest::collection::vec((any::<u64>(), any::<bool>(), any::<bool>()), 0..50),
            rate_hz in any::<f32>(),
        ) {
            let mut pacing = paced(rate_hz);
            for (nanos, watched, trigger) in times {
                if trigger {
                    pacing.trigger();
                }
                let now = Duration::from_nanos(nanos);
                if pacing.is_due(now, watched) {
                    pacing.begin(now);
                }
            }
        }
    }
}
