//! The scene's thread: takes what was received, brings the scene up to date, draws what is watched and hands it to the
//! outputs.

use std::collections::VecDeque;
use std::sync::Arc;
use std::time::{Duration, Instant};

use anyhow::{Error, Result};
use rcs_camera::{CameraModel, Projection};
use rcs_displays::{time_from_stamp, Reconfigured};
use rcs_light::Now;
use rcs_messages::{AnyMessage, Image, MessageKind};
use rcs_resources::{MeshStore, PackageIndex};
use rcs_ros::{NodeEvent, TopicSubscription};
use rcs_rviz_config::Config;
use rcs_transforms::Time;

use super::activity::SceneStep;
use super::frame_renderer::{has_gpu_failed, FrameRenderer};
use super::shared::{NodeState, Reload};
use super::windows::Windows;
use crate::camera::frame::FrameInFlight;
use crate::camera::latency::Update;
use crate::camera::oriented_frames::OrientedFrames;
use crate::camera::output::{self, CameraContext, CameraPublisher};
use crate::camera::plan::{self, CameraPlan};
use crate::camera::rearrange::rearrange;
use crate::config_names;
use crate::control::pattern::Pattern;
use crate::options::Options;
use crate::safety::ages::Assessment;
use crate::safety::read_rules::{self, LightTopics};
use crate::safety::{status, LitView, Safety};
use crate::scene::camera_pose::unknown_lens;
use crate::scene::subscriptions::Subscriptions;
use crate::scene::visibility::{self, PlacedCamera};
use crate::scene::{camera, status_tree, SceneState};

const LONGEST_SLEEP: Duration = Duration::from_millis(500);

/// Markers placed in one update: at most a twentieth of a second of work.
const MARKERS_PER_UPDATE: usize = 20_000;

/// The scene and what draws it.
pub(super) struct SceneThread {
    shared: Arc<NodeState>,
    context: Arc<CameraContext>,
    options: Options,
    scene: SceneState,
    subscriptions: Subscriptions,
    /// Arrival of the last transforms since the last update.
    transforms_received: Option<Instant>,
    renderer: FrameRenderer,
    safety: Safety,
    light_topics: LightTopics,
    /// Patterns of a calibration.
    patterns: TopicSubscription,
    oriented_frames: OrientedFrames,
    windows: Windows,
}

/// A frame in flight, and the index of its camera: only this thread adds and removes cameras, and not meanwhile.
type InFlight = VecDeque<(usize, FrameInFlight)>;

impl SceneThread {
    /// Subscribes and advertises what a config asks for.
    ///
    /// # Errors
    /// One line that names what failed: a topic, the renderer.
    pub(super) fn start(options: &Options, config: &Config, shared: &Arc<NodeState>) -> Result<Self> {
        let ros = &shared.ros;
        let (rules, light_topics) = read_rules::read(ros, options)?;
        let patterns = ros.subscribe("~patterns", MessageKind::Image, 1)?;
        let safety = Safety::new(rules);
        let renderer = FrameRenderer::new(options.renderer)?;
        let resources = options.resources.clone();
        let events = Arc::clone(ros.events());
        let meshes = MeshStore::in_background(PackageIndex::from_env(&[]), resources, move || events.wake());
        let mut scene = SceneState::new(config, options.fixed_frame.as_deref(), meshes);
        scene.limit_markers_per_update(MARKERS_PER_UPDATE);
        if scene.cameras().is_empty() {
            log::warn!("{}: no enabled CameraPub display, so there is nothing to publish", config.source);
        }
        let plans = plan::plans(ros, config)?;
        shared.control.set_cameras(plans.iter().map(CameraPlan::name));
        let windows = Windows::open(ros, &shared.control, options, &safety, &plans)?;
        let (model, depth_encoding) = (options.model, options.node.depth_encoding);
        let page = options.web.as_ref().map(|_| shared.page.pages().images().clone());
        let (own_ros, control) = (Arc::clone(ros), Arc::clone(&shared.control));
        let context = Arc::new(CameraContext { ros: own_ros, control, model, depth_encoding, page });
        let cameras = rearrange(&context, plans, Vec::new(), config, &scene, |camera| windows.of(camera));
        ros.subscribe_transforms()?;
        let mut subscriptions = Subscriptions::default();
        subscriptions.update(ros, &scene);
        log::info!("drawing {} of {} with {}", output::names(&cameras), config.source, renderer.describe());
        *shared.cameras() = cameras;
        scene.update(time_from_stamp(ros.now()));
        Ok(Self {
            shared: Arc::clone(shared),
            context,
            options: options.clone(),
            scene,
            subscriptions,
            transforms_received: None,
            renderer,
            safety,
            light_topics,
            patterns,
            oriented_frames: OrientedFrames::default(),
            windows,
        })
    }

    fn now(&self) -> Time {
        time_from_stamp(self.shared.ros.now())
    }

    pub(super) fn run(mut self) {
        let shared = Arc::clone(&self.shared);
        let mut is_ahead = false;
        while !shared.is_ending() {
            shared.activity.wait_for_work();
            let events = shared.ros.events().wait(if is_ahead { Duration::ZERO } else { self.sleep() });
            self.renderer.costs.clear();
            let mut has_news = !events.is_empty() || self.scene.has_new_resources();
            for event in events {
                self.handle(event);
            }
            has_news |= self.apply_changes();
            self.pause_streams();
            let now = self.now();
            let lookup_to_publish = shared.cameras().iter().filter_map(CameraPublisher::lookup_to_publish).max();
            let prediction = self.options.node.prediction.prediction(now, lookup_to_publish);
            self.scene.predict(prediction);
            has_news |= prediction.is_some();
            if has_news || self.scene.next_change().is_some_and(|change| change <= now) {
                self.update(now);
            }
            // The first frame after a pause is to show what is, not what was.
            is_ahead = self.subscriptions.awaited(Instant::now()).is_none() && self.publish();
            self.report_statuses();
        }
    }

    /// Pauses streams that nobody watches, and resumes them.
    fn pause_streams(&mut self) {
        let is_watched = !self.options.node.is_lazy || self.shared.cameras().iter().any(CameraPublisher::is_watched);
        self.light_topics.surfaces.update(&self.shared.ros, is_watched);
        if self.subscriptions.pause_streams(is_watched, &self.scene) {
            // It will be old when somebody watches again.
            self.shared.cameras().iter_mut().for_each(CameraPublisher::discard_last);
        }
    }

    /// Applies what the control thread has taken: another config, a user's settings. Returns `true` if the scene may
    /// have changed.
    fn apply_changes(&mut self) -> bool {
        // Taken out first, so that requests are not locked meanwhile.
        let (reload, is_retry) = self.shared.take_requests();
        if is_retry {
            self.scene.retry_resources();
        }
        let is_reloaded = reload.map(|reload| self.reload(reload)).is_some();
        for camera in self.shared.cameras().iter_mut() {
            camera.apply_new_settings(&self.scene);
        }
        is_reloaded || is_retry
    }

    /// Applies another config. Only what differs changes: subscriptions, publishers and services that are kept are not
    /// touched, and displays that are kept show what they did.
    fn reload(&mut self, Reload { config, reply, discards_changes }: Reload) {
        let shared = Arc::clone(&self.shared);
        shared.activity.begin(SceneStep::Config);
        let ros = &shared.ros;
        let plans = match plan::plans(ros, &config) {
            Ok(plans) => plans,
            // It was possible when the config was read.
            Err(error) => return log::error!("{}: {error}", config.source),
        };
        shared.control.set_cameras(plans.iter().map(CameraPlan::name));
        let changed = self.scene.reconfigure(&config, self.options.fixed_frame.as_deref(), self.now());
        self.subscriptions.update(ros, &self.scene);
        {
            let mut cameras = shared.cameras();
            cameras.iter_mut().filter(|_| discards_changes).for_each(CameraPublisher::discard_changes);
            let known = std::mem::take(&mut *cameras);
            self.windows.clear_those_without(&plans);
            *cameras = rearrange(&self.context, plans, known, &config, &self.scene, |camera| self.windows.of(camera));
        }
        self.renderer.forget_sizes();
        let Reconfigured { kept, added, removed } = changed;
        let changed = format!("{}: {kept} displays kept, {added} added, {removed} removed", config.source);
        let changed = match self.safety.set_names(&config_names(&config)) {
            Some(why) => format!("{changed}; all cameras are dark: {why}"),
            None => changed,
        };
        match reply {
            Some(reply) => reply.send(true, changed),
            None => log::info!("the config changed: {changed}"),
        }
    }

    fn update(&mut self, now: Time) {
        self.update_scene(now);
        self.record_update(Instant::now());
    }

    /// Brings the scene up to date.
    fn update_scene(&mut self, now: Time) {
        self.shared.activity.begin(SceneStep::Displays);
        self.scene.pack_points(self.renderer.takes_packed_points());
        self.scene.update(now);
        self.renderer.costs.add(self.scene.take_costs());
    }

    /// Records the last update for the figures of the next images.
    fn record_update(&mut self, decoded: Instant) {
        let (messages, transforms_received) = (self.scene.newly_shown(), self.transforms_received.take());
        let update = Update { messages, transforms_received, decoded };
        self.shared.cameras().iter_mut().for_each(|camera| camera.record_update(&update));
    }

    /// Time until something is due by itself: a camera's next frame, or a change of the scene.
    fn sleep(&mut self) -> Duration {
        let now = Instant::now();
        let awaited = self.subscriptions.awaited(now);
        let next_stale = self.safety.assessment().and_then(Assessment::next_change);
        let (due, light_end) = {
            let cameras = self.shared.cameras();
            let due = cameras.iter().filter_map(|camera| camera.until_due(now)).min();
            (due, cameras.iter().filter_map(CameraPublisher::light_end).min())
        };
        let change = self.scene.next_change().map(|change| change.saturating_since(self.now()));
        let diagnostics = self.shared.diagnostics().until_due(now);
        // A little later, so that it is over then.
        let after = |at: Instant| at.saturating_duration_since(now) + Duration::from_millis(1);
        let stale = next_stale.into_iter().chain(light_end).min().map(after);
        let all = awaited.or(due).into_iter().chain(change).chain(stale);
        all.fold(diagnostics.min(LONGEST_SLEEP), Duration::min)
    }

    fn report_statuses(&mut self) {
        let shared = Arc::clone(&self.shared);
        if !shared.diagnostics().is_due() {
            return;
        }
        shared.activity.begin(SceneStep::Statuses);
        let state = &self.scene;
        let mut entries = status_tree::scene(state, self.now());
        status::add(&mut entries, &self.safety, |topic| self.subscriptions.is_paused(topic));
        status::add_operator(&mut entries, &shared.control);
        let is_published = shared.diagnostics().until_due(Instant::now()).is_zero();
        if is_published {
            // This may take long, so the cameras are not locked meanwhile.
            let views: Vec<_> = shared.cameras().iter().map(|camera| Arc::clone(camera.view())).collect();
            let place = |view: &Arc<_>| camera(state, view, self.context.model).ok();
            let placed: Vec<_> = views.iter().map(|view| PlacedCamera { view, camera: place(view) }).collect();
            visibility::add(&mut entries, state, &placed);
        }
        entries.extend(shared.cameras().iter().map(|camera| camera.status_entry(state)));
        shared.diagnostics().report(&shared.ros, &mut entries);
        if is_published && shared.page.pages().is_any_open() {
            let published = |camera: &CameraPublisher| (camera.view().name.clone(), camera.figures().published);
            let published: Vec<_> = shared.cameras().iter().map(published).collect();
            shared.page.note(&entries, published.into_iter());
        }
    }

    fn handle(&mut self, event: NodeEvent) {
        let step = match &event {
            NodeEvent::Message { topic, .. } => SceneStep::Message(Arc::clone(topic)),
            _ => SceneStep::Event,
        };
        self.shared.activity.begin(step);
        match &event {
            NodeEvent::Message { topic, message: AnyMessage::Image(image), received, .. }
                if topic == self.patterns.topic() =>
            {
                if let Err(why) = self.take_pattern(image, *received) {
                    log::warn!("{topic}: not shown: {why}");
                }
            }
            NodeEvent::Message { topic, message, received, publisher } => {
                if self.safety.take_surface(topic, message, *received) {
                    return;
                }
                if let AnyMessage::Image(image) = message {
                    self.safety.take_image(topic, image, publisher, *received);
                }
            }
            NodeEvent::Transforms { received, is_static, .. } => {
                self.transforms_received = Some(*received);
                if !is_static {
                    self.safety.note_transforms(*received);
                }
            }
            NodeEvent::TimeJumpedBack { from, to } => {
                log::warn!(
                    "time jumped back from {} to {}: all frames and messages are dropped",
                    time_from_stamp(*from),
                    time_from_stamp(*to)
                );
                self.shared.cameras().iter_mut().for_each(CameraPublisher::forget_messages);
                self.safety.reset();
            }
            _ => {}
        }
        if matches!(event, NodeEvent::Message { .. }) {
            self.renderer.forget_snapshot();
        }
        let now = self.now();
        self.subscriptions.apply(event, &mut self.scene, now);
    }

    /// Shows a pattern of a calibration.
    ///
    /// # Errors
    /// It cannot be read, or fits no camera.
    fn take_pattern(&self, image: &Image, received: Instant) -> Result<(), String> {
        let pattern = Pattern::new(image, received)?;
        let place = |camera: &CameraPublisher| camera.frame_and_size(&self.scene);
        let places: Vec<_> = self.shared.cameras().iter().filter_map(place).collect();
        match pattern.misfit(&places) {
            Some(why) => return Err(why),
            None => self.shared.control.show_pattern(pattern),
        }
        Ok(())
    }

    /// Draws and publishes the frames that are due. As many are submitted as the renderer works on at once, and each is
    /// published as soon as it is finished. Returns `true` if the scene is newer than these frames.
    fn publish(&mut self) -> bool {
        self.assess();
        let count = self.shared.cameras().len();
        let mut in_flight = InFlight::new();
        let mut is_size_gone = false;
        for index in 0..count {
            match self.begin(index, &mut is_size_gone) {
                Ok(frame) => in_flight.extend(frame.map(|frame| (index, frame))),
                Err(error) => self.record_error(index, &error, &mut in_flight),
            }
            if in_flight.len() >= self.renderer.frames_at_once() {
                self.finish(&mut in_flight);
            }
        }
        let ahead = self.take_ahead();
        while !in_flight.is_empty() {
            self.finish(&mut in_flight);
        }
        if let Some(decoded) = ahead {
            self.record_update(decoded);
        }
        if is_size_gone {
            self.renderer.forget_sizes();
        }
        if !self.shared.cameras().iter().any(CameraPublisher::uses_depth) {
            self.renderer.forget_depths();
        }
        ahead.is_some()
    }

    /// While a GPU draws: takes the events in which a message has arrived, and uploads the clouds of the next images.
    /// Returns when the scene was up to date; `None` without such events, for which no image waits.
    fn take_ahead(&mut self) -> Option<Instant> {
        if !self.renderer.can_upload() {
            return None;
        }
        let shared = Arc::clone(&self.shared);
        let events = shared.ros.events().drain_if(|event| matches!(event, NodeEvent::Message { .. }));
        if events.is_empty() {
            return None;
        }
        events.into_iter().for_each(|event| self.handle(event));
        self.update_scene(self.now());
        let decoded = Instant::now();
        let scene = self.renderer.snapshot(&self.scene);
        let watched = |camera: &CameraPublisher| camera.is_watched().then(|| Arc::clone(camera.view()));
        let views: Vec<_> = shared.cameras().iter().filter_map(watched).collect();
        views.iter().for_each(|view| self.renderer.upload(&scene, &view.visible));
        Some(decoded)
    }

    fn assess(&mut self) {
        let steady = Instant::now();
        let now = Now { ros: self.now(), steady, resumed: self.shared.pulse.resumed(steady) };
        let state = &self.scene;
        // Where the projector's light goes, however the image is drawn.
        let model = CameraModel { projection: Projection::Exact, undistort: true };
        let view_of = |camera: &CameraPublisher| (Arc::clone(camera.view()), camera.is_watched());
        let (views, watched): (Vec<_>, Vec<_>) = self.shared.cameras().iter().map(view_of).unzip();
        let needs_camera = self.safety.needs_cameras();
        let cameras: Vec<_> =
            views.iter().map(|view| needs_camera.then(|| camera(state, view, model).ok()).flatten()).collect();
        let lit = views.iter().zip(&cameras).zip(&watched).map(|((view, camera), is_watched)| LitView {
            view,
            is_watched: *is_watched,
            camera: camera.as_ref(),
            unknown_lens: camera.as_ref().and_then(|camera| unknown_lens(state, view, camera)),
        });
        let lit: Vec<_> = lit.collect();
        let subscriptions = &self.subscriptions;
        let (ros, light_topics) = (&self.shared.ros, &self.light_topics);
        self.safety.follow_publishers(|topic| light_topics.publishers(ros, topic), steady);
        let lights = self.safety.assess(state, &lit, |name, kind| subscriptions.source(name, kind), now);
        for (view, light) in views.iter().zip(&lights) {
            if let Some(info) = state.camera_info(view) {
                self.oriented_frames.add(ros, &info.header.frame_id, light.evidence.post().orientation);
            }
        }
        let mut cameras = self.shared.cameras();
        cameras.iter_mut().zip(lights).for_each(|(camera, light)| camera.set_light(light));
    }

    /// Submits the frame of a camera if one is due and looks different from the last. `is_size_gone` is set if the
    /// camera had another size before.
    fn begin(&mut self, index: usize, is_size_gone: &mut bool) -> Result<Option<FrameInFlight>> {
        let shared = Arc::clone(&self.shared);
        let due = shared.cameras().get_mut(index).map(|camera| camera.poll(&self.scene)).transpose()?;
        let Some(due) = due.flatten() else { return Ok(None) };
        shared.activity.begin(SceneStep::Frame(due.view.name.clone()));
        let size_px = [due.camera.width_px(), due.camera.height_px()];
        let frame = self.renderer.submit(due, &self.scene)?;
        *is_size_gone |= shared.cameras().get_mut(index).is_some_and(|camera| camera.set_drawn_px(size_px));
        Ok(Some(frame))
    }

    /// Finishes and publishes the frame that was submitted first.
    fn finish(&mut self, in_flight: &mut InFlight) {
        let Some((index, frame)) = in_flight.pop_front() else { return };
        if let Err(error) = self.finish_frame(index, frame) {
            self.record_error(index, &error, in_flight);
        }
    }

    fn finish_frame(&mut self, index: usize, frame: FrameInFlight) -> Result<()> {
        let memory = self.shared.cameras().get_mut(index).map(CameraPublisher::take_back_buffer);
        let Some(finished) = self.renderer.finish(frame, memory.unwrap_or_default())? else { return Ok(()) };
        let slow = self.renderer.slow_frame(&self.scene);
        let mut cameras = self.shared.cameras();
        let Some(camera) = cameras.get_mut(index) else { return Ok(()) };
        slow.into_iter().for_each(|slow| camera.record_slow_frame(slow));
        camera.publish(finished)
    }

    /// Records why a camera's frame failed. An error does not end the node. If the GPU failed, all frames are lost.
    fn record_error(&mut self, index: usize, error: &Error, in_flight: &mut InFlight) {
        if let Some(camera) = self.shared.cameras().get_mut(index) {
            camera.record_error(error);
        }
        if has_gpu_failed(error) {
            in_flight.clear();
        }
    }
}
