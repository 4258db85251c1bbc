//! Warp of a drawn image through the [`PixelMap`] of a lens.
//!
//! Colours between pixels are interpolated, first downwards and then to the right, in 256 steps and to the nearest
//! level. Whole runs of the map are done eight pixels at once ([`eight`]); the rest, and places at the source's first
//! and last pixels, one by one, with the same colours.

mod eight;
#[cfg(test)]
mod tests;

use fearless_simd::prelude::*;
use fearless_simd::{dispatch, Level};
use rayon::prelude::*;
use rcs_scene::{DepthImage, Encoding, Image, MapRun, PixelMap};

/// Rows that a thread takes at once.
const ROWS: usize = 16;

/// Warps `drawn`, an [`Encoding::Rgba8`] image of the map's source. Colours between pixels are interpolated; pixels
/// without a place have the background's colour.
pub fn see_through(map: &PixelMap, drawn: &Image, background: [u8; 3], encoding: Encoding, image: &mut Image) {
    let [width, height] = map.size_px();
    image.reset(width, height, encoding);
    write_through(map, drawn, background, encoding, &mut image.data);
}

/// [`see_through`] into borrowed bytes: rows from the top, without padding. Surplus rows are left out.
pub fn write_through(map: &PixelMap, drawn: &Image, background: [u8; 3], encoding: Encoding, to: &mut [u8]) {
    let width = map.size_px()[0] as usize;
    let step = (width * encoding.bytes_per_pixel()).max(1);
    let [r, g, b] = background;
    let (source, level) = (Source::new(drawn), Level::new());
    let strips = to.par_chunks_mut(step * ROWS).enumerate();
    strips.for_each_init(Vec::new, |pixels, (strip, rows)| {
        for (row, bytes) in rows.chunks_mut(step).enumerate() {
            pixels.clear();
            pixels.resize(width, [r, g, b, 255]);
            let row = (strip * ROWS + row) as u32;
            dispatch!(level, simd => source.write_row(simd, map, row, pixels));
            encoding.write_row(pixels, bytes);
        }
    });
}

/// Warps depths: each pixel has that of the nearest one, because a depth between two is on no surface.
pub fn see_depth_through(map: &PixelMap, drawn: &DepthImage, depth: &mut DepthImage) {
    let [width, height] = map.size_px();
    depth.reset(width, height);
    write_depth_through(map, drawn, &mut depth.depths_m);
}

/// [`see_depth_through`] into borrowed depths. Surplus rows are left out.
pub fn write_depth_through(map: &PixelMap, drawn: &DepthImage, to: &mut [f32]) {
    let rows = to.par_chunks_mut((map.size_px()[0] as usize).max(1)).enumerate();
    rows.for_each(|(row, pixels)| {
        pixels.fill(f32::NAN);
        let (columns, runs) = map.runs(row as u32);
        let pixels = pixels.get_mut(columns.start as usize..columns.end as usize).unwrap_or_default();
        for (pixels, MapRun { place, step }) in pixels.chunks_mut(MapRun::PIXELS).zip(runs) {
            for (index, pixel) in (0..).zip(pixels) {
                let nearest = [0, 1].map(|axis| (place[axis] + index * step[axis] + (1 << 15)) >> 16);
                let at = nearest[1] as usize * drawn.width_px as usize + nearest[0] as usize;
                *pixel = drawn.depths_m.get(at).copied().unwrap_or(f32::NAN);
            }
        }
    });
}

/// The drawn image, four bytes for each pixel, row by row.
#[derive(Clone, Copy)]
struct Source<'a> {
    bytes: &'a [u8],
    /// `bytes` from the second row on.
    below: &'a [u8],
    /// Pixels of a row.
    width: i32,
}

impl<'a> Source<'a> {
    fn new(drawn: &'a Image) -> Self {
        let below = drawn.data.get(drawn.step()..).unwrap_or(&[]);
        Self { bytes: &drawn.data, below, width: drawn.width_px as i32 }
    }

    /// Writes the pixels of the map's row that have a place.
    #[inline(always)]
    fn write_row<S: Simd>(&self, simd: S, map: &PixelMap, row: u32, pixels: &mut [[u8; 4]]) {
        let (columns, mut runs) = map.runs(row);
        let Some(pixels) = pixels.get_mut(columns.start as usize..columns.end as usize) else { return };
        let (whole, rest) = pixels.as_chunks_mut::<{ MapRun::PIXELS }>();
        for pixels in whole {
            let Some(run) = runs.next() else { return };
            if eight::write(simd, self, run, pixels).is_none() {
                self.write_singly(run, pixels);
            }
        }
        if let Some(run) = runs.next() {
            self.write_singly(run, rest);
        }
    }

    /// Writes a run's pixels.
    #[inline(never)]
    fn write_singly(&self, run: MapRun, pixels: &mut [[u8; 4]]) {
        let MapRun { place: [mut x, mut y], step } = run;
        for pixel in pixels {
            *pixel = self.color([x, y]);
            (x, y) = (x + step[0], y + step[1]);
        }
    }

    /// Colour at a place in 1/65536 pixels; black beside the source.
    fn color(&self, [x, y]: [i32; 2]) -> [u8; 4] {
        let at = self.index([x, y]) as u32 as usize * 4;
        let pair = |bytes: &[u8]| bytes.get(at..).and_then(|bytes| bytes.first_chunk::<8>().copied());
        let (Some(above), Some(below)) = (pair(self.bytes), pair(self.below)) else { return [0, 0, 0, 255] };
        let mixed = |channel: usize| {
            let [left, right] = [channel, channel + 4].map(|i| between(above[i], below[i], y));
            between(left, right, x)
        };
        [0, 1, 2, 3].map(mixed)
    }

    /// Index of the pixel to the left of and above a place.
    #[inline(always)]
    fn index(&self, [x, y]: [i32; 2]) -> i32 {
        (y >> 16) * self.width + (x >> 16)
    }
}

/// Interpolates two levels by a place's fraction, to the nearest level.
fn between(first: u8, second: u8, place: i32) -> u8 {
    let (first, second, share) = (i32::from(first), i32::from(second), place >> 8 & 0xff);
    ((first * 256 + (second - first) * share + 128) >> 8) as u8
}
