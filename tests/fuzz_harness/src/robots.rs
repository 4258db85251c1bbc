//! Robot descriptions, and the joint states of such a robot.

use std::sync::{Arc, OnceLock};

use rcs_messages::geometry_msgs::{Quaternion, Transform, TransformStamped};
use rcs_messages::sensor_msgs::JointState;
use rcs_messages::std_msgs::Header;
use rcs_messages::tf2_msgs::TFMessage;
use rcs_messages::AnyMessage;
use rcs_rviz_config::Config;

use crate::displays::{config, Shown, FIXED_FRAME};

/// Links and joints that the first inputs have.
const LINKS: [&str; 4] = ["base_link", "arm", "a", "b"];
const JOINTS: [&str; 3] = ["joint", "elbow", "j"];

/// A robot description, shown by all displays that read one.
pub(crate) fn urdf(data: &[u8]) {
    static CONFIG: OnceLock<Config> = OnceLock::new();
    let config = CONFIG.get_or_init(|| {
        config(
            "{Class: rviz/RobotModel, Name: r, Enabled: true, Visual Enabled: true, Collision Enabled: true, Alpha: 0.5}\n  \
             - {Class: rviz/Effort, Name: e, Enabled: true, Topic: /joint_states}",
        )
    });
    let text: Arc<str> = String::from_utf8_lossy(data).into();
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
