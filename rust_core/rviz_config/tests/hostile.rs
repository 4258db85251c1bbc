//! Hostile files: reading ends without a panic and with values in their ranges.

use proptest::prelude::*;
use rcs_rviz_config::{parse, Config, DisplayConfig, DisplaySettings};
use rcs_scene::PointStyle;

/// A config that uses every class and most keys.
const CONFIG: &str = r#"Panels: [{Class: rviz/Time, SyncMode: 0, SyncSource: c}]
Visualization Manager:
  Class: ""
  Displays:
    - {Class: rviz/Grid, Name: Grid, Enabled: true, Cell Size: 0.5, Color: 1; 2; 3, Plane: XZ,
       Offset: {X: 1, Y: 2, Z: 3}, Line Style: {Value: Billboards, Line Width: 0.1}, Alpha: 0.5}
    - Class: rviz/Group
      Name: g
      Enabled: true
      Displays:
        - &cloud
          Class: rviz/PointCloud2
          Name: c
          Topic: /c
          Size (Pixels): 3
          Size (m): 0.02
          Queue Size: 5
          Color Transformer: Intensity
          Autocompute Value Bounds: {Value: false, Min Value: -1, Max Value: 1}
        - *cloud
        - {Class: rviz/Axes, Name: a, Length: 0.3, Radius: 0.01}
    - {Class: rviz/Path, Name: p, Topic: /p, Buffer Length: 2, Pose Style: Axes, Line Width: 0.01}
    - {Class: rviz/MarkerArray, Name: m, Marker Topic: /m, Namespaces: {"": true, b: false}}
    - {Class: rviz/TF, Name: TF, Frames: {All Enabled: true}, "Filter (whitelist)": "^(a|[[:digit:]]{2,3}b*)"}
    - Class: rviz_camera_stream/CameraPub
      Name: cam
      Enabled: true
      Near Clip Distance: 0.2
      Frame Rate: 10
      Queue Size: 3
      Visibility: {Value: true, Grid: false, g: {Value: true, c: false}}
  Enabled: true
  Global Options: {Fixed Frame: map, Frame Rate: 30, Background Color: 48; 48; 48}
  Views:
    Current: {Class: rviz/Orbit, Distance: 4, Pitch: 0.6, Yaw: 5.8, Target Frame: base}
"#;

/// Pieces that YAML and the readers treat in special ways.
const PIECES: [&str; 36] = [
    "- ",
    ": ",
    "\n",
    "  ",
    "    ",
    "[",
    "]",
    "{",
    "}",
    ", ",
    "? ",
    "&a ",
    "*a",
    "!!str ",
    "| ",
    ">\n",
    "\"",
    "'",
    "#",
    "~",
    "%",
    "@",
    "`",
    "---\n",
    "...\n",
    "<<: ",
    "\t",
    "\r\n",
    "\0",
    "\u{feff}",
    "é",
    "Displays",
    "Class",
    "Visualization Manager",
    "rviz/Group",
    "nan",
];

fn check_style(style: &PointStyle) {
    let (size, smallest) = match *style {
        PointStyle::Points { diameter_px } => (diameter_px, 1.0),
        PointStyle::FlatSquares { side_m } => (side_m, 0.0001),
        PointStyle::Squares { size_m: [side_m, _] }
        | PointStyle::Spheres { size_m: [side_m, _] }
        | PointStyle::Boxes { size_m: [side_m, ..] } => (side_m, 0.0001),
        PointStyle::Tiles { .. } => panic!("no config names tiles"),
    };
    assert!(size.is_finite() && size >= smallest);
}

fn check_display(display: &DisplayConfig) {
    match &display.settings {
        DisplaySettings::PointCloud2(cloud)
        | DisplaySettings::PointCloud(cloud)
        | DisplaySettings::LaserScan(cloud)
        | DisplaySettings::FluidPressure(cloud)
        | DisplaySettings::Illuminance(cloud)
        | DisplaySettings::RelativeHumidity(cloud)
        | DisplaySettings::Temperature(cloud) => {
            check_style(&cloud.style);
            assert!((0.0..=1.0).contains(&cloud.alpha) && cloud.decay_time_secs >= 0.0);
            assert!(cloud.intensity.min.is_finite() && cloud.axis_color.max.is_finite());
        }
        DisplaySettings::Grid(grid) => {
            assert!(grid.plane_cell_count >= 1 && grid.cell_size_m >= 0.0001);
            assert!(grid.line_width_m >= 0.001 && (0.0..=1.0).contains(&grid.alpha));
            assert!(grid.offset_m.iter().all(|value| value.is_finite()));
        }
        DisplaySettings::Axes(axes) => {
            assert!(axes.length_m >= 0.0001 && axes.radius_m >= 0.0001);
        }
        DisplaySettings::Path(path) => {
            assert!(path.buffer_length >= 1 && path.line_width_m >= 0.001);
            assert!(path.alpha.is_finite() && path.arrow.head_length_m.is_finite());
        }
        DisplaySettings::WrenchStamped(screw)
        | DisplaySettings::TwistStamped(screw)
        | DisplaySettings::AccelStamped(screw) => {
            assert!((1..=100_000).contains(&screw.history_length));
            assert!(screw.width_m.is_finite() && screw.linear_scale.is_finite() && screw.angular_scale.is_finite());
        }
        DisplaySettings::Tf(tf) => {
            assert!((0.0..=1.0).contains(&tf.marker_alpha) && tf.marker_scale.is_finite());
            assert!(tf.frame_timeout_s >= 1.0 && tf.update_interval_s >= 0.0 && tf.update_interval_s.is_finite());
        }
        DisplaySettings::DepthCloud(depth) => {
            assert!(depth.auto_size_factor >= 0.0001 && depth.occlusion_timeout_secs.is_finite());
            assert!(depth.cloud.queue_size >= 1);
            check_style(&depth.cloud.style);
        }
        settings => check_small_display(settings),
    }
}

fn check_small_display(settings: &DisplaySettings) {
    match settings {
        DisplaySettings::Map(map) => assert!((0.0..=1.0).contains(&map.alpha)),
        DisplaySettings::CameraPub(camera) => {
            assert!(camera.near_clip_m >= 0.01 && camera.near_clip_m.is_finite());
            assert!(camera.frame_rate_hz >= -1.0 && camera.queue_size >= 1);
        }
        DisplaySettings::RobotModel(robot) => {
            assert!((0.0..=1.0).contains(&robot.alpha) && robot.update_interval_secs >= 0.0);
        }
        DisplaySettings::Effort(effort) => {
            assert!((1..=100_000).contains(&effort.history_length) && effort.width_m.is_finite());
        }
        DisplaySettings::GridCells(cells) => assert!((0.0..=1.0).contains(&cells.alpha)),
        DisplaySettings::Range(range) => assert!(range.buffer_length >= 1 && range.alpha.is_finite()),
        DisplaySettings::Odometry(odometry) => {
            assert!(odometry.position_tolerance_m >= 0.0 && odometry.angle_tolerance_rad >= 0.0);
            assert!(odometry.covariance.position.iter().all(|position| position.scale >= 0.0));
        }
        DisplaySettings::PointStamped(points) => {
            assert!((1..=100_000).contains(&points.history_length) && points.radius_m.is_finite());
        }
        DisplaySettings::PoseArray(poses) => assert!((0.0..=1.0).contains(&poses.alpha)),
        _ => {}
    }
}

fn check(text: &str) -> Option<Config> {
    let config = match parse(text, "hostile.rviz") {
        Ok(config) => config,
        Err(error) => {
            assert!(error.to_string().starts_with("hostile.rviz"));
            return None;
        }
    };
    for placed in config.placed_displays() {
        check_display(placed.display);
    }
    let length: f64 = config.view.direction_in_fixed_frame([0.5, 0.5, 0.5, 0.5]).iter().map(|x| x * x).sum();
    assert!((length - 1.0).abs() < 1e-6);
    let lines = text.replace("\r\n", "\n").split(['\n', '\r']).count();
    for finding in &config.findings {
        assert!((1..=lines).contains(&finding.line), "{finding:?}");
        assert_eq!(finding.to_string().lines().count(), 1);
    }
    assert!(config.findings.is_sorted_by_key(|finding| finding.line));
    Some(config)
}

fn piece() -> impl Strategy<Value = String> {
    prop_oneof![
        3 => prop::sample::select(PIECES.as_slice()).prop_map(str::to_owned),
        1 => "[a-z0-9;. -]{0,6}",
        1 => any::<char>().prop_map(String::from),
    ]
}

/// Any YAML tree as text in flow style, with the names and values that the readers know.
fn tree() -> impl Strategy<Value = String> {
    let names = [
        "Displays",
        "Class",
        "Name",
        "Value",
        "Enabled",
        "Visibility",
        "Views",
        "Current",
        "Offset",
        "X",
        "Y",
        "Z",
        "Line Style",
        "Namespaces",
        "Autocompute Value Bounds",
        "Alpha",
        "Color",
        "Queue Size",
        "Target Frame",
        "Global Options",
        "Yaw",
        "Position",
    ];
    let values = [
        "rviz/Grid",
        "rviz/Group",
        "rviz/PointCloud2",
        "rviz/Path",
        "rviz/Marker",
        "rviz/FPS",
        "rviz/FrameAligned",
        "rviz_camera_stream/CameraPub",
        "~",
        "''",
        "true",
        "no",
        "-1",
        "1e39",
        "nan",
        "-inf",
        "1; 2; 3",
        "'#ffff'",
        "999999999999",
        "1.234,5",
    ];
    let leaf = prop::sample::select(values.to_vec()).prop_map(str::to_owned);
    leaf.prop_recursive(6, 64, 8, move |inner| {
        let key = prop::sample::select(names.to_vec());
        let entry = (key, inner.clone()).prop_map(|(key, value)| format!("{key}: {value}"));
        prop_oneof![
            1 => prop::collection::vec(inner, 0..4).prop_map(|items| format!("[{}]", items.join(", "))),
            4 => prop::collection::vec(entry, 0..8).prop_map(|entries| format!("{{{}}}", entries.join(", "))),
        ]
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_text_is_read_or_refused(text in any::<String>()) {
        check(&text);
    }

    #[test]
    fn any_sequence_of_yamls_signs_is_read_or_refused(pieces in prop::collection::vec(piece(), 0..40)) {
        check(&pieces.concat());
        check(&format!("Visualization Manager:\n  Displays:\n  - {}", pieces.concat()));
    }

    #[test]
    fn any_tree_is_read(tree in tree(), name in "[A-Z][a-z]{0,8}") {
        let text = format!("Visualization Manager: {{Displays: [{tree}], Views: {{Current: {tree}}}, {name}: {tree}}}");
        prop_assert!(check(&text).is_some());
        check(&format!("Visualization Manager: {tree}"));
    }

    #[test]
    fn a_config_with_a_piece_put_in_or_cut_out_is_read_or_refused(
        edits in prop::collection::vec((any::<prop::sample::Index>(), 0..12_usize, piece()), 1..6)
    ) {
        let mut chars: Vec<char> = CONFIG.chars().collect();
        for (at, cut, put) in edits {
            let start = at.index(chars.len());
            let end = (start + cut).min(chars.len());
            chars.splice(start..end, put.chars());
        }
        check(&chars.into_iter().collect::<String>());
    }

    #[test]
    fn lines_in_any_order_are_read_or_refused(lines in Just(CONFIG.lines().collect::<Vec<_>>()).prop_shuffle()) {
        check(&lines.join("\n"));
    }

    #[test]
    fn values_in_range_are_read_as_written(
        alpha in 0.0..=1.0_f32, size_m in 0.0001..1e6_f32, size_px in 1.0..1e4_f32, min in any::<i16>(),
        color in any::<[u8; 3]>(), queue_size in 0..10_000_u32, x in -1e6..1e6_f32,
    ) {
        let [r, g, b] = color;
        let text = format!(
            "Visualization Manager:\n  Displays:\n  - {{Class: rviz/PointCloud2, Alpha: {alpha}, Size (m): {size_m}, \
             Size (Pixels): {size_px}, Min Intensity: {min}, Color: {r}; {g}; {b}, Queue Size: {queue_size}}}\n  \
             - {{Class: rviz/Grid, Offset: {{X: {x}, Y: -1e-3, Z: 7}}}}\n  \
             - {{Class: rviz/PointCloud2, Style: Points, Size (Pixels): {size_px}}}\n"
        );
        let config = check(&text);
        let config = config.as_ref();
        prop_assert_eq!(config.map(|config| config.findings.len()), Some(0));
        let settings: Vec<_> = config.iter().flat_map(|config| &config.displays).map(|display| &display.settings).collect();
        let [DisplaySettings::PointCloud2(cloud), DisplaySettings::Grid(grid), DisplaySettings::PointCloud2(points)] =
            settings.as_slice()
        else {
            return Err(TestCaseError::fail("three displays"));
        };
        prop_assert_eq!((cloud.alpha, cloud.style), (alpha, PointStyle::FlatSquares { side_m: size_m }));
        prop_assert_eq!(points.style, PointStyle::Points { diameter_px: size_px });
        prop_assert_eq!((cloud.intensity.min, cloud.flat_color), (f32::from(min), color));
        prop_assert_eq!(cloud.queue_size, queue_size);
        prop_assert_eq!(grid.offset_m, [x, -1e-3, 7.0]);
    }
}

#[test]
fn of_a_plugin_with_countless_topics_a_few_are_named() {
    let keys: String = (0..200_000).map(|i| format!("    {i} Topic: /t{i}\n")).collect();
    let text = format!("Visualization Manager:\n  Displays:\n  - Class: my/Own\n    Enabled: true\n{keys}");
    let config = rcs_rviz_config::parse(&text, "t").unwrap();
    let found = config.findings[0].to_string();
    assert!(found.contains("(it shows /t0, /t1, ") && found.len() < 500, "{found}");
}
