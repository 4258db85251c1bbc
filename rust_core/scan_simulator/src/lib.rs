//! Simulated scans, for testing the calibration of a projector with an RGB-D camera.
//!
//! A [`Room`] of simple solids is lit by the projector of a [`Rig`] and seen by its camera. Rays are cast once
//! ([`View`]); from these follow the camera's images of patterns ([`Scan`]) under [`Conditions`], and a depth image
//! ([`DepthCamera`]). An [`Arm`] reaches into the room. [`LightError`] is the error of a calibration over the working
//! volume.
//!
//! Everything is reproducible by seeds, byte by byte. Frames are those of `rcs_calibration`: optical frames have x
//! right, y down, z along the view or light; the room's frame has the same axes from the rig, so y points at the floor
//! and z at the back wall. Lengths are metres.

#![forbid(unsafe_code)]

mod arm;
mod bounce;
mod conditions;
mod depth_camera;
mod light_error;
mod projected_image;
mod random;
mod rig;
mod room;
mod scan;
mod seeds;
mod sensor;

mod stripes;
mod surface;
mod view;

pub use arm::Arm;
pub use conditions::{Conditions, Motion};
pub use depth_camera::{DepthCamera, SmoothError};
pub use light_error::LightError;
pub use random::Random;
pub use rig::Rig;
pub use room::{Hit, Room};
pub use scan::Scan;
pub use seeds::{has_many_seeds, seeds};
pub use view::{Sight, View};
