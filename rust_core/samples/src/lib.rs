//! The programs of the paper's samples: aim a turret, keep the line of sight free, draw a path as arrows, publish a
//! cloud; and a rehearsal's camera and projector.
#![forbid(unsafe_code)]
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

pub mod line_of_sight;
pub mod nav_path_markers;
mod poses;
pub mod publish_cloud;
pub mod simulate_scan;
mod target;
pub mod turret_aim;
