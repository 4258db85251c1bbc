//! The fields of a `sensor_msgs/CameraInfo` that say how a camera projects.

/// A CameraInfo without its header; whoever has a message, or a struct of another
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
    /// Columns and rows that a camera's driver merges into one; 0 and 1 mean that it does not.
    pub binning: [u32; 2],
    /// The region of interest: offset from the left and the top, width and height, pixels; all 0 for the whole picture.
    pub region_px: [u32; 4],
}

impl CameraInfoFields<'_> {
    /// Whether the driver merges pixels.
    pub(crate) fn is_binned(&self) -> bool {
        self.binning.iter().any(|binning| *binning > 1)
    }

    /// Whether the region of interest is not the whole picture.
    pub(crate) fn is_cropped(&self) -> bool {
        let [left, top, width, height] = self.region_px;
        let is_set = width != 0 || height != 0 || left != 0 || top != 0;
        is_set && [left, top, width, height] != [0, 0, self.width_px, self.height_px]
    }
}
