//! Settings of each display class: its defaults, and every property.

use rcs_rviz_config::{
    parse, AxesSettings, Axis, AxisColorSettings, CameraPubSettings, CloudSettings, ColorTransformer,
    CovarianceColorStyle, CovarianceFrame, CovarianceSettings, DisplaySettings, GridPlane, GridSettings, GroupSettings,
    IntensitySettings, LineStyle, MarkerSettings, OdometrySettings, OrientationCovarianceSettings, PathArrowSettings,
    PathSettings, PlainColorSettings, PointStampedSettings, PoseArraySettings, PoseArrayShape, PoseSettings, PoseShape,
    PoseStyle, PoseSymbolSettings, PoseWithCovarianceSettings, PositionCovarianceSettings, RangeSettings,
};
use rcs_scene::{Encoding, PointStyle};

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
fn every_property_of_point_cloud2_is_read() {
    let config = with_display(
        "rviz/PointCloud2",
        "Topic: /c\nUnreliable: true\nQueue Size: 3\nSelectable: false\nStyle: Boxes\n\
         Size (Pixels): 7.5\nSize (m): 0.25\nAlpha: 0.3\nDecay Time: 1.5\n\
         Position Transformer: XYZ\nColor Transformer: AxisColor\nColor: 1; 2; 3\n\
         Channel Name: ring\nUse rainbow: false\nInvert Rainbow: true\nMin Color: 4; 5; 6\n\
         Max Color: 7; 8; 9\nAutocompute Intensity Bounds: false\nMin Intensity: -2\n\
         Max Intensity: 50.5\nAxis: X\nUse Fixed Frame: false\n\
         Autocompute Value Bounds:\n  Value: false\n  Min Value: -1.5\n  Max Value: 2.5",
    );
    assert_eq!(messages(&config), [""; 0]);
    let expected = CloudSettings {
        topic: "/c".to_owned(),
        queue_size: 3,
        style: PointStyle::Boxes { size_m: [0.25; 3] },
        alpha: 0.3,
        decay_time_secs: 1.5,
        color_transformer: Some(ColorTransformer::AxisColor),
        intensity: IntensitySettings {
            channel_name: "ring".to_owned(),
            use_rainbow: false,
            invert_rainbow: true,
            min_color: [4, 5, 6],
            max_color: [7, 8, 9],
            auto_bounds: false,
            min: -2.0,
            max: 50.5,
        },
        flat_color: [1, 2, 3],
        axis_color: AxisColorSettings {
            axis: Axis::X,
            auto_bounds: false,
            min: -1.5,
            max: 2.5,
            use_fixed_frame: false,
        },
    };
    assert_eq!(*settings(&config), DisplaySettings::PointCloud2(expected));
}

#[test]
fn displays_of_single_values_have_their_own_channel_and_bounds() {
    let keys = "Topic: /s\nInvert Rainbow: false\nMin Intensity: 10\nSize (m): 0.4";
    let config = with_display("rviz/Temperature", keys);
    assert_eq!(messages(&config), [""; 0]);
    let DisplaySettings::Temperature(temperature) = settings(&config) else { panic!("a Temperature") };
    let intensity = &temperature.intensity;
    assert_eq!(intensity.channel_name, "temperature");
    assert_eq!((intensity.min, intensity.max, intensity.auto_bounds), (10.0, 100.0, false));
    assert!(!intensity.invert_rainbow && CloudSettings::temperature_default().intensity.invert_rainbow);
    let pressure = CloudSettings::fluid_pressure_default().intensity;
    assert_eq!((pressure.channel_name.as_str(), pressure.min, pressure.max), ("fluid_pressure", 98e3, 105e3));
    assert_eq!(config.displays[0].topic(), Some("/s"));
}

#[test]
fn every_property_of_grid_cells_and_range_is_read() {
    let head = "Topic: /t\nUnreliable: true\nQueue Size: 3\nColor: 1; 2; 3\nAlpha: 1.5";
    let config = with_display("rviz/GridCells", head);
    assert_eq!(messages(&config).len(), 1, "Alpha is at most 1 here: {:?}", messages(&config));
    let (topic, color) = ("/t".to_owned(), [1, 2, 3]);
    let expected = PlainColorSettings { topic: topic.clone(), queue_size: 3, color, alpha: 1.0 };
    assert_eq!(*settings(&config), DisplaySettings::GridCells(expected));
    let config = with_display("rviz/Range", &format!("{head}\nBuffer Length: 7"));
    assert_eq!(messages(&config), [""; 0]);
    let expected = RangeSettings { topic, queue_size: 3, color, alpha: 1.5, buffer_length: 7 };
    assert_eq!(*settings(&config), DisplaySettings::Range(expected));
}

#[test]
fn each_color_transformer_and_style_has_its_name_and_each_style_its_size() {
    let transformers = [
        ("Intensity", Some(ColorTransformer::Intensity)),
        ("RGB8", Some(ColorTransformer::Rgb8)),
        ("MONO8", Some(ColorTransformer::Mono8)),
        ("RGBF32", Some(ColorTransformer::Rgbf32)),
        ("FlatColor", Some(ColorTransformer::FlatColor)),
        ("AxisColor", Some(ColorTransformer::AxisColor)),
        ("''", None),
    ];
    let styles = [
        ("Points", PointStyle::Points { diameter_px: 7.5 }),
        ("Squares", PointStyle::Squares { size_m: [0.25; 2] }),
        ("Flat Squares", PointStyle::FlatSquares { side_m: 0.25 }),
        ("Spheres", PointStyle::Spheres { size_m: [0.25; 2] }),
        ("Boxes", PointStyle::Boxes { size_m: [0.25; 3] }),
    ];
    for (transformer, expected_transformer) in transformers {
        for (style, expected_style) in styles {
            let sizes = "Size (Pixels): 7.5\nSize (m): 0.25";
            let keys = format!("Color Transformer: {transformer}\nStyle: {style}\n{sizes}");
            let config = with_display("rviz/PointCloud2", &keys);
            assert_eq!(messages(&config), [""; 0]);
            let DisplaySettings::PointCloud2(cloud) = settings(&config) else {
                panic!("a PointCloud2");
            };
            assert_eq!(cloud.color_transformer, expected_transformer);
            assert_eq!(cloud.style, expected_style);
        }
    }
}

#[test]
fn every_property_of_grid_and_axes_is_read() {
    let config = with_display(
        "rviz/Grid",
        "Reference Frame: /odom\nPlane Cell Count: 6\nNormal Cell Count: 2\nCell Size: 0.4\n\
         Line Style: {Line Width: 0.05, Value: Billboards}\nColor: 200; 120; 60\nAlpha: 0.8\n\
         Plane: YZ\nOffset: {X: 0.2, Y: -0.3, Z: 0.1}",
    );
    assert_eq!(messages(&config), [""; 0]);
    let grid = GridSettings {
        reference_frame: Some("odom".to_owned()),
        plane_cell_count: 6,
        normal_cell_count: 2,
        cell_size_m: 0.4,
        line_style: LineStyle::Billboards,
        line_width_m: 0.05,
        color: [200, 120, 60],
        alpha: 0.8,
        plane: GridPlane::Yz,
        offset_m: [0.2, -0.3, 0.1],
    };
    assert_eq!(*settings(&config), DisplaySettings::Grid(grid));

    let config =
        with_display("rviz/Axes", "Reference Frame: sensor\nLength: 0.5\nRadius: 0.02\nShow Trail: true\nAlpha: 0.7");
    assert_eq!(messages(&config), [""; 0]);
    let axes = AxesSettings {
        reference_frame: Some("sensor".to_owned()),
        length_m: 0.5,
        radius_m: 0.02,
        show_trail: true,
        alpha: 0.7,
    };
    assert_eq!(*settings(&config), DisplaySettings::Axes(axes));
}

#[test]
fn every_property_of_path_is_read() {
    let config = with_display(
        "rviz/Path",
        "Topic: /plan\nUnreliable: true\nQueue Size: 1\nLine Style: Billboards\nLine Width: 0.04\n\
         Color: 0; 160; 255\nAlpha: 0.5\nBuffer Length: 3\nOffset: {X: 1, Y: 2, Z: 3}\n\
         Pose Style: Arrows\nLength: 0.6\nRadius: 0.06\nPose Color: 9; 8; 7\nShaft Length: 0.11\n\
         Head Length: 0.12\nShaft Diameter: 0.13\nHead Diameter: 0.14",
    );
    assert_eq!(messages(&config), [""; 0]);
    let path = PathSettings {
        topic: "/plan".to_owned(),
        queue_size: 1,
        line_style: LineStyle::Billboards,
        line_width_m: 0.04,
        color: [0, 160, 255],
        alpha: 0.5,
        buffer_length: 3,
        offset_m: [1.0, 2.0, 3.0],
        pose_style: PoseStyle::Arrows,
        axes_length_m: 0.6,
        axes_radius_m: 0.06,
        arrow: PathArrowSettings {
            color: [9, 8, 7],
            shaft_length_m: 0.11,
            head_length_m: 0.12,
            shaft_diameter_m: 0.13,
            head_diameter_m: 0.14,
        },
    };
    assert_eq!(*settings(&config), DisplaySettings::Path(path));
}

/// The keys of an arrow or axes, as they stand beside or inside `Shape`.
const SYMBOL: &str = "Color: 1; 2; 3\nAlpha: 0.5\nShaft Length: 0.1\nShaft Radius: 0.2\nHead Length: 0.3\n\
                      Head Radius: 0.4\nAxes Length: 0.5\nAxes Radius: 0.6";

const COVARIANCE: &str =
    "Covariance:\n  Value: true\n  Position: {Value: true, Color: 4; 5; 6, Alpha: 0.25, Scale: 2}\n  \
                          Orientation: {Value: true, Frame: Fixed, Color Style: RGB, Color: 7; 8; 9, Alpha: 0.75, \
                          Offset: 3, Scale: 4}";

fn symbol() -> PoseSymbolSettings {
    PoseSymbolSettings {
        shape: PoseShape::Axes,
        color: [1, 2, 3],
        alpha: 0.5,
        shaft_length_m: 0.1,
        shaft_radius_m: 0.2,
        head_length_m: 0.3,
        head_radius_m: 0.4,
        axes_length_m: 0.5,
        axes_radius_m: 0.6,
    }
}

fn covariance() -> CovarianceSettings {
    CovarianceSettings {
        position: Some(PositionCovarianceSettings { color: [4, 5, 6], alpha: 0.25, scale: 2.0 }),
        orientation: Some(OrientationCovarianceSettings {
            frame: CovarianceFrame::Fixed,
            color_style: CovarianceColorStyle::Rgb,
            color: [7, 8, 9],
            alpha: 0.75,
            offset_m: 3.0,
            scale: 4.0,
        }),
    }
}

#[test]
fn every_property_of_poses_is_read() {
    let keys = format!("Topic: /t\nUnreliable: true\nQueue Size: 3\nShape: Axes\n{SYMBOL}");
    let config = with_display("rviz/Pose", &keys);
    assert_eq!(messages(&config), [""; 0]);
    let pose = PoseSettings { topic: "/t".to_owned(), queue_size: 3, symbol: symbol() };
    assert_eq!(*settings(&config), DisplaySettings::Pose(pose));

    let config = with_display("rviz/PoseWithCovariance", &format!("{keys}\n{COVARIANCE}"));
    assert_eq!(messages(&config), [""; 0]);
    let pose = PoseWithCovarianceSettings {
        topic: "/t".to_owned(),
        queue_size: 3,
        symbol: symbol(),
        covariance: covariance(),
    };
    assert_eq!(*settings(&config), DisplaySettings::PoseWithCovariance(pose));
}

#[test]
fn every_property_of_odometry_is_read_and_the_symbols_lie_inside_of_its_shape() {
    let shape = format!("Value: Axes\n{SYMBOL}").replace('\n', ", ");
    let keys = format!(
        "Topic: /t\nUnreliable: true\nQueue Size: 3\nPosition Tolerance: 0.7\nAngle Tolerance: 0.8\nKeep: 9\n\
         Shape: {{{shape}}}\n{COVARIANCE}"
    );
    let config = with_display("rviz/Odometry", &keys);
    assert_eq!(messages(&config), [""; 0]);
    let odometry = OdometrySettings {
        topic: "/t".to_owned(),
        queue_size: 3,
        position_tolerance_m: 0.7,
        angle_tolerance_rad: 0.8,
        keep: 9,
        symbol: symbol(),
        covariance: covariance(),
    };
    assert_eq!(*settings(&config), DisplaySettings::Odometry(odometry));
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
fn every_property_of_pose_array_point_stamped_and_polygon_is_read() {
    let common = "Topic: /t\nUnreliable: true\nQueue Size: 3\nColor: 1; 2; 3\nAlpha: 0.5";
    let config = with_display(
        "rviz/PoseArray",
        &format!(
            "{common}\nShape: Arrow (3D)\nArrow Length: 0.1\nShaft Length: 0.2\nShaft Radius: 0.3\nHead Length: 0.4\n\
             Head Radius: 0.5\nAxes Length: 0.6\nAxes Radius: 0.7"
        ),
    );
    assert_eq!(messages(&config), [""; 0]);
    let poses = PoseArraySettings {
        topic: "/t".to_owned(),
        queue_size: 3,
        shape: PoseArrayShape::Arrow3d,
        color: [1, 2, 3],
        alpha: 0.5,
        flat_arrow_length_m: 0.1,
        shaft_length_m: 0.2,
        shaft_radius_m: 0.3,
        head_length_m: 0.4,
        head_radius_m: 0.5,
        axes_length_m: 0.6,
        axes_radius_m: 0.7,
    };
    assert_eq!(*settings(&config), DisplaySettings::PoseArray(poses));

    let config = with_display("rviz/PointStamped", &format!("{common}\nRadius: 0.4\nHistory Length: 200000"));
    assert_eq!(messages(&config).len(), 1, "the history is clamped");
    let points = PointStampedSettings {
        topic: "/t".to_owned(),
        queue_size: 3,
        color: [1, 2, 3],
        alpha: 0.5,
        radius_m: 0.4,
        history_length: 100_000,
    };
    assert_eq!(*settings(&config), DisplaySettings::PointStamped(points));

    let config = with_display("rviz/Polygon", common);
    assert_eq!(messages(&config), [""; 0]);
    let polygon = PlainColorSettings { topic: "/t".to_owned(), queue_size: 3, color: [1, 2, 3], alpha: 0.5 };
    assert_eq!(*settings(&config), DisplaySettings::Polygon(polygon));
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
fn the_parts_of_screws_are_named_after_what_they_are() {
    let keys = |linear: &str, angular: &str| {
        format!(
            "Topic: /s\n{linear} Color: 1; 2; 3\n{angular} Color: 4; 5; 6\n{linear} Arrow Scale: 0.5\n\
             {angular} Arrow Scale: -2\nArrow Width: 0.1\nHistory Length: 1000000\nHide Small Values: false\nAlpha: 0.5"
        )
    };
    for (class, linear, angular) in [
        ("rviz/WrenchStamped", "Force", "Torque"),
        ("rviz/TwistStamped", "Linear", "Angular"),
        ("rviz/AccelStamped", "Linear", "Angular"),
    ] {
        let config = with_display(class, &keys(linear, angular));
        assert_eq!(messages(&config).len(), 1, "{class}: the history is clamped");
        let (DisplaySettings::WrenchStamped(screw)
        | DisplaySettings::TwistStamped(screw)
        | DisplaySettings::AccelStamped(screw)) = settings(&config)
        else {
            panic!("{class}")
        };
        let expected = rcs_rviz_config::ScrewSettings {
            topic: "/s".to_owned(),
            linear_color: [1, 2, 3],
            angular_color: [4, 5, 6],
            alpha: 0.5,
            linear_scale: 0.5,
            angular_scale: -2.0,
            width_m: 0.1,
            history_length: 100_000,
            hide_small_values: false,
            ..rcs_rviz_config::ScrewSettings::default()
        };
        assert_eq!(*screw, expected);
        assert_eq!(config.displays[0].topic(), Some("/s"));
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
