//! The fields of a `sensor_msgs/CameraInfo` that say how a camera projects.

/// A CameraInfo without its header, binning and region of interest; whoever has a message, or a struct of another
/// language, lends its fields. Matrices are row by row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraInfoFields<'a> {
    /// Pixels in a row.
    pub width_px: u32,
    /// Rows.
    pub height_px: u32,
    /// The model that `d` is of, such as `plumb_bob`.
    pub distortion_model: &'a str,
    /// The coefficients of the distortion; empty or all 0 without one.
    pub d: &'a [f64],
    /// Intrinsics of the raw picture, pixels, 3×3.
    pub k: &'a [f64; 9],
    /// The rotation from the raw picture's frame to that of P, 3×3; all 0 where it is not set.
    pub r: &'a [f64; 9],
    /// The projection to the rectified picture, pixels, 3×4.
    pub p: &'a [f64; 12],
}
