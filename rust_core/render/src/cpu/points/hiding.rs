//! What a face leaves to be seen of the next one.
//!
//! In an organised cloud, neighbouring faces overlap except for a strip that may be one pixel wide. A tile along the
//! edge of a face is covered only in part, so that [`Occluders`](crate::cpu::occlusion::Occluders) cannot tell what is
//! hidden in it. A few comparisons with the face before find the strip, and only its tiles are looked at.

use fearless_simd::prelude::*;
use fearless_simd::Simd;

use super::place::{ceil, floor, Corner, Quads, SUB};
use super::BLOCK;
use crate::cpu::lanes::{inlined, store_whole, whole, F};
use crate::cpu::occlusion::{Area, DepthPlane};

/// For each face of a block a rectangle of pixels that the face covers, in the band or not: left, right (past the
/// last), top, bottom (past the last). It is empty where the face is turned in the picture.
#[derive(Clone, Debug)]
pub(super) struct InnerAreas([[i32; BLOCK]; 4]);

impl Default for InnerAreas {
    fn default() -> Self {
        Self([[0; BLOCK]; 4])
    }
}

impl InnerAreas {
    /// Finds those of the faces from `begin` on.
    #[inline(always)]
    pub(super) fn find<S: Simd>(&mut self, quads: &Quads<S>, begin: usize) {
        let [a, b, c, d] = &quads.corners;
        // Which neighbour of the first corner is beside it, and which above or below.
        let is_level = (b.x - a.x).abs().simd_gt((b.y - a.y).abs());
        let (beside, across) = (Corner::select(is_level, b, d), Corner::select(is_level, d, b));
        // Strictly between two corners on one side and two on the other, as not every edge owns the pixels on it.
        let between = inlined(
            #[inline(always)]
            |one: [F<S>; 2], other: [F<S>; 2]| {
                let begin = one[0].max(one[1]).min(other[0].max(other[1]));
                let end = one[0].min(one[1]).max(other[0].min(other[1]));
                [floor(begin * (1.0 / SUB)) + 1.0, ceil(end * (1.0 / SUB))]
            },
        );
        let [left, right] = between([a.x, across.x], [beside.x, c.x]);
        let [top, bottom] = between([a.y, beside.y], [across.y, c.y]);
        for (all, value) in self.0.iter_mut().zip([left, right, top, bottom]) {
            store_whole(all, begin, whole(value));
        }
    }

    /// The rectangle of a face.
    #[inline(always)]
    pub(super) fn of(&self, i: usize) -> Area {
        let [left, right, top, bottom] = self.0.each_ref().map(|all| all[i]);
        Area { left, right, top, bottom }
    }
}

/// A face that was drawn in the band or found to be hidden there: no pixel that it covers shows anything farther away.
#[derive(Clone, Copy, Debug)]
pub(super) struct FaceBefore {
    pub depths: DepthPlane,
    pub rank: u32,
    /// Pixels that it covers.
    pub inner: Area,
}

impl FaceBefore {
    /// The part of another face's area in which something of it may be seen; the whole area where that part is no
    /// rectangle.
    #[inline(always)]
    pub(super) fn leaves(&self, plane: &DepthPlane, rank: u32, area: Area) -> Area {
        let inner = self.inner;
        let columns = [area.left.max(inner.left), area.right.min(inner.right)];
        let rows = [area.top.max(inner.top), area.bottom.min(inner.bottom)];
        let is_apart = columns[0] >= columns[1] || rows[0] >= rows[1];
        let mut left = area;
        if rows == [area.top, area.bottom] {
            [left.left, left.right] = without(columns, [area.left, area.right]);
        } else if columns == [area.left, area.right] {
            [left.top, left.bottom] = without(rows, [area.top, area.bottom]);
        }
        if is_apart || left == area || !self.hides(plane, rank, [columns, rows]) {
            return area;
        }
        left
    }

    /// Whether another face is behind this one, or equally far away and earlier, in all of these columns and rows.
    #[inline(always)]
    fn hides(&self, plane: &DepthPlane, rank: u32, [columns, rows]: [[i32; 2]; 2]) -> bool {
        let [x, y] = [columns[0], rows[0]].map(f64::from);
        let along = inlined(
            #[inline(always)]
            |other: f32, own: f32, [begin, end]: [i32; 2]| {
                let change = f64::from(other) - f64::from(own);
                (change * f64::from(end - begin - 1)).min(0.0)
            },
        );
        // Where they are nearest to each other.
        let behind = plane.value(x, y) - self.depths.value(x, y)
            + (along(plane.dx, self.depths.dx, columns) + along(plane.dy, self.depths.dy, rows));
        let unsure = f64::from(plane.noise) + f64::from(self.depths.noise);
        behind > unsure || (behind == unsure && rank < self.rank)
    }
}

/// What is left of the numbers from `begin` to before `end` without those from `first` to before `last`, which are
/// among them; all where these are in the middle.
#[inline(always)]
fn without([first, last]: [i32; 2], [begin, end]: [i32; 2]) -> [i32; 2] {
    if last == end {
        [begin, first]
    } else if first == begin {
        [last, end]
    } else {
        [begin, end]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BEFORE: FaceBefore = FaceBefore {
        depths: DepthPlane { at: 100.0, dx: 0.0, dy: 0.0, x: 0.0, y: 0.0, noise: 0.0, least: 100.0 },
        rank: 5,
        inner: area([10, 30], [20, 40]),
    };

    const fn area([left, right]: [i32; 2], [top, bottom]: [i32; 2]) -> Area {
        Area { left, right, top, bottom }
    }

    #[test]
    fn a_strip_is_left_of_a_face_behind_its_neighbour() {
        let behind = DepthPlane::level(101.0);
        for (before, left) in [
            (area([5, 25], [22, 38]), area([5, 10], [22, 38])),
            (area([15, 35], [20, 40]), area([30, 35], [20, 40])),
            (area([12, 30], [10, 30]), area([12, 30], [10, 20])),
            (area([10, 30], [35, 50]), area([10, 30], [40, 50])),
            // Nothing but rectangles: neither corners nor both sides.
            (area([5, 25], [15, 30]), area([5, 25], [15, 30])),
            (area([5, 35], [22, 38]), area([5, 35], [22, 38])),
            // Beside it.
            (area([30, 40], [22, 38]), area([30, 40], [22, 38])),
            (area([12, 20], [50, 60]), area([12, 20], [50, 60])),
        ] {
            assert_eq!(BEFORE.leaves(&behind, 9, before), left, "{before:?}");
        }
        let left = BEFORE.leaves(&behind, 9, area([12, 20], [25, 30]));
        assert!(left.left >= left.right, "{left:?}");
    }

    #[test]
    fn all_is_left_of_a_face_that_is_not_surely_behind() {
        let before = area([5, 25], [22, 38]);
        let strip = area([5, 10], [22, 38]);
        // Of equally far ones the later one is seen.
        for (plane, rank, left) in [
            (DepthPlane::level(99.0), 4, before),
            (DepthPlane::level(100.0), 4, strip),
            (DepthPlane::level(100.0), 6, before),
            (DepthPlane { noise: 2.0, ..DepthPlane::level(101.0) }, 4, before),
            (DepthPlane { noise: 0.5, ..DepthPlane::level(101.0) }, 6, strip),
            // Nearer in the last of the columns that both have, which is 24, or not before the first of the others.
            (DepthPlane { dx: -1.0, x: 22.0, ..DepthPlane::level(102.0) }, 6, before),
            (DepthPlane { dx: -1.0, x: 24.0, ..DepthPlane::level(101.0) }, 6, strip),
            (DepthPlane { dx: 1.0, x: 10.0, ..DepthPlane::level(101.0) }, 6, strip),
            (DepthPlane { dy: 1.0, y: 23.0, ..DepthPlane::level(100.5) }, 6, before),
        ] {
            assert_eq!(BEFORE.leaves(&plane, rank, before), left, "{plane:?}, rank {rank}");
        }
    }
}
