//! The displays of a config: which class each is, what every display has, and the reader of each class.
//!
//! A display class has a file here with its settings, their defaults and their reading, and one row in the table
//! [`display_classes`](crate::display_classes). The modules of this folder, [`DisplaySettings`], the readers by class
//! name and the list [`classes`] are made from that table, and so are the displays that draw the classes.

pub(crate) mod covariance;
pub(crate) mod pose_symbol;
pub(crate) mod visibility;

use crate::finding::FindingKind;
use crate::node::{Content, Node};
use crate::section::{join, Property, Report, Section};

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
/// So a new class needs three things: its settings, its display, and its row here.
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
            Group              "rviz/Group"                   mod group::GroupSettings::read                             []             Group;
            Illuminance        "rviz/Illuminance"             use cloud::CloudSettings::read_illuminance                 [topic]        Scene(illuminance);
            Image              "rviz/Image"                   use image::ImageSettings::read_image                       [topic]        Window(image);
            InteractiveMarkers "rviz/InteractiveMarkers"      mod interactive_markers::InteractiveMarkersSettings::read  [update_topic] Scene(interactive_markers);
            LaserScan          "rviz/LaserScan"               use cloud::CloudSettings::read                             [topic]        Scene(laser_scan);
            Map                "rviz/Map"                     mod map::MapSettings::read                                 [topic]        Scene(map);
            Marker             "rviz/Marker"                  mod marker::MarkerSettings::read                           [topic]        Scene(marker);
            MarkerArray        "rviz/MarkerArray"             use marker::MarkerSettings::read_array                     [topic]        Scene(marker_array);
            Odometry           "rviz/Odometry"                mod odometry::OdometrySettings::read                       [topic]        Scene(odometry);
            Path               "rviz/Path"                    mod path::PathSettings::read                               [topic]        Scene(path);
            PointCloud         "rviz/PointCloud"              use cloud::CloudSettings::read                             [topic]        Scene(point_cloud);
            PointCloud2        "rviz/PointCloud2"             use cloud::CloudSettings::read                             [topic]        Scene(point_cloud2);
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
                /// The topics that the display names, that of the key `Topic` first.
                topics: Vec<String>,
            },
        }

        impl DisplaySettings {
            /// What a display of the class is for the scene.
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

/// What a display of a class is for the scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// Drawn.
    Scene,
    /// Shown in a panel of rviz's window, and not in the scene.
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
    /// As a config names it, such as `rviz/Grid`.
    pub name: &'static str,
    /// What a display of the class is for the scene.
    pub role: Role,
}

/// The properties that a class reads, in the order of reading, with their defaults. Those that every display has (its
/// name, its class, whether it is enabled) are not among them, nor are those that are accepted without effect. Empty
/// for a class that is not known.
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

/// One entry of a list of displays.
#[derive(Debug, Clone, PartialEq)]
pub struct DisplayConfig {
    /// The display's name; empty when it has none. Names need not be unique.
    pub name: String,
    /// Its class as the file writes it, such as `rviz/PointCloud2`; empty when it has none.
    pub class: String,
    /// Its own tick box. A display inside a group is drawn only if all groups around it are enabled as well. A
    /// display without either key is not enabled, as in rviz.
    pub enabled: bool,
    /// The line at which the display begins, from 1.
    pub line: usize,
    /// Its properties.
    pub settings: DisplaySettings,
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

impl DisplayConfig {
    /// The topic that the display shows, or publishes in the case of a CameraPub; `None` if it has none or it is
    /// empty.
    pub fn topic(&self) -> Option<&str> {
        self.topic_setting().filter(|topic| !topic.is_empty())
    }

    /// The same as the config has it, which may be empty; `None` for a class without topic.
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

/// What a display goes by in paths.
fn label<'a>(name: &'a str, class: &'a str) -> &'a str {
    if name.is_empty() {
        class
    } else {
        name
    }
}

/// Reports the names in the cameras' Visibility that no display has. `displays` are those of the list `node`, and `all`
/// is the whole tree.
pub(crate) fn check_visibilities(
    node: Option<&Node>,
    displays: &[DisplayConfig],
    all: &[DisplayConfig],
    path: &str,
    report: &Report,
) {
    let Some(Content::List(items)) = node.map(|node| &node.content) else { return };
    for (item, display) in items.iter().zip(displays) {
        let path = join(path, label(&display.name, &display.class));
        report.with_notes(!display.enabled, || match &display.settings {
            DisplaySettings::CameraPub(_) => {
                if let Some(visibility) = item.get("Visibility") {
                    visibility::check(visibility, &join(&path, "Visibility"), &all.iter().collect::<Vec<_>>(), report);
                }
            }
            DisplaySettings::Group(group) => {
                check_visibilities(item.get("Displays"), &group.displays, all, &path, report);
            }
            _ => {}
        });
    }
}

/// More topics than a display has; a file may hold any number.
const MOST_TOPICS: usize = 16;

/// Passes over the keys of a class that is not known, but for its topics.
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

/// Adds the topics that a display of an unknown class names: plain values of keys that end with "Topic", each once,
/// that of the key `Topic` first. Plugins put some of their topics into sections.
fn add_topics(node: &Node, topics: &mut Vec<String>) {
    let Content::Map(entries) = &node.content else { return };
    for entry in entries {
        if topics.len() == MOST_TOPICS {
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
