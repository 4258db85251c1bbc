//! The node against a real ROS: its master, rostopic, rosservice, rosnode, rosbag and rospy.
#![allow(clippy::unwrap_used, reason = "a test whose set-up fails has failed")]

mod bags;
mod faults;
mod images;
mod limits;
mod messages;
mod node;
mod raw;
mod services;
mod subscribers;

use rcs_tests::ros::{RosMaster, Running};
use std::process::Command;

/// A program of ROS's Python.
const PEER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/programs/ros/peer.py");

/// Starts the probe (see `src/bin/ros_probe.rs`) with these arguments.
fn probe(master: &RosMaster, args: &[&str]) -> Running {
    let mut command = master.environment(Command::new(env!("CARGO_BIN_EXE_ros_probe")));
    Running::start(command.args(args)).unwrap()
}
