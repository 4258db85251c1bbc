//! Pacing of frames for a window: each is begun as late as it can still be finished before the screen's next refresh.
//!
//! A frame that is finished long before the refresh only waits for it, while newer data arrive. Begun later, it shows
//! them, and reaches the screen at the same refresh. The time that a frame takes is estimated from the last ones.

use std::time::{Duration, Instant};

use rcs_camera::RollingWindow;
use rcs_window::Refresh;

/// Frames from which the time that one takes is estimated.
const FRAMES: usize = 30;
/// Time between the end of a frame and the refresh: the window and the display server copy it, and wake-ups take time.
const MARGIN: Duration = Duration::from_millis(3);

/// The time that a camera's frames take.
#[derive(Debug, Default)]
pub(super) struct Pacing {
    took_secs: RollingWindow<FRAMES>,
}

impl Pacing {
    /// Wait before a frame is begun; `None` if it is to be begun now.
    pub(super) fn wait(&self, refresh: Option<Refresh>, now: Instant) -> Option<Duration> {
        let (refresh, took) = (refresh?, self.took_secs.percentiles()?);
        let secs = |secs: f64| Duration::try_from_secs_f64(secs).ok();
        let (usual, needed) = (secs(took.median)? + MARGIN / 2, secs(took.p95)? + MARGIN);
        // One that can only just make it to a refresh is begun at once.
        let wanted = refresh.next(now.checked_add(usual)?);
        let wait = wanted.saturating_duration_since(now).saturating_sub(needed);
        // What is shorter than a wake-up takes is no wait.
        Some(wait).filter(|wait| *wait > Duration::from_micros(200))
    }

    /// Records the time that a frame took from its beginning until it was handed on.
    pub(super) fn record(&mut self, took: Duration) {
        self.took_secs.push(took.as_secs_f64());
    }
}

#[cfg(test)]
mod tests {
    use rcs_camera::RateLimit;

    use super::*;

    const REFRESH: Duration = Duration::from_micros(16_733);

    /// The result of a simulation.
    struct Outcome {
        /// The mean age of the newest data in an image when the screen shows it first.
        age_ms: f64,
        images: usize,
    }

    /// A screen of 59.8 Hz, data at a rate, images at most at another rate that take 9 ms or a little more or less,
    /// for a minute on a simulated clock.
    fn simulate(data_hz: f64, most_hz: f64, is_paced: bool) -> Outcome {
        let start = Instant::now();
        let end = start + Duration::from_secs(60);
        let refresh = Refresh::new(start, REFRESH).unwrap();
        let mut limit = RateLimit::new(Duration::from_secs_f64(1.0 / most_hz));
        let arrival = |number: u32| start + Duration::from_secs_f64(f64::from(number) / data_hz);
        let took = |number: usize| Duration::from_micros(8_800 + 37 * (number as u64 * 7919 % 11));
        let (mut pacing, mut now, mut newest, mut shown) = (Pacing::default(), arrival(1), 0, 0);
        // By refresh, the age of the data of the last image before it.
        let mut ages: Vec<(Instant, Duration)> = Vec::new();
        let mut images = 0;
        while now < end {
            while arrival(newest + 1) <= now {
                newest += 1;
                limit.note_change(arrival(newest));
            }
            let next = arrival(newest + 1);
            if newest == shown {
                now = next;
                continue;
            }
            if !limit.allows(now) {
                let free = limit.until_free(now).map_or(next, |wait| now + wait.max(Duration::from_micros(50)));
                now = next.min(free);
                continue;
            }
            if let Some(wait) = pacing.wait(is_paced.then_some(refresh), now) {
                now = next.min(now + wait);
                continue;
            }
            shown = newest;
            limit.take(now);
            pacing.record(took(images));
            now += took(images);
            images += 1;
            // The window and the server need two milliseconds more.
            let at = refresh.next(now + Duration::from_millis(2));
            ages.retain(|(last, _)| *last != at);
            ages.push((at, at - arrival(shown)));
        }
        let sum: f64 = ages.iter().map(|(_, age)| age.as_secs_f64() * 1e3).sum();
        Outcome { age_ms: sum / ages.len() as f64, images }
    }

    #[test]
    fn data_are_younger_at_the_refresh_and_no_image_is_lost() {
        for (data_hz, least_gain_ms) in [(29.7, -0.3), (50.0, 2.0), (97.0, 4.0), (180.0, 3.0), (500.0, 4.0)] {
            let (plain, paced) = (simulate(data_hz, 30.0, false), simulate(data_hz, 30.0, true));
            let gain_ms = plain.age_ms - paced.age_ms;
            println!("{data_hz} Hz: {:.1} ms at once, {:.1} ms paced", plain.age_ms, paced.age_ms);
            println!("{} pictures, {} pictures", plain.images, paced.images);
            assert!(gain_ms >= least_gain_ms, "{data_hz} Hz: {gain_ms}");
            assert!(paced.images + 3 >= plain.images, "{} {}", paced.images, plain.images);
        }
    }

    #[test]
    fn without_a_refresh_or_a_image_before_nothing_waits() {
        let now = Instant::now();
        let mut pacing = Pacing::default();
        assert_eq!(pacing.wait(Refresh::new(now, REFRESH), now), None);
        pacing.record(Duration::from_millis(5));
        assert_eq!(pacing.wait(None, now), None);
        let wait = pacing.wait(Refresh::new(now, REFRESH), now).unwrap();
        assert_eq!(wait, REFRESH - Duration::from_millis(5) - MARGIN);
        assert_eq!(pacing.wait(Refresh::new(now, REFRESH), now + wait), None, "then it is begun");
    }
}
