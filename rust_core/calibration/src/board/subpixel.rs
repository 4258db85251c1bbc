//! Corners to a fraction of a pixel: at a corner every gradient is perpendicular to the line to it, which gives linear
//! equations for its place (Förstner and Gülch, 1987; as in OpenCV's cornerSubPix).

use nalgebra::{Matrix2, Point2, Vector2};

use super::response::Grey;

/// Maximum number of steps, and the step at which the search ends, pixels.
const STEPS: usize = 20;
const LAST_STEP_PX: f64 = 2e-3;
/// Minimum ratio of the eigenvalues of the gradients' sums: less is an edge.
const LEAST_RATIO: f64 = 0.05;

/// Refines a corner by the gradients within `radius_px`; `None` where there is none near.
pub(super) fn refined(grey: &Grey, start: Point2<f64>, radius_px: f64) -> Option<Point2<f64>> {
    let half = radius_px.round().max(2.0) as i32;
    let side = (2 * half + 3) as usize;
    let mut place = start;
    let mut patch = vec![0.0; side * side];
    for _ in 0..STEPS {
        for (index, level) in patch.iter_mut().enumerate() {
            let off = Vector2::new((index % side) as f64, (index / side) as f64).add_scalar(-f64::from(half) - 1.0);
            *level = grey.at(place + off)?;
        }
        let (mut sums, mut right) = (Matrix2::zeros(), Vector2::zeros());
        for (row, column) in (1..side - 1).flat_map(|row| (1..side - 1).map(move |column| (row, column))) {
            let at = row * side + column;
            let gradient = Vector2::new(patch[at + 1] - patch[at - 1], patch[at + side] - patch[at - side]);
            let off = Vector2::new(column as f64, row as f64).add_scalar(-f64::from(half) - 1.0);
            let weight = (-off.norm_squared() / (0.6 * radius_px * radius_px)).exp();
            let product = gradient * gradient.transpose() * weight;
            sums += product;
            right += product * off;
        }
        let [least, most] = {
            let eigenvalues = sums.symmetric_eigenvalues();
            [eigenvalues.min(), eigenvalues.max()]
        };
        if most.is_nan() || least <= LEAST_RATIO * most {
            return None;
        }
        let step = sums.try_inverse()? * right;
        place += step;
        if (place - start).norm() > radius_px {
            return None;
        }
        if step.norm() < LAST_STEP_PX {
            break;
        }
    }
    Some(place)
}
