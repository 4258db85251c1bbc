//! The lens that K and D of a CameraInfo describe.

use nalgebra::{Point2, Vector2};
use rcs_calibration::{Distortion, Lens};

use crate::CameraInfoFields;

/// Why a CameraInfo describes no lens that can be used.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{key}: {reason}")]
pub struct LensProblem {
    /// The key of the file or field of the message that is wrong.
    pub key: &'static str,
    /// What is wrong with it.
    pub reason: String,
}

/// The lens that K and D of a CameraInfo describe: that of the raw picture.
///
/// # Errors
/// [`LensProblem`]: focal lengths that are not positive, a skew, a last row of K that is not 0 0 1, a distortion that
/// no lens model has.
pub fn lens_of(info: &CameraInfoFields<'_>) -> Result<Lens, LensProblem> {
    let [fx, skew, cx, below_fx, fy, cy, last_row @ ..] = *info.k;
    let wrong = |key, reason| Err(LensProblem { key, reason });
    if info.k.iter().any(|value| !value.is_finite()) {
        return wrong("K", "not all are finite numbers".to_owned());
    }
    if fx <= 0.0 || fy <= 0.0 {
        return wrong("K", format!("the focal lengths (fx {fx}, fy {fy}) are not positive"));
    }
    if skew != 0.0 || below_fx != 0.0 {
        return wrong("K", format!("a skew ({skew}, {below_fx}) is not known to the lens model"));
    }
    if last_row != [0.0, 0.0, 1.0] {
        return wrong("K", format!("its last row is {last_row:?} where [0, 0, 1] is needed"));
    }
    let distortion = Distortion::from_message(info.distortion_model, info.d)
        .map_err(|problem| LensProblem { key: problem.key(), reason: problem.to_string() })?;
    let (focal_px, center_px) = (Vector2::new(fx, fy), Point2::new(cx, cy));
    Ok(Lens { size_px: [info.width_px, info.height_px], focal_px, center_px, distortion })
}
