//! Plausibility warnings about a lens from a tape measure or from a projector's file, one line each.

use super::measures::{ManualMeasures, WallMeasures};
use crate::patterns::Axis;
use crate::Lens;

/// Maximum relative difference of fx and fy: common projectors have square pixels.
const MOST_FOCAL_DIFFERENCE: f64 = 0.02;
/// Maximum difference of two measurements, standard deviations.
const MOST_SIGMAS: f64 = 3.0;
/// Maximum distance of the light's origin from the point measured from, metres.
const MOST_LENS_PLACE_M: f64 = 0.15;
/// Plausible throw ratios (distance over width).
const THROW_RATIOS: std::ops::RangeInclusive<f64> = 0.15..=15.0;
/// Maximum difference of K and P at the image's edge, pixels: the effect of rounding to a decimal.
const MOST_MATRIX_DIFFERENCE_PX: f64 = 0.1;

/// Warning about a lens. [`Display`](std::fmt::Display) is one line.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ManualWarning {
    /// fx and fy, pixels, differ by more than 2 %.
    #[error(
        "fx {:.1} and fy {:.1} differ by {:.1} %: measure width and height again, and switch keystone correction and \
         zoom off",
        .0, .1, 100.0 * focal_difference(*.0, *.1)
    )]
    FocalLengthsDiffer(f64, f64),
    /// No projector has this throw ratio.
    #[error("the distance is {0:.3} times the picture's width, which no projector has: are all lengths in metres?")]
    ThrowImplausible(f64),
    /// The principal point lies beside the image, or more than an image height above or below it.
    #[error(
        "c{} {center_px:.1} is far outside of the picture (0 to {side_px}): measure {} from the picture's top left \
         corner, positive {}",
        axis.name(), axis.name().to_uppercase(), if *axis == Axis::X { "to the right" } else { "downwards" }
    )]
    CenterImplausible {
        /// Axis of the coordinate.
        axis: Axis,
        /// Coordinate, pixels.
        center_px: f64,
        /// Image width or height, pixels.
        side_px: u32,
    },
    /// The aspect ratios at the first and the second distance differ.
    #[error(
        "the two distances disagree: the picture is {0:.3} times as wide as high at the first, {1:.3} times at the \
         second; the wall must be at right angles to the optical axis at both"
    )]
    ShapesDiffer(f64, f64),
    /// The principal points by both distances differ.
    #[error(
        "the two distances disagree: c{} is {:.1} by the first, {:.1} by the second; measure again where the optical \
         axis meets the wall",
        axis.name(), centers_px[0], centers_px[1]
    )]
    AxesDiffer {
        /// Axis of the coordinate.
        axis: Axis,
        /// Coordinates by the first and by the second distance, pixels.
        centers_px: [f64; 2],
    },
    /// By two distances, the light's origin is far behind the point measured from, metres.
    #[error(
        "the two distances disagree: by them, light comes from {:.0} mm {} the place that they were measured from; \
         measure both from the same place of the projector",
        1e3 * .0.abs(), if *.0 < 0.0 { "before" } else { "behind" }
    )]
    LensPlaceImplausible(f64),
    /// K and P of a file differ.
    #[error(transparent)]
    MatricesDiffer(MatrixDifference),
}

/// Difference of K and P of a file.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("K and P differ: {}: up to {most_px:.0} pixels, {:.0} mm at a metre; pictures are drawn with P", named(.entries), 1e3 * most_m)]
pub struct MatrixDifference {
    /// Differing entries: name, K's value and P's, pixels.
    pub entries: Vec<(&'static str, f64, f64)>,
    /// Maximum distance of the two projections at the image's edge, pixels.
    pub most_px: f64,
    /// Maximum distance at 1 m, metres.
    pub most_m: f64,
}

fn named(entries: &[(&str, f64, f64)]) -> String {
    entries.iter().map(|(name, k, p)| format!("{name} {k} and {p}")).collect::<Vec<_>>().join(", ")
}

/// Compares K and P of a projector without distortion, which should be equal; `None` if they differ by rounding only.
/// Row by row, as in a CameraInfo.
///
/// ```
/// use rcs_calibration::manual::compare_matrices;
///
/// let k = [1900.0, 0.0, 640.0, 0.0, 1900.0, 817.0, 0.0, 0.0, 1.0];
/// let p = [1900.0, 0.0, 640.0, 0.0, 0.0, 1900.0, 750.0, 0.0, 0.0, 0.0, 1.0, 0.0];
/// let warning = compare_matrices([1280, 800], &k, &p).unwrap().to_string();
/// assert!(warning.starts_with("K and P differ: cy 817 and 750: up to 67 pixels, 35 mm at a metre"), "{warning}");
/// ```
pub fn compare_matrices(size_px: [u32; 2], k: &[f64; 9], p: &[f64; 12]) -> Option<MatrixDifference> {
    let [k_fx, _, k_cx, _, k_fy, k_cy, ..] = *k;
    let [p_fx, _, p_cx, _, _, p_fy, p_cy, ..] = *p;
    let (mut most_px, mut most_m) = (0.0_f64, 0.0_f64);
    for (axis, (k_f, k_c, p_f, p_c)) in [(k_fx, k_cx, p_fx, p_cx), (k_fy, k_cy, p_fy, p_cy)].into_iter().enumerate() {
        for edge in [0.0, f64::from(size_px[axis])] {
            let apart_m = ((edge - k_c) / k_f - (edge - p_c) / p_f).abs();
            // A focal length of zero or NaN counts as infinitely different.
            let [apart_m, apart_px] =
                [apart_m, apart_m * p_f.abs()].map(|apart| if apart.is_nan() { f64::INFINITY } else { apart });
            (most_m, most_px) = (most_m.max(apart_m), most_px.max(apart_px));
        }
    }
    let entries = [("fx", k_fx, p_fx), ("fy", k_fy, p_fy), ("cx", k_cx, p_cx), ("cy", k_cy, p_cy)];
    let differing = entries.into_iter().filter(|(_, k, p)| k != p).collect();
    (most_px > MOST_MATRIX_DIFFERENCE_PX).then_some(MatrixDifference { entries: differing, most_px, most_m })
}

/// Relative difference of fx and fy.
fn focal_difference(fx: f64, fy: f64) -> f64 {
    (fx - fy).abs() / fx.min(fy)
}

/// Collects the warnings about a lens and its measurements.
pub(super) fn warnings(measures: &ManualMeasures, lens: &Lens, lens_place_m: Option<[f64; 2]>) -> Vec<ManualWarning> {
    let focal_px: [f64; 2] = lens.focal_px.into();
    let mut warnings = Vec::new();
    if focal_difference(focal_px[0], focal_px[1]) > MOST_FOCAL_DIFFERENCE {
        warnings.push(ManualWarning::FocalLengthsDiffer(focal_px[0], focal_px[1]));
    }
    let throw_ratio = focal_px[0] / f64::from(lens.size_px[0]);
    if !THROW_RATIOS.contains(&throw_ratio) {
        warnings.push(ManualWarning::ThrowImplausible(throw_ratio));
    }
    for (axis, side_px) in Axis::ALL.into_iter().zip(lens.size_px) {
        let (center_px, side) = (lens.center_px[axis.index()], f64::from(side_px));
        // Projectors throw upwards or downwards, and hardly ever sideways.
        let room = if axis == Axis::X { 0.0 } else { side };
        if !(-room..=side + room).contains(&center_px) {
            warnings.push(ManualWarning::CenterImplausible { axis, center_px, side_px });
        }
    }
    if let Some(second) = &measures.second {
        compare_walls(&mut warnings, measures, second);
    }
    if let Some([by_width, by_height]) = lens_place_m {
        let behind_m = 0.5 * (by_width + by_height);
        if behind_m.abs() > MOST_LENS_PLACE_M {
            warnings.push(ManualWarning::LensPlaceImplausible(behind_m));
        }
    }
    warnings
}

/// Warns where both distances contradict each other.
fn compare_walls(warnings: &mut Vec<ManualWarning>, measures: &ManualMeasures, second: &WallMeasures) {
    let ManualMeasures { size_px, first, tape_error_m, .. } = measures;
    let walls = [first, second];
    let shapes = walls.map(|wall| wall.image_m[0] / wall.image_m[1]);
    let shares = walls.map(|wall| (1.0 / wall.image_m[0]).hypot(1.0 / wall.image_m[1]));
    if (shapes[0] / shapes[1]).ln().abs() > MOST_SIGMAS * tape_error_m * shares[0].hypot(shares[1]) {
        warnings.push(ManualWarning::ShapesDiffer(shapes[0], shapes[1]));
    }
    let (Some(first_axis), Some(second_axis)) = (first.axis_m, second.axis_m) else { return };
    for axis in Axis::ALL {
        let index = axis.index();
        let side_px = f64::from(size_px[index]);
        let sides_m = walls.map(|wall| wall.image_m[index]);
        let shares = [first_axis[index] / sides_m[0], second_axis[index] / sides_m[1]];
        let errors = [0, 1].map(|wall| tape_error_m / sides_m[wall] * 1.0_f64.hypot(shares[wall]));
        if (shares[0] - shares[1]).abs() > MOST_SIGMAS * errors[0].hypot(errors[1]) {
            warnings.push(ManualWarning::AxesDiffer { axis, centers_px: shares.map(|share| share * side_px) });
        }
    }
}
