//! Which pixels of each row small triangles cover, several triangles at once.
//!
//! Most triangles of a small solid are slivers that cover no pixel's centre, or one or two of hundreds in the box
//! around them. So for each row the three edges are divided, as [`triangles`](super::triangles) does for large ones,
//! for one triangle in each lane: by a product with the inverse, which may be off by one and is put right in
//! whole numbers.

use fearless_simd::prelude::*;
use fearless_simd::Simd;

use super::lanes::{map, whole, F, I, LANES};
use super::occlusion::Area;
use super::screen::SUBPIXELS;

/// The side of the largest box around a triangle, in pixels: so that products of snapped places fit into 32 bits.
const MAX_PX: i32 = 72;

/// Several triangles, and what they cover.
#[derive(Debug)]
pub(super) struct Cover {
    /// The snapped places of the corners: x and y of the first, of the second and of the third.
    places: [[i32; LANES]; 6],
    /// The first row that is looked at, and how many.
    begin: [i32; LANES],
    rows: [i32; LANES],
    /// In each row the first pixel, and the one after the last.
    spans: Vec<[[i32; LANES]; 2]>,
}

impl Default for Cover {
    fn default() -> Self {
        let none = [0; LANES];
        Self { places: [none; 6], begin: none, rows: none, spans: Vec::new() }
    }
}

/// An edge of each triangle, with places from the box's first pixel: a pixel is on its inner side where `at` is not
/// negative.
#[derive(Clone, Copy)]
struct Edges<S: Simd> {
    at: I<S>,
    dy: I<S>,
    /// The change to the right, without its sign, and one over it.
    divisor: I<S>,
    inverse: F<S>,
    /// Whether it is on the left of the inner side, on the right: 0 or -1.
    is_left: I<S>,
    is_right: I<S>,
}

impl<S: Simd> Edges<S> {
    #[inline(always)]
    fn between(simd: S, [ax, ay]: [I<S>; 2], [bx, by]: [I<S>; 2]) -> Self {
        let (zero, one) = (I::splat(simd, 0), I::splat(simd, 1));
        let (along_x, along_y) = (bx - ax, by - ay);
        // Left edges go up, top edges go right: these own the pixels on them.
        let owns = along_y.simd_lt(zero) | (along_y.simd_eq(zero) & along_x.simd_gt(zero));
        let dx = -along_y * SUBPIXELS;
        let divisor = dx.max(-dx).max(one);
        Self {
            at: along_y * ax - along_x * ay - owns.select(zero, one),
            dy: along_x * SUBPIXELS,
            divisor,
            inverse: F::splat(simd, 1.0) / divisor.to_float::<F<S>>(),
            is_left: dx.simd_gt(zero).select(-one, zero),
            is_right: dx.simd_lt(zero).select(-one, zero),
        }
    }

    /// Narrows a row's pixels to those on the inner side, and goes on to the next row.
    #[inline(always)]
    fn narrow(&mut self, simd: S, first: &mut I<S>, after: &mut I<S>) {
        // A row has fewer pixels, and what is added makes a quotient positive, so that it is rounded down.
        const FAR: f32 = (2 * MAX_PX) as f32;
        let quotient = self.at.to_float::<F<S>>() * self.inverse;
        let quotient = whole(quotient.max(-FAR).min(FAR) + 2.0 * FAR) - 4 * MAX_PX;
        let rest = self.at - quotient * self.divisor;
        let (zero, one) = (I::splat(simd, 0), I::splat(simd, 1));
        let quotient = quotient - rest.simd_lt(zero).select(one, zero);
        let quotient = quotient + rest.simd_ge(self.divisor).select(one, zero);
        // An edge along the row has all of it or nothing on its inner side.
        let is_out = self.at.simd_lt(zero).select(-one, zero) & !(self.is_left | self.is_right);
        let limit = I::splat(simd, i32::MAX);
        *first = (*first).max(-quotient & self.is_left);
        let end = ((quotient + 1) & self.is_right) | (limit & !self.is_right);
        *after = (*after).min(end) & !is_out;
        self.at += self.dy;
    }
}

impl Cover {
    /// Puts a triangle with corners at these snapped places into a lane.
    #[inline]
    pub(super) fn set(&mut self, lane: usize, corners: [[i32; 2]; 3]) {
        let lane = lane % LANES;
        self.places.iter_mut().zip(corners.as_flattened()).for_each(|(places, place)| places[lane] = *place);
    }

    /// Leaves a lane without a triangle.
    pub(super) fn clear(&mut self, lane: usize) {
        self.places.iter_mut().for_each(|places| places[lane % LANES] = 0);
    }

    /// Finds what the triangles cover of an area. Returns a bit for each lane: whether it is anything.
    #[inline(always)]
    pub(super) fn find<S: Simd>(&mut self, simd: S, area: Area) -> u32 {
        let [ax, ay, bx, by, cx, cy] = map(
            self.places,
            #[inline(always)]
            |places| I::load_array(simd, places),
        );
        let zero = I::splat(simd, 0);
        // So that the inside is on the right of each edge as the picture shows it.
        let turns = ((bx - ax) * (cy - ay) - (cx - ax) * (by - ay)).simd_lt(zero);
        let [bx, cx] = [turns.select(cx, bx), turns.select(bx, cx)];
        let [by, cy] = [turns.select(cy, by), turns.select(by, cy)];
        let [left, top] = map(
            [ax.min(bx).min(cx), ay.min(by).min(cy)],
            #[inline(always)]
            |place| (place + (SUBPIXELS - 1)) >> 8,
        );
        let [right, bottom] = map(
            [ax.max(bx).max(cx), ay.max(by).max(cy)],
            #[inline(always)]
            |place| (place + SUBPIXELS) >> 8,
        );
        let begin = top.max(I::splat(simd, area.top));
        let rows = bottom.min(I::splat(simd, area.bottom)) - begin;
        let (from_x, from_y) = (left * SUBPIXELS, begin * SUBPIXELS);
        let [a, b, c] = [[ax - from_x, ay - from_y], [bx - from_x, by - from_y], [cx - from_x, cy - from_y]];
        let mut edges = [Edges::between(simd, a, b), Edges::between(simd, b, c), Edges::between(simd, c, a)];
        let [first_column, end_column] = [left.max(I::splat(simd, area.left)), right.min(I::splat(simd, area.right))];
        let [first_column, end_column] = [first_column - left, end_column - left];
        let most_rows = rows.to_array().into_iter().fold(0, i32::max).min(MAX_PX);
        self.spans.resize((most_rows as usize).max(self.spans.len()), [[0; LANES]; 2]);
        let mut covers = zero.simd_gt(zero);
        for (row, span) in (0..most_rows).zip(&mut self.spans) {
            let mut first = first_column;
            let mut after = rows.simd_gt(I::splat(simd, row)).select(end_column, zero);
            for edges in &mut edges {
                edges.narrow(simd, &mut first, &mut after);
            }
            covers |= first.simd_lt(after);
            (left + first).store_array(&mut span[0]);
            (left + after).store_array(&mut span[1]);
        }
        begin.store_array(&mut self.begin);
        rows.store_array(&mut self.rows);
        covers.to_bitmask() as u32
    }

    /// Of a triangle the rows in which it covers pixels: the row, the first pixel, and the one after the last.
    #[inline]
    pub(super) fn rows(&self, lane: usize) -> impl Iterator<Item = (i32, i32, i32)> + '_ {
        let lane = lane % LANES;
        let spans = self.spans.iter().take(self.rows[lane].max(0) as usize);
        let spans = (self.begin[lane]..).zip(spans).map(move |(y, [first, after])| (y, first[lane], after[lane]));
        spans.filter(|(_, first, after)| first < after)
    }
}

#[cfg(test)]
mod tests {
    use fearless_simd::dispatch;
    use proptest::prelude::*;
    use rcs_camera::simd_levels::levels;

    use super::*;

    /// Whether a pixel's centre is inside a triangle or on a left or top edge of it.
    fn covers(corners: [[i32; 2]; 3], x: i32, y: i32) -> bool {
        let [a, b, c] = corners.map(|corner| corner.map(i64::from));
        let cross =
            |[ax, ay]: [i64; 2], [bx, by]: [i64; 2], [px, py]: [i64; 2]| (bx - ax) * (py - ay) - (by - ay) * (px - ax);
        let area = cross(a, b, c);
        let [a, b, c] = if area < 0 { [a, c, b] } else { [a, b, c] };
        let at = [x, y].map(|place| i64::from(place) * i64::from(SUBPIXELS));
        area != 0
            && [[a, b], [b, c], [c, a]].into_iter().all(|[from, to]| {
                let along = [to[0] - from[0], to[1] - from[1]];
                let owns = along[1] < 0 || (along[1] == 0 && along[0] > 0);
                let side = cross(from, to, at);
                side > 0 || (side == 0 && owns)
            })
    }

    fn triangle() -> impl Strategy<Value = [[i32; 2]; 3]> {
        let near = |limit: i32| [0..limit, 0..limit];
        let corner = || prop_oneof![near(600), near(16_000), near(60).prop_map(|place| place.map(|c| c * 128))];
        ([corner(), corner(), corner()], [-2000..20_000_i32, -2000..20_000])
            .prop_map(|(corners, [x, y])| corners.map(|corner| [corner[0] + x, corner[1] + y]))
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(400))]

        #[test]
        fn a_row_has_the_pixels_whose_centres_are_inside(
            triangles in proptest::array::uniform8(triangle()),
            [left, top] in [-20..60_i32, -20..60],
            [columns, rows] in [1..150_i32, 1..64],
        ) {
            for level in levels() {
                let mut cover = Cover::default();
                triangles.iter().enumerate().for_each(|(lane, corners)| cover.set(lane, *corners));
                cover.clear(7);
                let area = Area { left, right: left + columns, top, bottom: top + rows };
                let found = dispatch!(level, simd => cover.find(simd, area));
                for (lane, &corners) in triangles.iter().enumerate() {
                    let mut expected = Vec::new();
                    for y in (area.top..area.bottom).filter(|_| lane != 7) {
                        let inside: Vec<i32> = (area.left..area.right).filter(|&x| covers(corners, x, y)).collect();
                        expected.extend(inside.first().map(|&first| (y, first, first + inside.len() as i32)));
                    }
                    prop_assert_eq!(found >> lane & 1 == 1, !expected.is_empty());
                    prop_assert_eq!(cover.rows(lane).collect::<Vec<_>>(), expected);
                }
            }
        }
    }
}
