//! Spots of light: placement, identification, detection.
//!
//! Each spot is in two images, that of its row and that of its column in a square table of all spots. No other spot is
//! in both, so their minimum shows this spot alone, however far it lands from its target.

use nalgebra::{Point2, Vector2};
use rayon::prelude::*;

use super::drawing::Drawing;
use super::light_map::{LightMap, Shares};
use super::surface::{DepthSurface, Patch, PosedProjector, ShadowMap};

/// Maximum number of spots.
const MOST: usize = 64;
/// Minimum distance of two spots, camera pixels.
const LEAST_APART_PX: f64 = 18.0;
/// Spacing of the candidate lattice, camera pixels.
const LATTICE_PX: usize = 4;
/// Radius of a spot in the camera's image, pixels: large enough for a subpixel centroid.
const RADIUS_PX: f64 = 2.5;
/// Range of radii in the projector's image, pixels.
const RADII_PX: std::ops::RangeInclusive<f64> = 2.0..=40.0;
/// Width of lit surface required around a spot, camera pixels.
const LIT_PX: usize = 6;
/// Minimum light share of a detected spot.
const DETECTED_SHARE: f64 = 0.3;
/// Light share that is subtracted for the centroid.
const FAINT_SHARE: f32 = 0.12;
/// Radius of the centroid's window, camera pixels.
const WINDOW_PX: f64 = 7.0;

/// Spot to project onto the surface.
#[derive(Debug, Clone, Copy)]
pub(super) struct Spot {
    /// Centre, a whole projector pixel.
    pub(super) pixel: Point2<f64>,
    radius_px: f64,
    pub(super) patch: Patch,
    /// Expected centre in the camera's image, pixels.
    pub(super) expected: Point2<f64>,
}

/// Chooses spots spread over the lit surface, away from depth edges.
pub(super) fn choose(
    surface: &DepthSurface,
    projector: &PosedProjector,
    shadow: &ShadowMap,
    light: &LightMap,
) -> Vec<Spot> {
    let [width, height] = surface.size();
    let rows: Vec<usize> = (0..height).step_by(LATTICE_PX).collect();
    let candidates: Vec<Vec<Spot>> = rows
        .into_par_iter()
        .map(|y| {
            let lit = (0..width).step_by(LATTICE_PX).filter(|x| light.is_lit_around(*x, y, LIT_PX));
            lit.filter_map(|x| Spot::at(surface.patch(x, y)?, surface, projector, shadow)).collect()
        })
        .collect();
    spread(&candidates.concat())
}

impl Spot {
    /// Spot in the centre of a patch; `None` where the projector cannot show it.
    fn at(patch: Patch, surface: &DepthSurface, projector: &PosedProjector, shadow: &ShadowMap) -> Option<Self> {
        let camera = &surface.camera;
        let pixel = projector.pixel_of(&patch, camera, patch.middle)?.map(f64::round);
        let expected = projector.seen_at(&patch, camera, pixel)?;
        let by_camera_px = projector.by_camera_px(&patch, camera, expected)?;
        let radius_px = RADIUS_PX * by_camera_px.determinant().sqrt();
        let margin = Vector2::repeat(radius_px + 1.0);
        let is_whole = projector.lens.contains(pixel - margin) && projector.lens.contains(pixel + margin);
        let depth_m = (projector.from_camera * patch.point(camera, expected)?).z;
        (RADII_PX.contains(&radius_px) && is_whole && shadow.is_reached(pixel, depth_m)).then_some(Self {
            pixel,
            radius_px,
            patch,
            expected,
        })
    }
}

/// Farthest-point sampling, starting near the mean.
fn spread(candidates: &[Spot]) -> Vec<Spot> {
    let count = candidates.len().max(1) as f64;
    let mean = candidates.iter().map(|spot| spot.expected.coords).sum::<Vector2<f64>>() / count;
    let mut apart: Vec<f64> = candidates.iter().map(|spot| -(spot.expected.coords - mean).norm()).collect();
    let mut chosen: Vec<Spot> = Vec::new();
    while chosen.len() < MOST {
        let Some(farthest) = (0..apart.len()).max_by(|a, b| apart[*a].total_cmp(&apart[*b])) else { break };
        if !chosen.is_empty() && apart[farthest] < LEAST_APART_PX {
            break;
        }
        let spot = candidates[farthest];
        for (apart, candidate) in apart.iter_mut().zip(candidates) {
            let distance = (candidate.expected - spot.expected).norm();
            *apart = if chosen.is_empty() { distance } else { apart.min(distance) };
        }
        chosen.push(spot);
    }
    chosen
}

/// Number of rows and columns of the square table for a number of spots.
fn side(spots: usize) -> usize {
    (1..).find(|side| side * side >= spots).unwrap_or_default()
}

/// Images that identify spots: those of the rows, then those of the columns.
pub(super) fn pictures(spots: &[Spot], size_px: [u32; 2]) -> Vec<Drawing> {
    let side = side(spots.len());
    let mut pictures = vec![Drawing::black(size_px); 2 * side];
    for (index, spot) in spots.iter().enumerate() {
        for picture in [index / side, side + index % side] {
            pictures[picture].disc(spot.pixel, spot.radius_px);
        }
    }
    pictures
}

/// Detects each spot in the camera's images of [`pictures`], pixels.
pub(super) fn find(spots: &[Spot], images: &[Shares]) -> Vec<Option<Point2<f64>>> {
    let side = side(spots.len());
    let of_spot = |index: usize| {
        let (row, column) = (images.get(index / side)?, images.get(side + index % side)?);
        centroid(&row.common(column))
    };
    (0..spots.len()).into_par_iter().map(of_spot).collect()
}

/// Centroid of the brightest light.
fn centroid(shares: &Shares) -> Option<Point2<f64>> {
    let mut at = brightest(shares)?;
    // The window follows the centroid, twice.
    for _ in 0..3 {
        let [columns, rows] = [(at.x, shares.width), (at.y, shares.height())].map(|(at, size)| {
            let end = (at + WINDOW_PX).floor() as usize + 1;
            (at - WINDOW_PX).ceil().max(0.0) as usize..end.min(size)
        });
        let (mut sum, mut weight) = (Vector2::zeros(), 0.0);
        for y in rows {
            for x in columns.clone() {
                let place = Vector2::new(x as f64, y as f64);
                let share = f64::from((shares.shares[y * shares.width + x] - FAINT_SHARE).clamp(0.0, 1.0));
                if share > 0.0 && (place - at.coords).norm() <= WINDOW_PX {
                    sum += share * place;
                    weight += share;
                }
            }
        }
        if weight <= 0.0 {
            return None;
        }
        at = Point2::from(sum / weight);
    }
    Some(at)
}

/// Pixel with the brightest neighbourhood, if it is bright enough for a spot.
fn brightest(shares: &Shares) -> Option<Point2<f64>> {
    let (width, height) = (shares.width, shares.height());
    let mut best = (DETECTED_SHARE as f32, None);
    for y in 1..height.saturating_sub(1) {
        for x in 1..width.saturating_sub(1) {
            let own = shares.shares[y * width + x];
            if own < FAINT_SHARE {
                continue;
            }
            let rows = [y - 1, y, y + 1].map(|row| &shares.shares[row * width + x - 1..=row * width + x + 1]);
            let mean = rows.iter().map(|row| row.iter().map(|share| share.min(1.5)).sum::<f32>()).sum::<f32>() / 9.0;
            if mean > best.0 {
                best = (mean, Some(Point2::new(x as f64, y as f64)));
            }
        }
    }
    best.1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_has_a_place_for_every_spot() {
        assert_eq!([0, 1, 2, 4, 5, 49, 50, 64].map(side), [1, 1, 2, 2, 3, 7, 8, 8]);
    }

    #[test]
    fn the_middle_of_light_has_fractions_and_noise_is_none() {
        let place = Point2::new(33.3, 20.8);
        let share = |index: usize| {
            let off = Point2::new((index % 60) as f64, (index / 60) as f64) - place;
            let noise = if index.is_multiple_of(7) { 0.03 } else { -0.01 };
            (-0.5 * off.norm_squared() / 4.0).exp() as f32 + noise
        };
        let shares = Shares { width: 60, shares: (0..60 * 40).map(share).collect() };
        let found = centroid(&shares).unwrap();
        assert!((found - place).norm() < 0.03, "{found}");
        let dark = Shares { width: 60, shares: shares.shares.iter().map(|share| 0.2 * share).collect() };
        assert_eq!(centroid(&dark), None);
        assert_eq!(centroid(&Shares { width: 0, shares: Vec::new() }), None);
    }
}
