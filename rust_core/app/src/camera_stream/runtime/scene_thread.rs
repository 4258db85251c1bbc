//! The scene's thread: takes what was received, brings the scene up to date, draws what is watched and hands it to the
//! outputs.

use std::collections::VecDeque;
use std::sync::Arc;
use std::time::{Duration, Instant};

use anyhow::Result;
use rcs_camera::{CameraModel, Projection};
use rcs_displays::{time_from_stamp, Reconfigured};
use rcs_messages::AnyMessage;
use rcs_render::{CpuRenderer, Finished, RenderError, Renderer, RendererChoice, View};
use rcs_resources::{MeshStore, PackageIndex};
use rcs_ros::NodeEvent;
use rcs_rviz_config::Config;
use rcs_scene::{DepthPicture, Picture, Scene};
use rcs_transforms::Time;

use crate::camera_stream::camera::latency::Update;
use crate::camera_stream::camera::oriented_frames::OrientedFrames;
use crate::camera_stream::camera::output::{self, CameraOutput};
use crate::camera_stream::camera::plan;
use crate::camera_stream::camera::progress::Progress;
use crate::camera_stream::camera_names;
use crate::camera_stream::cli::Cli;
use crate::camera_stream::outputs::depth_image::DepthEncoding;
use crate::camera_stream::prediction::PredictionSettings;
use crate::camera_stream::private_parameters;
use crate::camera_stream::runtime::activity::Step;
use crate::camera_stream::runtime::costs::Costs;
use crate::camera_stream::runtime::shared::{Reload, Shared};
use crate::camera_stream::runtime::windows::Windows;
use crate::camera_stream::safety::ages::{Assessment, Now};
use crate::camera_stream::safety::read_rules::{self, MaskTopics};
use crate::camera_stream::safety::status;
use crate::camera_stream::safety::{FramePolicy, LitView, Safety};
use crate::camera_stream::scene::status_tree::EntryKind;
use crate::camera_stream::scene::subscriptions::Subscriptions;
use crate::camera_stream::scene::visibility::{self, PlacedCamera};
use crate::camera_stream::scene::{renderer_view, SceneState};

/// How long the thread sleeps at most when nothing happens.
const LONGEST_SLEEP: Duration = Duration::from_millis(500);

/// So many markers are placed between two looks at what else there is to do: at most a twentieth of a second of work.
const MARKERS_IN_STEP: usize = 20_000;

/// The scene and what draws it.
pub(crate) struct SceneLoop {
    shared: Arc<Shared>,
    stage: SceneState,
    renderer: Box<dyn Renderer>,
    renderer_choice: RendererChoice,
    model: CameraModel,
    prediction: PredictionSettings,
    /// Streams that nobody watches are not received.
    is_lazy: bool,
    safety: Safety,
    masks: MaskTopics,
    /// Those of the cameras, when pictures were last looked for.
    policies: Vec<FramePolicy>,
    oriented_frames: OrientedFrames,
    depth_encoding: DepthEncoding,
    /// How far away is what the picture at hand shows.
    depth: DepthPicture,
    /// Memory to turn pictures with.
    turned: Picture,
    /// Pixels in a row and rows of each camera's last picture; none before the first.
    sizes_px: Vec<Option<[u32; 2]>>,
    subscriptions: Subscriptions,
    /// The command line's, which overrides the config's.
    fixed_frame: Option<String>,
    scene: Option<(u64, Arc<Scene>)>,
    /// When the last transforms were received since the last update.
    transforms_received: Option<Instant>,
    /// Of the picture at hand.
    costs: Costs,
    windows: Windows,
}

impl SceneLoop {
    /// Subscribes and advertises what a config asks for.
    ///
    /// # Errors
    /// One line that names what failed: a topic, the renderer.
    pub(crate) fn start(cli: &Cli, config: &Config, shared: &Arc<Shared>) -> Result<Self> {
        let ros = &shared.ros;
        let renderer_choice = private_parameters::renderer(ros, cli.renderer)?;
        let model = private_parameters::camera_model(ros, &cli.model, None)?;
        let is_lazy = private_parameters::switch(ros, cli.node.no_lazy.then_some(false), "~lazy")?;
        let depth_encoding = private_parameters::depth_encoding(ros, cli.node.depth.depth_encoding)?;
        let prediction = PredictionSettings::read(ros, &cli.node.prediction)?;
        let (rules, masks) = read_rules::read(ros, &cli.node, &camera_names(config))?;
        let safety = Safety::new(rules);
        let renderer = rcs_render::create(renderer_choice)?;
        let resources = private_parameters::resources(ros, &cli.resources)?;
        let events = Arc::clone(ros.events());
        let meshes = MeshStore::in_background(PackageIndex::from_env(&[]), resources, move || events.wake());
        let mut stage = SceneState::new(config, cli.node.fixed_frame.as_deref(), meshes);
        stage.place_in_steps(MARKERS_IN_STEP);
        if stage.cameras().is_empty() {
            log::warn!("{}: no enabled CameraPub display, so there is nothing to publish", config.source);
        }
        let plans = plan::plans(ros, config)?;
        let windows = Windows::open(ros, &cli.node.screens, &safety, &plans)?;
        let cameras = plan::rearrange(ros, plans, Vec::new(), config, stage.displays(), &windows);
        ros.subscribe_transforms()?;
        let mut subscriptions = Subscriptions::default();
        subscriptions.update(ros, stage.topics());
        ros.follow_parameters(stage.parameters());
        log::info!("drawing {} of {} with {}", output::names(&cameras), config.source, renderer.describe());
        *shared.cameras() = cameras;
        stage.update(time_from_stamp(ros.now()));
        Ok(Self {
            shared: Arc::clone(shared),
            stage,
            renderer,
            renderer_choice,
            model,
            prediction,
            is_lazy: is_lazy.unwrap_or(true),
            safety,
            masks,
            policies: Vec::new(),
            oriented_frames: OrientedFrames::default(),
            depth_encoding,
            depth: DepthPicture::default(),
            turned: Picture::default(),
            sizes_px: Vec::new(),
            subscriptions,
            fixed_frame: cli.node.fixed_frame.clone(),
            scene: None,
            transforms_received: None,
            costs: Costs::default(),
            windows,
        })
    }

    fn now(&self) -> Time {
        time_from_stamp(self.shared.ros.now())
    }

    /// Runs until the end is requested.
    pub(crate) fn run(mut self) {
        let shared = Arc::clone(&self.shared);
        while !shared.is_ending() {
            shared.activity.rest();
            let events = shared.ros.events().wait(self.sleep());
            self.costs.clear();
            let mut has_news = !events.is_empty() || self.stage.has_new_resources();
            for event in events {
                self.handle(event);
            }
            has_news |= self.apply_changes();
            has_news |= self.attend_streams();
            let now = self.now();
            has_news |= self.predict(now);
            if has_news || self.stage.displays().next_change().is_some_and(|change| change <= now) {
                self.update(now);
            }
            // The first picture after a pause is to show what is, not what was.
            if self.subscriptions.awaited(Instant::now()).is_none() {
                self.publish();
            }
            self.report_statuses();
        }
    }

    /// Pauses streams that nobody watches, and resumes them. Returns whether the scene changed.
    fn attend_streams(&mut self) -> bool {
        let is_watched = !self.is_lazy || self.shared.cameras().iter().any(CameraOutput::is_watched);
        let has_changed = self.subscriptions.attend(is_watched, &mut self.stage);
        if has_changed {
            self.scene = None;
            self.shared.cameras().iter_mut().for_each(CameraOutput::discard_last);
        }
        has_changed
    }

    /// Looks ahead of the transforms from now on, if that is set; by as much as the slowest camera needs. Returns
    /// whether that moves frames without news.
    fn predict(&mut self, now: Time) -> bool {
        let way = self.shared.cameras().iter().filter_map(CameraOutput::way).max();
        let prediction = self.prediction.prediction(now, way);
        self.stage.predict(prediction);
        prediction.is_some()
    }

    /// Applies what the control thread has taken: another config, a user's settings. Returns whether the scene may have
    /// changed.
    fn apply_changes(&mut self) -> bool {
        let is_retry = self.shared.take_retry();
        if is_retry {
            self.stage.retry_resources();
        }
        // Taken out first, so that the place is not locked meanwhile.
        let reload = self.shared.reload().take();
        let is_reloaded = reload.map(|reload| self.reload(reload)).is_some();
        for camera in self.shared.cameras().iter_mut() {
            camera.apply_new_settings(self.stage.displays());
        }
        is_reloaded || is_retry
    }

    /// Applies another config. Only what differs changes: subscriptions, publishers and services that are kept are not
    /// touched, and displays that are kept show what they did.
    fn reload(&mut self, Reload { config, reply }: Reload) {
        let shared = Arc::clone(&self.shared);
        shared.activity.begin(Step::Config);
        let ros = &shared.ros;
        let plans = match plan::plans(ros, &config) {
            Ok(plans) => plans,
            // It was possible when the config was read.
            Err(error) => return log::error!("{}: {error}", config.source),
        };
        let known_parameters = self.stage.parameters();
        let changed = self.stage.reconfigure(&config, self.fixed_frame.as_deref(), self.now());
        self.subscriptions.update(ros, self.stage.topics());
        let is_new = |name: &String| !known_parameters.contains(name);
        ros.follow_parameters(self.stage.parameters().into_iter().filter(is_new).collect());
        {
            let mut cameras = shared.cameras();
            let known = std::mem::take(&mut *cameras);
            self.windows.clear_those_without(&plans);
            *cameras = plan::rearrange(ros, plans, known, &config, self.stage.displays(), &self.windows);
        }
        let Reconfigured { kept, added, removed } = changed;
        let changed = format!("{}: {kept} displays kept, {added} added, {removed} removed", config.source);
        let changed = match self.safety.set_cameras(&camera_names(&config)) {
            Some(why) => format!("{changed}; all cameras are dark: {why}"),
            None => changed,
        };
        match reply {
            Some(reply) => reply.send(true, changed),
            None => log::info!("the config changed: {changed}"),
        }
    }

    /// Brings the scene up to date.
    fn update(&mut self, now: Time) {
        self.shared.activity.begin(Step::Displays);
        self.stage.update(now);
        self.costs.add(self.stage.take_costs());
        let shown = self.stage.displays().newly_shown();
        let transforms_received = self.transforms_received.take();
        let update = Update { shown, transforms_received, decoded: Instant::now() };
        self.shared.cameras().iter_mut().for_each(|camera| camera.record_update(&update));
    }

    /// How long until something is due by itself: a camera's next picture, or a change of the scene.
    fn sleep(&mut self) -> Duration {
        let now = Instant::now();
        let awaited = self.subscriptions.awaited(now);
        let due = self.shared.cameras().iter().filter_map(|camera| camera.until_due(now)).min();
        let cameras = awaited.or(due);
        let change = self.stage.displays().next_change().map(|change| change.saturating_since(self.now()));
        let diagnostics = self.shared.diagnostics().until_due(now);
        // A little later, so that it is over then.
        let stale = self.safety.assessment().and_then(Assessment::next_change).into_iter();
        let stale = stale.chain(self.policies.iter().filter_map(|policy| policy.valid_until)).min();
        let stale = stale.map(|at| at.saturating_duration_since(now) + Duration::from_millis(1));
        cameras.into_iter().chain(change).chain(stale).fold(diagnostics.min(LONGEST_SLEEP), Duration::min)
    }

    /// Reports the status of each display and camera.
    fn report_statuses(&mut self) {
        let shared = Arc::clone(&self.shared);
        if !shared.diagnostics().is_due() {
            return;
        }
        shared.activity.begin(Step::Statuses);
        let (stage, model) = (&self.stage, self.model);
        let mut entries = stage.status_entries(self.now());
        for entry in entries.iter_mut().filter(|entry| self.subscriptions.is_paused(&entry.topic)) {
            entry.values.push(("received", "not while nobody watches".to_owned()));
        }
        status::add(&mut entries, &self.safety);
        let is_published = shared.diagnostics().until_due(Instant::now()).is_zero();
        if is_published {
            // This may take long, so the cameras are not locked meanwhile.
            let views: Vec<_> = shared.cameras().iter().map(|camera| Arc::clone(camera.view())).collect();
            let place = |view: &Arc<_>| stage.camera(view, model).ok();
            let placed: Vec<_> = views.iter().map(|view| PlacedCamera { view, camera: place(view) }).collect();
            visibility::add(&mut entries, stage.displays(), &placed);
        }
        entries.extend(shared.cameras().iter().map(|camera| camera.status_entry(stage, model)));
        let cameras = entries.iter_mut().filter(|entry| entry.kind == EntryKind::Camera);
        cameras.zip(&self.policies).for_each(|(entry, policy)| status::add_dark(entry, policy));
        shared.diagnostics().report(&shared.ros, entries);
    }

    /// Applies an event to the scene.
    fn handle(&mut self, event: NodeEvent) {
        match &event {
            // The scene is put together again. Dropped here already, it holds no clouds whose memory the next ones can
            // use.
            NodeEvent::Message { topic, .. } => {
                self.shared.activity.begin(Step::Message(Arc::clone(topic)));
                self.scene = None;
            }
            NodeEvent::Transforms { received, is_static, .. } => {
                self.shared.activity.begin(Step::Event);
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
                self.shared.cameras().iter_mut().for_each(CameraOutput::forget_messages);
                self.safety.reset();
            }
            _ => self.shared.activity.begin(Step::Event),
        }
        if let NodeEvent::Message { topic, message: AnyMessage::Image(image), received, .. } = &event {
            self.safety.take_image(topic, image, *received);
        }
        let now = self.now();
        self.subscriptions.apply(event, &mut self.stage, now);
    }

    /// Draws and publishes what is due: as many pictures are begun as the renderer works on at once, and each is
    /// published as soon as it is finished.
    fn publish(&mut self) {
        let shared = Arc::clone(&self.shared);
        self.assess();
        let mut in_flight = VecDeque::new();
        let count = shared.cameras().len();
        let sizes_px = self.sizes_px.clone();
        self.sizes_px.resize(count, None);
        for index in 0..count {
            let begun = self.begin(index);
            if matches!(begun, Ok(Progress::Begun(()))) {
                in_flight.push_back(index);
            }
            self.record_result(index, begun);
            if in_flight.len() >= self.renderer.pictures_at_once() {
                self.finish(in_flight.pop_front());
            }
        }
        while !in_flight.is_empty() {
            self.finish(in_flight.pop_front());
        }
        let is_gone = |(index, size): (usize, &Option<_>)| size.is_some() && self.sizes_px.get(index) != Some(size);
        if sizes_px.iter().enumerate().any(is_gone) {
            self.renderer.forget_sizes();
        }
        if !shared.cameras().iter().any(CameraOutput::wants_depth) {
            self.depth = DepthPicture::default();
        }
    }

    /// Asks what the cameras may show now.
    fn assess(&mut self) {
        let now = Now { ros: self.now(), steady: Instant::now() };
        let stage = &self.stage;
        // Where the projector's light goes, however the picture is drawn.
        let model = CameraModel { projection: Projection::Exact, undistort: true };
        let views: Vec<_> = self.shared.cameras().iter().map(|camera| Arc::clone(camera.view())).collect();
        let needs_camera = self.safety.needs_cameras();
        let cameras: Vec<_> =
            views.iter().map(|view| needs_camera.then(|| stage.camera(view, model).ok()).flatten()).collect();
        let lit = views.iter().zip(&cameras).map(|(view, camera)| LitView {
            view,
            camera: camera.as_ref(),
            unknown_lens: camera.as_ref().and_then(|camera| stage.unknown_lens(view, camera)),
        });
        let lit: Vec<_> = lit.collect();
        let source = |name: &str, kind| self.masks.source(name).or_else(|| self.subscriptions.source(name, kind));
        self.policies = self.safety.assess(stage, &lit, source, now);
        for (view, policy) in views.iter().zip(&self.policies) {
            if let Some(info) = stage.camera_info(view) {
                self.oriented_frames.add(&self.shared.ros, &info.header.frame_id, policy.post.orientation);
            }
        }
    }

    /// Begins the picture of a camera if one is due and has changed.
    fn begin(&mut self, index: usize) -> Result<Progress> {
        let shared = Arc::clone(&self.shared);
        let Some(policy) = self.policies.get(index) else { return Ok(Progress::NotDue) };
        let begun = match shared.cameras().get_mut(index) {
            Some(camera) => camera.begin_if_due(&self.stage, self.model, policy, &shared.ros)?,
            None => Progress::NotDue,
        };
        let due = match begun {
            Progress::Begun(due) => due,
            Progress::NotDue => return Ok(Progress::NotDue),
            Progress::Published => return Ok(Progress::Published),
        };
        shared.activity.begin(Step::Picture(due.view.name.clone()));
        let scene = self.scene();
        let view = View { visible: &due.visible, ..renderer_view(&due.view, &scene, &due.camera) };
        let wants_depth = shared.cameras().get(index).is_some_and(CameraOutput::wants_depth);
        match wants_depth {
            true => self.renderer.submit_with_depth(&view, &mut self.depth)?,
            false => self.renderer.submit(&view)?,
        }
        if let Some(size_px) = self.sizes_px.get_mut(index) {
            *size_px = Some([due.camera.width_px(), due.camera.height_px()]);
        }
        if let Some(camera) = shared.cameras().get_mut(index) {
            camera.set_depth_encoding(self.depth_encoding);
            camera.record_begun(due, wants_depth.then_some(&self.depth));
        }
        Ok(Progress::Begun(()))
    }

    /// The scene as it is now, for all cameras.
    fn scene(&mut self) -> Arc<Scene> {
        let version = self.stage.displays().version();
        let current = self.scene.take().filter(|(known, _)| *known == version);
        let (_, scene) = self.scene.insert(current.unwrap_or_else(|| (version, Arc::new(self.stage.scene()))));
        Arc::clone(scene)
    }

    /// Publishes the picture that was begun first, which is that of this camera.
    fn finish(&mut self, index: Option<usize>) {
        let shared = Arc::clone(&self.shared);
        let Some(index) = index else { return };
        let Some(mut picture) = shared.cameras().get_mut(index).map(CameraOutput::take_spare) else { return };
        let result = self.finish_picture(index, &mut picture);
        self.record_result(index, result);
    }

    fn finish_picture(&mut self, index: usize, picture: &mut Picture) -> Result<Progress> {
        let step = self.shared.cameras().get(index).map(CameraOutput::last_step).unwrap_or_default();
        let keeps_drawn = self.shared.cameras().get(index).is_some_and(CameraOutput::keeps_drawn);
        // It is lost where the renderer lost those of all cameras.
        let Finished::Drawn = self.renderer.finish(picture)? else { return Ok(Progress::NotDue) };
        let drawn = keeps_drawn.then(|| Arc::new(picture.clone()));
        step.apply(picture, &mut self.turned);
        let slow = self.costs.slow_picture(self.renderer.as_ref(), self.stage.displays());
        let mut cameras = self.shared.cameras();
        let Some(camera) = cameras.get_mut(index) else { return Ok(Progress::NotDue) };
        if let Some(slow) = slow {
            camera.record_slow_picture(slow);
        }
        camera.finish(std::mem::take(picture), drawn, &self.shared.ros).map(|()| Progress::Published)
    }

    /// Records the result of rendering and publishing a camera's picture. An error is logged once and does not end the
    /// node. A GPU that `auto` chose and that fails is replaced by the CPU.
    fn record_result(&mut self, index: usize, result: Result<Progress>) {
        let gpu_failed = has_gpu_failed(&result);
        let mut cameras = self.shared.cameras();
        if let Some(camera) = cameras.get_mut(index) {
            camera.record_result(result);
        }
        if gpu_failed {
            cameras.iter_mut().for_each(CameraOutput::discard_in_flight);
            if let Some(renderer) = instead_of_gpu(self.renderer_choice) {
                self.renderer = renderer;
                log::warn!("drawing with {} from now on", self.renderer.describe());
            }
        }
    }
}

/// Whether a picture is missing because the GPU is lost, hangs or is out of memory.
fn has_gpu_failed(result: &Result<Progress>) -> bool {
    matches!(result, Err(error) if matches!(error.downcast_ref(), Some(RenderError::Gpu { .. })))
}

/// What draws when the GPU has failed; `None`: the GPU again, which is opened anew.
fn instead_of_gpu(choice: RendererChoice) -> Option<Box<dyn Renderer>> {
    (choice == RendererChoice::Auto).then(|| Box::new(CpuRenderer::new()) as Box<dyn Renderer>)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_gpu_that_fails_is_replaced_by_the_cpu_where_auto_had_chosen_it() {
        let lost = RenderError::Gpu { adapter: "a GPU".into(), reason: "the device was lost".into() };
        let too_large =
            RenderError::TooLarge { width_px: 9, height_px: 9, limit_px: 8, renderer: "gpu (a GPU)".into() };
        assert!(has_gpu_failed(&Err(lost.into())));
        assert!(!has_gpu_failed(&Err(too_large.into())) && !has_gpu_failed(&Ok(Progress::Published)));
        let replaced = instead_of_gpu(RendererChoice::Auto).map(|renderer| renderer.describe());
        assert!(replaced.is_some_and(|name| name.starts_with("cpu")));
        for choice in [RendererChoice::Gpu, RendererChoice::Cpu] {
            assert!(instead_of_gpu(choice).is_none());
        }
    }
}
