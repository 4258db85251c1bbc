//! Settings of display classes: their defaults and limits, and what is not read as it is written.
//!
//! That each property is read is shown by `saved_by_rviz`, and what it means by the golden cases.

use rcs_rviz_config::{
    parse, AxesSettings, CameraPubSettings, CloudSettings, DisplaySettings, GridSettings, GroupSettings,
    MarkerSettings, OdometrySettings, PathSettings, PlainColorSettings, PointStampedSettings, PoseArraySettings,
    PoseSettings, PoseWithCovarianceSettings, RangeSettings,
};
use rcs_scene::Encoding;

use super::{messages, settings, with_display};

#[test]
fn displays_without_keys_have_rvizs_defaults() {
    let defaults = [
        ("rviz/PointCloud2", DisplaySettings::PointCloud2(CloudSettings::default())),
        ("rviz/PointCloud", DisplaySettings::PointCloud(CloudSettings::default())),
        ("rviz/LaserScan", DisplaySettings::LaserScan(CloudSettings::default())),
        ("rviz/FluidPressure", DisplaySettings::FluidPressure(CloudSettings::fluid_pressure_default())),
        ("rviz/Illuminance", DisplaySettings::Illuminance(CloudSettings::illuminance_default())),
        ("rviz/RelativeHumidity", DisplaySettings::RelativeHumidity(CloudSettings::relative_humidity_default())),
        ("rviz/Temperature", DisplaySettings::Temperature(CloudSettings::temperature_default())),
        ("rviz/GridCells", DisplaySettings::GridCells(PlainColorSettings::default())),
        ("rviz/Range", DisplaySettings::Range(RangeSettings::default())),
        ("rviz/Grid", DisplaySettings::Grid(GridSettings::default())),
        ("rviz/Axes", DisplaySettings::Axes(AxesSettings::default())),
        ("rviz/Marker", DisplaySettings::Marker(MarkerSettings::default())),
        ("rviz/MarkerArray", DisplaySettings::MarkerArray(MarkerSettings::array_default())),
        ("rviz/Path", DisplaySettings::Path(PathSettings::default())),
        ("rviz/Odometry", DisplaySettings::Odometry(OdometrySettings::default())),
        ("rviz/PointStamped", DisplaySettings::PointStamped(PointStampedSettings::default())),
        ("rviz/Polygon", DisplaySettings::Polygon(PlainColorSettings::default())),
        ("rviz/Pose", DisplaySettings::Pose(PoseSettings::default())),
        ("rviz/PoseArray", DisplaySettings::PoseArray(PoseArraySettings::default())),
        ("rviz/PoseWithCovariance", DisplaySettings::PoseWithCovariance(PoseWithCovarianceSettings::default())),
        ("rviz/Group", DisplaySettings::Group(GroupSettings::default())),
        ("rviz_camera_stream/CameraPub", DisplaySettings::CameraPub(CameraPubSettings::default())),
    ];
    for (class, expected) in defaults {
        let config = with_display(class, "");
        assert_eq!(*settings(&config), expected);
        assert_eq!(messages(&config), [""; 0]);
    }
}

#[test]
fn numbers_have_the_limits_of_their_class() {
    for (class, keys, used) in [
        ("rviz/GridCells", "Alpha: 1.5", Some("1")),
        ("rviz/Range", "Alpha: 1.5", None),
        ("rviz/PointStamped", "History Length: 200000", Some("100000")),
        ("rviz/WrenchStamped", "History Length: 1000000", Some("100000")),
        ("rviz/TwistStamped", "History Length: 1000000", Some("100000")),
        ("rviz/AccelStamped", "History Length: 1000000", Some("100000")),
    ] {
        let found = messages(&with_display(class, keys));
        assert_eq!(found.len(), usize::from(used.is_some()), "{class}: {found:?}");
        assert!(used.is_none_or(|used| found[0].ends_with(&format!(", using {used}"))), "{class}: {found:?}");
    }
}

#[test]
fn the_symbols_of_an_odometry_lie_inside_of_its_shape() {
    // rviz does not find the symbol's keys beside Shape, where they were long ago.
    let config = with_display("rviz/Odometry", "Shape: Arrow\nShaft Length: 3");
    assert_eq!(*settings(&config), DisplaySettings::Odometry(OdometrySettings::default()));
    assert_eq!(messages(&config).len(), 1);
}

#[test]
fn covariances_are_switched_off_as_a_whole_or_in_parts() {
    for (keys, position, orientation) in [
        ("Covariance: false", false, false),
        ("Covariance: {Value: false, Position: {Value: true}}", false, false),
        ("Covariance: {Position: false}", false, true),
        ("Covariance: {Orientation: {Value: false}}", true, false),
    ] {
        let config = with_display("rviz/PoseWithCovariance", keys);
        let DisplaySettings::PoseWithCovariance(pose) = settings(&config) else { panic!() };
        let shown = (pose.covariance.position.is_some(), pose.covariance.orientation.is_some());
        assert_eq!(shown, (position, orientation), "{keys}");
    }
}

#[test]
fn every_property_of_camera_pub_is_read() {
    for (name, encoding) in [
        ("rgb8", Encoding::Rgb8),
        ("rgba8", Encoding::Rgba8),
        ("bgr8", Encoding::Bgr8),
        ("bgra8", Encoding::Bgra8),
        ("mono8", Encoding::Mono8),
        ("mono16", Encoding::Mono16),
    ] {
        let keys = format!(
            "Image Topic: /i\nCamera Info Topic: /c\nDisplay namespace: left\nQueue Size: 4\n\
             Frame Rate: 12.5\nBackground Color: 10; 20; 30\nImage Encoding: {name}\n\
             Near Clip Distance: 0.5\nProjection: exact\nUndistort: true\nDepth Topic: /d\n\
             Headless Twin: /tmp/a.rviz\nVisibility: {{Value: true, a: false}}"
        );
        let config = with_display("rviz_camera_stream/CameraPub", &keys);
        assert!(messages(&config).iter().all(|message| message.contains("/ Visibility / a: no display")));
        let DisplaySettings::CameraPub(camera) = settings(&config) else {
            panic!("a CameraPub");
        };
        assert!(!camera.visibility.shows(&["a"]) && camera.visibility.shows(&["b"]));
        let expected = CameraPubSettings {
            image_topic: "/i".to_owned(),
            camera_info_topic: "/c".to_owned(),
            display_namespace: "left".to_owned(),
            queue_size: 4,
            frame_rate_hz: 12.5,
            background_color: [10, 20, 30],
            image_encoding: encoding,
            near_clip_m: 0.5,
            is_exact: true,
            undistort: true,
            depth_topic: "/d".to_owned(),
            visibility: camera.visibility.clone(),
        };
        assert_eq!(*camera, expected);
        assert_eq!(encoding.name(), name);
    }
}

#[test]
fn frames_are_switched_off_one_by_one_and_a_plain_value_counts_as_off() {
    let frames = "Frames:\n  All Enabled: false\n  a: {Value: true}\n  b: {Value: false}\n  c: true\n  d: {}";
    let config = with_display("rviz/TF", &format!("{frames}\nFrame Timeout: 0.5\nTree:\n  a:\n    b: {{}}"));
    let DisplaySettings::Tf(tf) = settings(&config) else { panic!() };
    assert_eq!(tf.hidden_frames.iter().collect::<Vec<_>>(), ["b", "c", "d"]);
    assert_eq!(tf.frame_timeout_s, 1.0);
    let found = messages(&config).join("\n");
    assert!(found.contains("Frames / c: ") && found.contains("Frame Timeout: invalid value"), "{found}");
    assert_eq!(config.findings.len(), 2, "{found}");
}

#[test]
fn interactive_markers_know_with_which_tool_rviz_starts() {
    for (tools, enabled) in [
        ("Tools: [{Class: rviz/Interact, Hide Inactive Objects: true}, {Class: rviz/MoveCamera}]", true),
        ("Tools: [{Class: rviz/MoveCamera}, {Class: rviz/Interact}]", false),
        ("Tools: []", false),
        ("Tools: {Class: rviz/Interact}", false),
        ("", false),
    ] {
        let text = format!(
            "Visualization Manager:\n  Displays:\n  - Class: rviz/Group\n    Displays:\n    \
             - {{Class: rviz/InteractiveMarkers, Update Topic: /a/update_full, Show Axes: true}}\n  {tools}\n"
        );
        let config = parse(&text, "t").unwrap();
        assert_eq!(messages(&config), [""; 0], "{tools}");
        let placed = config.placed_displays();
        let DisplaySettings::InteractiveMarkers(settings) = &placed[1].display.settings else { panic!("{placed:?}") };
        let expected = rcs_rviz_config::InteractiveMarkersSettings {
            update_topic: "/a/update_full".to_owned(),
            show_axes: true,
            interaction_enabled: enabled,
            ..rcs_rviz_config::InteractiveMarkersSettings::default()
        };
        assert_eq!(*settings, expected, "{tools}");
        assert_eq!(settings.namespace(), Some("/a"));
    }
}
