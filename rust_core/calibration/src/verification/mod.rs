//! How far the light of a calibrated projector lands from where it should, measured with a camera that has depth.
//!
//! 1. [`VerificationPlan::new`] chooses places on the surface that the camera sees, where depth is steady, the
//!    projector's light arrives and nothing is in its way: spots all over, and outlines of things along the edges of
//!    the depth image.
//! 2. [`VerificationPlan::pictures`] are what the projector shows: spots and outlines where its file says that they
//!    will land on these places.
//! 3. [`VerificationPlan::measure`] finds the light in the camera's pictures. The surface there is known, and so the
//!    point on which it has landed, and the projector pixel that should have lit it: by so many pixels the light has
//!    missed.
//!
//! Pixels and frames are those of the crate.

mod drawing;
mod light_map;
mod rims;
mod shadow;
mod spots;
mod surface;

use nalgebra::{Isometry3, Point2, Vector2};

use crate::Lens;
use drawing::Drawing;
pub use light_map::LightMap;
use rims::{RimPlace, Rims};
use shadow::Shadow;
use spots::Spot;
use surface::{Patch, Projector, Surface};

/// Fewer spots say nothing.
const LEAST_SPOTS: usize = 8;
/// The least share of the spots that must be seen.
const LEAST_SEEN: f64 = 0.5;
/// Light that lands this close to its place, camera pixels, has landed on the same piece of the surface.
const SAME_PIECE_PX: f64 = 4.0;
/// An outline's light is looked for where so many spots around it have landed.
const NEAR_SPOTS: usize = 5;

/// What is to be verified, and what the camera sees before.
#[derive(Debug, Clone, Copy)]
pub struct VerificationScene<'a> {
    /// The camera's lens.
    pub camera: &'a Lens,
    /// The projector's lens by its file.
    pub projector: &'a Lens,
    /// Takes points of the camera's optical frame to the projector's, by its file.
    pub projector_from_camera: &'a Isometry3<f64>,
    /// Depths along the camera's view, metres, row by row, registered to its pictures; what is not a positive number is
    /// no depth.
    pub depth_m: &'a [f32],
    /// Where the projector's light arrives.
    pub light: &'a LightMap,
}

/// Why nothing can be said.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum VerificationProblem {
    /// There is nothing to put light on.
    #[error(
        "only {spots} places are seen with steady depth where the projector's light should arrive, {LEAST_SPOTS} are \
         needed: do camera and projector look at the same things, and does the file place the projector about where \
         it is?"
    )]
    FewPlaces {
        /// Places for spots.
        spots: usize,
    },
    /// The light is not seen.
    #[error(
        "the camera sees only {seen} of {shown} spots: is the projector's picture shown unscaled, and does the file \
         place the projector about where it is?"
    )]
    FewSeen {
        /// Spots that were found.
        seen: usize,
        /// Spots that were shown.
        shown: usize,
    },
}

/// What the projector shows, and where it should land.
#[derive(Debug, Clone)]
pub struct VerificationPlan {
    surface: Surface,
    projector: Projector,
    light: LightMap,
    spots: Vec<Spot>,
    rims: Rims,
}

/// Where light has landed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VerifiedPoint {
    /// Where the camera should see the light, pixels.
    pub expected: Point2<f64>,
    /// Where it sees it, pixels. Of an outline only how far beside it that is has been measured.
    pub landed: Point2<f64>,
    /// The distance in the projector's picture: from the pixel that was lit to the one that lights this place by the
    /// file, pixels.
    pub px: f64,
    /// The same distance where the light should land, across its direction, metres.
    pub m: f64,
}

/// What was measured.
#[derive(Debug, Clone, PartialEq)]
pub struct VerificationResult {
    /// The spots that were seen.
    pub spots: Vec<VerifiedPoint>,
    /// How many were shown.
    pub spots_shown: usize,
    /// The places of outlines that were seen.
    pub edges: Vec<VerifiedPoint>,
    /// How many were shown.
    pub edges_shown: usize,
}

/// Distances in short, each in projector pixels and in metres.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ErrorStatistics {
    /// How many distances.
    pub count: usize,
    /// The middle one.
    pub median: [f64; 2],
    /// The root of the mean square.
    pub rms: [f64; 2],
    /// The largest.
    pub worst: [f64; 2],
}

impl VerificationPlan {
    /// Chooses the places. `depth_m` and the light's pictures must have as many pixels as the camera's lens says.
    ///
    /// # Errors
    /// [`VerificationProblem::FewPlaces`].
    pub fn new(scene: &VerificationScene<'_>) -> Result<Self, VerificationProblem> {
        let surface = Surface::new(scene.camera, scene.depth_m);
        let projector = Projector { lens: *scene.projector, from_camera: *scene.projector_from_camera };
        let shadow = Shadow::new(&surface, &projector);
        let spots = spots::choose(&surface, &projector, &shadow, scene.light);
        if spots.len() < LEAST_SPOTS {
            return Err(VerificationProblem::FewPlaces { spots: spots.len() });
        }
        let rims = Rims::new(&surface, &projector, &shadow, scene.light);
        Ok(Self { surface, projector, light: scene.light.clone(), spots, rims })
    }

    /// What the projector is to show one after the other: grey levels of its size, row by row. The last picture shows
    /// the outlines, those before it the spots.
    pub fn pictures(&self) -> Vec<Vec<u8>> {
        let size_px = self.projector.lens.size_px;
        let spots = spots::pictures(&self.spots, size_px);
        spots.into_iter().chain([self.rims.picture(size_px)]).map(|drawing| drawing.levels).collect()
    }

    /// Spots and outlines together, to look at.
    pub fn overview(&self) -> Vec<u8> {
        let size_px = self.projector.lens.size_px;
        let mut all: Drawing = self.rims.picture(size_px);
        spots::pictures(&self.spots, size_px).iter().for_each(|drawing| all.add(drawing));
        all.levels
    }

    /// How many spots and places of outlines there are.
    pub fn counts(&self) -> [usize; 2] {
        [self.spots.len(), self.rims.places.len()]
    }

    /// Finds the light. `seen` are the camera's pictures of [`Self::pictures`], in their order: grey levels, row by
    /// row.
    ///
    /// # Errors
    /// [`VerificationProblem::FewSeen`].
    pub fn measure(&self, seen: &[Vec<u8>]) -> Result<VerificationResult, VerificationProblem> {
        let shares: Vec<_> = seen.iter().map(|grey| self.light.shares(grey)).collect();
        let found = spots::find(&self.spots, &shares).into_iter().zip(&self.spots);
        let spots: Vec<VerifiedPoint> =
            found.filter_map(|(found, spot)| self.miss(&spot.patch, spot.expected, found?)).collect();
        let shown = self.spots.len();
        if spots.len() < LEAST_SPOTS || (spots.len() as f64) < LEAST_SEEN * shown as f64 {
            return Err(VerificationProblem::FewSeen { seen: spots.len(), shown });
        }
        let edge = |place: &RimPlace| {
            let landed = place.find(shares.last()?, shift_near(place.expected, &spots))?;
            self.miss(&place.patch, place.expected, landed)
        };
        let edges: Vec<VerifiedPoint> = self.rims.places.iter().filter_map(edge).collect();
        Ok(VerificationResult { spots, spots_shown: shown, edges, edges_shown: self.rims.places.len() })
    }

    /// How far apart two places are; none where the surface is not known.
    fn miss(&self, patch: &Patch, expected: Point2<f64>, landed: Point2<f64>) -> Option<VerifiedPoint> {
        let camera = &self.surface.camera;
        let is_near = (landed - expected).norm() <= SAME_PIECE_PX;
        let there = if is_near { *patch } else { self.surface.patch_near(landed)? };
        let (aim, point) = (patch.point(camera, expected)?, there.point(camera, landed)?);
        let miss = self.projector.pixel(&point)? - self.projector.pixel(&aim)?;
        // Light that just misses a thing lands far behind it: what counts is by how much it has missed.
        let depth_m = (self.projector.from_camera * aim).z;
        let m = miss.component_div(&self.projector.lens.focal_px).norm() * depth_m;
        Some(VerifiedPoint { expected, landed, px: miss.norm(), m })
    }
}

/// By how much the spots around a place have missed theirs in the camera's picture, pixels: an outline's light is
/// looked for there.
fn shift_near(place: Point2<f64>, spots: &[VerifiedPoint]) -> Vector2<f64> {
    let mut nearest: Vec<&VerifiedPoint> = spots.iter().collect();
    nearest.sort_by(|a, b| (a.expected - place).norm().total_cmp(&(b.expected - place).norm()));
    nearest.truncate(NEAR_SPOTS);
    let median = |axis: usize| {
        let mut shifts: Vec<f64> = nearest.iter().map(|miss| miss.landed[axis] - miss.expected[axis]).collect();
        shifts.sort_by(f64::total_cmp);
        shifts.get(shifts.len() / 2).copied().unwrap_or_default()
    };
    Vector2::new(median(0), median(1))
}

impl VerificationResult {
    /// The distances of spots and outlines together.
    pub fn all(&self) -> ErrorStatistics {
        ErrorStatistics::of(self.spots.iter().chain(&self.edges))
    }
}

impl ErrorStatistics {
    /// Of distances; all zero if there are none.
    pub fn of<'a>(misses: impl IntoIterator<Item = &'a VerifiedPoint>) -> Self {
        let misses: Vec<[f64; 2]> = misses.into_iter().map(|miss| [miss.px, miss.m]).collect();
        let count = misses.len();
        let of_unit = |unit: usize, figure: fn(&mut Vec<f64>) -> f64| {
            let mut sorted: Vec<f64> = misses.iter().map(|miss| miss[unit]).collect();
            sorted.sort_by(f64::total_cmp);
            figure(&mut sorted)
        };
        let both = |figure: fn(&mut Vec<f64>) -> f64| [of_unit(0, figure), of_unit(1, figure)];
        Self {
            count,
            median: both(|sorted| sorted.get(sorted.len() / 2).copied().unwrap_or_default()),
            rms: both(|sorted| {
                (sorted.iter().map(|miss| miss * miss).sum::<f64>() / sorted.len().max(1) as f64).sqrt()
            }),
            worst: both(|sorted| sorted.last().copied().unwrap_or_default()),
        }
    }
}
