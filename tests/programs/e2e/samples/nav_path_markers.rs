//! `nav_path_markers`: plans become arrows, the next plan replaces them in one message, none are left at the end.

use rcs_tests::ros::Running;
use rcs_tests::ros_fixture::Setup;

use super::Sample;

/// Publishes plans and keeps the messages with markers, each as ids that are shown and ids that are deleted.
const VIEWER: &str = "
from nav_msgs.msg import Path
from geometry_msgs.msg import PoseStamped
from visualization_msgs.msg import Marker, MarkerArray
from diagnostic_msgs.msg import DiagnosticArray
def plan(*places, frame='map'):
    path = Path()
    path.header.frame_id = frame
    for x, y in places:
        pose = PoseStamped()
        pose.header.frame_id = frame
        pose.pose.position.x, pose.pose.position.y, pose.pose.orientation.w = x, y, 1
        path.poses.append(pose)
    return path
arrays, circles, states = [], [], []
def see(array):
    ids = lambda arrows, action: [marker.id for marker in arrows if marker.action == action]
    arrows = [marker for marker in array.markers if marker.ns == 'nav_path']
    circles.extend((marker.action, marker.pose.position.x, marker.pose.position.y) for marker in array.markers if marker not in arrows)
    arrays.append((ids(arrows, Marker.ADD), ids(arrows, Marker.DELETE), arrows))
viewer = rospy.Subscriber('/arrows', MarkerArray, see)
monitor = rospy.Subscriber('/diagnostics', DiagnosticArray, lambda array: states.extend(array.status))
def tip(marker):
    import math
    yaw = 2 * math.atan2(marker.pose.orientation.z, marker.pose.orientation.w)
    at = marker.pose.position
    return round(at.x + math.cos(yaw) * marker.scale.x, 6), round(at.y + math.sin(yaw) * marker.scale.x, 6)
";

#[test]
fn a_plan_is_arrows_up_to_its_goal_and_the_next_plan_replaces_them_in_one_message() {
    let args = ["/move_base/NavfnROS/plan:=/plan", "--markers-topic", "/arrows", "_spacing:=0.5", "_length:=0.3"];
    let mut sample = Sample::start("nav_path_markers", VIEWER, &[&args[..], &["_color:=255; 0; 0"]].concat());
    sample.python("latch('/plan', plan((0, 0), (1, 0), (1, 2)))");
    sample.wait_for("len(arrays) == 1");
    assert_eq!(sample.python("arrays[0][:2]"), "([0, 1, 2, 3, 4, 5], [])");
    assert_eq!(sample.python("tip(arrays[0][2][-1])"), "(1.0, 2.0)", "the goal");
    assert_eq!(sample.python("tip(arrays[0][2][0])"), "(0.5, 0.0)");
    let first =
        sample.python("[(m.ns, m.type, m.header.frame_id, m.frame_locked, m.color.r) for m in arrays[0][2][:1]]");
    assert_eq!(first, "[('nav_path', 0, 'map', True, 1.0)]");

    sample.python("latch('/plan', plan((0, 0), (1, 0)))");
    sample.wait_for("len(arrays) == 2");
    assert_eq!(sample.python("arrays[1][:2]"), "([0, 1], [2, 3, 4, 5])", "all of it in one message");
    sample.wait_for("any(s.name == 'nav_path_markers: path' and s.message == 'the plan is shown' for s in states)");

    // Who comes late gets the last plan.
    let actions = sample.late("/arrows", "[marker.action for marker in m.markers if marker.ns == 'nav_path']");
    assert_eq!(actions, "[0, 0, 2, 2, 2, 2]");

    sample.end();
    sample.wait_for("len(arrays) == 3");
    assert_eq!(sample.python("arrays[2][:2]"), "([], [0, 1, 2, 3, 4, 5])");
    assert_eq!(
        sample.python("circles"),
        "[(0, 1.0, 2.0), (0, 1.0, 0.0), (2, 0.0, 0.0)]",
        "around each goal, until the end"
    );
}

#[test]
fn of_two_plans_the_last_is_shown_and_an_empty_one_ends_only_its_own() {
    let topics = "_path_topic:=[/plan, /followed]";
    let mut sample = Sample::start("nav_path_markers", VIEWER, &[topics, "--markers-topic", "/arrows"]);
    sample.python("latch('/plan', plan((0, 0), (1, 0)))");
    sample.wait_for("circles == [(0, 1.0, 0.0)]");
    sample.python("latch('/followed', plan((0, 0), (0.5, 0), frame='odom'))");
    sample.wait_for("circles[1:] == [(0, 0.5, 0.0)]");
    // The first plan is not the one that is shown.
    sample.python("latch('/plan', plan()); time.sleep(0.5); latch('/followed', plan())");
    sample.wait_for("circles[2:] == [(2, 0.0, 0.0)]");
    assert_eq!(sample.python("len(arrays)"), "3");
    sample.end();
}

/// Publishes a plan left or right of the middle in turn, and notes of each image whether it shows the one and the
/// other.
const TURNS: &str = "
from nav_msgs.msg import Path
from geometry_msgs.msg import PoseStamped
from sensor_msgs.msg import Image
def plan(*places):
    path = Path()
    path.header.frame_id = 'map'
    for x in places:
        pose = PoseStamped()
        pose.pose.position.x, pose.pose.orientation.w = x, 1
        path.poses.append(pose)
    return path
shown = []
def note(image):
    lit = lambda u: any(image.data[24 * image.step + 3 * u:][:3])
    shown.append((lit(14), lit(42)))
noting = rospy.Subscriber('/view/image', Image, note, queue_size=100)
";

#[test]
fn no_image_shows_two_plans_or_none() {
    let markers = "{Class: rviz/MarkerArray, Name: arrows, Enabled: true, Marker Topic: /arrows, Queue Size: 100}";
    let fixture = Setup::of(&[markers]).start();
    let mut node = fixture.master.program("nav_path_markers");
    let arguments = ["--path-topic", "/plan", "--markers-topic", "/arrows", "--length", "0.4", "--spacing", "0.4"];
    let _node = Running::start(node.args(arguments).args(["--width", "0.3", "--goal-radius", "0"])).unwrap();
    // From above: rviz's light does.
    fixture.python("latch('/tf_static', tf('map', 'eye', xyz=(0, 0, 2), q=(1, 0, 0, 0)))");
    fixture.python("latch('/eye/camera_info', info())");
    fixture.python(TURNS);
    fixture.python("latch('/plan', plan(-1.0, -0.2))");
    fixture.wait_for("shown and shown[-1] == (True, False)");
    fixture.python("shown.clear()");
    fixture.python("turns = PublishRepeatedly(20, lambda i: plan(*((0.2, 1.0) if i % 2 else (-1.0, -0.2))), '/plan')");
    fixture.wait_for("min(shown.count((True, False)), shown.count((False, True))) > 5");
    assert_eq!(fixture.python("set(shown) - {(True, False), (False, True)}"), "set()");
}

#[test]
fn plans_that_cannot_be_shown_take_the_arrows_away_and_are_reported() {
    let mut sample =
        Sample::start("nav_path_markers", VIEWER, &["--path-topic", "/plan", "--markers-topic", "/arrows"]);
    let cases = [
        ("plan((0, 0), (float('nan'), 0))", "non-finite"),
        ("plan((0, 0), (1, 0), frame='')", "no frame_id"),
        ("plan()", "the plan is empty"),
    ];
    for (plan, reason) in cases {
        sample.python("arrays.clear(); states.clear()");
        sample.python("latch('/plan', plan((0, 0), (1, 0)))");
        sample.wait_for("len(arrays) == 1 and arrays[0][0] == [0, 1]");
        sample.python(&format!("latch('/plan', {plan})"));
        sample.wait_for("len(arrays) == 2 and arrays[1][:2] == ([], [0, 1])");
        sample.wait_for(&format!("any({reason:?} in state.message for state in states)"));
    }
    assert_eq!(
        sample.master.output("rosnode", &["ping", "-c", "1", "/nav_path_markers"]).unwrap().matches("reply").count(),
        1
    );
    sample.end();
    assert_eq!(sample.python("len(arrays)"), "2", "there was nothing left to delete");
}

#[test]
fn a_wrong_parameter_is_one_line_that_names_it() {
    let mut sample = Sample::start("nav_path_markers", "pass", &["_spacing:=0"]);
    let status = sample.node.wait(rcs_tests::ros::PATIENCE).unwrap();
    assert_eq!(status.code(), Some(1));
    let errors = sample.node.errors();
    let expected = "]: invalid value '0' for ~spacing: not from 0.01 to 100";
    assert!(errors.len() == 1 && errors[0].ends_with(expected), "{errors:?}");
}
