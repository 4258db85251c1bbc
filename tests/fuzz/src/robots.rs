//! Robot descriptions, the joint states of such a robot, and aiming with its joints.

use std::sync::{Arc, OnceLock};

use nalgebra::{Point3, Vector3};
use rcs_messages::geometry_msgs::{Quaternion, Transform, TransformStamped};
use rcs_messages::sensor_msgs::JointState;
use rcs_messages::std_msgs::Header;
use rcs_messages::tf2_msgs::TFMessage;
use rcs_messages::AnyMessage;
use rcs_robot::{Beam, Hinge, PanTilt, Robot};
use rcs_rviz_config::Config;

use crate::displays::{config, Shown, FIXED_FRAME};

/// Links and joints that the first inputs have.
const LINKS: [&str; 4] = ["base_link", "arm", "a", "b"];
const JOINTS: [&str; 3] = ["joint", "elbow", "j"];

/// A robot description, shown by all displays that read one; whatever two joints turn in it are aimed.
pub(crate) fn urdf(data: &[u8]) {
    static CONFIG: OnceLock<Config> = OnceLock::new();
    let config = CONFIG.get_or_init(|| {
        config(
            "{Class: rviz/RobotModel, Name: r, Enabled: true, Visual Enabled: true, Collision Enabled: true, Alpha: 0.5}\n  \
             - {Class: rviz/Effort, Name: e, Enabled: true, Topic: /joint_states}",
        )
    });
    let text: Arc<str> = rcs_text::decode(data).into();
    aim(&text);
    let mut shown = Shown::new(config);
    shown.take_parameter("robot_description", &text);
    let rotation = Quaternion { w: 1.0, ..Quaternion::default() };
    let placed = |link: &&str| TransformStamped {
        header: Header { frame_id: FIXED_FRAME.to_owned(), ..Header::default() },
        child_frame_id: (*link).to_owned(),
        transform: Transform { rotation: rotation.clone(), ..Transform::default() },
    };
    shown.take_transforms(&TFMessage { transforms: LINKS.iter().map(placed).collect() }, true);
    let mut state = JointState { name: JOINTS.map(str::to_owned).to_vec(), ..JointState::default() };
    (state.position, state.velocity, state.effort) = (vec![0.5; 3], vec![0.0; 3], vec![1.0, -2.0, 1e9]);
    shown.advance();
    shown.take("/joint_states", &AnyMessage::JointState(state.into()));
    shown.advance();
    shown.draw_some(data);
}

/// Aims with the first two joints that turn above a link. A posture is within the limits, whatever the description
/// says.
fn aim(text: &str) {
    let Ok(robot) = Robot::parse(text) else { return };
    let found = robot.links.keys().take(20).find_map(|link| Some((link, robot.two_turning_joints(link).ok()?)));
    let Some((link, names)) = found else { return };
    let [Ok(first), Ok(second)] = names.each_ref().map(|name| Hinge::of(name, &robot.joints[name])) else { return };
    let [above, below] = names.each_ref().map(|name| &robot.joints[name]);
    let Some(between) = robot.fixed_transform(&above.child_link, &below.parent_link) else { return };
    let Some(second_from_lens) = robot.fixed_transform(&below.child_link, link) else { return };
    let first_from_second = between * below.parent_from_child_at_zero;
    let unit = PanTilt { hinges: [first, second], first_from_second, second_from_lens };
    let beam = Beam { origin: Point3::origin(), direction: Vector3::z_axis() };
    if let Some(aim) = unit.aim(&beam, Point3::new(1.0, 0.5, -0.3), [0.0, 0.0]) {
        for (hinge, position) in unit.hinges.iter().zip(aim.positions) {
            assert!(hinge.travel.contains(position), "{position} is not within {:?}", hinge.travel);
        }
    }
}
