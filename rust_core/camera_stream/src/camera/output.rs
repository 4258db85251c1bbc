//! One camera of the node: decides what its next frame shows and when it is due, and hands frames to its outputs.
//!
//! Its parts: [`FrameTiming`] decides when a frame is due, [`RuntimeSettings`] holds the settings, the
//! [outputs](CameraConnections) receive the frames, [`CameraHealth`] records problems and figures. Frames themselves
//! are [objects of their own](super::frame), which only the scene's thread has.
//!
//! Each frame has a [grant](rcs_light) of the light in it, which is asked for when its content is chosen and again when
//! it is repeated. One whose grant ends is followed by a black one at once, whatever the frame rate.
//!
//! The [operator](crate::control)'s words come before the scene: a blackout goes out at once, from the control thread,
//! and no image that was begun before it leaves afterwards.
//!
//! A camera belongs to both of the node's threads: the scene's thread polls and publishes, and the control thread
//! answers calls and repeats the last frame while another is drawn for long. None of its methods takes long.

use std::sync::Arc;
use std::time::{Duration, Instant};

use anyhow::{Error, Result};
use rcs_camera::CameraModel;
use rcs_displays::{time_from_stamp, CameraView};
use rcs_light::{Condition, DarkCause, DarkReason, Grant};
use rcs_messages::dynamic_reconfigure::Config as Values;
use rcs_messages::sensor_msgs::CameraInfo;
use rcs_messages::std_msgs::Header;
use rcs_render::Orientation;
use rcs_ros::settings::NamedValues;
use rcs_ros::{RosNode, TriggerReply};
use rcs_rviz_config::CameraPubSettings;
use rcs_scene::{DepthImage, DisplayId, DisplayMask, Image, MAX_SIDE_PX};
use rcs_transforms::Time;
use rcs_web::Images;

use super::buffers::FrameBuffers;
use super::connections::CameraConnections;
use super::dimmer::Dimmer;
use super::frame::{size_px, DueFrame, FinishedFrame, FrameContent, FrameSpec};
use super::health::CameraHealth;
use super::latency::Update;
use super::light_check::LastCheck;
use super::oriented_info::TurnedInfo;
use super::plan::CameraPlan;
use super::reconfigurable::Switch;
use super::runtime_settings::RuntimeSettings;
use super::substitute;
use super::timing::FrameTiming;
use crate::control::{Control, OperatorSettings};
use crate::outputs::depth_image::{DepthEncoding, EncodedDepths};
use crate::outputs::shown::{self, ShownRecord};
use crate::outputs::{FrameImage, Output, OutputFrame, TopicOutput, WindowOutput};
use crate::safety::{self, CameraLight};
use crate::scene::status_tree::StatusEntry;
use crate::scene::{camera, SceneState};

/// The settings that all cameras of the node share.
pub(crate) struct CameraContext {
    pub(crate) ros: Arc<RosNode>,
    pub(crate) control: Arc<Control>,
    pub(crate) model: CameraModel,
    pub(crate) depth_encoding: DepthEncoding,
    /// The images of the operator's page, if there is one.
    pub(crate) page: Option<Images>,
}

/// A camera with its outputs and its trigger service.
pub(crate) struct CameraPublisher {
    pub(super) context: Arc<CameraContext>,
    pub(super) settings: RuntimeSettings,
    pub(super) connections: CameraConnections,
    pub(super) timing: FrameTiming,
    /// Evidence about its light.
    pub(super) light: CameraLight,
    pub(super) epoch: Epoch,
    pub(super) last_check: LastCheck,
    pub(super) buffers: FrameBuffers,
    pub(super) dimmer: Dimmer,
    turned_info: TurnedInfo,
    pub(super) health: CameraHealth,
}

/// The number of the frames among which a paused one may stay: see [`FrameSpec::epoch`].
#[derive(Default)]
pub(super) struct Epoch {
    pub(super) number: u64,
    hidden: Vec<DisplayId>,
    size_px: [u32; 2],
}

impl Epoch {
    /// Counts on if the stale displays or the size are others than before.
    fn follow(&mut self, hidden: &[DisplayId], size_px: [u32; 2]) {
        if self.hidden != hidden || self.size_px != size_px {
            (self.hidden, self.size_px) = (hidden.to_vec(), size_px);
            self.number += 1;
        }
    }
}

/// The cameras' names, for the log.
pub(crate) fn names(cameras: &[CameraPublisher]) -> String {
    match cameras {
        [] => "no camera".to_owned(),
        cameras => cameras.iter().map(|camera| camera.view().name.as_str()).collect::<Vec<_>>().join(", "),
    }
}

impl CameraPublisher {
    /// A camera without connections; [`Self::apply`] gives it those.
    pub(super) fn new(context: &Arc<CameraContext>, plan: &CameraPlan, switches: &Arc<[Switch]>) -> Self {
        let is_black = context.control.of_camera(plan.name()).is_switched_off;
        Self {
            context: Arc::clone(context),
            settings: RuntimeSettings::start(&context.ros, plan, switches, is_black),
            connections: CameraConnections::default(),
            timing: FrameTiming::default(),
            light: CameraLight::unknown(),
            epoch: Epoch::default(),
            last_check: LastCheck::default(),
            buffers: FrameBuffers::default(),
            dimmer: Dimmer::default(),
            turned_info: TurnedInfo::default(),
            health: CameraHealth::default(),
        }
    }

    /// Takes over the settings and connections that a config gives it.
    pub(super) fn apply(
        &mut self,
        plan: CameraPlan,
        connections: CameraConnections,
        switches: &Arc<[Switch]>,
        global_frame_rate_hz: i32,
        displays: &SceneState,
    ) {
        self.settings.update_from(&self.context.ros, plan.view, switches);
        self.connections = connections;
        // A paused frame is of a config that may have had other displays.
        self.epoch.number += 1;
        self.timing.global_frame_rate_hz = global_frame_rate_hz;
        self.apply_new_settings(displays);
    }

    /// Gives its connections away, for the cameras of another config.
    pub(super) fn release(&mut self) -> CameraConnections {
        std::mem::take(&mut self.connections)
    }

    /// Applies what a user has changed from the next frame on.
    pub(crate) fn apply_new_settings(&mut self, displays: &SceneState) {
        if self.settings.apply_changes(displays) {
            self.timing.set_frame_rate(self.settings.view().settings.frame_rate_hz);
            match self.operator().paused {
                Some(_) => self.buffers.is_outdated = true,
                None => self.discard_last(),
            }
        }
    }

    /// Forgets what services have changed in its settings.
    pub(crate) fn discard_changes(&mut self) {
        self.settings.discard_changes();
    }

    /// Whether services have changed its settings since they were last saved.
    pub(crate) fn is_unsaved(&self) -> bool {
        self.settings.is_unsaved()
    }

    pub(crate) fn set_saved(&mut self, is_saved: bool) {
        self.settings.set_saved(is_saved);
    }

    /// Its settings as they are now, to be saved.
    pub(crate) fn current_settings(&self) -> CameraPubSettings {
        self.settings.current_settings()
    }

    pub(super) fn id(&self) -> &str {
        self.settings.id()
    }

    pub(crate) fn view(&self) -> &Arc<CameraView> {
        self.settings.view()
    }

    /// Takes what is known about its light. Whether there is a camera, it finds out itself.
    pub(crate) fn set_light(&mut self, mut light: CameraLight) {
        light.evidence.keep(DarkCause::NoCamera, &self.light.evidence);
        self.light = light;
    }

    /// The time of the next change of its light if nothing new arrives.
    pub(crate) fn light_end(&self) -> Option<Instant> {
        self.light.evidence.end()
    }

    pub(crate) fn orientation(&self) -> Orientation {
        self.light.evidence.post().orientation
    }

    pub(crate) fn is_watched(&self) -> bool {
        self.connections.outputs.is_watched()
    }

    pub(crate) fn wants_depth(&self) -> bool {
        self.connections.outputs.wants_depth()
    }

    /// `true` if its frames are drawn with depths: for a topic, or to confirm their light.
    pub(crate) fn uses_depth(&self) -> bool {
        self.wants_depth() || self.light.surface.is_some()
    }

    /// Forgets the last frame: what it shows is old.
    pub(crate) fn discard_last(&mut self) {
        (self.buffers.front, self.buffers.is_outdated) = (None, false);
    }

    pub(crate) fn status_entry(&self, scene: &SceneState) -> StatusEntry<'static> {
        let mut entry = self.health.status_entry(scene, self.view(), self.context.model, &self.connections);
        self.last_check.shares().into_iter().for_each(|shares| safety::status::add_shares(&mut entry, shares));
        let operator = self.operator();
        // Of a camera that nobody watches, only what the operator said is known.
        let dark = if self.is_watched() { self.dark_reason(&operator) } else { operator.light.clone().err() };
        safety::status::add_dark(&mut entry, dark.as_ref());
        safety::status::add_substitute(&mut entry, &operator);
        entry
    }

    /// Records an update of the scene, for the latency figures.
    pub(crate) fn record_update(&mut self, update: &Update<'_>) {
        self.health.latency.record_update(update, &self.settings.view().visible);
    }

    /// Forgets the messages that the next frame would have been measured by: the time jumped back.
    pub(crate) fn forget_messages(&mut self) {
        self.health.latency.forget();
        self.epoch.number += 1;
    }

    /// The usual time from looking up frames to publishing the image, if it is watched and that was measured.
    pub(crate) fn lookup_to_publish(&self) -> Option<Duration> {
        self.is_watched().then(|| self.health.latency.lookup_to_publish()).flatten()
    }

    /// Records why a frame failed. An error is logged once, and stays until an image is published.
    pub(crate) fn record_error(&mut self, error: &Error) {
        self.health.record_error(&self.settings.view().name, error);
    }

    /// Records a frame that took long.
    pub(crate) fn record_slow_frame(&mut self, text: String) {
        self.health.record_slow_frame(&self.settings.view().name, text);
    }

    /// `true` if its parameters are served under this name.
    pub(crate) fn has_parameters(&self, server: &str) -> bool {
        self.servers().any(|own| &**own.name() == server)
    }

    /// Takes a caller's values of a server for the next frame. Returns the values that apply from then on; `None`
    /// without such a server.
    pub(crate) fn reconfigure(&mut self, server: &str, request: &NamedValues, caller: &str) -> Option<Values> {
        let ros = &self.context.ros;
        match self.settings.server() {
            Some(own) if &**own.name() == server => self.settings.set(ros, &self.context.control, request, caller),
            _ => self.connections.outputs.topic.as_mut()?.reconfigure(ros, request),
        }
    }

    /// `true` if this is the camera of a trigger service.
    pub(crate) fn serves(&self, service: &str) -> bool {
        self.connections.trigger_service.as_deref() == Some(service)
    }

    /// Answers a call of the trigger service; the frame follows.
    pub(crate) fn trigger(&mut self, reply: TriggerReply) {
        let outputs = &self.connections.outputs;
        if outputs.is_empty() {
            reply.send(false, "Image publisher not configured");
        } else {
            self.timing.schedule.trigger();
            let topic = outputs.topic.as_ref().map_or("another output", TopicOutput::topic);
            reply.send(true, format!("New image will be published on: {topic}"));
        }
    }

    /// Time until a frame is due by itself; `None` when that is never.
    pub(crate) fn until_due(&self, now: Instant) -> Option<Duration> {
        // A camera that cannot draw is retried when a message arrives.
        let can_draw = (!self.health.has_problem() || self.buffers.front.is_some()) && self.is_watched();
        let due = can_draw.then(|| self.timing.until_due(self.connections.outputs.refresh(), now)).flatten();
        due.into_iter().chain(self.until_dimmed(now).filter(|_| self.is_watched())).min()
    }

    /// The operator's settings.
    pub(super) fn operator(&self) -> OperatorSettings {
        self.context.control.of_camera(&self.view().name)
    }

    /// Optical frame, and width and height of the published images. `None` without a CameraInfo.
    pub(crate) fn frame_and_size<'a>(&self, scene: &'a SceneState) -> Option<(&'a str, [u32; 2])> {
        let info = scene.camera_info(self.view())?;
        Some((&info.header.frame_id, self.orientation().size_px([info.width, info.height])))
    }

    /// Applies what the operator has changed. The image of a blackout goes out here, whatever is being drawn.
    ///
    /// # Errors
    /// The outputs'.
    pub(crate) fn apply_control(&mut self) -> Result<()> {
        let operator = self.operator();
        self.settings.set_black(&self.context.ros, operator.is_switched_off);
        // A window sees itself that its grant is void.
        self.connections.outputs.window.iter().for_each(WindowOutput::wake);
        let now = Instant::now();
        let lit = self.buffers.front.take_if(|last| !last.spec.may_leave(now));
        let Err(dark) = operator.light else { return Ok(()) };
        match lit.filter(|_| self.is_watched()) {
            Some(last) => self.publish_substitute(last.spec.blacked_out(dark)),
            None => Ok(()),
        }
    }

    /// The frame that is due now, if it is to be drawn. One that would look like the last, and one that shows no scene,
    /// is published at once.
    ///
    /// # Errors
    /// The outputs'.
    pub(crate) fn poll(&mut self, scene: &SceneState) -> Result<Option<DueFrame>> {
        self.connections.outputs.topic.iter_mut().for_each(|topic| topic.poll_settings(&self.context.ros));
        if !self.is_watched() {
            self.timing.schedule.clear_trigger();
            self.health.latency.forget();
            return Ok(None);
        }
        let view = Arc::clone(self.view());
        let operator = self.operator();
        let camera = match camera(scene, &view, self.context.model) {
            Ok(camera) => Arc::new(camera),
            Err(problem) => {
                self.light.evidence.set(DarkCause::NoCamera, Condition::Dark(problem.to_string()));
                self.health.record_problem(&view.name, problem, Instant::now());
                return self.publish_without_camera(scene.camera_info(&view), &operator).map(|()| None);
            }
        };
        self.light.evidence.set(DarkCause::NoCamera, Condition::Always);
        self.health.clear_problem(&view.name);
        self.health.record_dark(&view.name, self.dark_reason(&operator).as_ref());
        let Some(info) = scene.camera_info(&view) else { return Ok(None) };
        let mut visible = view.visible.clone();
        self.light.hidden.iter().for_each(|display| visible.set(*display, false));
        self.last_check.update(&camera, self.light.surface.as_ref());
        self.epoch.follow(&self.light.hidden, size_px(&camera));
        let granted = self.grant_scene((size_px(&camera), &info.header.frame_id), &operator);
        let held = granted.as_ref().ok().filter(|_| operator.paused.is_some()).and_then(|grant| self.held(grant));
        let is_scene = held.is_none() && granted.is_ok();
        if is_scene && self.buffers.is_outdated {
            self.discard_last();
        }
        let is_recorded = is_scene && self.connections.outputs.shown().is_some();
        let oldest = is_recorded.then(|| oldest_stamp(scene, &visible)).flatten();
        let spec = held.unwrap_or_else(|| {
            let (content, grant) = granted.map_or_else(
                |substitute| substitute,
                |grant| {
                    let (version, hidden) = (scene.version_shown(&visible), self.light.hidden.clone());
                    (FrameContent::Scene { version, camera: Arc::clone(&camera), hidden }, Some(grant))
                },
            );
            let looked_up = scene.prediction().map(|prediction| prediction.now);
            FrameSpec { oldest, looked_up, ..self.spec(content, grant, info) }
        });
        let Some(spec) = self.due(spec)? else { return Ok(None) };
        if !is_scene {
            self.health.latency.forget();
        }
        let is_checked = self.light.surface.is_none() || self.last_check.is_some();
        if !is_scene || (is_checked && self.buffers.has_drawn(&spec, self.wants_depth())) {
            return self.publish_unrendered(spec).map(|()| None);
        }
        self.health.projection.check(scene, &view, self.context.model);
        let depth = self.wants_depth().then_some(self.context.depth_encoding);
        let (begun, keeps_drawn) = (Instant::now(), self.light.evidence.rules().protects_eyes);
        let check = self.light.surface.clone().map(|surface| (surface, std::mem::take(&mut self.buffers.back_objects)));
        Ok(Some(DueFrame { spec, view, visible, camera, depth, check, keeps_drawn, begun }))
    }

    fn spec(&self, content: FrameContent, grant: Option<Grant>, info: &Arc<CameraInfo>) -> FrameSpec {
        FrameSpec {
            content,
            grant,
            orientation: self.orientation(),
            epoch: self.epoch.number,
            info: Arc::clone(info),
            looked_up: None,
            oldest: None,
        }
    }

    /// The frame if it is due and looks different from the last one, which is published again if only that is due.
    fn due(&mut self, spec: FrameSpec) -> Result<Option<FrameSpec>> {
        self.follow_brightness(Some(&spec))?;
        let last = self.buffers.last();
        let lacks_depth = self.wants_depth() && self.buffers.front.as_ref().is_some_and(|last| last.depth.is_none());
        let changed = lacks_depth || last.is_none_or(|last| !last.looks_like(&spec));
        // What has become stale, or current again, does not wait for the frame rate; nor does light that is forbidden
        // now, unless frames follow changes anyway.
        let is_urgent = last.is_some_and(|last| {
            last.content.differs_in_staleness(&spec.content)
                || (!last.has_light_of(&spec) && !self.timing.schedule.follows_changes())
        });
        let now = Instant::now();
        self.timing.note_change(changed.then_some(&spec), now);
        let is_urgent = is_urgent || self.take_new_watcher();
        let is_due = self.timing.take_due(changed, is_urgent, self.connections.outputs.refresh(), now);
        if is_due && changed {
            return Ok(Some(spec));
        }
        if let (false, Some(last)) = (changed, &mut self.buffers.front) {
            last.renew(spec.grant.as_ref());
            if is_due {
                last.spec = spec;
            }
            self.connections.outputs.renew(&last.image);
        }
        if is_due {
            self.publish_last(None)?;
        }
        Ok(None)
    }

    /// Publishes a black frame or a test image if one is due, because there is no camera and the last frame must not
    /// pass for a current one. Without a CameraInfo and a frame before it, no size is known.
    fn publish_without_camera(&mut self, info: Option<&Arc<CameraInfo>>, operator: &OperatorSettings) -> Result<()> {
        let is_possible = |size: &[u32; 2]| size.iter().all(|side| (1..=MAX_SIDE_PX).contains(side));
        let last = self.buffers.last();
        let size_of_info = info.map(|info| [info.width, info.height]).filter(is_possible);
        let size_px = size_of_info.or_else(|| last.map(|last| last.content.size_px()));
        // A test image before there is a CameraInfo is for the window's monitor.
        let monitor_px = || Some(self.orientation().size_px(self.connections.outputs.window.as_ref()?.monitor_px()?));
        let Some(size_px) = size_px.or_else(monitor_px) else { return Ok(()) };
        let info = info.or(last.map(|last| &last.info)).cloned().unwrap_or_default();
        // There is no grant of the scene without a camera.
        let Err((content, grant)) = self.grant_scene((size_px, &info.header.frame_id), operator) else { return Ok(()) };
        let is_test = matches!(content, FrameContent::Test { .. });
        if !self.light.is_guarded && operator.light.is_ok() && !is_test {
            // As in rviz: nothing is published.
            self.discard_last();
            return Ok(());
        }
        let spec = self.spec(content, grant, &info);
        match self.due(spec)? {
            Some(spec) => self.publish_substitute(spec),
            None => Ok(()),
        }
    }

    /// Publishes an image that is not rendered: the last one below newer masks, or one that shows no scene.
    fn publish_unrendered(&mut self, spec: FrameSpec) -> Result<()> {
        if !matches!(spec.content, FrameContent::Scene { .. }) {
            return self.publish_substitute(spec);
        }
        let Some(mut last) = self.buffers.front.take() else { return Ok(()) };
        let drawn = last.drawn.as_ref().filter(|_| !last.spec.has_light_of(&spec));
        if let (Some(drawn), Some(grant)) = (drawn, spec.grant.clone()) {
            let Some(lit) = grant.light(Image::clone(drawn), &mut Image::default()) else { return Ok(()) };
            last.image = FrameImage::lit(lit);
        }
        last.renew(spec.grant.as_ref());
        last.depth = last.depth.or_else(|| self.wants_depth().then(|| self.nowhere(&spec)));
        self.buffers.front = Some(FinishedFrame { spec, is_published: false, ..last });
        self.publish_last(None)
    }

    /// Publishes an image that shows no scene.
    fn publish_substitute(&mut self, spec: FrameSpec) -> Result<()> {
        let view = self.view();
        let image = substitute::image(&spec, view.settings.image_encoding, &view.name);
        let depth = self.wants_depth().then(|| self.nowhere(&spec));
        self.buffers.front =
            Some(FinishedFrame { spec, image, depth, drawn: None, checked: None, begun: None, is_published: false });
        self.publish_last(None)
    }

    /// Depths where nothing is drawn.
    fn nowhere(&self, spec: &FrameSpec) -> Arc<EncodedDepths> {
        let ([width_px, height_px], mut nowhere) = (spec.content.size_px(), DepthImage::default());
        nowhere.reset(width_px, height_px);
        Arc::new(EncodedDepths::new(&nowhere, self.context.depth_encoding, spec.orientation))
    }

    /// `true` if somebody subscribed since the last call and is to get an image at once.
    fn take_new_watcher(&mut self) -> bool {
        !self.timing.schedule.is_on_trigger() && self.connections.outputs.take_new_watcher()
    }

    /// Publishes the last frame again if that is due: another one is being drawn for long.
    ///
    /// # Errors
    /// The outputs'.
    pub(crate) fn repeat_if_due(&mut self) -> Result<()> {
        if !self.is_watched() {
            return Ok(());
        }
        let (now, operator) = (Instant::now(), self.operator());
        let Some(last) = &mut self.buffers.front else { return Ok(()) };
        let decided = last.decide_again(&self.light.evidence, &operator, now);
        if !last.spec.may_leave(now) {
            let busy = || DarkReason::new(DarkCause::NoImage, "the node is busy, and drew nothing in time");
            let dark = decided.err().unwrap_or_else(busy);
            let black = last.spec.clone().blacked_out(dark);
            return self.publish_substitute(black);
        }
        self.connections.outputs.renew(&last.image);
        self.follow_brightness(None)?;
        if !self.take_new_watcher() && !self.timing.schedule.is_repetition_due(now) {
            return Ok(());
        }
        self.timing.schedule.begin(now, false);
        self.publish_last(None)
    }

    /// Memory for the frame that the renderer is about to finish.
    pub(crate) fn take_back_buffer(&mut self) -> Image {
        self.buffers.back.take().and_then(|back| Arc::try_unwrap(back).ok()).unwrap_or_default()
    }

    /// Records the size of the frame that the renderer was given. Returns `true` if it was another one before.
    pub(crate) fn set_drawn_px(&mut self, size_px: [u32; 2]) -> bool {
        self.buffers.drawn_px.replace(size_px).is_some_and(|before| before != size_px)
    }

    /// Publishes a frame that the renderer has finished; a black one if it has expired.
    ///
    /// # Errors
    /// The outputs'.
    pub(crate) fn publish(&mut self, mut frame: FinishedFrame) -> Result<()> {
        self.health.counts.drawn += 1;
        self.health.counts.depths_drawn += u64::from(frame.depth.is_some());
        if let Some(checked) = frame.checked.take() {
            self.buffers.back_objects = self.last_check.set(checked);
        }
        let (begun, now, operator) = (frame.begun, Instant::now(), self.operator());
        // It may have been drawn for long.
        let decided = frame.decide_again(&self.light.evidence, &operator, now);
        let published = match decided {
            _ if frame.spec.may_leave(now) => {
                self.buffers.retire_front(frame.image.size_px());
                self.buffers.front = Some(frame);
                self.publish_last(Some(now))
            }
            // A blackout came, or its data have become too old.
            Err(dark) => self.publish_substitute(frame.spec.blacked_out(dark)),
            // The next frame shows what is now.
            Ok(()) => Ok(()),
        };
        begun.into_iter().for_each(|begun| self.timing.pacing.record(begun.elapsed()));
        published
    }

    /// Hands the last frame to the outputs. `drawn`: when it was drawn, if it is a new one.
    pub(super) fn publish_last(&mut self, drawn: Option<Instant>) -> Result<()> {
        if self.buffers.last().is_some_and(|last| !last.may_leave(Instant::now())) {
            return self.apply_control();
        }
        let outputs = &mut self.connections.outputs;
        let Some(last) = self.buffers.front.as_mut().filter(|_| !outputs.is_empty()) else { return Ok(()) };
        let is_new = !std::mem::replace(&mut last.is_published, true);
        let stamp = self.context.ros.now();
        let info = self.turned_info.of(&last.spec.info, last.spec.orientation);
        let now = Instant::now();
        let brightness = self.context.control.brightness().fade.at(now);
        let (image, depth) = (self.dimmer.apply(&last.image, brightness, now), last.depth.clone());
        let shown = outputs.shown().filter(|_| is_new).map(|publisher| {
            let dark = last.spec.dark_reason().map(|dark| dark.why.as_str());
            let source = shown::source(&self.settings.view().name, dark, last.spec.oldest);
            let header = Header { seq: 0, stamp, frame_id: info.header.frame_id.clone() };
            Arc::new(ShownRecord::new(&self.context.ros, publisher, header, source))
        });
        outputs.send(&OutputFrame { image, info, depth, stamp, shown })?;
        if let Some(drawn) = drawn {
            let latency = &mut self.health.latency;
            latency.measure(drawn, Instant::now(), time_from_stamp(stamp));
            if let Some(looked_up) = last.spec.looked_up {
                latency.record_lookup_to_publish(time_from_stamp(stamp).saturating_since(looked_up));
            }
        }
        self.health.record_published();
        self.timing.schedule.clear_trigger();
        Ok(())
    }
}

/// Stamp of the oldest data that displays have drawn; `None` if none of them has a stamp.
fn oldest_stamp(scene: &SceneState, visible: &DisplayMask) -> Option<Time> {
    let drawn = scene.ages().filter(|age| visible.shows(age.id) && !age.is_empty);
    drawn.filter_map(|age| age.current).map(|shown| shown.stamp).filter(|stamp| !stamp.is_zero()).min()
}
