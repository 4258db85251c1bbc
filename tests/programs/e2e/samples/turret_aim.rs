//! `turret_aim` in a closed loop with a simulated unit: where its commands go, the joints follow, and their frames come
//! back.
//!
//! The unit is skew: the axes are tilted, apart, and the lens sits beside both. Where the light goes is computed here,
//! in Python from TF alone, and not by the node's own kinematics.

use std::process::Command;

use rcs_tests::programs::repository;
use rcs_tests::ros::Running;

use super::Sample;

/// Two skew joints on a torso, and the lens.
const ROBOT: &str = "<robot name='r'><link name='base_link'/><link name='torso'/><link name='yoke'/><link name='cradle'/>
  <link name='proj_view'/>
  <joint name='lift' type='prismatic'><parent link='base_link'/><child link='torso'/><origin xyz='0 0 0.8'/>
    <axis xyz='0 0 1'/><limit lower='0.1' upper='0.4' effort='1' velocity='1'/></joint>
  <joint name='pan' type='revolute'><parent link='torso'/><child link='yoke'/><origin xyz='0.1 0 0.3' rpy='0.05 -0.1 0'/>
    <axis xyz='0 0.1 1'/><limit lower='-1.2' upper='1.2' effort='1' velocity='3'/></joint>
  <joint name='tilt' type='continuous'><parent link='yoke'/><child link='cradle'/><origin xyz='0 0.03 0.07' rpy='0 0 0.1'/>
    <axis xyz='0.05 1 0'/></joint>
  <joint name='optics' type='fixed'><parent link='cradle'/><child link='proj_view'/>
    <origin xyz='0.11 0.06 0.05' rpy='-1.5707963267948966 0 -1.5707963267948966'/></joint>
  </robot>";

/// Follows the frames, and says how far, in degrees, the light of a pixel is from a point of base_link.
const OBSERVER: &str = "
import math, re
import numpy as np
from geometry_msgs.msg import PointStamped, PoseStamped
from diagnostic_msgs.msg import DiagnosticArray
from sensor_msgs.msg import JointState
frames, states, joints, speeds = {}, [], {}, []
def matrix(transform):
    t, q = transform.translation, transform.rotation
    x, y, z, w = q.x, q.y, q.z, q.w
    m = np.eye(4)
    m[:3, :3] = [[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                 [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                 [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]]
    m[:3, 3] = t.x, t.y, t.z
    return m
def hear(message):
    for stamped in message.transforms:
        frames[stamped.child_frame_id] = (stamped.header.frame_id, matrix(stamped.transform))
def feel(message):
    joints.update(zip(message.name, message.position))
    speeds.extend(abs(v) for v in message.velocity)
listeners = [rospy.Subscriber(topic, TFMessage, hear) for topic in ('/tf', '/tf_static')]
monitor = rospy.Subscriber('/diagnostics', DiagnosticArray, lambda array: states.extend(array.status))
feeling = rospy.Subscriber('/joint_states', JointState, feel)
def base_from(frame):
    m = np.eye(4)
    while frame in frames:
        frame, parent_from_child = frames[frame]
        m = parent_from_child.dot(m)
    return m
def miss(target, pixel=(31.5, 23.5), f=50.0, c=(32.0, 24.0)):
    lens = base_from('proj_view')
    ray = lens[:3, :3].dot([(pixel[0] - c[0]) / f, (pixel[1] - c[1]) / f, 1])
    to = np.array(target) - lens[:3, 3]
    return math.degrees(math.acos(min(1, ray.dot(to) / np.linalg.norm(ray) / np.linalg.norm(to))))
def point(x, y, z, frame='base_link', stamp=rospy.Time()):
    message = PointStamped()
    message.header.frame_id, message.header.stamp = frame, stamp
    message.point.x, message.point.y, message.point.z = x, y, z
    return message
def pose(x, y, z):
    message = PoseStamped()
    message.header.frame_id = 'base_link'
    message.pose.position.x, message.pose.position.y, message.pose.position.z = x, y, z
    message.pose.orientation.w = 1
    return message
latch('/proj_view/camera_info', info('proj_view'))
";

/// The node and the simulated unit.
struct Loop {
    sample: Sample,
    unit: Running,
}

impl Loop {
    fn start(command: &str, args: &[&str]) -> Self {
        let before = format!("rospy.set_param('/robot_description', '''{ROBOT}''')\n{OBSERVER}");
        let sample = Sample::start("turret_aim", &before, &[&["--command", command], args].concat());
        let unit = repository().join("ros_pkg/nodes/simulated_turret");
        let mut program = sample.master.environment(Command::new(unit));
        program.args(["--float64", "pan=/pan_controller/command", "--float64", "tilt=/tilt_controller/command"]);
        let unit = Running::start(program.args(["--trajectory", "/turret_controller/command"])).unwrap();
        Self { sample, unit }
    }

    /// Waits until the light of a pixel is less than so many degrees from a point.
    fn lights(&self, call: &str, degrees: f64) {
        let expression = format!("'proj_view' in frames and 'cradle' in frames and {call} < {degrees}");
        let holds = self.sample.python.wait_for(rcs_tests::ros::PATIENCE, &expression);
        let now = self.sample.python.run(call);
        assert!(holds, "{expression}: {now:?}\n{}\n{:?}", self.sample.log(), self.unit.errors());
    }
}

#[test]
fn float64_commands_bring_the_middle_of_the_image_to_a_point_that_moves() {
    let mut turret = Loop::start("float64", &["--target-point", "/target", "_target_timeout:=0", "_dead_band:=0.0005"]);
    for target in ["(1.5, 0.4, 0.7)", "(1.0, -0.5, 0.2)", "(2.0, 0.0, 1.6)"] {
        turret.sample.python(&format!("latch('/target', point{target})"));
        turret.lights(&format!("miss({target})"), 0.1);
    }
    // A point of a frame that moves is placed by the transform of its stamp.
    turret.sample.python("now = rospy.Time.now()");
    turret.sample.python("begin = tf('base_link', 'camera', xyz=(1, 0, 0), stamp=now).transforms");
    turret.sample.python("end = tf('base_link', 'camera', xyz=(1, 2, 0), stamp=now + rospy.Duration(1)).transforms");
    turret.sample.python("latch('/tf', TFMessage(begin + end))");
    let at_stamp = "point(0.5, -0.8, 0.5, frame='camera', stamp=now + rospy.Duration(0.5))";
    turret.sample.python(&format!("latch('/target', {at_stamp})"));
    turret.lights("miss((1.5, 0.2, 0.5))", 0.1);
    turret.sample.wait_for("any(s.name == 'turret_aim: turret' and s.level in (0, b'\\0') for s in states)");
    turret.sample.end();
}

#[test]
fn trajectories_bring_a_given_pixel_to_a_frame() {
    let turret = Loop::start("trajectory", &["--target-frame", "cup", "_pixel:=[10, 40]", "_speed:=0.5"]);
    turret.sample.python("latch('/tf_static', tf('base_link', 'cup', xyz=(1.2, 0.5, 0.4)))");
    turret.lights("miss((1.2, 0.5, 0.4), pixel=(10, 40))", 0.3);
    // The simulated joints could turn at 2 rad/s.
    assert_eq!(turret.sample.python("0.3 < max(speeds) < 0.55"), "True", "{}", turret.sample.python("max(speeds)"));
}

#[test]
fn a_pose_and_a_clouds_centroid_are_targets_too() {
    let turret = Loop::start("float64", &["--target-pose", "/target", "--target-timeout", "0"]);
    turret.sample.python("latch('/target', pose(1.4, 0.3, 0.6))");
    turret.lights("miss((1.4, 0.3, 0.6))", 0.3);
    drop(turret);
    let turret = Loop::start("trajectory", &["--target-cloud", "/objects", "--target-timeout", "0"]);
    let points = "((1.1, 0, 0.5), (1.3, 0, 0.5), (1.2, -0.3, 0.9), (float('nan'), 0, 0))";
    turret.sample.python(&format!("latch('/objects', cloud(0xffffff, 'base_link', points={points}))"));
    turret.lights("miss((1.2, -0.1, 1.9 / 3))", 0.3);
}

#[test]
fn what_is_out_of_reach_is_approached_within_the_limits_and_reported() {
    let turret = Loop::start("float64", &["--target-point", "/target", "--target-timeout", "0"]);
    turret.sample.python("latch('/target', point(0.1, 2.0, 1.0))");
    turret.sample.wait_for("any('cannot be reached: joint pan is at its limit of 1.200' in s.message for s in states)");
    turret.sample.wait_for("abs(joints['pan'] - 1.2) < 1e-3");
    assert!(turret.sample.log().contains("the smallest error is"), "{}", turret.sample.log());
    turret.sample.python("latch('/target', point(1.5, 0.4, 0.7))");
    turret.lights("miss((1.5, 0.4, 0.7))", 0.3);
    turret.sample.wait_for("any(s.message == 'aiming at the target' for s in states)");
}

#[test]
fn what_is_missing_is_reported_and_nothing_is_commanded() {
    let mut sample = Sample::start(
        "turret_aim",
        &format!("{OBSERVER}\nfrom std_msgs.msg import Float64\ncommands = []\nheard = rospy.Subscriber('/pan_controller/command', Float64, commands.append)"),
        &["--target-point", "/target"],
    );
    let reports = |text: &str| sample.wait_for(&format!("any({text:?} in s.message for s in states)"));
    reports("parameter robot_description is not set");
    sample.python(&format!("rospy.set_param('/robot_description', '''{ROBOT}''')"));
    reports("no position of joint pan yet on /joint_states");
    sample.python("states.clear()");
    let state = "JointState(name=['pan', 'tilt'], position=[0, 0])";
    sample.python(&format!("repeat = PublishRepeatedly(20, lambda i: {state}, '/joint_states')"));
    reports("no target yet on /target");
    sample.python("latch('/target', point(1, 0, 0, frame=''))");
    reports("it has no frame_id");
    assert_eq!(sample.python("commands"), "[]");
    sample.end();
}

#[test]
fn a_target_is_needed() {
    let mut sample = Sample::start("turret_aim", "pass", &[]);
    let status = sample.node.wait(rcs_tests::ros::PATIENCE).unwrap();
    assert_eq!(status.code(), Some(1));
    let errors = sample.node.errors();
    assert!(matches!(&errors[..], [one] if one.contains("give --target-pose")), "{errors:?}");
}
