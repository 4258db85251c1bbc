//! A colour as rviz stores it: four channels of 0 to 1, not gamma-corrected.

/// Red, green, blue and alpha of 0 to 1, not premultiplied.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rgba {
    /// Red, 0 to 1.
    pub r: f32,
    /// Green, 0 to 1.
    pub g: f32,
    /// Blue, 0 to 1.
    pub b: f32,
    /// Opacity: 0 is invisible, 1 is opaque.
    pub a: f32,
}

impl Rgba {
    /// Opaque white.
    pub const WHITE: Self = Self::new(1.0, 1.0, 1.0, 1.0);
    /// Opaque black.
    pub const BLACK: Self = Self::new(0.0, 0.0, 0.0, 1.0);
    /// All channels zero.
    pub const TRANSPARENT: Self = Self::new(0.0, 0.0, 0.0, 0.0);

    /// A colour of four channels, each 0 to 1.
    pub const fn new(r: f32, g: f32, b: f32, a: f32) -> Self {
        Self { r, g, b, a }
    }

    /// An 8-bit colour, such as a `.rviz` file's `115; 210; 22`, with an opacity of 0 to 1.
    pub fn from_rgb8(rgb: [u8; 3], alpha: f32) -> Self {
        let [r, g, b] = rgb.map(|c| f32::from(c) / 255.0);
        Self { r, g, b, a: alpha }
    }

    /// Replaces the opacity, 0 to 1.
    pub const fn with_alpha(self, alpha: f32) -> Self {
        Self { a: alpha, ..self }
    }

    /// Four bytes, red first, as Ogre packs vertex colours: each channel times 255 and cut off, not clamped, so that
    /// 1.2 wraps round to 50 and −0.2 to 205, as in rviz. NaN and what no 32-bit integer holds become 0.
    #[inline]
    pub fn to_rgba8(self) -> [u8; 4] {
        let byte = |channel: f32| {
            let level = channel * 255.0;
            if level.abs() < 2_147_483_648.0 {
                level as i32 as u8
            } else {
                0
            }
        };
        [byte(self.r), byte(self.g), byte(self.b), byte(self.a)]
    }

    /// Red, green, blue, alpha.
    pub const fn to_array(self) -> [f32; 4] {
        [self.r, self.g, self.b, self.a]
    }
}

impl From<[f32; 4]> for Rgba {
    fn from([r, g, b, a]: [f32; 4]) -> Self {
        Self { r, g, b, a }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn packing_cuts_off_and_wraps_as_ogre_does() {
        assert_eq!(Rgba::new(1.0, 0.999, 0.5, 0.0).to_rgba8(), [255, 254, 127, 0]);
        assert_eq!(Rgba::new(1.2, -0.2, f32::NAN, f32::INFINITY).to_rgba8(), [50, 205, 0, 0]);
    }
}
