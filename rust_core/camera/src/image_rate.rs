//! Frame rate over the last hundred images.

use std::collections::VecDeque;
use std::time::Duration;

use crate::IMAGES;

/// Times of the last images, since any fixed moment.
#[derive(Clone, Debug, Default)]
pub struct ImageRate {
    published: VecDeque<Duration>,
}

impl ImageRate {
    /// Adds an image.
    pub fn push(&mut self, published: Duration) {
        if self.published.len() == IMAGES {
            self.published.pop_front();
        }
        self.published.push_back(published);
    }

    /// Images a second; falls once the next one is later than usual. `None` with fewer than two images.
    pub fn hz(&self, now: Duration) -> Option<f64> {
        let (first, last) = (*self.published.front()?, *self.published.back()?);
        let intervals = u32::try_from(self.published.len() - 1).ok().filter(|intervals| *intervals > 0)?;
        let usual = last.saturating_sub(first) / intervals;
        let end = last.max(now.saturating_sub(usual));
        let secs = end.saturating_sub(first).as_secs_f64();
        (secs > 0.0).then(|| f64::from(intervals) / secs)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rate_is_that_of_the_last_hundred_and_falls_when_they_stop() {
        let mut rate = ImageRate::default();
        assert_eq!(rate.hz(Duration::ZERO), None);
        rate.push(Duration::from_secs(1000));
        assert_eq!(rate.hz(Duration::from_secs(1000)), None);
        let start = Duration::from_secs(2000);
        for i in 0..200 {
            rate.push(start + Duration::from_millis(50) * i);
        }
        let last = start + Duration::from_millis(50) * 199;
        for since_last_ms in [0, 10, 50] {
            let hz = rate.hz(last + Duration::from_millis(since_last_ms)).unwrap();
            assert!((hz - 20.0).abs() < 1e-9, "{hz}");
        }
        // 99 intervals in 4.95 s, and 5 s without one.
        let hz = rate.hz(last + Duration::from_millis(5050)).unwrap();
        assert!((hz - 99.0 / 9.95).abs() < 1e-9, "{hz}");
    }

    #[test]
    fn times_that_do_not_advance_have_no_rate() {
        let mut rate = ImageRate::default();
        rate.push(Duration::from_secs(1));
        rate.push(Duration::from_secs(1));
        assert_eq!(rate.hz(Duration::from_secs(1)), None);
        rate.push(Duration::ZERO);
        assert_eq!(rate.hz(Duration::ZERO), None);
    }
}
