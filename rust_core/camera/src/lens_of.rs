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

/// The lens that K and D of a CameraInfo describe: that of the raw picture. K counts up to scale.
///
/// # Errors
/// [`LensProblem`]: focal lengths of zero, skews that leave no picture, a last row of K that is not (0, 0, s) with s >
/// 0, a distortion that no lens model has.
pub fn lens_of(info: &CameraInfoFields<'_>) -> Result<Lens, LensProblem> {
    let wrong = |key, reason| Err(LensProblem { key, reason });
    if info.k.iter().any(|value| !value.is_finite()) {
        return wrong("K", "not all are finite numbers".to_owned());
    }
    let [.., below_x, below_y, scale] = *info.k;
    if !(scale > 0.0 && [below_x, below_y] == [0.0; 2]) {
        let row = [below_x, below_y, scale];
        return wrong("K", format!("its last row is {row:?} where [0, 0, s] with s > 0 is needed"));
    }
    let [fx, skew, cx, below_fx, fy, cy, ..] = info.k.map(|value| value / scale);
    if !(fx.is_normal() && fy.is_normal()) {
        return wrong("K", format!("a focal length is 0 (fx {fx}, fy {fy})"));
    }
    if (fx * fy).abs() <= (skew * below_fx).abs() || !(skew.is_finite() && below_fx.is_finite()) {
        return wrong("K", format!("its skews ({skew}, {below_fx}) are too large for its focal lengths ({fx}, {fy})"));
    }
    let distortion = Distortion::from_message(info.distortion_model, info.d)
        .map_err(|problem| LensProblem { key: problem.key(), reason: problem.to_string() })?;
    let (focal_px, skew_px, center_px) = (Vector2::new(fx, fy), Vector2::new(skew, below_fx), Point2::new(cx, cy));
    Ok(Lens { size_px: [info.width_px, info.height_px], focal_px, skew_px, center_px, distortion })
}
