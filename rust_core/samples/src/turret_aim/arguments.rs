//! The options of `turret_aim`.

use clap::Parser;

use super::beam::AimPixel;
use super::command::CommandKind;
use crate::target::TargetArguments;
use rcs_node_support::node_options::within;

/// Aims a pan-tilt unit so that a pixel of the projector lights a target.
///
/// The unit is any two turning joints between the robot's base and the projector's lens, as the robot's description has
/// them, with their offsets, tilted axes and limits. What cannot be reached is approached as far as the limits allow,
/// and reported in the log and on /diagnostics. Every option may be given as a private parameter, too: --target-frame
/// is ~target_frame. ROS's remappings and special arguments work.
#[derive(Parser, Clone, Debug)]
#[command(
    name = "turret_aim",
    display_name = "rviz_camera_stream",
    version,
    before_help = "\
Examples:
  turret_aim --target-frame cup --pan-joint pan --tilt-joint tilt",
    after_help = "\
Topics subscribed to: the target, the projector's CameraInfo, the joint states, /tf, /tf_static
Topics published: the commands (std_msgs/Float64 for each joint, or trajectory_msgs/JointTrajectory), /diagnostics
Exit codes: 0 ended by SIGINT, SIGTERM or rosnode kill; 1 a parameter or the node failed; 2 invalid arguments"
)]
pub(super) struct TurretArguments {
    #[command(flatten)]
    pub(super) target: TargetArguments,
    /// Pixel that lights the target: 'center' of the image, or U,V
    #[arg(long, default_value = "center", value_name = "PIXEL", allow_hyphen_values = true)]
    pub(super) pixel: AimPixel,
    /// Topic of the projector's CameraInfo
    #[arg(long, value_name = "TOPIC", default_value = "/proj_view/camera_info")]
    pub(super) camera_info_topic: String,
    /// Optical frame of the lens [default: the CameraInfo's]
    #[arg(long, value_name = "FRAME")]
    pub(super) lens_frame: Option<String>,
    /// Joint nearer to the base [default: the first of the two revolute joints above the lens in the description]
    #[arg(long, value_name = "JOINT", requires = "tilt_joint")]
    pub(super) pan_joint: Option<String>,
    /// Joint nearer to the lens [default: the second of them]
    #[arg(long, value_name = "JOINT", requires = "pan_joint")]
    pub(super) tilt_joint: Option<String>,
    /// Parameter with the robot description
    #[arg(long, value_name = "PARAM", default_value = "robot_description")]
    pub(super) robot_description: String,
    /// Topic of the joint states
    #[arg(long, value_name = "TOPIC", default_value = "/joint_states")]
    pub(super) joint_states_topic: String,
    /// Message type of the joint controllers
    #[arg(long, value_enum, default_value_t = CommandKind::Float64)]
    pub(super) command: CommandKind,
    /// Topic of the first joint's command, with --command float64
    #[arg(long, value_name = "TOPIC", default_value = "/pan_controller/command")]
    pub(super) pan_topic: String,
    /// Topic of the second joint's command, with --command float64
    #[arg(long, value_name = "TOPIC", default_value = "/tilt_controller/command")]
    pub(super) tilt_topic: String,
    /// Topic of both joints' command, with --command trajectory
    #[arg(long, value_name = "TOPIC", default_value = "/turret_controller/command")]
    pub(super) trajectory_topic: String,
    /// Smallest commanded motion of either joint [rad]
    #[arg(long, value_name = "RAD", default_value_t = 0.002, value_parser = within(0.0, 0.5))]
    pub(super) dead_band: f64,
    /// Speed limit of each joint, if the description has no lower one [rad/s]
    #[arg(long, value_name = "RAD_PER_SEC", default_value_t = 1.0, value_parser = within(0.01, 50.0))]
    pub(super) speed: f64,
    /// Rate of the commands [Hz]
    #[arg(long, value_name = "HZ", default_value_t = 20.0, value_parser = within(1.0, 200.0))]
    pub(super) rate: f64,
}
