//! All displays of a config, and the scene that they make together.

use std::sync::Arc;

use nalgebra::Vector3;
use rcs_messages::{AnyMessage, MessageKind};
use rcs_rviz_config::{CameraPubSettings, CloudSettings, Config, DisplaySettings, PlacedDisplay, ViewConfig};
use rcs_scene::{DirectionalLight, DisplayId, DisplayMask, Scene};
use rcs_transforms::Time;

use crate::axes::AxesDisplay;
use crate::cloud::{CloudDisplay, CloudSource};
use crate::display::Display;
use crate::effort::EffortDisplay;
use crate::grid::GridDisplay;
use crate::grid_cells::GridCellsDisplay;
use crate::interactive_markers::InteractiveMarkersDisplay;
use crate::laser_scan::LaserScanSource;
use crate::map::MapDisplay;
use crate::marker::MarkerDisplay;
use crate::not_drawn::NotDrawnDisplay;
use crate::odometry::OdometryDisplay;
use crate::path::PathDisplay;
use crate::point_cloud::PointCloudSource;
use crate::point_cloud2::PointCloud2Source;
use crate::point_stamped::PointStampedDisplay;
use crate::polygon::PolygonDisplay;
use crate::pose::PoseDisplay;
use crate::pose_array::PoseArrayDisplay;
use crate::pose_with_covariance::PoseWithCovarianceDisplay;
use crate::range::RangeDisplay;
use crate::report::DisplayReport;
use crate::robot_model::RobotModelDisplay;
use crate::scalar::{FluidPressureSource, IlluminanceSource, RelativeHumiditySource, TemperatureSource};
use crate::screw::ScrewDisplay;
use crate::tf::TfDisplay;
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

/// The one place where a display class becomes a display. `None` for what is no display in the scene: groups and cameras.
fn create(id: DisplayId, settings: &DisplaySettings) -> Option<Box<dyn Display>> {
    Some(match settings {
        DisplaySettings::PointCloud2(settings) => clouds::<PointCloud2Source>(id, settings),
        DisplaySettings::PointCloud(settings) => clouds::<PointCloudSource>(id, settings),
        DisplaySettings::LaserScan(settings) => clouds::<LaserScanSource>(id, settings),
        DisplaySettings::FluidPressure(settings) => clouds::<FluidPressureSource>(id, settings),
        DisplaySettings::Illuminance(settings) => clouds::<IlluminanceSource>(id, settings),
        DisplaySettings::RelativeHumidity(settings) => clouds::<RelativeHumiditySource>(id, settings),
        DisplaySettings::Temperature(settings) => clouds::<TemperatureSource>(id, settings),
        DisplaySettings::GridCells(settings) => Box::new(GridCellsDisplay::new(id, settings.clone())),
        DisplaySettings::Range(settings) => Box::new(RangeDisplay::new(id, settings.clone())),
        DisplaySettings::Grid(settings) => Box::new(GridDisplay::new(id, settings.clone())),
        DisplaySettings::Axes(settings) => Box::new(AxesDisplay::new(id, settings.clone())),
        DisplaySettings::Marker(settings) => Box::new(MarkerDisplay::single(id, settings.clone())),
        DisplaySettings::MarkerArray(settings) => Box::new(MarkerDisplay::array(id, settings.clone())),
        DisplaySettings::Path(settings) => Box::new(PathDisplay::new(id, settings.clone())),
        DisplaySettings::WrenchStamped(settings) => {
            Box::new(ScrewDisplay::new(id, settings.clone(), MessageKind::WrenchStamped))
        }
        DisplaySettings::TwistStamped(settings) => {
            Box::new(ScrewDisplay::new(id, settings.clone(), MessageKind::TwistStamped))
        }
        DisplaySettings::AccelStamped(settings) => {
            Box::new(ScrewDisplay::new(id, settings.clone(), MessageKind::AccelStamped))
        }
        DisplaySettings::Tf(settings) => Box::new(TfDisplay::new(id, settings.clone())),
        DisplaySettings::Odometry(settings) => Box::new(OdometryDisplay::of(id, settings)),
        DisplaySettings::PointStamped(settings) => Box::new(PointStampedDisplay::of(id, settings)),
        DisplaySettings::Polygon(settings) => Box::new(PolygonDisplay::of(id, settings)),
        DisplaySettings::Pose(settings) => Box::new(PoseDisplay::of(id, settings)),
        DisplaySettings::PoseArray(settings) => Box::new(PoseArrayDisplay::of(id, settings)),
        DisplaySettings::PoseWithCovariance(settings) => Box::new(PoseWithCovarianceDisplay::of(id, settings)),
        DisplaySettings::InteractiveMarkers(settings) => Box::new(InteractiveMarkersDisplay::new(id, settings.clone())),
        DisplaySettings::Map(settings) => Box::new(MapDisplay::new(id, settings.clone())),
        DisplaySettings::Image(_) | DisplaySettings::Camera(_) => Box::new(NotDrawnDisplay::of_window()),
        DisplaySettings::NotDrawn { known, .. } => Box::new(NotDrawnDisplay::new(*known)),
        DisplaySettings::RobotModel(settings) => Box::new(RobotModelDisplay::new(id, settings.clone())),
        DisplaySettings::Effort(settings) => Box::new(EffortDisplay::new(id, settings.clone())),
        DisplaySettings::Group(_) | DisplaySettings::CameraPub(_) => return None,
    })
}

/// A display of clouds that come from messages of a type.
fn clouds<S: CloudSource + 'static>(id: DisplayId, settings: &CloudSettings) -> Box<dyn Display> {
    Box::new(CloudDisplay::<S>::new(id, settings.clone()))
}

struct Entry {
    listed: ListedDisplay,
    display: Box<dyn Display>,
    /// How many messages it was given since the start or the last reset.
    received: u64,
}

/// The enabled displays of a config, in its order.
pub struct DisplaySet {
    entries: Vec<Entry>,
    cameras: Vec<CameraView>,
    /// rviz's main view, where the default light is on.
    lit_by: Option<ViewConfig>,
    light: Option<DirectionalLight>,
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
        let placed = config.placed_displays();
        let mut entries = Vec::new();
        for (id, placed) in placed.iter().enumerate().filter(|(_, placed)| placed.enabled) {
            let listed = ListedDisplay {
                path: owned(&placed.path),
                class: placed.display.class.clone(),
                topic: placed.display.topic_setting().map(str::to_owned),
            };
            let display = create(id as DisplayId, &placed.display.settings);
            entries.extend(display.map(|display| Entry { listed, display, received: 0 }));
        }
        let lit_by = config.global.default_light.then(|| config.view.clone());
        Self { entries, cameras: cameras(&placed), lit_by, light: None }
    }

    /// The cameras, in the config's order.
    pub fn cameras(&self) -> &[CameraView] {
        &self.cameras
    }

    /// What the displays listen to; a topic that several want stands here once, with the longest of their queues.
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
        for entry in &mut self.entries {
            let wants = |request: &TopicRequest| request.topic == topic && request.kind == message.kind();
            if entry.display.topics().iter().any(wants) {
                entry.received += 1;
                entry.display.take(message, world);
            }
        }
    }

    /// The names of the ROS parameters that the displays want to know, each once.
    pub fn parameters(&self) -> Vec<String> {
        let mut names: Vec<String> = self.entries.iter().flat_map(|entry| entry.display.parameters()).collect();
        names.sort();
        names.dedup();
        names
    }

    /// Hands the text of a parameter to the displays that want it; `None` while nobody has set it.
    pub fn take_parameter(&mut self, name: &str, text: Option<&Arc<str>>, world: &World<'_>) {
        for entry in &mut self.entries {
            if entry.display.parameters().iter().any(|wanted| wanted == name) {
                entry.display.take_parameter(name, text, world);
            }
        }
    }

    /// Brings all displays up to date. Returns whether the scene changed.
    pub fn update(&mut self, world: &World<'_>) -> bool {
        let light = self.lit_by.as_ref().map(|view| light(view, world));
        let mut changed = light != self.light;
        self.light = light;
        for entry in &mut self.entries {
            changed |= entry.display.update(world);
        }
        changed
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

    /// Forgets all messages.
    pub fn reset(&mut self) {
        for entry in &mut self.entries {
            entry.received = 0;
            entry.display.reset();
        }
    }

    /// How each display does, those of classes that are not drawn among them.
    pub fn reports(&self) -> impl Iterator<Item = DisplayReport<'_>> {
        self.entries.iter().map(|entry| DisplayReport::new(&entry.listed, entry.display.as_ref(), entry.received))
    }
}

fn owned(path: &[&str]) -> Vec<String> {
    path.iter().map(|name| (*name).to_owned()).collect()
}

fn cameras(placed: &[PlacedDisplay<'_>]) -> Vec<CameraView> {
    let enabled = placed.iter().filter(|placed| placed.enabled);
    let camera = |camera: &PlacedDisplay<'_>| {
        let DisplaySettings::CameraPub(settings) = &camera.display.settings else { return None };
        let mut visible = DisplayMask::all();
        for (id, other) in placed.iter().enumerate() {
            visible.set(id as DisplayId, settings.visibility.shows(&other.path));
        }
        let (name, path) = (camera.display.name.clone(), owned(&camera.path));
        Some(CameraView { name, path, settings: settings.clone(), visible })
    };
    enabled.filter_map(camera).collect()
}

/// rviz's default light shines along the main window's view.
fn light(view: &ViewConfig, world: &World<'_>) -> DirectionalLight {
    let fixed_from_target =
        view.target_frame.as_deref().and_then(|frame| world.fixed_from(frame, Time::ZERO).ok()).unwrap_or_default();
    let rotation = fixed_from_target.rotation.into_inner().coords.into();
    DirectionalLight { direction: Vector3::from(view.direction_in_fixed_frame(rotation)) }
}
