//! Problems, counters and latency of one of the node's cameras, for the log and its statuses.

use std::time::{Duration, Instant};

use anyhow::Error;
use rcs_camera::CameraModel;
use rcs_displays::{CameraView, Level};
use rcs_light::DarkReason;
use rcs_logging::one_line;

use super::connections::CameraConnections;
use super::latency::Latency;
use crate::projection_warning::ProjectionWarning;
use crate::scene::camera_pose::CameraProblem;
use crate::scene::status_tree::{self, StatusEntry};
use crate::scene::SceneState;

/// Time without a CameraInfo or a transform before that is logged: at the start it is usually just on its way.
const PATIENCE: Duration = Duration::from_secs(2);

/// Time for which a slow frame remains a status.
const SLOW_STATUS: Duration = Duration::from_secs(10);
/// Time until another slow frame is logged.
const SLOW_SILENCE: Duration = Duration::from_secs(60);

/// The health of a camera.
#[derive(Debug, Default)]
pub(super) struct CameraHealth {
    problem: ProblemLog,
    /// Why images are black at present, though there is a camera.
    dark: Option<DarkReason>,
    /// Why a frame failed, unless one was published since.
    last_error: Option<String>,
    /// Deviations of the CameraInfo from what is drawn.
    pub(super) projection: ProjectionWarning,
    slow: SlowFrames,
    pub(super) counts: FrameCounts,
    pub(super) latency: Latency,
}

/// Logs why there is no camera.
#[derive(Debug, Default)]
struct ProblemLog {
    /// The present problem, and since when it lasts.
    current: Option<(CameraProblem, Instant)>,
    is_logged: bool,
    /// `true` if a problem was logged since the camera was last there: this one, or another before it.
    has_logged: bool,
}

/// The last frame that took long.
#[derive(Debug, Default)]
struct SlowFrames {
    /// Its time, and its description.
    last: Option<(Instant, String)>,
    logged: Option<Instant>,
}

/// Counters of a camera's frames.
#[derive(Debug, Default)]
pub(super) struct FrameCounts {
    pub(super) drawn: u64,
    pub(super) depths_drawn: u64,
    /// Unchanged ones included.
    published: u64,
}

impl ProblemLog {
    fn record(&mut self, camera: &str, problem: CameraProblem, now: Instant) {
        let since = match &self.current {
            // Its text has times in it.
            Some((CameraProblem::NoTransform { .. }, since)) => {
                matches!(problem, CameraProblem::NoTransform { .. }).then_some(*since)
            }
            // Compared as text: a NaN in a problem is not equal to itself.
            Some((known, since)) => (known.to_string() == problem.to_string()).then_some(*since),
            None => None,
        };
        self.is_logged &= since.is_some();
        let since = since.unwrap_or(now);
        let is_invalid = matches!(problem, CameraProblem::BadCameraInfo { .. });
        if !self.is_logged && (is_invalid || now.saturating_duration_since(since) >= PATIENCE) {
            (self.is_logged, self.has_logged) = (true, true);
            let level = if is_invalid { log::Level::Error } else { log::Level::Warn };
            log::log!(level, "camera {camera}: {problem}");
        }
        self.current = Some((problem, since));
    }

    fn clear(&mut self, camera: &str) {
        if self.current.take().is_some() && std::mem::take(&mut self.has_logged) {
            log::info!("camera {camera}: ok");
        }
    }
}

impl CameraHealth {
    /// `true` if there is no camera at present.
    pub(super) fn has_problem(&self) -> bool {
        self.problem.current.is_some()
    }

    /// Frames published so far, unchanged ones included.
    pub(super) fn published(&self) -> u64 {
        self.counts.published
    }

    /// Why there is no camera at present.
    pub(super) fn problem(&self) -> Option<String> {
        self.problem.current.as_ref().map(|(problem, _)| problem.to_string())
    }

    /// Records why a frame failed. An error is logged once, and stays until an image is published.
    pub(super) fn record_error(&mut self, camera: &str, error: &Error) {
        let error = one_line(error);
        if self.last_error.as_ref() != Some(&error) {
            log::error!("camera {camera}: {error}");
        }
        self.last_error = Some(error);
    }

    /// Records that an image was published.
    pub(super) fn record_published(&mut self) {
        self.counts.published += 1;
        self.last_error = None;
    }

    /// Records a frame that took long, and logs it unless another was logged in the last minute.
    pub(super) fn record_slow_frame(&mut self, camera: &str, text: String) {
        let now = Instant::now();
        let is_quiet = |logged: Instant| now.saturating_duration_since(logged) < SLOW_SILENCE;
        if !self.slow.logged.is_some_and(is_quiet) {
            self.slow.logged = Some(now);
            log::warn!("camera {camera}: {text}");
        }
        self.slow.last = Some((now, text));
    }

    /// Records why there is no camera, and logs it once: an invalid CameraInfo at once, what may still arrive when it
    /// has been missing for a while.
    pub(super) fn record_problem(&mut self, camera: &str, problem: CameraProblem, now: Instant) {
        self.problem.record(camera, problem, now);
        self.latency.forget();
    }

    /// Records that there is a camera, and logs it if it was logged that there is none.
    pub(super) fn clear_problem(&mut self, camera: &str) {
        self.problem.clear(camera);
    }

    /// Records why images are black though there is a camera, and logs when that begins and ends.
    pub(super) fn record_dark(&mut self, camera: &str, dark: Option<&DarkReason>) {
        if self.dark.as_ref() == dark {
            return;
        }
        match dark {
            Some(why) => log::warn!("camera {camera}: the picture is black: {why}"),
            None => log::info!("camera {camera}: the picture is shown again"),
        }
        self.dark = dark.cloned();
    }

    pub(super) fn status_entry(
        &self,
        scene: &SceneState,
        view: &CameraView,
        model: CameraModel,
        connections: &CameraConnections,
    ) -> StatusEntry<'static> {
        let mut entry = status_tree::camera(scene, view, model);
        let statuses = entry.statuses.to_mut();
        if connections.outputs.is_empty() && statuses.level() < Level::Error {
            statuses.set(Level::Error, "Output Topic", "Image publisher not configured");
        } else if connections.trigger_service.is_none() {
            let text = "Could not create trigger. Make sure that display namespace is unique!";
            statuses.set(Level::Warn, "Display namespace", text);
        } else {
            statuses.set(Level::Ok, "Display namespace", "OK");
        }
        if let Some(error) = &self.last_error {
            statuses.set(Level::Error, "Picture", error.clone());
        }
        let is_recent = |(at, _): &&(Instant, String)| at.elapsed() < SLOW_STATUS;
        if let Some((_, text)) = self.slow.last.as_ref().filter(is_recent) {
            statuses.set(Level::Warn, "Speed", text.clone());
        }
        if let Some(topic) = &connections.outputs.topic {
            entry.topic = topic.topic().to_owned();
            entry.values.push(("subscribers", topic.subscriber_count().to_string()));
        }
        entry.values.push(("frames drawn", self.counts.drawn.to_string()));
        entry.values.push(("depths drawn", self.counts.depths_drawn.to_string()));
        entry.values.push(("frames published", self.counts.published.to_string()));
        entry.values.extend(self.latency.values());
        if let Some(prediction) = scene.prediction() {
            entry.values.push(("frames predicted ahead ms", format!("{:.2}", prediction.lead.as_secs_f64() * 1e3)));
        }
        entry
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_camera_info_that_is_a_moment_late_is_not_logged() {
        let (mut problem, start) = (ProblemLog::default(), Instant::now());
        let mut is_logged_after = |millis| {
            let no_info = CameraProblem::NoCameraInfo { topic: "/eye/camera_info".to_owned() };
            problem.record("eye", no_info, start + Duration::from_millis(millis));
            problem.is_logged
        };
        assert_eq!([0, 1000, 1999, 2000].map(&mut is_logged_after), [false, false, false, true]);
    }

    #[test]
    fn an_error_stays_until_an_image_is_published() {
        let mut health = CameraHealth::default();
        for _ in 0..2 {
            health.record_error("eye", &anyhow::anyhow!("the disk is full"));
            assert_eq!(health.last_error.as_deref(), Some("the disk is full"));
        }
        health.record_published();
        assert_eq!(health.last_error, None);
    }
}
