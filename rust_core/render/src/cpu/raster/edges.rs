//! The edges of faces: which pixels are on the inner side of each. This is the only place that knows the fill rule.
//!
//! A pixel belongs to a face where its centre lies inside of all edges, or on a left or top edge, of the face whose
//! corners are snapped to 1/256 pixel. All of that is decided in whole numbers, so that faces which share an edge draw
//! every pixel along it once. An edge is a function of the pixel that grows by the same from pixel to pixel and from
//! row to row ([`Edge`]). It is evaluated for several pixels side by side ([`RowEdges`]), or divided by its growth,
//! which gives the first and the last pixel of each row of a wide face ([`SpanEdges`]).

use std::ops::{Add, Mul, Neg, Range, Sub};

use fearless_simd::prelude::*;
use fearless_simd::Simd;

use crate::cpu::tile::lanes::{map, I, M};
use crate::cpu::tile::screen::{Area, ScreenPosition, SUBPIXELS};

/// A whole number, or several side by side.
pub(in crate::cpu) trait Whole:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Neg<Output = Self>
{
    /// Of a snapped place the pixel, rounded down.
    fn pixel(self) -> Self;
    /// Of a snapped place the part that is less than a pixel.
    fn fraction(self) -> Self;
    /// 0 where pixels on an edge along this direction are the face's, else 1.
    fn disowns(along_x: Self, along_y: Self) -> Self;
}

impl Whole for i64 {
    #[inline(always)]
    fn pixel(self) -> Self {
        self >> SUBPIXELS.ilog2()
    }

    #[inline(always)]
    fn fraction(self) -> Self {
        self & i64::from(SUBPIXELS - 1)
    }

    #[inline(always)]
    fn disowns(along_x: Self, along_y: Self) -> Self {
        // Left edges go up, top edges go right.
        Self::from(!(along_y < 0 || (along_y == 0 && along_x > 0)))
    }
}

impl<S: Simd> Whole for I<S> {
    #[inline(always)]
    fn pixel(self) -> Self {
        self >> SUBPIXELS.ilog2()
    }

    #[inline(always)]
    fn fraction(self) -> Self {
        self & (SUBPIXELS - 1)
    }

    #[inline(always)]
    fn disowns(along_x: Self, along_y: Self) -> Self {
        let (zero, one) = (Self::splat(along_x.token(), 0), Self::splat(along_x.token(), 1));
        (along_y.simd_lt(zero) | (along_y.simd_eq(zero) & along_x.simd_gt(zero))).select(zero, one)
    }
}

/// A straight edge: the pixel (x, y) from the origin is on its inner side where `at + x · dx + y · dy` is not negative.
#[derive(Clone, Copy, Debug)]
pub(in crate::cpu) struct Edge<T> {
    /// The value at the origin, rounded down to whole pixels: its growth is a multiple of these.
    pub at: T,
    pub dx: T,
    pub dy: T,
}

impl<T: Whole> Edge<T> {
    /// Between two snapped places, with the inside on its right as the image shows it, and measured from a pixel.
    #[inline(always)]
    pub(in crate::cpu) fn new(from: [T; 2], to: [T; 2], origin: [T; 2]) -> Self {
        let (along_x, along_y) = (to[0] - from[0], to[1] - from[1]);
        let fraction = along_y * from[0].fraction() - along_x * from[1].fraction() - T::disowns(along_x, along_y);
        let (right, down) = (origin[0] - from[0].pixel(), origin[1] - from[1].pixel());
        Self { at: along_x * down - along_y * right + fraction.pixel(), dx: -along_y, dy: along_x }
    }
}

impl Edge<i64> {
    /// The edges of a triangle whose inside is on the right of each, measured from the image's first pixel.
    #[inline(always)]
    pub(in crate::cpu) fn around([a, b, c]: [&ScreenPosition; 3]) -> [Self; 3] {
        let place = |position: &ScreenPosition| [i64::from(position.x), i64::from(position.y)];
        let (a, b, c) = (place(a), place(b), place(c));
        [Self::new(a, b, [0; 2]), Self::new(b, c, [0; 2]), Self::new(c, a, [0; 2])]
    }

    #[inline(always)]
    fn value(&self, x: i32, y: i32) -> i64 {
        self.at + self.dx * i64::from(x) + self.dy * i64::from(y)
    }

    /// True if a pixel is on the inner side.
    #[inline(always)]
    pub(in crate::cpu) fn covers(&self, x: i32, y: i32) -> bool {
        self.value(x, y) >= 0
    }

    /// The edge measured from a pixel, with numbers of 32 bits: right within a tile.
    #[inline(always)]
    pub(in crate::cpu) fn measured_at(&self, x: i32, y: i32) -> Edge<i32> {
        // Snapped places reach to ±2^24, and a tile's pixels are fewer than 8 away on each axis.
        const FAR: i64 = (1 << 29) + (1 << 28);
        Edge { at: self.value(x, y).clamp(-FAR, FAR) as i32, dx: self.dx as i32, dy: self.dy as i32 }
    }

    /// True if no pixel of an area is on the inner side.
    #[inline(always)]
    pub(in crate::cpu) fn excludes(&self, area: Area) -> bool {
        let (right, down) = (i64::from(area.right - 1 - area.left), i64::from(area.bottom - 1 - area.top));
        self.value(area.left, area.top) + (self.dx * right).max(0) + (self.dy * down).max(0) < 0
    }
}

/// The edges of a face at pixels side by side, row by row.
#[derive(Clone, Copy)]
pub(in crate::cpu) struct RowEdges<S: Simd, const N: usize> {
    at: [I<S>; N],
    down: [i32; N],
}

impl<S: Simd, const N: usize> RowEdges<S, N> {
    /// At pixels of a row, given by their distances from the origin of the edges.
    #[inline(always)]
    pub(in crate::cpu) fn new(edges: &[Edge<i32>; N], x: I<S>, y: i32) -> Self {
        let at = map(
            *edges,
            #[inline(always)]
            |Edge { at, dx, dy }| x * dx + (at + dy * y),
        );
        let down = map(
            *edges,
            #[inline(always)]
            |edge| edge.dy,
        );
        Self { at, down }
    }

    /// The pixels of the row that are inside; goes on to the next row.
    #[inline(always)]
    pub(in crate::cpu) fn next(&mut self) -> M<S> {
        let mut all = self.at[0];
        for k in 1..N {
            all |= self.at[k];
        }
        for k in 0..N {
            self.at[k] += self.down[k];
        }
        all.simd_ge(0)
    }
}

/// The span of a triangle in one row after another. The edges' values grow by the same from row to row, so that each is
/// divided only once.
pub(in crate::cpu) struct SpanEdges {
    edges: [SpanEdge; 3],
    columns: Range<i32>,
}

struct SpanEdge {
    /// The value at the row's beginning, divided by the change per pixel without its sign: the quotient, rounded down,
    /// and the rest.
    quotient: i64,
    rest: i64,
    /// Quotient and rest of the change from row to row.
    step: i64,
    rest_step: i64,
    divisor: i64,
    /// True if the inner side is on the right; an edge along the rows has none.
    is_left: Option<bool>,
}

impl SpanEdges {
    /// From a row on, within some columns.
    pub(in crate::cpu) fn new(edges: &[Edge<i64>; 3], row: i32, columns: Range<i32>) -> Self {
        Self { edges: edges.map(|edge| SpanEdge::new(&edge, row)), columns }
    }

    /// The pixels of the row that are inside, from the first to before the last; goes on to the next row.
    #[inline(always)]
    pub(in crate::cpu) fn next(&mut self) -> Range<i32> {
        let Range { start: mut first, end: mut after } = self.columns;
        for edge in &mut self.edges {
            edge.narrow(&mut first, &mut after);
        }
        first..after
    }
}

impl SpanEdge {
    fn new(edge: &Edge<i64>, row: i32) -> Self {
        let here = edge.value(0, row);
        let divisor = edge.dx.abs().max(1);
        Self {
            quotient: here.div_euclid(divisor),
            rest: here.rem_euclid(divisor),
            step: edge.dy.div_euclid(divisor),
            rest_step: edge.dy.rem_euclid(divisor),
            divisor,
            is_left: (edge.dx != 0).then_some(edge.dx > 0),
        }
    }

    /// Narrows `first..after` to the pixels of the row on the inner side, and goes on to the next row.
    #[inline]
    fn narrow(&mut self, first: &mut i32, after: &mut i32) {
        match self.is_left {
            None if self.quotient < 0 => *after = *first,
            None => {}
            Some(true) => *first = i64::from(*first).max(-self.quotient).min(i64::from(*after)) as i32,
            Some(false) => *after = i64::from(*after).min(self.quotient + 1).max(i64::from(*first)) as i32,
        }
        self.quotient += self.step;
        self.rest += self.rest_step;
        if self.rest >= self.divisor {
            self.rest -= self.divisor;
            self.quotient += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use fearless_simd::dispatch;
    use proptest::prelude::*;
    use rcs_camera::simd_levels::levels;

    use super::*;
    use crate::cpu::tile::lanes::{lane_indices, LANES};

    /// True if a pixel's centre is inside a triangle or on a left or top edge of it.
    fn covers(corners: [[i32; 2]; 3], x: i32, y: i32) -> bool {
        let [a, b, c] = corners.map(|corner| corner.map(i64::from));
        let at = [x, y].map(|place| i64::from(place) * i64::from(SUBPIXELS));
        [[a, b], [b, c], [c, a]].into_iter().all(|[from, to]| {
            let along = [to[0] - from[0], to[1] - from[1]];
            let owns = along[1] < 0 || (along[1] == 0 && along[0] > 0);
            let side = along[0] * (at[1] - from[1]) - along[1] * (at[0] - from[0]);
            side > 0 || (side == 0 && owns)
        })
    }

    /// The corners of a triangle whose inside is on the right of each edge.
    fn triangle(size: i32) -> impl Strategy<Value = [[i32; 2]; 3]> {
        let near = |limit: i32| [0..limit, 0..limit];
        let corner = move || prop_oneof![near(size), near(size / 128).prop_map(|place| place.map(|c| c * 128))];
        let at = [-2000..20_000_i32, -2000..20_000];
        ([corner(), corner(), corner()], at).prop_map(|(corners, [x, y])| {
            let [a, b, c] = corners.map(|corner| [corner[0] + x, corner[1] + y]);
            let along = |i: usize, to: [i32; 2]| i64::from(to[i] - a[i]);
            let area = along(0, b) * along(1, c) - along(0, c) * along(1, b);
            if area < 0 {
                [a, c, b]
            } else {
                [a, b, c]
            }
        })
    }

    fn edges_of(corners: [[i32; 2]; 3]) -> [Edge<i64>; 3] {
        let [a, b, c] = corners.map(|[x, y]| ScreenPosition { x, y, ..ScreenPosition::default() });
        Edge::around([&a, &b, &c])
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(400))]

        #[test]
        fn spans_are_the_pixels_whose_centres_are_inside(corners in triangle(16_000), left in -20..60_i32, top in -20..60) {
            let columns = left..left + 70;
            let mut spans = SpanEdges::new(&edges_of(corners), top, columns.clone());
            for y in top..top + 64 {
                let inside: Vec<i32> = columns.clone().filter(|&x| covers(corners, x, y)).collect();
                prop_assert_eq!(spans.next().collect::<Vec<i32>>(), inside);
            }
        }

        #[test]
        fn lanes_are_the_pixels_whose_centres_are_inside(corners in triangle(1600), x in -10..80_i32, y in -10..80) {
            let expected: Vec<Vec<bool>> =
                (y..y + 8).map(|y| (x..x + LANES as i32).map(|x| covers(corners, x, y)).collect()).collect();
            for level in levels() {
                let rows = dispatch!(level, simd => {
                    let edges = edges_of(corners).map(|edge| edge.measured_at(x, y));
                    let mut rows = RowEdges::new(&edges, lane_indices(simd), 0);
                    (0..8).map(|_| rows.next().to_bitmask()).collect::<Vec<_>>()
                });
                for (row, expected) in rows.iter().zip(&expected) {
                    let inside: Vec<bool> = (0..LANES).map(|lane| row >> lane & 1 == 1).collect();
                    prop_assert_eq!(&inside, expected);
                }
            }
        }

        #[test]
        fn an_edge_of_lanes_is_that_of_single_numbers(
            places in proptest::array::uniform8([0..60_000_i32, 0..60_000, 0..60_000, 0..60_000]),
            [x, y] in [0..200_i32, 0..200],
        ) {
            for level in levels() {
                let lanes = dispatch!(level, simd => {
                    let of = |i: usize| I::load_array(simd, places.map(|place| place[i]));
                    let edge = Edge::new([of(0), of(1)], [of(2), of(3)], [I::splat(simd, x), I::splat(simd, y)]);
                    [edge.at.to_array(), edge.dx.to_array(), edge.dy.to_array()]
                });
                for (lane, place) in places.iter().enumerate() {
                    let [ax, ay, bx, by] = place.map(i64::from);
                    let edge = Edge::new([ax, ay], [bx, by], [i64::from(x), i64::from(y)]);
                    prop_assert_eq!(lanes.map(|all| i64::from(all[lane])), [edge.at, edge.dx, edge.dy]);
                }
            }
        }

        #[test]
        fn an_excluded_area_has_no_pixel_inside(corners in triangle(16_000), x in -20..60_i32, y in -20..60) {
            let area = Area { left: x, right: x + 8, top: y, bottom: y + 8 };
            if edges_of(corners).iter().any(|edge| edge.excludes(area)) {
                prop_assert!(!(y..y + 8).any(|y| (x..x + 8).any(|x| covers(corners, x, y))));
            }
        }
    }
}
