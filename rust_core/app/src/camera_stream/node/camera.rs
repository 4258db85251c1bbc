//! One camera of the node: draws its pictures when they are due and hands them to its outputs.
//!
//! Its parts: [`Schedule`] decides when a picture is due, [`RuntimeSettings`] holds the settings, [`Outputs`] receive
//! the pictures, [`CameraHealth`] records problems and figures.
//!
//! A camera belongs to both of the node's threads, see [`super::shared`]: the scene's thread draws its pictures, and
//! the control thread answers calls and repeats the last picture while another is drawn for long. None of its methods
//! takes long; the drawing itself is done between [`CameraOutput::begin_if_due`] and [`CameraOutput::finish`].

use std::sync::Arc;
use std::time::{Duration, Instant};

use anyhow::Result;
use rcs_displays::{time_from_stamp, CameraView, DisplaySet};
use rcs_messages::dynamic_reconfigure::Config as Values;
use rcs_messages::sensor_msgs::CameraInfo;
use rcs_ros::{RosNode, TriggerReply};
use rcs_scene::{Camera, Picture};
use rcs_transforms::Time;

use super::camera_health::CameraHealth;
use super::camera_plan::CameraPlan;
use super::latency::Update;
use super::pacing::Pacing;
use super::reconfigurable::Switch;
use super::runtime_settings::RuntimeSettings;
use super::schedule::Schedule;
use crate::camera_stream::camera_pose::CameraModel;
use crate::camera_stream::outputs::{Frame, Output, Outputs, TopicOutput};
use crate::camera_stream::stage::Stage;
use crate::camera_stream::status_tree::StatusEntry;

/// A camera with its outputs and its trigger service.
pub(super) struct CameraOutput {
    /// Identifies it when the config is read again; its parameters are below this name.
    id: String,
    /// With the settings of the last picture.
    view: Arc<CameraView>,
    settings: RuntimeSettings,
    /// The config's "Global Options: Frame Rate".
    global_frame_rate_hz: i32,
    schedule: Schedule,
    connections: CameraConnections,
    /// A user changed settings since the last picture.
    has_new_settings: bool,
    last: Option<LastPicture>,
    /// The picture before the last one, whose memory is drawn into again unless an output still holds it.
    spare: Option<Arc<Picture>>,
    in_flight: Option<Drawn>,
    /// The newest change that was not drawn yet.
    waiting_change: Option<(u64, Camera)>,
    /// When pictures for a window are begun.
    pacing: Pacing,
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
    /// When its frames were looked up, in ROS time, if they were predicted.
    looked_up: Option<Time>,
}

/// The picture that was finished last.
struct LastPicture {
    picture: Arc<Picture>,
    of: Drawn,
}

/// A picture that is due and to be drawn.
pub(super) struct DuePicture {
    /// The camera's settings.
    pub(super) view: Arc<CameraView>,
    /// Where it is.
    pub(super) camera: Camera,
    info: Arc<CameraInfo>,
    scene_version: u64,
    looked_up: Option<Time>,
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
            view: Arc::new(plan.view()),
            settings: RuntimeSettings::start(ros, &plan.id, &plan.settings, switches),
            global_frame_rate_hz: 0,
            schedule: Schedule::new(),
            connections: CameraConnections::default(),
            has_new_settings: false,
            last: None,
            spare: None,
            in_flight: None,
            waiting_change: None,
            pacing: Pacing::default(),
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
        self.view = Arc::new(plan.view());
        self.connections = connections;
        self.global_frame_rate_hz = global_frame_rate_hz;
        self.has_new_settings = true;
        self.apply_new_settings(displays);
    }

    /// Gives its connections away, for the cameras of another config.
    pub(super) fn release(&mut self) -> CameraConnections {
        std::mem::take(&mut self.connections)
    }

    /// Applies what a user has changed from the next picture on.
    pub(super) fn apply_new_settings(&mut self, displays: &DisplaySet) {
        if !std::mem::take(&mut self.has_new_settings) {
            return;
        }
        let view = Arc::make_mut(&mut self.view);
        self.settings.write_to(&mut view.settings);
        view.visible = displays.mask(&view.settings.visibility);
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
    pub(super) fn view(&self) -> &Arc<CameraView> {
        &self.view
    }

    /// Whether somebody watches its pictures.
    pub(super) fn is_watched(&self) -> bool {
        self.connections.outputs.is_watched()
    }

    /// Forgets the last picture: what it shows is old.
    pub(super) fn discard_last(&mut self) {
        self.last = None;
    }

    /// Its statuses.
    pub(super) fn status_entry(&self, stage: &Stage, model: CameraModel) -> StatusEntry<'static> {
        self.health.status_entry(stage, &self.view, model, &self.connections)
    }

    /// Records an update of the scene, for the latency figures.
    pub(super) fn record_update(&mut self, update: &Update<'_>) {
        self.health.latency.record_update(update, &self.view.visible);
    }

    /// Forgets the messages that the next picture would have been measured by: the time jumped back.
    pub(super) fn forget_messages(&mut self) {
        self.health.latency.forget();
    }

    /// The usual time from looking up frames to publishing the picture, if it is watched and that was measured.
    pub(super) fn way(&self) -> Option<Duration> {
        self.connections.outputs.is_watched().then(|| self.health.latency.way()).flatten()
    }

    /// Records the result of rendering and publishing. An error is logged once.
    pub(super) fn record_result(&mut self, result: Result<()>) {
        self.health.record_result(&self.view.name, result);
    }

    /// Whether its parameters are served under this name.
    pub(super) fn has_parameters(&self, server: &str) -> bool {
        self.settings.serves(server) || self.topic_of(server).is_some()
    }

    /// Its topic, if the server of this name has the settings of that.
    fn topic_of(&self, server: &str) -> Option<&TopicOutput> {
        self.connections.outputs.topic.as_ref().filter(|topic| topic.has_parameters(server))
    }

    /// Takes a user's values of a server for the next picture. Returns the values that apply from then on.
    pub(super) fn reconfigure(&mut self, server: &str, request: &Values, ros: &RosNode) -> Values {
        if let Some(topic) = self.connections.outputs.topic.as_mut().filter(|topic| topic.has_parameters(server)) {
            return topic.reconfigure(ros, request);
        }
        self.has_new_settings = true;
        self.settings.set(ros, request)
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
        // What waits for the screen's refresh is not due before.
        let paced = self.waiting_change.is_some().then(|| self.pacing_wait(now)).flatten().unwrap_or_default();
        self.schedule.until_due(now).filter(|_| can_draw).map(|due| due.max(paced))
    }

    /// The picture that is due now, if it has changed: to be given to the renderer, and to
    /// [`Self::record_begun`] then. An unchanged one is published at once.
    ///
    /// # Errors
    /// Those of the outputs.
    pub(super) fn begin_if_due(
        &mut self,
        stage: &Stage,
        model: CameraModel,
        ros: &RosNode,
    ) -> Result<Option<DuePicture>> {
        self.connections.outputs.topic.iter_mut().for_each(|topic| topic.attend(ros));
        if !self.connections.outputs.is_watched() {
            self.schedule.clear_trigger();
            self.health.latency.forget();
            return Ok(None);
        }
        let camera = match stage.camera(&self.view, model) {
            Ok(camera) => camera,
            Err(problem) => {
                // The last picture must not pass for a current one.
                self.last = None;
                self.health.record_problem(&self.view.name, problem, Instant::now());
                return Ok(None);
            }
        };
        self.health.clear_problem(&self.view.name);
        let Some(info) = stage.camera_info(&self.view).cloned() else { return Ok(None) };
        let scene_version = stage.displays().version_shown(&self.view.visible);
        let is_current = |last: &LastPicture| last.of.scene_version == scene_version && last.of.camera == camera;
        let changed = !self.last.as_ref().is_some_and(is_current);
        let now = Instant::now();
        let change = changed.then(|| (scene_version, camera.clone()));
        if change.is_some() && change != self.waiting_change {
            self.schedule.note_change(now);
        }
        self.waiting_change = change;
        let has_new_watcher = self.has_new_watcher();
        if !has_new_watcher && !self.schedule.is_due(now, changed) {
            return Ok(None);
        }
        if changed && !has_new_watcher && self.pacing_wait(now).is_some() {
            return Ok(None);
        }
        self.schedule.begin(now, changed);
        if changed {
            self.health.warn_about_projection(&self.view, &info, model);
            let looked_up = stage.prediction().map(|prediction| prediction.now);
            return Ok(Some(DuePicture { view: Arc::clone(&self.view), camera, info, scene_version, looked_up }));
        }
        if let Some(last) = &mut self.last {
            last.of.info = info;
        }
        self.publish_last(None, ros)?;
        Ok(None)
    }

    /// How long a new picture waits for the screen's refresh; `None` if it does not.
    fn pacing_wait(&self, now: Instant) -> Option<Duration> {
        self.pacing.wait(self.connections.outputs.refresh(), now)
    }

    /// Whether somebody subscribed who is to get a picture at once.
    fn has_new_watcher(&mut self) -> bool {
        !self.schedule.is_on_trigger() && self.connections.outputs.take_new_watcher()
    }

    /// Publishes the last picture again if that is due: another one is being drawn for long.
    ///
    /// # Errors
    /// Those of the outputs.
    pub(super) fn repeat_if_due(&mut self, ros: &RosNode) -> Result<()> {
        if self.last.is_none() || !self.connections.outputs.is_watched() {
            return Ok(());
        }
        let now = Instant::now();
        if self.has_new_watcher() || self.schedule.is_repetition_due(now) {
            self.schedule.begin(now, false);
            self.publish_last(None, ros)?;
        }
        Ok(())
    }

    /// Records that the renderer was given a picture.
    pub(super) fn record_begun(&mut self, picture: DuePicture) {
        let DuePicture { camera, info, scene_version, looked_up, .. } = picture;
        self.in_flight = Some(Drawn { scene_version, camera, info, looked_up });
        self.pacing.begin(Instant::now());
    }

    /// Memory for the picture that the renderer is about to finish.
    pub(super) fn take_spare(&mut self) -> Picture {
        self.spare.take().and_then(|spare| Arc::try_unwrap(spare).ok()).unwrap_or_default()
    }

    /// Publishes the picture that was begun, now that it is finished.
    ///
    /// # Errors
    /// Those of the outputs.
    pub(super) fn finish(&mut self, picture: Picture, ros: &RosNode) -> Result<()> {
        let Some(of) = self.in_flight.take() else { return Ok(()) };
        self.health.drawn += 1;
        let is_similar = |spare: &Arc<Picture>| spare.data.len() <= 4 * picture.data.len();
        self.spare = self.last.take().map(|last| last.picture).filter(is_similar);
        self.last = Some(LastPicture { picture: Arc::new(picture), of });
        let published = self.publish_last(Some(Instant::now()), ros);
        self.pacing.finish(Instant::now());
        published
    }

    /// Records a picture that took long.
    pub(super) fn record_slow_picture(&mut self, text: String) {
        self.health.record_slow_picture(&self.view.name, text);
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
            let way = last.of.looked_up.map(|looked_up| time_from_stamp(stamp).saturating_since(looked_up));
            way.into_iter().for_each(|way| self.health.latency.record_way(way));
        }
        self.health.published += 1;
        self.schedule.clear_trigger();
        Ok(())
    }
}
