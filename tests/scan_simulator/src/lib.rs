//! Simulated scans, to test the calibration of a projector by an RGB-D camera with.
//!
//! A [`Room`] of simple solids is lit by the projector of a [`Rig`] and seen by its camera. Ray casting tells once what
//! each camera pixel sees ([`View`]); from that follow the pictures that the camera takes of patterns ([`Scan`]), with
//! what goes wrong in them ([`Conditions`]), and a depth image ([`DepthCamera`]). [`LightError`] says by how much a
//! calibration misses over the whole working volume.
//!
//! Everything follows from seeds: the same ones give the same bytes. Frames are those of `rcs_calibration`: optical
//! frames have x right, y down, z along the view or light; the room's frame has the same axes as seen from the rig, so
//! y points at the floor and z at the back wall. Lengths are metres.

#![forbid(unsafe_code)]

mod bounce;
mod conditions;
mod depth_camera;
mod light_error;
mod random;
mod rig;
mod room;
mod scan;
mod seeds;
mod sensor;
mod shown;
mod stripes;
mod surface;
mod view;

pub use conditions::{Conditions, Motion};
pub use depth_camera::{DepthCamera, SmoothError};
pub use light_error::LightError;
pub use random::Random;
pub use rig::Rig;
pub use room::{Hit, Room};
pub use scan::Scan;
pub use seeds::{has_many_seeds, seeds};
pub use view::{Sight, View};
