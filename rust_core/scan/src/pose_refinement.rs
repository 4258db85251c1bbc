//! Refinement of a bumped projector's pose: a brief look at its light, then at most eight images of spots.

use std::time::Duration;

use nalgebra::Isometry3;
use rcs_calibration::patterns::Pattern;
use rcs_calibration::{Lens, LightMap, PoseRefinement, RefinedPose, VerificationScene};

use crate::failure::ScanFailure;
use crate::session::ScanSession;

/// Minimum number of depth images to choose spots by. More come while the spots are shown.
const MIN_DEPTHS: u32 = 3;

/// Refined pose and duration.
#[derive(Debug)]
pub struct Refinement {
    /// Pose with its samples.
    pub refined: RefinedPose,
    /// Duration from the first look to the pose.
    pub elapsed: Duration,
}

impl ScanSession<'_> {
    /// Finds the pose of a projector with a known lens, and leaves it dark. The true pose may differ from
    /// `projector_from_camera`, that of the projector's file, by a few degrees and centimetres.
    ///
    /// # Errors
    /// [`ScanFailure`]: as for a scan, or the spots do not determine the pose.
    pub fn refine(
        mut self,
        projector: &Lens,
        projector_from_camera: &Isometry3<f64>,
    ) -> Result<Refinement, ScanFailure> {
        let result = self.refine_lit(projector, projector_from_camera);
        let dark = self.show(&Pattern::Black);
        let result = result?;
        dark.map(|_| result)
    }

    fn refine_lit(
        &mut self,
        projector: &Lens,
        projector_from_camera: &Isometry3<f64>,
    ) -> Result<Refinement, ScanFailure> {
        let started = self.camera.now();
        let (light, black) = self.look_briefly()?;
        light.check_exposure()?;
        light.warn(&mut |warning| self.warn(warning));
        let white = self.capture(&Pattern::White, &light, Some(&black))?;
        let depth_m = self.average_depth(MIN_DEPTHS)?;
        let camera = self.camera.lens();
        let refinement = PoseRefinement::new(&VerificationScene {
            camera: &camera,
            projector,
            projector_from_camera,
            depth_m: &depth_m,
            light: &LightMap::new(&white, &black, camera.size_px[0], light.noise),
        })?;
        let seen = self.capture_images(refinement.images(), &light, &white)?;
        self.check_unchanged(&white, &light)?;
        let refined = refinement.refine(&seen, &self.depth.depth_m())?;
        Ok(Refinement { refined, elapsed: self.camera.now().saturating_duration_since(started) })
    }
}
