//! Grey images, and candidates for a chessboard's corners by the ChESS response (Bennett and Lasenby, "ChESS: quick and
//! robust detection of chess-board features", 2014).

use nalgebra::{Point2, Vector2};
use rayon::prelude::*;

/// Offsets of a ring of 16 pixels with radius 5.
const RING: [[i32; 2]; 16] = [
    [0, -5],
    [2, -5],
    [3, -3],
    [5, -2],
    [5, 0],
    [5, 2],
    [3, 3],
    [2, 5],
    [0, 5],
    [-2, 5],
    [-3, 3],
    [-5, 2],
    [-5, 0],
    [-5, -2],
    [-3, -3],
    [-2, -5],
];
const RADIUS: usize = 6;
/// Width at which corners are looked for, pixels: larger images are reduced.
const WIDTH_PX: f64 = 1280.0;
/// Half the side of the neighbourhood in which a candidate is the largest, pixels.
const APART: usize = 3;
/// Minimum response as a share of the strongest ones.
const LEAST_RESPONSE: f32 = 0.08;
/// Maximum number of candidates.
const MOST: usize = 4000;

/// Grey image.
pub(super) struct Grey {
    pub(super) size_px: [usize; 2],
    pub(super) levels: Vec<f32>,
}

impl Grey {
    pub(super) fn new(levels: &[u8], size_px: [u32; 2]) -> Self {
        Self {
            size_px: size_px.map(|side| side as usize),
            levels: levels.iter().map(|level| f32::from(*level)).collect(),
        }
    }

    /// Level at a pixel between others, by bilinear interpolation; `None` outside of the image.
    pub(super) fn at(&self, place: Point2<f64>) -> Option<f64> {
        let [width, height] = self.size_px;
        let (left, top) = (place.x.floor(), place.y.floor());
        if !(left >= 0.0 && top >= 0.0 && left < width as f64 - 1.0 && top < height as f64 - 1.0) {
            return None;
        }
        let index = top as usize * width + left as usize;
        let (right, down) = (place.x - left, place.y - top);
        let level = |index: usize| f64::from(self.levels[index]);
        let upper = level(index) * (1.0 - right) + level(index + 1) * right;
        let lower = level(index + width) * (1.0 - right) + level(index + width + 1) * right;
        Some(upper * (1.0 - down) + lower * down)
    }

    /// Means of `factor` × `factor` pixels.
    fn reduced(&self, factor: usize) -> Self {
        let size_px = self.size_px.map(|side| side / factor);
        let [width, height] = size_px;
        let mean = |x: usize, y: usize| {
            let rows = y * factor..(y + 1) * factor;
            let row = |row: usize| &self.levels[row * self.size_px[0] + x * factor..][..factor];
            rows.flat_map(row).sum::<f32>() / (factor * factor) as f32
        };
        let levels = (0..width * height).into_par_iter().map(|index| mean(index % width, index / width)).collect();
        Self { size_px, levels }
    }

    /// Smoothed by the binomial filter 1 2 1 along both axes.
    fn smoothed(&self) -> Self {
        let [width, height] = self.size_px;
        let along = |levels: &[f32], step: usize, is_inner: &(dyn Fn(usize) -> bool + Sync)| -> Vec<f32> {
            let at = |i: usize| {
                if is_inner(i) {
                    0.25 * (levels[i - step] + 2.0 * levels[i] + levels[i + step])
                } else {
                    levels[i]
                }
            };
            (0..levels.len()).into_par_iter().map(at).collect()
        };
        let rows = along(&self.levels, 1, &|i| i % width > 0 && i % width + 1 < width);
        Self { size_px: self.size_px, levels: along(&rows, width, &|i| i >= width && i / width + 1 < height) }
    }

    /// Response of each pixel; positive at corners of chessboards.
    fn responses(&self) -> Vec<f32> {
        let [width, height] = self.size_px;
        let offsets = RING.map(|[x, y]| y as isize * width as isize + x as isize);
        let response = |index: usize| {
            let (x, y) = (index % width, index / width);
            if x < RADIUS || y < RADIUS || x + RADIUS >= width || y + RADIUS >= height {
                return 0.0;
            }
            let ring = offsets.map(|offset| self.levels[index.wrapping_add_signed(offset)]);
            let sums = (0..4).map(|i| (ring[i] + ring[i + 8] - ring[i + 4] - ring[i + 12]).abs()).sum::<f32>();
            let differences = (0..8).map(|i| (ring[i] - ring[i + 8]).abs()).sum::<f32>();
            let own = self.levels[index];
            let cross = own + self.levels[index - 1] + self.levels[index + 1];
            let local = (cross + self.levels[index - width] + self.levels[index + width]) / 5.0;
            let mean = ring.iter().sum::<f32>() / 16.0;
            (sums - differences - 16.0 * (local - mean).abs()).max(0.0)
        };
        (0..width * height).into_par_iter().map(response).collect()
    }
}

/// Candidates for corners, roughly, the strongest first.
pub(super) fn candidates(grey: &Grey) -> Vec<Point2<f64>> {
    let factor = ((grey.size_px[0].max(grey.size_px[1]) as f64 / WIDTH_PX).round() as usize).max(1);
    let reduced = if factor > 1 { grey.reduced(factor) } else { grey.smoothed() };
    let responses = reduced.responses();
    let [width, height] = reduced.size_px;
    if width <= 2 * RADIUS || height <= 2 * RADIUS {
        return Vec::new();
    }
    let is_largest = |index: usize| {
        let (x, y, own) = (index % width, index / width, responses[index]);
        own > 0.0
            && (y - APART..=y + APART).all(|row| {
                (x - APART..=x + APART).all(|column| {
                    let other = row * width + column;
                    responses[other] < own || (responses[other] == own && other >= index)
                })
            })
    };
    let rows = RADIUS..height - RADIUS;
    let mut found: Vec<usize> = rows
        .into_par_iter()
        .flat_map_iter(|y| (RADIUS..width - RADIUS).map(move |x| y * width + x))
        .filter(|index| is_largest(*index))
        .collect();
    found.sort_by(|a, b| responses[*b].total_cmp(&responses[*a]).then(a.cmp(b)));
    // Not of the single strongest one, which a reflection may be.
    let strong = found.get(found.len().min(24) / 2).map_or(0.0, |index| responses[*index]);
    found.retain(|index| responses[*index] > LEAST_RESPONSE * strong);
    found.truncate(MOST);
    let middle = Vector2::repeat(0.5 * (factor as f64 - 1.0));
    let place = |index: usize| Vector2::new((index % width) as f64, (index / width) as f64);
    found.into_iter().map(|index| Point2::from(place(index) * factor as f64 + middle)).collect()
}
