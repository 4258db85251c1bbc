//! File formats: a projector's geometry ([`projector`]), the calibration's input and output ([`capture`],
//! [`correspondences`], [`calibration_report`], [`verification`]), an operator's cues ([`cue_file`]), point clouds
//! ([`pcd`]), images ([`image_file`], [`image_folder`], [`canvas`]) and sizes as a user types them ([`sizes`]).

#![forbid(unsafe_code)]
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

pub mod atomic_file;
pub mod blend_file;
pub mod calibration_report;
pub mod canvas;
pub mod capture;
pub mod correspondences;
pub mod cue_file;
mod file_error;
pub mod image_file;
pub mod image_folder;
mod image_limits;
pub mod pcd;
pub mod projector;
pub mod sizes;
pub mod verification;
mod yaml_spans;
mod yaml_text;

pub use file_error::FileError;
