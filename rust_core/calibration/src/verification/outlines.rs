//! Outlines along the edges of the depth image, slightly inside on the nearer surface.
//!
//! Depth is uncertain at an edge, but not a few pixels inside. The outline is drawn there, and the offset of its light
//! across the line is measured in many places; the offset along the line is not observable.

use std::collections::VecDeque;

use nalgebra::{Matrix2, Point2, SymmetricEigen, Vector2};

use super::drawing::Drawing;
use super::light_map::{LightMap, Shares};
use super::surface::{DepthSurface, Patch, PosedProjector, ShadowMap};

/// Minimum depth step of an edge, as a share of the depth.
const JUMP: f64 = 0.04;
/// Maximum width of an edge, pixels; pixels between may have no depth.
const ACROSS_PX: usize = 5;
/// Distance of the outline from the edge, camera pixels.
const INSET_PX: std::ops::Range<f64> = 4.5..5.6;
/// Maximum relative depth difference between edge and outline on one surface.
const SAME: f64 = 0.025;
/// Width of lit surface required around the outline, camera pixels.
const LIT_PX: usize = 2;
/// Half the outline's width in the camera's image, pixels.
const HALF_WIDTH_PX: f64 = 1.0;
/// Maximum number of outlines and minimum length, pixels: the longest are drawn.
const MOST_OUTLINES: usize = 16;
const LEAST_PIXELS: usize = 18;
/// Distance of targets on an outline, and half the length over which it must be straight, camera pixels.
const APART_PX: f64 = 12.0;
const STRAIGHT_PX: f64 = 6.0;
const LEAST_STRAIGHT: usize = 8;
/// Maximum standard deviation across of a straight outline's pixels.
const MOST_ACROSS_PX: f64 = 0.75;
/// Search range across the outline, camera pixels; other outlines are at least twice as far away.
const BESIDE_PX: f64 = 7.0;
/// Minimum light share of a detected outline.
const DETECTED_SHARE: f64 = 0.25;

#[derive(Debug, Clone, Copy)]
struct OutlinePixel {
    patch: Patch,
    /// Projector pixel that should light it.
    pixel: Point2<f64>,
    /// Half the line's width, projector pixels.
    radius_px: f64,
    /// Index of its outline.
    outline: usize,
}

/// Outlines of the camera's image.
#[derive(Debug, Clone)]
pub(super) struct Outlines {
    width: usize,
    /// Outline pixels by camera pixel.
    pixels: Vec<Option<OutlinePixel>>,
    /// Targets.
    pub(super) places: Vec<OutlinePlace>,
}

/// Target: a straight piece of an outline.
#[derive(Debug, Clone, Copy)]
pub(super) struct OutlinePlace {
    pub(super) patch: Patch,
    /// Expected centre in the camera's image, pixels.
    pub(super) expected: Point2<f64>,
    /// Unit normal of the line in the camera's image.
    across: Vector2<f64>,
}

impl Outlines {
    pub(super) fn new(
        surface: &DepthSurface,
        projector: &PosedProjector,
        shadow: &ShadowMap,
        light: &LightMap,
    ) -> Self {
        let [width, height] = surface.size();
        let nearest = nearest_edges(surface);
        let mut pixels = vec![None; width * height];
        for (index, pixel) in pixels.iter_mut().enumerate() {
            let (x, y) = (index % width, index / width);
            let Some([edge_x, edge_y]) = nearest[index] else { continue };
            let distance = (edge_x as f64 - x as f64).hypot(edge_y as f64 - y as f64);
            let depths = surface.depth_m(index).zip(surface.depth_m(edge_y * width + edge_x));
            let is_same = depths.is_some_and(|(own, edge)| (own - edge).abs() < SAME * edge);
            if INSET_PX.contains(&distance) && is_same && light.is_lit_around(x, y, LIT_PX) {
                *pixel = surface.patch(x, y).and_then(|patch| OutlinePixel::new(patch, surface, projector, shadow));
            }
        }
        keep_longest(&mut pixels, width);
        let places = places(&pixels, width);
        Self { width, pixels, places }
    }

    pub(super) fn image(&self, size_px: [u32; 2]) -> Drawing {
        let mut drawing = Drawing::black(size_px);
        for (index, own) in self.pixels.iter().enumerate() {
            let Some(own) = own else { continue };
            drawing.disc(own.pixel, own.radius_px);
            for other in neighbours(index, self.width, self.pixels.len()).filter(|other| *other > index) {
                if let Some(other) = self.pixels[other] {
                    drawing.line(own.pixel, other.pixel, own.radius_px);
                }
            }
        }
        drawing
    }
}

impl OutlinePixel {
    fn new(patch: Patch, surface: &DepthSurface, projector: &PosedProjector, shadow: &ShadowMap) -> Option<Self> {
        let camera = &surface.camera;
        let point = patch.point(camera, patch.middle)?;
        let pixel = projector.pixel(&point).filter(|pixel| projector.lens.contains(*pixel))?;
        let by_camera_px = projector.by_camera_px(&patch, camera, patch.middle)?;
        let radius_px = (HALF_WIDTH_PX * by_camera_px.determinant().sqrt()).max(1.0);
        let depth_m = (projector.from_camera * point).z;
        shadow.is_reached(pixel, depth_m).then_some(Self { patch, pixel, radius_px, outline: 0 })
    }
}

impl OutlinePlace {
    /// Camera pixel at which the outline's light is detected, searching around an expected shift.
    pub(super) fn find(&self, image: &Shares, shift: Vector2<f64>) -> Option<Point2<f64>> {
        let along = Vector2::new(-self.across.y, self.across.x);
        let profile = |beside: f64| {
            let shares = (-4..=4).map(|step| {
                let place = self.expected + shift + self.across * beside + along * f64::from(step);
                image.at(place).map(|share| share.clamp(0.0, 1.5))
            });
            shares.sum::<Option<f64>>().map(|sum| sum / 9.0)
        };
        let steps = (2.0 * BESIDE_PX) as i32;
        let places: Vec<(f64, f64)> = (-steps..=steps)
            .map(|step| profile(0.5 * f64::from(step)).map(|share| (0.5 * f64::from(step), share)))
            .collect::<Option<_>>()?;
        let (peak, most) = places.iter().copied().max_by(|a, b| a.1.total_cmp(&b.1))?;
        if most < DETECTED_SHARE || peak.abs() + 2.0 > BESIDE_PX {
            return None;
        }
        // Centroid of light above a third of the peak, within the line's width.
        let near = places.iter().filter(|(beside, _)| (beside - peak).abs() <= 3.0);
        let weighed = near.map(|(beside, share)| (beside, (share - most / 3.0).max(0.0)));
        let (sum, weight) =
            weighed.fold((0.0, 0.0), |(sum, total), (beside, weight)| (sum + beside * weight, total + weight));
        (weight > 0.0).then(|| self.expected + self.across * (shift.dot(&self.across) + sum / weight))
    }
}

/// Approximately nearest pixel on the near side of an edge, for each pixel: two passes of a distance transform
/// (Danielsson, "Euclidean distance mapping", 1980).
fn nearest_edges(surface: &DepthSurface) -> Vec<Option<[usize; 2]>> {
    let [width, height] = surface.size();
    let mut nearest: Vec<Option<[usize; 2]>> =
        (0..width * height).map(|index| is_edge(surface, index).then_some([index % width, index / width])).collect();
    let squared = |at: usize, edge: [usize; 2]| {
        let (x, y) = (at % width, at / width);
        edge[0].abs_diff(x).pow(2) + edge[1].abs_diff(y).pow(2)
    };
    let mut pass = |order: &mut dyn Iterator<Item = usize>| {
        for index in order {
            for other in neighbours(index, width, width * height) {
                if let Some(edge) = nearest[other] {
                    if nearest[index].is_none_or(|own| squared(index, edge) < squared(index, own)) {
                        nearest[index] = Some(edge);
                    }
                }
            }
        }
    };
    pass(&mut (0..width * height));
    pass(&mut (0..width * height).rev());
    nearest
}

/// `true` if a pixel beside this one is much farther away.
fn is_edge(surface: &DepthSurface, index: usize) -> bool {
    let [width, height] = surface.size();
    let (x, y) = ((index % width) as i64, (index / width) as i64);
    let Some(own) = surface.depth_m(index) else { return false };
    [[1, 0], [-1, 0], [0, 1], [0, -1]].iter().any(|[right, down]| {
        let beside = (1..=ACROSS_PX as i64).find_map(|step| {
            let (x, y) = (x + step * right, y + step * down);
            let is_inside = x >= 0 && y >= 0 && x < width as i64 && y < height as i64;
            is_inside.then(|| surface.depth_m(y as usize * width + x as usize))?
        });
        beside.is_some_and(|depth| depth > (1.0 + JUMP) * own)
    })
}

/// Up to eight neighbours of a pixel.
fn neighbours(index: usize, width: usize, count: usize) -> impl Iterator<Item = usize> {
    let (x, y) = (index % width, index / width);
    let rows = y.saturating_sub(1)..=(y + 1).min((count / width).saturating_sub(1));
    rows.flat_map(move |row| (x.saturating_sub(1)..=(x + 1).min(width - 1)).map(move |column| row * width + column))
        .filter(move |other| *other != index)
}

/// Labels connected outlines and drops all but the longest.
fn keep_longest(pixels: &mut [Option<OutlinePixel>], width: usize) {
    let mut is_visited = vec![false; pixels.len()];
    let mut outlines: Vec<Vec<usize>> = Vec::new();
    for start in 0..pixels.len() {
        if pixels[start].is_none() || is_visited[start] {
            continue;
        }
        is_visited[start] = true;
        let (mut outline, mut queue) = (Vec::new(), VecDeque::from([start]));
        while let Some(index) = queue.pop_front() {
            outline.push(index);
            for other in neighbours(index, width, pixels.len()) {
                if pixels[other].is_some() && !is_visited[other] {
                    is_visited[other] = true;
                    queue.push_back(other);
                }
            }
        }
        outlines.push(outline);
    }
    outlines.sort_by_key(|outline| std::cmp::Reverse(outline.len()));
    for (number, outline) in outlines.iter().enumerate() {
        let is_kept = number < MOST_OUTLINES && outline.len() >= LEAST_PIXELS;
        for index in outline {
            pixels[*index] = pixels[*index].filter(|_| is_kept).map(|pixel| OutlinePixel { outline: number, ..pixel });
        }
    }
}

/// Targets on straight pieces, apart from each other.
fn places(pixels: &[Option<OutlinePixel>], width: usize) -> Vec<OutlinePlace> {
    let mut places: Vec<OutlinePlace> = Vec::new();
    for pixel in pixels.iter().flatten() {
        let is_apart = places.iter().all(|place| (place.expected - pixel.patch.middle).norm() >= APART_PX);
        if is_apart {
            places.extend(place(pixel, pixels, width));
        }
    }
    places
}

/// Target around a pixel, if the outline is straight there and no other one is near.
fn place(pixel: &OutlinePixel, pixels: &[Option<OutlinePixel>], width: usize) -> Option<OutlinePlace> {
    let reach = 2.0 * BESIDE_PX;
    let (x, y) = (pixel.patch.middle.x, pixel.patch.middle.y);
    let range = |at: f64, size: usize| ((at - reach).max(0.0) as usize)..((at + reach) as usize + 1).min(size);
    let height = pixels.len() / width;
    let columns = range(x, width);
    let around: Vec<&OutlinePixel> = range(y, height)
        .flat_map(|row| pixels[row * width + columns.start..row * width + columns.end].iter().flatten())
        .collect();
    let is_near = |other: &&&OutlinePixel| (other.patch.middle - pixel.patch.middle).norm() <= STRAIGHT_PX;
    let own: Vec<Point2<f64>> = around.iter().filter(is_near).map(|other| other.patch.middle).collect();
    if own.len() < LEAST_STRAIGHT {
        return None;
    }
    let expected = Point2::from(own.iter().map(|place| place.coords).sum::<Vector2<f64>>() / own.len() as f64);
    let spread: Matrix2<f64> =
        own.iter().map(|place| (place - expected) * (place - expected).transpose()).sum::<Matrix2<f64>>()
            / own.len() as f64;
    let spread = SymmetricEigen::new(spread);
    let least = spread.eigenvalues.imin();
    let across: Vector2<f64> = spread.eigenvectors.column(least).into_owned();
    // In the middle of a straight piece.
    let is_straight =
        spread.eigenvalues[least].sqrt() <= MOST_ACROSS_PX && (expected - pixel.patch.middle).norm() < 1.5;
    // Only the outline itself lies across.
    let is_alone = around.iter().all(|other| {
        let off = other.patch.middle - expected;
        let along = off.perp(&across).abs();
        along > 5.0 || off.dot(&across).abs() < 3.0 && other.outline == pixel.outline
    });
    (is_straight && is_alone).then_some(OutlinePlace { patch: pixel.patch, expected, across })
}
