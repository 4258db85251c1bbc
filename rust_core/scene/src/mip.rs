//! Mipmap levels of images.

use crate::Texture;

impl Texture {
    /// The next smaller level of the image; `None` for a single texel.
    ///
    /// Each texel is the mean of two by two, rounded. Of odd sides the last row or column is left out; texels that are
    /// missing are white.
    pub fn halved(&self) -> Option<Self> {
        if self.width.max(self.height) <= 1 {
            return None;
        }
        let [width, height] = [self.width, self.height].map(|side| (side / 2).max(1));
        let texel = |x: u32, y: u32| {
            let x = x.min(self.width.saturating_sub(1)) as usize;
            let y = y.min(self.height.saturating_sub(1)) as usize;
            self.rgba.get(y * self.width as usize + x).copied().unwrap_or([255; 4])
        };
        let texels = (0..height).flat_map(|y| (0..width).map(move |x| [2 * x, 2 * y]));
        let mean = |[x, y]: [u32; 2]| {
            let [a, b, c, d] =
                [[x, y], [x + 1, y], [x, y + 1], [x + 1, y + 1]].map(|[x, y]| texel(x, y).map(u16::from));
            [0, 1, 2, 3].map(|i| ((a[i] + b[i] + c[i] + d[i] + 2) / 4) as u8)
        };
        Some(Self { width, height, rgba: texels.map(mean).collect(), ..*self })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Filtering, Wrapping};

    fn texture(width: u32, height: u32, levels: &[u8]) -> Texture {
        let rgba = levels.iter().map(|level| [*level; 4]).collect();
        Texture { width, height, rgba, filtering: Filtering::BilinearMipmap, wrapping: Wrapping::Repeat }
    }

    #[test]
    fn a_level_is_the_mean_of_four() {
        let half = texture(4, 2, &[0, 10, 20, 30, 40, 50, 60, 70]).halved().unwrap();
        assert_eq!(half, texture(2, 1, &[25, 45]));
        assert_eq!(half.halved(), Some(texture(1, 1, &[35])));
        assert_eq!(texture(1, 1, &[35]).halved(), None);
    }

    #[test]
    fn of_odd_sides_the_last_is_left_out_and_missing_texels_are_white() {
        assert_eq!(texture(3, 1, &[0, 10, 20]).halved(), Some(texture(1, 1, &[5])));
        assert_eq!(texture(2, 2, &[0, 10]).halved(), Some(texture(1, 1, &[130])));
    }
}
