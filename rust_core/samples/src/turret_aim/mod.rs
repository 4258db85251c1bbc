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
