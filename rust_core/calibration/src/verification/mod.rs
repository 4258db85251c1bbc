//! Verification of a calibrated projector: projection errors, measured with an RGB-D camera.
//!
//! 1. [`VerificationPlan::new`] chooses targets on surfaces with steady depth that the projector lights unoccluded:
//!    spots all over, and outlines along the edges of the depth image.
//! 2. [`VerificationPlan::images`] are the images to project, by the projector's file.
//! 3. [`VerificationPlan::measure`] finds the light in the camera's images. The surface gives the lit point, and the
//!    file the projector pixel that should have lit it: its distance from the pixel that did is the error.
//!
//! [`PoseRefinement`] finds the pose of a bumped projector with the same spots, without outlines.
//!
//! Pixels and frames are those of the crate.

mod drawing;
mod light_map;
mod outlines;
mod pose_refinement;
mod scene;
mod spots;
mod stillness;
mod surface;
mod zoom;

use nalgebra::{Point2, Vector2};

use crate::statistics::{median, root_mean_square};
use drawing::Drawing;
pub use light_map::LightMap;
use outlines::{OutlinePlace, Outlines};
pub use pose_refinement::{PoseRefinement, RefinedPose, RefinementProblem};
pub use scene::VerificationScene;
use spots::{Spot, LEAST_SPOTS};
use surface::{DepthSurface, Patch, PosedProjector, ShadowMap};
pub use zoom::Zoom;

/// Minimum share of spots that must be detected.
const LEAST_SEEN: f64 = 0.5;
/// Maximum distance between target and detection on the same surface patch, camera pixels.
const SAME_PIECE_PX: f64 = 4.0;
/// Number of nearest spots whose median offset is the search start for an outline.
const NEAR_SPOTS: usize = 5;

/// Verification is impossible.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum VerificationProblem {
    /// Too few targets.
    #[error(
        "only {spots} places are seen with steady depth where the projector's light should arrive, {LEAST_SPOTS} are \
         needed: do camera and projector look at the same scene, and does the file place the projector about where it \
         is?"
    )]
    FewPlaces {
        /// Number of places for spots.
        spots: usize,
    },
    /// Too few spots detected.
    #[error(
        "the camera sees only {seen} of {shown} spots: is the projector's picture shown unscaled, and does the file \
         place the projector about where it is?"
    )]
    FewSeen {
        /// Number of detected spots.
        seen: usize,
        /// Number of projected spots.
        shown: usize,
    },
}

/// Targets of a verification.
#[derive(Debug, Clone)]
pub struct VerificationPlan {
    surface: DepthSurface,
    projector: PosedProjector,
    light: LightMap,
    spots: Vec<Spot>,
    outlines: Outlines,
}

/// Target with the position at which its light was detected.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VerifiedPoint {
    /// Expected camera pixel.
    pub expected: Point2<f64>,
    /// Detected camera pixel. For outlines, only the offset across the line is measured.
    pub landed: Point2<f64>,
    /// Error in projector pixels: from the lit pixel to the one that lights the detected place by the file.
    pub px: f64,
    /// Error at the target's depth, across the light, metres.
    pub m: f64,
}

/// Result of a verification.
#[derive(Debug, Clone, PartialEq)]
pub struct VerificationResult {
    /// Detected spots.
    pub spots: Vec<VerifiedPoint>,
    /// Number of projected spots.
    pub spots_shown: usize,
    /// Detected outline targets.
    pub edges: Vec<VerifiedPoint>,
    /// Number of projected outline targets.
    pub edges_shown: usize,
}

/// Error statistics, each in projector pixels and in metres.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ErrorStatistics {
    /// Number of errors.
    pub count: usize,
    /// Median.
    pub median: [f64; 2],
    /// Root mean square.
    pub rms: [f64; 2],
    /// Maximum.
    pub worst: [f64; 2],
}

impl VerificationPlan {
    /// Chooses the targets. Depth and light map must have the camera lens's size.
    ///
    /// # Errors
    /// [`VerificationProblem::FewPlaces`].
    pub fn new(scene: &VerificationScene<'_>) -> Result<Self, VerificationProblem> {
        let surface = DepthSurface::new(scene.camera, scene.depth_m);
        let projector = PosedProjector { lens: *scene.projector, from_camera: *scene.projector_from_camera };
        let shadow = ShadowMap::new(&surface, &projector);
        let spots = spots::choose(&surface, &projector, &shadow, scene.light);
        if spots.len() < LEAST_SPOTS {
            return Err(VerificationProblem::FewPlaces { spots: spots.len() });
        }
        let outlines = Outlines::new(&surface, &projector, &shadow, scene.light);
        Ok(Self { surface, projector, light: scene.light.clone(), spots, outlines })
    }

    /// Images to project one after the other: grey levels, row by row. The last one has the outlines, the others spots.
    pub fn images(&self) -> Vec<Vec<u8>> {
        let size_px = self.projector.lens.size_px;
        let spots = spots::images(&self.spots, size_px);
        spots.into_iter().chain([self.outlines.image(size_px)]).map(|drawing| drawing.levels).collect()
    }

    /// Spots and outlines in one image, for people.
    pub fn overview(&self) -> Vec<u8> {
        let size_px = self.projector.lens.size_px;
        let mut all: Drawing = self.outlines.image(size_px);
        spots::images(&self.spots, size_px).iter().for_each(|drawing| all.add(drawing));
        all.levels
    }

    /// Number of spots and of outline targets.
    pub fn counts(&self) -> [usize; 2] {
        [self.spots.len(), self.outlines.places.len()]
    }

    /// Measures the errors from the camera's images of [`Self::images`], in their order: grey levels, row by row.
    ///
    /// # Errors
    /// [`VerificationProblem::FewSeen`].
    pub fn measure(&self, images: &[Vec<u8>]) -> Result<VerificationResult, VerificationProblem> {
        let shares: Vec<_> = images.iter().map(|grey| self.light.shares(grey)).collect();
        let found = spots::find(&self.spots, &shares).into_iter().zip(&self.spots);
        let spots: Vec<VerifiedPoint> =
            found.filter_map(|(found, spot)| self.verified(&spot.patch, spot.expected, found?.at)).collect();
        let shown = self.spots.len();
        if spots.len() < LEAST_SPOTS || (spots.len() as f64) < LEAST_SEEN * shown as f64 {
            return Err(VerificationProblem::FewSeen { seen: spots.len(), shown });
        }
        let edge = |place: &OutlinePlace| {
            let landed = place.find(shares.last()?, shift_near(place.expected, &spots))?;
            self.verified(&place.patch, place.expected, landed)
        };
        let edges: Vec<VerifiedPoint> = self.outlines.places.iter().filter_map(edge).collect();
        Ok(VerificationResult { spots, spots_shown: shown, edges, edges_shown: self.outlines.places.len() })
    }

    /// Error of a detected target; `None` where the surface is unknown.
    fn verified(&self, patch: &Patch, expected: Point2<f64>, landed: Point2<f64>) -> Option<VerifiedPoint> {
        let camera = &self.surface.camera;
        let is_near = (landed - expected).norm() <= SAME_PIECE_PX;
        let there = if is_near { *patch } else { self.surface.patch_near(landed)? };
        let (aim, point) = (patch.point(camera, expected)?, there.point(camera, landed)?);
        let error = self.projector.pixel(&point)? - self.projector.pixel(&aim)?;
        // Light that just misses an object lands far behind it, so the target's depth counts.
        let depth_m = (self.projector.from_camera * aim).z;
        let m = error.component_div(&self.projector.lens.focal_px).norm() * depth_m;
        Some(VerifiedPoint { expected, landed, px: error.norm(), m })
    }
}

/// Median offset of the nearest spots from their targets, camera pixels.
fn shift_near(place: Point2<f64>, spots: &[VerifiedPoint]) -> Vector2<f64> {
    let mut nearest: Vec<&VerifiedPoint> = spots.iter().collect();
    nearest.sort_by(|a, b| (a.expected - place).norm().total_cmp(&(b.expected - place).norm()));
    nearest.truncate(NEAR_SPOTS);
    let shift = |axis: usize| {
        let mut shifts: Vec<f64> = nearest.iter().map(|spot| spot.landed[axis] - spot.expected[axis]).collect();
        median(&mut shifts)
    };
    Vector2::new(shift(0), shift(1))
}

impl VerificationResult {
    /// Statistics of spots and outlines together.
    pub fn all(&self) -> ErrorStatistics {
        ErrorStatistics::of(self.spots.iter().chain(&self.edges))
    }
}

impl ErrorStatistics {
    /// Statistics of points; all zero if there are none.
    pub fn of<'a>(points: impl IntoIterator<Item = &'a VerifiedPoint>) -> Self {
        let errors: Vec<[f64; 2]> = points.into_iter().map(|point| [point.px, point.m]).collect();
        let [px, m] = [0, 1].map(|unit| {
            let mut values: Vec<f64> = errors.iter().map(|error| error[unit]).collect();
            let median = if values.is_empty() { 0.0 } else { median(&mut values) };
            values.sort_by(f64::total_cmp);
            [median, root_mean_square(values.iter().copied()), values.last().copied().unwrap_or_default()]
        });
        Self { count: errors.len(), median: [px[0], m[0]], rms: [px[1], m[1]], worst: [px[2], m[2]] }
    }
}
