//! Test images for a projector, in its own resolution. They reveal scaling, overscan, keystone correction, mirroring
//! and the wrong screen on the wall. Levels of grey only, for cameras of any kind.

mod canvas;
mod layout;
mod marks;

use std::str::FromStr;

use rcs_scene::Image;

pub(crate) use layout::identification;

/// A test image.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum TestImage {
    /// Lines with their coordinates: the projected position of each pixel. Straight on a plane unless the lens
    /// distorts.
    Grid,
    /// Squares: sharpness and scaling.
    Checkerboard,
    /// Lines through the middle of the image, with a scale.
    Crosshair,
    /// The outermost pixels, and stripes a pixel wide: overscan and scaling.
    Border,
    /// All levels of grey: brightness, contrast, gamma.
    Ramp,
    /// The monitor's name and resolution.
    Name,
    /// Marks of mirroring and rotation for people and cameras.
    Orientation,
}

/// Error of an unknown test image's name.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("there is no test picture '{0}'")]
pub struct UnknownTestImage(String);

impl TestImage {
    /// All test images, in the order of the key t.
    pub const ALL: [Self; 7] =
        [Self::Name, Self::Border, Self::Orientation, Self::Grid, Self::Checkerboard, Self::Crosshair, Self::Ramp];

    /// The image after another one in [`ALL`](Self::ALL), the first after none; `None` after the last one.
    pub fn after(current: Option<Self>) -> Option<Self> {
        let index = current.and_then(|current| Self::ALL.iter().position(|test| *test == current));
        Self::ALL.get(index.map_or(0, |index| index + 1)).copied()
    }

    /// The name on command lines and of files.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Grid => "grid",
            Self::Checkerboard => "checkerboard",
            Self::Crosshair => "crosshair",
            Self::Border => "border",
            Self::Ramp => "ramp",
            Self::Name => "name",
            Self::Orientation => "orientation",
        }
    }

    /// Draws the image in a resolution. `monitor` is the text of [`Self::Name`].
    ///
    /// ```
    /// use rcs_window::test_images::TestImage;
    ///
    /// let border = TestImage::Border.draw([1280, 800], "HDMI-1");
    /// assert_eq!((border.data[0], border.data[1280 + 1]), (255, 0));
    /// ```
    pub fn draw(self, size_px: [u32; 2], monitor: &str) -> Image {
        match self {
            Self::Grid => layout::grid(size_px),
            Self::Checkerboard => layout::checkerboard(size_px),
            Self::Crosshair => layout::crosshair(size_px),
            Self::Border => layout::border(size_px),
            Self::Ramp => layout::ramp(size_px),
            Self::Name => layout::name(size_px, monitor),
            Self::Orientation => marks::orientation(size_px),
        }
    }
}

impl FromStr for TestImage {
    type Err = UnknownTestImage;

    fn from_str(name: &str) -> Result<Self, UnknownTestImage> {
        Self::ALL.into_iter().find(|image| image.name() == name).ok_or_else(|| UnknownTestImage(name.to_owned()))
    }
}

#[cfg(test)]
mod tests;
