//! Depths of the objects to be confirmed, and shares of the results.

/// Depths of what the listed displays light in an image that is about to be shown.
#[derive(Clone, Copy, Debug)]
pub struct ObjectDepths<'a> {
    /// Width and height of the finished image: after lens and flip, before its orientation.
    pub size_px: [u32; 2],
    /// Metres along the optical axis for each pixel, row by row; NaN where no listed display lights.
    pub depths_m: &'a [f32],
    /// A pixel without depth stays dark.
    pub is_strict: bool,
}

/// Shares of the pixels that the listed displays light, 0 to 1; all 0 if they light none. A pixel counts by what the
/// surface says, whether or not its light is still held back.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Shares {
    /// The surface is at the object's depth.
    pub confirmed: f64,
    /// A surface is nearer than the object.
    pub blocked: f64,
    /// The surface is farther than the object.
    pub gone: f64,
    /// No surface was measured there.
    pub unseen: f64,
}
