//! Limits of light for content in place of the newest picture. The program sets them with each picture.

use std::fmt::Debug;
use std::sync::Arc;

use rcs_scene::Picture;

use crate::test_pictures::TestPicture;

/// A mask of the light at each pixel.
pub trait Mask: Debug + Send + Sync {
    /// The allowed share of light at each pixel of a monitor of this size: a mono8 picture, 255 for all. Pixels beyond
    /// the picture's edges are dark.
    fn shares(&self, monitor_px: [u32; 2]) -> Picture;
}

/// Limit of the light of some content.
#[derive(Debug, Clone, Default)]
pub enum LightLimit {
    /// No limit.
    #[default]
    All,
    /// The light within the mask.
    Masked(Arc<dyn Mask>),
    /// No light.
    Nothing,
}

impl LightLimit {
    /// `true` for no light.
    pub(crate) fn is_nothing(&self) -> bool {
        matches!(self, Self::Nothing)
    }

    /// `true` if content has to be drawn again for the other limit.
    pub(crate) fn differs(&self, other: &Self) -> bool {
        !matches!((self, other), (Self::All, Self::All) | (Self::Nothing, Self::Nothing))
    }
}

/// Limits of content in place of a picture.
#[derive(Debug, Clone)]
pub struct WindowPermit {
    /// `true` if a paused picture may stay in its place.
    pub is_lit: bool,
    /// Limit of test pictures.
    pub test: LightLimit,
}

impl Default for WindowPermit {
    fn default() -> Self {
        Self { is_lit: true, test: LightLimit::All }
    }
}

/// The view that a program selects.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum WindowView {
    /// The newest picture.
    #[default]
    Live,
    /// No light.
    Black,
    /// A test picture in the monitor's resolution, within the permit.
    Test(TestPicture),
}

/// Hears when a picture is on the screen.
pub trait OnScreen: Debug + Send + Sync {
    /// The display server has completed the picture in the window, or has it where it does not report that. Called on
    /// the window's thread, once, and never for a picture that a newer one has replaced before.
    fn shown(&self);
}

/// A picture with the limits of content in its place.
#[derive(Debug, Clone)]
pub struct LitPicture {
    /// The picture.
    pub picture: Arc<Picture>,
    /// Limits of content in its place.
    pub permit: WindowPermit,
    /// Hears when it is on the screen.
    pub on_screen: Option<Arc<dyn OnScreen>>,
}

/// Scales pixels, `0x00RRGGBB`, by their shares; pixels without a share are dark.
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
