//! The property "Frame Rate" and the trigger service.

use rcs_tests::python_node::PythonNode;
use rcs_tests::ros::PATIENCE;
use rcs_tests::ros_fixture::{CameraPub, RosFixture, Setup, CLOUD};
use std::time::Duration;

/// Name, image topic, display namespace and frame rate of the cameras of one node.
const CAMERAS: [(&str, &str, &str, &str); 5] = [
    ("CameraPub", "/view/image", "", "0"),
    ("Rare", "/rare/image", "rare", "0.0001"),
    ("Repeated", "/repeated/image", "repeated", "-1"),
    ("Limited", "/limited/image", "limited", "8"),
    ("Nowhere", "", "nowhere", "-1"),
];
/// Each from a red square.
const SCENARIOS: [fn(&RosFixture); 6] = [
    the_first_subscriber_gets_an_image_at_once,
    at_0_there_is_one_image_for_each_trigger_and_none_without,
    below_0_an_unchanged_scene_is_repeated_at_the_global_rate_and_a_change_appears_at_once,
    changes_below_0_make_images_at_most_at_the_global_rate_in_the_long_run,
    above_0_images_come_at_that_rate,
    a_camera_without_image_topic_cannot_be_triggered,
];

#[test]
fn each_camera_has_its_frame_rate() {
    let camera = |(name, image, namespace, rate)| CameraPub { name, image, namespace, rate, ..CameraPub::default() };
    let fixture = start(&CAMERAS.map(camera));
    for scenario in SCENARIOS {
        fixture.python("latch('/cloud', cloud(0xff0000))");
        scenario(&fixture);
        fixture.python("viewer.close()");
    }
}

/// A node with these cameras and publishers of their CameraInfo, their frame and a red cloud.
fn start(cameras: &[CameraPub]) -> RosFixture {
    let fixture = Setup::with_cameras(&[CLOUD], cameras).start();
    fixture.python("place_camera(); latch('/cloud', cloud(0xff0000))");
    // The node has connected to all of them; latched messages arrive with the connection.
    fixture.wait_for("all(out.get_num_connections() > 0 for out in publishers.values())");
    fixture
}

/// Asserts that the images that the viewer received were made at most so often, by their stamps. How many a slow
/// machine makes is its own affair; that no more are left out than need be, is tested with simulated times.
pub(crate) fn at_most(fixture: &RosFixture, viewer: &str, most_hz: f64) {
    let stamps = format!("[image[2] for image in {viewer}.images]");
    let rate = fixture.python(format!("(lambda s: (len(s) - 1) / (s[-1] - s[0]))({stamps})"));
    println!("{rate} pictures a second, of {most_hz}");
    assert!(rate.parse::<f64>().unwrap() < 1.2 * most_hz, "{rate} pictures a second");
}

fn below_0_an_unchanged_scene_is_repeated_at_the_global_rate_and_a_change_appears_at_once(fixture: &RosFixture) {
    fixture.python("viewer = Viewer('/repeated/image')");
    fixture.wait_for("viewer.middle() == (255, 0, 0)");
    fixture.python("viewer.forget()");
    fixture.wait_for("len(viewer.images) > 90");
    at_most(fixture, "viewer", 30.0);
    assert_eq!(fixture.python("len({i[6] for i in viewer.images})"), "1", "the same picture");
    let stamps = "all(a[2] < b[2] for a, b in zip(viewer.images, viewer.images[1:]))";
    assert_eq!(fixture.python(stamps), "True", "with fresh stamps");
    fixture.python("viewer.forget(); changed = time.time(); latch('/cloud', cloud(0x0000ff))");
    fixture.wait_for("viewer.middle() == (0, 0, 255)");
}

fn changes_below_0_make_images_at_most_at_the_global_rate_in_the_long_run(fixture: &RosFixture) {
    fixture.python("viewer = Viewer('/repeated/image')");
    fixture.wait_for("viewer.middle() == (255, 0, 0)");
    fixture.python("repeated = PublishRepeatedly(100, lambda i: cloud(i & 0xffffff), '/cloud'); viewer.forget()");
    fixture.wait_for("len(viewer.images) > 150");
    at_most(fixture, "viewer", 30.0);
    fixture.python("repeated.stop()");
}

fn at_0_there_is_one_image_for_each_trigger_and_none_without(fixture: &RosFixture) {
    fixture.python("viewer = Viewer('/view/image')");
    fixture.wait_for("all(s.get_num_connections() for s in viewer.subscribers)");
    // No image may come without a trigger.
    std::thread::sleep(Duration::from_secs(1));
    assert_eq!(fixture.python("viewer.images"), "[]");
    let printed = fixture.master.output("rosservice", &["call", "/camera_trigger"]).unwrap();
    assert!(printed.contains("success: True"), "{printed}");
    assert!(printed.contains("message: \"New image will be published on: /view/image\""), "{printed}");
    fixture.wait_for("len(viewer.images) == 1 and viewer.middle() == (255, 0, 0)");
    for count in 2..5 {
        fixture.python(format!("latch('/cloud', cloud(0x00ff0{count}))"));
        assert_eq!(
            fixture.python("trigger('/camera_trigger')"),
            "(True, 'New image will be published on: /view/image')"
        );
        fixture.wait_for(format!("len(viewer.images) == {count}"));
    }
    // No further image may come without a further trigger.
    std::thread::sleep(Duration::from_secs(1));
    assert_eq!(fixture.python("len(viewer.images), len(viewer.infos)"), "(4, 4)");
}

fn above_0_images_come_at_that_rate(fixture: &RosFixture) {
    fixture.python("repeated = PublishRepeatedly(50, lambda i: cloud(i), '/cloud'); viewer = Viewer('/limited/image')");
    fixture.wait_for("len(viewer.images) > 20");
    at_most(fixture, "viewer", 8.0);
    assert_eq!(fixture.python("trigger('/limited/camera_trigger')[0]"), "True");
    fixture.python("repeated.stop()");
}

fn the_first_subscriber_gets_an_image_at_once(fixture: &RosFixture) {
    // The node has received all that it needs before the first subscriber comes.
    fixture.python("monitor()");
    fixture.wait_for("level('camera_stream: Rare') == 0 and level('camera_stream: cloud') == 0");
    fixture.python("viewer = Viewer('/rare/image')");
    fixture.wait_for("len(viewer.images) >= 1 and viewer.middle() == (255, 0, 0)");
    // Nor does another one wait for the hours of this rate.
    let other = PythonNode::start(&fixture.master, &["__name:=other"]).unwrap();
    other.run("viewer = Viewer('/rare/image')").unwrap();
    assert!(other.wait_for(PATIENCE, "viewer.middle() == (255, 0, 0)"));
}

fn a_camera_without_image_topic_cannot_be_triggered(fixture: &RosFixture) {
    assert_eq!(fixture.python("trigger('/nowhere/camera_trigger')"), "(False, 'Image publisher not configured')");
}

#[test]
fn triggers_are_in_the_display_namespaces_and_a_shared_one_is_a_warning() {
    let camera = |name, image, namespace| CameraPub { name, image, namespace, rate: "0", ..CameraPub::default() };
    let cameras = [
        camera("Left", "/left/image", "left"),
        camera("Right", "/right/image", "right"),
        camera("Other", "/other/image", "right"),
    ];
    let fixture = start(&cameras);
    assert_eq!(fixture.log_lines(&["WARN", "Right", "Other", "right"]), 1, "{}", fixture.log());
    fixture.python("viewer = Viewer('/left/image'); right = Viewer('/right/image')");
    fixture.wait_for("all(s.get_num_connections() for s in viewer.subscribers + right.subscribers)");
    let answer = |topic| format!("(True, 'New image will be published on: {topic}')");
    assert_eq!(fixture.python("trigger('/left/camera_trigger')"), answer("/left/image"));
    fixture.wait_for("len(viewer.images) == 1");
    assert_eq!(fixture.python("trigger('/right/camera_trigger')"), answer("/right/image"));
    fixture.wait_for("len(right.images) == 1");
    assert_eq!(fixture.python("len(viewer.images)"), "1");
}
