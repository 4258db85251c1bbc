//! One camera of the node: draws its pictures when they are due and hands them to its outputs.
//!
//! Its parts: [`Schedule`] decides when a picture is due, [`RuntimeSettings`] holds the settings, [`Outputs`] receive
//! the pictures, [`CameraHealth`] records problems and figures.

use std::sync::Arc;
use std::time::{Duration, Instant};

use anyhow::Result;
use rcs_displays::{time_from_stamp, CameraView, DisplaySet};
use rcs_messages::dynamic_reconfigure::Config as Values;
use rcs_messages::sensor_msgs::CameraInfo;
use rcs_render::Renderer;
use rcs_ros::{RosNode, TriggerReply};
use rcs_scene::{Camera, Picture, Scene};

use super::camera_health::CameraHealth;
use super::camera_plan::CameraPlan;
use super::latency::Update;
use super::reconfigurable::Switch;
use super::runtime_settings::RuntimeSettings;
use super::schedule::Schedule;
use crate::camera_stream::camera_pose::Projection;
use crate::camera_stream::outputs::{Frame, Output, Outputs, TopicOutput};
use crate::camera_stream::stage::{renderer_view, Stage};
use crate::camera_stream::status_tree::StatusEntry;

/// A camera with its outputs and its trigger service.
pub(super) struct CameraOutput {
    /// Identifies it when the config is read again; its parameters are below this name.
    id: String,
    view: CameraView,
    settings: RuntimeSettings,
    /// The config's "Global Options: Frame Rate".
    global_frame_rate_hz: i32,
    schedule: Schedule,
    connections: CameraConnections,
    last: Option<LastPicture>,
    in_flight: Option<Drawn>,
    health: CameraHealth,
}

/// What connects a camera to the world outside.
#[derive(Default)]
pub(super) struct CameraConnections {
    pub(super) outputs: Outputs,
    /// The whole name of its trigger service; `None` where another camera has that name.
    pub(super) trigger_service: Option<Arc<str>>,
}

/// What a picture shows: the state of the scene and the camera.
struct Drawn {
    scene_version: u64,
    camera: Camera,
    info: Arc<CameraInfo>,
}

/// The picture that was finished last.
struct LastPicture {
    picture: Arc<Picture>,
    of: Drawn,
}

/// The scene that all cameras share, and what draws it.
pub(super) struct Drawing<'a> {
    pub(super) stage: &'a Stage,
    pub(super) scene_version: u64,
    pub(super) projection: Projection,
    pub(super) renderer: &'a mut dyn Renderer,
    pub(super) ros: &'a RosNode,
}

/// The cameras' names, for the log.
pub(super) fn names(cameras: &[CameraOutput]) -> String {
    match cameras {
        [] => "no camera".to_owned(),
        cameras => cameras.iter().map(CameraOutput::name).collect::<Vec<_>>().join(", "),
    }
}

impl CameraOutput {
    /// A camera without connections; [`Self::apply`] gives it those.
    pub(super) fn new(ros: &RosNode, plan: &CameraPlan, switches: &Arc<[Switch]>) -> Self {
        Self {
            id: plan.id.clone(),
            view: plan.view(),
            settings: RuntimeSettings::start(ros, &plan.id, &plan.settings, switches),
            global_frame_rate_hz: 0,
            schedule: Schedule::new(),
            connections: CameraConnections::default(),
            last: None,
            in_flight: None,
            health: CameraHealth::default(),
        }
    }

    /// Takes over the settings and connections that a config gives it.
    pub(super) fn apply(
        &mut self,
        plan: &CameraPlan,
        connections: CameraConnections,
        switches: &Arc<[Switch]>,
        global_frame_rate_hz: i32,
        ros: &RosNode,
        displays: &DisplaySet,
    ) {
        self.settings.update_from(ros, &plan.settings, switches);
        self.view = plan.view();
        self.connections = connections;
        self.global_frame_rate_hz = global_frame_rate_hz;
        self.apply_settings(displays);
    }

    /// Gives its connections away, for the cameras of another config.
    pub(super) fn release(&mut self) -> CameraConnections {
        std::mem::take(&mut self.connections)
    }

    /// Applies the current settings from the next picture on.
    fn apply_settings(&mut self, displays: &DisplaySet) {
        self.settings.write_to(&mut self.view.settings);
        self.view.visible = displays.mask(&self.view.settings.visibility);
        self.schedule.set_frame_rate(self.view.settings.frame_rate_hz, self.global_frame_rate_hz);
        self.last = None;
    }

    /// Identifies it when the config is read again.
    pub(super) fn id(&self) -> &str {
        &self.id
    }

    /// The display's name.
    pub(super) fn name(&self) -> &str {
        &self.view.name
    }

    /// The camera with its current settings.
    pub(super) fn view(&self) -> &CameraView {
        &self.view
    }

    /// Its statuses.
    pub(super) fn status_entry(&self, stage: &Stage, projection: Projection) -> StatusEntry<'static> {
        self.health.status_entry(stage, &self.view, projection, &self.connections)
    }

    /// Records an update of the scene, for the latency figures.
    pub(super) fn record_update(&mut self, update: &Update<'_>) {
        self.health.latency.record_update(update, &self.view.visible);
    }

    /// Forgets the messages that the next picture would have been measured by: the time jumped back.
    pub(super) fn forget_messages(&mut self) {
        self.health.latency.forget();
    }

    /// Records the result of rendering and publishing. An error is logged once.
    pub(super) fn record_result(&mut self, result: Result<()>) {
        self.health.record_result(&self.view.name, result);
    }

    /// Whether its parameters are served under this name.
    pub(super) fn has_parameters(&self, server: &str) -> bool {
        self.settings.serves(server)
    }

    /// Applies a user's values. Returns the values that apply now.
    pub(super) fn reconfigure(&mut self, request: &Values, displays: &DisplaySet, ros: &RosNode) -> Values {
        let values = self.settings.set(ros, request);
        self.apply_settings(displays);
        values
    }

    /// Whether this is the camera of a trigger service.
    pub(super) fn serves(&self, service: &str) -> bool {
        self.connections.trigger_service.as_deref() == Some(service)
    }

    /// Answers a call of the trigger service; the picture follows.
    pub(super) fn trigger(&mut self, reply: TriggerReply) {
        let outputs = &self.connections.outputs;
        if outputs.is_empty() {
            reply.send(false, "Image publisher not configured");
        } else {
            self.schedule.trigger();
            let topic = outputs.topic.as_ref().map_or("another output", TopicOutput::topic);
            reply.send(true, format!("New image will be published on: {topic}"));
        }
    }

    /// How long until a picture is due by itself; `None` when that is never.
    pub(super) fn until_due(&self, now: Instant) -> Option<Duration> {
        // A camera that cannot draw is retried when a message arrives.
        let can_draw = !self.health.has_problem() && self.connections.outputs.is_watched();
        self.schedule.until_due(now).filter(|_| can_draw)
    }

    /// Begins a picture if one is due and has changed; [`Self::finish`] publishes it. An unchanged one is published at
    /// once. `scene` is called for what is drawn. Returns whether a picture was begun.
    ///
    /// # Errors
    /// The renderer's, and those of the outputs.
    pub(super) fn begin_if_due(&mut self, drawing: Drawing<'_>, scene: impl FnOnce() -> Arc<Scene>) -> Result<bool> {
        let Drawing { stage, scene_version, projection, renderer, ros } = drawing;
        if !self.connections.outputs.is_watched() {
            self.schedule.clear_trigger();
            self.health.latency.forget();
            return Ok(false);
        }
        let camera = match stage.camera(&self.view, projection) {
            Ok(camera) => camera,
            Err(problem) => {
                // The last picture must not pass for a current one.
                self.last = None;
                self.health.record_problem(&self.view.name, problem, Instant::now());
                return Ok(false);
            }
        };
        self.health.clear_problem(&self.view.name);
        let Some(info) = stage.camera_info(&self.view).cloned() else { return Ok(false) };
        let is_current = |last: &LastPicture| last.of.scene_version == scene_version && last.of.camera == camera;
        let changed = !self.last.as_ref().is_some_and(is_current);
        let now = Instant::now();
        let has_new_watcher = !self.schedule.is_on_trigger() && self.connections.outputs.take_new_watcher();
        if !(has_new_watcher || self.schedule.is_due(now, changed)) {
            return Ok(false);
        }
        self.schedule.begin(now, changed);
        if changed {
            self.health.warn_about_projection(&self.view, &info, projection);
            renderer.submit(&renderer_view(&self.view, &scene(), &camera))?;
            self.in_flight = Some(Drawn { scene_version, camera, info });
            return Ok(true);
        }
        if let Some(last) = &mut self.last {
            last.of.info = info;
        }
        self.publish_last(None, ros)?;
        Ok(false)
    }

    /// Waits for the picture that was begun, which is the renderer's first in flight, and publishes it.
    ///
    /// # Errors
    /// The renderer's, and those of the outputs.
    pub(super) fn finish(&mut self, renderer: &mut dyn Renderer, ros: &RosNode) -> Result<()> {
        let Some(of) = self.in_flight.take() else { return Ok(()) };
        // The last picture's memory is used again, unless an output still holds it.
        let recycled = self.last.take().and_then(|last| Arc::try_unwrap(last.picture).ok());
        let mut picture = recycled.unwrap_or_default();
        if !renderer.finish(&mut picture)? {
            return Ok(());
        }
        self.health.drawn += 1;
        self.last = Some(LastPicture { picture: Arc::new(picture), of });
        self.publish_last(Some(Instant::now()), ros)
    }

    /// Forgets the picture that was begun: the renderer lost those of all cameras. The next call begins it again.
    pub(super) fn discard_in_flight(&mut self) {
        self.in_flight = None;
    }

    /// Hands the last picture to the outputs. `drawn`: when it was drawn, if it is a new one.
    fn publish_last(&mut self, drawn: Option<Instant>, ros: &RosNode) -> Result<()> {
        let Some(last) = self.last.as_ref().filter(|_| !self.connections.outputs.is_empty()) else { return Ok(()) };
        let stamp = ros.now();
        let frame = Frame { picture: Arc::clone(&last.picture), info: Arc::clone(&last.of.info), stamp };
        self.connections.outputs.send(&frame)?;
        if let Some(drawn) = drawn {
            self.health.latency.measure(drawn, Instant::now(), time_from_stamp(stamp));
        }
        self.health.published += 1;
        self.schedule.clear_trigger();
        Ok(())
    }
}
