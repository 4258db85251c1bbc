//! Tape measurements and their checks.

/// Measurements with the wall at one distance, in metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WallMeasures {
    /// Z: from the lens to the wall; with a second distance, from any fixed point of the projector.
    pub distance_m: f64,
    /// W and H of the image on the wall.
    pub image_m: [f64; 2],
    /// X and Y from the image's top left corner to the intersection of the optical axis and the wall. Optional at one
    /// of two distances.
    pub axis_m: Option<[f64; 2]>,
}

/// All measurements.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ManualMeasures {
    /// Image width and height, pixels.
    pub size_px: [u32; 2],
    /// First distance.
    pub first: WallMeasures,
    /// Second distance, nearer or farther.
    pub second: Option<WallMeasures>,
    /// Standard deviation of a length read from the tape, metres.
    pub tape_error_m: f64,
}

/// Invalid measurements.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ManualError {
    /// The image has no pixels.
    #[error("the picture has {}x{} pixels", size_px[0], size_px[1])]
    NoPixels {
        /// Image width and height.
        size_px: [u32; 2],
    },
    /// The value of a measurement, by its name, is NaN or infinite.
    #[error("{0} is {1}, which is not a finite number")]
    NotFinite(&'static str, f64),
    /// The value of a measurement, by its name, is zero or less, metres.
    #[error("{0} is {1} m; it must be greater than zero")]
    NotPositive(&'static str, f64),
    /// The optical axis was measured at no distance.
    #[error("where the optical axis meets the wall (X, Y) was measured at no distance")]
    NoAxis,
    /// Both distances are equal, metres.
    #[error("both distances are {0} m; move the projector or the wall between them")]
    SameDistance(f64),
    /// The image is not larger at the larger distance.
    #[error(
        "the {side} is {far_m} m at {far_distance_m} m and {near_m} m at {near_distance_m} m, but a picture grows with \
         the distance"
    )]
    DoesNotGrow {
        /// `width` or `height`.
        side: &'static str,
        /// Smaller distance, metres.
        near_distance_m: f64,
        /// Side at the smaller distance, metres.
        near_m: f64,
        /// Larger distance, metres.
        far_distance_m: f64,
        /// Side at the larger distance, metres.
        far_m: f64,
    },
    /// The resulting lens has no finite or no positive focal lengths.
    #[error("these measures are those of no projector (f {fx} and {fy} pixels)")]
    Absurd {
        /// Focal length along u, pixels.
        fx: f64,
        /// Focal length along v, pixels.
        fy: f64,
    },
}

impl ManualMeasures {
    /// Default of [`Self::tape_error_m`].
    pub const TAPE_ERROR_M: f64 = 0.002;

    /// Measurements of both distances.
    pub(super) fn walls(&self) -> impl Iterator<Item = &WallMeasures> {
        [Some(&self.first), self.second.as_ref()].into_iter().flatten()
    }

    /// Checks each value, and that the image grows with the distance.
    pub(super) fn check(&self) -> Result<(), ManualError> {
        if self.size_px.contains(&0) {
            return Err(ManualError::NoPixels { size_px: self.size_px });
        }
        positive("the tape's error", self.tape_error_m)?;
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
        for (wall, [distance, width, height, x, y]) in self.walls().zip(NAMES) {
            positive(distance, wall.distance_m)?;
            positive(width, wall.image_m[0])?;
            positive(height, wall.image_m[1])?;
            // The axis may lie left of the image or above it.
            for (name, at) in [x, y].into_iter().zip(wall.axis_m.into_iter().flatten()) {
                finite(name, at)?;
            }
        }
        if self.walls().all(|wall| wall.axis_m.is_none()) {
            return Err(ManualError::NoAxis);
        }
        self.second.as_ref().map_or(Ok(()), |second| check_growth(&self.first, second))
    }
}

fn check_growth(first: &WallMeasures, second: &WallMeasures) -> Result<(), ManualError> {
    let (near, far) = if first.distance_m < second.distance_m { (first, second) } else { (second, first) };
    if near.distance_m == far.distance_m {
        return Err(ManualError::SameDistance(near.distance_m));
    }
    for (axis, side) in ["width", "height"].into_iter().enumerate() {
        if far.image_m[axis] <= near.image_m[axis] {
            return Err(ManualError::DoesNotGrow {
                side,
                near_distance_m: near.distance_m,
                near_m: near.image_m[axis],
                far_distance_m: far.distance_m,
                far_m: far.image_m[axis],
            });
        }
    }
    Ok(())
}

fn finite(measure: &'static str, value: f64) -> Result<(), ManualError> {
    value.is_finite().then_some(()).ok_or(ManualError::NotFinite(measure, value))
}

fn positive(measure: &'static str, value: f64) -> Result<(), ManualError> {
    finite(measure, value)?;
    (value > 0.0).then_some(()).ok_or(ManualError::NotPositive(measure, value))
}
