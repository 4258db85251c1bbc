//! Frames: invalid transforms are refused, a leading slash is ignored, a camera waits for its frame.

use rcs_tests::ros::{wait_until, PATIENCE};
use rcs_tests::ros_fixture::{RosFixture, Setup, CLOUD};
use std::time::Duration;

/// A node whose camera sees an empty scene.
fn fixture() -> RosFixture {
    let fixture = Setup::of(&[CLOUD]).start();
    fixture.python("place_camera()");
    fixture.python("viewer = Viewer('/view/image')");
    fixture.wait_for("viewer.middle() == (0, 0, 0)");
    fixture
}

/// Asserts that the next twenty images are empty.
fn nothing_appears(fixture: &RosFixture) {
    fixture.python("viewer.forget()");
    fixture.wait_for("len(viewer.images) > 20");
    assert_eq!(fixture.python("viewer.colors"), "[(0, 0, 0)]");
}

#[test]
fn invalid_rotations_are_refused_and_logged_with_their_publisher_and_frame() {
    let fixture = fixture();
    fixture.python("nan = float('nan')");
    for (number, rotation) in ["(0, 0, 0, 0.9)", "(0, nan, 0, 1)", "(0, 0, 0, 0)"].into_iter().enumerate() {
        let frame = format!("table{number}");
        fixture.python(format!("send('/tf', tf('map', '{frame}', q={rotation}))"));
        fixture.wait_for_log(&frame).unwrap();
        assert_eq!(fixture.log_lines(&["WARN", "/python_node", &frame]), 1, "{}", fixture.log());
        fixture.python(format!("latch('/cloud', cloud(0xff0000, '{frame}'))"));
        nothing_appears(&fixture);
        fixture.python(format!("send('/tf', tf('map', '{frame}', q={rotation}))"));
    }
    fixture.python("send('/tf', tf('map', 'table2'))");
    fixture.wait_for("viewer.middle() == (255, 0, 0)");
    assert_eq!(fixture.log_lines(&["WARN", "/python_node"]), 3, "each is logged once: {}", fixture.log());
}

#[test]
fn a_leading_slash_of_a_frame_name_is_ignored() {
    let fixture = fixture();
    fixture.python("latch('/tf_static', tf('/map', '/hand'))");
    fixture.python("latch('/eye/camera_info', info(frame='/hand'))");
    fixture.python("latch('/cloud', cloud(0xff0000, '/map'))");
    fixture.wait_for("viewer.middle() == (255, 0, 0) and viewer.last.header.frame_id == '/hand'");
    fixture.python("latch('/cloud', cloud(0x00ff00, 'hand'))");
    fixture.wait_for("viewer.middle() == (0, 255, 0)");
}

#[test]
fn a_camera_whose_frame_is_missing_logs_it_and_starts_when_it_arrives() {
    let fixture = Setup::of(&[CLOUD]).start();
    fixture.python("latch('/cloud', cloud(0xff0000))");
    fixture.python("latch('/eye/camera_info', info(frame='lens'))");
    fixture.python("viewer = Viewer('/view/image')");
    let named = || fixture.log_lines(&["WARN", "CameraPub", "lens", "map"]) == 1;
    assert!(wait_until(PATIENCE, named), "{}", fixture.log());
    // No image may come while the frame is missing.
    std::thread::sleep(Duration::from_millis(500));
    assert_eq!(fixture.python("viewer.images"), "[]");
    fixture.python("latch('/tf_static', tf('map', 'lens'))");
    fixture.wait_for("viewer.middle() == (255, 0, 0)");
    assert!(named(), "logged once: {}", fixture.log());
}
