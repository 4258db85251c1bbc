//! The displays of a config: their class, the properties that all have, and the reader of each class.
//!
//! A display class has a file here with its settings, and one row in the table
//! [`display_classes`](crate::display_classes). The modules of this folder, [`DisplaySettings`], the readers by class
//! name and the list [`classes`] are made from that table, and so are the displays that draw the classes.

pub(crate) mod covariance;
pub(crate) mod line_style;
pub(crate) mod pose_symbol;
pub(crate) mod visibility;

use crate::finding::FindingKind;
use crate::node::{Content, Node};
use crate::report::{Property, Report};
use crate::section::{join, Properties, Section};

/// The table of display classes: `display_classes!(callback)` calls the macro `callback` with its rows.
///
/// Each row has
///
/// - the name of its [`DisplaySettings`] variant and the class as a config names it;
/// - its settings' module in `rviz_config/src/displays` (`mod` declares the module, `use` takes that of another row),
///   the type of the settings and the function that reads them;
/// - in brackets the field of the settings that holds its topic, if there is one;
/// - its [`Role`], and in parentheses its module in `displays/src/classes`, which has the function
///   `create(DisplayId, &Settings) -> Box<dyn Display>`.
///
/// A new class needs its settings, its display, and its row here.
#[rustfmt::skip]
#[macro_export]
macro_rules! display_classes {
    ($callback:ident) => {
        $callback! {
            AccelStamped       "rviz/AccelStamped"            mod screw::ScrewSettings::read_motion                      [topic]        Scene(accel_stamped);
            Axes               "rviz/Axes"                    mod axes::AxesSettings::read                               []             Scene(axes);
            Camera             "rviz/Camera"                  mod image::ImageSettings::read_camera                      [topic]        Window(camera);
            DepthCloud         "rviz/DepthCloud"              mod depth_cloud::DepthCloudSettings::read                  [depth_topic]  Scene(depth_cloud);
            Effort             "rviz/Effort"                  mod effort::EffortSettings::read                           [topic]        Scene(effort);
            FluidPressure      "rviz/FluidPressure"           mod cloud::CloudSettings::read_fluid_pressure              [topic]        Scene(fluid_pressure);
            Grid               "rviz/Grid"                    mod grid::GridSettings::read                               []             Scene(grid);
            GridCells          "rviz/GridCells"               mod plain_color::PlainColorSettings::read                  [topic]        Scene(grid_cells);
            Group              "rviz/Group"                   use self::GroupSettings::read                              []             Group;
            Illuminance        "rviz/Illuminance"             use cloud::CloudSettings::read_illuminance                 [topic]        Scene(illuminance);
            Image              "rviz/Image"                   use image::ImageSettings::read_image                       [topic]        Window(image);
            InteractiveMarkers "rviz/InteractiveMarkers"      mod interactive_markers::InteractiveMarkersSettings::read  [update_topic] Scene(interactive_markers);
            LaserScan          "rviz/LaserScan"               use cloud::CloudSettings::read_cloud                       [topic]        Scene(laser_scan);
            Map                "rviz/Map"                     mod map::MapSettings::read                                 [topic]        Scene(map);
            Marker             "rviz/Marker"                  mod marker::MarkerSettings::read                           [topic]        Scene(marker);
            MarkerArray        "rviz/MarkerArray"             use marker::MarkerSettings::read_array                     [topic]        Scene(marker_array);
            Odometry           "rviz/Odometry"                mod odometry::OdometrySettings::read                       [topic]        Scene(odometry);
            Path               "rviz/Path"                    mod path::PathSettings::read                               [topic]        Scene(path);
            PointCloud         "rviz/PointCloud"              use cloud::CloudSettings::read_cloud                       [topic]        Scene(point_cloud);
            PointCloud2        "rviz/PointCloud2"             use cloud::CloudSettings::read_cloud                       [topic]        Scene(point_cloud2);
            PointStamped       "rviz/PointStamped"            mod point_stamped::PointStampedSettings::read              [topic]        Scene(point_stamped);
            Polygon            "rviz/Polygon"                 use plain_color::PlainColorSettings::read                  [topic]        Scene(polygon);
            Pose               "rviz/Pose"                    mod pose::PoseSettings::read                               [topic]        Scene(pose);
            PoseArray          "rviz/PoseArray"               mod pose_array::PoseArraySettings::read                    [topic]        Scene(pose_array);
            PoseWithCovariance "rviz/PoseWithCovariance"      mod pose_with_covariance::PoseWithCovarianceSettings::read [topic]        Scene(pose_with_covariance);
            Range              "rviz/Range"                   mod range::RangeSettings::read                             [topic]        Scene(range);
            RelativeHumidity   "rviz/RelativeHumidity"        use cloud::CloudSettings::read_relative_humidity           [topic]        Scene(relative_humidity);
            RobotModel         "rviz/RobotModel"              mod robot_model::RobotModelSettings::read                  []             Scene(robot_model);
            Tf                 "rviz/TF"                      mod tf::TfSettings::read                                   []             Scene(tf);
            Temperature        "rviz/Temperature"             use cloud::CloudSettings::read_temperature                 [topic]        Scene(temperature);
            TwistStamped       "rviz/TwistStamped"            use screw::ScrewSettings::read_motion                      [topic]        Scene(twist_stamped);
            WrenchStamped      "rviz/WrenchStamped"           use screw::ScrewSettings::read_wrench                      [topic]        Scene(wrench_stamped);
            CameraPub          "rviz_camera_stream/CameraPub" mod camera_pub::CameraPubSettings::read                    [image_topic]  Camera;
        }
    };
}

macro_rules! define_classes {
    ($(
        $variant:ident $class:literal $declare:tt $module:ident::$settings:ident::$read:ident [$($topic:ident)?] $role:ident $(($display:ident))?;
    )*) => {
        $(declare_module! { $declare $module })*

        /// The properties of a display by class.
        #[derive(Debug, Clone, PartialEq)]
        pub enum DisplaySettings {
            $(
                #[doc = concat!("`", $class, "`")]
                $variant($settings),
            )*
            /// A class that is not known, and not drawn.
            Unknown {
                /// The topics that the display names, the value of `Topic` first.
                topics: Vec<String>,
            },
        }

        impl DisplaySettings {
            /// Role of the class in the scene.
            pub fn role(&self) -> Role {
                match self {
                    $(Self::$variant(_) => Role::$role,)*
                    Self::Unknown { .. } => Role::Unknown,
                }
            }

            /// The topic as the config has it, which may be empty; `None` for a class without topic.
            fn topic(&self) -> Option<&str> {
                match self {
                    $($(Self::$variant(settings) => Some(&settings.$topic),)?)*
                    Self::Unknown { topics } => topics.first().map(String::as_str),
                    _ => None,
                }
            }
        }

        /// Reads the properties of a class; `None` for one that is not known.
        fn read_class(class: &str, section: &mut Section<'_>) -> Option<DisplaySettings> {
            match class {
                $($class => Some(DisplaySettings::$variant($settings::$read(section))),)*
                _ => None,
            }
        }

        /// All display classes, sorted by name.
        ///
        /// ```
        /// let names: Vec<&str> = rcs_rviz_config::classes().iter().map(|class| class.name).collect();
        /// assert!(names.contains(&"rviz/PointCloud2") && names.is_sorted());
        /// ```
        pub fn classes() -> &'static [ClassInfo] {
            &[$(ClassInfo { name: $class, role: Role::$role },)*]
        }
    };
}

macro_rules! declare_module {
    (mod $module:ident) => {
        pub(crate) mod $module;
        pub use $module::*;
    };
    (use $module:ident) => {};
}

display_classes!(define_classes);

/// Role of a display class in the scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// Drawn.
    Scene,
    /// A panel of rviz's window, not part of the scene.
    Window,
    /// Holds other displays.
    Group,
    /// Draws the scene.
    Camera,
    /// Not known, so nothing is drawn.
    Unknown,
}

/// A display class.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ClassInfo {
    /// The name in a config, such as `rviz/Grid`.
    pub name: &'static str,
    /// Role of the class in the scene.
    pub role: Role,
}

/// The properties that a class reads, with their defaults; empty for an unknown class. Properties of every display
/// (name, class, enabled) are not among them, nor are those that are accepted without effect.
///
/// ```
/// let properties = rcs_rviz_config::properties("rviz/Axes");
/// let length = properties.iter().find(|property| property.key == "Length").unwrap();
/// assert_eq!(length.default, "1");
/// ```
pub fn properties(class: &str) -> Vec<Property> {
    let report = Report::recording();
    read_class(class, &mut Section::empty(String::new(), &report));
    report.into_properties()
}

/// The displays of a `rviz/Group`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct GroupSettings {
    /// The displays, in the file's order.
    pub displays: Vec<DisplayConfig>,
}

impl GroupSettings {
    fn read(section: &mut Section<'_>) -> Self {
        let path = section.path().to_owned();
        GroupSettings { displays: read_list(section, &path) }
    }
}

/// One entry of a list of displays.
#[derive(Debug, Clone, PartialEq)]
pub struct DisplayConfig {
    /// The display's name; empty when it has none. Names need not be unique.
    pub name: String,
    /// The class as the file writes it, such as `rviz/PointCloud2`; empty when it has none.
    pub class: String,
    /// The display's own tick box; unticked without a key, as in rviz. A display inside a group is drawn only if all
    /// groups around it are enabled as well.
    pub enabled: bool,
    /// The line at which the display begins, from 1.
    pub line: usize,
    /// Its properties.
    pub settings: DisplaySettings,
}

impl DisplayConfig {
    /// The topic that the display subscribes to, or a CameraPub publishes; `None` if it has none or it is empty.
    pub fn topic(&self) -> Option<&str> {
        self.topic_setting().filter(|topic| !topic.is_empty())
    }

    /// The topic as the config has it, which may be empty; `None` for a class without topic.
    pub fn topic_setting(&self) -> Option<&str> {
        self.settings.topic()
    }
}

/// Reads the list of displays under the key `Displays` of `section`. Their paths begin with `path`.
pub(crate) fn read_list(section: &mut Section<'_>, path: &str) -> Vec<DisplayConfig> {
    let report = section.report();
    match section.node("Displays").map(|node| (node, &node.content)) {
        Some((_, Content::List(items))) => items.iter().map(|item| read_display(item, path, report)).collect(),
        None | Some((_, Content::Null)) => Vec::new(),
        Some((node, Content::Scalar(_) | Content::Map(_))) => {
            report.add_invalid(node.line, path, "not a list", "no displays");
            Vec::new()
        }
    }
}

/// Reads what every display has, then hands over to the class.
fn read_display(node: &Node, group_path: &str, report: &Report) -> DisplayConfig {
    let plain = |key| node.get(key).and_then(Node::scalar).unwrap_or_default().to_owned();
    let (name, class) = (plain("Name"), plain("Class"));
    let path = join(group_path, label(&name, &class));
    let mut section = Section::new(node, path, report);
    section.skip(&["Name", "Class"]);
    // rviz loads the display's own value first and the key that it calls Enabled after it.
    let mut enabled = false;
    section.bool("Value", &mut enabled);
    section.bool("Enabled", &mut enabled);
    let settings = report.with_notes(!enabled, || {
        let settings = read_class(&class, &mut section);
        let settings = settings.unwrap_or_else(|| read_unknown(&class, node, &mut section));
        section.finish();
        settings
    });
    DisplayConfig { name, class, enabled, line: node.line, settings }
}

/// The name of a display in paths.
pub(crate) fn label<'a>(name: &'a str, class: &'a str) -> &'a str {
    if name.is_empty() {
        class
    } else {
        name
    }
}

/// Most topics that are listed of a display of an unknown class.
const MAX_TOPICS: usize = 16;

/// Skips the keys of an unknown class, except for its topics.
fn read_unknown(class: &str, display: &Node, section: &mut Section<'_>) -> DisplaySettings {
    let mut topics = Vec::new();
    add_topics(display, &mut topics);
    let kind = match class {
        "" => FindingKind::UnknownClass { class: String::new() },
        _ => FindingKind::PluginDisplay { class: class.to_owned(), topics: topics.clone() },
    };
    section.report().add(display.line, section.path(), kind);
    section.skip_rest();
    DisplaySettings::Unknown { topics }
}

/// Adds the topics of a display of an unknown class: plain values of keys that end with "Topic", each once, the value
/// of `Topic` first. Plugins put some of their topics into sections.
fn add_topics(node: &Node, topics: &mut Vec<String>) {
    for entry in node.entries() {
        if topics.len() == MAX_TOPICS {
            return;
        }
        match &entry.value.content {
            Content::Scalar(topic) if entry.key.ends_with("Topic") && !topic.is_empty() && !topics.contains(topic) => {
                let place = if entry.key == "Topic" { 0 } else { topics.len() };
                topics.insert(place, topic.clone());
            }
            Content::Map(_) => add_topics(&entry.value, topics),
            _ => {}
        }
    }
}
