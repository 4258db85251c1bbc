//! Configs of older and newer versions of rviz: what 1.14 ignores is a note, what changes the image is not.

use rcs_rviz_config::{parse, setting_problems, DisplaySettings, OdometrySettings};

use super::{messages, settings, with_display};

#[test]
fn keys_that_older_versions_wrote_are_notes() {
    let config = with_display("rviz/Odometry", "Color: 255; 25; 0\nLength: 1\nKeep: 100\nColour: red");
    assert_eq!(
        messages(&config),
        [
            "line 6: note: Displays / it / Color: key of an older rviz, which rviz ignores since 1.12; it reads Shape / Color",
            "line 7: note: Displays / it / Length: key of an older rviz, which rviz ignores since 1.12; it reads Shape / \
             Shaft Length and Head Length",
            "line 9: Displays / it / Colour: unknown key",
        ]
    );
    assert_eq!(*settings(&config), DisplaySettings::Odometry(OdometrySettings::default()));
    let config = with_display("rviz/Grid", "Offset: {Value: 0; 0; 0, X: 1, Y: 2, Z: 3}");
    let found = messages(&config);
    assert!(
        found.len() == 1 && found[0].starts_with("line 6: note: Displays / it / Offset / Value: key of"),
        "{found:?}"
    );
    let DisplaySettings::Grid(grid) = settings(&config) else { panic!("a Grid") };
    assert_eq!(grid.offset_m, [1.0, 2.0, 3.0]);
}

#[test]
fn numbers_that_older_versions_rounded_beyond_their_limit_are_no_findings() {
    let pitch = |text: &str| {
        let text = format!("Visualization Manager: {{Views: {{Current: {{Class: rviz/Orbit, Pitch: {text}}}}}}}");
        parse(&text, "t").unwrap().findings.len()
    };
    assert_eq!((pitch("1.5698"), pitch("-1.5698"), pitch("1.57"), pitch("1.58")), (0, 0, 1, 1));
}

#[test]
fn a_newer_versions_image_timeout_is_understood() {
    let config = with_display("rviz/Image", "Image Topic: /image\nTimeout: 0");
    assert_eq!(messages(&config), Vec::<String>::new());
}

#[test]
fn synchronization_of_the_time_panel_is_reported() {
    let found = |panel: &str| {
        let text = format!("Panels:\n- {{Class: rviz/Displays}}\n- {{{panel}}}\nVisualization Manager: {{}}");
        messages(&parse(&text, "t").unwrap())
    };
    let exact = found("Class: rviz/Time, SyncMode: 1, SyncSource: cloud");
    assert_eq!(
        exact,
        [
            "line 3: Panels / Time / SyncMode: synchronization \"Exact\" to cloud is not followed: what follows frames is shown \
             at their latest transforms, as with SyncMode 0"
        ]
    );
    assert!(found("Class: rviz/Time, SyncMode: 2")[0].contains("\"Approximate\" is not followed"));
    assert!(found("Class: rviz/Time, SyncMode: 3")[0].contains("\"Frame\" is not followed"));
    for harmless in
        ["Class: rviz/Time, SyncMode: 0, SyncSource: cloud", "Class: rviz/Time", "Class: my/Time, SyncMode: 1"]
    {
        assert_eq!(found(harmless), Vec::<String>::new(), "{harmless}");
    }
    for wrong in ["4", "-1", "x", "[1]", "99999999999"] {
        assert_eq!(
            found(&format!("Class: rviz/Time, SyncMode: {wrong}")),
            Vec::<String>::new(),
            "{wrong}: as 0 in rviz"
        );
    }
    for panels in ["7", "[7]", "[{Class: [a]}]"] {
        assert!(messages(&parse(&format!("Panels: {panels}\nVisualization Manager: {{}}"), "t").unwrap()).is_empty());
    }
}

#[test]
fn a_tree_of_joints_that_rviz_does_not_read_back_is_named_with_what_is_lost() {
    let tree = "Link/Joint Tree:\n  All Links Enabled: true\n  Link Tree Style: Tree of links and joints\n  base:\n    \
                Details: {Alpha: 1, Show Axes: false, Show Trail: false}\n    Value: true\n    shoulder:\n      Details: {Show \
                Axes: true, Show Joint Axis: true}\n      Value: true\n      arm:\n        Details: {Alpha: 0.5, Show Axes: \
                false, Show Trail: true}\n        Value: false";
    let config = with_display("rviz/RobotModel", tree);
    let found = messages(&config);
    assert_eq!(found.len(), 1, "{found:?}");
    assert!(
        found[0].contains(
            "note: Displays / it / Link/Joint Tree: rviz does not read this tree of links back, so these settings have no \
             effect: Show Axes of shoulder, Show Joint Axis of shoulder, Alpha 0.5 of arm, Show Trail of arm, arm is switched \
             off;"
        ),
        "{found:?}"
    );
    let config =
        with_display("rviz/RobotModel", "Joints:\n  All Links Enabled: true\n  j: {Show Axes: false, Value: true}");
    assert_eq!(messages(&config), Vec::<String>::new(), "nothing is lost");
}

#[test]
fn frames_are_filtered_by_regular_expressions_as_rviz_1_14_20_and_1_13_30_do() {
    let lists = |keys: &str| {
        let config = with_display("rviz/TF", keys);
        let DisplaySettings::Tf(tf) = settings(&config) else { panic!("a TF") };
        let listed: Vec<bool> = ["lamp_1", "lamp_2", "laser"].iter().map(|frame| tf.lists(frame)).collect();
        (listed, messages(&config))
    };
    let none = Vec::<String>::new();
    assert_eq!(lists("Filter (whitelist): ''\nFilter (blacklist): ''"), (vec![true; 3], none.clone()));
    assert_eq!(lists("Filter (whitelist): ^lamp"), (vec![true, true, false], none.clone()));
    assert_eq!(lists("Filter (blacklist): _2$"), (vec![true, false, true], none.clone()));
    assert_eq!(lists("Filter (whitelist): lamp\nFilter (blacklist): 1"), (vec![false, true, false], none));
    for key in ["Filter (whitelist)", "Filter (blacklist)"] {
        let (listed, found) = lists(&format!("{key}: lamp("));
        assert_eq!(listed, [true; 3], "{key}: one that is invalid is none");
        let start = format!(
            "line 6: Displays / it / {key}: invalid value \"lamp(\", using no filter, because it is no regular"
        );
        assert!(found.len() == 1 && found[0].starts_with(&start), "{found:?}");
    }
}

#[test]
fn two_cameras_without_a_namespace_as_the_first_plugin_saved_them_are_a_note() {
    let camera = |name: &str| {
        format!(
            "  - {{Camera Info Topic: /{name}/camera_info, Class: rviz_camera_stream/CameraPub, Enabled: true, Frame Rate: -1, \
             Image Topic: /{name}/image, Name: {name}, Queue Size: 2, Value: true, Visibility: {{Value: true}}}}\n"
        )
    };
    let text = format!("Visualization Manager:\n  Displays:\n{}{}", camera("a"), camera("b"));
    let config = parse(&text, "t").unwrap();
    assert_eq!(messages(&config), Vec::<String>::new());
    let problems = setting_problems(&config);
    assert!(problems.len() == 1 && problems[0].is_note, "{problems:?}");
}
