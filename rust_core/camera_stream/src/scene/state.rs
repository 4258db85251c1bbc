//! The state of a loaded config: its displays, the frames, and the CameraInfos of its cameras.
//!
//! Live topics and bags feed it in the same way, and the view of its cameras is a function of the messages and the
//! time.
//!
//! ```
//! use rcs_camera::Projection;
//! use rcs_camera_stream::scene::SceneState;
//! use rcs_resources::{MeshStore, PackageIndex};
//! use rcs_transforms::Time;
//!
//! let config = "
//! Visualization Manager:
//!   Global Options: {Fixed Frame: map}
//!   Displays:
//!   - {Class: rviz/Grid, Name: floor, Enabled: true}
//!   - {Class: rviz_camera_stream/CameraPub, Name: projector, Enabled: true, Image Topic: /image,
//!      Camera Info Topic: /camera_info}
//! ";
//! let config = rcs_rviz_config::parse(config, "scene.rviz")?;
//! let mut state = SceneState::new(&config, None, MeshStore::new(PackageIndex::new([])));
//! assert_eq!(state.topics()[0].topic, "/camera_info");
//! // Messages go in with `take` and `take_transforms`; then the scene is brought up to date.
//! assert!(state.update(Time::ZERO), "the grid is new in the scene");
//! assert!(!state.scene().drawables.is_empty());
//! let without_camera_info = state.camera(&state.cameras()[0], Projection::Rviz).unwrap_err();
//! assert_eq!(without_camera_info.to_string(), "No CameraInfo received on [/camera_info]. Topic may not exist.");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use std::collections::HashMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use nalgebra::Point3;
use rcs_camera::{is_distorted, CameraModel, Lenses, NoLens};
use rcs_displays::{
    raw_transforms, time_from_stamp, CameraView, DisplaySet, Reconfigured, ShownMessage, TopicRequest, World,
};
use rcs_files::projector::fields_of;
use rcs_messages::sensor_msgs::CameraInfo;
use rcs_messages::tf2_msgs::TFMessage;
use rcs_messages::{AnyMessage, MessageKind};
use rcs_render::View;
use rcs_resources::MeshStore;
use rcs_rviz_config::Config;
use rcs_scene::{DisplayId, Scene};
use rcs_transforms::{InsertProblem, Prediction, Time, TransformTree};

use crate::scene::camera_pose::{self, CameraProblem};

/// Number of frames and reasons for which refused transforms are logged.
const MOST_WARNINGS: usize = 1000;

/// The frame in which the scene is built.
fn fixed_frame_of(config: &Config, given: Option<&str>) -> String {
    given.unwrap_or(&config.global.fixed_frame).trim_start_matches('/').to_owned()
}

/// The transforms and meshes that displays use, and the settings of updates.
#[derive(Debug)]
struct DisplayContext {
    transforms: TransformTree,
    fixed_frame: String,
    /// Extrapolation of moving frames; `None` if there is none.
    prediction: Option<Prediction>,
    /// Most markers that a display places in one update.
    step: Option<usize>,
    /// `true` if the renderer decodes points by itself.
    packs_points: bool,
    meshes: MeshStore,
}

impl DisplayContext {
    fn world(&self, now: Time) -> World<'_> {
        let mut world = World::new(&self.transforms, &self.fixed_frame, now, &self.meshes);
        (world.prediction, world.step) = (self.prediction, self.step);
        world.packs_points = self.packs_points;
        world
    }
}

/// A config's displays and cameras with the state that the messages so far gave them.
#[derive(Debug)]
pub struct SceneState {
    displays: DisplaySet,
    context: DisplayContext,
    /// Version of the meshes at the last update.
    meshes_version: u64,
    /// By topic, with the time of arrival, if that was given.
    camera_infos: HashMap<String, (Arc<CameraInfo>, Option<Instant>)>,
    lenses: Lenses,
    warned: std::collections::HashSet<String>,
}

impl SceneState {
    /// No messages yet; `fixed_frame` overrides the config's.
    pub fn new(config: &Config, fixed_frame: Option<&str>, meshes: MeshStore) -> Self {
        Self {
            displays: DisplaySet::new(config),
            context: DisplayContext {
                transforms: TransformTree::new(),
                fixed_frame: fixed_frame_of(config, fixed_frame),
                prediction: None,
                step: None,
                packs_points: false,
                meshes,
            },
            meshes_version: 0,
            camera_infos: HashMap::new(),
            lenses: Lenses::default(),
            warned: std::collections::HashSet::new(),
        }
    }

    /// Limits the markers that a display places in one update, see [`World::step`]: another update follows at once.
    pub fn limit_markers_per_update(&mut self, most: usize) {
        self.context.step = Some(most);
    }

    /// Leaves the points of the next messages to the renderer, see [`Renderer::takes_packed_points`].
    ///
    /// [`Renderer::takes_packed_points`]: rcs_render::Renderer::takes_packed_points
    pub fn pack_points(&mut self, packs_points: bool) {
        self.context.packs_points = packs_points;
    }

    /// Replaces the config; `fixed_frame` overrides its own. Displays in both are kept, and placed again if the fixed
    /// frame changed.
    pub fn reconfigure(&mut self, config: &Config, fixed_frame: Option<&str>, now: Time) -> Reconfigured {
        let fixed_frame = fixed_frame_of(config, fixed_frame);
        let is_moved = fixed_frame != self.context.fixed_frame;
        self.context.fixed_frame = fixed_frame;
        let world = self.context.world(now);
        let changed = self.displays.reconfigure(config, &world);
        if is_moved {
            self.displays.change_fixed_frame(&world);
        }
        let topics = self.topics();
        let is_read = |topic: &str| topics.iter().any(|request| request.topic == topic);
        self.camera_infos.retain(|topic, _| is_read(topic));
        self.lenses.keep(is_read);
        changed
    }

    /// The cameras, in the config's order.
    pub fn cameras(&self) -> &[CameraView] {
        self.displays.cameras()
    }

    /// The displays.
    pub fn displays(&self) -> &DisplaySet {
        &self.displays
    }

    /// The topics of displays and cameras, by their names in the config, without those of transforms.
    pub fn topics(&self) -> Vec<TopicRequest> {
        let mut topics = self.displays.topics();
        for camera in self.cameras() {
            let topic = &camera.settings.camera_info_topic;
            let known = |request: &TopicRequest| &request.topic == topic && request.kind == MessageKind::CameraInfo;
            if !topic.is_empty() && !topics.iter().any(known) {
                topics.push(TopicRequest { topic: topic.clone(), kind: MessageKind::CameraInfo, queue_size: 1 });
            }
        }
        topics
    }

    /// Takes transforms of a publisher. Refused ones are logged once for each child frame and reason, those of too many
    /// frames once.
    pub fn take_transforms(&mut self, message: &TFMessage, is_static: bool, publisher: &str) {
        for transform in raw_transforms(message) {
            if let Err(error) = self.context.transforms.insert(&transform, is_static, publisher) {
                let key = match &error.problem {
                    InsertProblem::TooManyFrames => String::new(),
                    problem => format!("{publisher} {} {:?}", transform.child, std::mem::discriminant(problem)),
                };
                if self.warned.len() < MOST_WARNINGS && self.warned.insert(key) {
                    log::warn!("{error}");
                }
            }
        }
    }

    /// Takes a message of a topic, by its name in the config.
    pub fn take(&mut self, topic: &str, message: &AnyMessage, now: Time) {
        self.take_received(topic, message, None, now);
    }

    /// Like [`take`](Self::take), with the time of arrival, which [`DisplaySet::newly_shown`] passes on.
    pub fn take_received(&mut self, topic: &str, message: &AnyMessage, received: Option<Instant>, now: Time) {
        if let AnyMessage::CameraInfo(info) = message {
            self.camera_infos.insert(topic.to_owned(), (info.clone(), received));
        }
        let world = self.context.world(now);
        self.displays.take_received(topic, message, received, &world);
    }

    /// `true` if each message of a topic, by its name in the config, replaces all that earlier ones made.
    pub(crate) fn is_replaced_by_newest(&self, topic: &str, kind: MessageKind) -> bool {
        self.displays.is_replaced_by_newest(topic, kind)
    }

    /// The names of the ROS parameters that the displays read, as the config has them.
    pub fn parameters(&self) -> Vec<String> {
        self.displays.parameters()
    }

    /// Takes the text of a parameter, by its name in the config; `None` while it is not set.
    pub fn take_parameter(&mut self, name: &str, text: Option<&Arc<str>>, now: Time) {
        let world = self.context.world(now);
        self.displays.take_parameter(name, text, &world);
    }

    /// Handles that a publisher of a topic left, by the topic's name in the config.
    pub fn publisher_left(&mut self, topic: &str) {
        self.displays.publisher_left(topic);
    }

    /// `true` if meshes or textures were loaded since the last update.
    pub fn has_new_resources(&self) -> bool {
        self.context.meshes.version() != self.meshes_version
    }

    /// Loads meshes and textures again that could not be used.
    pub fn retry_resources(&self) {
        self.context.meshes.retry_failures();
    }

    /// Sets the extrapolation of moving frames, cameras included; `None`: frames are at their latest transforms.
    pub fn predict(&mut self, prediction: Option<Prediction>) {
        self.context.prediction = prediction;
    }

    /// The extrapolation of moving frames, if there is any.
    pub fn prediction(&self) -> Option<&Prediction> {
        self.context.prediction.as_ref()
    }

    /// Brings the displays up to date. Returns `true` if the scene changed.
    pub fn update(&mut self, now: Time) -> bool {
        // First: meshes that are loaded from now on count as new.
        self.meshes_version = self.context.meshes.version();
        let world = self.context.world(now);
        self.displays.update(&world)
    }

    /// The time that each display's messages and updates took since the last call.
    pub fn take_costs(&mut self) -> impl Iterator<Item = (DisplayId, Duration)> + '_ {
        self.displays.take_costs()
    }

    /// The transforms, and the frame in which the scene is built.
    pub(crate) fn frames(&self) -> (&TransformTree, &str) {
        (&self.context.transforms, &self.context.fixed_frame)
    }

    /// The scene as of the last update.
    pub fn scene(&self) -> Scene {
        self.displays.scene()
    }

    /// The last CameraInfo of a camera.
    pub fn camera_info(&self, camera: &CameraView) -> Option<&Arc<CameraInfo>> {
        self.camera_infos.get(&camera.settings.camera_info_topic).map(|(info, _)| info)
    }

    /// The projection and pose of a camera, from its last CameraInfo and the latest or [predicted](Self::predict)
    /// transforms.
    ///
    /// # Errors
    /// See [`CameraProblem`]: no image can be drawn then.
    pub fn camera(
        &self,
        camera: &CameraView,
        model: impl Into<CameraModel>,
    ) -> Result<rcs_scene::Camera, CameraProblem> {
        let topic = &camera.settings.camera_info_topic;
        let info = self.camera_info(camera).ok_or_else(|| CameraProblem::NoCameraInfo { topic: topic.clone() })?;
        let near_m = f64::from(camera.settings.near_clip_m);
        camera_pose::camera(info, topic, &self.context.world(Time::ZERO), near_m, model.into(), &self.lenses)
    }

    /// Why the lens of a camera's last CameraInfo could not be applied, if that was tried.
    pub(crate) fn no_lens(&self, camera: &CameraView) -> Option<NoLens> {
        self.lenses.problem(&camera.settings.camera_info_topic)
    }

    /// Why the distortion of a camera's CameraInfo is unknown, if it has one that `drawn` lacks.
    pub(crate) fn unknown_lens(&self, camera: &CameraView, drawn: &rcs_scene::Camera) -> Option<NoLens> {
        let is_straight = drawn.lens().is_none();
        let info = self.camera_info(camera).filter(|info| is_straight && is_distorted(&fields_of(info)));
        info.and_then(|_| self.no_lens(camera))
    }

    /// Drops frames and messages: the time jumped back. CameraInfos are kept, as latched topics are not sent again.
    pub fn reset(&mut self) {
        self.context.transforms.clear();
        self.displays.reset();
    }

    /// The CameraInfo topics of its cameras, by their names in the config.
    pub(crate) fn camera_info_topics(&self) -> impl Iterator<Item = &str> {
        self.cameras().iter().map(|view| view.settings.camera_info_topic.as_str())
    }

    /// The frame of the last CameraInfo of a topic, with its stamp and arrival.
    pub(crate) fn received_camera_info(&self, topic: &str) -> Option<(&str, ShownMessage)> {
        let (info, received) = self.camera_infos.get(topic)?;
        let shown = ShownMessage { stamp: time_from_stamp(info.header.stamp), received: *received };
        Some((&info.header.frame_id, shown))
    }

    /// Newest time at which a frame's place in the fixed frame is known; zero if nothing between them moves. `None` for
    /// the fixed frame itself, and for a frame whose place is unknown.
    pub(crate) fn known_until(&self, frame: &str) -> Option<Time> {
        let is_fixed = frame.trim_start_matches('/') == self.context.fixed_frame;
        let found =
            (!is_fixed).then(|| self.context.transforms.lookup_stamped(&self.context.fixed_frame, frame, Time::ZERO));
        found?.ok().map(|(_, stamp)| stamp)
    }

    /// The origin of a frame in the fixed frame now; `None` if it is unknown.
    pub(crate) fn place_of(&self, frame: &str) -> Option<Point3<f64>> {
        let place = self.context.world(Time::ZERO).fixed_from(frame, Time::ZERO).ok()?;
        Some(Point3::from(place.translation.vector))
    }
}

/// The renderer's input for a camera's image.
pub fn renderer_view<'a>(view: &'a CameraView, scene: &'a Scene, camera: &'a rcs_scene::Camera) -> View<'a> {
    View {
        scene,
        camera,
        visible: &view.visible,
        background: view.settings.background_color,
        encoding: view.settings.image_encoding,
    }
}
