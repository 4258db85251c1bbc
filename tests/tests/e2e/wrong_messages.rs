//! Invalid messages and configs are logged once and do not end the node.

use rcs_tests::ros::{wait_until, PATIENCE};
use rcs_tests::stand::{config, CameraPub, Stand, CLOUD};

#[test]
fn a_cloud_with_too_little_data_is_dropped_and_logged_once() {
    let stand = Stand::start(&config(&[CLOUD], &[CameraPub::default()]), &[]).unwrap();
    stand.puppet("latch('/tf_static', tf('map', 'eye'))");
    stand.puppet("latch('/eye/camera_info', info()); eye = Eye('/view/image')");
    stand.puppet("latch('/cloud', cloud(0xff0000))");
    stand.wait_for("eye.middle() == (255, 0, 0)");
    stand.puppet("short = cloud(0x00ff00); short.data = short.data[:-1]");
    stand.puppet("repeated = PublishRepeatedly(20, lambda i: short, '/cloud')");
    let said = || stand.log_lines(&["display cloud", "Dropping message"]);
    assert!(wait_until(PATIENCE, || said() > 0), "{}", stand.log());
    stand.puppet("repeated.stop()");
    stand.puppet("latch('/cloud', cloud(0x0000ff))");
    stand.wait_for("eye.middle() == (0, 0, 255)");
    assert_eq!(said(), 1, "{}", stand.log());
    assert_eq!(stand.puppet("(0, 255, 0) in eye.colors"), "False");
}

#[test]
fn a_display_whose_frame_is_missing_is_logged() {
    let stand = Stand::start(&config(&[CLOUD], &[CameraPub::default()]), &[]).unwrap();
    stand.puppet("latch('/tf_static', tf('map', 'eye')); latch('/cloud', cloud(0xff0000, 'lost'))");
    let said = || stand.log_lines(&["WARN", "display cloud", "Frame [lost] does not exist"]);
    assert!(wait_until(PATIENCE, || said() == 1), "{}", stand.log());
}

#[test]
fn an_unknown_display_class_is_logged_and_the_other_displays_are_drawn() {
    let displays = [
        "{Class: rviz/InteractiveMarkers, Name: robot, Enabled: true}",
        "{Class: fancy_plugins/Hologram, Name: ghost, Enabled: true, Topic: /cloud}",
        "{Class: rviz/Group, Name: group, Enabled: true, Displays: [{Class: rviz/Map, Name: floor, Enabled: true}]}",
        CLOUD,
    ];
    let stand = Stand::start(&config(&displays, &[CameraPub::default()]), &[]).unwrap();
    stand.puppet("latch('/tf_static', tf('map', 'eye'))");
    stand.puppet("latch('/eye/camera_info', info()); latch('/cloud', cloud(0xff0000)); eye = Eye('/view/image')");
    stand.wait_for("eye.middle() == (255, 0, 0)");
    assert_eq!(stand.log_lines(&["WARN", "scene.rviz", "line 4", "fancy_plugins/Hologram"]), 1, "{}", stand.log());
}

#[test]
fn several_cameras_render_one_scene() {
    let camera = |name, image, info, background| CameraPub { name, image, info, background, ..CameraPub::default() };
    let cameras = [
        CameraPub { namespace: "left", ..camera("Left", "/left/image", "/left/lens", "9; 0; 0") },
        CameraPub { namespace: "right", ..camera("Right", "/right/image", "/right/lens", "0; 9; 0") },
    ];
    let stand = Stand::start(&config(&[CLOUD], &cameras), &[]).unwrap();
    stand.puppet("latch('/tf_static', tf('map', 'eye'))");
    stand.puppet("latch('/left/lens', info()); latch('/right/lens', info(width=80, height=20))");
    stand.puppet("eye = Eye('/left/image'); right = Eye('/right/image')");
    stand.wait_for("eye.middle() == (9, 0, 0) and right.middle() == (0, 9, 0)");
    stand.puppet("latch('/cloud', cloud(0x0000ff))");
    stand.wait_for("eye.middle() == (0, 0, 255) and right.middle() == (0, 0, 255)");
    assert_eq!(stand.puppet("(eye.last.width, right.last.width)"), "(64, 80)");
}
