//! What the programs are made of: command lines, wiring, and the files that they read.
#![forbid(unsafe_code)]

pub mod camera_pose;
pub mod check;
pub mod check_live;
pub mod cli;
pub mod logging;
mod lzf;
pub mod node;
pub mod offline;
pub mod pcd;
pub mod pcd_header;
pub mod picture_file;
pub mod projector_file;
mod recent;
mod report;
pub mod small_node;
pub mod stage;
mod status_log;
