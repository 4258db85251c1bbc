//! The edges of triangles, in whole numbers: which pixels are on the inner side of each.

use wide::i32x4;

use super::screen::SUBPIXELS;
use super::triangles::ScreenPosition;

/// The edges of a small triangle, where to try each pixel is faster than the divisions that find the ends of a row. As
/// [`Edge`], one in a lane, the last without meaning; places are measured from the bounding box's first pixel, so that
/// all fits into 32 bits.
pub(super) struct SmallEdges {
    pub c: i32x4,
    pub dx: i32x4,
    pub dy: i32x4,
}

impl SmallEdges {
    /// The widest triangles for which that is so.
    pub(super) const MAX_WIDTH_PX: i32 = 6;
    /// The highest that fit.
    pub(super) const MAX_HEIGHT_PX: i32 = 64;

    /// Of corners whose inside is on the right of each edge; `left` and `top` are the first pixel.
    #[inline]
    pub(super) fn around([a, b, c]: [&ScreenPosition; 3], left: i32, top: i32) -> Self {
        let (x, y) = (i32x4::splat(left * SUBPIXELS), i32x4::splat(top * SUBPIXELS));
        let (from_x, from_y) = (i32x4::new([a.x, b.x, c.x, a.x]) - x, i32x4::new([a.y, b.y, c.y, a.y]) - y);
        let along_x = i32x4::new([b.x, c.x, a.x, a.x]) - x - from_x;
        let along_y = i32x4::new([b.y, c.y, a.y, a.y]) - y - from_y;
        let owns = along_y.simd_lt(i32x4::ZERO) | (along_y.simd_eq(i32x4::ZERO) & along_x.simd_gt(i32x4::ZERO));
        // A mask is -1 where it holds, so that one is taken off where the edge does not own the pixels on it.
        Self {
            c: along_y * from_x - along_x * from_y - i32x4::ONE - owns,
            dx: -along_y * i32x4::splat(SUBPIXELS),
            dy: along_x * i32x4::splat(SUBPIXELS),
        }
    }

    /// The pixels of a row, from 0 to before `width`, that are on the inner side of all edges: the first and the one
    /// after the last.
    #[inline]
    pub(super) fn row(&self, y: i32, width: i32) -> (i32, i32) {
        const EDGES: u32 = 0b111;
        let mut at = self.c + self.dy * i32x4::splat(y);
        let mut inside = 0u32;
        for x in 0..width {
            inside |= u32::from(at.to_bitmask() & EDGES == 0) << x;
            at += self.dx;
        }
        // They lie side by side.
        let first = inside.trailing_zeros().min(width as u32) as i32;
        (first, first + inside.count_ones() as i32)
    }
}

/// A straight edge: a pixel (x, y) is on its inner side where `c + x · dx + y · dy` is not negative.
pub(super) struct Edge {
    pub c: i64,
    pub dx: i64,
    pub dy: i64,
}

impl Edge {
    /// Those of a triangle whose inside is on the right of each.
    pub(super) fn around([a, b, c]: [&ScreenPosition; 3]) -> [Self; 3] {
        [(a, b), (b, c), (c, a)].map(|(from, to)| Self::new([from.x, from.y], [to.x, to.y]))
    }

    fn new([ax, ay]: [i32; 2], [bx, by]: [i32; 2]) -> Self {
        let (along_x, along_y) = (i64::from(bx - ax), i64::from(by - ay));
        // Left edges go up, top edges go right: these own the pixels on them.
        let owns = along_y < 0 || (along_y == 0 && along_x > 0);
        Self {
            c: along_y * i64::from(ax) - along_x * i64::from(ay) - i64::from(!owns),
            dx: -along_y * i64::from(SUBPIXELS),
            dy: along_x * i64::from(SUBPIXELS),
        }
    }
}

/// Where an edge crosses one row after another. Its value grows by the same from row to row, so that it is divided only
/// once.
pub(super) struct EdgeRows {
    /// The value at the row's beginning, divided by the change per pixel without its sign: the quotient, rounded down,
    /// and what is left.
    quotient: i64,
    rest: i64,
    /// The same of the change from row to row.
    step: i64,
    rest_step: i64,
    divisor: i64,
    /// Whether the inner side is on the right; an edge along the rows has none.
    is_left: Option<bool>,
}

impl EdgeRows {
    /// From a row on.
    pub(super) fn new(edge: &Edge, row: i32) -> Self {
        let here = edge.c + edge.dy * i64::from(row);
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
    pub(super) fn narrow(&mut self, first: &mut i32, after: &mut i32) {
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
