//! What the tests and benchmarks of the whole project share.
#![forbid(unsafe_code)]

pub mod big_robot;
pub mod captures;
pub mod golden;
pub mod modules;
pub mod programs;
pub mod python_node;
pub mod ros;
pub mod ros_fixture;
pub mod scenes;
pub mod sources;
