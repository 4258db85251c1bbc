//! The scan engine: shows patterns with a projector, takes the camera's images of them, checks both, and makes a
//! capture of what was seen; or finds patterns and images in a recording.
//!
//! [`Session`] is a live scan on a [`Screen`] and a [`Camera`]; the ROS ones live in `calibrate`, tests bring simulated
//! ones. [`recorded::scan`] is the scan of a bag. Both share what is checked of the images. No ROS master, no window.
#![forbid(unsafe_code)]

mod camera_lens;
mod coarse_code;
mod compare;
mod depth_average;
mod devices;
mod failure;
mod finish;
mod light;
mod measure_light;
mod orientation;
pub mod preview;
mod received;
pub mod recorded;
mod session;
#[cfg(test)]
mod tests;
mod topics;
mod verification;

pub use camera_lens::lens_of_topic;
pub use devices::{Camera, CameraError, DepthFrame, Frame, Screen};
pub use failure::ScanFailure;
pub use finish::Scanned;
pub use light::Delay;
pub use received::{depth_of, picture_of};
pub use session::{patterns, ScanEvent, ScanOptions, Session};
pub use topics::{CameraTopics, DepthTopic};
pub use verification::Verification;
