//! When a camera's next picture is due.

use std::time::{Duration, Instant};

/// When a camera's last picture was begun, and whether it differed from the one before.
#[derive(Clone, Copy, Debug, PartialEq)]
struct LastBegun {
    at: Instant,
    changed: bool,
}

/// Decides when a camera's pictures are due: by its frame rate, or because its trigger service was called.
#[derive(Clone, Copy, Debug)]
pub(super) struct Schedule {
    pace: Pace,
    triggered: bool,
    last: Option<LastBegun>,
}

impl Schedule {
    /// Only when triggered, until a frame rate is set.
    pub(super) fn new() -> Self {
        Self { pace: Pace::OnTrigger, triggered: false, last: None }
    }

    /// From a display's "Frame Rate" and the config's global one, both in pictures a second.
    pub(super) fn set_frame_rate(&mut self, frame_rate_hz: f32, global_frame_rate_hz: i32) {
        self.pace = Pace::new(frame_rate_hz, global_frame_rate_hz);
    }

    /// Whether pictures are published only when triggered.
    pub(super) fn is_on_trigger(&self) -> bool {
        self.pace == Pace::OnTrigger
    }

    /// A picture is due now, whatever the frame rate.
    pub(super) fn trigger(&mut self) {
        self.triggered = true;
    }

    /// The trigger was served, or there is nobody to serve.
    pub(super) fn clear_trigger(&mut self) {
        self.triggered = false;
    }

    /// Whether a picture is due; `changed`: it would differ from the last one.
    pub(super) fn is_due(&self, now: Instant, changed: bool) -> bool {
        self.triggered || self.pace.is_due(self.last, now, changed)
    }

    /// How long until a picture is due by itself; `None` when it never is.
    pub(super) fn until_due(&self, now: Instant) -> Option<Duration> {
        self.pace.until_due(self.last, now)
    }

    /// Records that a picture was begun. The next one is timed from here, also when drawing fails, so that it is
    /// retried at the frame rate and not at once.
    pub(super) fn begin(&mut self, now: Instant, changed: bool) {
        self.last = Some(LastBegun { at: now, changed });
    }
}

/// A CameraPub display's "Frame Rate".
#[derive(Clone, Copy, Debug, PartialEq)]
enum Pace {
    /// Below 0: whenever the scene changes; an unchanged one is repeated at this period.
    OnChange {
        /// That of rviz's main loop ("Global Options: Frame Rate").
        repeat: Duration,
    },
    /// 0: only when triggered.
    OnTrigger,
    /// Above 0: once in this period.
    Every(Duration),
}

impl Pace {
    /// From a display's "Frame Rate" and the config's global one, both in pictures a second.
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

    fn is_due(self, last: Option<LastBegun>, now: Instant, changed: bool) -> bool {
        let is_change = changed && matches!(self, Self::OnChange { .. });
        is_change || self.until_due(last, now) == Some(Duration::ZERO)
    }

    fn until_due(self, last: Option<LastBegun>, now: Instant) -> Option<Duration> {
        let period = match self {
            // A scene that changes about as often as it would be repeated must not be late because its old picture is
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
    fn pictures_are_due_at_the_frame_rate() {
        let start = Instant::now();
        let at = |millis| start + Duration::from_millis(millis);
        let (new, old) = (LastBegun { at: start, changed: true }, LastBegun { at: start, changed: false });
        let fast = Pace::new(-1.0, 30);
        assert!(fast.is_due(Some(new), at(1), true), "a change is drawn at once");
        assert!(!fast.is_due(Some(old), at(33), false));
        assert!(fast.is_due(Some(old), at(34), false), "an unchanged scene is repeated at rviz's rate");
        assert!(!fast.is_due(Some(new), at(49), false), "what changes at that rate is not repeated between");
        assert!(fast.is_due(Some(new), at(51), false));
        let slow = Pace::new(2.0, 30);
        assert!(!slow.is_due(Some(new), at(499), true));
        assert!(slow.is_due(Some(new), at(501), false));
        assert_eq!(slow.until_due(Some(new), at(400)), Some(Duration::from_millis(100)));
        let stopped = Pace::new(0.0, 30);
        assert!(!stopped.is_due(None, at(10_000), true));
        assert_eq!(stopped.until_due(None, start), None);
        assert!(Pace::new(-1.0, 0).is_due(Some(old), at(1001), false), "a global rate of 0 counts as 1");
    }

    #[test]
    fn a_trigger_makes_one_picture_due_whatever_the_frame_rate() {
        let now = Instant::now();
        let mut schedule = Schedule::new();
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
