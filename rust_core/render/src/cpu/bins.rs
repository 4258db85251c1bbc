//! Points, triangles or lines ("things") sorted into the bands that they touch.
//!
//! Only the things' indices are kept, in their order; one that touches two bands is there twice. All memory is reused
//! for the next picture.

use super::screen::Screen;

/// Things by band.
#[derive(Debug, Default)]
pub(super) struct Bins {
    bands: Vec<Vec<u32>>,
    band_rows: u32,
}

impl Bins {
    /// Forgets everything, and has a bin for each of the picture's bands.
    pub(super) fn reset(&mut self, screen: &Screen) {
        self.bands.iter_mut().for_each(Vec::clear);
        self.bands.resize_with(screen.bands(), Vec::new);
        self.band_rows = screen.band_rows() as u32;
    }

    /// Adds a thing that touches these rows; rows outside of the picture have no band.
    #[inline(always)]
    pub(super) fn add(&mut self, number: u32, begin_row: u32, end_row: u32) {
        if begin_row >= end_row {
            return;
        }
        for band in begin_row / self.band_rows..=(end_row - 1) / self.band_rows {
            if let Some(band) = self.bands.get_mut(band as usize) {
                band.push(number);
            }
        }
    }

    /// All things, those that touch several bands several times.
    pub(super) fn all(&self) -> impl Iterator<Item = u32> + '_ {
        self.bands.iter().flatten().copied()
    }

    /// The things that touch a band, in their order.
    pub(super) fn band(&self, index: usize) -> &[u32] {
        self.bands.get(index).map_or(&[], Vec::as_slice)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn things_keep_their_order_in_every_band_they_touch() {
        let screen = Screen::new(640, 200);
        assert_eq!((screen.band_rows(), screen.bands()), (50, 4));
        let mut bins = Bins::default();
        bins.reset(&screen);
        for (thing, begin_row, end_row) in [('a', 190, 200), ('b', 45, 55), ('-', 50, 50), ('c', 0, 1), ('d', 0, 200)] {
            bins.add(thing as u32, begin_row, end_row);
        }
        let names = |band: usize| bins.band(band).iter().filter_map(|&t| char::from_u32(t)).collect::<String>();
        assert_eq!([names(0), names(1), names(2), names(3), names(4)], ["bcd", "bd", "d", "ad", ""]);
        assert_eq!(bins.all().count(), 8);
        bins.reset(&screen);
        assert!(bins.band(0).is_empty());
    }
}
