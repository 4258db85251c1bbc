//! Robot descriptions (URDF), chains of joints, and aiming a beam with a pan-tilt unit.
//!
//! No ROS, no files, no drawing. Lengths are metres, angles radians. Transforms are named `target_from_source`; a joint
//! rotates right-handed about its axis.

#![forbid(unsafe_code)]
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod aim;
mod chain;
mod pan_tilt;
mod urdf;

pub use aim::{Aim, Beam};
pub use chain::ChainError;
pub use pan_tilt::{Hinge, PanTilt, Travel};
pub use urdf::{Collision, Joint, JointKind, JointLimits, Link, Robot, UrdfError, UrdfMaterial, UrdfShape, Visual};
