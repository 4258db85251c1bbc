//! Findings of keys, values and classes that rviz does not write.

use rcs_rviz_config::{parse, DisplaySettings, FindingKind, GridSettings, LineStyle, Role};
use rcs_scene::PointStyle;

use super::{messages, settings, with_display, FIRST_LINE};

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
    let style = PointStyle::FlatSquares { side_m: 0.0001 };
    assert_eq!((cloud.alpha, cloud.style, cloud.queue_size), (0.0, style, 0));
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
    assert_eq!((cloud.style, cloud.color_transformer), (PointStyle::Points { diameter_px: 3.0 }, None));
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
    let text = "Robot State Topic: /state\nTopic: /plan\nMove Group: {A: 1, Trajectory Topic: /way}\nOther Topic: ''";
    let config = with_display("moveit_rviz_plugin/MotionPlanning", text);
    let found = messages(&config);
    assert_eq!(found.len(), 1, "{found:?}");
    assert!(found[0].starts_with(
        "line 3: Displays / it: unknown class moveit_rviz_plugin/MotionPlanning, which needs a plugin of the package \
         moveit_ros_visualization (it shows /plan, /state, /way): "
    ));
    assert_eq!(settings(&config).role(), Role::Unknown);
    assert_eq!(config.displays[0].topic(), Some("/plan"));
    assert!(matches!(settings(&config), DisplaySettings::Unknown { .. }));
    let config = parse("Visualization Manager: {Displays: [{Name: x}]}", "t").unwrap();
    assert_eq!(messages(&config), ["line 1: note: Displays / x: no class named"]);
}

#[test]
fn what_is_found_in_a_disabled_display_is_a_note() {
    let text = "Visualization Manager:\n  Displays:\n  - {Class: my/Own, Name: a, Enabled: false}\n  \
                - {Class: my/Own, Name: b, Enabled: true}\n  \
                - {Class: rviz/Grid, Name: c, Enabled: false, Colour: red}\n  \
                - Class: rviz/Group\n    Name: g\n    Displays: [{Class: my/Own, Name: d, Enabled: true}]\n";
    let config = parse(text, "t").unwrap();
    let expected = [
        "line 3: note: Displays / a: unknown class my/Own, which needs a plugin",
        "line 4: Displays / b: unknown class my/Own, which needs a plugin",
        "line 5: note: Displays / c / Colour: unknown key",
        "line 8: note: Displays / g / d: unknown class my/Own, which needs a plugin",
    ];
    let found = messages(&config);
    assert!(found.iter().zip(expected).all(|(found, expected)| found.starts_with(expected)), "{found:?}");
    assert_eq!(found.len(), expected.len());
}

#[test]
fn a_name_in_a_visibility_that_no_display_has_is_reported() {
    let text = "Visualization Manager:\n  Displays:\n  - {Class: rviz/Grid, Name: floor, Enabled: true}\n  \
                - {Class: rviz/Group, Name: robot, Enabled: true, Displays: [{Class: rviz/TF, Name: frames, Enabled: true}]}\n  \
                - Class: rviz_camera_stream/CameraPub\n    Name: eye\n    Enabled: true\n    Visibility:\n      \
                Value: true\n      flor: false\n      floor: false\n      gone: true\n      \
                robot:\n        Value: true\n        frames: false\n        floor: false\n      eye: true\n";
    let config = parse(text, "t").unwrap();
    let there = "no display has this name; there are:";
    let expected = [
        format!("line 10: Displays / eye / Visibility / flor: {there} floor, robot, eye"),
        format!("line 12: note: Displays / eye / Visibility / gone: {there} floor, robot, eye"),
        format!("line 16: Displays / eye / Visibility / robot / floor: {there} frames"),
    ];
    assert_eq!(messages(&config), expected);
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
