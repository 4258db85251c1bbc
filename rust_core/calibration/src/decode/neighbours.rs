//! Prediction of pixels from neighbours: projector coordinates are nearly linear on a surface.
//!
//! A plane is fitted to the coordinates of each window of 5×5 pixels, twice, with less weight for outliers of the first
//! fit. A pixel's prediction is the best fitting plane of the windows around and beside it, so that edges between
//! surfaces stay sharp. The planes' bias on curved surfaces is corrected.

use rayon::prelude::*;

use crate::plane::{means_around, robust_weight, Plane, PlaneSums};
use crate::statistics::median_f32;

/// Half the width of a window, pixels.
const RADIUS: usize = 2;
/// Half the width of the windows that the planes' bias is averaged over.
const BIAS_RADIUS: usize = 4;
/// Minimum weight of a window, in pixels of full weight.
const LEAST_SUPPORT: f32 = 5.0;
/// Residuals at which weights are halved in the first and the second fit, projector pixels.
const FIRST_WIDTH_PX: f32 = 12.0;
const SECOND_WIDTH_PX: f32 = 1.5;
/// Maximum residual of a pixel for the bias, standard deviations.
const OUTLIER: f32 = 3.0;
/// Error of a plane on a curved surface, projector pixels.
const CURVATURE_PX: f32 = 0.035;

/// Coordinates of all pixels along one axis.
pub(super) struct Field {
    pub(super) width: usize,
    /// Projector coordinates, pixels.
    pub(super) at: Vec<f32>,
    /// Standard deviations; infinite where unknown.
    pub(super) sigma: Vec<f32>,
}

/// Prediction of a pixel by a plane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PlanePrediction {
    /// Coordinate, projector pixels.
    pub(super) at: f32,
    pub(super) sigma: f32,
    /// RMS residual of the window.
    pub(super) spread: f32,
    /// `true` if the window is centred on the pixel.
    is_around: bool,
}

impl Field {
    /// Predicts each pixel; `None` where there are too few neighbours.
    pub(super) fn predictions(&self) -> Vec<Option<PlanePrediction>> {
        let mut predictions = self.predicted_by_planes();
        let residuals: Vec<f32> = (0..self.at.len())
            .map(|pixel| predictions[pixel].map_or(f32::NAN, |prediction| self.residual(pixel, &prediction)))
            .collect();
        let bias = means_around(&residuals, self.width, BIAS_RADIUS);
        for (prediction, bias) in predictions.iter_mut().zip(&bias) {
            if let Some(prediction) = prediction.as_mut().filter(|prediction| prediction.is_around) {
                prediction.at += bias;
            }
        }
        predictions
    }

    /// Residual of a pixel in the window around it; NaN for outliers and other windows.
    fn residual(&self, pixel: usize, prediction: &PlanePrediction) -> f32 {
        let off = self.at[pixel] - prediction.at;
        let is_near = off.abs() <= OUTLIER * self.sigma[pixel].hypot(prediction.sigma);
        if prediction.is_around && self.sigma[pixel].is_finite() && is_near {
            off
        } else {
            f32::NAN
        }
    }

    fn predicted_by_planes(&self) -> Vec<Option<PlanePrediction>> {
        let planes = self.planes();
        let height = self.at.len() / self.width;
        let offsets = [-2_i32, 0, 2];
        let mut predictions = vec![None; self.at.len()];
        predictions.par_chunks_mut(self.width).enumerate().for_each(|(y, row)| {
            for (x, prediction) in row.iter_mut().enumerate() {
                let mut best = (f32::INFINITY, Plane::NONE, 0.0, 0.0);
                for oy in offsets {
                    for ox in offsets {
                        let (px, py) = (x as i32 + ox, y as i32 + oy);
                        if px < 0 || py < 0 || px as usize >= self.width || py as usize >= height {
                            continue;
                        }
                        let plane = planes[py as usize * self.width + px as usize];
                        // The window around the pixel is preferred.
                        let beside = if ox == 0 && oy == 0 { 0.5 } else { 1.0 };
                        let badness = beside * (plane.variance + CURVATURE_PX * CURVATURE_PX) / plane.support.max(0.1);
                        if plane.support > 0.0 && badness < best.0 {
                            best = (badness, plane, -ox as f32, -oy as f32);
                        }
                    }
                }
                let (badness, plane, dx, dy) = best;
                if badness.is_finite() {
                    let distance = 1.0 + 0.25 * (dx * dx + dy * dy);
                    let variance = plane.variance * 3.0 / plane.support * distance + CURVATURE_PX * CURVATURE_PX;
                    *prediction = Some(PlanePrediction {
                        at: plane.at + plane.by_x * dx + plane.by_y * dy,
                        sigma: variance.sqrt(),
                        spread: plane.variance.sqrt(),
                        is_around: dx == 0.0 && dy == 0.0,
                    });
                }
            }
        });
        predictions
    }

    fn planes(&self) -> Vec<Plane> {
        let height = self.at.len() / self.width;
        let mut planes = vec![Plane::NONE; self.at.len()];
        planes.par_chunks_mut(self.width).enumerate().for_each(|(y, row)| {
            let rows = y.saturating_sub(RADIUS)..(y + RADIUS + 1).min(height);
            for (x, plane) in row.iter_mut().enumerate() {
                let columns = x.saturating_sub(RADIUS)..(x + RADIUS + 1).min(self.width);
                if let Some(fitted) = self.fit(x, y, rows.clone(), columns) {
                    *plane = fitted;
                }
            }
        });
        planes
    }

    fn fit(&self, x: usize, y: usize, rows: std::ops::Range<usize>, columns: std::ops::Range<usize>) -> Option<Plane> {
        let mut window = [(0.0_f32, [0.0_f32; 3]); (2 * RADIUS + 1) * (2 * RADIUS + 1)];
        let mut count = 0;
        let mut origin = f32::NAN;
        for row in rows {
            for column in columns.clone() {
                let index = row * self.width + column;
                let sigma = self.sigma[index];
                if sigma.is_finite() {
                    if origin.is_nan() {
                        origin = self.at[index];
                    }
                    let (dx, dy) = (column as f32 - x as f32, row as f32 - y as f32);
                    window[count] = (robust_weight(1.0, 2.0 * sigma), [dx, dy, self.at[index] - origin]);
                    count += 1;
                }
            }
        }
        if (count as f32) < LEAST_SUPPORT {
            return None;
        }
        let window = &window[..count];
        // Pixels near the central median are likely on the same surface.
        let mut heights = [0.0_f32; 9];
        let central = window.iter().filter(|(_, [dx, dy, _])| dx.abs() <= 1.0 && dy.abs() <= 1.0);
        let near = heights.iter_mut().zip(central).map(|(height, (_, [.., a]))| *height = *a).count();
        if near == 0 {
            return None;
        }
        let middle = median_f32(&mut heights[..near]);
        let fit = |residual: &dyn Fn(&[f32; 3]) -> f32, width_px: f32| {
            let weighted = window.iter().map(|(weight, at)| (robust_weight(*weight, residual(at) / width_px), *at));
            weighted.collect::<PlaneSums>().plane(LEAST_SUPPORT)
        };
        let first = fit(&|at| at[2] - middle, FIRST_WIDTH_PX)?;
        let plane = fit(&|at| first.residual(at), SECOND_WIDTH_PX)?;
        Some(Plane { at: plane.at + origin, ..plane })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curved_surfaces_are_predicted_without_a_shift() {
        const SIDE: usize = 30;
        let at = |index: usize| {
            let (x, y) = ((index % SIDE) as f32 - 15.0, (index / SIDE) as f32 - 15.0);
            300.0 + 2.0 * x + 0.5 * y + 0.006 * (x * x + y * y)
        };
        let at: Vec<f32> = (0..SIDE * SIDE).map(at).collect();
        let field = Field { width: SIDE, sigma: vec![0.05; at.len()], at };
        let middle = 15 * SIDE + 15;
        let [planes, predictions] = [field.predicted_by_planes(), field.predictions()];
        let off = |predictions: &[Option<PlanePrediction>]| predictions[middle].unwrap().at - field.at[middle];
        assert!(off(&planes) > 0.02 && off(&predictions).abs() < 0.001, "{} {}", off(&planes), off(&predictions));
    }
}
