//! All displays of a config, and the scene that they make together.

use std::collections::HashSet;
use std::sync::Arc;
use std::time::{Duration, Instant};

use nalgebra::Vector3;
use rcs_messages::{AnyMessage, MessageKind};
use rcs_rviz_config::{
    CameraPubSettings, Config, DisplayConfig, DisplaySettings, PlacedDisplay, ViewConfig, Visibility,
};
use rcs_scene::{Camera, DirectionalLight, DisplayId, DisplayMask, Scene};
use rcs_transforms::Time;

use crate::classes::create;
use crate::framework::ages::DisplayAge;
use crate::framework::arrivals::ShownMessage;
use crate::framework::display::Display;
use crate::framework::entry::Entry;
use crate::framework::guarded::GuardedDisplay;
use crate::framework::in_view::InView;
use crate::framework::message_cache::{CachedMessage, MessageCache};
use crate::framework::report::DisplayReport;
use crate::{TopicRequest, World};

/// A camera of a config: an enabled CameraPub display.
#[derive(Clone, Debug)]
pub struct CameraView {
    /// The display's name.
    pub name: String,
    /// The names of the groups around it and its own.
    pub path: Vec<String>,
    /// Its properties.
    pub settings: CameraPubSettings,
    /// Which displays it shows.
    pub visible: DisplayMask,
}

/// A display of a config, drawn or not.
#[derive(Clone, Debug)]
pub struct ListedDisplay {
    /// The names of the groups around it and its own.
    pub path: Vec<String>,
    /// Such as `rviz/Grid`.
    pub class: String,
    /// The topic that the config gives it, which may be empty; `None` for a class without topic.
    pub topic: Option<String>,
}

/// What reading a config again changed.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Reconfigured {
    /// How many displays stay as they are, with all that they show.
    pub kept: usize,
    /// How many were added, those with other settings than before included.
    pub added: usize,
    /// How many were removed, those with other settings now included.
    pub removed: usize,
}

/// The enabled displays of a config, in its order.
///
/// ```
/// use rcs_displays::{DisplaySet, World};
/// use rcs_resources::{MeshStore, PackageIndex};
/// use rcs_transforms::{Time, TransformTree};
///
/// let text = "Visualization Manager: {Displays: [{Class: rviz/Grid, Name: floor, Enabled: true}]}";
/// let mut displays = DisplaySet::new(&rcs_rviz_config::parse(text, "scene.rviz")?);
/// let (transforms, meshes) = (TransformTree::new(), MeshStore::new(PackageIndex::new([])));
/// let world = World::new(&transforms, "map", Time::ZERO, &meshes);
///
/// // Messages go to `take`, each with the name of its topic in the config; then an update brings the scene up to date.
/// assert!(displays.update(&world));
/// assert_eq!(displays.scene().drawables.len(), 1);
/// # Ok::<(), rcs_rviz_config::ConfigError>(())
/// ```
pub struct DisplaySet {
    entries: Vec<Entry>,
    cameras: Vec<CameraView>,
    /// rviz's main view, where the default light is on.
    lit_by: Option<ViewConfig>,
    light: Option<DirectionalLight>,
    message_cache: MessageCache,
    /// The displays that the last update made show another message.
    newly_shown: Vec<(DisplayId, ShownMessage)>,
    /// Incremented with every change of the scene.
    version: u64,
    /// That of the last change that concerns every camera: of the light, or of which displays there are.
    changed_for_all_at: u64,
}

impl std::fmt::Debug for DisplaySet {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let listed: Vec<&ListedDisplay> = self.entries.iter().map(|entry| &entry.listed).collect();
        f.debug_struct("DisplaySet").field("displays", &listed).field("cameras", &self.cameras).finish_non_exhaustive()
    }
}

impl DisplaySet {
    /// Makes the displays and the cameras of a config that are enabled, all groups around them included.
    pub fn new(config: &Config) -> Self {
        let mut set = Self {
            entries: Vec::new(),
            cameras: Vec::new(),
            lit_by: None,
            light: None,
            message_cache: MessageCache::default(),
            newly_shown: Vec::new(),
            version: 0,
            changed_for_all_at: 0,
        };
        set.arrange(config);
        set
    }

    /// Applies another config. A display of the same class, name, groups and settings stays as it is; another one, and
    /// one that panicked, is recreated and gets the last messages of its topics.
    pub fn reconfigure(&mut self, config: &Config, world: &World<'_>) -> Reconfigured {
        let before = self.entries.len();
        let added = self.arrange(config);
        for entry in self.entries.iter_mut().filter(|entry| added.contains(&entry.id)) {
            entry.give_all(&self.message_cache, world);
        }
        self.message_cache.limit_to(&self.topics(), &self.parameters());
        let kept = self.entries.len() - added.len();
        Reconfigured { kept, added: added.len(), removed: before - kept }
    }

    /// Makes the enabled displays of a config, out of those that there are where they fit. Returns which are new.
    fn arrange(&mut self, config: &Config) -> Vec<DisplayId> {
        let mut old = std::mem::take(&mut self.entries);
        let mut fits = |path: &[&str], placed: &DisplayConfig| {
            let same = |entry: &Entry| {
                let is_same = entry.listed.class == placed.class
                    && entry.listed.path == path
                    && entry.settings == placed.settings;
                is_same && !entry.display.has_failed()
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
                let id = free.next()?;
                let display = guarded(id, &placed.display.settings)?;
                let listed = ListedDisplay {
                    path: owned(&placed.path),
                    class: placed.display.class.clone(),
                    topic: placed.display.topic_setting().map(str::to_owned),
                };
                added.push(id);
                Some(Entry::new(id, listed, placed.display.settings.clone(), display))
            };
            self.entries.extend(entry.or_else(new));
        }
        self.cameras = placed.iter().filter(|placed| placed.enabled).filter_map(|camera| self.camera(camera)).collect();
        self.lit_by = config.global.default_light.then(|| config.view.clone());
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

    /// Which displays these tick boxes show.
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

    /// What the displays subscribe to; a topic of several displays stands here once, with the longest of their queues.
    pub fn topics(&self) -> Vec<TopicRequest> {
        let mut topics: Vec<TopicRequest> = Vec::new();
        for request in self.entries.iter().flat_map(|entry| entry.display.topics()) {
            match topics.iter_mut().find(|known| (&known.topic, known.kind) == (&request.topic, request.kind)) {
                Some(known) => known.queue_size = known.queue_size.max(request.queue_size),
                None => topics.push(request),
            }
        }
        topics
    }

    /// Hands a message of a topic (by the name in the config) to the displays that want it.
    pub fn take(&mut self, topic: &str, message: &AnyMessage, world: &World<'_>) {
        self.take_received(topic, message, None, world);
    }

    /// As [`take`](Self::take), with the moment when the message was received, which [`newly_shown`](Self::newly_shown)
    /// returns.
    pub fn take_received(&mut self, topic: &str, message: &AnyMessage, received: Option<Instant>, world: &World<'_>) {
        let number = self.message_cache.next_number();
        let kept = CachedMessage { number, topic, message: message.clone() };
        let mut wanted = false;
        for entry in &mut self.entries {
            let wants = |request: &TopicRequest| request.topic == topic && request.kind == message.kind();
            if entry.display.topics().iter().any(wants) {
                entry.take(&kept, received, world);
                wanted = true;
            }
        }
        if wanted {
            self.message_cache.keep(topic, message, world.now);
        }
    }

    /// The names of the ROS parameters that the displays read, each once.
    pub fn parameters(&self) -> Vec<String> {
        let mut names: Vec<String> = self.entries.iter().flat_map(|entry| entry.display.parameters()).collect();
        names.sort();
        names.dedup();
        names
    }

    /// Hands the text of a parameter to the displays that read it; `None` while it is not set.
    pub fn take_parameter(&mut self, name: &str, text: Option<&Arc<str>>, world: &World<'_>) {
        self.message_cache.keep_parameter(name, text);
        for entry in &mut self.entries {
            if entry.display.parameters().iter().any(|wanted| wanted == name) {
                entry.take_parameter(name, text, world);
            }
        }
    }

    /// Tells the displays that subscribe to a topic (by the name in the config) that one of its publishers is gone.
    pub fn publisher_left(&mut self, topic: &str) {
        for entry in &mut self.entries {
            if entry.display.topics().iter().any(|request| request.topic == topic) {
                entry.publisher_left(topic);
            }
        }
    }

    /// Whether each message of a topic (by the name in the config) replaces all that earlier ones made in every display
    /// that takes it, and is large enough that it is worth while not to receive it.
    pub fn is_replaced_by_newest(&self, topic: &str, kind: MessageKind) -> bool {
        use MessageKind::{CompressedImage, Image, LaserScan, PointCloud, PointCloud2};
        let is_stream = matches!(kind, PointCloud2 | PointCloud | LaserScan | Image | CompressedImage);
        is_stream && self.entries_of(topic, kind).all(|entry| entry.display.is_replaced_by_newest())
    }

    fn entries_of<'a>(&'a self, topic: &'a str, kind: MessageKind) -> impl Iterator<Item = &'a Entry> {
        let wants = move |request: &TopicRequest| request.topic == topic && request.kind == kind;
        self.entries.iter().filter(move |entry| entry.display.topics().iter().any(wants))
    }

    /// Has the displays of such a topic show nothing until its next message: what it sent is old.
    pub fn forget_topic(&mut self, topic: &str, kind: MessageKind) {
        let of_topic: Vec<DisplayId> = self.entries_of(topic, kind).map(|entry| entry.id).collect();
        self.message_cache.forget(topic, kind);
        self.version += 1;
        for entry in self.entries.iter_mut().filter(|entry| of_topic.contains(&entry.id)) {
            entry.forget_shown();
            entry.changed_at = self.version;
        }
    }

    /// Brings all displays up to date. Returns whether the scene changed.
    pub fn update(&mut self, world: &World<'_>) -> bool {
        let light = self.lit_by.as_ref().map(|view| light(view, world));
        let before = self.version;
        if light != self.light {
            self.change_for_all();
        }
        self.light = light;
        self.newly_shown.clear();
        for entry in &mut self.entries {
            let (has_changed, shown) = entry.update(&self.message_cache, world);
            self.newly_shown.extend(shown.map(|shown| (entry.id, shown)));
            if has_changed {
                self.version += 1;
                entry.changed_at = self.version;
            }
        }
        self.version > before
    }

    /// Incremented with every change of the scene.
    pub fn version(&self) -> u64 {
        self.version
    }

    /// The version of the last change that a camera sees, which shows these displays.
    pub fn version_shown(&self, visible: &DisplayMask) -> u64 {
        let shown = self.entries.iter().filter(|entry| visible.shows(entry.id));
        shown.map(|entry| entry.changed_at).fold(self.changed_for_all_at, u64::max)
    }

    /// What each display's messages and updates took since this was last called.
    pub fn take_costs(&mut self) -> impl Iterator<Item = (DisplayId, Duration)> + '_ {
        self.entries.iter_mut().map(|entry| (entry.id, std::mem::take(&mut entry.cost)))
    }

    /// A display's name with those of the groups around it.
    pub fn path(&self, display: DisplayId) -> Option<&[String]> {
        self.entries.iter().find(|entry| entry.id == display).map(|entry| &*entry.listed.path)
    }

    /// The displays that show another message since the last update, each with the newest one.
    pub fn newly_shown(&self) -> &[(DisplayId, ShownMessage)] {
        &self.newly_shown
    }

    /// The next time at which the scene changes by itself.
    pub fn next_change(&self) -> Option<Time> {
        self.entries.iter().filter_map(|entry| entry.display.next_change()).min()
    }

    /// The scene as it is since the last update.
    pub fn scene(&self) -> Scene {
        Scene {
            drawables: self.entries.iter().flat_map(|entry| entry.display.drawables()).cloned().collect(),
            light: self.light,
        }
    }

    /// Whether anything of a display lies in a camera's view, since the last update. [`InView::Empty`] for an id that
    /// no display has. Meant for reports: for a cloud outside the view it reads all points.
    pub fn in_view(&self, display: DisplayId, camera: &Camera) -> InView {
        let entry = self.entries.iter().find(|entry| entry.id == display);
        entry.map_or(InView::Empty, |entry| InView::of(entry.display.drawables(), camera))
    }

    /// Forgets all messages.
    pub fn reset(&mut self) {
        self.change_for_all();
        self.message_cache.forget_messages();
        self.entries.iter_mut().for_each(Entry::reset);
    }

    /// Places everything in another fixed frame.
    pub fn change_fixed_frame(&mut self, world: &World<'_>) {
        self.change_for_all();
        for entry in &mut self.entries {
            entry.place_again(&self.message_cache, world);
        }
    }

    /// What the age of each display is measured by.
    pub fn ages(&self) -> impl Iterator<Item = DisplayAge<'_>> {
        self.entries.iter().map(Entry::age)
    }

    /// The statuses of each display, those of classes that are not drawn included.
    pub fn reports(&self) -> impl Iterator<Item = DisplayReport<'_>> {
        self.entries.iter().map(Entry::report)
    }
}

/// A display of these settings; `None` for what is no display in the scene.
fn guarded(id: DisplayId, settings: &DisplaySettings) -> Option<GuardedDisplay> {
    let settings = settings.clone();
    GuardedDisplay::new(Box::new(move || create(id, &settings)))
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
