//! Light masks: an image over the projector's image, dark where there must be none.

use super::factors::ONE;

/// A grey image that is laid over the whole image: 0 no light, 255 all of it, in between that share.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LightMask {
    size_px: [u32; 2],
    /// Row by row, without gaps.
    levels: Vec<u8>,
}

impl LightMask {
    /// The mask of `width × height` levels, row by row. None where there are more or fewer, or none at all.
    ///
    /// A mask of another size than the image is stretched over it; a pixel of the image that lies on several of the
    /// mask's takes the darkest.
    pub fn new(size_px: [u32; 2], levels: Vec<u8>) -> Option<Self> {
        let count = size_px[0] as usize * size_px[1] as usize;
        (count > 0 && levels.len() == count).then_some(Self { size_px, levels })
    }

    /// Width and height.
    pub fn size_px(&self) -> [u32; 2] {
        self.size_px
    }

    /// Levels, row by row.
    pub fn levels(&self) -> &[u8] {
        &self.levels
    }

    /// Lowers the factors of a row of the image.
    pub(super) fn write(&self, image_px: [u32; 2], row: usize, factors: &mut [u16]) {
        let width = self.size_px[0] as usize;
        let rows = covered(row, image_px[1] as usize, self.size_px[1] as usize);
        for row in rows {
            let Some(levels) = self.levels.get(row * width..(row + 1) * width) else { continue };
            if self.size_px[0] == image_px[0] {
                lower(factors, levels);
            } else {
                for (column, factor) in factors.iter_mut().enumerate() {
                    let columns = covered(column, image_px[0] as usize, width);
                    let darkest = levels.get(columns).and_then(|levels| levels.iter().min().copied());
                    *factor = (*factor).min(factor_of(darkest.unwrap_or(0)));
                }
            }
        }
    }
}

/// The pixels of a side of the mask that a pixel of the image's side lies on.
fn covered(at: usize, image: usize, mask: usize) -> std::ops::Range<usize> {
    let image = image.max(1);
    at * mask / image..((at + 1) * mask).div_ceil(image).min(mask)
}

fn lower(factors: &mut [u16], levels: &[u8]) {
    for (factor, level) in factors.iter_mut().zip(levels) {
        *factor = (*factor).min(factor_of(*level));
    }
}

/// The factor of a level; that of 255 is exactly one, and no other one is more than its share.
fn factor_of(level: u8) -> u16 {
    (u32::from(level) * u32::from(ONE) / 255) as u16
}
