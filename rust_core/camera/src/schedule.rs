//! Schedule of a camera's images.

use std::time::{Duration, Instant};

use crate::RateLimit;

/// Start of a camera's last image, and whether it differed from the one before.
#[derive(Clone, Copy, Debug, PartialEq)]
struct LastBegun {
    at: Instant,
    changed: bool,
}

/// Decides when a camera's images are due: by its frame rate, or because its trigger service was called.
#[derive(Clone, Copy, Debug)]
pub struct Schedule {
    pace: Pace,
    triggered: bool,
    last: Option<LastBegun>,
    /// For a pace of changes.
    limit: RateLimit,
}

impl Default for Schedule {
    /// Only when triggered, until a frame rate is set.
    fn default() -> Self {
        Self { pace: Pace::OnTrigger, triggered: false, last: None, limit: RateLimit::new(Duration::ZERO) }
    }
}

impl Schedule {
    /// Sets a display's "Frame Rate" and the config's global one, both in images a second.
    pub fn set_frame_rate(&mut self, frame_rate_hz: f32, global_frame_rate_hz: i32) {
        let pace = Pace::new(frame_rate_hz, global_frame_rate_hz);
        if let Pace::OnChange { repeat } = pace {
            if pace != self.pace {
                self.limit = RateLimit::new(repeat);
            }
        }
        self.pace = pace;
    }

    /// `true` if images are published only when triggered.
    pub fn is_on_trigger(&self) -> bool {
        self.pace == Pace::OnTrigger
    }

    /// `true` if each change makes an image due.
    pub fn follows_changes(&self) -> bool {
        matches!(self.pace, Pace::OnChange { .. })
    }

    /// Makes an image due now, whatever the frame rate.
    pub fn trigger(&mut self) {
        self.triggered = true;
    }

    /// `true` if an image was triggered and not served yet.
    pub fn is_triggered(&self) -> bool {
        self.triggered
    }

    /// Withdraws the trigger: it was served, or there is nobody to serve.
    pub fn clear_trigger(&mut self) {
        self.triggered = false;
    }

    /// Records a change: the next image would differ from the last one, or in another way than before.
    pub fn note_change(&mut self, now: Instant) {
        self.limit.note_change(now);
    }

    /// `true` if an image is due; `changed`: it would differ from the last one.
    pub fn is_due(&mut self, now: Instant, changed: bool) -> bool {
        if self.triggered {
            return true;
        }
        match self.pace {
            Pace::OnChange { .. } if changed => self.limit.allows(now),
            _ => self.is_repetition_due(now),
        }
    }

    /// `true` if the last image is due again, or the next one at a fixed rate.
    pub fn is_repetition_due(&self, now: Instant) -> bool {
        self.pace.until_due(self.last, now) == Some(Duration::ZERO)
    }

    /// Time until an image is due by itself: one of a waiting change, or a repetition. `None` if never.
    pub fn until_due(&self, now: Instant) -> Option<Duration> {
        let by_itself = self.pace.until_due(self.last, now)?;
        let change = matches!(self.pace, Pace::OnChange { .. }).then(|| self.limit.until_free(now)).flatten();
        Some(change.map_or(by_itself, |change| change.min(by_itself)))
    }

    /// Records that an image was begun. The next one is timed from here, also when drawing fails, so that it is
    /// retried at the frame rate and not at once.
    pub fn begin(&mut self, now: Instant, changed: bool) {
        self.last = Some(LastBegun { at: now, changed });
        self.limit.take(now);
    }
}

/// A CameraPub display's "Frame Rate".
#[derive(Clone, Copy, Debug, PartialEq)]
enum Pace {
    /// Below 0: whenever the scene changes, but in the long run no more often than once in this period; an unchanged
    /// image is repeated at this period.
    OnChange {
        /// Period of rviz's main loop ("Global Options: Frame Rate").
        repeat: Duration,
    },
    /// 0: only when triggered.
    OnTrigger,
    /// Above 0: once in this period.
    Every(Duration),
}

impl Pace {
    /// From a display's "Frame Rate" and the config's global one, both in images a second.
    fn new(frame_rate_hz: f32, global_frame_rate_hz: i32) -> Self {
        let period = |rate_hz: f64| Duration::try_from_secs_f64(1.0 / rate_hz).unwrap_or(Duration::MAX);
        if frame_rate_hz < 0.0 {
            Self::OnChange { repeat: period(f64::from(global_frame_rate_hz.max(1))) }
        } else if frame_rate_hz > 0.0 {
            Self::Every(period(f64::from(frame_rate_hz)))
        } else {
            Self::OnTrigger
        }
    }

    fn until_due(self, last: Option<LastBegun>, now: Instant) -> Option<Duration> {
        let period = match self {
            // A scene that changes about as often as it would be repeated must not be late because its old image is
            // just being sent, so the first repetition waits half a period longer.
            Self::OnChange { repeat } if last.is_some_and(|last| last.changed) => repeat.saturating_add(repeat / 2),
            Self::OnChange { repeat } => repeat,
            Self::OnTrigger => return None,
            Self::Every(period) => period,
        };
        Some(last.map_or(Duration::ZERO, |last| period.saturating_sub(now.saturating_duration_since(last.at))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn images_are_due_at_the_frame_rate() {
        let start = Instant::now();
        let at = |millis| start + Duration::from_millis(millis);
        // An image of each kind that was begun at the start.
        let begun = |frame_rate_hz: f32, global_frame_rate_hz: i32, changed: bool| {
            let mut schedule = Schedule::default();
            schedule.set_frame_rate(frame_rate_hz, global_frame_rate_hz);
            schedule.begin(start, changed);
            schedule
        };
        let (mut new, mut old) = (begun(-1.0, 30, true), begun(-1.0, 30, false));
        assert!(new.is_due(at(1), true), "a change is drawn at once");
        assert!(!old.is_due(at(33), false));
        assert!(old.is_due(at(34), false), "an unchanged scene is repeated at rviz's rate");
        assert!(!new.is_due(at(49), false), "what changes at that rate is not repeated between");
        assert!(new.is_due(at(51), false));
        let mut slow = begun(2.0, 30, true);
        assert!(!slow.is_due(at(499), true));
        assert!(slow.is_due(at(501), false));
        assert_eq!(slow.until_due(at(400)), Some(Duration::from_millis(100)));
        let mut stopped = begun(0.0, 30, true);
        assert!(!stopped.is_due(at(10_000), true));
        assert_eq!(stopped.until_due(start), None);
        assert!(begun(-1.0, 0, false).is_due(at(1001), false), "a global rate of 0 counts as 1");
    }

    #[test]
    fn changes_are_drawn_at_the_global_rate_at_most() {
        let start = Instant::now();
        let mut schedule = Schedule::default();
        schedule.set_frame_rate(-1.0, 20);
        let (mut now, mut drawn) = (start, 0);
        while now < start + Duration::from_secs(10) {
            now += schedule.until_due(now).unwrap_or_default().min(Duration::from_millis(10));
            schedule.note_change(now);
            if schedule.is_due(now, true) {
                schedule.begin(now, true);
                drawn += 1;
            }
        }
        assert!((198..=202).contains(&drawn), "{drawn}");
    }

    #[test]
    fn a_trigger_makes_one_image_due_whatever_the_frame_rate() {
        let now = Instant::now();
        let mut schedule = Schedule::default();
        assert!(schedule.is_on_trigger() && !schedule.is_due(now, true));
        schedule.trigger();
        assert!(schedule.is_due(now, false));
        schedule.begin(now, true);
        schedule.clear_trigger();
        assert!(!schedule.is_due(now, true));
        schedule.set_frame_rate(10.0, 30);
        assert_eq!(schedule.until_due(now), Some(Duration::from_millis(100)));
        schedule.trigger();
        assert!(schedule.is_due(now, false));
    }
}
