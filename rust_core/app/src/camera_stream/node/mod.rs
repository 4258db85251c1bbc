//! `camera_stream` as a ROS node.
//!
//! One thread owns the stage: it takes what the network received, brings the scene up to date, draws what somebody
//! looks at and hands it to the publishers. Nothing is drawn that nobody subscribes to, and a scene that did not change
//! is not drawn again: its last picture goes out with a new stamp.

mod camera;
mod diagnostics;
mod latency;
mod pace;
mod parameters;
mod reload;
mod subscriptions;
mod tuning;
mod watch;

use std::collections::VecDeque;
use std::path::PathBuf;
use std::str::FromStr;
use std::sync::Arc;
use std::time::{Duration, Instant};

use anyhow::{anyhow, Context, Result};
use clap::ValueEnum;
use rcs_messages::{stamp_nanos, MessageKind};
use rcs_render::{CpuRenderer, RenderError, Renderer, RendererChoice};
use rcs_resources::{MeshStore, PackageIndex};
use rcs_ros::{NodeEvent, RosNode};
use rcs_rviz_config::Config;
use rcs_scene::Scene;
use rcs_transforms::Time;

use crate::camera_stream::camera_pose::Projection;
use crate::camera_stream::cli::Cli;
use crate::camera_stream::stage::Stage;
use crate::logging::one_line;
use crate::small_node::{self, EndRequest};
use camera::CameraOutput;
use diagnostics::Diagnostics;
use latency::Update;
use subscriptions::Subscriptions;
use watch::FileWatch;

/// How long the node sleeps at most when nothing happens.
const LONGEST_SLEEP: Duration = Duration::from_millis(100);

/// Runs the node until it is asked to end.
///
/// # Errors
/// One line that names what is in the way: the master's address, a topic, the renderer.
pub fn run(cli: &Cli, config: &Config) -> Result<()> {
    for finding in &config.findings {
        log::warn!("{}: {finding}", config.source);
    }
    let end = EndRequest::watch_signals().context("signals cannot be taken")?;
    let Some(ros) = small_node::connect("camera_stream", &end)? else { return Ok(()) };
    let result = Node::start(cli, config, &ros).map(|mut node| node.play(&end));
    ros.shutdown();
    result
}

/// A private parameter, where the command line says nothing.
fn choice<T>(ros: &RosNode, given: Option<T>, name: &str, parse: impl Fn(&str) -> Result<T, String>) -> Result<T>
where
    T: Default,
{
    match (given, ros.string_param(name)) {
        (Some(given), _) => Ok(given),
        (None, Some(text)) => parse(&text).map_err(|error| anyhow!("parameter {name}: {error}")),
        (None, None) => Ok(T::default()),
    }
}

/// Watches the config, unless that is not wanted.
fn watch(cli: &Cli, ros: &RosNode) -> Result<Option<FileWatch>> {
    let is_wanted = !cli.node.no_watch && ros.bool_param("~watch").unwrap_or(true);
    let Some(file) = cli.node.display_config.clone().filter(|_| is_wanted) else { return Ok(None) };
    let events = ros.events().clone();
    FileWatch::start(file, move || events.wake()).map(Some).context("the config cannot be watched")
}

struct Node<'a> {
    ros: &'a RosNode,
    stage: Stage,
    renderer: Box<dyn Renderer>,
    projection: Projection,
    cameras: Vec<CameraOutput>,
    subscriptions: Subscriptions,
    /// As it was read last.
    config: Config,
    file: PathBuf,
    /// The command line's, before the config's.
    fixed_frame: Option<String>,
    /// The whole name of the service that reads the config again.
    reload_service: Arc<str>,
    watch: Option<FileWatch>,
    /// Grows with every change of the scene.
    scene_version: u64,
    scene: Option<(u64, Arc<Scene>)>,
    renderer_choice: RendererChoice,
    diagnostics: Diagnostics,
    /// When the last transforms were received that the displays have not seen.
    moved: Option<Instant>,
}

impl<'a> Node<'a> {
    fn start(cli: &Cli, config: &Config, ros: &'a RosNode) -> Result<Self> {
        let renderer_choice = choice(ros, cli.renderer, "~renderer", RendererChoice::from_str)?;
        let projection = choice(ros, cli.projection, "~projection", |text| Projection::from_str(text, true))?;
        let renderer = rcs_render::create(renderer_choice)?;
        let meshes = MeshStore::new(PackageIndex::from_env(&[]));
        let stage = Stage::new(config, cli.node.fixed_frame.as_deref(), meshes);
        if stage.cameras().is_empty() {
            log::warn!("{}: no enabled CameraPub display, so there is nothing to publish", config.source);
        }
        let plans = camera::plans(ros, config)?;
        let cameras = camera::rearrange(ros, plans, Vec::new(), config, stage.displays());
        ros.subscribe_transforms()?;
        let mut subscriptions = Subscriptions::default();
        subscriptions.follow(ros, stage.topics());
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
            diagnostics: Diagnostics::start(),
            moved: None,
        })
    }

    fn now(&self) -> Time {
        Time::from_nanos(stamp_nanos(self.ros.now()))
    }

    fn play(&mut self, end: &EndRequest) {
        self.stage.update(self.now());
        while !end.is_requested() && !self.ros.is_asked_to_end() {
            let events = self.ros.events().wait(self.sleep());
            let mut heard = !events.is_empty();
            for event in events {
                self.take(event);
            }
            if self.watch.as_ref().is_some_and(FileWatch::take_change) {
                self.follow_file();
                heard = true;
            }
            let now = self.now();
            if heard || self.stage.displays().next_change().is_some_and(|change| change <= now) {
                self.update(now);
            }
            self.publish();
            self.tell();
        }
    }

    /// Brings the scene up to date.
    fn update(&mut self, now: Time) {
        self.scene_version += u64::from(self.stage.update(now));
        let shown = self.stage.displays().newly_shown();
        let update = Update { shown, moved: self.moved.take(), decoded: Instant::now() };
        self.cameras.iter_mut().for_each(|camera| camera.follow(&update));
    }

    /// Until something is due by itself: a camera's next picture, or a change of the scene.
    fn sleep(&self) -> Duration {
        let now = Instant::now();
        let cameras = self.cameras.iter().filter_map(|camera| camera.until_due(now)).min();
        let change = self.stage.displays().next_change().map(|change| change.saturating_since(self.now()));
        let diagnostics = self.diagnostics.until_due(now);
        cameras.into_iter().chain(change).fold(diagnostics.min(LONGEST_SLEEP), Duration::min)
    }

    /// Says how displays and cameras do.
    fn tell(&mut self) {
        let (stage, projection, cameras, now) = (&self.stage, self.projection, &self.cameras, self.now());
        self.diagnostics.tell(self.ros, || {
            let mut subjects = stage.subjects(now);
            subjects.extend(cameras.iter().map(|camera| camera.subject(stage, projection)));
            subjects
        });
    }

    fn take(&mut self, event: NodeEvent) {
        match event {
            NodeEvent::Message { topic, message, received, .. } => {
                let now = self.now();
                // The scene is put together anew. Until then nobody holds its clouds, so that the next ones can have their
                // memory.
                self.scene = None;
                for name in self.subscriptions.names(&topic, message.kind()) {
                    self.stage.take_received(name, &message, Some(received), now);
                }
            }
            NodeEvent::Transforms { message, is_static, authority, received } => {
                self.moved = Some(received);
                self.stage.take_transforms(&message, is_static, &authority);
            }
            NodeEvent::TimeJumpedBack { from, to } => {
                log::warn!(
                    "the time jumped back from {} to {}: frames and messages are forgotten",
                    Time::from_nanos(stamp_nanos(from)),
                    Time::from_nanos(stamp_nanos(to))
                );
                self.stage.reset();
                self.cameras.iter_mut().for_each(CameraOutput::forget_news);
                self.scene_version += 1;
            }
            NodeEvent::Trigger { service, reply } if service == self.reload_service => match self.reload() {
                Ok(changed) => reply.send(true, changed.unwrap_or_else(|| "nothing changed".to_owned())),
                Err(error) => reply.send(false, one_line(&error)),
            },
            NodeEvent::Reconfigure { server, request, reply } => {
                // Without an answer, the caller gets an error.
                if let Some(camera) = self.cameras.iter_mut().find(|camera| camera.has_parameters(&server)) {
                    reply.answer(camera.reconfigure(&request, self.stage.displays(), self.ros));
                }
            }
            NodeEvent::Trigger { service, reply } => match self.cameras.iter_mut().find(|c| c.serves(&service)) {
                Some(camera) => camera.trigger(reply),
                None => reply.send(false, "Image publisher not configured"),
            },
            NodeEvent::Parameter { name, text } => {
                let now = self.now();
                self.stage.take_parameter(&name, text.as_ref(), now);
            }
            NodeEvent::PublisherLeft { topic } => {
                for name in MessageKind::ALL.iter().flat_map(|kind| self.subscriptions.names(&topic, *kind)) {
                    self.stage.publisher_left(name);
                }
            }
            NodeEvent::SubscriberConnected { .. } => {}
        }
    }

    /// Draws and publishes what is due: as many pictures are begun as the renderer works on at once, and each goes out
    /// as soon as it is finished.
    fn publish(&mut self) {
        let mut in_flight = VecDeque::new();
        for index in 0..self.cameras.len() {
            let (stage, version, cached) = (&self.stage, self.scene_version, &mut self.scene);
            let scene = || {
                let (_, scene) = match cached.take() {
                    Some(current) if current.0 == version => cached.insert(current),
                    _ => cached.insert((version, Arc::new(stage.scene()))),
                };
                scene.clone()
            };
            let Some(camera) = self.cameras.get_mut(index) else { continue };
            let renderer = self.renderer.as_mut();
            match camera.begin_if_due(stage, version, scene, self.projection, renderer, self.ros) {
                Ok(true) => in_flight.push_back(index),
                done => self.note(index, done.map(|_| ())),
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
        let done = camera.finish(self.renderer.as_mut(), self.ros);
        self.note(index, done);
    }

    /// Takes how a camera's drawing and publishing went. What goes wrong is said once, and does not end the node; a GPU
    /// that `auto` chose and that fails gives way to the CPU.
    fn note(&mut self, index: usize, done: Result<()>) {
        let gpu_failed = matches!(&done, Err(error) if matches!(error.downcast_ref(), Some(RenderError::Gpu { .. })));
        if let Some(camera) = self.cameras.get_mut(index) {
            camera.note(done);
        }
        if gpu_failed {
            self.cameras.iter_mut().for_each(CameraOutput::lose_picture);
        }
        if gpu_failed && self.renderer_choice == RendererChoice::Auto {
            self.renderer = Box::new(CpuRenderer::new());
            log::warn!("drawing with {} from now on", self.renderer.describe());
        }
    }
}
