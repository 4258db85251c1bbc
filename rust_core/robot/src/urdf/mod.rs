//! Robot descriptions (URDF): links with their shapes, and joints.
//!
//! Accepts and refuses what urdfdom 3.0 does, as rviz: a shape that cannot be read ends its link, but not the robot; a
//! joint that cannot be read is an error of the whole robot; the first definition of a material's name in the whole
//! file counts; a colour of three numbers is black. The crate `urdf-rs` refuses the robot for one shape, has no lines
//! in its errors and accepts duplicate names.

mod attribute_values;
mod elements;
mod model;
mod parse;

pub use model::{Collision, Joint, JointKind, JointLimits, Link, Robot, UrdfError, UrdfMaterial, UrdfShape, Visual};
