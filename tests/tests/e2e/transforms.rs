//! Frames: clouds wait for theirs, invalid transforms are refused, a leading slash is ignored.

use rcs_tests::ros::wait_until;
use rcs_tests::stand::{config, CameraPub, Stand, CLOUD};
use std::time::Duration;

/// A node whose camera sees an empty scene.
fn stand(args: &[&str]) -> Stand {
    let stand = Stand::start(&config(&[CLOUD], &[CameraPub::default()]), args).unwrap();
    stand.puppet("latch('/tf_static', tf('map', 'eye'))");
    stand.puppet("latch('/eye/camera_info', info())");
    stand.puppet("eye = Eye('/view/image')");
    stand.wait_for("eye.middle() == (0, 0, 0)");
    stand
}

/// Asserts that the next twenty pictures are empty.
fn nothing_appears(stand: &Stand) {
    stand.puppet("eye.forget()");
    stand.wait_for("len(eye.images) > 20");
    assert_eq!(stand.puppet("eye.colors"), "[(0, 0, 0)]");
}

#[test]
fn a_cloud_waits_for_its_frame() {
    let stand = stand(&[]);
    stand.puppet("now = rospy.Time.now(); latch('/cloud', cloud(0xff0000, 'table', stamp=now))");
    nothing_appears(&stand);
    stand.puppet("send('/tf', tf('map', 'table', stamp=now - rospy.Duration(0.5)))");
    // It is transformed at its own stamp, for which there is no transform yet.
    nothing_appears(&stand);
    stand.puppet("send('/tf', tf('map', 'table', stamp=now + rospy.Duration(0.5)))");
    stand.wait_for("eye.middle() == (255, 0, 0)");
}

#[test]
fn a_cloud_is_placed_where_its_frame_was_at_its_stamp() {
    let stand = stand(&[]);
    stand.puppet("now = rospy.Time.now()");
    // The table moves by 2 m in a second: half way the cloud is in the middle.
    stand.puppet("send('/tf', tf('map', 'table', xyz=(-1, 0, 0), stamp=now))");
    stand.puppet("send('/tf', tf('map', 'table', xyz=(1, 0, 0), stamp=now + rospy.Duration(1)))");
    stand.puppet("latch('/cloud', cloud(0x00ff00, 'table', stamp=now + rospy.Duration(0.5)))");
    stand.wait_for("eye.middle() == (0, 255, 0)");
    assert_eq!(stand.puppet("eye.pixel(21, 24), eye.pixel(43, 24)"), "((0, 255, 0), (0, 255, 0))");
    // Stamp zero means the latest transform: 1 m to the right, which is 25 pixels.
    stand.puppet("latch('/cloud', cloud(0x0000ff, 'table', points=((-0.5, 0, 2),)))");
    stand.wait_for("eye.pixel(44, 24) == (0, 0, 255)");
    assert_eq!(stand.puppet("eye.pixel(28, 24)"), "(0, 0, 0)");
}

#[test]
fn invalid_rotations_are_refused_and_logged_with_their_publisher_and_frame() {
    let stand = stand(&[]);
    stand.puppet("nan = float('nan')");
    for (number, rotation) in ["(0, 0, 0, 0.9)", "(0, nan, 0, 1)", "(0, 0, 0, 0)"].into_iter().enumerate() {
        let frame = format!("table{number}");
        stand.puppet(format!("send('/tf', tf('map', '{frame}', q={rotation}))"));
        stand.wait_for_log(&frame).unwrap();
        assert_eq!(stand.log_lines(&["WARN", "/puppet", &frame]), 1, "{}", stand.log());
        stand.puppet(format!("latch('/cloud', cloud(0xff0000, '{frame}'))"));
        nothing_appears(&stand);
        stand.puppet(format!("send('/tf', tf('map', '{frame}', q={rotation}))"));
    }
    stand.puppet("send('/tf', tf('map', 'table2'))");
    stand.wait_for("eye.middle() == (255, 0, 0)");
    assert_eq!(stand.log_lines(&["WARN", "/puppet"]), 3, "each is said once: {}", stand.log());
}

#[test]
fn a_leading_slash_of_a_frame_name_is_ignored() {
    let stand = stand(&[]);
    stand.puppet("latch('/tf_static', tf('/map', '/hand'))");
    stand.puppet("latch('/eye/camera_info', info(frame='/hand'))");
    stand.puppet("latch('/cloud', cloud(0xff0000, '/map'))");
    stand.wait_for("eye.middle() == (255, 0, 0) and eye.last.header.frame_id == '/hand'");
    stand.puppet("latch('/cloud', cloud(0x00ff00, 'hand'))");
    stand.wait_for("eye.middle() == (0, 255, 0)");
}

#[test]
fn the_fixed_frame_can_be_chosen_on_the_command_line() {
    // There is no frame `map`, which the config names.
    let stand = Stand::start(&config(&[CLOUD], &[CameraPub::default()]), &["-f", "/world"]).unwrap();
    stand.puppet("latch('/tf_static', tf('world', 'eye', xyz=(5, 0, 0)))");
    stand.puppet("latch('/eye/camera_info', info())");
    stand.puppet("latch('/cloud', cloud(0xff0000, 'world', points=((5, 0, 2),)))");
    stand.puppet("eye = Eye('/view/image')");
    stand.wait_for("eye.middle() == (255, 0, 0)");
}

#[test]
fn a_camera_whose_frame_is_missing_logs_it_and_starts_when_it_arrives() {
    let stand = Stand::start(&config(&[CLOUD], &[CameraPub::default()]), &[]).unwrap();
    stand.puppet("latch('/cloud', cloud(0xff0000))");
    stand.puppet("latch('/eye/camera_info', info(frame='lens'))");
    stand.puppet("eye = Eye('/view/image')");
    let named = || stand.log_lines(&["WARN", "CameraPub", "lens", "map"]) == 1;
    assert!(wait_until(Duration::from_secs(30), named), "{}", stand.log());
    // No picture may come while the frame is missing.
    std::thread::sleep(Duration::from_millis(500));
    assert_eq!(stand.puppet("eye.images"), "[]");
    stand.puppet("latch('/tf_static', tf('map', 'lens'))");
    stand.wait_for("eye.middle() == (255, 0, 0)");
    assert!(named(), "said once: {}", stand.log());
}
