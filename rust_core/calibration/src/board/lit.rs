//! The projector's pixel of each corner, by a homography from the camera's to the projector's pixels around it (Moreno
//! and Taubin, 2012): the board is flat, and over a square neither lens bends it.

use nalgebra::{Point2, SMatrix, SVector, Vector2};

use super::{BoardCorner, LitPixel};
use crate::statistics::median;
use crate::Decoded;

/// Radius of the decoded pixels around a corner as a share of the distance to its nearest neighbour.
const RADIUS_SHARE: f64 = 0.9;
/// Bounds of the radius, pixels.
const RADIUS_PX: [f64; 2] = [5.0, 60.0];
/// Minimum number of decoded pixels.
const LEAST_PIXELS: usize = 24;
/// Maximum distance of their middle from the corner, in radii: they must lie all around it.
const MOST_OFF: f64 = 0.25;
/// Rounds of reweighting.
const ROUNDS: usize = 4;
/// Residual at which a pixel's weight is halved, in median residuals.
const HALF_WEIGHT: f64 = 3.0;
/// Number of decoded pixels that share an error: decoding smooths.
const CORRELATED: f64 = 20.0;
/// Lower bound of a corner's deviation, projector pixels.
const LEAST_SIGMA_PX: f64 = 0.03;

/// Finds the projector pixels of corners; those that too few decoded pixels surround get none.
pub fn lit_corners(corners: &[BoardCorner], decoded: &Decoded) -> Vec<BoardCorner> {
    let lit = |corner: &BoardCorner| {
        let others = corners.iter().filter(|other| other.place != corner.place);
        let nearest_px = others.map(|other| (other.pixel - corner.pixel).norm()).fold(f64::INFINITY, f64::min);
        let radius_px = (RADIUS_SHARE * nearest_px).clamp(RADIUS_PX[0], RADIUS_PX[1]);
        BoardCorner { lit_by: lit_pixel(corner.pixel, radius_px, decoded), ..*corner }
    };
    corners.iter().map(lit).collect()
}

/// A decoded pixel near a corner: its place in radii from the corner, the projector's pixel and weight.
struct Near {
    off: Vector2<f64>,
    lit_by: Point2<f64>,
    weight: f64,
}

fn lit_pixel(corner: Point2<f64>, radius_px: f64, decoded: &Decoded) -> Option<LitPixel> {
    let near = near(corner, radius_px, decoded);
    let middle = near.iter().map(|near| near.off).sum::<Vector2<f64>>() / near.len().max(1) as f64;
    if near.len() < LEAST_PIXELS || middle.norm() > MOST_OFF {
        return None;
    }
    let mut weights: Vec<f64> = near.iter().map(|near| near.weight).collect();
    let mut found = None;
    for _ in 0..ROUNDS {
        let fit = Fit::new(&near, &weights)?;
        let residuals: Vec<f64> = near.iter().map(|near| (near.lit_by - fit.at(near.off)).norm()).collect();
        let typical_px = median(&mut residuals.clone()).max(1e-6);
        let factor = |residual: &f64| 1.0 / (1.0 + (residual / (HALF_WEIGHT * typical_px)).powi(2));
        weights = near.iter().zip(&residuals).map(|(near, residual)| near.weight * factor(residual)).collect();
        let independent = (near.len() as f64 / CORRELATED).max(1.0);
        let sigma_px = (typical_px * (8.0 / independent).sqrt() / std::f64::consts::SQRT_2).max(LEAST_SIGMA_PX);
        found = Some(LitPixel { pixel: fit.at(Vector2::zeros()), sigma_px });
    }
    found
}

/// Decoded pixels within a radius around a corner.
fn near(corner: Point2<f64>, radius_px: f64, decoded: &Decoded) -> Vec<Near> {
    let [width, height] = decoded.size_px.map(i64::from);
    let range = |middle: f64, size: i64| {
        let [first, last] = [middle - radius_px, middle + radius_px].map(|bound| bound.round() as i64);
        first.max(0)..(last + 1).min(size)
    };
    let places = range(corner.y, height).flat_map(|y| range(corner.x, width).map(move |x| [x, y]));
    let near = places.filter_map(|[x, y]| {
        let off = (Point2::new(x as f64, y as f64) - corner) / radius_px;
        let pixel = decoded.pixels.get((y * width + x) as usize)?;
        let sigma = f64::from(pixel.sigma[0].hypot(pixel.sigma[1]));
        let is_near = off.norm_squared() <= 1.0 && pixel.is_decoded();
        is_near.then(|| Near {
            off,
            lit_by: Point2::from(pixel.at.map(f64::from)),
            weight: 1.0 / (0.01 + sigma * sigma),
        })
    });
    near.collect()
}

/// Homography (a + b x + c y) / (1 + g x + h y) for u, and with d, e, f for v.
struct Fit(SVector<f64, 8>);

impl Fit {
    /// Fits by weighted least squares, linear once both sides are multiplied by the denominator.
    fn new(near: &[Near], weights: &[f64]) -> Option<Self> {
        let (mut normal, mut right) = (SMatrix::<f64, 8, 8>::zeros(), SVector::<f64, 8>::zeros());
        // Relative to the mean, so that the denominator multiplies small numbers.
        let mean = near.iter().map(|near| near.lit_by.coords).sum::<Vector2<f64>>() / near.len() as f64;
        for (Near { off, lit_by, .. }, weight) in near.iter().zip(weights) {
            for axis in 0..2 {
                let value = lit_by[axis] - mean[axis];
                let mut row = SVector::<f64, 8>::zeros();
                row.fixed_rows_mut::<3>(3 * axis).copy_from(&off.insert_row(0, 1.0));
                row[6] = -value * off.x;
                row[7] = -value * off.y;
                normal += row * row.transpose() * *weight;
                right += row * (value * weight);
            }
        }
        let mut entries = normal.cholesky()?.solve(&right);
        // The mean again: (m (1 + g x + h y) + a + b x + c y) / (1 + g x + h y).
        let (g, h) = (entries[6], entries[7]);
        for axis in 0..2 {
            for (column, factor) in [1.0, g, h].into_iter().enumerate() {
                entries[3 * axis + column] += mean[axis] * factor;
            }
        }
        entries.iter().all(|entry| entry.is_finite()).then_some(Self(entries))
    }

    fn at(&self, off: Vector2<f64>) -> Point2<f64> {
        let entries = &self.0;
        let denominator = 1.0 + entries[6] * off.x + entries[7] * off.y;
        Point2::from([0, 3].map(|i| (entries[i] + entries[i + 1] * off.x + entries[i + 2] * off.y) / denominator))
    }
}
