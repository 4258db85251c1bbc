//! Rate limit of images in the long run, with no delay after a pause.
//!
//! A token bucket: each image takes one, one is added in each period, and [`MOST_TOKENS`] fit in. A change that finds
//! no token waits for one, so that changes that come much faster than the rate are drawn at equal intervals. Changes
//! that come just a little faster, such as 30.05 clouds a second at a rate of 30, would all be late by a slowly
//! drifting part of a period. There, the change waits for two tokens, by when usually the next one has come, which is
//! drawn instead and leaves a token: one in some hundred is left out, and none is late.

use std::time::{Duration, Instant};

/// Images that may follow each other at once after a pause.
const MOST_TOKENS: f64 = 2.0;
/// Share of a period below which the interval between changes is much faster than the rate.
const FAST_SHARE: f64 = 0.75;
/// Weight of the newest interval in the mean.
const NEWEST_WEIGHT: f64 = 0.2;

/// Limits the rate of images.
#[derive(Clone, Copy, Debug)]
pub struct RateLimit {
    period: Duration,
    /// Number at `counted_at`.
    tokens: f64,
    counted_at: Option<Instant>,
    /// A change waits for tokens.
    is_waiting: bool,
    last_change: Option<Instant>,
    /// Mean time between changes, in periods.
    mean_interval: f64,
}

impl RateLimit {
    /// One image in each period in the long run.
    pub fn new(period: Duration) -> Self {
        Self { period, tokens: MOST_TOKENS, counted_at: None, is_waiting: false, last_change: None, mean_interval: 1.0 }
    }

    fn periods(&self, duration: Duration) -> f64 {
        duration.as_secs_f64() / self.period.as_secs_f64().max(1e-9)
    }

    fn tokens_at(&self, now: Instant) -> f64 {
        let passed = self.counted_at.map_or(Duration::ZERO, |counted| now.saturating_duration_since(counted));
        (self.tokens + self.periods(passed)).min(MOST_TOKENS)
    }

    fn is_fast(&self) -> bool {
        self.mean_interval < FAST_SHARE
    }

    /// Tokens that a waiting change needs.
    fn wanted_tokens(&self) -> f64 {
        if self.is_fast() {
            1.0
        } else {
            MOST_TOKENS
        }
    }

    /// Records a change.
    pub fn note_change(&mut self, now: Instant) {
        if let Some(last) = self.last_change.replace(now) {
            // A pause says nothing about the interval.
            let interval = self.periods(now.saturating_duration_since(last)).min(1.0);
            self.mean_interval += (interval - self.mean_interval) * NEWEST_WEIGHT;
        }
        self.is_waiting &= self.is_fast();
    }

    /// `true` if the change that was noted last may be drawn now. If not, it waits, see [`Self::until_free`].
    pub fn allows(&mut self, now: Instant) -> bool {
        let wanted = if self.is_waiting { self.wanted_tokens() } else { 1.0 };
        let is_allowed = self.tokens_at(now) >= wanted;
        self.is_waiting = !is_allowed;
        is_allowed
    }

    /// Remaining wait of the waiting change; `None` if none waits.
    pub fn until_free(&self, now: Instant) -> Option<Duration> {
        let missing = (self.wanted_tokens() - self.tokens_at(now)).max(0.0);
        // Rounded up, so that it is free then.
        self.is_waiting.then(|| self.period.mul_f64(missing) + Duration::from_micros(1))
    }

    /// Records that an image was begun.
    pub fn take(&mut self, now: Instant) {
        self.tokens = (self.tokens_at(now) - 1.0).max(0.0);
        self.counted_at = Some(now);
        self.is_waiting = false;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Times in seconds at which images are drawn, at a rate of 30, of changes at these times; each change is drawn
    /// as soon as it may be, with those that came meanwhile.
    fn drawn(changes: impl Iterator<Item = f64>) -> Vec<f64> {
        let start = Instant::now();
        let at = |secs: f64| start + Duration::from_secs_f64(secs);
        let mut limit = RateLimit::new(Duration::from_secs_f64(1.0 / 30.0));
        let (mut drawn, mut waiting_until): (Vec<f64>, Option<f64>) = (Vec::new(), None);
        for change in changes {
            if let Some(free) = waiting_until.take_if(|free| *free <= change) {
                assert!(limit.allows(at(free)));
                limit.take(at(free));
                drawn.push(free);
            }
            limit.note_change(at(change));
            if limit.allows(at(change)) {
                limit.take(at(change));
                drawn.push(change);
                waiting_until = None;
            } else {
                waiting_until = limit.until_free(at(change)).map(|left| change + left.as_secs_f64());
            }
        }
        drawn
    }

    fn every(period_secs: f64, secs: f64) -> impl Iterator<Item = f64> {
        (0..(secs / period_secs) as u32).map(move |i| f64::from(i) * period_secs)
    }

    #[test]
    fn fast_changes_are_drawn_at_the_rate_and_evenly() {
        let drawn = drawn(every(0.0033, 10.0));
        assert!((297..=302).contains(&drawn.len()), "{}", drawn.len());
        let gaps = drawn.windows(2).skip(10).map(|pair| pair[1] - pair[0]);
        gaps.for_each(|gap| assert!((0.033..0.037).contains(&gap), "{gap}"));
    }

    #[test]
    fn slower_changes_are_drawn_at_once() {
        let drawn = drawn(every(1.0 / 29.9, 10.0));
        assert_eq!(drawn, every(1.0 / 29.9, 10.0).collect::<Vec<_>>());
    }

    #[test]
    fn of_changes_a_little_too_fast_a_few_are_left_out_and_none_is_late() {
        for rate_hz in [30.05, 31.0, 36.0] {
            let changes: Vec<f64> = every(1.0 / rate_hz, 60.0).collect();
            let drawn = drawn(changes.iter().copied());
            assert!((60 * 29..=60 * 30 + 2).contains(&drawn.len()), "{rate_hz}: {}", drawn.len());
            let late = drawn.iter().filter(|drawn| !changes.contains(drawn)).count();
            assert!(late <= drawn.len() / 50, "{rate_hz}: {late} of {}", drawn.len());
        }
    }

    #[test]
    fn after_a_pause_a_change_is_drawn_at_once() {
        let drawn = drawn([0.0, 0.01, 0.02, 0.03, 5.0, 5.01, 5.5].into_iter());
        assert!(drawn.contains(&5.0) && drawn.contains(&5.5), "{drawn:?}");
    }
}
