//! The property "Frame Rate" and the trigger service.

use crate::diagnostics::MONITOR;
use rcs_tests::puppet::Puppet;
use rcs_tests::ros::PATIENCE;
use rcs_tests::stand::{config, CameraPub, Stand, CLOUD};
use std::time::Duration;

/// A node with these cameras and publishers of their CameraInfo, their frame and a red cloud.
fn stand(cameras: &[CameraPub]) -> Stand {
    let stand = Stand::start(&config(&[CLOUD], cameras), &[]).unwrap();
    stand.puppet("latch('/tf_static', tf('map', 'eye'))");
    stand.puppet("latch('/eye/camera_info', info())");
    stand.puppet("latch('/cloud', cloud(0xff0000))");
    // The node has connected to all of them; latched messages arrive with the connection.
    stand.wait_for("all(out.get_num_connections() > 0 for out in publishers.values())");
    stand
}

/// Collects the node's diagnostics.
fn monitor(stand: &Stand) {
    stand.puppet("topic = '/diagnostics'");
    stand.puppet(MONITOR);
}

/// Pictures per second that the eye got.
fn rate(stand: &Stand) -> f64 {
    stand.puppet("(len(eye.images) - 1) / (eye.images[-1][0] - eye.images[0][0])").parse().unwrap()
}

#[test]
fn below_0_an_unchanged_scene_is_repeated_at_the_global_rate_and_a_change_appears_at_once() {
    let stand = stand(&[CameraPub::default()]);
    stand.puppet("eye = Eye('/view/image')");
    stand.wait_for("eye.middle() == (255, 0, 0)");
    stand.puppet("eye.forget()");
    stand.wait_for("len(eye.images) > 90");
    let rate = rate(&stand);
    assert!((20.0..36.0).contains(&rate), "{rate} pictures a second");
    assert_eq!(stand.puppet("len({i[6] for i in eye.images})"), "1", "the same picture");
    let stamps = "all(a[2] < b[2] for a, b in zip(eye.images, eye.images[1:]))";
    assert_eq!(stand.puppet(stamps), "True", "with fresh stamps");
    stand.puppet("eye.forget(); changed = time.time(); latch('/cloud', cloud(0x0000ff))");
    stand.wait_for("eye.middle() == (0, 0, 255)");
}

#[test]
fn changes_below_0_are_not_held_back_to_the_global_rate() {
    let stand = stand(&[CameraPub::default()]);
    stand.puppet("eye = Eye('/view/image')");
    stand.wait_for("eye.middle() == (255, 0, 0)");
    stand.puppet("repeated = PublishRepeatedly(100, lambda i: cloud(i & 0xffffff), '/cloud'); eye.forget()");
    stand.wait_for("len(eye.images) > 150");
    let rate = rate(&stand);
    assert!(rate > 36.0, "{rate} pictures a second, for a scene that changes 100 times");
}

#[test]
fn at_0_there_is_one_picture_for_each_trigger_and_none_without() {
    let stand = stand(&[CameraPub { rate: "0", ..CameraPub::default() }]);
    stand.puppet("eye = Eye('/view/image')");
    stand.wait_for("all(s.get_num_connections() for s in eye.subscribers)");
    // No picture may come without a trigger.
    std::thread::sleep(Duration::from_secs(1));
    assert_eq!(stand.puppet("eye.images"), "[]");
    let said = stand.master.output("rosservice", &["call", "/camera_trigger"]).unwrap();
    assert!(said.contains("success: True"), "{said}");
    assert!(said.contains("message: \"New image will be published on: /view/image\""), "{said}");
    stand.wait_for("len(eye.images) == 1 and eye.middle() == (255, 0, 0)");
    for count in 2..5 {
        stand.puppet(format!("latch('/cloud', cloud(0x00ff0{count}))"));
        assert_eq!(stand.puppet("trigger('/camera_trigger')"), "(True, 'New image will be published on: /view/image')");
        stand.wait_for(format!("len(eye.images) == {count}"));
    }
    // No further picture may come without a further trigger.
    std::thread::sleep(Duration::from_secs(1));
    assert_eq!(stand.puppet("len(eye.images), len(eye.infos)"), "(4, 4)");
}

#[test]
fn above_0_pictures_come_at_that_rate() {
    let stand = stand(&[CameraPub { rate: "8", ..CameraPub::default() }]);
    stand.puppet("repeated = PublishRepeatedly(50, lambda i: cloud(i), '/cloud'); eye = Eye('/view/image')");
    stand.wait_for("len(eye.images) > 20");
    let rate = rate(&stand);
    assert!((6.5..9.0).contains(&rate), "{rate} pictures a second");
    assert_eq!(stand.puppet("trigger('/camera_trigger')[0]"), "True");
}

#[test]
fn the_first_subscriber_gets_a_picture_at_once() {
    let stand = stand(&[CameraPub { rate: "0.02", ..CameraPub::default() }]);
    // The node has received all that it needs before the first subscriber comes.
    monitor(&stand);
    stand.wait_for("level('camera_stream: CameraPub') == 0 and level('camera_stream: cloud') == 0");
    stand.puppet("eye = Eye('/view/image')");
    stand.wait_for("len(eye.images) >= 1 and eye.middle() == (255, 0, 0)");
    // Nor does another one wait for the 50 s of this rate.
    let other = Puppet::start(&stand.master, &["__name:=other"]).unwrap();
    other.run("eye = Eye('/view/image')").unwrap();
    assert!(other.wait_for(PATIENCE, "eye.middle() == (255, 0, 0)"));
}

#[test]
fn nothing_is_rendered_without_subscribers() {
    let stand = stand(&[CameraPub::default()]);
    stand.puppet("latch('/eye/camera_info', info(width=1280, height=800, f=900.0))");
    // A hundred squares of half the picture, each in front of the last one, take time to render.
    stand.puppet("latch('/cloud', cloud(0xff0000, points=[(0, 0, 4 - z / 50) for z in range(100)]))");
    // With a moving camera every picture is different.
    stand.puppet("moving = lambda i: tf('map', 'moving', xyz=(i * 1e-4, 0, 0), stamp=rospy.Time.now())");
    stand.puppet("repeated = PublishRepeatedly(60, moving, '/tf')");
    stand.puppet("latch('/eye/camera_info', info(frame='moving', width=1280, height=800, f=900.0))");
    stand.puppet("eye = Eye('/view/image')");
    stand.wait_for("len({i[6] for i in eye.images}) > 10");
    let watched = cpu_ticks_in_2_secs(&stand);
    monitor(&stand);
    stand.puppet("eye.close()");
    stand.wait_for("values('camera_stream: CameraPub').get('subscribers') == '0'");
    let unwatched = cpu_ticks_in_2_secs(&stand);
    assert!(unwatched * 5 < watched, "{unwatched} ticks of CPU time unwatched, {watched} watched");
}

/// The CPU time that the node takes in two seconds.
fn cpu_ticks_in_2_secs(stand: &Stand) -> u64 {
    let ticks = || -> u64 {
        let stat = std::fs::read_to_string(format!("/proc/{}/stat", stand.node.id())).unwrap();
        let fields: Vec<&str> = stat.rsplit(')').next().unwrap().split_whitespace().collect();
        // After the name: fields 14 and 15 of proc(5).
        fields[11].parse::<u64>().unwrap() + fields[12].parse::<u64>().unwrap()
    };
    let before = ticks();
    // The time that is measured.
    std::thread::sleep(Duration::from_secs(2));
    ticks() - before
}

#[test]
fn a_camera_without_image_topic_cannot_be_triggered() {
    let stand = stand(&[CameraPub { image: "", ..CameraPub::default() }]);
    assert_eq!(stand.puppet("trigger('/camera_trigger')"), "(False, 'Image publisher not configured')");
}

#[test]
fn triggers_are_in_the_display_namespaces_and_a_shared_one_is_a_warning() {
    let camera = |name, image, namespace| CameraPub { name, image, namespace, rate: "0", ..CameraPub::default() };
    let cameras = [
        camera("Left", "/left/image", "left"),
        camera("Right", "/right/image", "right"),
        camera("Other", "/other/image", "right"),
    ];
    let stand = stand(&cameras);
    assert_eq!(stand.log_lines(&["WARN", "Right", "Other", "right"]), 1, "{}", stand.log());
    stand.puppet("eye = Eye('/left/image'); right = Eye('/right/image')");
    stand.wait_for("all(s.get_num_connections() for s in eye.subscribers + right.subscribers)");
    let answer = |topic| format!("(True, 'New image will be published on: {topic}')");
    assert_eq!(stand.puppet("trigger('/left/camera_trigger')"), answer("/left/image"));
    stand.wait_for("len(eye.images) == 1");
    assert_eq!(stand.puppet("trigger('/right/camera_trigger')"), answer("/right/image"));
    stand.wait_for("len(right.images) == 1");
    assert_eq!(stand.puppet("len(eye.images)"), "1");
}
