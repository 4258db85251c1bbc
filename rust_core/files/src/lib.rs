//! The files that the programs read and write, each format in one place: a projector's geometry ([`projector`]), what
//! its calibration reads and writes ([`capture`], [`correspondences`], [`calibration_report`]), point clouds ([`pcd`])
//! and pictures ([`picture_file`]).

#![forbid(unsafe_code)]

pub mod atomic_file;
pub mod calibration_report;
pub mod capture;
pub mod correspondences;
pub mod pcd;
pub mod picture_file;
pub mod projector;
mod yaml_text;
