//! The light that a window may show in place of the newest picture. The program that hands pictures over decides that;
//! the window obeys.

use std::fmt::Debug;
use std::sync::Arc;

use rcs_scene::Picture;

/// Takes light away where there must be none.
pub trait Mask: Debug + Send + Sync {
    /// A picture that was drawn earlier, as it may be lit now.
    fn post_process(&self, drawn: &Picture) -> Picture;

    /// The share of light that is allowed at each pixel of a monitor of this size: a mono8 picture, 255 all of it. What
    /// is beyond the picture's edges is dark.
    fn shares(&self, monitor_px: [u32; 2]) -> Picture;
}

/// How much of something may be lit.
#[derive(Debug, Clone, Default)]
pub enum Light {
    /// All of it.
    #[default]
    All,
    /// Only the light that the mask leaves.
    Masked(Arc<dyn Mask>),
    /// Nothing.
    Nothing,
}

impl Light {
    /// Whether nothing may be lit.
    pub(crate) fn is_nothing(&self) -> bool {
        matches!(self, Self::Nothing)
    }

    /// Whether what is shown by this has to be drawn again for the other.
    pub(crate) fn differs(&self, other: &Self) -> bool {
        !matches!((self, other), (Self::All, Self::All) | (Self::Nothing, Self::Nothing))
    }
}

/// What may be lit in place of a picture.
#[derive(Debug, Clone, Default)]
pub struct WindowPermit {
    /// An earlier picture, which the user has paused. Where it is nothing, the newest picture is shown.
    pub paused: Light,
    /// Test pictures.
    pub test: Light,
    /// An earlier picture may stay only in the place of those of its own number; otherwise the pause goes on with the
    /// newest.
    pub scene: u64,
}

/// A picture as it was drawn, and what may be lit in its place.
#[derive(Debug, Clone)]
pub struct LitPicture {
    /// The picture.
    pub picture: Arc<Picture>,
    /// The picture before its mask, which a pause needs below newer masks.
    pub drawn: Option<Arc<Picture>>,
    /// What may be lit in its place.
    pub permit: WindowPermit,
}

/// Takes away from pixels, `0x00RRGGBB`, what is not allowed; the shares are those of as many pixels.
pub(crate) fn dim(pixels: &mut [u32], shares: &[u8]) {
    let scaled = |level: u32, share: u8| (level & 0xff) * u32::from(share) / 255;
    for (index, pixel) in pixels.iter_mut().enumerate() {
        let share = shares.get(index).copied().unwrap_or(0);
        *pixel = scaled(*pixel >> 16, share) << 16 | scaled(*pixel >> 8, share) << 8 | scaled(*pixel, share);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_take_light_away_and_pixels_without_one_are_dark() {
        let mut pixels = [0x00ff_8040, 0x00ff_8040, 0x00ff_8040, 0x00ff_ffff];
        dim(&mut pixels, &[255, 128, 0]);
        assert_eq!(pixels, [0x00ff_8040, 0x0080_4020, 0, 0]);
    }
}
