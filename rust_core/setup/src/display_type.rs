//! The message types that can be projected: the rviz display of each, as rviz adds it by topic, with sizes and colours
//! for a projector instead of a screen.

/// A message type and its display.
#[derive(Debug, PartialEq)]
pub(crate) struct DisplayType {
    /// Message type, `package/Name`.
    pub(crate) ros_type: &'static str,
    /// Class of the display.
    pub(crate) class: &'static str,
    /// Property that holds the topic.
    pub(crate) topic_key: &'static str,
    /// Further properties as `Key: value`; `COLOR` stands for the display's colour.
    pub(crate) properties: &'static [&'static str],
    /// `true` for what is usually sent when it changes, not periodically.
    pub(crate) is_event: bool,
    /// `true` for what programs compute, unlike what sensors measure: projected unless the user chooses otherwise.
    pub(crate) is_result: bool,
}

const CLOUD: &[&str] = &[
    "Style: Flat Squares",
    "Size (m): 0.01",
    "Position Transformer: XYZ",
    "Color Transformer: FlatColor",
    "Color: COLOR",
    "Alpha: 1",
    "Decay Time: 0",
    "Queue Size: 10",
];
const MARKERS: &[&str] = &["Namespaces: {}", "Queue Size: 100"];
const PATH: &[&str] = &[
    "Line Style: Billboards",
    "Line Width: 0.05",
    "Color: COLOR",
    "Alpha: 1",
    "Buffer Length: 1",
    "Pose Style: None",
    "Queue Size: 10",
];
const ARROW: &[&str] = &[
    "Shape: Arrow",
    "Color: COLOR",
    "Alpha: 1",
    "Shaft Length: 0.2",
    "Shaft Radius: 0.015",
    "Head Length: 0.08",
    "Head Radius: 0.04",
    "Queue Size: 10",
];
const ARROWS: &[&str] = &["Shape: Arrow (Flat)", "Arrow Length: 0.2", "Color: COLOR", "Alpha: 1", "Queue Size: 10"];
const PLAIN: &[&str] = &["Color: COLOR", "Alpha: 1", "Queue Size: 10"];
const POINT: &[&str] = &["Radius: 0.03", "History Length: 1", "Color: COLOR", "Alpha: 1", "Queue Size: 10"];
const RANGE: &[&str] = &["Color: COLOR", "Alpha: 1", "Buffer Length: 1", "Queue Size: 100"];
const ODOMETRY: &[&str] = &[
    "Keep: 1",
    "Covariance: {Value: false}",
    "Shape: {Value: Arrow, Color: COLOR, Alpha: 1, Shaft Length: 0.2, Shaft Radius: 0.015, Head Length: 0.08, Head Radius: 0.04}",
    "Queue Size: 10",
];
const MAP: &[&str] = &["Alpha: 1", "Color Scheme: map", "Draw Behind: false"];

/// A row of [`DISPLAY_TYPES`].
const fn row(
    ros_type: &'static str,
    class: &'static str,
    properties: &'static [&'static str],
    is_event: bool,
    is_result: bool,
) -> DisplayType {
    DisplayType { ros_type, class, topic_key: "Topic", properties, is_event, is_result }
}

/// All types, the most used first.
pub(crate) const DISPLAY_TYPES: [DisplayType; 15] = [
    row("sensor_msgs/PointCloud2", "rviz/PointCloud2", CLOUD, false, true),
    DisplayType {
        topic_key: "Marker Topic",
        ..row("visualization_msgs/MarkerArray", "rviz/MarkerArray", MARKERS, true, true)
    },
    DisplayType { topic_key: "Marker Topic", ..row("visualization_msgs/Marker", "rviz/Marker", MARKERS, true, true) },
    row("nav_msgs/Path", "rviz/Path", PATH, true, true),
    row("nav_msgs/OccupancyGrid", "rviz/Map", MAP, true, false),
    row("geometry_msgs/PoseStamped", "rviz/Pose", ARROW, true, false),
    row("geometry_msgs/PoseArray", "rviz/PoseArray", ARROWS, false, true),
    row("geometry_msgs/PoseWithCovarianceStamped", "rviz/PoseWithCovariance", ARROW, false, false),
    row("geometry_msgs/PointStamped", "rviz/PointStamped", POINT, true, false),
    row("geometry_msgs/PolygonStamped", "rviz/Polygon", PLAIN, false, true),
    row("nav_msgs/GridCells", "rviz/GridCells", PLAIN, false, false),
    row("nav_msgs/Odometry", "rviz/Odometry", ODOMETRY, false, false),
    row("sensor_msgs/LaserScan", "rviz/LaserScan", CLOUD, false, false),
    row("sensor_msgs/PointCloud", "rviz/PointCloud", CLOUD, false, true),
    row("sensor_msgs/Range", "rviz/Range", RANGE, false, false),
];

/// Colours of displays, one after the other: bright ones, which a projector shows well.
const COLORS: [&str; 5] = ["255; 255; 255", "0; 255; 0", "0; 255; 255", "255; 255; 0", "255; 0; 255"];

/// The colour of a display by its place in the list of those that have one.
pub(crate) fn color(index: usize) -> &'static str {
    COLORS.get(index % COLORS.len()).copied().unwrap_or_default()
}

/// The type with a name, `package/Name` or `Name` alone.
///
/// # Errors
/// The known types.
pub(crate) fn find(name: &str) -> Result<&'static DisplayType, String> {
    let is_named = |display: &&DisplayType| display.ros_type == name || short_name(display) == name;
    DISPLAY_TYPES.iter().find(is_named).ok_or_else(|| {
        let names: Vec<&str> = DISPLAY_TYPES.iter().map(short_name).collect();
        format!("type '{name}' has no display here; choose one of {}", names.join(", "))
    })
}

/// The type's name without its package.
pub(crate) fn short_name(display: &DisplayType) -> &'static str {
    display.ros_type.split_once('/').map_or(display.ros_type, |(_, name)| name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_type_is_found_with_and_without_its_package() {
        assert_eq!(find("sensor_msgs/PointCloud2"), find("PointCloud2"));
        assert_eq!(find("Path").unwrap().class, "rviz/Path");
        let error = find("Joy").unwrap_err();
        assert!(error.starts_with("type 'Joy' has no display here; choose one of PointCloud2, MarkerArray"), "{error}");
    }

    #[test]
    fn every_type_is_a_message_that_its_display_takes() {
        for display in &DISPLAY_TYPES {
            assert!(rcs_messages::MessageKind::from_ros_type(display.ros_type).is_some(), "{display:?}");
            assert!(!rcs_rviz_config::properties(display.class).is_empty(), "{display:?}");
        }
    }
}
