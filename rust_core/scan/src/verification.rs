//! A verification from the first look to the distances: the light and its delay as for a scan, then spots and outlines
//! on the surface that the camera sees now.

use std::time::Duration;

use nalgebra::Isometry3;
use rcs_calibration::patterns::Pattern;
use rcs_calibration::{Lens, LightMap, VerificationPlan, VerificationResult, VerificationScene};

use crate::failure::ScanFailure;
use crate::session::{ScanEvent, Session};

/// Depth images that the surface is the mean of, at least,
const LEAST_DEPTHS: u32 = 10;
/// or as many as come within this time.
const DEPTHS_WITHIN: Duration = Duration::from_secs(5);

/// What a verification yields.
#[derive(Debug)]
pub struct Verification {
    /// How far light landed from where it should.
    pub verified: VerificationResult,
    /// The camera's picture of the white projector: grey levels, row by row.
    pub white: Vec<u8>,
    /// Width and height of that, pixels.
    pub camera_px: [u32; 2],
}

impl Session<'_> {
    /// Verifies a projector's file and leaves spots and outlines shown.
    ///
    /// # Errors
    /// [`ScanFailure`]: what would refuse a scan, or too little light is found.
    pub fn verify(
        mut self,
        projector: &Lens,
        projector_from_camera: &Isometry3<f64>,
    ) -> Result<Verification, ScanFailure> {
        let light = self.find_light()?;
        for warning in light.warnings() {
            self.tell(ScanEvent::Warning(&warning));
        }
        let white = self.capture(&Pattern::White, &light, None)?;
        let black = self.capture(&Pattern::Black, &light, Some(&white))?;
        let depth_m = self.steady_depth()?;
        let camera = self.camera_lens();
        let plan = VerificationPlan::new(&VerificationScene {
            camera: &camera,
            projector,
            projector_from_camera,
            depth_m: &depth_m,
            light: &LightMap::new(&white, &black, camera.size_px[0], light.noise),
        })?;
        let pictures = plan.pictures();
        self.tell(ScanEvent::Delay(light.delay, pictures.len()));
        let mut seen: Vec<Vec<u8>> = Vec::new();
        for picture in pictures {
            let shown = self.show_picture(picture)?;
            let last = seen.last().unwrap_or(&black);
            let grey = self.capture_shown(shown, &light, Some(last))?;
            seen.push(grey);
            self.tell(ScanEvent::Captured { pictures: &[], readable: 1.0 });
        }
        self.check_unchanged(&white, &light)?;
        let verified = plan.measure(&seen)?;
        self.show_picture(plan.overview())?;
        Ok(Verification { verified, white, camera_px: camera.size_px })
    }

    /// The mean of enough depth images, metres.
    fn steady_depth(&mut self) -> Result<Vec<f32>, ScanFailure> {
        let mut after = self.now();
        let until = after + DEPTHS_WITHIN;
        loop {
            let frames = self.depth().frames();
            if frames >= LEAST_DEPTHS || (frames > 0 && after > until) {
                return Ok(self.depth().depth_m());
            }
            if after > until {
                return Err(ScanFailure::NoDepth);
            }
            after = self.frame(after)?.received;
        }
    }
}
