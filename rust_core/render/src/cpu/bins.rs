//! Things sorted into the bands that they touch.
//!
//! A counting sort: things of one band stand together and keep their order; a thing that touches two bands is there
//! twice. All memory is used again for the next picture.

use super::screen::Screen;

/// Something that touches rows of the picture.
pub(super) trait Rows {
    /// The first row and the row after the last; never empty and never outside of the picture.
    fn rows(&self) -> (i32, i32);
}

/// Things by band.
#[derive(Debug)]
pub(super) struct Bins<T> {
    sorted: Vec<T>,
    /// Where each band ends in `sorted`, and before that where the first begins.
    starts: Vec<u32>,
}

impl<T> Default for Bins<T> {
    fn default() -> Self {
        Self { sorted: Vec::new(), starts: Vec::new() }
    }
}

impl<T: Rows + Copy> Bins<T> {
    /// Forgets everything.
    pub(super) fn clear(&mut self) {
        self.sorted.clear();
        self.starts.clear();
    }

    /// Replaces the content by `things`, sorted.
    pub(super) fn fill(&mut self, screen: &Screen, things: &[T]) {
        self.clear();
        let Some(&first) = things.first() else { return };
        let bands = screen.bands();
        let touched = |thing: &T| {
            let (begin, end) = thing.rows();
            let first = (begin.max(0) as usize) >> screen.band_shift;
            let last = ((end - 1).max(0) as usize) >> screen.band_shift;
            first..last.min(bands - 1) + 1
        };
        self.starts.resize(bands + 2, 0);
        for thing in things {
            for band in touched(thing) {
                self.starts[band + 2] += 1;
            }
        }
        for i in 2..self.starts.len() {
            self.starts[i] += self.starts[i - 1];
        }
        self.sorted.resize(self.starts[bands + 1] as usize, first);
        for thing in things {
            for band in touched(thing) {
                let place = &mut self.starts[band + 1];
                self.sorted[*place as usize] = *thing;
                *place += 1;
            }
        }
    }

    /// All things, those that touch several bands several times.
    pub(super) fn all(&self) -> &[T] {
        &self.sorted
    }

    /// The things that touch a band, in their order.
    pub(super) fn band(&self, index: usize) -> &[T] {
        match (self.starts.get(index), self.starts.get(index + 1)) {
            (Some(&begin), Some(&end)) => self.sorted.get(begin as usize..end as usize).unwrap_or(&[]),
            _ => &[],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Clone, Copy, Debug, PartialEq)]
    struct Thing(i32, i32, char);

    impl Rows for Thing {
        fn rows(&self) -> (i32, i32) {
            (self.0, self.1)
        }
    }

    #[test]
    fn things_keep_their_order_in_every_band_they_touch() {
        let screen = Screen::new(640, 200);
        assert_eq!((screen.band_rows(), screen.bands()), (64, 4));
        let mut bins = Bins::default();
        let things = [Thing(190, 200, 'a'), Thing(60, 70, 'b'), Thing(0, 1, 'c'), Thing(0, 200, 'd')];
        bins.fill(&screen, &things);
        let names = |band: usize| bins.band(band).iter().map(|t| t.2).collect::<String>();
        assert_eq!([names(0), names(1), names(2), names(3), names(4)], ["bcd", "bd", "ad", "ad", ""]);
        bins.fill(&screen, &[]);
        assert!(bins.band(0).is_empty());
    }
}
