//! When a camera's next picture is due.

use std::time::{Duration, Instant};

/// When a camera last published, and what.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Published {
    /// When.
    pub at: Instant,
    /// It differed from the picture before.
    pub was_new: bool,
}

/// A CameraPub display's "Frame Rate".
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Pace {
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
    pub(super) fn new(frame_rate_hz: f32, global_frame_rate_hz: i32) -> Self {
        let period = |rate_hz: f64| Duration::try_from_secs_f64(1.0 / rate_hz).unwrap_or(Duration::MAX);
        if frame_rate_hz < 0.0 {
            Self::OnChange { repeat: period(f64::from(global_frame_rate_hz.max(1))) }
        } else if frame_rate_hz > 0.0 {
            Self::Every(period(f64::from(frame_rate_hz)))
        } else {
            Self::OnTrigger
        }
    }

    /// Whether a picture is due, `changed` telling whether it would differ from the last one.
    pub(super) fn is_due(self, last: Option<Published>, now: Instant, changed: bool) -> bool {
        let is_change = changed && matches!(self, Self::OnChange { .. });
        is_change || self.until_due(last, now) == Some(Duration::ZERO)
    }

    /// How long until a picture is due by itself; `None` when it never is.
    pub(super) fn until_due(self, last: Option<Published>, now: Instant) -> Option<Duration> {
        let period = match self {
            // A scene that changes about as often as it would be repeated is not to be late because its old picture is
            // just being sent, so that the first repetition has half a period more.
            Self::OnChange { repeat } if last.is_some_and(|last| last.was_new) => repeat.saturating_add(repeat / 2),
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
    fn the_frame_rate_says_when_pictures_are_due() {
        let start = Instant::now();
        let at = |millis| start + Duration::from_millis(millis);
        let (new, old) = (Published { at: start, was_new: true }, Published { at: start, was_new: false });
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
}
