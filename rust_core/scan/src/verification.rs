//! A verification: the light and its delay are measured as for a scan, then the errors of spots and outlines on the
//! surface that the camera sees now.

use nalgebra::Isometry3;
use rcs_calibration::patterns::Pattern;
use rcs_calibration::{Lens, LightMap, VerificationPlan, VerificationResult, VerificationScene};

use crate::failure::ScanFailure;
use crate::session::{ScanEvent, ScanSession};

/// Least depth images that the surface is the mean of.
const MIN_DEPTHS: u32 = 10;

/// The result of a verification.
#[derive(Debug)]
pub struct Verification {
    /// The errors of spots and outlines.
    pub result: VerificationResult,
    /// The camera's image of white: grey levels, row by row.
    pub white: Vec<u8>,
    /// Width and height of that, pixels.
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
        let pictures = plan.pictures();
        (self.observe)(ScanEvent::Delay(light.delay, pictures.len()));
        let mut seen: Vec<Vec<u8>> = Vec::new();
        for picture in pictures {
            let shown = self.show_picture(picture)?;
            let last = seen.last().unwrap_or(&black);
            let grey = self.capture_shown(shown, &light, Some(last))?;
            seen.push(grey);
            (self.observe)(ScanEvent::Captured { pictures: &[], readable: 1.0 });
        }
        self.check_unchanged(&white, &light)?;
        let result = plan.measure(&seen)?;
        self.show_picture(plan.overview())?;
        Ok(Verification { result, white, camera_px: camera.size_px })
    }
}
