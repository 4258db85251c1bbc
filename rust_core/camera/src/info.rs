//! The projection fields of a `sensor_msgs/CameraInfo`, and the lens of its K and D.

use nalgebra::{Point2, Vector2};
use rcs_calibration::{Distortion, Lens};

/// A CameraInfo without its header, borrowed from a message or a C struct. Matrices are row by row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraInfoFields<'a> {
    /// Pixels in a row.
    pub width_px: u32,
    /// Rows.
    pub height_px: u32,
    /// The distortion model of `d`, such as `plumb_bob`.
    pub distortion_model: &'a str,
    /// The coefficients of the distortion; empty or all 0 without one.
    pub d: &'a [f64],
    /// Intrinsics of the raw image, pixels, 3×3.
    pub k: &'a [f64; 9],
    /// The rotation from the raw image's frame to that of P, 3×3; all 0 where it is not set.
    pub r: &'a [f64; 9],
    /// The projection to the rectified image, pixels, 3×4.
    pub p: &'a [f64; 12],
    /// Columns and rows that the driver merges into one; 0 and 1 are none.
    pub binning: [u32; 2],
    /// The region of interest: offset from the left and the top, width and height, pixels; all 0 for the whole image.
    pub region_px: [u32; 4],
}

impl CameraInfoFields<'_> {
    /// `true` if the driver merges pixels.
    pub(crate) fn is_binned(&self) -> bool {
        self.binning.iter().any(|binning| *binning > 1)
    }

    /// `true` if the region of interest is not the whole image.
    pub(crate) fn is_cropped(&self) -> bool {
        let [left, top, width, height] = self.region_px;
        let is_set = width != 0 || height != 0 || left != 0 || top != 0;
        is_set && [left, top, width, height] != [0, 0, self.width_px, self.height_px]
    }
}

/// Invalid lens of a CameraInfo.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{key}: {reason}")]
pub struct LensProblem {
    /// Key of the file or field of the message.
    pub key: &'static str,
    /// Problem with its value.
    pub reason: String,
}

/// The lens of K and D of a CameraInfo, which is that of the raw image. K counts up to scale.
///
/// # Errors
/// [`LensProblem`]: focal lengths of zero, skews that leave no image, a last row of K that is not (0, 0, s) with s >
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
