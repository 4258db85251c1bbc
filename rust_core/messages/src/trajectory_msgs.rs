//! `trajectory_msgs`: where joints are to be at which time, for joint_trajectory_controller and the like.
//!
//! They are types of our own, so that the programs can be built where that package is not installed.

use crate::fields::{fields_in_order, with_parts};
use crate::std_msgs::Header;
use rosrust::{Duration, Message};

fields_in_order! {
    /// `trajectory_msgs/JointTrajectoryPoint`: positions and their derivatives at one time, in the order of the
    /// trajectory's names; empty where they are left to the controller.
    JointTrajectoryPoint {
        /// Radians or metres.
        positions: Vec<f64>,
        /// Per second.
        velocities: Vec<f64>,
        /// Per second squared.
        accelerations: Vec<f64>,
        /// Newton metres or newton.
        effort: Vec<f64>,
        /// When, after the trajectory's stamp.
        time_from_start: Duration,
    }
    /// `trajectory_msgs/JointTrajectory`
    JointTrajectory {
        /// Its stamp is the start; zero means at once.
        header: Header,
        /// The joints.
        joint_names: Vec<String>,
        /// Where they are to be, in the order of time.
        points: Vec<JointTrajectoryPoint>,
    }
}

const POINT: &str = "float64[] positions\nfloat64[] velocities\nfloat64[] accelerations\nfloat64[] effort\n\
     duration time_from_start\n";

impl Message for JointTrajectory {
    fn msg_definition() -> String {
        let parts = [
            ("std_msgs/Header", "uint32 seq\ntime stamp\nstring frame_id\n"),
            ("trajectory_msgs/JointTrajectoryPoint", POINT),
        ];
        with_parts("Header header\nstring[] joint_names\nJointTrajectoryPoint[] points\n", &parts)
    }

    fn md5sum() -> String {
        "65b4f94a94d1ed67169da35a02f33d3f".to_owned()
    }

    fn msg_type() -> String {
        "trajectory_msgs/JointTrajectory".to_owned()
    }
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
