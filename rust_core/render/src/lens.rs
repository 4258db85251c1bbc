//! Through a lens: the picture of a [`PixelMap`], taken from what was drawn without one.

use rayon::prelude::*;
use rcs_scene::{DepthPicture, Encoding, MapRun, Picture, PixelMap};

/// Rows that a thread takes at once.
const ROWS: usize = 16;

/// Writes the picture that a lens makes of `drawn`, an [`Encoding::Rgba8`] picture of the map's source. Colours between
/// pixels are interpolated, so that edges and lines are where they are, not at the nearest pixel; what the lens does
/// not show has the background's colour.
pub(crate) fn see_through(
    map: &PixelMap,
    drawn: &Picture,
    background: [u8; 3],
    encoding: Encoding,
    picture: &mut Picture,
) {
    let [width, height] = map.size_px();
    picture.reset(width, height, encoding);
    let step = picture.step();
    let [r, g, b] = background;
    let source = Source { bytes: &drawn.data, step: drawn.step() };
    let strips = picture.data.par_chunks_mut(step * ROWS).enumerate();
    strips.for_each_init(Vec::new, |pixels, (strip, rows)| {
        for (row, bytes) in rows.chunks_mut(step).enumerate() {
            pixels.clear();
            pixels.resize(width as usize, [r, g, b, 255]);
            for run in map.runs((strip * ROWS + row) as u32) {
                source.write(run, pixels);
            }
            encoding.write_row(pixels, bytes);
        }
    });
}

/// Writes the depths that a lens makes of `drawn`: each pixel has that of the nearest one, for a depth between two is
/// nowhere.
pub(crate) fn see_depth_through(map: &PixelMap, drawn: &DepthPicture, depth: &mut DepthPicture) {
    let [width, height] = map.size_px();
    depth.reset(width, height);
    let rows = depth.depths_m.par_chunks_mut((width as usize).max(1)).enumerate();
    rows.for_each(|(row, pixels)| {
        for MapRun { column, len, place, step } in map.runs(row as u32) {
            let Some(pixels) = pixels.get_mut(column as usize..(column + len) as usize) else { continue };
            for (index, pixel) in (0..).zip(pixels) {
                let nearest = [0, 1].map(|axis| (place[axis] + index * step[axis] + (1 << 15)) >> 16);
                let at = nearest[1] as usize * drawn.width_px as usize + nearest[0] as usize;
                *pixel = drawn.depths_m.get(at).copied().unwrap_or(f32::NAN);
            }
        }
    });
}

/// What was drawn, four bytes for each pixel, row by row.
#[derive(Clone, Copy)]
struct Source<'a> {
    bytes: &'a [u8],
    /// Bytes of a row.
    step: usize,
}

impl Source<'_> {
    /// Writes a run's pixels into their row.
    #[inline(always)]
    fn write(&self, run: MapRun, row: &mut [[u8; 4]]) {
        let MapRun { column, len, place: [mut x, mut y], step } = run;
        let Some(pixels) = row.get_mut(column as usize..).and_then(|row| row.get_mut(..len as usize)) else { return };
        for pixel in pixels {
            *pixel = self.color([x, y]);
            (x, y) = (x + step[0], y + step[1]);
        }
    }

    /// The colour at a place in 1/65536 pixels; black beside the source, where no map leads.
    #[inline(always)]
    fn color(&self, [x, y]: [i32; 2]) -> [u8; 4] {
        let at = (y >> 16) as usize * self.step + (x >> 16) as usize * 4;
        let pair =
            |at: usize| self.bytes.get(at..).and_then(<[u8]>::first_chunk).map(|bytes| u64::from_le_bytes(*bytes));
        let (Some(above), Some(below)) = (pair(at), pair(at + self.step)) else { return [0, 0, 0, 255] };
        // The first and the third channel of both pixels, and the second and the fourth.
        let even = between(above & BYTES, below & BYTES, y);
        let odd = between(above >> 8 & BYTES, below >> 8 & BYTES, y);
        let (left, right) = (even & LOW | odd << 32, even >> 32 | odd & !LOW);
        let color = between(left, right, x);
        ((color | color >> 24) as u32).to_le_bytes()
    }
}

/// The lowest byte of each of four numbers.
const BYTES: u64 = 0x00ff_00ff_00ff_00ff;

/// The lower two numbers.
const LOW: u64 = 0xffff_ffff;

/// Between each of four numbers and another one, by a place's fraction, to the nearest level.
#[inline(always)]
fn between(first: u64, second: u64, place: i32) -> u64 {
    const HALF: u64 = 0x0080_0080_0080_0080;
    let share = u64::from(place as u32 >> 8 & 0xff);
    // What the differences borrow from each other, the sum gives back: each of its numbers fits into its 16 bits.
    let sum = (first << 8).wrapping_add(second.wrapping_sub(first).wrapping_mul(share));
    (sum.wrapping_add(HALF) >> 8) & BYTES
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drawn(width_px: u32, height_px: u32, color: impl Fn(u32, u32) -> [u8; 4]) -> Picture {
        let mut picture = Picture::default();
        picture.reset(width_px, height_px, Encoding::Rgba8);
        let pixels = (0..height_px).flat_map(|y| (0..width_px).map(move |x| (x, y)));
        picture.data = pixels.flat_map(|(x, y)| color(x, y)).collect();
        picture
    }

    fn seen(map: &PixelMap, drawn: &Picture, encoding: Encoding) -> Picture {
        let mut picture = Picture::default();
        see_through(map, drawn, [1, 2, 3], encoding, &mut picture);
        picture
    }

    #[test]
    fn colours_between_pixels_are_interpolated() {
        let map = PixelMap::new([20, 10], |[u, v]| Some([u + 0.25, v + 0.5])).unwrap();
        let [width, height] = map.source_size_px();
        let source = drawn(width, height, |x, y| [(4 * x) as u8, (10 * y) as u8, 200, 255]);
        let picture = seen(&map, &source, Encoding::Rgb8);
        let [left, top] = map.source_origin_px();
        for (at, pixel) in picture.data.as_chunks::<3>().0.iter().enumerate() {
            let (x, y) = ((at % 20) as i32 - left, (at / 20) as i32 - top);
            assert_eq!(*pixel, [(4 * x + 1) as u8, (10 * y + 5) as u8, 200]);
        }
    }

    #[test]
    fn depths_are_those_of_the_nearest_pixel_and_never_between_two() {
        let map = PixelMap::new([20, 10], |[u, v]| (u < 15.0).then_some([u + 0.4, v + 0.6])).unwrap();
        let [width, height] = map.source_size_px();
        let mut drawn = DepthPicture::default();
        drawn.reset(width, height);
        for (at, depth) in (0..).zip(&mut drawn.depths_m) {
            *depth = if (at % width + at / width) % 2 == 0 { 1.0 } else { 9.0 };
        }
        let mut seen = DepthPicture::default();
        see_depth_through(&map, &drawn, &mut seen);
        let [left, top] = map.source_origin_px();
        for (at, depth) in seen.depths_m.iter().enumerate() {
            let (x, y) = ((at % 20) as i32 - left, (at / 20) as i32 + 1 - top);
            match at % 20 {
                0..15 => assert_eq!(*depth, if (x + y) % 2 == 0 { 1.0 } else { 9.0 }, "{at}"),
                _ => assert!(depth.is_nan()),
            }
        }
    }

    #[test]
    fn an_even_surface_keeps_its_colour_and_the_rest_is_background() {
        let place = |[u, v]: [f64; 2]| (u < 12.0).then_some([1.1 * u, 0.93 * v + 0.37]);
        let map = PixelMap::new([33, 21], place).unwrap();
        let [width, height] = map.source_size_px();
        let source = drawn(width, height, |_, _| [10, 255, 99, 255]);
        for encoding in Encoding::ALL {
            let picture = seen(&map, &source, encoding);
            assert_eq!((picture.width_px, picture.height_px), (33, 21));
            let cell = encoding.bytes_per_pixel();
            let mut colors = [vec![0; cell], vec![0; cell]];
            encoding.write_row(&[[10, 255, 99, 255]], &mut colors[0]);
            encoding.write_row(&[[1, 2, 3, 255]], &mut colors[1]);
            for (at, pixel) in picture.data.chunks(cell).enumerate() {
                assert_eq!(pixel, colors[usize::from(at % 33 >= 12)], "{encoding:?}, {at}");
            }
        }
    }
}
