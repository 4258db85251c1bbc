//! Sections of a file, and unreadable files.

use std::path::Path;

use rcs_rviz_config::{
    load, parse, DisplaySettings, FreeView, GridSettings, PlacedDisplay, Role, ViewConfig, ViewController,
};

use super::messages;

/// A config as saved by rviz, with every section, for projecting a robot's clouds.
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
    assert_eq!(messages(&config), [""; 0]);
    assert_eq!(config.source, "projector.rviz");
    assert_eq!(config.global.fixed_frame, "base_link", "without its slash");
    assert_eq!(config.global.background_color, [48, 48, 90]);
    assert!(config.enabled);

    let placed = config.placed_displays();
    let seen: Vec<_> = placed
        .iter()
        .map(|placed| (placed.path.join("/"), placed.enabled, placed.display.settings.role() != Role::Unknown))
        .collect();
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

    assert_eq!(config.view.target_frame.as_deref(), Some("gripper_link"));
    assert!(matches!(config.view.controller, ViewController::Orbit(_)));
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
fn views_of_each_class_are_read() {
    let view = |keys: &str| {
        let text = format!("Visualization Manager: {{Views: {{Current: {keys}}}}}");
        let config = parse(&text, "t").unwrap();
        assert_eq!(messages(&config), [""; 0], "{keys}");
        config.view
    };
    let free = "Position: {X: 1, Y: 2, Z: 3}, Yaw: 1, Pitch: 0.5, Roll: 0.1, Target Frame: base";
    let fps = view(&format!("{{Class: rviz/FPS, {free}}}"));
    assert_eq!(fps.target_frame.as_deref(), Some("base"));
    let free = FreeView { yaw_rad: 1.0, pitch_rad: 0.5, roll_rad: 0.1 };
    assert_eq!(fps.controller, ViewController::Fps(free));
    let aligned = view("{Class: rviz/FrameAligned, Point towards: +y axis, Lock Camera: true}");
    let [x, y, z] = aligned.direction_in_target_frame();
    assert!(x.abs() < 1e-6 && (y - 1.0).abs() < 1e-6 && z.abs() < 1e-6);
    let above = view("{Class: rviz/TopDownOrtho, Angle: 1, Scale: 50, X: 2, Y: 3}");
    assert_eq!(above.direction_in_target_frame(), [0.0, 0.0, -1.0]);
    assert_eq!(above.target_frame, None);
    let follower = view("{Class: rviz/ThirdPersonFollower, Target Frame: <Fixed Frame>}");
    assert!(matches!(follower.controller, ViewController::ThirdPersonFollower(_)));
    assert_eq!(follower.target_frame, None);
}

#[test]
fn an_unknown_view_is_reported_and_is_the_default() {
    let text = "Visualization Manager:\n  Views:\n    Current:\n      Class: some/View\n      Zoom: 1\n";
    let config = parse(text, "t").unwrap();
    assert_eq!(messages(&config), ["line 4: note: Views / Current: unknown class some/View"]);
    assert_eq!(config.view, ViewConfig::default());
}

#[test]
fn an_unknown_key_of_a_view_changes_no_image() {
    let text =
        "Visualization Manager:\n  Views:\n    Old: 1\n    Current:\n      Class: rviz/Orbit\n      Yaw: left\n      \
                Sparkle: 1\n";
    let found = [
        "line 3: note: Views / Old: unknown key",
        "line 6: Views / Current / Yaw: invalid value \"left\", using 0",
        "line 7: note: Views / Current / Sparkle: unknown key",
    ];
    assert_eq!(messages(&parse(text, "t").unwrap()), found);
}

#[test]
fn files_that_are_no_rviz_files_are_errors_that_say_where() {
    let yaml = parse("a: 1\nb: [1, 2\nc: }\n", "broken.rviz").unwrap_err();
    assert!(yaml.place.starts_with("broken.rviz:3:") && yaml.problem.starts_with("not YAML: "), "{yaml}");
    for text in ["", "x: 1", "- 1", "Visualization Manager: ~", "Visualization Manager: 3"] {
        assert!(parse(text, "t").unwrap_err().to_string().starts_with("t: no \"Visualization Manager\" section"));
    }
}

#[test]
fn a_config_of_ros_2_is_refused_in_one_sentence() {
    let ros2 = "Panels:\n- {Class: rviz_common/Displays}\nVisualization Manager:\n  Displays:\n  \
                - {Class: rviz_default_plugins/Grid, Name: g, Enabled: true, Reference Frame: <Fixed Frame>}\n  \
                Tools: [{Class: rviz_default_plugins/MoveCamera}]\n";
    let error = parse(ros2, "two.rviz").unwrap_err();
    let text = error.to_string();
    assert!(text.starts_with("two.rviz: this is a ROS 2 config (rviz_default_plugins/Grid)"), "{text}");
    // A ROS 1 config into which one such display was pasted is read.
    let mixed = ros2.replace("rviz_common/Displays", "rviz/Displays");
    assert_eq!(messages(&parse(&mixed, "t").unwrap()).len(), 1);
}

#[test]
fn files_that_cannot_be_read_are_errors_that_name_them() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.rviz");
    let missing = rcs_rviz_config::load(&path).unwrap_err();
    assert!(missing.to_string().contains("a.rviz: cannot be read: "), "{missing}");
    std::fs::File::create(&path).unwrap().set_len(40 << 30).unwrap();
    for (endless, problem) in [
        (std::path::Path::new("/dev/zero"), "it is a device, only regular files are read"),
        (path.as_path(), "larger than 8 MB"),
    ] {
        let error = rcs_rviz_config::load(endless).unwrap_err().to_string();
        assert_eq!(error, format!("{}: cannot be read: {problem}", endless.display()));
    }
}

#[test]
fn any_encoding_end_of_line_and_separator_that_rviz_reads_is_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.rviz");
    let utf_16: Vec<u8> = PROJECTOR.encode_utf16().flat_map(u16::to_le_bytes).collect();
    for bytes in [
        PROJECTOR.replace('\n', "\r\n").into_bytes(),
        PROJECTOR.replace('\n', "\r").into_bytes(),
        PROJECTOR.replace(": ", ":\t").into_bytes(),
        [b"# V\xe9lo\n", PROJECTOR.as_bytes()].concat(),
        [&b"\xff\xfe"[..], &utf_16].concat(),
        utf_16,
    ] {
        std::fs::write(&path, bytes).unwrap();
        let config = rcs_rviz_config::load(&path).unwrap();
        assert_eq!(config.source, path.display().to_string());
        assert_eq!(config.displays.len(), parse(PROJECTOR, "t").unwrap().displays.len());
        assert_eq!(config.global, parse(PROJECTOR, "t").unwrap().global);
    }
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

/// A cloud of the head camera's own colours on what it sees would be optical feedback.
#[test]
fn on_a_fetch_rviz_shows_robot_and_camera_but_only_detections_markers_and_the_path_are_projected() {
    let config = load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../rviz/fetch.rviz")).unwrap();
    let placed = config.placed_displays();
    let cameras = placed.iter().filter_map(|placed| match &placed.display.settings {
        DisplaySettings::CameraPub(camera) => Some(&camera.visibility),
        _ => None,
    });
    let [visibility] = cameras.collect::<Vec<_>>()[..] else { panic!("not one camera") };
    let (shown, hidden): (Vec<_>, Vec<_>) =
        placed.iter().filter(|placed| placed.enabled).partition(|placed| visibility.shows(&placed.path));
    let names =
        |placed: &[&PlacedDisplay<'_>]| -> Vec<String> { placed.iter().map(|one| one.path.join("/")).collect() };
    assert_eq!(names(&hidden), ["Grid", "RobotModel", "TF", "head camera"]);
    assert_eq!(names(&shown), ["clusters", "desired object", "nav path", "markers", "CameraPub"]);
}
