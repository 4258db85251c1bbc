//! The C interface of the Rust core, which rviz's CameraPub plugin links: the projection of a CameraInfo, pacing, the
//! bytes of a finished image, its lens, statistics, and the node's report on a config.
//!
//! ```text
//!   C ──► extern "C" functions ──► guard: panics and errors become text
//!                │                 pointers: NULL, alignment, length and overlap are checked before anything is read
//!                └──► rcs_camera, rcs_rviz_config: the code that the node uses, too
//! ```
//!
//! `ros_pkg/include/rviz_camera_stream/core.h` is generated from this crate: the comments of exported items are the
//! interface's documentation. It is the only crate with `unsafe`, which pointers from C need; it handles only pointers,
//! texts and handles.
//!
//! An `enum` or `bool` from C is taken as a number and checked: a Rust `enum` or `bool` with an invalid value would be
//! undefined behaviour.

#![cfg_attr(not(test), warn(clippy::disallowed_methods, clippy::multiple_unsafe_ops_per_block, clippy::panic))]

mod camera;
mod config_report;
mod encoding;
mod fault;
mod guard;
mod numbers;
mod pacing;
mod pixels;
mod pointers;
mod statistics;
#[cfg(test)]
mod tests;
mod text;
mod version;
mod view;

pub use camera::*;
pub use config_report::*;
pub use encoding::*;
pub use fault::RcsResult;
pub use guard::rcs_last_error;
pub use numbers::{EncodingNumber, Flag, PixelOrderNumber, ProjectionNumber};
pub use pacing::*;
pub use pixels::*;
pub use statistics::*;
pub use version::*;
pub use view::*;
