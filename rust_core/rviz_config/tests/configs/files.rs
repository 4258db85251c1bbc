//! Sections of a file, and unreadable files.

use std::path::Path;

use rcs_rviz_config::{load, parse, DisplaySettings, FreeView, PlacedDisplay, ViewConfig, ViewController};

use super::messages;

/// A config as rviz saved it, with every section.
const SAVED: &str = include_str!("../saved_by_rviz/defaults.rviz");

#[test]
fn the_fixed_frame_loses_its_slash() {
    let config = parse("Visualization Manager: {Global Options: {Fixed Frame: /base_link}}", "t").unwrap();
    assert_eq!((config.global.fixed_frame.as_str(), config.source.as_str()), ("base_link", "t"));
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
    let utf_16: Vec<u8> = SAVED.encode_utf16().flat_map(u16::to_le_bytes).collect();
    for bytes in [
        SAVED.replace('\n', "\r\n").into_bytes(),
        SAVED.replace('\n', "\r").into_bytes(),
        SAVED.replace(": ", ":\t").into_bytes(),
        [b"# V\xe9lo\n", SAVED.as_bytes()].concat(),
        [&b"\xff\xfe"[..], &utf_16].concat(),
        utf_16,
    ] {
        std::fs::write(&path, bytes).unwrap();
        let config = rcs_rviz_config::load(&path).unwrap();
        assert_eq!(config.source, path.display().to_string());
        assert_eq!(config.displays.len(), parse(SAVED, "t").unwrap().displays.len());
        assert_eq!(config.global, parse(SAVED, "t").unwrap().global);
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
