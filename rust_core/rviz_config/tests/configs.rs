//! Whole `.rviz` files: what each section and display class is read into, and what is reported.

use rcs_rviz_config::{
    parse, AxesSettings, Axis, AxisColorSettings, CameraPubSettings, CloudSettings, ColorTransformer, Config,
    ConfigError, CovarianceColorStyle, CovarianceFrame, CovarianceSettings, DisplaySettings, FindingKind,
    GridCellsSettings, GridPlane, GridSettings, ImageEncoding, IntensitySettings, LineStyle, MarkerSettings,
    OdometrySettings, OrientationCovarianceSettings, PathSettings, PointStampedSettings, PointStyle, PolygonSettings,
    PoseArraySettings, PoseArrayShape, PoseSettings, PoseShape, PoseStyle, PoseSymbolSettings,
    PoseWithCovarianceSettings, PositionCovarianceSettings, RangeSettings, ViewConfig, ViewController,
};

/// The config whose only display has these keys.
fn with_display(class: &str, keys: &str) -> Config {
    let mut text =
        format!("Visualization Manager:\n  Displays:\n    - Class: {class}\n      Name: it\n      Enabled: true\n");
    for line in keys.lines() {
        text += &format!("      {line}\n");
    }
    parse(&text, "test.rviz").unwrap_or_else(|error| panic!("{error}"))
}

/// The line of the first of `with_display`'s keys.
const FIRST_LINE: usize = 6;

fn settings(config: &Config) -> &DisplaySettings {
    &config.displays[0].settings
}

fn messages(config: &Config) -> Vec<String> {
    config.findings.iter().map(ToString::to_string).collect()
}

fn not_understood(config: &Config) -> Vec<String> {
    let findings = config.findings.iter();
    findings.filter(|finding| finding.is_not_understood()).map(ToString::to_string).collect()
}

/// What rviz saves of a scene in which a projector shows a robot's clouds, with every section of the file.
const PROJECTOR: &str = r#"Panels:
  - Class: rviz/Displays
    Help Height: 70
    Name: Displays
    Property Tree Widget:
      Expanded: [/Global Options1, /TF1/Frames1]
      Splitter Ratio: 0.4
    Tree Height: 600
  - Class: some_tools/SomePanel
    Name: SomePanel
Preferences:
  PromptSaveOnExit: true
Toolbars:
  toolButtonStyle: 2
Visualization Manager:
  Class: ""
  Displays:
    - Alpha: 0.5
      Cell Size: 1
      Class: rviz/Grid
      Color: 160; 160; 164
      Enabled: true
      Line Style:
        Line Width: 0.029999999329447746
        Value: Lines
      Name: Grid
      Normal Cell Count: 0
      Offset:
        X: 0
        Y: 0
        Z: 0
      Plane: XY
      Plane Cell Count: 10
      Reference Frame: <Fixed Frame>
      Value: true
    - Class: rviz/Group
      Displays: ~
      Enabled: false
      Name: Nothing in it
    - Class: rviz/Group
      Displays:
        - Alpha: 1
          Autocompute Intensity Bounds: true
          Autocompute Value Bounds:
            Max Value: 10
            Min Value: -10
            Value: true
          Axis: Z
          Channel Name: intensity
          Class: rviz/PointCloud2
          Color: 255; 255; 255
          Color Transformer: RGB8
          Decay Time: 0
          Enabled: true
          Invert Rainbow: false
          Max Color: 255; 255; 255
          Max Intensity: 4096
          Min Color: 0; 0; 0
          Min Intensity: 0
          Name: cloud
          Position Transformer: XYZ
          Queue Size: 10
          Selectable: true
          Size (Pixels): 4
          Size (m): 0.009999999776482582
          Style: Points
          Topic: /head_camera/points
          Unreliable: false
          Use Fixed Frame: true
          Use rainbow: true
          Value: true
        - Class: rviz/MarkerArray
          Enabled: false
          Marker Topic: /grasps
          Name: grasps
          Namespaces:
            "": true
            approach: false
          Queue Size: 100
          Value: false
      Enabled: true
      Name: Sensors
    - Alpha: 1
      Class: rviz/RobotModel
      Links:
        All Links Enabled: true
        base_link:
          Alpha: 1
          Value: true
      Name: RobotModel
      Enabled: false
      Robot Description: robot_description
      Value: false
    - Class: rviz/TF
      Enabled: true
      Frames:
        All Enabled: false
        head_camera:
          Value: true
      Name: TF
      Tree:
        base_link:
          head_camera:
            {}
      Value: true
    - Background Color: 0; 0; 0
      Camera Info Topic: /projector/camera_info
      Class: rviz_camera_stream/CameraPub
      Display namespace: ""
      Enabled: true
      Frame Rate: -1
      Image Encoding: rgb8
      Image Topic: /projector/image
      Name: Projection
      Near Clip Distance: 0.009999999776482582
      Queue Size: 2
      Value: true
      Visibility:
        Grid: false
        Nothing in it: true
        Picture: true
        RobotModel: true
        Sensors:
          Value: true
          cloud: true
          grasps: false
        TF: true
        Value: true
    - Class: rviz/Image
      Enabled: false
      Image Topic: /projector/image
      Max Value: 1
      Median window: 5
      Name: Picture
      Transport Hint: raw
      Value: false
  Enabled: true
  Global Options:
    Background Color: 48; 48; 90
    Default Light: true
    Fixed Frame: /base_link
    Frame Rate: 30
  Name: root
  Tools:
    - Class: rviz/Interact
      Hide Inactive Objects: true
    - Class: rviz/SetGoal
      Topic: /goal
  Value: true
  Views:
    Current:
      Class: rviz/XYOrbit
      Distance: 0.92
      Enable Stereo Rendering:
        Stereo Eye Separation: 0.05999999865889549
        Stereo Focal Distance: 1
        Swap Stereo Eyes: false
        Value: false
      Focal Point:
        X: 0.5
        Y: 0.25
        Z: 0
      Focal Shape Fixed Size: false
      Focal Shape Size: 0.05000000074505806
      Invert Z Axis: false
      Name: Current View
      Near Clip Distance: 0.009999999776482582
      Pitch: 1.5697963237762451
      Target Frame: gripper_link
      Value: XYOrbit (rviz)
      Yaw: 3.07
    Saved:
      - Class: rviz/Orbit
        Name: from the side
Window Geometry:
  Displays:
    collapsed: false
  Height: 1025
  QMainWindow State: 000000ff00000000
  Width: 1861
"#;

#[test]
fn a_file_as_rviz_saves_it_is_understood() {
    let config = parse(PROJECTOR, "projector.rviz").unwrap();
    assert_eq!(not_understood(&config), [""; 0]);
    assert_eq!(messages(&config), [""; 0]);
    assert_eq!(config.source, "projector.rviz");
    assert_eq!(config.global.fixed_frame, "base_link", "without its slash");
    assert_eq!(config.global.background_color, [48, 48, 90]);
    assert!(config.enabled);

    let placed = config.placed_displays();
    let seen: Vec<_> =
        placed.iter().map(|placed| (placed.path.join("/"), placed.enabled, placed.display.is_drawn())).collect();
    let expected = [
        ("Grid", true, true),
        ("Nothing in it", false, true),
        ("Sensors", true, true),
        ("Sensors/cloud", true, true),
        ("Sensors/grasps", false, true),
        ("RobotModel", false, true),
        ("TF", true, true),
        ("Projection", true, true),
        ("Picture", false, true),
    ];
    assert_eq!(seen, expected.map(|(path, enabled, drawn)| (path.to_owned(), enabled, drawn)));
    let topics: Vec<_> = placed.iter().map(|placed| placed.display.topic()).collect();
    let (cloud, image) = (Some("/head_camera/points"), Some("/projector/image"));
    assert_eq!(topics, [None, None, None, cloud, Some("/grasps"), None, None, image, image]);
    assert_eq!(placed[3].display.line, 42);

    assert_eq!(placed[0].display.settings, DisplaySettings::Grid(GridSettings::default()));
    let DisplaySettings::MarkerArray(grasps) = &placed[4].display.settings else {
        panic!("a MarkerArray");
    };
    assert!(grasps.shows_namespace("") && grasps.shows_namespace("other"));
    assert!(!grasps.shows_namespace("approach"));

    let DisplaySettings::CameraPub(camera) = &placed[7].display.settings else {
        panic!("a CameraPub");
    };
    assert_eq!(camera.near_clip_m, 0.01);
    let visible: Vec<_> = placed.iter().map(|placed| camera.visibility.shows(&placed.path)).collect();
    assert_eq!(visible, [false, true, true, true, false, true, true, true, true]);

    assert_eq!(config.view.target_frame(), Some("gripper_link"));
    let ViewController::XyOrbit(orbit) = &config.view.controller else {
        panic!("an XYOrbit");
    };
    assert_eq!(orbit.focal_point_m, [0.5, 0.25, 0.0]);
}

#[test]
fn a_config_without_any_keys_has_rvizs_defaults() {
    let config = parse("Visualization Manager: {}", "empty.rviz").unwrap();
    assert_eq!(config.global.fixed_frame, "map");
    assert_eq!(config.global.frame_rate_hz, 30);
    assert_eq!(config.global.background_color, [48, 48, 48]);
    assert!(config.global.default_light && config.enabled);
    assert_eq!(config.view, ViewConfig::default());
    assert_eq!((config.displays, config.findings), (vec![], vec![]));
}

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
        ("rviz/GridCells", DisplaySettings::GridCells(GridCellsSettings::default())),
        ("rviz/Range", DisplaySettings::Range(RangeSettings::default())),
        ("rviz/Grid", DisplaySettings::Grid(GridSettings::default())),
        ("rviz/Axes", DisplaySettings::Axes(AxesSettings::default())),
        ("rviz/Marker", DisplaySettings::Marker(MarkerSettings::default())),
        ("rviz/MarkerArray", DisplaySettings::MarkerArray(MarkerSettings::array_default())),
        ("rviz/Path", DisplaySettings::Path(PathSettings::default())),
        ("rviz/Odometry", DisplaySettings::Odometry(OdometrySettings::default())),
        ("rviz/PointStamped", DisplaySettings::PointStamped(PointStampedSettings::default())),
        ("rviz/Polygon", DisplaySettings::Polygon(PolygonSettings::default())),
        ("rviz/Pose", DisplaySettings::Pose(PoseSettings::default())),
        ("rviz/PoseArray", DisplaySettings::PoseArray(PoseArraySettings::default())),
        ("rviz/PoseWithCovariance", DisplaySettings::PoseWithCovariance(PoseWithCovarianceSettings::default())),
        ("rviz/Group", DisplaySettings::Group(vec![])),
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
        unreliable: true,
        queue_size: 3,
        selectable: false,
        style: PointStyle::Boxes,
        size_px: 7.5,
        size_m: 0.25,
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
    let expected = GridCellsSettings { topic: topic.clone(), unreliable: true, queue_size: 3, color, alpha: 1.0 };
    assert_eq!(*settings(&config), DisplaySettings::GridCells(expected));
    let config = with_display("rviz/Range", &format!("{head}\nBuffer Length: 7"));
    assert_eq!(messages(&config), [""; 0]);
    let expected = RangeSettings { topic, unreliable: true, queue_size: 3, color, alpha: 1.5, buffer_length: 7 };
    assert_eq!(*settings(&config), DisplaySettings::Range(expected));
}

#[test]
fn each_color_transformer_and_style_has_its_name() {
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
        ("Points", PointStyle::Points),
        ("Squares", PointStyle::Squares),
        ("Flat Squares", PointStyle::FlatSquares),
        ("Spheres", PointStyle::Spheres),
        ("Boxes", PointStyle::Boxes),
    ];
    for (transformer, expected_transformer) in transformers {
        for (style, expected_style) in styles {
            let keys = format!("Color Transformer: {transformer}\nStyle: {style}");
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
        unreliable: true,
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
        arrow_color: [9, 8, 7],
        shaft_length_m: 0.11,
        head_length_m: 0.12,
        shaft_diameter_m: 0.13,
        head_diameter_m: 0.14,
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
    let pose = PoseSettings { topic: "/t".to_owned(), unreliable: true, queue_size: 3, symbol: symbol() };
    assert_eq!(*settings(&config), DisplaySettings::Pose(pose));

    let config = with_display("rviz/PoseWithCovariance", &format!("{keys}\n{COVARIANCE}"));
    assert_eq!(messages(&config), [""; 0]);
    let pose = PoseWithCovarianceSettings {
        topic: "/t".to_owned(),
        unreliable: true,
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
        unreliable: true,
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
    assert_eq!(not_understood(&config).len(), 1);
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
        unreliable: true,
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
        unreliable: true,
        queue_size: 3,
        color: [1, 2, 3],
        alpha: 0.5,
        radius_m: 0.4,
        history_length: 100_000,
    };
    assert_eq!(*settings(&config), DisplaySettings::PointStamped(points));

    let config = with_display("rviz/Polygon", common);
    assert_eq!(messages(&config), [""; 0]);
    let polygon =
        PolygonSettings { topic: "/t".to_owned(), unreliable: true, queue_size: 3, color: [1, 2, 3], alpha: 0.5 };
    assert_eq!(*settings(&config), DisplaySettings::Polygon(polygon));
}

#[test]
fn every_property_of_camera_pub_is_read() {
    for (name, encoding) in [
        ("rgb8", ImageEncoding::Rgb8),
        ("rgba8", ImageEncoding::Rgba8),
        ("bgr8", ImageEncoding::Bgr8),
        ("bgra8", ImageEncoding::Bgra8),
        ("mono8", ImageEncoding::Mono8),
        ("mono16", ImageEncoding::Mono16),
    ] {
        let keys = format!(
            "Image Topic: /i\nCamera Info Topic: /c\nDisplay namespace: left\nQueue Size: 4\n\
             Frame Rate: 12.5\nBackground Color: 10; 20; 30\nImage Encoding: {name}\n\
             Near Clip Distance: 0.5\nVisibility: {{Value: true, a: false}}"
        );
        let config = with_display("rviz_camera_stream/CameraPub", &keys);
        assert_eq!(messages(&config), [""; 0]);
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
            visibility: camera.visibility.clone(),
        };
        assert_eq!(*camera, expected);
        assert_eq!(encoding.name(), name);
    }
}

#[test]
fn numbers_out_of_range_are_clamped_and_reported() {
    let class = "rviz_camera_stream/CameraPub";
    let config = with_display(class, "Queue Size: 0\nFrame Rate: -5\nNear Clip Distance: 0.001");
    assert_eq!(
        messages(&config),
        [
            "line 6: Displays / it / Queue Size: invalid value \"0\", using 1",
            "line 7: Displays / it / Frame Rate: invalid value \"-5\", using -1",
            "line 8: Displays / it / Near Clip Distance: invalid value \"0.001\", using 0.01",
        ]
    );
    let DisplaySettings::CameraPub(camera) = settings(&config) else {
        panic!("a CameraPub");
    };
    assert_eq!((camera.queue_size, camera.frame_rate_hz, camera.near_clip_m), (1, -1.0, 0.01));
}

#[test]
fn text_that_is_no_number_counts_as_zero() {
    let config = with_display(
        "rviz/PointCloud2",
        "Alpha: much\nSize (m): nan\nQueue Size: 10.0\nMin Intensity: nan\nDecay Time: inf",
    );
    assert_eq!(config.findings.len(), 5);
    let DisplaySettings::PointCloud2(cloud) = settings(&config) else {
        panic!("a PointCloud2");
    };
    assert_eq!((cloud.alpha, cloud.size_m, cloud.queue_size), (0.0, 0.0001, 0));
    assert_eq!((cloud.intensity.min, cloud.decay_time_secs), (0.0, f32::MAX));
}

#[test]
fn an_unknown_choice_is_the_first_of_the_list() {
    let config = with_display("rviz/PointCloud2", "Style: Billboards\nColor Transformer: Heat");
    assert_eq!(
        messages(&config),
        [
            "line 6: Displays / it / Style: invalid value \"Billboards\", using Points",
            "line 7: Displays / it / Color Transformer: invalid value \"Heat\", using what fits the message",
        ]
    );
    let DisplaySettings::PointCloud2(cloud) = settings(&config) else {
        panic!("a PointCloud2");
    };
    assert_eq!((cloud.style, cloud.color_transformer), (PointStyle::Points, None));
}

#[test]
fn an_unknown_key_is_reported_with_its_line_at_any_depth() {
    let text = "Extra: 1\n\
                Visualization Manager:\n\
                \x20 Global Options: {Fixed Frame: a, Gravity: 9.81}\n\
                \x20 Views: {Current: {Class: rviz/Orbit, Zoom: 2}, Old: 1}\n\
                \x20 Weather: fine\n\
                \x20 Displays:\n\
                \x20   - Class: rviz/Group\n\
                \x20     Name: g\n\
                \x20     Displays:\n\
                \x20       - Class: rviz/Grid\n\
                \x20         Name: floor\n\
                \x20         Line Style:\n\
                \x20           Value: Lines\n\
                \x20           Dashes: 3\n\
                \x20         Offset: {X: 0, Y: 0, Z: 0, W: 0}\n\
                \x20     Tint: red\n";
    let config = parse(text, "t").unwrap();
    let found: Vec<_> =
        config.findings.iter().map(|finding| (finding.line, finding.path.as_str(), &finding.kind)).collect();
    let key = &FindingKind::UnknownKey;
    assert_eq!(
        found,
        [
            (1, "Extra", key),
            (3, "Global Options / Gravity", key),
            (4, "Views / Current / Zoom", key),
            (4, "Views / Old", key),
            (5, "Weather", key),
            (14, "Displays / g / floor / Line Style / Dashes", key),
            (15, "Displays / g / floor / Offset / W", key),
            (16, "Displays / g / Tint", key),
        ]
    );
}

#[test]
fn an_unknown_class_is_reported_once_and_its_keys_are_not() {
    let config = with_display("moveit_rviz_plugin/MotionPlanning", "Topic: /plan\nMove Group: {A: 1}");
    assert_eq!(messages(&config), ["line 3: Displays / it: unknown class moveit_rviz_plugin/MotionPlanning"]);
    assert!(config.findings[0].is_not_understood() && !config.displays[0].is_drawn());
    assert_eq!(config.displays[0].topic(), Some("/plan"));
    assert!(matches!(settings(&config), DisplaySettings::NotDrawn { known: false, .. }));
    let config = parse("Visualization Manager: {Displays: [{Name: x}]}", "t").unwrap();
    assert_eq!(messages(&config), ["line 1: Displays / x: no class named"]);
}

#[test]
fn what_is_enabled_follows_rviz() {
    for (keys, enabled) in [
        ("{Class: rviz/Grid}", false),
        ("{Class: rviz/Grid, Value: true}", true),
        ("{Class: rviz/Grid, Enabled: true}", true),
        ("{Class: rviz/Grid, Enabled: false, Value: true}", false),
    ] {
        let text = format!("Visualization Manager: {{Displays: [{keys}]}}");
        let config = parse(&text, "t").unwrap();
        assert_eq!(config.displays[0].enabled, enabled, "{keys}");
    }
    let text = "Visualization Manager:\n  Enabled: false\n  Displays: [{Class: rviz/Grid, Enabled: true}]";
    let config = parse(text, "t").unwrap();
    assert!(config.displays[0].enabled && !config.placed_displays()[0].enabled);
}

#[test]
fn a_property_may_be_written_as_a_map_with_its_value() {
    let config = with_display("rviz/Grid", "Alpha: {Value: 0.25}\nLine Style: Billboards");
    assert_eq!(messages(&config), [""; 0]);
    let DisplaySettings::Grid(grid) = settings(&config) else {
        panic!("a Grid");
    };
    assert_eq!((grid.alpha, grid.line_style), (0.25, LineStyle::Billboards));
}

#[test]
fn wrong_types_are_reported_and_leave_the_default() {
    let config = with_display(
        "rviz/Grid",
        "Alpha: [1]\nColor: {a: b}\nPlane: ~\nOffset: 1; 2; 3\nLine Style: [x]\nCell Size: [1, 2]",
    );
    let lines: Vec<_> = config.findings.iter().map(|finding| finding.line).collect();
    assert_eq!(lines, [6, 7, 9, 10, 11]);
    assert_eq!(*settings(&config), DisplaySettings::Grid(GridSettings::default()));
    for displays in ["7", "{a: b}", "[7, [], ~]"] {
        let text = format!("Visualization Manager: {{Displays: {displays}}}");
        let config = parse(&text, "t").unwrap();
        assert!(!config.findings.is_empty(), "{displays}");
    }
}

#[test]
fn of_a_repeated_key_the_last_counts_and_the_others_are_reported() {
    let config = with_display("rviz/Grid", "Alpha: 0.1\nAlpha: 0.2\nAlpha: 0.3");
    let lines: Vec<_> = config.findings.iter().map(|finding| finding.line).collect();
    assert_eq!(lines, [FIRST_LINE, FIRST_LINE + 1]);
    let DisplaySettings::Grid(grid) = settings(&config) else {
        panic!("a Grid");
    };
    assert_eq!(grid.alpha, 0.3);
}

#[test]
fn views_of_each_class_are_read() {
    let view = |keys: &str| {
        let text = format!("Visualization Manager: {{Views: {{Current: {keys}}}}}");
        let config = parse(&text, "t").unwrap();
        assert_eq!(messages(&config), [""; 0], "{keys}");
        config.view
    };
    let free = "Position: {X: 1, Y: 2, Z: 3}, Yaw: 1, Pitch: 0.5, Roll: 0.1, Target Frame: base";
    let fps = view(&format!("{{Class: rviz/FPS, {free}}}"));
    assert_eq!(fps.target_frame(), Some("base"));
    assert_eq!(
        fps.controller,
        ViewController::Fps { position_m: [1.0, 2.0, 3.0], yaw_rad: 1.0, pitch_rad: 0.5, roll_rad: 0.1 }
    );
    let aligned = view("{Class: rviz/FrameAligned, Point towards: +y axis, Lock Camera: true}");
    let [x, y, z] = aligned.direction_in_target_frame();
    assert!(x.abs() < 1e-6 && (y - 1.0).abs() < 1e-6 && z.abs() < 1e-6);
    let above = view("{Class: rviz/TopDownOrtho, Angle: 1, Scale: 50, X: 2, Y: 3}");
    assert_eq!(above.direction_in_target_frame(), [0.0, 0.0, -1.0]);
    assert_eq!(above.target_frame(), None);
    let follower = view("{Class: rviz/ThirdPersonFollower, Target Frame: <Fixed Frame>}");
    assert!(matches!(follower.controller, ViewController::ThirdPersonFollower(_)));
    assert_eq!(follower.target_frame(), None);
}

#[test]
fn an_unknown_view_is_reported_and_is_the_default() {
    let text = "Visualization Manager:\n  Views:\n    Current:\n      Class: some/View\n      Zoom: 1\n";
    let config = parse(text, "t").unwrap();
    assert_eq!(messages(&config), ["line 4: Views / Current: unknown class some/View"]);
    assert_eq!(config.view, ViewConfig::default());
}

#[test]
fn files_that_are_no_rviz_files_are_errors_that_say_where() {
    let yaml = parse("a: 1\nb: [1, 2\nc: }\n", "broken.rviz").unwrap_err();
    let ConfigError::NotYaml { file, line, .. } = &yaml else {
        panic!("not YAML, but {yaml}");
    };
    assert_eq!((file.as_str(), *line), ("broken.rviz", 3));
    assert!(yaml.to_string().starts_with("broken.rviz:3:"));
    for text in ["", "x: 1", "- 1", "Visualization Manager: ~", "Visualization Manager: 3"] {
        assert!(matches!(parse(text, "t"), Err(ConfigError::NoVisualizationManager { .. })));
    }
}

#[test]
fn files_that_cannot_be_read_are_errors_that_name_them() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.rviz");
    let missing = rcs_rviz_config::load(&path).unwrap_err();
    assert!(matches!(missing, ConfigError::Unreadable { .. }));
    assert!(missing.to_string().contains("a.rviz"));
    std::fs::write(&path, b"Visualization Manager:\n  Name: \xff\n").unwrap();
    let bytes = rcs_rviz_config::load(&path).unwrap_err();
    assert!(matches!(bytes, ConfigError::NotUtf8 { line: 2, .. }));
    std::fs::write(&path, PROJECTOR.replace('\n', "\r\n")).unwrap();
    let config = rcs_rviz_config::load(&path).unwrap();
    assert_eq!(config.source, path.display().to_string());
    assert_eq!(config.displays, parse(PROJECTOR, "t").unwrap().displays);
}

#[test]
fn groups_may_be_nested_as_deep_as_a_file_may_be() {
    let depth = 240;
    let mut text = "Visualization Manager:\n".to_owned();
    for level in 0..depth {
        let indent = " ".repeat(2 + 4 * level);
        text += &format!("{indent}Displays:\n{indent}  - Class: rviz/Group\n{indent}    Name: g\n");
    }
    let config = parse(&text, "t").unwrap();
    assert_eq!(config.placed_displays().len(), depth);
    assert_eq!(messages(&config), [""; 0]);
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
        assert_eq!(not_understood(&config), [""; 0], "{class}");
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
        assert_eq!(not_understood(&config), [""; 0], "{tools}");
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
