//! All displays of a config, and their scene.

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
use crate::framework::arrivals::ShownMessage;
use crate::framework::display::Display;
use crate::framework::entry::DisplayEntry;
use crate::framework::guarded::GuardedDisplay;
use crate::framework::in_view::InView;
use crate::framework::message_cache::MessageCache;
use crate::framework::report::{DisplayAge, DisplayReport, ListedDisplay};
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
    entries: Vec<DisplayEntry>,
    cameras: Vec<CameraView>,
    /// rviz's main view, where the default light is on.
    lit_by: Option<ViewConfig>,
    light: Option<DirectionalLight>,
    message_cache: MessageCache,
    /// Displays that show another message since the last update.
    newly_shown: Vec<(DisplayId, ShownMessage)>,
    /// Version, incremented with every change of the scene.
    version: u64,
    /// Version of the last change for all cameras: of the light, or of the list of displays.
    changed_for_all_at: u64,
}

impl std::fmt::Debug for DisplaySet {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let listed: Vec<&ListedDisplay> = self.entries.iter().map(|entry| &entry.listed).collect();
        f.debug_struct("DisplaySet").field("displays", &listed).field("cameras", &self.cameras).finish_non_exhaustive()
    }
}

impl DisplaySet {
    /// Makes the enabled displays and cameras of a config; all groups around them must be enabled, too.
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

    /// Makes the enabled displays of a config, reusing the present ones where they fit. Returns the new ones.
    fn arrange(&mut self, config: &Config) -> Vec<DisplayId> {
        let mut old = std::mem::take(&mut self.entries);
        let mut fits = |path: &[&str], placed: &DisplayConfig| {
            let same = |entry: &DisplayEntry| {
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
                Some(DisplayEntry::new(id, listed, placed.display.settings.clone(), display))
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

    /// Topics that the displays subscribe to, each once, with the longest of their queues.
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

    /// Passes a message of a topic (by the name in the config) to the displays that subscribe to it.
    pub fn take(&mut self, topic: &str, message: &AnyMessage, world: &World<'_>) {
        self.take_received(topic, message, None, world);
    }

    /// Like [`take`](Self::take), with the time of reception, which [`newly_shown`](Self::newly_shown) returns.
    pub fn take_received(&mut self, topic: &str, message: &AnyMessage, received: Option<Instant>, world: &World<'_>) {
        let mut wanted = false;
        for entry in &mut self.entries {
            let wants = |request: &TopicRequest| request.topic == topic && request.kind == message.kind();
            if entry.display.topics().iter().any(wants) {
                entry.take(topic, message, received, world);
                wanted = true;
            }
        }
        if wanted {
            self.message_cache.keep(topic, message, world.now);
        }
    }

    /// Names of the ROS parameters that the displays read, each once.
    pub fn parameters(&self) -> Vec<String> {
        let mut names: Vec<String> = self.entries.iter().flat_map(|entry| entry.display.parameters()).collect();
        names.sort();
        names.dedup();
        names
    }

    /// Passes the text of a parameter to the displays that read it; `None` while it is unset.
    pub fn take_parameter(&mut self, name: &str, text: Option<&Arc<str>>, world: &World<'_>) {
        self.message_cache.keep_parameter(name, text);
        for entry in &mut self.entries {
            if entry.display.parameters().iter().any(|wanted| wanted == name) {
                entry.take_parameter(name, text, world);
            }
        }
    }

    /// Notifies the displays of a topic (by the name in the config) that one of its publishers is gone.
    pub fn publisher_left(&mut self, topic: &str) {
        for entry in &mut self.entries {
            if entry.display.topics().iter().any(|request| request.topic == topic) {
                entry.publisher_left(topic);
            }
        }
    }

    /// `true` if each message of a topic (by the name in the config) replaces all earlier ones in every display, and is
    /// large enough that skipping it pays.
    pub fn is_replaced_by_newest(&self, topic: &str, kind: MessageKind) -> bool {
        use MessageKind::{CompressedImage, Image, LaserScan, PointCloud, PointCloud2};
        let is_stream = matches!(kind, PointCloud2 | PointCloud | LaserScan | Image | CompressedImage);
        is_stream && self.entries_of(topic, kind).all(|entry| entry.display.is_replaced_by_newest())
    }

    fn entries_of<'a>(&'a self, topic: &'a str, kind: MessageKind) -> impl Iterator<Item = &'a DisplayEntry> {
        let wants = move |request: &TopicRequest| request.topic == topic && request.kind == kind;
        self.entries.iter().filter(move |entry| entry.display.topics().iter().any(wants))
    }

    /// Updates all displays. Returns whether the scene changed.
    pub fn update(&mut self, world: &World<'_>) -> bool {
        let light = self.lit_by.as_ref().map(|view| light(view, world));
        let before = self.version;
        if light != self.light {
            self.change_for_all();
        }
        self.light = light;
        self.newly_shown.clear();
        for entry in &mut self.entries {
            let (has_changed, shown) = entry.update(world);
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
        self.entries.iter().filter_map(|entry| entry.display.next_change()).min()
    }

    /// The scene of the last update.
    pub fn scene(&self) -> Scene {
        Scene {
            drawables: self.entries.iter().flat_map(|entry| entry.display.drawables()).cloned().collect(),
            light: self.light,
        }
    }

    /// Tests a display against a camera's view, as of the last update; [`InView::Empty`] for an unknown id. Meant for
    /// reports: for a cloud outside the view it reads all points.
    pub fn in_view(&self, display: DisplayId, camera: &Camera) -> InView {
        let entry = self.entries.iter().find(|entry| entry.id == display);
        entry.map_or(InView::Empty, |entry| InView::of(entry.display.drawables(), camera))
    }

    /// Removes all messages.
    pub fn reset(&mut self) {
        self.change_for_all();
        self.message_cache.forget_messages();
        self.entries.iter_mut().for_each(DisplayEntry::reset);
    }

    /// Places everything in another fixed frame.
    pub fn change_fixed_frame(&mut self, world: &World<'_>) {
        self.change_for_all();
        for entry in &mut self.entries {
            entry.place_again(&self.message_cache, world);
        }
    }

    /// Age of each display.
    pub fn ages(&self) -> impl Iterator<Item = DisplayAge<'_>> {
        self.entries.iter().map(DisplayEntry::age)
    }

    /// Statuses of each display, including those of classes that are not drawn.
    pub fn reports(&self) -> impl Iterator<Item = DisplayReport<'_>> {
        self.entries.iter().map(DisplayEntry::report)
    }
}

/// A display of these settings; `None` for groups and cameras.
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
