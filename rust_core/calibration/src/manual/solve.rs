//! Lens from tape measurements, and its accuracy: the tape's errors, taken as independent, propagated to first order.

use nalgebra::{Point2, Vector2};

use super::measures::{ManualError, ManualMeasures};
use super::warning::{warnings, ManualWarning};
use crate::Lens;

/// Lens that follows from tape measurements.
#[derive(Debug, Clone, PartialEq)]
pub struct ManualLens {
    /// Lens without distortion.
    pub lens: Lens,
    /// Accuracy of the lens.
    pub accuracy: ManualAccuracy,
    /// With two distances: how far the light's origin lies behind the point that distances were measured from, by width
    /// and by height, metres; negative: before it.
    pub lens_place_m: Option<[f64; 2]>,
    /// Warnings for the user.
    pub warnings: Vec<ManualWarning>,
}

/// Standard deviations that follow from the tape's error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ManualAccuracy {
    /// Relative deviations of fx and fy.
    pub focal_share: Vector2<f64>,
    /// Deviations of cx and cy, pixels.
    pub center_px: Vector2<f64>,
    /// Projection error at 1 m, at the worst corner of the image, metres.
    pub light_m: f64,
    /// Relative error of f for each metre between the light's origin and the point measured from; `None` with two
    /// distances, which cancel it.
    pub focal_share_by_place: Option<f64>,
}

/// Computes the lens.
///
/// ```
/// use rcs_calibration::manual::{solve, ManualMeasures, WallMeasures};
///
/// let at = |distance_m, image_m, axis_m| WallMeasures { distance_m, image_m, axis_m: Some(axis_m) };
/// let mut measures = ManualMeasures {
///     size_px: [1280, 800],
///     first: at(1.0, [0.8, 0.5], [0.4, 0.5]),
///     second: None,
///     tape_error_m: 0.001,
/// };
/// let one = solve(&measures)?;
/// assert_eq!((one.lens.focal_px.x, one.lens.center_px.y), (1600.0, 800.0));
///
/// // A second distance shows that the light comes from 25 mm before the point measured from.
/// measures.second = Some(at(2.0, [1.62051282, 1.01282051], [0.81025641, 1.01282051]));
/// let two = solve(&measures)?;
/// assert_eq!(two.lens.focal_px.x.round(), 1560.0);
/// assert_eq!(two.lens_place_m.map(|place| (place[0] * 1000.0).round()), Some(-25.0));
/// # Ok::<(), rcs_calibration::manual::ManualError>(())
/// ```
///
/// # Errors
/// [`ManualError`]: values that are not finite or not positive, a missing axis, equal distances, or an image that does
/// not grow.
pub fn solve(measures: &ManualMeasures) -> Result<ManualLens, ManualError> {
    measures.check()?;
    let ManualMeasures { size_px, first, second, .. } = measures;
    let sides = size_px.map(f64::from);
    let focal_px = [0, 1].map(|axis| match second {
        None => sides[axis] * first.distance_m / first.image_m[axis],
        Some(second) => {
            sides[axis] * (second.distance_m - first.distance_m) / (second.image_m[axis] - first.image_m[axis])
        }
    });
    let places: Vec<_> = measures.walls().filter_map(|wall| Some((wall, wall.axis_m?))).collect();
    let center_px = [0, 1].map(|axis| match places[..] {
        [(wall, place)] => sides[axis] * place[axis] / wall.image_m[axis],
        _ => {
            let sum = |value: fn(f64, f64) -> f64| -> f64 {
                places.iter().map(|(wall, place)| value(place[axis], wall.image_m[axis])).sum()
            };
            sides[axis] * sum(|place, side| place * side) / sum(|_, side| side * side)
        }
    });
    let [fx, fy] = focal_px;
    if !focal_px.iter().chain(&center_px).all(|value| value.is_finite()) || fx <= 0.0 || fy <= 0.0 {
        return Err(ManualError::Absurd { fx, fy });
    }
    let lens = Lens::pinhole(*size_px, focal_px, center_px);
    let lens_place_m =
        second.map(|_| [0, 1].map(|axis| focal_px[axis] * first.image_m[axis] / sides[axis] - first.distance_m));
    let accuracy = ManualAccuracy::new(measures, &lens);
    let warnings = warnings(measures, &lens, lens_place_m);
    Ok(ManualLens { lens, accuracy, lens_place_m, warnings })
}

impl ManualAccuracy {
    /// Accuracy of the lens from checked measurements.
    fn new(measures: &ManualMeasures, lens: &Lens) -> Self {
        let ManualMeasures { first, second, tape_error_m, .. } = measures;
        let focal_share = Vector2::from_fn(|axis, _| match second {
            None => tape_error_m * (1.0 / first.distance_m).hypot(1.0 / first.image_m[axis]),
            Some(second) => {
                let by_distance = 1.0 / (second.distance_m - first.distance_m);
                let by_side = 1.0 / (second.image_m[axis] - first.image_m[axis]);
                tape_error_m * 2.0_f64.sqrt() * by_distance.hypot(by_side)
            }
        });
        let center_px = Vector2::from_fn(|axis, _| {
            let with_axis = measures.walls().filter(|wall| wall.axis_m.is_some());
            let squares: f64 = with_axis.map(|wall| wall.image_m[axis].powi(2)).sum();
            let side_px = f64::from(lens.size_px[axis]);
            // The side's error counts in proportion to the axis' distance from the corner.
            side_px * tape_error_m * 1.0_f64.hypot(lens.center_px[axis] / side_px) / squares.sqrt()
        });
        let focal_share_by_place = second.is_none().then(|| 1.0 / first.distance_m);
        let [width, height] = lens.size_px.map(f64::from);
        let error_at_m = |corner: [f64; 2]| {
            let off_axis = (Point2::from(corner) - lens.center_px).component_div(&lens.focal_px);
            off_axis.component_mul(&focal_share).norm().hypot(center_px.component_div(&lens.focal_px).norm())
        };
        let corners = [[0.0, 0.0], [width, 0.0], [0.0, height], [width, height]];
        let light_m = corners.map(error_at_m).into_iter().fold(0.0, f64::max);
        Self { focal_share, center_px, light_m, focal_share_by_place }
    }
}
