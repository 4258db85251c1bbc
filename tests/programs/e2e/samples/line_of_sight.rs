//! `line_of_sight`: the cylinder in the planning scene, as MoveIt understands it, and its removal.

use super::{Sample, DEFINED_BY_SENDER};

/// Keeps the collision objects and markers.
const PLANNER: &str = "
from geometry_msgs.msg import PointStamped
from visualization_msgs.msg import Marker
markers, objects = [], seen
seeing = rospy.Subscriber('/collision_object', rospy.AnyMsg, see)
marking = rospy.Subscriber('/line_of_sight_marker', Marker, markers.append)
def point(x, y, z):
    message = PointStamped()
    message.header.frame_id = 'base_link'
    message.point.x, message.point.y, message.point.z = x, y, z
    return message
latch('/tf_static', tf('base_link', 'proj_view', xyz=(0, 0, 1)))
def last(): return objects[-1].operation if objects else None
";

fn planner() -> String {
    format!("{DEFINED_BY_SENDER}\n{PLANNER}")
}

#[test]
fn the_cylinder_follows_the_target_and_goes_with_it() {
    let args = ["--target-point", "/target", "--target-timeout", "5", "--radius", "0.07", "--lens-gap", "0.2"];
    let sample = Sample::start("line_of_sight", &planner(), &[&args[..], &["_target_gap:=0.3"]].concat());
    // What an earlier node may have left is taken away first.
    sample.wait_for("last() == 1");
    sample.python("repeat = PublishRepeatedly(10, lambda i: point(2, 0, 1), '/target')");
    sample.wait_for("last() == 0");
    let object = sample.python(
        "(lambda o: [str(o.id), o.header.frame_id, o.primitives[0].type, [round(d, 6) for d in o.primitives[0].dimensions], \
         o.pose.orientation.w, len(o.meshes)])(objects[-1])",
    );
    assert_eq!(object, "['line_of_sight', 'base_link', 3, [1.5, 0.07], 1.0, 0]");
    let pose = sample.python("(lambda p: [round(v, 4) for v in (p.position.x, p.position.z, p.orientation.y, p.orientation.w)])(objects[-1].primitive_poses[0])");
    assert_eq!(pose, "[0.95, 1.0, 0.7071, 0.7071]", "between the gaps, turned from z to x");
    sample.wait_for("markers[-1].type == Marker.CYLINDER and markers[-1].action == Marker.ADD");
    assert_eq!(sample.python("round(markers[-1].scale.x, 6), round(markers[-1].scale.z, 6)"), "(0.14, 1.5)");

    // A target that stays is not announced again; one that moves is.
    let before = sample.python("len(objects)");
    sample.python("time.sleep(0.5)");
    assert_eq!(sample.python("len(objects)"), before);
    sample.python("repeat.stop(); repeat = PublishRepeatedly(10, lambda i: point(3, 0, 1), '/target')");
    sample.wait_for("round(objects[-1].primitives[0].dimensions[0], 6) == 2.5");

    // The target goes.
    sample.python("repeat.stop()");
    sample.wait_for("last() == 1 and markers[-1].action == Marker.DELETE");
    // A planner that starts now learns that there is nothing.
    assert_eq!(sample.late("/collision_object", "(m.operation, str(m.id))"), "(1, 'line_of_sight')");
}

#[test]
fn the_cylinder_is_removed_when_the_node_ends() {
    let mut sample =
        Sample::start("line_of_sight", &planner(), &["--target-point", "/target", "--target-timeout", "0"]);
    sample.python("latch('/target', point(2, 0, 1))");
    sample.wait_for("last() == 0 and markers and markers[-1].action == Marker.ADD");
    sample.end();
    sample.wait_for("last() == 1 and markers[-1].action == Marker.DELETE");
}

#[test]
fn a_node_that_looks_every_ten_seconds_ends_at_once_all_the_same() {
    let mut sample = Sample::start("line_of_sight", &planner(), &["--target-frame", "cup", "--rate", "0.1"]);
    sample.wait_for("last() == 1");
    sample.end();
}

#[test]
fn both_definitions_of_a_collision_object_are_known() {
    for (moveit, md5sum) in
        [("noetic", "dbba710596087da521c07564160dfccb"), ("melodic", "568a161b26dc46c54a5a07621ce82cf3")]
    {
        let args = ["--target-point", "/target", "--target-timeout", "0", "--moveit-msgs", moveit];
        let sample = Sample::start("line_of_sight", &planner(), &args);
        sample.python("latch('/target', point(2, 0, 1))");
        sample.wait_for("last() == 0");
        let header = sample.python("headers[-1]['type'], headers[-1]['md5sum']");
        assert_eq!(header, format!("('moveit_msgs/CollisionObject', '{md5sum}')"));
        assert_eq!(sample.python("objects[-1].primitives[0].type"), "3");
    }
}
