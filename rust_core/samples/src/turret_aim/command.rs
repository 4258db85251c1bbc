//! The two ways in which units are commanded.

use std::io;
use std::time::Duration;

use clap::ValueEnum;
use rcs_messages::std_msgs::Float64;
use rcs_messages::trajectory_msgs::{JointTrajectory, JointTrajectoryPoint};
use rcs_ros::{NodeError, Publisher, RosNode};

/// What the controllers of the joints take.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum CommandKind {
    /// A std_msgs/Float64 for each joint, as dynamixel_controllers and arbotix take them
    Float64,
    /// A trajectory_msgs/JointTrajectory for both
    Trajectory,
}

/// Commands both joints.
pub(super) enum Commander {
    /// Positions on the way, one topic for each joint.
    Positions([Publisher<Float64>; 2]),
    /// Goals with the time that they take.
    Trajectories(Publisher<JointTrajectory>),
}

/// Old commands are of no use.
const QUEUE_SIZE: usize = 1;

impl Commander {
    /// A topic for each joint.
    ///
    /// # Errors
    /// [`NodeError::Name`].
    pub(super) fn positions(node: &RosNode, topics: [&str; 2]) -> Result<Self, NodeError> {
        let [pan, tilt] = topics;
        Ok(Self::Positions([node.publisher(pan, QUEUE_SIZE)?, node.publisher(tilt, QUEUE_SIZE)?]))
    }

    /// One topic for both joints.
    ///
    /// # Errors
    /// [`NodeError::Name`].
    pub(super) fn trajectories(node: &RosNode, topic: &str) -> Result<Self, NodeError> {
        Ok(Self::Trajectories(node.publisher(topic, QUEUE_SIZE)?))
    }

    /// The topics.
    pub(super) fn topics(&self) -> String {
        match self {
            Self::Positions([pan, tilt]) => format!("{}, {}", pan.topic(), tilt.topic()),
            Self::Trajectories(both) => both.topic().to_owned(),
        }
    }
}

/// Sends both joints to where they are to be now.
///
/// # Errors
/// See [`Publisher::send`].
pub(super) fn send_positions(topics: &[Publisher<Float64>; 2], positions: [f64; 2]) -> io::Result<()> {
    for (topic, data) in topics.iter().zip(positions) {
        topic.send(Float64 { data })?;
    }
    Ok(())
}

/// Sends both joints to a goal.
///
/// # Errors
/// See [`Publisher::send`].
pub(super) fn send_goal(
    topic: &Publisher<JointTrajectory>,
    names: [&str; 2],
    goal: [f64; 2],
    takes: Duration,
) -> io::Result<()> {
    let nanos = i64::try_from(takes.as_nanos()).unwrap_or(i64::MAX);
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
