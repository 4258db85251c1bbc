//! `camera_stream` as a ROS node.
//!
//! One thread owns the stage: it handles what was received, brings the scene up to date, draws what is watched and
//! hands it to the outputs. Nothing is drawn that nobody subscribes to, and a scene that did not change is not drawn
//! again: its last picture is published with a new stamp.

mod camera;
mod camera_health;
mod camera_plan;
mod diagnostics;
mod file_watch;
mod latency;
mod reconfigurable;
mod reload;
mod runtime_settings;
mod schedule;

use std::collections::VecDeque;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

use anyhow::{Context, Result};
use rcs_displays::time_from_stamp;
use rcs_render::{CpuRenderer, RenderError, Renderer, RendererChoice};
use rcs_resources::{MeshStore, PackageIndex};
use rcs_ros::{NodeEvent, RosNode};
use rcs_rviz_config::Config;
use rcs_scene::Scene;
use rcs_transforms::Time;

use crate::camera_stream::camera_pose::Projection;
use crate::camera_stream::cli::Cli;
use crate::camera_stream::private_parameters;
use crate::camera_stream::stage::Stage;
use crate::camera_stream::subscriptions::Subscriptions;
use crate::camera_stream::visibility::{self, PlacedCamera};
use crate::camera_stream::NODE_NAME;
use crate::logging::one_line;
use crate::small_node::{self, EndRequest};
use camera::{CameraOutput, Drawing};
use diagnostics::Diagnostics;
use file_watch::FileWatch;
use latency::Update;

/// How long the node sleeps at most when nothing happens.
const LONGEST_SLEEP: Duration = Duration::from_millis(100);

/// Runs the node until it is asked to end.
///
/// # Errors
/// One line that names what failed: the master's address, a topic, the renderer.
pub fn run(cli: &Cli, config: &Config) -> Result<()> {
    for finding in &config.findings {
        log::warn!("{}: {finding}", config.source);
    }
    let end = EndRequest::watch_signals().context("cannot handle signals")?;
    let Some(ros) = small_node::connect(NODE_NAME, &end)? else { return Ok(()) };
    let result = Node::start(cli, config, &ros).map(|mut node| node.run(&end));
    ros.shutdown();
    result
}

/// Watches the config's file, unless `--no-watch` or `~watch` says not to.
fn watch(cli: &Cli, ros: &RosNode) -> Result<Option<FileWatch>> {
    let is_wanted = !cli.node.no_watch && ros.bool_param("~watch").unwrap_or(true);
    let Some(file) = cli.node.display_config.clone().filter(|_| is_wanted) else { return Ok(None) };
    let events = ros.events().clone();
    FileWatch::start(file, move || events.wake()).map(Some).context("cannot watch the config")
}

struct Node<'a> {
    ros: &'a RosNode,
    stage: Stage,
    renderer: Box<dyn Renderer>,
    projection: Projection,
    cameras: Vec<CameraOutput>,
    subscriptions: Subscriptions,
    /// As it was last read.
    config: Config,
    file: PathBuf,
    /// The command line's, which overrides the config's.
    fixed_frame: Option<String>,
    /// The whole name of the service that reloads the config.
    reload_service: Arc<str>,
    watch: Option<FileWatch>,
    /// Incremented with every change of the scene.
    scene_version: u64,
    scene: Option<(u64, Arc<Scene>)>,
    renderer_choice: RendererChoice,
    diagnostics: Diagnostics,
    /// When the last transforms were received since the last update.
    transforms_received: Option<Instant>,
}

impl<'a> Node<'a> {
    fn start(cli: &Cli, config: &Config, ros: &'a RosNode) -> Result<Self> {
        let renderer_choice = private_parameters::renderer(ros, cli.renderer)?;
        let projection = private_parameters::projection(ros, cli.projection, &["~projection"])?;
        let renderer = rcs_render::create(renderer_choice)?;
        let resources = private_parameters::resources(ros, &cli.resources)?;
        let events = ros.events().clone();
        let meshes = MeshStore::in_background(PackageIndex::from_env(&[]), resources, move || events.wake());
        let stage = Stage::new(config, cli.node.fixed_frame.as_deref(), meshes);
        if stage.cameras().is_empty() {
            log::warn!("{}: no enabled CameraPub display, so there is nothing to publish", config.source);
        }
        let plans = camera_plan::plans(ros, config)?;
        let cameras = camera_plan::rearrange(ros, plans, Vec::new(), config, stage.displays());
        ros.subscribe_transforms()?;
        let mut subscriptions = Subscriptions::default();
        subscriptions.update(ros, stage.topics());
        ros.follow_parameters(stage.parameters());
        log::info!("drawing {} of {} with {}", camera::names(&cameras), config.source, renderer.describe());
        Ok(Self {
            ros,
            stage,
            renderer,
            projection,
            cameras,
            subscriptions,
            watch: watch(cli, ros)?,
            reload_service: ros.serve_trigger("~reload_config")?,
            config: config.clone(),
            file: cli.node.display_config.clone().unwrap_or_default(),
            fixed_frame: cli.node.fixed_frame.clone(),
            scene_version: 0,
            scene: None,
            renderer_choice,
            diagnostics: Diagnostics::start(ros),
            transforms_received: None,
        })
    }

    fn now(&self) -> Time {
        time_from_stamp(self.ros.now())
    }

    fn run(&mut self, end: &EndRequest) {
        self.stage.update(self.now());
        while !end.is_requested() {
            let events = self.ros.events().wait(self.sleep());
            let mut has_news = !events.is_empty() || self.stage.has_new_resources();
            for event in events {
                self.handle(event);
            }
            if self.watch.as_ref().is_some_and(FileWatch::take_change) {
                self.reload_changed_file();
                has_news = true;
            }
            let now = self.now();
            if has_news || self.stage.displays().next_change().is_some_and(|change| change <= now) {
                self.update(now);
            }
            self.publish();
            self.report_statuses();
        }
    }

    /// Brings the scene up to date.
    fn update(&mut self, now: Time) {
        self.scene_version += u64::from(self.stage.update(now));
        let shown = self.stage.displays().newly_shown();
        let transforms_received = self.transforms_received.take();
        let update = Update { shown, transforms_received, decoded: Instant::now() };
        self.cameras.iter_mut().for_each(|camera| camera.record_update(&update));
    }

    /// How long until something is due by itself: a camera's next picture, or a change of the scene.
    fn sleep(&self) -> Duration {
        let now = Instant::now();
        let cameras = self.cameras.iter().filter_map(|camera| camera.until_due(now)).min();
        let change = self.stage.displays().next_change().map(|change| change.saturating_since(self.now()));
        let diagnostics = self.diagnostics.until_due(now);
        cameras.into_iter().chain(change).fold(diagnostics.min(LONGEST_SLEEP), Duration::min)
    }

    /// Reports the status of each display and camera.
    fn report_statuses(&mut self) {
        let (stage, projection, cameras, now) = (&self.stage, self.projection, &self.cameras, self.now());
        self.diagnostics.report(self.ros, |is_published| {
            let mut entries = stage.status_entries(now);
            if is_published {
                let place = |camera: &'_ CameraOutput| stage.camera(camera.view(), projection).ok();
                let placed = cameras.iter().map(|camera| PlacedCamera { view: camera.view(), camera: place(camera) });
                visibility::add(&mut entries, stage.displays(), &placed.collect::<Vec<_>>());
            }
            entries.extend(cameras.iter().map(|camera| camera.status_entry(stage, projection)));
            entries
        });
    }

    fn handle(&mut self, event: NodeEvent) {
        match event {
            NodeEvent::Trigger { service, reply } if service == self.reload_service => match self.reload() {
                Ok(changed) => reply.send(true, changed.unwrap_or_else(|| "nothing changed".to_owned())),
                Err(error) => reply.send(false, one_line(&error)),
            },
            NodeEvent::Trigger { service, reply } => match self.cameras.iter_mut().find(|c| c.serves(&service)) {
                Some(camera) => camera.trigger(reply),
                None => reply.send(false, "Image publisher not configured"),
            },
            NodeEvent::Reconfigure { server, request, reply } => {
                // Without an answer, the caller gets an error.
                if let Some(camera) = self.cameras.iter_mut().find(|camera| camera.has_parameters(&server)) {
                    reply.answer(camera.reconfigure(&request, self.stage.displays(), self.ros));
                }
            }
            event => self.apply(event),
        }
    }

    /// Applies an event that changes the scene.
    fn apply(&mut self, event: NodeEvent) {
        match &event {
            // The scene is put together again. Dropped here already, it holds no clouds whose memory the next ones can
            // use.
            NodeEvent::Message { .. } => self.scene = None,
            NodeEvent::Transforms { received, .. } => self.transforms_received = Some(*received),
            NodeEvent::TimeJumpedBack { from, to } => {
                log::warn!(
                    "time jumped back from {} to {}: all frames and messages are dropped",
                    time_from_stamp(*from),
                    time_from_stamp(*to)
                );
                self.cameras.iter_mut().for_each(CameraOutput::forget_messages);
                self.scene_version += 1;
            }
            _ => {}
        }
        let now = self.now();
        self.subscriptions.apply(event, &mut self.stage, now);
    }

    /// Draws and publishes what is due: as many pictures are begun as the renderer works on at once, and each is
    /// published as soon as it is finished.
    fn publish(&mut self) {
        let mut in_flight = VecDeque::new();
        for index in 0..self.cameras.len() {
            let (stage, scene_version, cached) = (&self.stage, self.scene_version, &mut self.scene);
            let scene = || {
                let (_, scene) = match cached.take() {
                    Some(current) if current.0 == scene_version => cached.insert(current),
                    _ => cached.insert((scene_version, Arc::new(stage.scene()))),
                };
                scene.clone()
            };
            let Some(camera) = self.cameras.get_mut(index) else { continue };
            let (projection, renderer) = (self.projection, self.renderer.as_mut());
            let drawing = Drawing { stage, scene_version, projection, renderer, ros: self.ros };
            match camera.begin_if_due(drawing, scene) {
                Ok(true) => in_flight.push_back(index),
                result => self.record_result(index, result.map(|_| ())),
            }
            if in_flight.len() >= self.renderer.pictures_at_once() {
                self.finish(in_flight.pop_front());
            }
        }
        while !in_flight.is_empty() {
            self.finish(in_flight.pop_front());
        }
    }

    /// Publishes the picture that was begun first, which is that of this camera.
    fn finish(&mut self, index: Option<usize>) {
        let Some((index, camera)) = index.and_then(|index| Some((index, self.cameras.get_mut(index)?))) else { return };
        let result = camera.finish(self.renderer.as_mut(), self.ros);
        self.record_result(index, result);
    }

    /// Records the result of rendering and publishing a camera's picture. An error is logged once and does not end the
    /// node. A GPU that `auto` chose and that fails is replaced by the CPU.
    fn record_result(&mut self, index: usize, result: Result<()>) {
        let gpu_failed = matches!(&result, Err(error) if matches!(error.downcast_ref(), Some(RenderError::Gpu { .. })));
        if let Some(camera) = self.cameras.get_mut(index) {
            camera.record_result(result);
        }
        if gpu_failed {
            self.cameras.iter_mut().for_each(CameraOutput::discard_in_flight);
        }
        if gpu_failed && self.renderer_choice == RendererChoice::Auto {
            self.renderer = Box::new(CpuRenderer::new());
            log::warn!("drawing with {} from now on", self.renderer.describe());
        }
    }
}
