//! Pose of a bumped projector with a known lens, by a few images of spots.
//!
//! The file's pose need not be right: it only chooses spots that about cover the lit surface. The code tells which spot
//! landed where, the depth image gives the lit point, and [`solve`] the pose with its deviations. Motion meanwhile
//! shows in the centroids: each spot is lit in half of the images, and has to be at the same place in all of them.

use super::light_map::LightMap;
use super::scene::VerificationScene;
use super::spots::{self, Spot, SpotLight, LEAST_SPOTS};
use super::stillness;
use super::surface::{DepthSurface, PosedProjector, ShadowMap};
use super::zoom::{self, Zoom};
use crate::{solve, Lens, Refusal, Sample, Solution, SolveOptions};

/// Minimum share of spots that must be detected: a bump moves some of them out of view or onto edges.
const LEAST_SEEN: f64 = 0.25;
/// Minimum share of the detected spots that must agree with the pose.
const LEAST_AGREEING: f64 = 0.7;
/// Standard deviation of a centroid, camera pixels.
const SIGMA_CAMERA_PX: f64 = 0.1;

/// Reason why a pose cannot be refined.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RefinementProblem {
    /// Too few targets.
    #[error(
        "only {spots} places are seen with steady depth where the projector's light arrives, {LEAST_SPOTS} are needed: \
         do camera and projector look at the same scene, and does a mask leave enough of it lit?"
    )]
    FewPlaces {
        /// Number of places for spots.
        spots: usize,
    },
    /// Too few spots detected.
    #[error(
        "the camera sees only {seen} of {shown} spots: is a blackout on, does a mask hide them, or is the projector \
         bumped so far that a scan is needed?"
    )]
    FewSeen {
        /// Number of detected spots.
        seen: usize,
        /// Number of projected spots.
        shown: usize,
    },
    /// Motion during the images.
    #[error(
        "the camera, the projector or the things have moved by {px:.1} camera pixels while spots were shown: keep all \
         at rest and refine again"
    )]
    Moved {
        /// Distance, camera pixels.
        px: f64,
    },
    /// The projector's zoom or focus has changed, by a share of the focal length.
    #[error(
        "the projector's zoom has changed by {:.1} % (± {:.1} %): set it back, or calibrate the lens again with scan",
        100.0 * change, 100.0 * sigma
    )]
    ZoomChanged {
        /// Change as a share of the focal length.
        change: f64,
        /// Standard deviation of that.
        sigma: f64,
    },
    /// Too many spots disagree with the pose: the share that agrees, percent.
    #[error(
        "only {0:.0} % of the spots agree with one pose: was the zoom or the keystone correction changed, did something \
         move, is the depth registered to the image?"
    )]
    Inconsistent(f64),
    /// The spots determine no pose.
    #[error(transparent)]
    Unsolvable(Refusal),
}

/// Converts a refusal of the solver: spots disagree for other reasons than samples of a scan.
fn unsolvable(refusal: Refusal) -> RefinementProblem {
    match refusal {
        Refusal::FewInliers { percent, .. } | Refusal::Moved { first_percent: percent, .. } => {
            RefinementProblem::Inconsistent(percent)
        }
        Refusal::TwoPoses { second_percent, .. } => RefinementProblem::Inconsistent(100.0 - second_percent),
        refusal => RefinementProblem::Unsolvable(refusal),
    }
}

/// Refined pose.
#[derive(Debug, Clone, PartialEq)]
pub struct RefinedPose {
    /// Pixels of the spots, and the points that they light.
    pub samples: Vec<Sample>,
    /// Lens of the file, and the pose with its deviations.
    pub solution: Solution,
    /// Number of projected spots.
    pub shown: usize,
    /// Zoom compared with the file's.
    pub zoom: Zoom,
}

/// Spots for a refinement.
#[derive(Debug, Clone)]
pub struct PoseRefinement {
    projector: PosedProjector,
    camera: Lens,
    light: LightMap,
    spots: Vec<Spot>,
}

impl PoseRefinement {
    /// Chooses the spots by the file's pose. Depth and light map must have the camera lens's size.
    ///
    /// # Errors
    /// [`RefinementProblem::FewPlaces`].
    pub fn new(scene: &VerificationScene<'_>) -> Result<Self, RefinementProblem> {
        let surface = DepthSurface::new(scene.camera, scene.depth_m);
        let projector = PosedProjector { lens: *scene.projector, from_camera: *scene.projector_from_camera };
        let shadow = ShadowMap::new(&surface, &projector);
        let spots = spots::choose(&surface, &projector, &shadow, scene.light);
        if spots.len() < LEAST_SPOTS {
            return Err(RefinementProblem::FewPlaces { spots: spots.len() });
        }
        Ok(Self { projector, camera: *scene.camera, light: scene.light.clone(), spots })
    }

    /// At most eight images to project one after the other: grey levels, row by row.
    pub fn images(&self) -> Vec<Vec<u8>> {
        let drawings = spots::images(&self.spots, self.projector.lens.size_px);
        drawings.into_iter().map(|drawing| drawing.levels).collect()
    }

    /// Solves for the pose from the camera's images of [`Self::images`], in their order: grey levels, row by row, and
    /// depths as in [`VerificationScene::depth_m`].
    ///
    /// # Errors
    /// [`RefinementProblem`]: too few spots are seen, something moved, the zoom has changed, or there is no solution.
    pub fn refine(&self, images: &[Vec<u8>], depth_m: &[f32]) -> Result<RefinedPose, RefinementProblem> {
        let surface = DepthSurface::new(&self.camera, depth_m);
        let shares: Vec<_> = images.iter().map(|grey| self.light.shares(grey)).collect();
        let found = spots::find(&self.spots, &shares);
        let seen: Vec<(&Spot, SpotLight)> =
            self.spots.iter().zip(found).filter_map(|(spot, found)| Some((spot, found?))).collect();
        let shown = self.spots.len();
        let lights: Vec<&SpotLight> = seen.iter().map(|(_, light)| light).collect();
        if let Some(px) = stillness::motion_px(&lights, images.len()) {
            return Err(RefinementProblem::Moved { px });
        }
        let samples: Vec<Sample> = seen.iter().filter_map(|(spot, light)| self.sample(spot, light, &surface)).collect();
        if samples.len() < LEAST_SPOTS || (samples.len() as f64) < LEAST_SEEN * shown as f64 {
            return Err(RefinementProblem::FewSeen { seen: samples.len(), shown });
        }
        let lens = self.projector.lens;
        let zoom = zoom::check(&samples, &lens);
        if let Some(Zoom::Changed { change, sigma }) = zoom {
            return Err(RefinementProblem::ZoomChanged { change, sigma });
        }
        let options = SolveOptions { known_lens: Some(lens), ..SolveOptions::new(lens.size_px) };
        let solution = solve(&samples, &options).map_err(unsolvable)?;
        let agreeing = solution.inliers as f64 / samples.len() as f64;
        match zoom {
            Some(zoom) if agreeing >= LEAST_AGREEING => Ok(RefinedPose { samples, solution, shown, zoom }),
            _ => Err(RefinementProblem::Inconsistent(100.0 * agreeing)),
        }
    }

    /// Point that a spot lights; `None` where it is unsteady, or depth is missing or has an edge.
    fn sample(&self, spot: &Spot, light: &SpotLight, surface: &DepthSurface) -> Option<Sample> {
        if !stillness::is_steady(light) {
            return None;
        }
        let camera = &self.camera;
        let patch = surface.patch_near(light.at)?;
        let point = patch.point(camera, light.at)?;
        let by_camera_px = self.projector.by_camera_px(&patch, camera, light.at)?;
        let sigma_px = SIGMA_CAMERA_PX * by_camera_px.determinant().sqrt();
        Some(Sample { sigma_px, ..Sample::new(spot.pixel, point) })
    }
}
