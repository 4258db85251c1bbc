//! A finished image mirrored along its rows, its columns or both.
//!
//! A CameraInfo whose P has a negative focal length describes a mirrored image. It is drawn without the mirror, so
//! that faces keep their winding, and is flipped when it is finished.

use rayon::prelude::*;

use crate::{DepthImage, Image};

/// Sides along which an image is mirrored.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Flip {
    /// Left and right are swapped.
    pub is_left_right: bool,
    /// Top and bottom are swapped.
    pub is_up_down: bool,
}

impl Flip {
    /// Leaves images as they are.
    pub const NONE: Self = Self { is_left_right: false, is_up_down: false };

    /// Place of a pixel of an image of this size in the flipped one; an integer is a pixel's centre.
    pub fn pixel(self, [width_px, height_px]: [u32; 2], [u, v]: [f64; 2]) -> [f64; 2] {
        [
            if self.is_left_right { f64::from(width_px) - 1.0 - u } else { u },
            if self.is_up_down { f64::from(height_px) - 1.0 - v } else { v },
        ]
    }

    /// Row of an image of this height at a row of the flipped one.
    pub fn row(self, height: usize, row: usize) -> usize {
        match self.is_up_down {
            true => height.saturating_sub(row + 1),
            false => row,
        }
    }

    /// Flips an image in place.
    pub fn image(self, image: &mut Image) {
        self.bytes(image.width_px, image.encoding.bytes_per_pixel(), &mut image.data);
    }

    /// Flips the depths of an image in place.
    pub fn depth(self, depth: &mut DepthImage) {
        self.cells(depth.width_px, &mut depth.depths_m);
    }

    /// Flips an image of 1 to 4 bytes for each pixel in place: rows of `width_px` pixels without padding.
    pub fn bytes(self, width_px: u32, bytes_per_pixel: usize, data: &mut [u8]) {
        match bytes_per_pixel {
            1 => self.cells(width_px, data),
            2 => self.cells(width_px, data.as_chunks_mut::<2>().0),
            3 => self.cells(width_px, data.as_chunks_mut::<3>().0),
            _ => self.cells(width_px, data.as_chunks_mut::<4>().0),
        }
    }

    /// Flips an image of one cell for each pixel in place: rows of `width_px` cells.
    pub fn cells<T: Send>(self, width_px: u32, cells: &mut [T]) {
        let width = width_px as usize;
        if width == 0 || self == Self::NONE {
            return;
        }
        let reverse = |row: &mut [T]| {
            if self.is_left_right {
                row.reverse();
            }
        };
        let rows = cells.len() / width;
        let (upper, rest) = cells.split_at_mut(rows / 2 * width);
        let (middle, lower) = rest.split_at_mut(rows % 2 * width);
        reverse(middle);
        upper.par_chunks_mut(width).zip(lower.par_chunks_mut(width).rev()).for_each(|(above, below)| {
            reverse(above);
            reverse(below);
            if self.is_up_down {
                above.swap_with_slice(below);
            }
        });
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::Encoding;

    proptest! {
        #[test]
        fn each_pixel_is_where_the_mirror_shows_it(
            width in 1..9_u32, height in 1..9_u32, which in 0..6_usize, is_left_right: bool, is_up_down: bool,
        ) {
            let flip = Flip { is_left_right, is_up_down };
            let (mut image, mut depth) = (Image::default(), DepthImage::default());
            image.reset(width, height, Encoding::ALL[which]);
            (0..).zip(&mut image.data).for_each(|(at, byte)| *byte = at);
            depth.reset(width, height);
            (0_u16..).zip(&mut depth.depths_m).for_each(|(at, depth_m)| *depth_m = f32::from(at));
            let (before, depth_before) = (image.clone(), depth.clone());
            flip.image(&mut image);
            flip.depth(&mut depth);
            let cell = image.encoding.bytes_per_pixel();
            for (row, column) in (0..height).flat_map(|row| (0..width).map(move |column| (row, column))) {
                let [u, v] = flip.pixel([width, height], [column, row].map(f64::from));
                let (from, to) = ((row * width + column) as usize, (v as u32 * width + u as u32) as usize);
                prop_assert_eq!(&image.data[to * cell..][..cell], &before.data[from * cell..][..cell]);
                prop_assert_eq!(depth.depths_m[to], depth_before.depths_m[from]);
                prop_assert_eq!(flip.row(height as usize, row as usize), v as usize);
            }
        }
    }
}
