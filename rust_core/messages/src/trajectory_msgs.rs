//! `trajectory_msgs`: trajectories for joint_trajectory_controller.

use crate::fields::{fields_in_order, message_types, with_parts};
use crate::std_msgs::Header;
use rosrust::Duration;

fields_in_order! {
    /// `trajectory_msgs/JointTrajectoryPoint`: positions and their derivatives at one time, in the order of the
    /// trajectory's names; empty lists are left to the controller.
    JointTrajectoryPoint {
        /// Positions, radians or metres.
        positions: Vec<f64>,
        /// Velocities, per second.
        velocities: Vec<f64>,
        /// Accelerations, per second squared.
        accelerations: Vec<f64>,
        /// Efforts, newton metres or newtons.
        effort: Vec<f64>,
        /// Time after the trajectory's stamp.
        time_from_start: Duration,
    }
    /// `trajectory_msgs/JointTrajectory`
    JointTrajectory {
        /// Header, whose stamp is the start; zero means at once.
        header: Header,
        /// Joints.
        joint_names: Vec<String>,
        /// Points in the order of time.
        points: Vec<JointTrajectoryPoint>,
    }
}

const POINT: &str = "float64[] positions\nfloat64[] velocities\nfloat64[] accelerations\nfloat64[] effort\n\
     duration time_from_start\n";

message_types! {
    JointTrajectory: "trajectory_msgs/JointTrajectory", "65b4f94a94d1ed67169da35a02f33d3f", {
        let parts = [
            ("std_msgs/Header", "uint32 seq\ntime stamp\nstring frame_id\n"),
            ("trajectory_msgs/JointTrajectoryPoint", POINT),
        ];
        with_parts("Header header\nstring[] joint_names\nJointTrajectoryPoint[] points\n", &parts)
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_trajectory_comes_back_as_it_was() {
        let time_from_start = Duration { sec: 1, nsec: 500_000_000 };
        let point = JointTrajectoryPoint { positions: vec![0.5, -1.0], time_from_start, ..Default::default() };
        let joint_names = vec!["pan".to_owned(), "tilt".to_owned()];
        let trajectory = JointTrajectory { joint_names, points: vec![point], ..Default::default() };
        let bytes = crate::encode(&trajectory);
        assert_eq!(crate::decode::<JointTrajectory>(&bytes).unwrap(), trajectory);
        // Header 16, names 4 + 7 + 8, one point 4: positions 4 + 16, three empty lists 12, duration 8.
        assert_eq!(bytes.len(), 16 + 19 + 4 + 20 + 12 + 8);
    }
}
