//! `~stale_timeout`: when a process of the chain dies, the image turns black by itself, and comes back at once.

use rcs_tests::python_node::PythonNode;
use rcs_tests::ros::Running;
use rcs_tests::ros_fixture::{CameraPub, RosFixture, Setup, CLOUD};
use std::time::Duration;

/// A second cloud, beside the first one.
const OTHER_CLOUD: &str = "{Class: rviz/PointCloud2, Name: other, Enabled: true, Topic: /other, Style: Flat Squares, \
     Size (m): 1, Color Transformer: RGB8, Position Transformer: XYZ, Queue Size: 10, Alpha: 1, Decay Time: 0}";

const RED: &str = "viewer.middle() == (255, 0, 0)";
/// The image goes on, and is black but for a note at its lower left.
const BLACK: &str = "viewer.middle() == (0, 0, 0) and 0 < sum(viewer.last.data) < 40 * len(viewer.last.data) \
     and sum(viewer.last.data[:len(viewer.last.data) // 2]) == 0";

/// A node that turns black after half a second and says why, and a viewer. Nobody publishes anything yet.
fn fixture(args: &[&str]) -> RosFixture {
    let args = [&["--stale-timeout", "0.5", "--stale-note"], args].concat();
    let fixture = Setup::of(&[CLOUD, OTHER_CLOUD]).args(&args).start();
    fixture.python("viewer = Viewer('/view/image')");
    fixture
}

/// Another node, which ends by SIGKILL when this is dropped.
fn other_node(fixture: &RosFixture, python: &str) -> PythonNode {
    let node = PythonNode::start(&fixture.master, &["__name:=other_node"]).unwrap();
    node.run(python).unwrap();
    node
}

const CLOUDS: &str = "PublishRepeatedly(20, lambda i: cloud(0xff0000, stamp=rospy.Time.now()), '/cloud')";
const FRAMES: &str = "PublishRepeatedly(20, lambda i: tf('map', 'eye', stamp=rospy.Time.now()), '/tf')";
const INFO: &str = "latch('/eye/camera_info', info())";

/// Asserts that the image turns black when the node that this code runs in is killed, while the rest goes on, and
/// comes back with another one.
fn dies(rest: [&str; 2], dying: &str, because: &str) {
    let fixture = fixture(&[]);
    rest.iter().for_each(|part| drop(fixture.python(part)));
    let node = other_node(&fixture, dying);
    fixture.wait_for(RED);
    // It stays while all of them are alive, also what is latched and so not sent again.
    fixture.shows_only("(255, 0, 0)", Duration::from_millis(1500));
    drop(node);
    fixture.wait_for(BLACK);
    fixture.wait_for_log(because).unwrap();
    // Black images are repeated like others, for those who join.
    fixture.python("viewer.forget()");
    fixture.wait_for(format!("len(viewer.images) > 10 and {BLACK}"));
    let _node = other_node(&fixture, dying);
    fixture.wait_for(RED);
}

#[test]
fn the_image_turns_black_when_the_publisher_of_cloud_frame_or_camera_info_is_killed() {
    for (rest, dying, because) in [
        ([FRAMES, INFO], CLOUDS, "cloud: no data on /cloud"),
        ([CLOUDS, INFO], FRAMES, "eye: no transform"),
        ([CLOUDS, FRAMES], INFO, "CameraInfo: no data on /eye/camera_info"),
    ] {
        dies(rest, dying, &format!("the picture is black: {because} of the last 0.5 s"));
    }
}

#[test]
fn one_display_that_is_too_old_leaves_the_others_in_the_image() {
    let fixture = fixture(&[]);
    [FRAMES, INFO].iter().for_each(|part| drop(fixture.python(part)));
    let beside = "cloud(0x0000ff, points=((1, 0, 2),), stamp=rospy.Time.now())";
    fixture.python(format!("PublishRepeatedly(20, lambda i: {beside}, '/other')"));
    let node = other_node(&fixture, CLOUDS);
    fixture.wait_for(format!("{RED} and viewer.pixel(57, 24) == (0, 0, 255)"));
    drop(node);
    fixture.wait_for("viewer.middle() == (0, 0, 0) and viewer.pixel(57, 24) == (0, 0, 255)");
    fixture.wait_for_log("not drawn: cloud: no data on /cloud of the last 0.5 s").unwrap();
    assert_eq!(fixture.log_lines(&["the picture is black: cloud"]), 0, "{}", fixture.log());
}

#[test]
fn limits_are_parameters_too_and_single_topics_are_exempt() {
    let args = ["_stale_timeout:=0.5", "_stale_timeouts:=[{topic: /other, limit: never}]"];
    let fixture = Setup::of(&[CLOUD, OTHER_CLOUD]).args(&args).start();
    fixture.python("viewer = Viewer('/view/image')");
    fixture.python("latch('/tf_static', tf('map', 'eye'))");
    fixture.python(INFO);
    fixture.python("send('/cloud', cloud(0xff0000))");
    fixture.python("send('/other', cloud(0x0000ff, points=((1, 0, 2),)))");
    fixture.wait_for("viewer.middle() == (0, 0, 0) and viewer.pixel(57, 24) == (0, 0, 255)");
    std::thread::sleep(Duration::from_millis(700));
    assert_eq!(fixture.python("viewer.pixel(57, 24)"), "(0, 0, 255)");
}

#[test]
fn a_camera_that_is_only_triggered_turns_black_too_and_a_image_without_a_note_is_all_black() {
    let camera = CameraPub { rate: "0", ..CameraPub::default() };
    let fixture = Setup::with_cameras(&[CLOUD], &[camera]).args(&["--stale-timeout", "0.5"]).start();
    fixture.python("viewer = Viewer('/view/image')");
    fixture.python("latch('/tf_static', tf('map', 'eye'))");
    fixture.python(INFO);
    let node = other_node(&fixture, CLOUDS);
    fixture.wait_for("trigger('/camera_trigger')[0] and viewer.middle() == (255, 0, 0)");
    drop(node);
    fixture.wait_for("viewer.last and max(viewer.last.data) == 0");
}

#[test]
fn the_image_turns_black_when_projector_or_publish_cloud_is_killed() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        path.display().to_string()
    };
    let projector = file(
        "projector.yaml",
        "{frame_id: eye, width: 64, height: 48, K: [50, 0, 32, 0, 50, 24, 0, 0, 1], camera_info_topic: /eye/camera_info, \
         frames: [{parent: map, child: eye}]}",
    );
    let header = "FIELDS x y z rgb\nSIZE 4 4 4 4\nTYPE F F F U\nWIDTH 1\nHEIGHT 1\nDATA ascii\n";
    let cloud = file("cloud.pcd", &format!("{header}0 0 2 16711680\n"));
    let fixture = fixture(&[]);
    let start = |args: &[&str]| Running::start(fixture.master.program(args[0]).args(&args[1..])).unwrap();
    let projector: &[&str] = &["projector", &projector];
    let cloud: &[&str] = &["publish_cloud", &cloud, "--rate", "0", "--topic", "/cloud"];
    let mut running = [start(projector), start(cloud)];
    fixture.wait_for(RED);
    let whats = [(projector, "CameraInfo: no data on /eye/camera_info"), (cloud, "cloud: no data on /cloud")];
    for (place, (program, because)) in running.iter_mut().zip(whats) {
        // What is latched does not age while its publisher lives.
        fixture.shows_only("(255, 0, 0)", Duration::from_millis(1000));
        place.signal("KILL");
        fixture.wait_for(BLACK);
        fixture.wait_for_log(&format!("the picture is black: {because} of the last 0.5 s")).unwrap();
        *place = start(program);
        fixture.wait_for(RED);
    }
}

#[test]
fn without_a_limit_old_data_stay_for_ever_as_in_rviz() {
    let fixture = Setup::of(&[CLOUD]).start();
    fixture.python("viewer = Viewer('/view/image')");
    let node = other_node(&fixture, &[CLOUDS, FRAMES, INFO].join("\n"));
    fixture.wait_for(RED);
    drop(node);
    std::thread::sleep(Duration::from_millis(1500));
    fixture.python("viewer.forget()");
    fixture.wait_for(format!("len(viewer.images) > 10 and {RED}"));
    assert_eq!(fixture.python("viewer.colors"), "[(255, 0, 0)]");
}
