//! `~mask_topic`, `~keep_out`: where there must be no light, and none at all while that is not known.

use rcs_tests::python_node::PythonNode;
use rcs_tests::ros_fixture::{config, CameraPub, RosFixture, CLOUD};

/// A wall of red before the whole view.
const WALL: &str =
    "latch('/cloud', cloud(0xff0000, points=[(0.5 * x, 0.5 * y, 2) for x in range(-5, 6) for y in range(-5, 6)]))";
const ALL_RED: &str = "bytes(viewer.last.data) == b'\\xff\\0\\0' * 64 * 48";
const ALL_BLACK: &str = "viewer.last and max(viewer.last.data) == 0";

/// A mask of the picture's size that is dark on the right of this column.
const MASK: &str = "
def mask(column, encoding='mono8'):
    message = Image(width=64, height=48, step=64, encoding=encoding)
    message.header.stamp = rospy.Time.now()
    message.data = bytes([255] * column + [0] * (64 - column)) * 48
    return message
def only_right_of(column):
    rows = [bytes(viewer.last.data[192 * v : 192 * (v + 1)]) for v in range(48)]
    return all(row == b'\\xff\\0\\0' * column + b'\\0' * 3 * (64 - column) for row in rows)
";

fn fixture(args: &[&str]) -> RosFixture {
    let fixture = RosFixture::start(&config(&[CLOUD], &[CameraPub::default()]), args).unwrap();
    fixture.python("viewer = Viewer('/view/image')");
    fixture.python("latch('/tf_static', tf('map', 'eye'))");
    fixture.python("latch('/eye/camera_info', info())");
    fixture.python(WALL);
    fixture.python(MASK);
    fixture
}

#[test]
fn without_a_current_mask_all_is_black_and_with_one_only_what_it_allows_is_lit() {
    let fixture = fixture(&["_mask_topic:=/mask", "_stale_note:=true", "_stale_timeout:=0.5"]);
    fixture.wait_for(format!("{ALL_BLACK} and len(viewer.images) > 5"));
    fixture.wait_for_log("the picture is black: no mask on /mask yet").unwrap();
    let node = PythonNode::start(&fixture.master, &["__name:=masks"]).unwrap();
    node.run(MASK).unwrap();
    node.run("PublishRepeatedly(20, lambda i: mask(40), '/mask')").unwrap();
    fixture.wait_for("viewer.last and only_right_of(40)");
    drop(node);
    // No note either: it is light, too.
    fixture.wait_for(ALL_BLACK);
    fixture.wait_for_log("the picture is black: mask: no data on /mask of the last 0.5 s").unwrap();
    fixture.python("repeated = PublishRepeatedly(20, lambda i: mask(20), '/mask')");
    fixture.wait_for("only_right_of(20)");
}

#[test]
fn the_last_mask_holds_where_none_is_required_and_one_that_is_none_is_an_error() {
    let fixture = fixture(&["--mask-topic", "CameraPub=/mask", "--mask-required", "false"]);
    fixture.wait_for(format!("viewer.last and {ALL_RED}"));
    fixture.python("send('/mask', mask(33))");
    fixture.wait_for("only_right_of(33)");
    fixture.python("send('/mask', mask(10, 'rgb8'))");
    fixture.wait_for_log("mask on /mask: its encoding is rgb8, not mono8").unwrap();
    std::thread::sleep(std::time::Duration::from_millis(1200));
    assert_eq!(fixture.python("only_right_of(33)"), "True");
}

#[test]
fn no_light_falls_around_a_keep_out_frame_wherever_it_goes_and_none_at_all_while_that_is_unknown() {
    let fixture = fixture(&["--keep-out", "head=0.2"]);
    fixture.wait_for(format!("{ALL_BLACK} and len(viewer.images) > 5"));
    fixture.wait_for_log("the picture is black: keep-out frame head: its place is not known").unwrap();
    fixture.python("place = [0.3]");
    let node = PythonNode::start(&fixture.master, &["__name:=tracker"]).unwrap();
    node.run("place = [0.3]").unwrap();
    node.run("PublishRepeatedly(20, lambda i: tf('map', 'head', (place[0], 0, 1), stamp=rospy.Time.now()), '/tf')")
        .unwrap();
    // At 1 m, the middle is 15 pixels to the right of the picture's and the radius is 10 pixels.
    let dark = "viewer.pixel(47, 24) == (0, 0, 0) and viewer.pixel(38, 24) == (0, 0, 0)";
    let lit = "viewer.pixel(34, 24) == (255, 0, 0) and viewer.pixel(60, 24) == (255, 0, 0)";
    let above_and_below = "viewer.pixel(47, 10) == viewer.pixel(47, 38) == (255, 0, 0)";
    fixture.wait_for(format!("viewer.last and {dark} and {lit} and {above_and_below}"));
    node.run("place[0] = -0.3").unwrap();
    fixture.wait_for("viewer.pixel(17, 24) == (0, 0, 0) and viewer.pixel(47, 24) == (255, 0, 0)");
    drop(node);
    fixture.wait_for(ALL_BLACK);
    fixture.wait_for_log("the picture is black: head: no transform of the last 1 s").unwrap();
}

#[test]
fn a_frame_that_is_not_required_stays_dark_where_it_was_last_in_the_light_of_the_cameras_p() {
    let fixture = fixture(&["--keep-out", "head=0.2", "--mask-required", "false"]);
    // Light is flatter than rviz's picture, whose pixels are square.
    fixture.python("latch('/eye/camera_info', info(P=[50, 0, 32, 0, 0, 25, 24, 0, 0, 0, 1, 0]))");
    fixture.wait_for(format!("viewer.last and {ALL_RED}"));
    fixture.python("send('/tf', tf('map', 'head', (0.3, 0, 1), stamp=rospy.Time.now()))");
    let dark = "viewer.pixel(47, 24) == viewer.pixel(38, 24) == viewer.pixel(47, 20) == (0, 0, 0)";
    let lit = "viewer.pixel(34, 24) == viewer.pixel(47, 16) == viewer.pixel(47, 32) == (255, 0, 0)";
    fixture.wait_for(format!("viewer.last and {dark} and {lit}"));
    std::thread::sleep(std::time::Duration::from_millis(1200));
    fixture.python("viewer.forget()");
    fixture.wait_for(format!("len(viewer.images) > 2 and {dark} and {lit}"));
}

#[test]
fn where_the_lens_is_unknown_nothing_is_lit_around_keep_out_frames() {
    let fixture = fixture(&["--keep-out", "head=0.2"]);
    fixture.python(
        "latch('/tf_static', TFMessage(tf('map', 'eye').transforms + tf('map', 'head', (0.3, 0, 1)).transforms))",
    );
    let dark = "viewer.pixel(47, 24) == (0, 0, 0) and viewer.pixel(34, 24) == (255, 0, 0)";
    fixture.wait_for(format!("viewer.last and {dark}"));
    fixture.python("latch('/eye/camera_info', info(D=[0.1, 0, 0, 0, 0], distortion_model='unheard_of'))");
    fixture.wait_for(ALL_BLACK);
    fixture.wait_for_log("where the lens sends light around keep-out frames is not known").unwrap();
    fixture.python("latch('/eye/camera_info', info(D=[0.01, 0, 0, 0, 0], distortion_model='plumb_bob'))");
    fixture.wait_for(dark);
}
