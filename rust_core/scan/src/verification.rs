//! A verification: the light and its delay are measured as for a scan, then the errors of spots and outlines on the
//! surface that the camera sees now.

use nalgebra::Isometry3;
use rcs_calibration::patterns::Pattern;
use rcs_calibration::{Lens, LightMap, VerificationPlan, VerificationResult, VerificationScene};

use crate::failure::ScanFailure;
use crate::session::ScanSession;

/// Minimum number of depth images to average for the surface.
const MIN_DEPTHS: u32 = 10;

/// Measured errors with the camera's image.
#[derive(Debug)]
pub struct Verification {
    /// Errors of spots and outlines.
    pub result: VerificationResult,
    /// Camera's image of white: grey levels, row by row.
    pub white: Vec<u8>,
    /// Width and height of the image, pixels.
    pub camera_px: [u32; 2],
}

impl ScanSession<'_> {
    /// Verifies a projector's lens and pose, and leaves spots and outlines shown.
    ///
    /// # Errors
    /// [`ScanFailure`]: as for a scan, or too few spots are seen.
    pub fn verify(
        mut self,
        projector: &Lens,
        projector_from_camera: &Isometry3<f64>,
    ) -> Result<Verification, ScanFailure> {
        let light = self.measure_light()?;
        light.check_exposure()?;
        light.warn(&mut |warning| self.warn(warning));
        let white = self.capture(&Pattern::White, &light, None)?;
        let black = self.capture(&Pattern::Black, &light, Some(&white))?;
        let depth_m = self.average_depth(MIN_DEPTHS)?;
        let camera = self.camera.lens();
        let plan = VerificationPlan::new(&VerificationScene {
            camera: &camera,
            projector,
            projector_from_camera,
            depth_m: &depth_m,
            light: &LightMap::new(&white, &black, camera.size_px[0], light.noise),
        })?;
        let seen = self.capture_images(plan.images(), &light, &black)?;
        self.check_unchanged(&white, &light)?;
        let result = plan.measure(&seen)?;
        self.show_image(plan.overview())?;
        Ok(Verification { result, white, camera_px: camera.size_px })
    }
}
