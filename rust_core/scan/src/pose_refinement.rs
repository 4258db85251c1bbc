//! A refinement: a brief look, at most eight images of spots, and the pose of a projector that was bumped.

use std::time::Duration;

use nalgebra::Isometry3;
use rcs_calibration::patterns::Pattern;
use rcs_calibration::{Lens, LightMap, PoseRefinement, RefinedPose, VerificationScene};

use crate::failure::ScanFailure;
use crate::session::{ScanEvent, ScanSession};

/// Least depth images that spots are chosen by. More come while they are shown.
const MIN_DEPTHS: u32 = 3;

/// The result of a refinement.
#[derive(Debug)]
pub struct Refinement {
    /// The pose.
    pub refined: RefinedPose,
    /// Time that it took.
    pub elapsed: Duration,
}

impl ScanSession<'_> {
    /// Finds the pose of a projector with a known lens and leaves it dark. By its file it is at
    /// `projector_from_camera`, from which it may be off by some degrees and centimetres.
    ///
    /// # Errors
    /// [`ScanFailure`]: as for a scan, or the spots do not tell the pose.
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
        let pictures = refinement.pictures();
        (self.observe)(ScanEvent::Delay(light.delay, pictures.len()));
        let mut seen: Vec<Vec<u8>> = Vec::new();
        for picture in pictures {
            let shown = self.show_picture(picture)?;
            let last = seen.last().unwrap_or(&white);
            let grey = self.capture_shown(shown, &light, Some(last))?;
            seen.push(grey);
            (self.observe)(ScanEvent::Captured { pictures: &[], readable: 1.0 });
        }
        self.check_unchanged(&white, &light)?;
        let refined = refinement.refine(&seen, &self.depth.depth_m())?;
        Ok(Refinement { refined, elapsed: self.camera.now().saturating_duration_since(started) })
    }
}
