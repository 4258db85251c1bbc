//! A projector's intrinsics from a tape measure: the jig of the paper.
//!
//! The projector stands still and throws its picture onto a flat wall at right angles to its optical axis. Measured are
//! the picture's width W and height H, the distance Z from the lens to the wall, and the place (X, Y) where the optical
//! axis meets the wall, from the picture's top left corner: X to the right, Y down, all in metres. For a picture of
//! w×h pixels
//!
//! ```text
//! fx = w·Z/W    fy = h·Z/H    cx = w·X/W    cy = h·Y/H
//! ```
//!
//! Where in the housing the light seems to come from is not to be seen from outside; being wrong by a centimetre at a
//! metre makes f wrong by 1 %. A second distance cancels it, since the picture grows in proportion to the *difference*:
//!
//! ```text
//! fx = w·(Z2 − Z1)/(W2 − W1)    fy = h·(Z2 − Z1)/(H2 − H1)
//! ```
//!
//! The principal point does not depend on that place. Each distance tells c/w = X/W; of both, the value with the least
//! squared errors of X counts: c/w = (X1·W1 + X2·W2)/(W1² + W2²), so that the larger picture, whose pixels are larger
//! in comparison with the tape's errors, has more weight. (The difference of both, w·(X2 − X1)/(W2 − W1), would be
//! several times less certain.) c is never forced into the picture: many projectors throw upwards, with the axis below
//! the picture.
//!
//! Distances to edges are rounded to pixels nowhere: half a pixel is a third of a millimetre in such a picture, less
//! than the tape shows.

mod accuracy;
mod warning;

use crate::Lens;

pub use accuracy::ManualAccuracy;
pub use warning::{compare_matrices, ManualWarning, MatrixDifference, WarningAxis};

/// What was measured with the wall at one distance. All lengths are metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WallMeasures {
    /// Z: from the lens, or from any fixed place of the projector if there is a second distance, to the wall.
    pub distance_m: f64,
    /// W and H of the picture on the wall.
    pub picture_m: [f64; 2],
    /// X and Y from the picture's top left corner to the place where the optical axis meets the wall. One of two
    /// distances may go without.
    pub axis_m: Option<[f64; 2]>,
}

/// All that was measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ManualMeasures {
    /// Width and height of the picture, pixels.
    pub size_px: [u32; 2],
    /// One distance.
    pub first: WallMeasures,
    /// Another distance, nearer or farther.
    pub second: Option<WallMeasures>,
    /// How far a length read from the tape is off, as a standard deviation, metres.
    pub tape_error_m: f64,
}

impl ManualMeasures {
    /// What is taken for [`Self::tape_error_m`] if nothing is known.
    pub const TAPE_ERROR_M: f64 = 0.002;
}

/// What follows from the measures.
#[derive(Debug, Clone, PartialEq)]
pub struct ManualLens {
    /// The lens, without distortion.
    pub lens: Lens,
    /// How certain it is.
    pub accuracy: ManualAccuracy,
    /// With two distances: how far behind the place that distances were measured from the light seems to come from,
    /// by width and by height, metres; negative: before it.
    pub lens_place_m: Option<[f64; 2]>,
    /// What the user should look at again.
    pub warnings: Vec<ManualWarning>,
}

/// Why nothing follows from the measures.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ManualError {
    /// A picture without pixels.
    #[error("the picture has {}x{} pixels", size_px[0], size_px[1])]
    NoPixels {
        /// Its width and height.
        size_px: [u32; 2],
    },
    /// Not a number, or infinite.
    #[error("{measure} is {value}, which is not a finite number")]
    NotFinite {
        /// What was measured.
        measure: &'static str,
        /// Its value.
        value: f64,
    },
    /// Zero or less.
    #[error("{measure} is {value} m; it must be greater than zero")]
    NotPositive {
        /// What was measured.
        measure: &'static str,
        /// Its value, metres.
        value: f64,
    },
    /// The place of the optical axis is missing.
    #[error("where the optical axis meets the wall (X, Y) was measured at no distance")]
    NoAxis,
    /// Two distances that are one.
    #[error("both distances are {distance_m} m; move the projector or the wall between them")]
    SameDistance {
        /// The distance.
        distance_m: f64,
    },
    /// The picture is not larger at the larger distance.
    #[error(
        "the {side} is {far_m} m at {far_distance_m} m and {near_m} m at {near_distance_m} m, but a picture grows with \
         the distance"
    )]
    DoesNotGrow {
        /// `width` or `height`.
        side: &'static str,
        /// The smaller distance, metres.
        near_distance_m: f64,
        /// The side there, metres.
        near_m: f64,
        /// The larger distance, metres.
        far_distance_m: f64,
        /// The side there, metres.
        far_m: f64,
    },
    /// Measures whose quotients are too large for any number.
    #[error("these measures are those of no projector (f {fx} and {fy} pixels)")]
    Absurd {
        /// The focal lengths, pixels.
        fx: f64,
        /// The same along v.
        fy: f64,
    },
}

/// The lens that the measures are those of.
///
/// ```
/// use rcs_calibration::manual::{solve, ManualMeasures, WallMeasures};
///
/// let at = |distance_m, picture_m, axis_m| WallMeasures { distance_m, picture_m, axis_m: Some(axis_m) };
/// let mut measures = ManualMeasures {
///     size_px: [1280, 800],
///     first: at(1.0, [0.8, 0.5], [0.4, 0.5]),
///     second: None,
///     tape_error_m: 0.001,
/// };
/// let one = solve(&measures)?;
/// assert_eq!((one.lens.focal_px.x, one.lens.center_px.y), (1600.0, 800.0));
///
/// // With another wall farther away it shows that the light comes from 25 mm before the place measured from.
/// measures.second = Some(at(2.0, [1.62051282, 1.01282051], [0.81025641, 1.01282051]));
/// let two = solve(&measures)?;
/// assert_eq!(two.lens.focal_px.x.round(), 1560.0);
/// assert_eq!(two.lens_place_m.map(|place| (place[0] * 1000.0).round()), Some(-25.0));
/// # Ok::<(), rcs_calibration::manual::ManualError>(())
/// ```
///
/// # Errors
/// [`ManualError`]: what is not finite or not positive, a missing axis, two distances that are one or at which the
/// picture does not grow.
pub fn solve(measures: &ManualMeasures) -> Result<ManualLens, ManualError> {
    check(measures)?;
    let ManualMeasures { size_px, first, second, .. } = measures;
    let sides = [0, 1].map(|axis| f64::from(size_px[axis]));
    let places: Vec<(&WallMeasures, [f64; 2])> =
        [Some(first), second.as_ref()].into_iter().flatten().filter_map(|wall| Some((wall, wall.axis_m?))).collect();
    let focal_px = [0, 1].map(|axis| focal_length(sides[axis], axis, first, second.as_ref()));
    let center_px = [0, 1].map(|axis| match places[..] {
        [(wall, place)] => sides[axis] * place[axis] / wall.picture_m[axis],
        _ => {
            let sum = |value: fn(f64, f64) -> f64| -> f64 {
                places.iter().map(|(wall, place)| value(place[axis], wall.picture_m[axis])).sum()
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
        second.map(|_| [0, 1].map(|axis| focal_px[axis] * first.picture_m[axis] / sides[axis] - first.distance_m));
    let accuracy = ManualAccuracy::of(measures, &lens);
    let warnings = warning::warnings(measures, &lens, lens_place_m);
    Ok(ManualLens { lens, accuracy, lens_place_m, warnings })
}

fn focal_length(side_px: f64, axis: usize, first: &WallMeasures, second: Option<&WallMeasures>) -> f64 {
    match second {
        None => side_px * first.distance_m / first.picture_m[axis],
        Some(second) => {
            side_px * (second.distance_m - first.distance_m) / (second.picture_m[axis] - first.picture_m[axis])
        }
    }
}

/// An error for measures that cannot be.
fn check(measures: &ManualMeasures) -> Result<(), ManualError> {
    let ManualMeasures { size_px, first, second, tape_error_m } = measures;
    if size_px.contains(&0) {
        return Err(ManualError::NoPixels { size_px: *size_px });
    }
    positive("the tape's error", *tape_error_m)?;
    const NAMES: [[&str; 5]; 2] = [
        ["the distance", "the picture's width", "the picture's height", "the axis' X", "the axis' Y"],
        [
            "the second distance",
            "the picture's width at the second distance",
            "the picture's height at the second distance",
            "the axis' X at the second distance",
            "the axis' Y at the second distance",
        ],
    ];
    let walls = [Some(first), second.as_ref()];
    for (wall, [distance, width, height, x, y]) in walls.into_iter().zip(NAMES) {
        let Some(wall) = wall else { continue };
        positive(distance, wall.distance_m)?;
        positive(width, wall.picture_m[0])?;
        positive(height, wall.picture_m[1])?;
        // The axis may lie left of the picture or above it.
        for (name, place) in [x, y].into_iter().zip(wall.axis_m.into_iter().flatten()) {
            finite(name, place)?;
        }
    }
    if walls.iter().flatten().all(|wall| wall.axis_m.is_none()) {
        return Err(ManualError::NoAxis);
    }
    second.as_ref().map_or(Ok(()), |second| check_growth(first, second))
}

fn check_growth(first: &WallMeasures, second: &WallMeasures) -> Result<(), ManualError> {
    let (near, far) = if first.distance_m < second.distance_m { (first, second) } else { (second, first) };
    if near.distance_m == far.distance_m {
        return Err(ManualError::SameDistance { distance_m: near.distance_m });
    }
    for (axis, side) in ["width", "height"].into_iter().enumerate() {
        if far.picture_m[axis] <= near.picture_m[axis] {
            return Err(ManualError::DoesNotGrow {
                side,
                near_distance_m: near.distance_m,
                near_m: near.picture_m[axis],
                far_distance_m: far.distance_m,
                far_m: far.picture_m[axis],
            });
        }
    }
    Ok(())
}

fn finite(measure: &'static str, value: f64) -> Result<(), ManualError> {
    if value.is_finite() {
        Ok(())
    } else {
        Err(ManualError::NotFinite { measure, value })
    }
}

fn positive(measure: &'static str, value: f64) -> Result<(), ManualError> {
    finite(measure, value)?;
    if value > 0.0 {
        Ok(())
    } else {
        Err(ManualError::NotPositive { measure, value })
    }
}

#[cfg(test)]
mod tests;
