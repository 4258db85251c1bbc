//! Invalid messages and configs are logged once and do not end the node.

use rcs_tests::programs::repository;
use rcs_tests::ros::{wait_until, PATIENCE};
use rcs_tests::ros_fixture::{Setup, CLOUD};
use std::time::Instant;

#[test]
fn a_cloud_with_too_little_data_is_dropped_and_logged_once() {
    let fixture = Setup::of(&[CLOUD]).showing_red();
    fixture.python("short = cloud(0x00ff00); short.data = short.data[:-1]");
    fixture.python("repeated = PublishRepeatedly(20, lambda i: short, '/cloud')");
    let warnings = || fixture.log_lines(&["display cloud", "Dropping message"]);
    assert!(wait_until(PATIENCE, || warnings() > 0), "{}", fixture.log());
    fixture.python("repeated.stop()");
    fixture.python("latch('/cloud', cloud(0x0000ff))");
    fixture.wait_for("viewer.middle() == (0, 0, 255)");
    assert_eq!(warnings(), 1, "{}", fixture.log());
    assert_eq!(fixture.python("(0, 255, 0) in viewer.colors"), "False");
}

/// Thirty a second, each of which the decoder of JPEG panics on.
#[test]
fn damaged_jpegs_are_logged_and_neither_end_the_node_nor_stop_the_image() {
    const DEPTH: &str = "{Class: rviz/DepthCloud, Name: depth, Enabled: true, Depth Map Topic: /d/image, \
                         Color Image Topic: /c/image, Color Transport Hint: compressed}";
    let fixture = Setup::of(&[CLOUD, DEPTH]).showing_red();
    let input = repository().join("fuzz/regressions/compressed_image/jpeg_whose_decoder_panics");
    // The input's first byte chooses the format.
    fixture.python(format!("jpeg = open('{}', 'rb').read()[1:]", input.display()));
    fixture.python("from sensor_msgs.msg import CompressedImage");
    fixture.python("bad = CompressedImage(format='rgb8; jpeg compressed bgr8', data=jpeg)");
    let begin = Instant::now();
    fixture.python("repeated = PublishRepeatedly(30, lambda i: bad, '/c/image/compressed')");
    let is_counted = || fixture.log_lines(&["panicked at", "more like this before"]) > 1;
    assert!(wait_until(PATIENCE, is_counted), "{}", fixture.log());
    // Once a second, from the second on with a count.
    let panics = fixture.log_lines(&["ERROR", "panicked at", "zune-jpeg"]) as u64;
    assert!(panics < 4 + begin.elapsed().as_secs(), "{}", fixture.log());
    let status = ["display depth", "Cannot decode an image of /c/image/compressed: the Jpeg decoder panicked"];
    assert!(wait_until(PATIENCE, || fixture.log_lines(&status) > 0), "{}", fixture.log());
    fixture.python("latch('/cloud', cloud(0x0000ff))");
    fixture.wait_for("viewer.middle() == (0, 0, 255)");
    fixture.python("repeated.stop()");
}

#[test]
fn an_unknown_display_class_is_logged_and_the_other_displays_are_drawn() {
    let displays = [
        "{Class: rviz/InteractiveMarkers, Name: robot, Enabled: true}",
        "{Class: fancy_plugins/Hologram, Name: ghost, Enabled: true, Topic: /cloud}",
        "{Class: rviz/Group, Name: group, Enabled: true, Displays: [{Class: rviz/Map, Name: floor, Enabled: true}]}",
        CLOUD,
    ];
    let fixture = Setup::of(&displays).showing_red();
    assert_eq!(fixture.log_lines(&["WARN", "scene.rviz", "line 4", "fancy_plugins/Hologram"]), 1, "{}", fixture.log());
}
