//! Points, triangles or lines ("things") sorted into the bands that they touch.
//!
//! Only the things' indices are kept, in their order; one that touches two bands is there twice. All memory is reused
//! for the next image.

use super::screen::Screen;

/// Bands are counted in 2^24 parts of one.
const PART_BITS: u32 = 24;

/// Things by band.
#[derive(Debug, Default)]
pub(in crate::cpu) struct Bins {
    bands: Vec<Vec<u32>>,
    /// Factor from a row to its band, in parts of 2^24: images have at most 2^14 rows, bands at most 128.
    bands_per_row: u64,
    height_px: u32,
}

impl Bins {
    /// Forgets everything, and has a bin for each of the image's bands.
    pub(in crate::cpu) fn reset(&mut self, screen: &Screen) {
        self.bands.iter_mut().for_each(Vec::clear);
        self.bands.resize_with(screen.bands(), Vec::new);
        self.height_px = screen.height_px;
        self.bands_per_row = (1_u64 << PART_BITS).div_ceil(screen.band_rows() as u64);
    }

    /// Adds a thing that touches these rows; rows outside of the image have no band.
    #[inline(always)]
    pub(in crate::cpu) fn add(&mut self, number: u32, begin_row: u32, end_row: u32) {
        if begin_row >= end_row {
            return;
        }
        let band = |row: u32| (u64::from(row) * self.bands_per_row) >> PART_BITS;
        for band in band(begin_row)..=band(end_row - 1) {
            if let Some(band) = self.bands.get_mut(band as usize) {
                band.push(number);
            }
        }
    }

    /// As [`Self::add`], for rows that may be outside of the image.
    #[inline(always)]
    pub(in crate::cpu) fn add_rows(&mut self, number: u32, (begin, end): (i32, i32)) {
        let row = |row: i32| row.clamp(0, self.height_px as i32) as u32;
        self.add(number, row(begin), row(end));
    }

    /// The things that touch a band, in their order.
    pub(in crate::cpu) fn band(&self, index: usize) -> &[u32] {
        self.bands.get(index).map_or(&[], Vec::as_slice)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn things_keep_their_order_in_every_band_they_touch() {
        let screen = Screen::new(640, 200, 2);
        assert_eq!((screen.band_rows(), screen.bands()), (50, 4));
        let mut bins = Bins::default();
        bins.reset(&screen);
        for (thing, begin_row, end_row) in [('a', 190, 200), ('b', 45, 55), ('-', 50, 50), ('c', 0, 1), ('d', 0, 200)] {
            bins.add(thing as u32, begin_row, end_row);
        }
        let names = |band: usize| bins.band(band).iter().filter_map(|&t| char::from_u32(t)).collect::<String>();
        assert_eq!([names(0), names(1), names(2), names(3), names(4)], ["bcd", "bd", "d", "ad", ""]);
        bins.reset(&screen);
        assert!(bins.band(0).is_empty());
    }

    #[test]
    fn a_row_is_in_the_band_of_its_quotient() {
        for (width, height) in [(640, 480), (640, 360), (320, 200), (1280, 800), (16384, 16384), (1, 16384), (1, 1)] {
            for workers in [1, 2, 3, 100] {
                let screen = Screen::new(width, height, workers);
                let mut bins = Bins::default();
                bins.reset(&screen);
                (0..height).for_each(|row| bins.add(row, row, row + 1));
                for index in 0..screen.bands() {
                    let rows = index * screen.band_rows()..(height as usize).min((index + 1) * screen.band_rows());
                    let in_band = bins.band(index).iter().map(|&row| row as usize);
                    assert!(in_band.eq(rows), "{width}x{height}, {workers} workers, band {index}");
                }
            }
        }
    }
}
