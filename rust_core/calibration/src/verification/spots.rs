//! Spots of light: placement, identification, detection.
//!
//! Balanced code: each spot is lit in one half of the images and dark in the other, no two spots in the same half. So
//! the brighter half of a camera pixel's levels names the spot that lights it, however far that lands from its target
//! and whatever lies between, and no pixel needs a threshold. Eight images tell 70 spots apart.

use nalgebra::{Point2, Vector2};
use rayon::prelude::*;

use super::drawing::Drawing;
use super::light_map::{LightMap, Shares};
use super::surface::{DepthSurface, Patch, PosedProjector, ShadowMap};

/// Minimum number of spots for a result.
pub(super) const LEAST_SPOTS: usize = 8;
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
/// Images of the code for [`MOST`] spots.
const MOST_IMAGES: usize = 8;
/// Least gap between the two halves of a pixel's levels, as a share of the distance of their means.
const LEAST_GAP: f32 = 0.3;

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

/// Code words for a number of spots, a bit for each image, and the number of images.
fn code(spots: usize) -> (usize, Vec<u16>) {
    let words = |images: usize| {
        (0..1_u16 << images).filter(|word| word.count_ones() as usize == images / 2).collect::<Vec<_>>()
    };
    let images = [2, 4, 6].into_iter().find(|images| words(*images).len() >= spots).unwrap_or(MOST_IMAGES);
    let words = words(images);
    // Evenly drawn, so that all images are about equally bright.
    let word = |spot: usize| words[spot * words.len() / spots];
    (images, (0..spots.min(words.len())).map(word).collect())
}

/// Images that identify spots.
pub(super) fn images(spots: &[Spot], size_px: [u32; 2]) -> Vec<Drawing> {
    let (images, words) = code(spots.len());
    let mut images = vec![Drawing::black(size_px); images];
    for (spot, word) in spots.iter().zip(words) {
        for (_, image) in images.iter_mut().enumerate().filter(|(image, _)| word >> image & 1 == 1) {
            image.disc(spot.pixel, spot.radius_px);
        }
    }
    images
}

/// Light of a spot in the camera's images.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct SpotLight {
    /// Centroid in all images together, pixels.
    pub(super) at: Point2<f64>,
    /// Images in which the spot is lit, with the centroid in each.
    pub(super) in_images: Vec<(usize, Point2<f64>)>,
}

/// Detects each spot in the camera's images of [`images`].
pub(super) fn find(spots: &[Spot], images: &[Shares]) -> Vec<Option<SpotLight>> {
    let (count, words) = code(spots.len());
    let Some(first) = images.first().filter(|_| images.len() >= count) else { return vec![None; spots.len()] };
    let images = &images[..count];
    let coded: Vec<(u16, f32)> = (0..first.shares.len()).into_par_iter().map(|pixel| decoded(images, pixel)).collect();
    words.into_par_iter().map(|word| found(word, &coded, images)).collect()
}

/// Code word of a pixel and its contrast; no contrast where the light is not that of a spot.
fn decoded(images: &[Shares], pixel: usize) -> (u16, f32) {
    let mut levels = [(0.0, 0); MOST_IMAGES];
    let levels = &mut levels[..images.len()];
    for (image, level) in levels.iter_mut().enumerate() {
        *level = (images[image].shares[pixel], image);
    }
    levels.sort_unstable_by(|a, b| b.0.total_cmp(&a.0));
    let (lit, dark) = levels.split_at(images.len() / 2);
    let (Some(faintest), Some(brightest)) = (lit.last(), dark.first()) else { return (0, 0.0) };
    let mean = |half: &[(f32, usize)]| half.iter().map(|(share, _)| share).sum::<f32>() / half.len() as f32;
    let contrast = mean(lit) - mean(dark);
    if contrast < FAINT_SHARE || faintest.0 - brightest.0 < LEAST_GAP * contrast {
        return (0, 0.0);
    }
    (lit.iter().fold(0, |word, (_, image)| word | 1 << image), contrast)
}

/// Light of the spot with a code word.
fn found(word: u16, coded: &[(u16, f32)], images: &[Shares]) -> Option<SpotLight> {
    let width = images.first()?.width;
    let own = coded.iter().map(|(own, contrast)| if *own == word { *contrast } else { 0.0 });
    let start = brightest(&Shares { width, shares: own.collect() })?;
    let is_lit = |image: usize| word >> image & 1 == 1;
    let half = 0.5 * images.len() as f32;
    let share = |pixel: usize| {
        let signed = |(image, shares): (usize, &Shares)| if is_lit(image) { 1.0 } else { -1.0 } * shares.shares[pixel];
        images.iter().enumerate().map(signed).sum::<f32>() / half
    };
    let size = [width, images.first()?.height()];
    let at = centroid(start, size, share)?;
    let lit = (0..images.len()).filter(|image| is_lit(*image));
    let in_images = lit.map(|image| Some((image, centroid(at, size, |pixel| images[image].shares[pixel])?)));
    Some(SpotLight { at, in_images: in_images.collect::<Option<_>>()? })
}

/// Centroid of the light around a place, in an image of a size with a light share for each pixel.
fn centroid(start: Point2<f64>, size: [usize; 2], share: impl Fn(usize) -> f32) -> Option<Point2<f64>> {
    let mut at = start;
    // The window follows the centroid, twice.
    for _ in 0..3 {
        let [columns, rows] = [0, 1].map(|axis| {
            let end = (at[axis] + WINDOW_PX).floor() as usize + 1;
            (at[axis] - WINDOW_PX).ceil().max(0.0) as usize..end.min(size[axis])
        });
        let (mut sum, mut weight) = (Vector2::zeros(), 0.0);
        for y in rows {
            for x in columns.clone() {
                let place = Vector2::new(x as f64, y as f64);
                let share = f64::from((share(y * size[0] + x) - FAINT_SHARE).clamp(0.0, 1.0));
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
    fn each_spot_is_lit_in_half_of_the_images_and_no_two_in_the_same() {
        for (spots, expected) in [(1, 2), (2, 2), (6, 4), (7, 6), (20, 6), (21, 8), (MOST, 8)] {
            let (images, mut words) = code(spots);
            assert!(images == expected && words.iter().all(|word| word.count_ones() as usize == images / 2));
            let lit = |image: usize| words.iter().filter(|word| *word >> image & 1 == 1).count();
            assert!((0..images).all(|image| lit(image).abs_diff(spots / 2) <= 1 + spots / 6), "{spots}: {words:?}");
            words.sort_unstable();
            words.dedup();
            assert_eq!(words.len(), spots);
        }
    }

    /// Images of round spots with these words, each of one brightness.
    fn images(spots: &[(u16, Point2<f64>, f32)]) -> Vec<Shares> {
        let level = |image: usize, index: usize| {
            let light = |(word, place, brightness): &(u16, Point2<f64>, f32)| {
                let off = Point2::new((index % 60) as f64, (index / 60) as f64) - place;
                let is_lit = f32::from(*word >> image & 1);
                is_lit * brightness * (-0.5 * off.norm_squared() / 4.0).exp() as f32
            };
            let noise = if (index + image).is_multiple_of(7) { 0.03 } else { -0.01 };
            spots.iter().map(light).sum::<f32>() + noise
        };
        let image = |image: usize| Shares { width: 60, shares: (0..60 * 40).map(|at| level(image, at)).collect() };
        (0..MOST_IMAGES).map(image).collect()
    }

    #[test]
    fn spots_are_told_apart_wherever_they_land_and_noise_is_none() {
        let (near, far) = (Point2::new(33.3, 20.8), Point2::new(15.5, 12.25));
        let images = images(&[(0b1101_0010, near, 1.0), (0b0101_0011, far, 0.6), (0b1111_0000, near, 0.04)]);
        let coded: Vec<(u16, f32)> = (0..60 * 40).map(|pixel| decoded(&images, pixel)).collect();
        for (word, place) in [(0b1101_0010, near), (0b0101_0011, far)] {
            let light = found(word, &coded, &images).unwrap();
            assert!((light.at - place).norm() < 0.06, "{light:?}");
            assert_eq!(light.in_images.len(), 4);
            assert!(light.in_images.iter().all(|(image, at)| word >> image & 1 == 1 && (at - place).norm() < 0.15));
        }
        assert_eq!(found(0b1111_0000, &coded, &images), None, "too faint");
        assert_eq!(found(0b0000_1111, &coded, &images), None, "not shown");
    }
}
