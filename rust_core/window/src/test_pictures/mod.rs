//! Test pictures for a projector, drawn in its own resolution, so that each pixel of a picture is one of the
//! projector's: what is wrong with the set-up (scaling, overscan, keystone correction, mirroring, the wrong screen) is
//! seen on the wall. Levels of grey only, for cameras of any kind.

mod canvas;
mod layout;
mod marks;

use std::str::FromStr;

use rcs_scene::Picture;

use canvas::{Anchor, Canvas, BLACK, WHITE};
pub use layout::identification;
pub use marks::{orientation_marks, OrientationMark};

/// A test picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum TestPicture {
    /// Lines with their coordinates: where on a thing which pixel lands. Straight on a plane unless the lens distorts.
    Grid,
    /// Squares: sharpness and scaling.
    Checkerboard,
    /// Lines through the middle of the picture, with a scale.
    Crosshair,
    /// The outermost pixels, and stripes a pixel wide: overscan and scaling.
    Border,
    /// All levels of grey: brightness, contrast, gamma.
    Ramp,
    /// The monitor's name and resolution: which screen this is.
    Name,
    /// Marks that differ: mirroring and rotation, for eyes and for cameras, see [`orientation_marks`].
    Orientation,
}

/// A name that no test picture has.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("there is no test picture '{0}'")]
pub struct UnknownTestPicture(String);

impl TestPicture {
    /// All, in the order in which they are shown.
    pub const ALL: [Self; 7] =
        [Self::Name, Self::Border, Self::Orientation, Self::Grid, Self::Checkerboard, Self::Crosshair, Self::Ramp];

    /// Its name on command lines and of files.
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

    /// The picture in a resolution. `monitor` is the name that [`Self::Name`] shows.
    ///
    /// ```
    /// use rcs_window::test_pictures::TestPicture;
    ///
    /// let border = TestPicture::Border.draw([1280, 800], "HDMI-1");
    /// assert_eq!((border.data[0], border.data[1280 + 1]), (255, 0));
    /// ```
    pub fn draw(self, size_px: [u32; 2], monitor: &str) -> Picture {
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

impl FromStr for TestPicture {
    type Err = UnknownTestPicture;

    fn from_str(name: &str) -> Result<Self, UnknownTestPicture> {
        Self::ALL.into_iter().find(|picture| picture.name() == name).ok_or_else(|| UnknownTestPicture(name.to_owned()))
    }
}

#[cfg(test)]
mod tests;
