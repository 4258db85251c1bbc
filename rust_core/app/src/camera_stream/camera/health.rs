//! Status of one of the node's cameras: its problems, its counters and its latency, for the log and its statuses.

use std::time::{Duration, Instant};

use anyhow::Result;
use rcs_camera::CameraModel;
use rcs_displays::{CameraView, Level};

use crate::camera_stream::camera::latency::Latency;
use crate::camera_stream::camera::output::CameraConnections;
use crate::camera_stream::camera::progress::Progress;
use crate::camera_stream::projection_warning::ProjectionWarning;
use crate::camera_stream::safety::causes::Dark;
use crate::camera_stream::scene::camera_pose::CameraProblem;
use crate::camera_stream::scene::status_tree::{self, StatusEntry};
use crate::camera_stream::scene::SceneState;
use rcs_logging::one_line;

/// How long a CameraInfo or a frame may be missing before that is logged: at the start it is usually just on its way.
const PATIENCE: Duration = Duration::from_secs(2);

/// How long a slow picture remains a status.
const SLOW_STATUS: Duration = Duration::from_secs(10);
/// How long the next slow picture is not logged.
const SLOW_SILENCE: Duration = Duration::from_secs(60);

/// What is known of a camera's pictures.
#[derive(Debug, Default)]
pub(crate) struct CameraHealth {
    /// Why there is no camera at present, since when, and whether that was logged.
    problem: Option<CameraProblem>,
    problem_since: Option<Instant>,
    is_problem_logged: bool,
    /// Whether a problem was logged since the camera was last there: this one, or another before it.
    has_logged_problem: bool,
    /// Why the picture is black at present, though there is a camera.
    dark: Option<Dark>,
    /// Why a picture failed, unless one was published since.
    last_error: Option<String>,
    /// What makes a projection miss.
    pub(crate) projection: ProjectionWarning,
    /// When a picture last took long, and what it took so long for.
    slow_picture: Option<(Instant, String)>,
    slow_picture_logged: Option<Instant>,
    /// Pictures drawn.
    pub(crate) drawn: u64,
    /// Pictures whose depths were drawn, too.
    pub(crate) depths_drawn: u64,
    /// Pictures published, unchanged ones included.
    pub(crate) published: u64,
    pub(crate) latency: Latency,
}

impl CameraHealth {
    /// Whether there is no camera at present.
    pub(crate) fn has_problem(&self) -> bool {
        self.problem.is_some()
    }

    /// Records the result of rendering and publishing. An error is logged once, and stays until an image is published.
    pub(crate) fn record_result(&mut self, camera: &str, result: Result<Progress>) {
        match result {
            Ok(Progress::NotDue | Progress::Begun(())) => {}
            Ok(Progress::Published) => self.last_error = None,
            Err(error) => {
                let error = one_line(&error);
                if self.last_error.as_ref() != Some(&error) {
                    log::error!("camera {camera}: {error}");
                }
                self.last_error = Some(error);
            }
        }
    }

    /// Records a picture that took long, and logs it unless another was logged in the last minute.
    pub(crate) fn record_slow_picture(&mut self, camera: &str, text: String) {
        let now = Instant::now();
        let is_quiet = |logged: Instant| now.saturating_duration_since(logged) < SLOW_SILENCE;
        if !self.slow_picture_logged.is_some_and(is_quiet) {
            self.slow_picture_logged = Some(now);
            log::warn!("camera {camera}: {text}");
        }
        self.slow_picture = Some((now, text));
    }

    /// Records why there is no camera, and logs it once: an invalid CameraInfo at once, what may still arrive when it
    /// has been missing for a while.
    pub(crate) fn record_problem(&mut self, camera: &str, problem: CameraProblem, now: Instant) {
        let same_kind = |known: &CameraProblem| std::mem::discriminant(known) == std::mem::discriminant(&problem);
        let is_new = match (&self.problem, &problem) {
            // Its text has times in it.
            (Some(known @ CameraProblem::NoTransform { .. }), _) => !same_kind(known),
            // Compared as text: a NaN in a problem is not equal to itself.
            (known, _) => known.as_ref().map(ToString::to_string) != Some(problem.to_string()),
        };
        if is_new {
            self.problem_since = Some(now);
            self.is_problem_logged = false;
        }
        let lasts = self.problem_since.map_or(Duration::ZERO, |since| now.saturating_duration_since(since));
        let is_invalid = matches!(problem, CameraProblem::BadCameraInfo { .. });
        if !self.is_problem_logged && (is_invalid || lasts >= PATIENCE) {
            self.is_problem_logged = true;
            self.has_logged_problem = true;
            let level = if is_invalid { log::Level::Error } else { log::Level::Warn };
            log::log!(level, "camera {camera}: {problem}");
        }
        self.problem = Some(problem);
        self.latency.forget();
    }

    /// Records that there is a camera, and logs it if it was logged that there is none.
    pub(crate) fn clear_problem(&mut self, camera: &str) {
        if self.problem.take().is_some() && std::mem::take(&mut self.has_logged_problem) {
            log::info!("camera {camera}: ok");
        }
    }

    /// Records why the picture is black though there is a camera, and logs when that begins and ends.
    pub(crate) fn record_dark(&mut self, camera: &str, dark: Option<&Dark>) {
        if self.dark.as_ref() == dark {
            return;
        }
        match dark {
            Some(why) => log::warn!("camera {camera}: the picture is black: {why}"),
            None => log::info!("camera {camera}: the picture is shown again"),
        }
        self.dark = dark.cloned();
    }

    /// The camera's statuses and figures.
    pub(crate) fn status_entry(
        &self,
        stage: &SceneState,
        view: &CameraView,
        model: CameraModel,
        connections: &CameraConnections,
    ) -> StatusEntry<'static> {
        let mut entry = status_tree::camera(stage, view, model);
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
        if let Some((_, text)) = self.slow_picture.as_ref().filter(is_recent) {
            statuses.set(Level::Warn, "Speed", text.clone());
        }
        if let Some(topic) = &connections.outputs.topic {
            entry.topic = topic.topic().to_owned();
            entry.values.push(("subscribers", topic.subscriber_count().to_string()));
        }
        entry.values.push(("frames drawn", self.drawn.to_string()));
        entry.values.push(("depths drawn", self.depths_drawn.to_string()));
        entry.values.push(("frames published", self.published.to_string()));
        entry.values.extend(self.latency.values());
        if let Some(prediction) = stage.prediction() {
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
        let (mut health, start) = (CameraHealth::default(), Instant::now());
        let mut is_logged_after = |millis| {
            let problem = CameraProblem::NoCameraInfo { topic: "/eye/camera_info".to_owned() };
            health.record_problem("eye", problem, start + Duration::from_millis(millis));
            health.is_problem_logged
        };
        assert_eq!([0, 1000, 1999, 2000].map(&mut is_logged_after), [false, false, false, true]);
    }

    #[test]
    fn an_error_stays_until_an_image_is_published() {
        let mut health = CameraHealth::default();
        let mut error_after = |result: Result<Progress>| {
            health.record_result("eye", result);
            health.last_error.clone()
        };
        let fails = || Err(anyhow::anyhow!("the disk is full"));
        let error = Some("the disk is full".to_owned());
        assert_eq!(error_after(Ok(Progress::Published)), None);
        assert_eq!(error_after(fails()), error);
        assert_eq!(error_after(Ok(Progress::NotDue)), error);
        assert_eq!(error_after(Ok(Progress::Begun(()))), error);
        assert_eq!(error_after(fails()), error);
        assert_eq!(error_after(Ok(Progress::Published)), None);
    }
}
