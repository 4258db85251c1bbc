//! Demosaicing of Bayer images.
//!
//! Bilinear, rounded half up, with the outermost rows and columns copied from their neighbours, as OpenCV's `cvtColor`,
//! which `image_view` and `image_proc` use.

use crate::Image;

/// Place of the red pixel in the first two rows and columns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Mosaic {
    /// Column of red, 0 or 1.
    red_u: usize,
    /// Row of red, 0 or 1.
    red_v: usize,
    /// `true` for sixteen bits a pixel.
    is_wide: bool,
}

impl Mosaic {
    /// Mosaic of an encoding of `sensor_msgs/image_encodings.h`.
    fn of(encoding: &str) -> Option<Self> {
        let (pattern, is_wide) = match encoding.strip_prefix("bayer_")?.split_at_checked(4)? {
            (pattern, "8") => (pattern, false),
            (pattern, "16") => (pattern, true),
            _ => return None,
        };
        let (red_u, red_v) = match pattern {
            "rggb" => (0, 0),
            "grbg" => (1, 0),
            "gbrg" => (0, 1),
            "bggr" => (1, 1),
            _ => return None,
        };
        Some(Self { red_u, red_v, is_wide })
    }
}

/// A level for each pixel, row by row.
struct Levels {
    levels: Vec<u32>,
    width: usize,
}

impl Levels {
    fn at(&self, u: usize, v: usize) -> u32 {
        self.levels.get(v * self.width + u).copied().unwrap_or(0)
    }

    /// Rounded mean of neighbours of a pixel that is not at the border.
    fn mean<const N: usize>(&self, [u, v]: [usize; 2], offsets: [[isize; 2]; N]) -> u32 {
        let sum: u32 =
            offsets.iter().map(|[du, dv]| self.at(u.wrapping_add_signed(*du), v.wrapping_add_signed(*dv))).sum();
        (sum + N as u32 / 2) / N as u32
    }

    /// Red, green and blue of a pixel that is not at the border.
    fn color(&self, [u, v]: [usize; 2], mosaic: Mosaic) -> [u32; 3] {
        const BESIDE: [[isize; 2]; 2] = [[-1, 0], [1, 0]];
        const ABOVE: [[isize; 2]; 2] = [[0, -1], [0, 1]];
        const AROUND: [[isize; 2]; 4] = [[-1, 0], [1, 0], [0, -1], [0, 1]];
        const CORNERS: [[isize; 2]; 4] = [[-1, -1], [1, -1], [-1, 1], [1, 1]];
        let (own, at) = (self.at(u, v), [u, v]);
        match (u % 2 == mosaic.red_u, v % 2 == mosaic.red_v) {
            (true, true) => [own, self.mean(at, AROUND), self.mean(at, CORNERS)],
            (false, false) => [self.mean(at, CORNERS), self.mean(at, AROUND), own],
            (false, true) => [self.mean(at, BESIDE), own, self.mean(at, ABOVE)],
            (true, false) => [self.mean(at, ABOVE), own, self.mean(at, BESIDE)],
        }
    }
}

impl Image {
    /// Red, green and blue of a `bayer_*` image, one byte each, row by row; `None` for other encodings.
    ///
    /// Sixteen bits are scaled to eight. An image of fewer than three rows or columns is black.
    ///
    /// # Errors
    /// The data are shorter than the image's size and step need.
    ///
    /// ```
    /// use rcs_messages::{std_msgs::Header, Image};
    /// use std::sync::Arc;
    ///
    /// let red = [200, 0, 200, 0, 0, 0, 0, 0, 200, 0, 200, 0, 0, 0, 0, 0];
    /// let image = Image::new(Header::default(), [4, 4], "bayer_rggb8", 4, Arc::new(red.to_vec()));
    /// let rgb = image.demosaic().expect("a mosaic")?;
    /// assert_eq!((rgb.len(), &rgb[..3]), (48, &[200, 0, 0][..]));
    /// # Ok::<(), String>(())
    /// ```
    pub fn demosaic(&self) -> Option<Result<Vec<u8>, String>> {
        let mosaic = Mosaic::of(&self.encoding)?;
        Some(self.rows(if mosaic.is_wide { 2 } else { 1 }).map(|rows| self.colors(rows, mosaic)))
    }

    fn colors<'a>(&self, rows: impl Iterator<Item = &'a [u8]>, mosaic: Mosaic) -> Vec<u8> {
        let (width, height) = (self.width as usize, self.height as usize);
        if width < 3 || height < 3 {
            return vec![0; 3 * width * height];
        }
        let mut levels = Vec::with_capacity(width * height);
        for row in rows {
            if mosaic.is_wide {
                levels.extend(row.as_chunks().0.iter().map(|level| u32::from(self.u16_of(*level))));
            } else {
                levels.extend(row.iter().map(|level| u32::from(*level)));
            }
        }
        let levels = Levels { levels, width };
        let narrow = |level: u32| if mosaic.is_wide { (level + 128) / 257 } else { level } as u8;
        let pixels = (0..height).flat_map(|v| (0..width).map(move |u| [u, v]));
        pixels
            .map(|[u, v]| levels.color([u.clamp(1, width - 2), v.clamp(1, height - 2)], mosaic))
            .flat_map(|color| color.map(narrow))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::std_msgs::Header;
    use std::sync::Arc;

    /// An encoding, a mosaic of 6 x 4 pixels, and blue, green and red of its inner pixels as OpenCV 4.6 computes them.
    type Case = (&'static str, [u8; 24], [[u8; 3]; 8]);

    const CASES: [Case; 4] = [
        (
            "bayer_rggb8",
            [
                32, 8, 84, 205, 50, 79, 169, 64, 108, 211, 24, 113, 234, 20, 44, 15, 158, 219, 142, 243, 19, 251, 154,
                235,
            ],
            [
                [64, 76, 99],
                [138, 108, 64],
                [211, 88, 84],
                [162, 24, 104],
                [154, 20, 139],
                [192, 41, 44],
                [231, 15, 101],
                [203, 103, 158],
            ],
        ),
        (
            "bayer_bggr8",
            [
                86, 135, 227, 53, 175, 110, 188, 243, 34, 100, 228, 32, 147, 195, 24, 211, 229, 94, 166, 175, 231, 133,
                79, 63,
            ],
            [
                [121, 138, 243],
                [126, 34, 172],
                [164, 132, 100],
                [202, 228, 66],
                [86, 195, 209],
                [24, 168, 163],
                [127, 211, 117],
                [229, 153, 82],
            ],
        ),
        (
            "bayer_gbrg8",
            [
                113, 87, 160, 42, 202, 194, 216, 226, 158, 145, 68, 64, 188, 244, 206, 145, 167, 163, 209, 156, 150,
                38, 169, 202,
            ],
            [
                [166, 226, 187],
                [130, 184, 158],
                [94, 145, 113],
                [136, 145, 68],
                [244, 194, 183],
                [195, 206, 154],
                [145, 139, 136],
                [154, 167, 119],
            ],
        ),
        (
            "bayer_grbg8",
            [
                205, 70, 153, 230, 240, 48, 178, 190, 44, 105, 182, 0, 86, 247, 16, 19, 9, 112, 220, 51, 111, 138, 123,
                68,
            ],
            [
                [111, 190, 159],
                [44, 116, 142],
                [113, 105, 125],
                [182, 89, 102],
                [138, 86, 247],
                [78, 16, 133],
                [115, 67, 19],
                [153, 9, 66],
            ],
        ),
    ];

    #[test]
    fn a_mosaics_colors_are_those_of_opencv_and_the_border_is_its_neighbours() {
        for (encoding, mosaic, inner_bgr) in CASES {
            let image = Image::new(Header::default(), [6, 4], encoding, 6, Arc::new(mosaic.to_vec()));
            let rgb = image.demosaic().unwrap().unwrap();
            for v in 0..4_usize {
                for u in 0..6_usize {
                    let [b, g, r] = inner_bgr[(v.clamp(1, 2) - 1) * 4 + u.clamp(1, 4) - 1];
                    assert_eq!(rgb[(v * 6 + u) * 3..][..3], [r, g, b], "{encoding} ({u}, {v})");
                }
            }
            let wide = mosaic.iter().flat_map(|level| (u16::from(*level) * 257).to_be_bytes()).collect();
            let mut image =
                Image::new(Header::default(), [6, 4], &format!("{}16", &encoding[..10]), 12, Arc::new(wide));
            image.is_bigendian = 1;
            let narrowed = image.demosaic().unwrap().unwrap();
            assert!(narrowed.iter().zip(&rgb).all(|(a, b)| a.abs_diff(*b) <= 1), "{encoding} of sixteen bits");
        }
    }

    #[test]
    fn other_encodings_short_data_and_tiny_images_are_no_mosaics() {
        let image =
            |encoding, size, bytes| Image::new(Header::default(), size, encoding, size[0], Arc::new(vec![9; bytes]));
        for encoding in ["mono8", "bayer_", "bayer_rggb", "bayer_rgbg8", "bayer_rggb32", "bayer_äää8"] {
            assert!(image(encoding, [4, 4], 16).demosaic().is_none(), "{encoding}");
        }
        assert!(image("bayer_rggb8", [4, 4], 15).demosaic().unwrap().is_err());
        assert_eq!(image("bayer_rggb8", [2, 4], 8).demosaic(), Some(Ok(vec![0; 24])));
    }
}
