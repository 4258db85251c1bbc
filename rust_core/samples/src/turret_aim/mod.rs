//! `turret_aim`: aims a pan-tilt unit so that a pixel of the projector lights a target.
//!
//! ```text
//!  target, frames ──► place in the unit's base ─┐
//!  CameraInfo, pixel ──► beam of the lens ──────┼─► two positions ─► dead band, speed ─► commands
//!  description, frames ──► joints and lens ─────┤
//!  joint states ──► present posture ────────────┘
//! ```

mod arguments;
mod beam;
mod command;
mod controller;
mod inputs;
mod setpoint;
mod unit;

use std::process::ExitCode;
use std::time::{Duration, Instant};

use clap::{Command, CommandFactory};
use rcs_messages::MessageKind;
use rcs_ros::{NodeEvent, RosNode};
use rcs_transforms::TransformTree;

use crate::target::Target;
use arguments::TurretArguments;
use controller::Controller;
use inputs::TurretInputs;
use rcs_node_support::frames;
use rcs_node_support::lifecycle::{self, EndRequest};
use rcs_node_support::node_options::with_parameters;
use rcs_node_support::node_status::NodeStatus;
use rcs_node_support::ros_names::{publishes, reads, subscribes, RosName};

/// Topics and parameters of the node.
pub const ROS_NAMES: &[RosName] = &[
    subscribes(
        "TARGET",
        "geometry_msgs/PoseStamped, geometry_msgs/PointStamped or sensor_msgs/PointCloud2",
        "the target, unless it is a frame",
    ),
    subscribes("/proj_view/camera_info", "sensor_msgs/CameraInfo", "the projector's"),
    subscribes("/joint_states", "sensor_msgs/JointState", "where the joints are"),
    subscribes("/tf, /tf_static", "tf2_msgs/TFMessage", "frames of target and robot"),
    reads("robot_description", "string", "the joints; looked for until it is set"),
    publishes("/pan_controller/command", "std_msgs/Float64", "with `--command float64`: the first joint's position"),
    publishes("/tilt_controller/command", "std_msgs/Float64", "with `--command float64`: the second joint's position"),
    publishes(
        "/turret_controller/command",
        "trajectory_msgs/JointTrajectory",
        "with `--command trajectory`: both goals and the time to reach them",
    ),
    publishes("/diagnostics", "diagnostic_msgs/DiagnosticArray", "the status, both goals and the remaining error"),
];

/// The command line.
pub fn command() -> Command {
    TurretArguments::command()
}

/// Runs the program with the process's arguments.
pub fn main() -> ExitCode {
    lifecycle::run_main(|_: TurretArguments| {
        lifecycle::with_node("turret_aim", |node, end| aim(node, end, &with_parameters(node)?))
    })
}

/// Commands the unit until the shutdown is requested.
fn aim(node: &RosNode, end: &EndRequest, arguments: &TurretArguments) -> anyhow::Result<()> {
    let given = &arguments.target;
    let mut target = Target::start(node, given.source()?, &given.fixed_frame, given.timeout())?;
    let mut controller = Controller::start(node, arguments)?;
    let mut inputs = TurretInputs::new(arguments);
    let mut status = NodeStatus::start(node, "turret")?;
    let mut tree = TransformTree::new();
    node.subscribe_transforms()?;
    let info = node.subscribe(&arguments.camera_info_topic, MessageKind::CameraInfo, 1)?;
    let states = node.subscribe(&arguments.joint_states_topic, MessageKind::JointState, 20)?;
    node.follow_parameters(vec![arguments.robot_description.clone()]);
    inputs.name_topics(info.topic(), states.topic());
    log::info!("commands on {}", controller.topics());

    let period = Duration::from_secs_f64(1.0 / arguments.rate);
    let mut updated = Instant::now();
    while !end.is_requested() {
        let left = period.saturating_sub(updated.elapsed());
        frames::take_events(node, left, &mut tree, |event| match event {
            NodeEvent::Message { topic, message, received, .. } => {
                target.take(&topic, &message, received);
                inputs.take(&topic, &message, received);
            }
            NodeEvent::Parameter { text, .. } => inputs.take_description(text.as_deref()),
            _ => {}
        });
        let elapsed = updated.elapsed();
        if elapsed < period {
            continue;
        }
        updated = Instant::now();
        let now = frames::now(node);
        let posture = inputs.posture(&tree, &mut target, now);
        controller.cycle(&posture, elapsed.min(2 * period), &mut status)?;
        status.publish_if_due()?;
    }
    Ok(())
}
