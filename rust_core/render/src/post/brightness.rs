//! The share of each level that an operator wants to see.

use rayon::prelude::*;
use rcs_scene::Image;

use super::factors::{scale_row, ONE};

/// A share of each level, 0 to 1. It can only darken.
///
/// ```
/// use rcs_render::Brightness;
/// use rcs_scene::{Encoding, Image};
///
/// let mut image = Image::default();
/// image.reset(3, 1, Encoding::Mono8);
/// image.data = vec![0, 100, 255];
/// Brightness::new(0.5).unwrap_or(Brightness::DARK).apply(&mut image);
/// assert_eq!(image.data, [0, 50, 128]);
/// assert_eq!([f64::NAN, -0.1, 1.1].map(Brightness::new), [None; 3]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Brightness(u16);

impl Brightness {
    /// All of each level: images stay as they are.
    pub const FULL: Self = Self(ONE);
    /// Black.
    pub const DARK: Self = Self(0);

    /// A share from 0 to 1; `None` for any other number.
    pub fn new(share: f64) -> Option<Self> {
        (0.0..=1.0).contains(&share).then(|| Self((share * f64::from(ONE)).round() as u16))
    }

    /// Scales all levels of an image; alpha stays.
    pub fn apply(self, image: &mut Image) {
        let step = image.step();
        if self == Self::FULL || step == 0 {
            return;
        }
        let (factors, encoding) = (vec![self.0; image.width_px as usize], image.encoding);
        image.data.par_chunks_mut(step).for_each(|row| scale_row(encoding, &factors, row));
    }
}

#[cfg(test)]
mod tests {
    use rcs_scene::Encoding;

    use super::*;

    #[test]
    fn every_encoding_gets_darker_by_the_same_share_and_never_brighter() {
        for encoding in Encoding::ALL {
            let mut image = Image::default();
            image.reset(64, 3, encoding);
            image.data = (0..image.data.len()).map(|index| (index * 7 % 256) as u8).collect();
            let drawn = image.data.clone();
            Brightness::FULL.apply(&mut image);
            assert_eq!(image.data, drawn, "{encoding:?}");
            for share in [0.7, 0.3, 0.0] {
                let mut dimmed = image.clone();
                Brightness::new(share).unwrap().apply(&mut dimmed);
                let levels = |image: &Image, at: usize| match encoding {
                    Encoding::Mono16 => f64::from(u16::from_le_bytes([image.data[2 * at], image.data[2 * at + 1]])),
                    _ => f64::from(image.data[at]),
                };
                let count = drawn.len() / if encoding == Encoding::Mono16 { 2 } else { 1 };
                let has_alpha = matches!(encoding, Encoding::Rgba8 | Encoding::Bgra8);
                for at in 0..count {
                    let is_alpha = has_alpha && at % 4 == 3;
                    let (before, after) = (levels(&image, at), levels(&dimmed, at));
                    let expected = if is_alpha { before } else { share * before };
                    assert!((after - expected).abs() <= 0.51 + before * 2e-5 && after <= before, "{encoding:?} {at}");
                }
            }
        }
    }
}
