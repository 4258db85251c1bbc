//! One camera of the node: draws its pictures when they are due and hands them to its outputs.
//!
//! Its parts: [`Schedule`] decides when a picture is due, [`RuntimeSettings`] holds the settings, [`Outputs`] receive
//! the pictures, [`CameraHealth`] records problems and figures.
//!
//! A picture that has become false, because what it shows is too old, is followed by a black one at once, whatever the
//! frame rate; see [`crate::camera_stream::safety`].
//!
//! A camera belongs to both of the node's threads, see [`crate::camera_stream::runtime::shared`]: the scene's thread draws its pictures, and
//! the control thread answers calls and repeats the last picture while another is drawn for long. None of its methods
//! takes long; the drawing itself is done between [`CameraOutput::begin_if_due`] and [`CameraOutput::finish`].

use std::sync::Arc;
use std::time::{Duration, Instant};

use anyhow::Result;
use rcs_camera::{CameraModel, Schedule};
use rcs_displays::{time_from_stamp, CameraView, DisplaySet};
use rcs_messages::dynamic_reconfigure::Config as Values;
use rcs_messages::sensor_msgs::CameraInfo;
use rcs_render::LastStep;
use rcs_ros::{RosNode, TriggerReply};
use rcs_scene::{Camera, DepthPicture, DisplayId, DisplayMask, Picture, MAX_SIDE_PX};
use rcs_transforms::Time;

use crate::camera_stream::camera::frame::{size_px, Content, Drawn, Note};
use crate::camera_stream::camera::health::CameraHealth;
use crate::camera_stream::camera::latency::Update;
use crate::camera_stream::camera::oriented_info::TurnedInfo;
use crate::camera_stream::camera::pacing::Pacing;
use crate::camera_stream::camera::plan::CameraPlan;
use crate::camera_stream::camera::progress::Progress;
use crate::camera_stream::camera::reconfigurable::Switch;
use crate::camera_stream::camera::runtime_settings::RuntimeSettings;
use crate::camera_stream::outputs::depth_image::{DepthEncoding, DepthImage};
use crate::camera_stream::outputs::{Frame, Output, Outputs, TopicOutput};
use crate::camera_stream::safety::black_image::black_picture;
use crate::camera_stream::safety::causes::Dark;
use crate::camera_stream::safety::{self, FramePolicy};
use crate::camera_stream::scene::status_tree::StatusEntry;
use crate::camera_stream::scene::SceneState;

/// A camera with its outputs and its trigger service.
pub(crate) struct CameraOutput {
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
    depth_in_flight: Option<Arc<DepthImage>>,
    depth_encoding: DepthEncoding,
    /// The newest change that was not drawn yet.
    waiting_change: Option<(Content, Arc<LastStep>)>,
    /// When pictures for a window are begun.
    pacing: Pacing,
    /// The displays left out because they are stale, and the size of pictures.
    kind: (Vec<DisplayId>, [u32; 2]),
    /// Counts the kinds of pictures that a window may not hold in each other's place.
    scene: u64,
    turned_info: TurnedInfo,
    health: CameraHealth,
}

/// What connects a camera to the world outside.
#[derive(Default)]
pub(crate) struct CameraConnections {
    pub(crate) outputs: Outputs,
    /// The whole name of its trigger service; `None` where another camera has that name.
    pub(crate) trigger_service: Option<Arc<str>>,
}

/// The picture that was finished last.
struct LastPicture {
    picture: Arc<Picture>,
    /// Where depths were wanted.
    depth: Option<Arc<DepthImage>>,
    /// Before post-processing, where a window may hold it below newer masks.
    drawn: Option<Arc<Picture>>,
    of: Drawn,
}

/// A picture that is due and to be drawn.
pub(crate) struct DuePicture {
    /// The camera's settings.
    pub(crate) view: Arc<CameraView>,
    /// The displays that are drawn.
    pub(crate) visible: DisplayMask,
    /// Where it is.
    pub(crate) camera: Camera,
    drawn: Drawn,
}

/// The cameras' names, for the log.
pub(crate) fn names(cameras: &[CameraOutput]) -> String {
    match cameras {
        [] => "no camera".to_owned(),
        cameras => cameras.iter().map(CameraOutput::name).collect::<Vec<_>>().join(", "),
    }
}

impl CameraOutput {
    /// A camera without connections; [`Self::apply`] gives it those.
    pub(crate) fn new(ros: &RosNode, plan: &CameraPlan, switches: &Arc<[Switch]>) -> Self {
        Self {
            id: plan.id.clone(),
            view: Arc::new(plan.view()),
            settings: RuntimeSettings::start(ros, &plan.id, &plan.settings, switches),
            global_frame_rate_hz: 0,
            schedule: Schedule::default(),
            connections: CameraConnections::default(),
            has_new_settings: false,
            last: None,
            spare: None,
            in_flight: None,
            depth_in_flight: None,
            depth_encoding: DepthEncoding::default(),
            waiting_change: None,
            pacing: Pacing::default(),
            kind: Default::default(),
            scene: 0,
            turned_info: TurnedInfo::default(),
            health: CameraHealth::default(),
        }
    }

    /// Writes depths like this from now on.
    pub(crate) fn set_depth_encoding(&mut self, encoding: DepthEncoding) {
        self.depth_encoding = encoding;
    }

    /// Takes over the settings and connections that a config gives it.
    pub(crate) fn apply(
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
        // What a window holds is of a config that may have had other displays.
        self.scene += 1;
        self.global_frame_rate_hz = global_frame_rate_hz;
        self.has_new_settings = true;
        self.apply_new_settings(displays);
    }

    /// Gives its connections away, for the cameras of another config.
    pub(crate) fn release(&mut self) -> CameraConnections {
        std::mem::take(&mut self.connections)
    }

    /// Applies what a user has changed from the next picture on.
    pub(crate) fn apply_new_settings(&mut self, displays: &DisplaySet) {
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
    pub(crate) fn id(&self) -> &str {
        &self.id
    }

    /// The display's name.
    pub(crate) fn name(&self) -> &str {
        &self.view.name
    }

    /// The camera with its current settings.
    pub(crate) fn view(&self) -> &Arc<CameraView> {
        &self.view
    }

    /// Whether somebody watches its pictures.
    pub(crate) fn is_watched(&self) -> bool {
        self.connections.outputs.is_watched()
    }

    /// Forgets the last picture: what it shows is old.
    pub(crate) fn discard_last(&mut self) {
        self.last = None;
    }

    /// Its statuses.
    pub(crate) fn status_entry(&self, stage: &SceneState, model: CameraModel) -> StatusEntry<'static> {
        self.health.status_entry(stage, &self.view, model, &self.connections)
    }

    /// Records an update of the scene, for the latency figures.
    pub(crate) fn record_update(&mut self, update: &Update<'_>) {
        self.health.latency.record_update(update, &self.view.visible);
    }

    /// Forgets the messages that the next picture would have been measured by: the time jumped back.
    pub(crate) fn forget_messages(&mut self) {
        self.health.latency.forget();
        self.scene += 1;
    }

    /// The usual time from looking up frames to publishing the picture, if it is watched and that was measured.
    pub(crate) fn way(&self) -> Option<Duration> {
        self.connections.outputs.is_watched().then(|| self.health.latency.way()).flatten()
    }

    /// Records the result of rendering and publishing. An error is logged once, and stays until an image is published.
    pub(crate) fn record_result(&mut self, result: Result<Progress>) {
        self.health.record_result(&self.view.name, result);
    }

    /// Whether its parameters are served under this name.
    pub(crate) fn has_parameters(&self, server: &str) -> bool {
        self.settings.serves(server) || self.topic_of(server).is_some()
    }

    /// Its topic, if the server of this name has the settings of that.
    fn topic_of(&self, server: &str) -> Option<&TopicOutput> {
        self.connections.outputs.topic.as_ref().filter(|topic| topic.has_parameters(server))
    }

    /// Takes a user's values of a server for the next picture. Returns the values that apply from then on.
    pub(crate) fn reconfigure(&mut self, server: &str, request: &Values, ros: &RosNode) -> Values {
        if let Some(topic) = self.connections.outputs.topic.as_mut().filter(|topic| topic.has_parameters(server)) {
            return topic.reconfigure(ros, request);
        }
        self.has_new_settings = true;
        self.settings.set(ros, request)
    }

    /// Whether this is the camera of a trigger service.
    pub(crate) fn serves(&self, service: &str) -> bool {
        self.connections.trigger_service.as_deref() == Some(service)
    }

    /// Answers a call of the trigger service; the picture follows.
    pub(crate) fn trigger(&mut self, reply: TriggerReply) {
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
    pub(crate) fn until_due(&self, now: Instant) -> Option<Duration> {
        // A camera that cannot draw is retried when a message arrives.
        let can_draw = (!self.health.has_problem() || self.last.is_some()) && self.connections.outputs.is_watched();
        // What waits for the screen's refresh is not due before.
        let paced = self.waiting_change.is_some().then(|| self.pacing_wait(now)).flatten().unwrap_or_default();
        self.schedule.until_due(now).filter(|_| can_draw).map(|due| due.max(paced))
    }

    /// Begins the picture that is due now, if it has changed: it is to be given to the renderer, and to
    /// [`Self::record_begun`] then. An unchanged one, and a black one, is published at once.
    ///
    /// # Errors
    /// Those of the outputs.
    pub(crate) fn begin_if_due(
        &mut self,
        stage: &SceneState,
        model: CameraModel,
        policy: &FramePolicy,
        ros: &RosNode,
    ) -> Result<Progress<DuePicture>> {
        self.connections.outputs.topic.iter_mut().for_each(|topic| topic.attend(ros));
        if !self.connections.outputs.is_watched() {
            self.schedule.clear_trigger();
            self.health.latency.forget();
            return Ok(Progress::NotDue);
        }
        let camera = match stage.camera(&self.view, model) {
            Ok(camera) => camera,
            Err(problem) => {
                let why = problem.to_string();
                self.health.record_problem(&self.view.name, problem, Instant::now());
                // The last picture must not pass for a current one.
                let Some(dark) = policy.without_camera(&why) else {
                    self.last = None;
                    return Ok(Progress::NotDue);
                };
                let info = stage.camera_info(&self.view).cloned();
                return self.turn_black(info, policy, dark, ros);
            }
        };
        self.health.clear_problem(&self.view.name);
        let Some(info) = stage.camera_info(&self.view).cloned() else { return Ok(Progress::NotDue) };
        let (visible, drawn) = self.allowed(&camera, info, stage, policy);
        let drawn = match self.due(drawn, ros)? {
            Progress::Begun(drawn) => drawn,
            Progress::NotDue => return Ok(Progress::NotDue),
            Progress::Published => return Ok(Progress::Published),
        };
        if let Content::Black { .. } = drawn.content {
            self.health.latency.forget();
            return self.publish_black(drawn, ros).map(|()| Progress::Published);
        }
        self.health.projection.check(stage, &self.view, model);
        Ok(Progress::Begun(DuePicture { view: Arc::clone(&self.view), visible, camera, drawn }))
    }

    /// What may be drawn now, and which displays are.
    fn allowed(
        &mut self,
        camera: &Camera,
        info: Arc<CameraInfo>,
        stage: &SceneState,
        policy: &FramePolicy,
    ) -> (DisplayMask, Drawn) {
        self.health.record_dark(&self.view.name, policy.dark.as_ref());
        let mut visible = self.view.visible.clone();
        policy.hidden.iter().for_each(|display| visible.set(*display, false));
        let kind = (policy.hidden.clone(), size_px(camera));
        if self.kind != kind {
            self.kind = kind;
            self.scene += 1;
        }
        let content = match &policy.dark {
            Some(dark) => Content::Black { size_px: size_px(camera), dark: dark.clone(), note: note(policy, dark) },
            None => {
                let version = stage.displays().version_shown(&visible);
                Content::Scene { version, camera: Box::new(camera.clone()), hidden: policy.hidden.clone() }
            }
        };
        let looked_up = stage.prediction().map(|prediction| prediction.now);
        (visible, self.drawn(content, policy, info, looked_up))
    }

    fn drawn(&self, content: Content, policy: &FramePolicy, info: Arc<CameraInfo>, looked_up: Option<Time>) -> Drawn {
        let (step, protects_eyes, until) = (Arc::clone(&policy.post), policy.protects_eyes, policy.valid_until);
        Drawn { content, step, protects_eyes, scene: self.scene, info, until, looked_up }
    }

    /// The picture if it is due and differs from the last one. That one is published again if only that is due.
    fn due(&mut self, drawn: Drawn, ros: &RosNode) -> Result<Progress<Drawn>> {
        let last = self.last.as_ref().map(|last| &last.of);
        let lacks_depth =
            self.connections.outputs.wants_depth() && self.last.as_ref().is_some_and(|last| last.depth.is_none());
        let changed = lacks_depth || last.is_none_or(|last| !last.shows_the_same(&drawn));
        // What has become false, or true again, does not wait for the frame rate; nor does light that is forbidden now,
        // unless pictures follow changes anyway.
        let is_urgent = last.is_some_and(|last| {
            last.content.differs_in_age(&drawn.content) || (last.step != drawn.step && !self.schedule.follows_changes())
        });
        let now = Instant::now();
        let change = changed.then(|| (drawn.content.clone(), Arc::clone(&drawn.step)));
        if change.is_some() && self.waiting_change != change {
            self.schedule.note_change(now);
        }
        self.waiting_change = change;
        let cannot_wait = is_urgent || self.has_new_watcher();
        let is_due = cannot_wait || self.schedule.is_due(now, changed);
        if !is_due || (changed && !cannot_wait && self.pacing_wait(now).is_some()) {
            if let (false, Some(last)) = (changed, &mut self.last) {
                last.of.until = drawn.until;
            }
            if self.last.as_ref().is_some_and(|last| !last.of.is_over(now)) {
                self.connections.outputs.confirm();
            }
            return Ok(Progress::NotDue);
        }
        self.schedule.begin(now, changed);
        if changed {
            return Ok(Progress::Begun(drawn));
        }
        if let Some(last) = &mut self.last {
            last.of = drawn;
        }
        self.publish_last(None, ros)?;
        Ok(Progress::Published)
    }

    /// How long a new picture waits for the screen's refresh; `None` if it does not.
    fn pacing_wait(&self, now: Instant) -> Option<Duration> {
        self.pacing.wait(self.connections.outputs.refresh(), now)
    }

    /// Publishes a black picture if one is due, because there is no camera. Without a CameraInfo and a picture before
    /// it, no size is known.
    fn turn_black(
        &mut self,
        info: Option<Arc<CameraInfo>>,
        policy: &FramePolicy,
        dark: Dark,
        ros: &RosNode,
    ) -> Result<Progress<DuePicture>> {
        let of_info = info.as_ref().map(|info| [info.width, info.height]);
        let is_possible = |size: &[u32; 2]| size.iter().all(|side| (1..=MAX_SIDE_PX).contains(side));
        let last = self.last.as_ref().map(|last| &last.of);
        let Some(info) = info.or_else(|| last.map(|last| Arc::clone(&last.info))) else { return Ok(Progress::NotDue) };
        let of_last = last.map(|last| match &last.content {
            Content::Scene { camera, .. } => size_px(camera),
            Content::Black { size_px, .. } => *size_px,
        });
        let Some(size_px) = of_info.filter(is_possible).or(of_last) else { return Ok(Progress::NotDue) };
        let note = note(policy, &dark);
        let drawn = self.drawn(Content::Black { size_px, dark, note }, &policy.unplaced(), info, None);
        match self.due(drawn, ros)? {
            Progress::Begun(drawn) => self.publish_black(drawn, ros).map(|()| Progress::Published),
            Progress::NotDue => Ok(Progress::NotDue),
            Progress::Published => Ok(Progress::Published),
        }
    }

    /// Publishes a black picture in the place of this content, and says why.
    fn publish_black(&mut self, of: Drawn, ros: &RosNode) -> Result<()> {
        let content = match of.content {
            Content::Scene { camera, .. } => {
                Content::Black { size_px: size_px(&camera), dark: safety::expired(), note: Note::NotShown }
            }
            black => black,
        };
        let Content::Black { size_px, dark, note } = &content else { return Ok(()) };
        let size_px = *size_px;
        let note = (*note == Note::Shown).then_some(dark.why.as_str());
        let mut picture = black_picture(size_px, self.view.settings.image_encoding, note);
        of.step.apply(&mut picture, &mut Picture::default());
        let depth = self.connections.outputs.wants_depth().then(|| {
            let mut nowhere = DepthPicture::default();
            nowhere.reset(size_px[0], size_px[1]);
            Arc::new(DepthImage::new(&nowhere, self.depth_encoding, of.step.orientation))
        });
        let of = Drawn { content, until: None, ..of };
        self.last = Some(LastPicture { picture: Arc::new(picture), depth, drawn: None, of });
        self.publish_last(None, ros)
    }

    /// Whether somebody subscribed who is to get a picture at once.
    fn has_new_watcher(&mut self) -> bool {
        !self.schedule.is_on_trigger() && self.connections.outputs.take_new_watcher()
    }

    /// Publishes the last picture again if that is due: another one is being drawn for long.
    ///
    /// # Errors
    /// Those of the outputs.
    pub(crate) fn repeat_if_due(&mut self, ros: &RosNode) -> Result<Progress> {
        if self.last.is_none() || !self.connections.outputs.is_watched() {
            return Ok(Progress::NotDue);
        }
        let now = Instant::now();
        if let Some(over) = self.last.as_ref().map(|last| &last.of).filter(|of| of.is_over(now)).cloned() {
            return self.publish_black(over, ros).map(|()| Progress::Published);
        }
        self.connections.outputs.confirm();
        if !self.has_new_watcher() && !self.schedule.is_repetition_due(now) {
            return Ok(Progress::NotDue);
        }
        self.schedule.begin(now, false);
        self.publish_last(None, ros).map(|()| Progress::Published)
    }

    /// Records that the renderer was given a picture.
    pub(crate) fn record_begun(&mut self, picture: DuePicture, depth: Option<&DepthPicture>) {
        let orientation = picture.drawn.step.orientation;
        self.health.depths_drawn += u64::from(depth.is_some());
        self.depth_in_flight = depth.map(|depth| Arc::new(DepthImage::new(depth, self.depth_encoding, orientation)));
        self.in_flight = Some(picture.drawn);
        self.pacing.begin(Instant::now());
    }

    /// Whether the depths of the next picture are wanted.
    pub(crate) fn wants_depth(&self) -> bool {
        self.connections.outputs.wants_depth()
    }

    /// Memory for the picture that the renderer is about to finish.
    pub(crate) fn take_spare(&mut self) -> Picture {
        self.spare.take().and_then(|spare| Arc::try_unwrap(spare).ok()).unwrap_or_default()
    }

    /// Whether the picture that was begun is wanted without its post-processing, too: a window may hold it below newer
    /// masks.
    pub(crate) fn keeps_drawn(&self) -> bool {
        self.connections.outputs.window.is_some() && self.in_flight.as_ref().is_some_and(|drawn| drawn.protects_eyes)
    }

    /// What is to be done to the picture that was begun, when it is drawn.
    pub(crate) fn last_step(&self) -> Arc<LastStep> {
        self.in_flight.as_ref().map(|drawn| Arc::clone(&drawn.step)).unwrap_or_default()
    }

    /// Publishes the picture that was begun, now that it is finished; `drawn` is the one before post-processing.
    ///
    /// # Errors
    /// Those of the outputs.
    pub(crate) fn finish(&mut self, picture: Picture, drawn: Option<Arc<Picture>>, ros: &RosNode) -> Result<()> {
        let Some(of) = self.in_flight.take() else { return Ok(()) };
        self.health.drawn += 1;
        let is_similar = |spare: &Arc<Picture>| spare.data.len() <= 4 * picture.data.len();
        self.spare = self.last.take().map(|last| last.picture).filter(is_similar);
        let published = if of.is_over(Instant::now()) {
            self.publish_black(of, ros)
        } else {
            let depth = self.depth_in_flight.take();
            self.last = Some(LastPicture { picture: Arc::new(picture), depth, drawn, of });
            self.publish_last(Some(Instant::now()), ros)
        };
        self.pacing.finish(Instant::now());
        published
    }

    /// Records a picture that took long.
    pub(crate) fn record_slow_picture(&mut self, text: String) {
        self.health.record_slow_picture(&self.view.name, text);
    }

    /// Forgets the picture that was begun: the renderer lost those of all cameras. The next call begins it again.
    pub(crate) fn discard_in_flight(&mut self) {
        self.in_flight = None;
    }

    /// Hands the last picture to the outputs. `drawn`: when it was drawn, if it is a new one.
    fn publish_last(&mut self, drawn: Option<Instant>, ros: &RosNode) -> Result<()> {
        let Some(last) = self.last.as_ref().filter(|_| !self.connections.outputs.is_empty()) else { return Ok(()) };
        let stamp = ros.now();
        let info = self.turned_info.of(&last.of.info, last.of.step.orientation);
        let (picture, depth, permit) = (Arc::clone(&last.picture), last.depth.clone(), last.of.permit());
        let frame = Frame { picture, info, depth, stamp, permit, drawn: last.drawn.clone() };
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

/// Whether a black picture says why it is black.
fn note(policy: &FramePolicy, dark: &Dark) -> Note {
    match policy.shows_note(dark) {
        true => Note::Shown,
        false => Note::NotShown,
    }
}
