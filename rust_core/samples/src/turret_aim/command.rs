//! Commands to the joint controllers: positions or trajectories.

use std::io;
use std::time::Duration;

use clap::ValueEnum;
use rcs_messages::std_msgs::Float64;
use rcs_messages::trajectory_msgs::{JointTrajectory, JointTrajectoryPoint};
use rcs_ros::{NodeError, Publisher, RosNode};

/// Message type of the joint controllers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum CommandKind {
    /// A std_msgs/Float64 for each joint, as dynamixel_controllers and arbotix take them
    Float64,
    /// A trajectory_msgs/JointTrajectory for both
    Trajectory,
}

/// Publishers of the commands.
pub(super) enum Commander {
    /// Intermediate positions, one topic for each joint.
    Positions([Publisher<Float64>; 2]),
    /// Goals with their durations.
    Trajectories(Publisher<JointTrajectory>),
}

/// Only the newest command counts.
const QUEUE_SIZE: usize = 1;

impl Commander {
    /// Advertises a topic for each joint.
    ///
    /// # Errors
    /// [`NodeError::Name`].
    pub(super) fn positions(node: &RosNode, topics: [&str; 2]) -> Result<Self, NodeError> {
        let [pan, tilt] = topics;
        Ok(Self::Positions([node.publisher(pan, QUEUE_SIZE)?, node.publisher(tilt, QUEUE_SIZE)?]))
    }

    /// Advertises one topic for both joints.
    ///
    /// # Errors
    /// [`NodeError::Name`].
    pub(super) fn trajectories(node: &RosNode, topic: &str) -> Result<Self, NodeError> {
        Ok(Self::Trajectories(node.publisher(topic, QUEUE_SIZE)?))
    }

    /// Names of the topics.
    pub(super) fn topics(&self) -> String {
        match self {
            Self::Positions([pan, tilt]) => format!("{}, {}", pan.topic(), tilt.topic()),
            Self::Trajectories(both) => both.topic().to_owned(),
        }
    }
}

/// Commands the positions of both joints.
///
/// # Errors
/// See [`Publisher::send`].
pub(super) fn send_positions(topics: &[Publisher<Float64>; 2], positions: [f64; 2]) -> io::Result<()> {
    for (topic, data) in topics.iter().zip(positions) {
        topic.send(Float64 { data })?;
    }
    Ok(())
}

/// Commands both joints to reach a goal after `duration`.
///
/// # Errors
/// See [`Publisher::send`].
pub(super) fn send_goal(
    topic: &Publisher<JointTrajectory>,
    names: [&str; 2],
    goal: [f64; 2],
    duration: Duration,
) -> io::Result<()> {
    let nanos = i64::try_from(duration.as_nanos()).unwrap_or(i64::MAX);
    let point = JointTrajectoryPoint {
        positions: goal.to_vec(),
        velocities: vec![0.0; 2],
        time_from_start: rcs_messages::Duration::from_nanos(nanos),
        ..JointTrajectoryPoint::default()
    };
    // Stamp zero: from now on by the controller's own clock.
    let joint_names = names.map(str::to_owned).to_vec();
    topic.send(JointTrajectory { joint_names, points: vec![point], ..JointTrajectory::default() })
}
