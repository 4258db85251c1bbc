//! When a camera's next picture is due.

use std::time::{Duration, Instant};

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
    pub(super) fn is_due(self, last: Option<Instant>, now: Instant, changed: bool) -> bool {
        let passed = |period| last.is_none_or(|last| now.saturating_duration_since(last) >= period);
        match self {
            Self::OnChange { repeat } => changed || passed(repeat),
            Self::OnTrigger => false,
            Self::Every(period) => passed(period),
        }
    }

    /// How long until a picture is due by itself; `None` when it never is.
    pub(super) fn until_due(self, last: Option<Instant>, now: Instant) -> Option<Duration> {
        let period = match self {
            Self::OnChange { repeat } => repeat,
            Self::OnTrigger => return None,
            Self::Every(period) => period,
        };
        Some(last.map_or(Duration::ZERO, |last| period.saturating_sub(now.saturating_duration_since(last))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_frame_rate_says_when_pictures_are_due() {
        let start = Instant::now();
        let at = |millis| start + Duration::from_millis(millis);
        let fast = Pace::new(-1.0, 30);
        assert!(fast.is_due(Some(start), at(1), true), "a change is drawn at once");
        assert!(!fast.is_due(Some(start), at(30), false));
        assert!(fast.is_due(Some(start), at(34), false), "an unchanged scene is repeated at rviz's rate");
        let slow = Pace::new(2.0, 30);
        assert!(!slow.is_due(Some(start), at(499), true));
        assert!(slow.is_due(Some(start), at(501), false));
        assert_eq!(slow.until_due(Some(start), at(400)), Some(Duration::from_millis(100)));
        let stopped = Pace::new(0.0, 30);
        assert!(!stopped.is_due(None, at(10_000), true));
        assert_eq!(stopped.until_due(None, start), None);
        assert!(Pace::new(-1.0, 0).is_due(Some(start), at(1001), false), "a global rate of 0 counts as 1");
    }
}
