//! How far away what a picture shows is.

use crate::memory::resize_block;

/// Metres along the optical axis for each pixel, row by row from the top; NaN where nothing is.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DepthPicture {
    /// Pixels in a row.
    pub width_px: u32,
    /// Rows.
    pub height_px: u32,
    /// `width · height` depths.
    pub depths_m: Vec<f32>,
}

impl DepthPicture {
    /// Makes it a picture of this size that shows nothing. Keeps its memory, unless that is several times what the
    /// picture needs.
    pub fn reset(&mut self, width_px: u32, height_px: u32) {
        (self.width_px, self.height_px) = (width_px, height_px);
        resize_block(&mut self.depths_m, width_px as usize * height_px as usize, f32::NAN);
        self.depths_m.fill(f32::NAN);
    }
}
