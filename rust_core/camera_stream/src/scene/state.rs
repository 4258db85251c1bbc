//! A config at work: its displays, the frames, and the CameraInfos of its cameras.
//!
//! Live topics and bags feed the same stage, and what its cameras see is a function of the messages and the time.
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
//! let mut stage = SceneState::new(&config, None, MeshStore::new(PackageIndex::new([])));
//! assert_eq!(stage.topics()[0].topic, "/camera_info");
//! // Messages go in with `take` and `take_transforms`; then the scene is brought up to date.
//! assert!(stage.update(Time::ZERO), "the grid is new in the scene");
//! assert!(!stage.scene().drawables.is_empty());
//! let without_camera_info = stage.camera(&stage.cameras()[0], Projection::Rviz).unwrap_err();
//! assert_eq!(without_camera_info.to_string(), "No CameraInfo received on [/camera_info]. Topic may not exist.");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use std::collections::HashMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use nalgebra::Point3;
use rcs_camera::{is_distorted, CameraModel, Lenses, NoLens};
use rcs_displays::{
    raw_transforms, time_from_stamp, CameraView, DisplayAge, DisplaySet, Reconfigured, ShownMessage, TopicRequest,
    World,
};
use rcs_files::projector::fields_of;
use rcs_messages::sensor_msgs::CameraInfo;
use rcs_messages::tf2_msgs::TFMessage;
use rcs_messages::{AnyMessage, MessageKind};
use rcs_render::View;
use rcs_resources::MeshStore;
use rcs_rviz_config::Config;
use rcs_scene::{DisplayId, Scene};
use rcs_transforms::{Prediction, Time, TransformTree, FRAMES_ALWAYS_KEPT};

use crate::safety::ages::SceneAges;
use crate::scene::camera_pose::{self, CameraProblem};
use crate::scene::status_tree::{self, StatusEntry};

/// Frames and reasons for which refused transforms are logged.
const MOST_WARNINGS: usize = 1000;

/// The frame in which the scene is built.
fn fixed_frame_of(config: &Config, given: Option<&str>) -> String {
    given.unwrap_or(&config.global.fixed_frame).trim_start_matches('/').to_owned()
}

/// What displays draw their messages with.
#[derive(Debug)]
struct Surroundings {
    transforms: TransformTree,
    fixed_frame: String,
    /// The time that moving frames are led on to, if they are.
    prediction: Option<Prediction>,
    /// How many markers a display places in one update.
    step: Option<usize>,
    meshes: MeshStore,
}

impl Surroundings {
    fn world(&self, now: Time) -> World<'_> {
        let mut world = World::new(&self.transforms, &self.fixed_frame, now, &self.meshes);
        (world.prediction, world.step) = (self.prediction, self.step);
        world
    }
}

/// A config's displays and cameras with the state that the messages so far gave them.
#[derive(Debug)]
pub struct SceneState {
    displays: DisplaySet,
    around: Surroundings,
    /// That of the meshes at the last update.
    meshes_version: u64,
    /// By topic, with the moment when they were received, if that was given.
    camera_infos: HashMap<String, (Arc<CameraInfo>, Option<Instant>)>,
    lenses: Lenses,
    warned: std::collections::HashSet<String>,
    /// It was logged that there are too many frames.
    has_warned_of_frames: bool,
}

impl SceneState {
    /// An empty stage; `fixed_frame` overrides the config's.
    pub fn new(config: &Config, fixed_frame: Option<&str>, meshes: MeshStore) -> Self {
        Self {
            displays: DisplaySet::new(config),
            around: Surroundings {
                transforms: TransformTree::new(),
                fixed_frame: fixed_frame_of(config, fixed_frame),
                prediction: None,
                step: None,
                meshes,
            },
            meshes_version: 0,
            camera_infos: HashMap::new(),
            lenses: Lenses::default(),
            warned: std::collections::HashSet::new(),
            has_warned_of_frames: false,
        }
    }

    /// Has displays place so many markers in one update at most, as in [`World::step`]: another update follows at once.
    pub fn limit_markers_per_update(&mut self, step: usize) {
        self.around.step = Some(step);
    }

    /// Replaces the config; `fixed_frame` overrides its own. Displays that both have are kept, and placed again if the
    /// fixed frame changed.
    pub fn reconfigure(&mut self, config: &Config, fixed_frame: Option<&str>, now: Time) -> Reconfigured {
        let fixed_frame = fixed_frame_of(config, fixed_frame);
        let is_moved = fixed_frame != self.around.fixed_frame;
        self.around.fixed_frame = fixed_frame;
        let world = self.around.world(now);
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

    /// The topics of displays and cameras, by their names in the config; those of transforms are not among them.
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

    /// Takes transforms of a publisher. One that is refused is logged once for each child frame and reason.
    pub fn take_transforms(&mut self, message: &TFMessage, is_static: bool, publisher: &str) {
        for transform in raw_transforms(message) {
            if let Err(error) = self.around.transforms.insert(&transform, is_static, publisher) {
                let key = format!("{publisher} {} {:?}", transform.child, std::mem::discriminant(&error.problem));
                if self.warned.len() < MOST_WARNINGS && self.warned.insert(key) {
                    log::warn!("{error}");
                }
            }
        }
        if self.around.transforms.forgotten_frames() > 0 && !self.has_warned_of_frames {
            self.has_warned_of_frames = true;
            log::warn!(
                "more than {FRAMES_ALWAYS_KEPT} frames: those without new transforms for longest are forgotten; the last were \
                 sent by {publisher}"
            );
        }
    }

    /// Takes a message of a topic, by its name in the config.
    pub fn take(&mut self, topic: &str, message: &AnyMessage, now: Time) {
        self.take_received(topic, message, None, now);
    }

    /// As [`take`](Self::take), with the moment when the message was received, which
    /// [`DisplaySet::newly_shown`] passes on.
    pub fn take_received(&mut self, topic: &str, message: &AnyMessage, received: Option<Instant>, now: Time) {
        if let AnyMessage::CameraInfo(info) = message {
            self.camera_infos.insert(topic.to_owned(), (info.clone(), received));
        }
        let world = self.around.world(now);
        self.displays.take_received(topic, message, received, &world);
    }

    /// Whether each message of a topic, by its name in the config, replaces all that earlier ones made.
    pub(crate) fn is_replaced_by_newest(&self, topic: &str, kind: MessageKind) -> bool {
        self.displays.is_replaced_by_newest(topic, kind)
    }

    /// Shows nothing of such a topic until its next message.
    pub(crate) fn forget_topic(&mut self, topic: &str, kind: MessageKind) {
        self.displays.forget_topic(topic, kind);
    }

    /// The names of the ROS parameters that the displays read, as the config has them.
    pub fn parameters(&self) -> Vec<String> {
        self.displays.parameters()
    }

    /// Takes the text of a parameter, by its name in the config; `None` while it is not set.
    pub fn take_parameter(&mut self, name: &str, text: Option<&Arc<str>>, now: Time) {
        let world = self.around.world(now);
        self.displays.take_parameter(name, text, &world);
    }

    /// Handles that a publisher of a topic left, by the topic's name in the config.
    pub fn publisher_left(&mut self, topic: &str) {
        self.displays.publisher_left(topic);
    }

    /// Whether meshes or textures were loaded since the last update, which the displays then show.
    pub fn has_new_resources(&self) -> bool {
        self.around.meshes.version() != self.meshes_version
    }

    /// Looks at meshes and textures again that could not be used.
    pub fn retry_resources(&self) {
        self.around.meshes.retry_failures();
    }

    /// Shows moving frames, cameras included, where they will be at a time from now on; `None`: at their latest
    /// transforms.
    pub fn predict(&mut self, prediction: Option<Prediction>) {
        self.around.prediction = prediction;
    }

    /// What moving frames are predicted for, if they are.
    pub fn prediction(&self) -> Option<&Prediction> {
        self.around.prediction.as_ref()
    }

    /// Brings the displays up to date. Returns whether the scene changed.
    pub fn update(&mut self, now: Time) -> bool {
        // First: what is loaded from now on is seen by the next update.
        self.meshes_version = self.around.meshes.version();
        let world = self.around.world(now);
        self.displays.update(&world)
    }

    /// What each display's messages and updates took since this was last called.
    pub fn take_costs(&mut self) -> impl Iterator<Item = (DisplayId, Duration)> + '_ {
        self.displays.take_costs()
    }

    /// The global status and those of each display at a ROS time.
    pub(crate) fn status_entries(&self, now: Time) -> Vec<StatusEntry<'_>> {
        status_tree::scene(&self.displays, &self.around.transforms, &self.around.fixed_frame, now)
    }

    /// The scene as of the last update.
    pub fn scene(&self) -> Scene {
        self.displays.scene()
    }

    /// The last CameraInfo of a camera.
    pub fn camera_info(&self, camera: &CameraView) -> Option<&Arc<CameraInfo>> {
        self.camera_infos.get(&camera.settings.camera_info_topic).map(|(info, _)| info)
    }

    /// Where a camera is and what it sees of the scene, from its last CameraInfo and the latest transforms, or
    /// what these [predict](Self::predict).
    ///
    /// # Errors
    /// See [`CameraProblem`]: no picture can be drawn then.
    pub fn camera(
        &self,
        camera: &CameraView,
        model: impl Into<CameraModel>,
    ) -> Result<rcs_scene::Camera, CameraProblem> {
        let topic = &camera.settings.camera_info_topic;
        let info = self.camera_info(camera).ok_or_else(|| CameraProblem::NoCameraInfo { topic: topic.clone() })?;
        let near_m = f64::from(camera.settings.near_clip_m);
        camera_pose::camera(info, topic, &self.around.world(Time::ZERO), near_m, model.into(), &self.lenses)
    }

    /// Why the lens of a camera's last CameraInfo was not allowed for, if that was tried.
    pub(crate) fn no_lens(&self, camera: &CameraView) -> Option<NoLens> {
        self.lenses.problem(&camera.settings.camera_info_topic)
    }

    /// Why it is not known where the distortion of a camera's CameraInfo sends light, if it has any that was not
    /// allowed for in what is drawn.
    pub(crate) fn unknown_lens(&self, camera: &CameraView, drawn: &rcs_scene::Camera) -> Option<NoLens> {
        let is_straight = drawn.lens().is_none();
        let info = self.camera_info(camera).filter(|info| is_straight && is_distorted(&fields_of(info)));
        info.and_then(|_| self.no_lens(camera))
    }

    /// Drops frames and messages: the time jumped back. CameraInfos are kept, as latched topics are not sent again.
    pub fn reset(&mut self) {
        self.around.transforms.clear();
        self.displays.reset();
    }
}

impl SceneAges for SceneState {
    fn ages(&self) -> Vec<DisplayAge<'_>> {
        self.displays.ages().collect()
    }

    fn camera_info_topics(&self) -> Vec<&str> {
        self.cameras().iter().map(|view| view.settings.camera_info_topic.as_str()).collect()
    }

    fn received_camera_info(&self, topic: &str) -> Option<(&str, ShownMessage)> {
        let (info, received) = self.camera_infos.get(topic)?;
        let shown = ShownMessage { stamp: time_from_stamp(info.header.stamp), received: *received };
        Some((&info.header.frame_id, shown))
    }

    fn known_until(&self, frame: &str) -> Option<Time> {
        let is_fixed = frame.trim_start_matches('/') == self.around.fixed_frame;
        let found =
            (!is_fixed).then(|| self.around.transforms.lookup_stamped(&self.around.fixed_frame, frame, Time::ZERO));
        found?.ok().map(|(_, stamp)| stamp)
    }

    fn place_of(&self, frame: &str) -> Option<Point3<f64>> {
        let place = self.around.world(Time::ZERO).fixed_from(frame, Time::ZERO).ok()?;
        Some(Point3::from(place.translation.vector))
    }
}

/// What a renderer needs to draw a camera's picture.
pub fn renderer_view<'a>(view: &'a CameraView, scene: &'a Scene, camera: &'a rcs_scene::Camera) -> View<'a> {
    View {
        scene,
        camera,
        visible: &view.visible,
        background: view.settings.background_color,
        encoding: view.settings.image_encoding,
    }
}
