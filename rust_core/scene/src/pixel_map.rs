//! Map from each pixel of an image to its place in a source image, such as a lens makes it.

use std::ops::Range;

use rayon::prelude::*;

use crate::MAX_SIDE_PX;

/// Distance between stored places along a row; between them they are interpolated.
const STRIDE_PX: u32 = MapRun::PIXELS as u32;

/// Fixed-point one of places.
const ONE: f64 = 65536.0;

/// Least reach of the source beyond the image's own area, which is half a side otherwise.
const LEAST_REACH_PX: f64 = 64.0;

/// Margin of the source around the places, so that each has its four neighbours.
const MARGIN_PX: f64 = 1.0;

/// Map of an image's pixels to places in a source image; some pixels may have none.
///
/// Places are pixels from the source's top left one; an integer is a pixel's centre. Between every eighth pixel of a
/// row they are interpolated, with an error of some hundredths of a pixel at most for a lens.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PixelMap {
    size_px: [u32; 2],
    source_size_px: [u32; 2],
    source_origin_px: [i32; 2],
    rows: Vec<MapRow>,
    /// Places in 16.16 fixed point, those of each row after those of the last: of every [`STRIDE_PX`]th pixel, up to
    /// the one after the last run.
    nodes: Vec<[i32; 2]>,
}

/// The pixels of a row that have a place, and their nodes.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
struct MapRow {
    pixels: Range<u32>,
    nodes: Range<usize>,
}

/// Pixels of a row with equidistant places.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MapRun {
    /// The first pixel's place, in 1/65536 pixels of the source.
    pub place: [i32; 2],
    /// Distance from one pixel's place to the next one's.
    pub step: [i32; 2],
}

impl MapRun {
    /// Pixels of a run; the last one of a row may have fewer.
    pub const PIXELS: usize = 8;
}

impl PixelMap {
    /// The map of an image of `size_px`. `place` gives the place of a pixel (column, row) in an unbounded source
    /// image, in pixels, if it has one. The source is cut to the places, and to twice the image's size around its
    /// middle at most: [`Self::source_origin_px`] is the place of its first pixel.
    ///
    /// `None` if no pixel has a place.
    ///
    /// ```
    /// use rcs_scene::PixelMap;
    ///
    /// // An image that shows its source twice as large, except for its left half.
    /// let place = |[u, v]: [f64; 2]| (u >= 50.0).then_some([u / 2.0, v / 2.0]);
    /// let map = PixelMap::new([100, 80], place).unwrap();
    /// assert_eq!((map.size_px(), map.source_origin_px()), ([100, 80], [24, -1]));
    /// let (columns, mut runs) = map.runs(10);
    /// assert_eq!((columns, runs.next().unwrap().place), (50..100, [65536, 6 * 65536]));
    /// ```
    pub fn new(size_px: [u32; 2], place: impl Fn([f64; 2]) -> Option<[f64; 2]> + Sync) -> Option<Self> {
        let [width, height] = size_px.map(f64::from);
        // What lies farther beside the image is left out: a lens that bends so much would need a huge source.
        let reach = [width, height].map(|side| (side / 2.0).max(LEAST_REACH_PX));
        let is_near =
            |[x, y]: &[f64; 2]| (-reach[0]..width + reach[0]).contains(x) && (-reach[1]..height + reach[1]).contains(y);
        let place = |column: u32, row: u32| place([f64::from(column), f64::from(row)]).filter(is_near);
        let rows: Vec<_> =
            (0..size_px[1]).into_par_iter().map(|row| places_of_row(size_px[0], |u| place(u, row))).collect();

        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for place in rows.iter().flat_map(|(_, places)| places) {
            for axis in 0..2 {
                (low[axis], high[axis]) = (low[axis].min(place[axis]), high[axis].max(place[axis]));
            }
        }
        if low[0] > high[0] {
            return None;
        }
        let source_origin_px = low.map(|low| (low - MARGIN_PX).floor() as i32);
        let last = high.map(|high| (high + MARGIN_PX).ceil() as i32);
        let source_size_px = [0, 1].map(|i| (last[i] - source_origin_px[i] + 1) as u32);
        if source_size_px.iter().any(|side| *side > MAX_SIDE_PX) {
            return None;
        }
        let mut map = Self { size_px, source_size_px, source_origin_px, rows: Vec::new(), nodes: Vec::new() };
        let fixed =
            |place: [f64; 2]| [0, 1].map(|i| ((place[i] - f64::from(source_origin_px[i])) * ONE).round() as i32);
        for (pixels, places) in rows {
            let begin = map.nodes.len();
            map.nodes.extend(places.into_iter().map(fixed));
            map.extend_last_run(begin, pixels.len());
            map.rows.push(MapRow { pixels, nodes: begin..map.nodes.len() });
        }
        Some(map)
    }

    /// Width and height of the image.
    pub fn size_px(&self) -> [u32; 2] {
        self.size_px
    }

    /// Width and height of the source.
    pub fn source_size_px(&self) -> [u32; 2] {
        self.source_size_px
    }

    /// Place of the source's first pixel, in the coordinates that [`new`](Self::new) was given.
    pub fn source_origin_px(&self) -> [i32; 2] {
        self.source_origin_px
    }

    /// Columns of a row's pixels that have a place, and their runs of [`MapRun::PIXELS`] pixels, the last one of the
    /// rest. Places and the pixels to the right of and below them are in the source.
    pub fn runs(&self, row: u32) -> (Range<u32>, impl Iterator<Item = MapRun> + '_) {
        let MapRow { pixels, nodes } = self.rows.get(row as usize).cloned().unwrap_or_default();
        let nodes = self.nodes.get(nodes).unwrap_or(&[]);
        let runs = nodes.windows(2).map(|nodes| {
            let (place, next) = (nodes[0], nodes[1]);
            MapRun { place, step: [0, 1].map(|axis| (next[axis] - place[axis]) / STRIDE_PX as i32) }
        });
        (pixels, runs)
    }

    /// Extends the last run of a row of `pixels` pixels, whose nodes begin at `begin` and end with its last pixel's
    /// place, to a whole run.
    fn extend_last_run(&mut self, begin: usize, pixels: usize) {
        let Some(last) = pixels.checked_sub(1) else { return };
        // The last run's only pixel may be the row's last one.
        let steps = last % MapRun::PIXELS;
        if steps == 0 {
            self.nodes.extend_from_within(self.nodes.len() - 1..);
        } else if let Some([place, end]) = self.nodes.get_mut(begin..).and_then(<[_]>::last_chunk_mut) {
            // Places are not negative, so that differences of bounded ones fit.
            const LEAST: i64 = i32::MIN as i64 / 2;
            *end = [0, 1].map(|axis| {
                let step = i64::from((end[axis] - place[axis]) / steps as i32);
                (i64::from(place[axis]) + step * i64::from(STRIDE_PX)).clamp(LEAST, i32::MAX.into()) as i32
            });
        }
    }
}

/// Longest run of pixels that have a place, and the places of every [`STRIDE_PX`]th of them and of the last one.
fn places_of_row(width: u32, place: impl Fn(u32) -> Option<[f64; 2]>) -> (Range<u32>, Vec<[f64; 2]>) {
    let pixels = longest_run(width, |column| place(column).is_some());
    let Some(last) = pixels.clone().next_back() else { return (pixels, Vec::new()) };
    let columns = pixels.clone().step_by(STRIDE_PX as usize).filter(|column| *column != last).chain([last]);
    let places = columns.filter_map(place).collect();
    (pixels, places)
}

/// Longest range of columns for which `holds`: sampled at every [`STRIDE_PX`]th, and at each where it begins or ends.
fn longest_run(width: u32, holds: impl Fn(u32) -> bool) -> Range<u32> {
    let (mut longest, mut current) = (0..0, 0..0);
    let mut column = 0;
    while column < width {
        let end = (column + STRIDE_PX).min(width);
        let is_whole = holds(column) && holds(end - 1);
        for column in column..end {
            if is_whole || holds(column) {
                current = if current.end == column { current.start..column + 1 } else { column..column + 1 };
                if current.len() > longest.len() {
                    longest = current.clone();
                }
            }
        }
        column = end;
    }
    longest
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The columns of a row that have a place, and the places.
    fn fixed_places(map: &PixelMap, row: u32) -> Vec<(u32, [i32; 2])> {
        let (columns, runs) = map.runs(row);
        let pixels = runs.flat_map(|run| {
            (0..MapRun::PIXELS as i32).map(move |i| [0, 1].map(|axis| run.place[axis] + i * run.step[axis]))
        });
        let places: Vec<_> = columns.clone().zip(pixels).collect();
        assert_eq!(places.len(), columns.len());
        places
    }

    /// The place of each pixel by the runs; none where there is none.
    fn places(map: &PixelMap, row: u32) -> Vec<Option<[f64; 2]>> {
        let mut places = vec![None; map.size_px()[0] as usize];
        for (column, place) in fixed_places(map, row) {
            places[column as usize] =
                Some([0, 1].map(|axis| f64::from(place[axis]) / ONE + f64::from(map.source_origin_px()[axis])));
        }
        places
    }

    #[test]
    fn every_pixel_has_its_place_within_hundredths_of_a_pixel() {
        // As a lens of 500 px bends: r' = r (1 + 0.2 r²).
        let lens = |[u, v]: [f64; 2]| {
            let (x, y) = ((u - 170.3) / 500.0, (v - 90.0) / 500.0);
            let scale = 500.0 * (1.0 + 0.2 * (x * x + y * y));
            Some([170.3 + x * scale, 90.0 + y * scale])
        };
        for width in [1, 2, 7, 8, 9, 17, 333] {
            let map = PixelMap::new([width, 211], lens).unwrap();
            for row in 0..211 {
                for (column, place) in places(&map, row).into_iter().enumerate() {
                    let (place, expected) = (place.unwrap(), lens([column as f64, f64::from(row)]).unwrap());
                    let off = (place[0] - expected[0]).hypot(place[1] - expected[1]);
                    assert!(off < 0.01, "{width}: ({column}, {row}) is off by {off}");
                }
            }
        }
    }

    #[test]
    fn pixels_without_a_place_are_in_no_run() {
        let disc = |[u, v]: [f64; 2]| ((u - 40.0).hypot(v - 30.0) < 21.5).then_some([u, v]);
        let map = PixelMap::new([90, 60], disc).unwrap();
        for row in 0..60 {
            for (column, place) in places(&map, row).into_iter().enumerate() {
                assert_eq!(place.is_some(), disc([column as f64, f64::from(row)]).is_some(), "({column}, {row})");
            }
        }
        assert_eq!((map.source_origin_px(), map.source_size_px()), ([18, 8], [45, 45]));
        assert_eq!(PixelMap::new([90, 60], |_| None), None);
    }

    #[test]
    fn the_source_has_the_neighbours_of_each_place_and_is_bounded() {
        let map = PixelMap::new([64, 48], |[u, v]| Some([u * 40.0 - 100.0, v + 0.5])).unwrap();
        let [width, height] = map.source_size_px();
        assert!(width <= 64 + 2 * 64 + 4, "{width}");
        for row in 0..48 {
            for (_, place) in fixed_places(&map, row) {
                let [x, y] = place.map(|place| place >> 16);
                assert!(x >= 0 && y >= 0 && x + 1 < width as i32 && y + 1 < height as i32);
            }
        }
    }

    #[test]
    fn rows_that_end_with_a_leap_are_no_error() {
        let map = PixelMap::new([16_000, 1], |[u, _]| Some([if u < 15_999.0 { u } else { 0.0 }, 0.0])).unwrap();
        let places = fixed_places(&map, 0);
        let width = map.source_size_px()[0] as i32;
        assert!(places.iter().all(|(_, [x, _])| (0..width).contains(&(x >> 16))), "{:?}", places.last());
    }

    #[test]
    fn there_are_no_rows_beside_the_image() {
        let map = PixelMap::new([4, 3], Some).unwrap();
        assert_eq!((map.runs(2).0, map.runs(2).1.count()), (0..4, 1));
        assert_eq!((map.runs(3).0, map.runs(3).1.count()), (0..0, 0));
    }
}
