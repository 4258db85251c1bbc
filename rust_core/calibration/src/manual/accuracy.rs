//! How certain a lens from a tape measure is: the tape's errors, taken as independent, propagated to first order.

use nalgebra::{Point2, Vector2};

use super::{ManualMeasures, WallMeasures};
use crate::Lens;

/// Standard deviations that follow from the tape's error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ManualAccuracy {
    /// Of fx and fy, as shares of them.
    pub focal_share: Vector2<f64>,
    /// Of cx and cy, pixels.
    pub center_px: Vector2<f64>,
    /// How far light lands from where it should at 1 m, at the corner of the picture where that is the most, metres.
    pub light_m: f64,
    /// By which share f is wrong for each metre that the light comes from elsewhere than the distance was measured
    /// from; none with two distances, which cancel it.
    pub focal_share_by_place: Option<f64>,
}

impl ManualAccuracy {
    /// The accuracy of this lens from these measures, which were checked.
    pub(super) fn of(measures: &ManualMeasures, lens: &Lens) -> Self {
        let ManualMeasures { first, second, tape_error_m, .. } = measures;
        let focal_share = Vector2::from_fn(|axis, _| match second {
            None => tape_error_m * (1.0 / first.distance_m).hypot(1.0 / first.picture_m[axis]),
            Some(second) => {
                let by_distance = 1.0 / (second.distance_m - first.distance_m);
                let by_side = 1.0 / (second.picture_m[axis] - first.picture_m[axis]);
                tape_error_m * 2.0_f64.sqrt() * by_distance.hypot(by_side)
            }
        });
        let walls = || [Some(first), second.as_ref()].into_iter().flatten();
        let squares = |axis: usize| -> f64 {
            let of_wall = |wall: &WallMeasures| wall.picture_m[axis].powi(2);
            walls().filter(|wall| wall.axis_m.is_some()).map(of_wall).sum()
        };
        let center_px = Vector2::from_fn(|axis, _| center_error(lens, axis, squares(axis), *tape_error_m));
        let focal_share_by_place = second.is_none().then(|| 1.0 / first.distance_m);
        let mut accuracy = Self { focal_share, center_px, light_m: 0.0, focal_share_by_place };
        let [width, height] = lens.size_px.map(f64::from);
        let corners = [[0.0, 0.0], [width, 0.0], [0.0, height], [width, height]];
        accuracy.light_m =
            corners.into_iter().map(|corner| accuracy.light_at_m(lens, corner.into())).fold(0.0, f64::max);
        accuracy
    }

    /// How far light of a pixel lands from where it should at 1 m, metres.
    fn light_at_m(&self, lens: &Lens, pixel: Point2<f64>) -> f64 {
        let by_focal = (pixel - lens.center_px).component_div(&lens.focal_px).component_mul(&self.focal_share);
        let by_center = self.center_px.component_div(&lens.focal_px);
        by_focal.norm().hypot(by_center.norm())
    }
}

/// Of one coordinate of the principal point, from axes measured in pictures whose sides' squares add up to `squares`,
/// pixels. The side's error counts as much as the axis lies off the corner.
fn center_error(lens: &Lens, axis: usize, squares: f64, tape_error_m: f64) -> f64 {
    let side_px = f64::from(lens.size_px[axis]);
    side_px * tape_error_m * 1.0_f64.hypot(lens.center_px[axis] / side_px) / squares.sqrt()
}
