//! The scan engine: shows patterns with a projector, takes the camera's images of them, checks both, and makes a
//! capture of them; or finds patterns and images in a recording.
//!
//! [`ScanSession`] is a live scan on a [`ProjectorScreen`] and a [`ScanCamera`]; those of ROS are in
//! `projector_calibrate`, tests bring simulated ones. [`recorded::scan`] is the scan of a bag. Both share the checks of
//! the images. No ROS master, no window.
#![forbid(unsafe_code)]
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod board;
mod camera_messages;
mod coarse_code;
mod compare;
mod depth_average;
mod devices;
mod failure;
mod finish;
mod light;
mod measure_light;
mod orientation;
mod pose_refinement;
pub mod preview;
pub mod recorded;
mod robot;
mod scan;
mod session;
#[cfg(test)]
mod tests;
mod verification;

pub use camera_messages::{depth_of, grey_image, lens_of_topic};
pub use devices::{CameraFrame, CameraTopics, DepthFrame, DepthTopic, ProjectorScreen, ScanCamera, ScanCameraError};
pub use failure::ScanFailure;
pub use finish::ScanResult;
pub use light::Delay;
pub use pose_refinement::Refinement;
pub use robot::captured_robot;
pub use scan::patterns;
pub use session::{ScanEvent, ScanOptions, ScanSession};
pub use verification::Verification;
