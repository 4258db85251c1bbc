//! Timing of a camera's frames: by its frame rate, changes, triggers, and the screen's refresh.

use std::time::{Duration, Instant};

use rcs_camera::Schedule;
use rcs_window::Refresh;

use super::frame::FrameSpec;
use super::pacing::Pacing;

/// The timing of one camera's frames.
#[derive(Default)]
pub(super) struct FrameTiming {
    pub(super) schedule: Schedule,
    pub(super) pacing: Pacing,
    /// The config's "Global Options: Frame Rate".
    pub(super) global_frame_rate_hz: i32,
    /// The newest change that was not drawn yet.
    waiting_change: Option<FrameSpec>,
}

impl FrameTiming {
    pub(super) fn set_frame_rate(&mut self, frame_rate_hz: f32) {
        self.schedule.set_frame_rate(frame_rate_hz, self.global_frame_rate_hz);
    }

    /// Records the frame that would be drawn now, if it differs from the last one.
    pub(super) fn note_change(&mut self, changed: Option<&FrameSpec>, now: Instant) {
        let is_known = |spec| self.waiting_change.as_ref().is_some_and(|waiting| waiting.looks_like(spec));
        if changed.is_some_and(|spec| !is_known(spec)) {
            self.schedule.note_change(now);
        }
        self.waiting_change = changed.cloned();
    }

    /// Returns `true` if a frame is due, which counts as begun then. `changed`: it differs from the last one;
    /// `is_urgent`: it waits for neither the frame rate nor the screen's refresh.
    pub(super) fn take_due(&mut self, changed: bool, is_urgent: bool, refresh: Option<Refresh>, now: Instant) -> bool {
        let is_due = is_urgent || self.schedule.is_due(now, changed);
        let waits = changed && !is_urgent && self.pacing.wait(refresh, now).is_some();
        if is_due && !waits {
            self.schedule.begin(now, changed);
        }
        is_due && !waits
    }

    /// Time until a frame is due by itself; `None` when that is never.
    pub(super) fn until_due(&self, refresh: Option<Refresh>, now: Instant) -> Option<Duration> {
        // What waits for the screen's refresh is not due before.
        let paced = self.waiting_change.is_some().then(|| self.pacing.wait(refresh, now)).flatten();
        self.schedule.until_due(now).map(|due| due.max(paced.unwrap_or_default()))
    }
}
