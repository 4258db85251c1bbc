//! The displays of a config: which class each is, what every display has, and the reader of each class.
//!
//! A display class that is drawn has a file here with its settings, their defaults and their reading. The classes
//! that rviz has and that are not drawn yet are [`KNOWN_NOT_DRAWN`]; every other class is unknown.

pub(crate) mod axes;
pub(crate) mod camera_pub;
pub(crate) mod cloud;
pub(crate) mod covariance;
pub(crate) mod depth_cloud;
pub(crate) mod effort;
pub(crate) mod grid;
pub(crate) mod grid_cells;
pub(crate) mod image;
pub(crate) mod interactive_markers;
pub(crate) mod map;
pub(crate) mod marker;
pub(crate) mod odometry;
pub(crate) mod path;
pub(crate) mod point_stamped;
pub(crate) mod polygon;
pub(crate) mod pose;
pub(crate) mod pose_array;
pub(crate) mod pose_symbol;
pub(crate) mod pose_with_covariance;
pub(crate) mod range;
pub(crate) mod robot_model;
pub(crate) mod screw;
pub(crate) mod tf;
pub(crate) mod visibility;

use crate::finding::FindingKind;
use crate::node::{Content, Node};
use crate::section::{join, Report, Section};

use axes::AxesSettings;
use camera_pub::CameraPubSettings;
use cloud::CloudSettings;
use depth_cloud::DepthCloudSettings;
use effort::EffortSettings;
use grid::GridSettings;
use grid_cells::GridCellsSettings;
use image::ImageSettings;
use interactive_markers::InteractiveMarkersSettings;
use map::MapSettings;
use marker::MarkerSettings;
use odometry::OdometrySettings;
use path::PathSettings;
use point_stamped::PointStampedSettings;
use polygon::PolygonSettings;
use pose::PoseSettings;
use pose_array::PoseArraySettings;
use pose_with_covariance::PoseWithCovarianceSettings;
use range::RangeSettings;
use robot_model::RobotModelSettings;
use screw::ScrewSettings;
use tf::TfSettings;

/// One entry of a list of displays.
#[derive(Debug, Clone, PartialEq)]
pub struct DisplayConfig {
    /// The display's name; empty when it has none. Names need not be unique.
    pub name: String,
    /// Its class as the file writes it, such as `rviz/PointCloud2`; empty when it has none.
    pub class: String,
    /// Its own tick box. A display inside a group is drawn only if all groups around it are enabled as well. A
    /// display that says nothing is not enabled, as in rviz.
    pub enabled: bool,
    /// The line at which the display begins, from 1.
    pub line: usize,
    /// Its properties.
    pub settings: DisplaySettings,
}

/// The properties of a display by class.
#[derive(Debug, Clone, PartialEq)]
pub enum DisplaySettings {
    /// `rviz/PointCloud2`
    PointCloud2(CloudSettings),
    /// `rviz/PointCloud`
    PointCloud(CloudSettings),
    /// `rviz/LaserScan`
    LaserScan(CloudSettings),
    /// `rviz/FluidPressure`
    FluidPressure(CloudSettings),
    /// `rviz/Illuminance`
    Illuminance(CloudSettings),
    /// `rviz/RelativeHumidity`
    RelativeHumidity(CloudSettings),
    /// `rviz/Temperature`
    Temperature(CloudSettings),
    /// `rviz/GridCells`
    GridCells(GridCellsSettings),
    /// `rviz/Range`
    Range(RangeSettings),
    /// `rviz/Grid`
    Grid(GridSettings),
    /// `rviz/Axes`
    Axes(AxesSettings),
    /// `rviz/Marker`
    Marker(MarkerSettings),
    /// `rviz/MarkerArray`
    MarkerArray(MarkerSettings),
    /// `rviz/Path`
    Path(PathSettings),
    /// `rviz/WrenchStamped`
    WrenchStamped(ScrewSettings),
    /// `rviz/TwistStamped`
    TwistStamped(ScrewSettings),
    /// `rviz/AccelStamped`
    AccelStamped(ScrewSettings),
    /// `rviz/TF`
    Tf(TfSettings),
    /// `rviz/Odometry`
    Odometry(OdometrySettings),
    /// `rviz/PointStamped`
    PointStamped(PointStampedSettings),
    /// `rviz/Polygon`
    Polygon(PolygonSettings),
    /// `rviz/Pose`
    Pose(PoseSettings),
    /// `rviz/PoseArray`
    PoseArray(PoseArraySettings),
    /// `rviz/PoseWithCovariance`
    PoseWithCovariance(PoseWithCovarianceSettings),
    /// `rviz/DepthCloud`
    DepthCloud(DepthCloudSettings),
    /// `rviz/Map`
    Map(MapSettings),
    /// `rviz/Image`
    Image(ImageSettings),
    /// `rviz/Camera`
    Camera(ImageSettings),
    /// `rviz/InteractiveMarkers`
    InteractiveMarkers(InteractiveMarkersSettings),
    /// `rviz/RobotModel`
    RobotModel(RobotModelSettings),
    /// `rviz/Effort`
    Effort(EffortSettings),
    /// `rviz/Group`: displays inside a display, in the file's order.
    Group(Vec<DisplayConfig>),
    /// `rviz_camera_stream/CameraPub`
    CameraPub(CameraPubSettings),
    /// A class that is not drawn.
    NotDrawn {
        /// The topic that the display names, if it names one.
        topic: Option<String>,
        /// Whether it is one of rviz's own classes.
        known: bool,
    },
}

/// How lines are drawn by the displays that let one choose.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum LineStyle {
    /// One pixel wide at any distance.
    #[default]
    Lines,
    /// Strips that face the camera, of a width in metres.
    Billboards,
}

/// The names of line styles in a config.
pub(crate) const LINE_STYLES: [(&str, LineStyle); 2] =
    [("Lines", LineStyle::Lines), ("Billboards", LineStyle::Billboards)];

/// The display classes of rviz 1.14 that are not drawn yet.
const KNOWN_NOT_DRAWN: &[&str] = &[];

/// The keys under which displays that are not drawn name the topic that they show, the likeliest first.
const TOPIC_KEYS: [&str; 5] = ["Topic", "Marker Topic", "Image Topic", "Depth Map Topic", "Update Topic"];

impl DisplayConfig {
    /// Whether all is shown of this display that a camera could see. True of a group, whose displays are drawn or not
    /// each for itself, of a CameraPub, which is what draws, and of what is not in the scene (an Image or a Camera).
    pub fn is_drawn(&self) -> bool {
        !matches!(self.settings, DisplaySettings::NotDrawn { .. })
    }

    /// The topic that the display shows, or publishes in the case of a CameraPub; `None` if it has none or it is
    /// empty.
    pub fn topic(&self) -> Option<&str> {
        self.topic_setting().filter(|topic| !topic.is_empty())
    }

    /// The same as the config has it, which may be empty; `None` for a class without topic.
    pub fn topic_setting(&self) -> Option<&str> {
        let topic = match &self.settings {
            DisplaySettings::PointCloud2(settings)
            | DisplaySettings::PointCloud(settings)
            | DisplaySettings::LaserScan(settings)
            | DisplaySettings::FluidPressure(settings)
            | DisplaySettings::Illuminance(settings)
            | DisplaySettings::RelativeHumidity(settings)
            | DisplaySettings::Temperature(settings) => &settings.topic,
            DisplaySettings::GridCells(settings) => &settings.topic,
            DisplaySettings::Range(settings) => &settings.topic,
            DisplaySettings::Marker(settings) | DisplaySettings::MarkerArray(settings) => &settings.topic,
            DisplaySettings::Path(settings) => &settings.topic,
            DisplaySettings::WrenchStamped(settings)
            | DisplaySettings::TwistStamped(settings)
            | DisplaySettings::AccelStamped(settings) => &settings.topic,
            DisplaySettings::Odometry(settings) => &settings.topic,
            DisplaySettings::PointStamped(settings) => &settings.topic,
            DisplaySettings::Polygon(settings) => &settings.topic,
            DisplaySettings::Pose(settings) => &settings.topic,
            DisplaySettings::PoseArray(settings) => &settings.topic,
            DisplaySettings::PoseWithCovariance(settings) => &settings.topic,
            DisplaySettings::DepthCloud(settings) => &settings.depth_topic,
            DisplaySettings::Map(settings) => &settings.topic,
            DisplaySettings::Image(settings) | DisplaySettings::Camera(settings) => &settings.topic,
            DisplaySettings::InteractiveMarkers(settings) => &settings.update_topic,
            DisplaySettings::Effort(settings) => &settings.topic,
            DisplaySettings::CameraPub(settings) => &settings.image_topic,
            DisplaySettings::NotDrawn { topic, .. } => return topic.as_deref(),
            DisplaySettings::RobotModel(_)
            | DisplaySettings::Grid(_)
            | DisplaySettings::Axes(_)
            | DisplaySettings::Tf(_)
            | DisplaySettings::Group(_) => return None,
        };
        Some(topic)
    }
}

/// Reads the list of displays under the key `Displays` of `section`. Their paths begin with `path`.
pub(crate) fn read_list(section: &mut Section<'_>, path: &str) -> Vec<DisplayConfig> {
    let report = section.report();
    match section.node("Displays").map(|node| (node, &node.content)) {
        Some((_, Content::List(items))) => items.iter().map(|item| read_display(item, path, report)).collect(),
        None | Some((_, Content::Null)) => Vec::new(),
        Some((node, Content::Scalar(_) | Content::Map(_))) => {
            let kind = FindingKind::InvalidValue { value: "not a list".to_owned(), used: "no displays".to_owned() };
            report.add(node.line, path, kind);
            Vec::new()
        }
    }
}

/// Reads what every display has, then hands over to the class.
fn read_display(node: &Node, group_path: &str, report: &Report) -> DisplayConfig {
    let plain = |key| match node.get(key).map(|value| &value.content) {
        Some(Content::Scalar(text)) => text.clone(),
        _ => String::new(),
    };
    let (name, class) = (plain("Name"), plain("Class"));
    let label = if name.is_empty() { &class } else { &name };
    let path = join(group_path, label);
    let mut section = Section::new(node, path, report);
    section.skip(&["Name", "Class"]);
    // rviz loads the display's own value first and the key that it calls Enabled after it.
    let mut enabled = false;
    section.bool("Value", &mut enabled);
    section.bool("Enabled", &mut enabled);
    let settings = read_class(&class, node.line, &mut section);
    section.finish();
    DisplayConfig { name, class, enabled, line: node.line, settings }
}

/// The one table from class names to readers.
fn read_class(class: &str, line: usize, section: &mut Section<'_>) -> DisplaySettings {
    match class {
        "rviz/PointCloud2" => DisplaySettings::PointCloud2(CloudSettings::read(section, CloudSettings::default())),
        "rviz/PointCloud" => DisplaySettings::PointCloud(CloudSettings::read(section, CloudSettings::default())),
        "rviz/LaserScan" => DisplaySettings::LaserScan(CloudSettings::read(section, CloudSettings::default())),
        "rviz/FluidPressure" => {
            let defaults = CloudSettings::fluid_pressure_default();
            DisplaySettings::FluidPressure(CloudSettings::read(section, defaults))
        }
        "rviz/Illuminance" => {
            let defaults = CloudSettings::illuminance_default();
            DisplaySettings::Illuminance(CloudSettings::read(section, defaults))
        }
        "rviz/RelativeHumidity" => {
            let defaults = CloudSettings::relative_humidity_default();
            DisplaySettings::RelativeHumidity(CloudSettings::read(section, defaults))
        }
        "rviz/Temperature" => {
            let defaults = CloudSettings::temperature_default();
            DisplaySettings::Temperature(CloudSettings::read(section, defaults))
        }
        "rviz/GridCells" => DisplaySettings::GridCells(GridCellsSettings::read(section)),
        "rviz/Range" => DisplaySettings::Range(RangeSettings::read(section)),
        "rviz/Grid" => DisplaySettings::Grid(GridSettings::read(section)),
        "rviz/Axes" => DisplaySettings::Axes(AxesSettings::read(section)),
        "rviz/Marker" => DisplaySettings::Marker(MarkerSettings::read(section, MarkerSettings::default())),
        "rviz/MarkerArray" => {
            let defaults = MarkerSettings::array_default();
            DisplaySettings::MarkerArray(MarkerSettings::read(section, defaults))
        }
        "rviz/Path" => DisplaySettings::Path(PathSettings::read(section)),
        "rviz/WrenchStamped" => DisplaySettings::WrenchStamped(ScrewSettings::read_wrench(section)),
        "rviz/TwistStamped" => DisplaySettings::TwistStamped(ScrewSettings::read_motion(section)),
        "rviz/AccelStamped" => DisplaySettings::AccelStamped(ScrewSettings::read_motion(section)),
        "rviz/TF" => DisplaySettings::Tf(TfSettings::read(section)),
        "rviz/Odometry" => DisplaySettings::Odometry(OdometrySettings::read(section)),
        "rviz/PointStamped" => DisplaySettings::PointStamped(PointStampedSettings::read(section)),
        "rviz/Polygon" => DisplaySettings::Polygon(PolygonSettings::read(section)),
        "rviz/Pose" => DisplaySettings::Pose(PoseSettings::read(section)),
        "rviz/PoseArray" => DisplaySettings::PoseArray(PoseArraySettings::read(section)),
        "rviz/PoseWithCovariance" => DisplaySettings::PoseWithCovariance(PoseWithCovarianceSettings::read(section)),
        "rviz/DepthCloud" => DisplaySettings::DepthCloud(DepthCloudSettings::read(section)),
        "rviz/Map" => DisplaySettings::Map(MapSettings::read(section)),
        "rviz/Image" => DisplaySettings::Image(ImageSettings::read_image(section)),
        "rviz/Camera" => DisplaySettings::Camera(ImageSettings::read_camera(section)),
        "rviz/InteractiveMarkers" => DisplaySettings::InteractiveMarkers(InteractiveMarkersSettings::read(section)),
        "rviz/RobotModel" => DisplaySettings::RobotModel(RobotModelSettings::read(section)),
        "rviz/Effort" => DisplaySettings::Effort(EffortSettings::read(section)),
        "rviz/Group" => {
            let path = section.path().to_owned();
            DisplaySettings::Group(read_list(section, &path))
        }
        "rviz_camera_stream/CameraPub" => DisplaySettings::CameraPub(CameraPubSettings::read(section)),
        _ => read_not_drawn(class, line, section),
    }
}

fn read_not_drawn(class: &str, line: usize, section: &mut Section<'_>) -> DisplaySettings {
    let known = KNOWN_NOT_DRAWN.contains(&class);
    let class = class.to_owned();
    let kind = if known { FindingKind::NotDrawnYet { class } } else { FindingKind::UnknownClass { class } };
    section.report().add(line, section.path(), kind);
    let topic = TOPIC_KEYS.iter().find_map(|key| match section.node(key).map(|node| &node.content) {
        Some(Content::Scalar(topic)) if !topic.is_empty() => Some(topic.clone()),
        _ => None,
    });
    section.skip_rest();
    DisplaySettings::NotDrawn { topic, known }
}
