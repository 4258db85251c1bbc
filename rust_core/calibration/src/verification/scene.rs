//! Prior knowledge of a verification and a refinement.

use nalgebra::Isometry3;

use super::light_map::LightMap;
use crate::Lens;

/// Camera, projector and scene to verify.
#[derive(Debug, Clone, Copy)]
pub struct VerificationScene<'a> {
    /// Camera lens.
    pub camera: &'a Lens,
    /// Projector lens by its file.
    pub projector: &'a Lens,
    /// Projector pose by its file, from the camera's optical frame.
    pub projector_from_camera: &'a Isometry3<f64>,
    /// Depths along the optical axis, metres, row by row, registered to the camera images; values that are not positive
    /// are missing.
    pub depth_m: &'a [f32],
    /// Projector light in the camera's image.
    pub light: &'a LightMap,
}
