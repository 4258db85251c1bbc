//! `camera_stream` as a ROS node.
//!
//! One thread owns the stage: it takes what the network received, brings the scene up to date, draws what somebody
//! looks at and hands it to the publishers. Nothing is drawn that nobody subscribes to, and a scene that did not change
//! is not drawn again: its last picture goes out with a new stamp.

mod camera;
mod pace;

use std::collections::HashMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use anyhow::{Context, Result};
use rcs_input::live::{NodeEvent, NodeOptions, RosNode, TopicSubscription};
use rcs_messages::{stamp_nanos, AnyMessage, MessageKind};
use rcs_render::{Renderer, RendererChoice};
use rcs_resources::{MeshStore, PackageIndex};
use rcs_rviz_config::Config;
use rcs_scene::Scene;
use rcs_transforms::Time;

use crate::camera_pose::Projection;
use crate::cli::Cli;
use crate::ending::EndRequest;
use crate::stage::Stage;
use camera::CameraOutput;

/// How long the node sleeps at most when nothing happens.
const LONGEST_SLEEP: Duration = Duration::from_millis(100);

/// Runs the node until it is asked to end.
///
/// # Errors
/// One line that names what is in the way: the master's address, a topic, the renderer.
pub fn run(cli: &Cli, ros_args: &[String], config: &Config) -> Result<()> {
    for finding in &config.findings {
        log::warn!("{}: {finding}", config.source);
    }
    let end = EndRequest::watch_signals().context("signals cannot be taken")?;
    let options = NodeOptions::new("camera_stream", ros_args);
    let Some(ros) = RosNode::connect(options, &|| end.is_requested())? else { return Ok(()) };
    let result = Node::start(cli, config, &ros).and_then(|mut node| node.play(&end));
    ros.shutdown();
    result
}

/// A private parameter, where the command line says nothing.
fn choice<T: std::str::FromStr>(ros: &RosNode, given: Option<T>, parameter: &str) -> Result<Option<T>>
where
    T::Err: std::fmt::Display,
{
    if given.is_some() {
        return Ok(given);
    }
    match ros.string_param(parameter)? {
        Some(text) => {
            let value = text.parse().map_err(|error| anyhow::anyhow!("parameter {parameter}: {error}"))?;
            Ok(Some(value))
        }
        None => Ok(None),
    }
}

struct Node<'a> {
    ros: &'a RosNode,
    stage: Stage,
    renderer: Box<dyn Renderer>,
    projection: Projection,
    cameras: Vec<CameraOutput>,
    /// The config's names of each subscribed topic, by its full name and kind.
    names: HashMap<(Arc<str>, MessageKind), Vec<String>>,
    /// Kept for as long as the node listens.
    _subscriptions: Vec<TopicSubscription>,
    /// Grows with every change of the scene.
    scene_version: u64,
    scene: Option<(u64, Scene)>,
}

impl<'a> Node<'a> {
    fn start(cli: &Cli, config: &Config, ros: &'a RosNode) -> Result<Self> {
        let renderer_choice = choice::<RendererChoice>(ros, cli.renderer, "~renderer")?.unwrap_or_default();
        let projection = choice::<Projection>(ros, cli.projection, "~projection")?.unwrap_or_default();
        let renderer = rcs_render::create(renderer_choice)?;
        let meshes = MeshStore::new(PackageIndex::from_env(&[]));
        let stage = Stage::new(config, cli.node.fixed_frame.as_deref(), meshes);
        if stage.cameras().is_empty() {
            log::warn!("{}: no enabled CameraPub display, so there is nothing to publish", config.source);
        }
        let cameras = camera::outputs(ros, stage.cameras(), config.global.frame_rate_hz)?;
        ros.subscribe_transforms()?;
        let mut names: HashMap<(Arc<str>, MessageKind), Vec<String>> = HashMap::new();
        let mut subscriptions = Vec::new();
        for request in stage.topics() {
            match ros.subscribe(&request.topic, request.kind, request.queue_size) {
                Ok(subscription) => {
                    let full_name = Arc::from(subscription.topic());
                    names.entry((full_name, request.kind)).or_default().push(request.topic);
                    subscriptions.push(subscription);
                }
                Err(error) => log::error!("{error}"),
            }
        }
        log::info!("drawing {} of {} with {}", camera::names(&cameras), config.source, renderer.describe());
        Ok(Self {
            ros,
            stage,
            renderer,
            projection,
            cameras,
            names,
            _subscriptions: subscriptions,
            scene_version: 0,
            scene: None,
        })
    }

    fn now(&self) -> Time {
        Time::from_nanos(stamp_nanos(self.ros.now()))
    }

    fn play(&mut self, end: &EndRequest) -> Result<()> {
        while !end.is_requested() && self.ros.shutdown_request().is_none() {
            let events = self.ros.events().wait(self.sleep());
            let heard = !events.is_empty();
            for event in events {
                self.take(event);
            }
            let now = self.now();
            if heard || self.stage.displays().next_change().is_some_and(|change| change <= now) {
                self.scene_version += u64::from(self.stage.update(now));
            }
            self.publish(now)?;
        }
        Ok(())
    }

    /// Until something is due by itself: a camera's next picture, or a change of the scene.
    fn sleep(&self) -> Duration {
        let now = Instant::now();
        let cameras = self.cameras.iter().filter_map(|camera| camera.due(now)).min();
        let change = self.stage.displays().next_change().map(|change| change.saturating_since(self.now()));
        cameras.into_iter().chain(change).min().unwrap_or(LONGEST_SLEEP).min(LONGEST_SLEEP)
    }

    fn take(&mut self, event: NodeEvent) {
        match event {
            NodeEvent::Message { topic, message, publisher } => {
                // Cameras publish their CameraInfo beside their image, which may be the very topic they listen to.
                if matches!(message, AnyMessage::CameraInfo(_)) && *publisher == *self.ros.name() {
                    return;
                }
                let now = self.now();
                for name in self.names.get(&(topic, message.kind())).into_iter().flatten() {
                    self.stage.take(name, &message, now);
                }
            }
            NodeEvent::Transforms { message, is_static, authority } => {
                self.stage.take_transforms(&message, is_static, &authority);
            }
            NodeEvent::TimeJumpedBack { from, to } => {
                log::warn!(
                    "the time jumped back from {} to {}: frames and messages are forgotten",
                    Time::from_nanos(stamp_nanos(from)),
                    Time::from_nanos(stamp_nanos(to))
                );
                self.stage.reset();
                self.scene_version += 1;
            }
            NodeEvent::Trigger { service, reply } => match self.cameras.iter_mut().find(|c| c.serves(&service)) {
                Some(camera) => camera.trigger(reply),
                None => reply.send(false, "Image publisher not configured"),
            },
            NodeEvent::SubscriberConnected { .. } => {}
        }
    }

    /// Draws and publishes what is due.
    fn publish(&mut self, now: Time) -> Result<()> {
        for camera in &mut self.cameras {
            if !camera.is_due(self.scene_version, self.stage.transforms_generation()) {
                continue;
            }
            let scene = match &self.scene {
                Some((version, scene)) if *version == self.scene_version => scene,
                _ => &self.scene.insert((self.scene_version, self.stage.scene(now))).1,
            };
            camera.publish(&self.stage, scene, self.scene_version, self.projection, self.renderer.as_mut(), self.ros)?;
        }
        Ok(())
    }
}
