//! The state of a loaded config: its displays and cameras, the frames around them, and their scene.
//!
//! Live topics and bags feed it in the same way: what it shows is a function of the messages and the time. A message
//! goes to those that take its topic by one table, which changes with the config only.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;
use std::time::{Duration, Instant};

use nalgebra::{Isometry3, Point3, Vector3};
use rcs_camera::Lenses;
use rcs_messages::sensor_msgs::CameraInfo;
use rcs_messages::tf2_msgs::TFMessage;
use rcs_messages::{AnyMessage, MessageKind};
use rcs_resources::MeshStore;
use rcs_rviz_config::{
    CameraPubSettings, Config, DisplayConfig, DisplaySettings, PlacedDisplay, ViewConfig, Visibility,
};
use rcs_scene::{Camera, DirectionalLight, DisplayId, DisplayMask, Scene};
use rcs_transforms::{InsertProblem, LookupError, Prediction, Time, TransformTree};

use crate::classes::create;
use crate::framework::arrivals::ShownMessage;
use crate::framework::entry::DisplayEntry;
use crate::framework::in_view::InView;
use crate::framework::message_cache::MessageCache;
use crate::framework::report::{DisplayAge, DisplayReport, ListedDisplay};
use crate::framework::world::{raw_transforms, time_from_stamp};
use crate::{TopicRequest, World};

/// Number of frames and reasons for which refused transforms are logged.
const MOST_WARNINGS: usize = 1000;

/// A camera of a config: an enabled CameraPub display.
#[derive(Clone, Debug)]
pub struct CameraView {
    /// The display's name.
    pub name: String,
    /// The names of the groups around it and its own.
    pub path: Vec<String>,
    /// Its properties.
    pub settings: CameraPubSettings,
    /// Displays that it shows.
    pub visible: DisplayMask,
}

/// Changes of a config that was read again.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Reconfigured {
    /// Displays that stay, with their state.
    pub kept: usize,
    /// Displays that were added, including those with changed settings.
    pub added: usize,
    /// Displays that were removed, including those with changed settings.
    pub removed: usize,
}

/// A topic of the config, and the displays that take its messages. CameraInfos are for cameras as well.
struct Route {
    request: TopicRequest,
    displays: Vec<DisplayId>,
}

impl Route {
    fn is_of(&self, topic: &str, kind: MessageKind) -> bool {
        self.request.topic == topic && self.request.kind == kind
    }
}

/// The transforms and meshes that displays use, and the settings of updates.
struct Surroundings {
    transforms: TransformTree,
    fixed_frame: String,
    prediction: Option<Prediction>,
    step: Option<usize>,
    packs_points: bool,
    meshes: MeshStore,
    /// Version of the meshes at the last update.
    meshes_version: u64,
    /// Causes of refused transforms that were logged.
    warned: HashSet<String>,
    /// rviz's main view, where the default light is on.
    lit_by: Option<ViewConfig>,
}

impl Surroundings {
    fn world(&self, now: Time) -> World<'_> {
        let mut world = World::new(&self.transforms, &self.fixed_frame, now, &self.meshes);
        (world.prediction, world.step, world.packs_points) = (self.prediction, self.step, self.packs_points);
        world
    }
}

/// The enabled displays and cameras of a config, in its order, with the state that the messages so far gave them.
///
/// ```
/// use rcs_displays::SceneState;
/// use rcs_resources::{MeshStore, PackageIndex};
/// use rcs_transforms::Time;
///
/// let text = "Visualization Manager: {Displays: [{Class: rviz/Path, Name: path, Enabled: true, Topic: /path},
///   {Class: rviz/Grid, Name: floor, Enabled: true}]}";
/// let config = rcs_rviz_config::parse(text, "scene.rviz")?;
/// let mut state = SceneState::new(&config, Some("map"), MeshStore::new(PackageIndex::new([])));
/// assert_eq!(state.topics()[0].topic, "/path");
/// // Messages go in with `take` and `take_transforms`; then the scene is brought up to date.
/// assert!(state.update(Time::ZERO), "the grid is new in the scene");
/// assert_eq!(state.scene().drawables.len(), 1);
/// # Ok::<(), rcs_rviz_config::ConfigError>(())
/// ```
pub struct SceneState {
    entries: Vec<DisplayEntry>,
    cameras: Vec<CameraView>,
    /// By topic and type, each once, in the config's order.
    routes: Vec<Route>,
    around: Surroundings,
    /// By topic, with the time of arrival, if that was given.
    camera_infos: HashMap<String, (Arc<CameraInfo>, Option<Instant>)>,
    lenses: Lenses,
    light: Option<DirectionalLight>,
    message_cache: MessageCache,
    /// Displays that show another message since the last update.
    newly_shown: Vec<(DisplayId, ShownMessage)>,
    /// Version, incremented with every change of the scene.
    version: u64,
    /// Version of the last change for all cameras: of the light, or of the list of displays.
    changed_for_all_at: u64,
}

impl std::fmt::Debug for SceneState {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let listed: Vec<&ListedDisplay> = self.entries.iter().map(|entry| &entry.listed).collect();
        f.debug_struct("SceneState").field("displays", &listed).field("cameras", &self.cameras).finish_non_exhaustive()
    }
}

impl SceneState {
    /// Makes the enabled displays and cameras of a config, without messages; all groups around them must be enabled,
    /// too. `fixed_frame` overrides the config's.
    pub fn new(config: &Config, fixed_frame: Option<&str>, meshes: MeshStore) -> Self {
        let mut state = Self {
            entries: Vec::new(),
            cameras: Vec::new(),
            routes: Vec::new(),
            around: Surroundings {
                transforms: TransformTree::new(),
                fixed_frame: fixed_frame_of(config, fixed_frame),
                prediction: None,
                step: None,
                packs_points: false,
                meshes,
                meshes_version: 0,
                warned: HashSet::new(),
                lit_by: None,
            },
            camera_infos: HashMap::new(),
            lenses: Lenses::default(),
            light: None,
            message_cache: MessageCache::default(),
            newly_shown: Vec::new(),
            version: 0,
            changed_for_all_at: 0,
        };
        state.arrange(config);
        state
    }

    /// Replaces the config; `fixed_frame` overrides its own. A display of the same class, name, groups and settings
    /// stays as it is; another one, and one that panicked, is recreated and gets the last messages of its topics. All
    /// are placed again if the fixed frame changed.
    pub fn reconfigure(&mut self, config: &Config, fixed_frame: Option<&str>, now: Time) -> Reconfigured {
        let fixed_frame = fixed_frame_of(config, fixed_frame);
        let is_moved = fixed_frame != self.around.fixed_frame;
        self.around.fixed_frame = fixed_frame;
        let before = self.entries.len();
        let added = self.arrange(config);
        let world = self.around.world(now);
        for entry in self.entries.iter_mut().filter(|entry| added.contains(&entry.id)) {
            entry.give_all(&self.message_cache, &world);
        }
        let routes = &self.routes;
        let is_taken =
            |topic: &str, kind| routes.iter().any(|route| route.is_of(topic, kind) && !route.displays.is_empty());
        self.message_cache.limit_to(is_taken, &self.parameters());
        if is_moved {
            self.entries.iter_mut().for_each(|entry| entry.place_again(&self.message_cache, &world));
        }
        let is_read = |topic: &str| routes.iter().any(|route| route.request.topic == topic);
        self.camera_infos.retain(|topic, _| is_read(topic));
        self.lenses.keep(is_read);
        let kept = self.entries.len() - added.len();
        Reconfigured { kept, added: added.len(), removed: before - kept }
    }

    /// Makes the enabled displays of a config, reusing the present ones where they fit. Returns the new ones.
    fn arrange(&mut self, config: &Config) -> Vec<DisplayId> {
        let mut old = std::mem::take(&mut self.entries);
        let mut fits = |path: &[&str], placed: &DisplayConfig| {
            let same = |entry: &DisplayEntry| {
                let is_same = entry.listed.class == placed.class
                    && entry.listed.path == path
                    && entry.settings == placed.settings;
                is_same && !entry.has_failed()
            };
            old.iter().position(same).map(|index| old.remove(index))
        };
        let placed = config.placed_displays();
        let enabled = placed.iter().filter(|placed| placed.enabled);
        let found: Vec<_> = enabled.map(|placed| (placed, fits(&placed.path, placed.display))).collect();
        let used: HashSet<DisplayId> = found.iter().filter_map(|(_, entry)| Some(entry.as_ref()?.id)).collect();
        let mut free = (0..).filter(|id| !used.contains(id));
        let mut added = Vec::new();
        for (placed, entry) in found {
            let new = || {
                let (id, settings) = (free.next()?, placed.display.settings.clone());
                let listed = ListedDisplay {
                    path: owned(&placed.path),
                    class: placed.display.class.clone(),
                    topic: placed.display.topic_setting().map(str::to_owned),
                };
                let entry = DisplayEntry::new(id, listed, settings, create)?;
                added.push(id);
                Some(entry)
            };
            self.entries.extend(entry.or_else(new));
        }
        self.cameras = placed.iter().filter(|placed| placed.enabled).filter_map(|camera| self.camera(camera)).collect();
        self.routes = routes(&self.entries, &self.cameras);
        self.around.lit_by = config.global.default_light.then(|| config.view.clone());
        self.change_for_all();
        added
    }

    fn change_for_all(&mut self) {
        self.version += 1;
        self.changed_for_all_at = self.version;
    }

    fn camera(&self, placed: &PlacedDisplay<'_>) -> Option<CameraView> {
        let DisplaySettings::CameraPub(settings) = &placed.display.settings else { return None };
        let (name, path) = (placed.display.name.clone(), owned(&placed.path));
        Some(CameraView { name, path, settings: settings.clone(), visible: self.mask(&settings.visibility) })
    }

    /// Limits the markers that a display places in one update, see [`World::step`]: another update follows at once.
    pub fn limit_markers_per_update(&mut self, most: usize) {
        self.around.step = Some(most);
    }

    /// Leaves the points of the next messages to the renderer, see [`World::packs_points`].
    pub fn pack_points(&mut self, packs_points: bool) {
        self.around.packs_points = packs_points;
    }

    /// Sets the extrapolation of moving frames, cameras included; `None`: frames are at their latest transforms.
    pub fn predict(&mut self, prediction: Option<Prediction>) {
        self.around.prediction = prediction;
    }

    /// The extrapolation of moving frames, if there is any.
    pub fn prediction(&self) -> Option<&Prediction> {
        self.around.prediction.as_ref()
    }

    /// Displays that these tick boxes show.
    pub fn mask(&self, visibility: &Visibility) -> DisplayMask {
        let mut visible = DisplayMask::all();
        for entry in &self.entries {
            let path: Vec<&str> = entry.listed.path.iter().map(String::as_str).collect();
            visible.set(entry.id, visibility.shows(&path));
        }
        visible
    }

    /// The cameras, in the config's order.
    pub fn cameras(&self) -> &[CameraView] {
        &self.cameras
    }

    /// Topics of displays and cameras by their names in the config, without those of transforms: each once, with the
    /// longest of their queues.
    pub fn topics(&self) -> Vec<TopicRequest> {
        self.routes.iter().map(|route| route.request.clone()).collect()
    }

    /// Takes transforms of a publisher. Refused ones are logged once for each child frame and reason, those of too many
    /// frames once.
    pub fn take_transforms(&mut self, message: &TFMessage, is_static: bool, publisher: &str) {
        for transform in raw_transforms(message) {
            if let Err(error) = self.around.transforms.insert(&transform, is_static, publisher) {
                let key = match &error.problem {
                    InsertProblem::TooManyFrames => String::new(),
                    problem => format!("{publisher} {} {:?}", transform.child, std::mem::discriminant(problem)),
                };
                if self.around.warned.len() < MOST_WARNINGS && self.around.warned.insert(key) {
                    log::warn!("{error}");
                }
            }
        }
    }

    /// Passes a message of a topic, by its name in the config, to those that take it.
    pub fn take(&mut self, topic: &str, message: &AnyMessage, now: Time) {
        self.take_received(topic, message, None, now);
    }

    /// Like [`take`](Self::take), with the time of reception, which [`newly_shown`](Self::newly_shown) returns.
    pub fn take_received(&mut self, topic: &str, message: &AnyMessage, received: Option<Instant>, now: Time) {
        let Some(route) = self.routes.iter().find(|route| route.is_of(topic, message.kind())) else { return };
        if let AnyMessage::CameraInfo(info) = message {
            self.camera_infos.insert(topic.to_owned(), (Arc::clone(info), received));
        }
        let world = self.around.world(now);
        for entry in self.entries.iter_mut().filter(|entry| route.displays.contains(&entry.id)) {
            entry.take(topic, message, received, &world);
        }
        if !route.displays.is_empty() {
            self.message_cache.keep(topic, message, now);
        }
    }

    /// Names of the ROS parameters that the displays read, each once.
    pub fn parameters(&self) -> Vec<String> {
        let mut names: Vec<String> = self.entries.iter().flat_map(DisplayEntry::parameters).collect();
        names.sort();
        names.dedup();
        names
    }

    /// Passes the text of a parameter to the displays that read it; `None` while it is unset.
    pub fn take_parameter(&mut self, name: &str, text: Option<&Arc<str>>, now: Time) {
        self.message_cache.keep_parameter(name, text);
        let world = self.around.world(now);
        for entry in self.entries.iter_mut().filter(|entry| entry.parameters().iter().any(|read| read == name)) {
            entry.take_parameter(name, text, &world);
        }
    }

    /// Notifies the displays of a topic (by the name in the config) that one of its publishers is gone.
    pub fn publisher_left(&mut self, topic: &str) {
        for route in self.routes.iter().filter(|route| route.request.topic == topic) {
            let takers = self.entries.iter_mut().filter(|entry| route.displays.contains(&entry.id));
            takers.for_each(|entry| entry.publisher_left(topic));
        }
    }

    /// `true` if each message of a topic (by the name in the config) replaces all earlier ones in every display, and is
    /// large enough that skipping it pays.
    pub fn is_replaced_by_newest(&self, topic: &str, kind: MessageKind) -> bool {
        use MessageKind::{CompressedImage, Image, LaserScan, PointCloud, PointCloud2};
        let is_stream = matches!(kind, PointCloud2 | PointCloud | LaserScan | Image | CompressedImage);
        let takes = |id| self.routes.iter().any(|route| route.is_of(topic, kind) && route.displays.contains(&id));
        is_stream && self.entries.iter().filter(|entry| takes(entry.id)).all(DisplayEntry::is_replaced_by_newest)
    }

    /// `true` if meshes or textures were loaded since the last update.
    pub fn has_new_resources(&self) -> bool {
        self.around.meshes.version() != self.around.meshes_version
    }

    /// Faults of the loaded meshes that are not fatal, one line each.
    pub fn mesh_warnings(&self) -> Vec<String> {
        self.around.meshes.warnings()
    }

    /// Loads meshes and textures again that could not be used.
    pub fn retry_resources(&self) {
        self.around.meshes.retry_failures();
    }

    /// Brings the displays up to date. Returns whether the scene changed.
    pub fn update(&mut self, now: Time) -> bool {
        // First: meshes that are loaded from now on count as new.
        self.around.meshes_version = self.around.meshes.version();
        let light = self.around.lit_by.as_ref().map(|view| light(view, &self.around.world(now)));
        let before = self.version;
        if light != self.light {
            self.change_for_all();
        }
        self.light = light;
        self.newly_shown.clear();
        let world = self.around.world(now);
        for entry in &mut self.entries {
            let (has_changed, shown) = entry.update(&world);
            self.newly_shown.extend(shown.map(|shown| (entry.id, shown)));
            if has_changed {
                self.version += 1;
                entry.changed_at = self.version;
            }
        }
        self.version > before
    }

    /// Version, incremented with every change of the scene.
    pub fn version(&self) -> u64 {
        self.version
    }

    /// Version of the last change for a camera that shows these displays.
    pub fn version_shown(&self, visible: &DisplayMask) -> u64 {
        let shown = self.entries.iter().filter(|entry| visible.shows(entry.id));
        shown.map(|entry| entry.changed_at).fold(self.changed_for_all_at, u64::max)
    }

    /// Time spent on each display's messages and updates since the last call.
    pub fn take_costs(&mut self) -> impl Iterator<Item = (DisplayId, Duration)> + '_ {
        self.entries.iter_mut().map(|entry| (entry.id, std::mem::take(&mut entry.cost)))
    }

    /// Name of a display with those of the groups around it.
    pub fn path(&self, display: DisplayId) -> Option<&[String]> {
        self.entries.iter().find(|entry| entry.id == display).map(|entry| &*entry.listed.path)
    }

    /// Displays that show another message since the last update, each with the newest one.
    pub fn newly_shown(&self) -> &[(DisplayId, ShownMessage)] {
        &self.newly_shown
    }

    /// Time of the next change without a message.
    pub fn next_change(&self) -> Option<Time> {
        self.entries.iter().filter_map(DisplayEntry::next_change).min()
    }

    /// The scene of the last update.
    pub fn scene(&self) -> Scene {
        Scene { drawables: self.entries.iter().flat_map(DisplayEntry::drawables).cloned().collect(), light: self.light }
    }

    /// Tests a display against a camera's view, as of the last update; [`InView::Empty`] for an unknown id. Meant for
    /// reports: for a cloud outside the view it reads all points.
    pub fn in_view(&self, display: DisplayId, camera: &Camera) -> InView {
        let entry = self.entries.iter().find(|entry| entry.id == display);
        entry.map_or(InView::Empty, |entry| InView::of(entry.drawables(), camera))
    }

    /// Drops frames and messages: the time jumped back. CameraInfos are kept, as latched topics are not sent again.
    pub fn reset(&mut self) {
        self.around.transforms.clear();
        self.change_for_all();
        self.message_cache.forget_messages();
        self.entries.iter_mut().for_each(DisplayEntry::reset);
    }

    /// Age of each display.
    pub fn ages(&self) -> impl Iterator<Item = DisplayAge<'_>> {
        self.entries.iter().map(DisplayEntry::age)
    }

    /// Statuses of each display, including those of classes that are not drawn.
    pub fn reports(&self) -> impl Iterator<Item = DisplayReport<'_>> {
        self.entries.iter().map(DisplayEntry::report)
    }

    /// The last CameraInfo of a camera.
    pub fn camera_info(&self, camera: &CameraView) -> Option<&Arc<CameraInfo>> {
        self.camera_infos.get(&camera.settings.camera_info_topic).map(|(info, _)| info)
    }

    /// The CameraInfo topics of its cameras, by their names in the config.
    pub fn camera_info_topics(&self) -> impl Iterator<Item = &str> {
        self.cameras.iter().map(|view| view.settings.camera_info_topic.as_str())
    }

    /// The frame of the last CameraInfo of a topic, with its stamp and arrival.
    pub fn received_camera_info(&self, topic: &str) -> Option<(&str, ShownMessage)> {
        let (info, received) = self.camera_infos.get(topic)?;
        let shown = ShownMessage { stamp: time_from_stamp(info.header.stamp), received: *received };
        Some((&info.header.frame_id, shown))
    }

    /// The lenses of the last CameraInfos, by topic.
    pub fn lenses(&self) -> &Lenses {
        &self.lenses
    }

    /// The transforms, and the frame in which the scene is built.
    pub fn frames(&self) -> (&TransformTree, &str) {
        (&self.around.transforms, &self.around.fixed_frame)
    }

    /// The latest or [predicted](Self::predict) pose of a frame in the fixed frame.
    ///
    /// # Errors
    /// See [`LookupError`].
    pub fn pose_of(&self, frame: &str) -> Result<Isometry3<f64>, LookupError> {
        self.around.world(Time::ZERO).fixed_from_moving(frame)
    }

    /// The origin of a frame in the fixed frame now; `None` if it is unknown.
    pub fn place_of(&self, frame: &str) -> Option<Point3<f64>> {
        let place = self.around.world(Time::ZERO).fixed_from(frame, Time::ZERO).ok()?;
        Some(Point3::from(place.translation.vector))
    }

    /// Newest time at which a frame's place in the fixed frame is known; zero if nothing between them moves. `None` for
    /// the fixed frame itself, and for a frame whose place is unknown.
    pub fn known_until(&self, frame: &str) -> Option<Time> {
        let (transforms, fixed_frame) = self.frames();
        let is_fixed = frame.trim_start_matches('/') == fixed_frame;
        let found = (!is_fixed).then(|| transforms.lookup_stamped(fixed_frame, frame, Time::ZERO));
        found?.ok().map(|(_, stamp)| stamp)
    }
}

/// The frame in which the scene is built.
fn fixed_frame_of(config: &Config, given: Option<&str>) -> String {
    given.unwrap_or(&config.global.fixed_frame).trim_start_matches('/').to_owned()
}

/// The topics of displays and cameras, each with the displays that take it.
fn routes(displays: &[DisplayEntry], cameras: &[CameraView]) -> Vec<Route> {
    let of_display =
        |entry: &DisplayEntry| entry.topics.iter().map(|request| (request.clone(), Some(entry.id))).collect::<Vec<_>>();
    let of_camera = |view: &CameraView| {
        let request = TopicRequest::new(&view.settings.camera_info_topic, MessageKind::CameraInfo, 1)?;
        Some((request, None))
    };
    let mut routes: Vec<Route> = Vec::new();
    for (request, display) in displays.iter().flat_map(of_display).chain(cameras.iter().filter_map(of_camera)) {
        match routes.iter_mut().find(|route| route.is_of(&request.topic, request.kind)) {
            Some(route) => {
                route.request.queue_size = route.request.queue_size.max(request.queue_size);
                route.displays.extend(display);
            }
            None => routes.push(Route { request, displays: display.into_iter().collect() }),
        }
    }
    routes
}

fn owned(path: &[&str]) -> Vec<String> {
    path.iter().map(|name| (*name).to_owned()).collect()
}

/// rviz's default light shines along the main window's view.
fn light(view: &ViewConfig, world: &World<'_>) -> DirectionalLight {
    let fixed_from_target =
        view.target_frame.as_deref().and_then(|frame| world.fixed_from_moving(frame).ok()).unwrap_or_default();
    let rotation = fixed_from_target.rotation.into_inner().coords.into();
    DirectionalLight { direction: Vector3::from(view.direction_in_fixed_frame(rotation)) }
}

#[cfg(test)]
mod tests;
