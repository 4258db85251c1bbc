//! How far away the pixels of cells are already covered, by a plane for each: see [`occlusion`](super::occlusion).

use fearless_simd::prelude::*;
use fearless_simd::Simd;

use super::lanes::{inlined, WideF, WideU, WIDE};
use super::occlusion::{DepthPlane, TILE_PX};
use super::screen::FARTHEST;

/// What is known of cells of one size: a plane for each.
#[derive(Debug, Default)]
pub(super) struct Cells {
    /// The plane at the cell's middle, in two parts whose sum has more digits than one; infinite where there is none.
    middle: Vec<f32>,
    rest: Vec<f32>,
    dx: Vec<f32>,
    dy: Vec<f32>,
    noise: Vec<f32>,
    /// No pixel of the cell is farther away; infinite where there is no plane.
    pub farthest: Vec<f32>,
    /// None of the pixels that are as far away as that has a lower one.
    pub rank: Vec<u32>,
}

/// The numbers from `begin` on, which must exist.
#[inline(always)]
fn load<S: Simd>(simd: S, all: &[f32], begin: usize) -> WideF<S> {
    let numbers = all.get(begin..).and_then(<[f32]>::first_chunk);
    numbers.map_or(WideF::splat(simd, 0.0), |numbers| WideF::load_array_ref(simd, numbers))
}

/// From the middle of a cell of this side to the middle of its last pixel.
pub(super) const fn half(side_px: i32) -> f32 {
    (side_px - 1) as f32 * 0.5
}

impl Cells {
    /// Forgets all, for so many cells.
    pub(super) fn reset(&mut self, count: usize) {
        for numbers in [&mut self.rest, &mut self.dx, &mut self.dy, &mut self.noise] {
            numbers.clear();
            numbers.resize(count, 0.0);
        }
        for numbers in [&mut self.middle, &mut self.farthest] {
            numbers.clear();
            numbers.resize(count, f32::INFINITY);
        }
        self.rank.clear();
        self.rank.resize(count, 0);
    }

    /// In which of [`WIDE`] cells from `begin` on something of a face may be seen, given their middles, and how far
    /// from their middles to the right and down the face's pixels are.
    #[inline(always)]
    pub(super) fn seen<S: Simd>(
        &self,
        simd: S,
        plane: &DepthPlane,
        rank: u32,
        begin: usize,
        [x, y]: [WideF<S>; 2],
        [columns, rows]: [[WideF<S>; 2]; 2],
    ) -> u32 {
        let numbers = inlined(
            #[inline(always)]
            |all: &[f32]| load(simd, all, begin),
        );
        let ranks = self.rank.get(begin..).and_then(<[u32]>::first_chunk);
        let is_earlier = ranks.map_or(WideU::splat(simd, 0), |ranks| WideU::load_array_ref(simd, ranks)).simd_gt(rank);
        let apart = plane.at - numbers(&self.middle);
        let (right, down) = ((x - plane.x) * plane.dx, (y - plane.y) * plane.dy);
        let (dx, dy) = (plane.dx - numbers(&self.dx), plane.dy - numbers(&self.dy));
        // Where the planes are nearest to each other.
        let (along_row, along_column) = ((dx * columns[0]).min(dx * columns[1]), (dy * rows[0]).min(dy * rows[1]));
        let behind = (apart + (right + down)) + ((along_row + along_column) - numbers(&self.rest));
        // Beside the planes' noise, that of the sums here.
        let sums = (apart.abs() + (right.abs() + down.abs())) + (along_row.abs() + along_column.abs());
        let unsure = sums * (1.0 / (1 << 20) as f32);
        let unsure = unsure + (numbers(&self.noise) + plane.noise);
        let is_hidden = behind.simd_gt(unsure) | (behind.simd_ge(unsure) & is_earlier);
        // The plane of a steep face leads far before it, but nothing of the face is nearer than its nearest corner.
        let (least, farthest) = (WideF::splat(simd, plane.least), numbers(&self.farthest));
        let is_hidden = is_hidden | least.simd_gt(farthest) | (least.simd_ge(farthest) & is_earlier);
        !(is_hidden.to_bitmask() as u32) & ((1 << WIDE) - 1)
    }

    /// As [`seen`](Self::seen), whatever the rank, of a face that ends where a limit is positive. The limit is given by
    /// its values at the cells' middles and its changes to the right and down.
    #[inline(always)]
    pub(super) fn seen_within<S: Simd>(
        &self,
        simd: S,
        plane: &DepthPlane,
        begin: usize,
        [x, y]: [WideF<S>; 2],
        [columns, rows]: [[WideF<S>; 2]; 2],
        [limit, limit_dx, limit_dy]: [WideF<S>; 3],
    ) -> u32 {
        let numbers = inlined(
            #[inline(always)]
            |all: &[f32]| load(simd, all, begin),
        );
        let least = inlined(
            #[inline(always)]
            |dx: WideF<S>, dy: WideF<S>| (dx * columns[0]).min(dx * columns[1]) + (dy * rows[0]).min(dy * rows[1]),
        );
        let is_beside = (limit + least(limit_dx, limit_dy)).simd_gt(0.0);
        let apart = plane.at - numbers(&self.middle);
        let (right, down) = ((x - plane.x) * plane.dx, (y - plane.y) * plane.dy);
        let (dx, dy) = (plane.dx - numbers(&self.dx), plane.dy - numbers(&self.dy));
        // What is not positive on the face may be added any number of times and still gives a bound. So many times turn
        // the difference between the planes along the limit, so that the bound is the greatest.
        let zero = WideF::splat(simd, 0.0);
        let times = (zero - (dx * limit_dx + dy * limit_dy)) / (limit_dx * limit_dx + limit_dy * limit_dy);
        let times = times.max(0.0);
        let (more, more_dx, more_dy) = (times * limit, times * limit_dx, times * limit_dy);
        let along = least(dx + more_dx, dy + more_dy);
        let behind = (apart + (right + down)) + more + (along - numbers(&self.rest));
        let sums = (apart.abs() + (right.abs() + down.abs())) + (along.abs() + more.abs());
        let slopes = (dx.abs() + more_dx.abs() + dy.abs() + more_dy.abs()) * TILE_PX as f32;
        let unsure = (sums + slopes) * (1.0 / (1 << 20) as f32) + (numbers(&self.noise) + plane.noise);
        let is_hidden = is_beside | behind.simd_gt(unsure);
        !(is_hidden.to_bitmask() as u32) & ((1 << WIDE) - 1)
    }

    /// The largest of what a cell's depths are above a plane of these slopes that has depth 0 in the cell's middle.
    pub(super) fn bound_along(&self, cell: usize, [dx, dy]: [f64; 2], half: f32) -> f64 {
        let slopes = (f64::from(self.dx[cell]) - dx).abs() + (f64::from(self.dy[cell]) - dy).abs();
        let middle = f64::from(self.middle[cell]) + f64::from(self.rest[cell]);
        middle + slopes * f64::from(half) + f64::from(self.noise[cell])
    }

    /// Takes the plane of a face that covers a cell, given where its middle is and half of its side, if it is nearer
    /// than the one that is there; says whether it is.
    pub(super) fn offer(&mut self, plane: &DepthPlane, rank: u32, cell: usize, [x, y]: [f64; 2], half: f32) -> bool {
        let value = plane.value(x, y);
        let reach = (f64::from(plane.dx.abs()) + f64::from(plane.dy.abs())) * f64::from(half) + f64::from(plane.noise);
        // Depths are clamped outside of these, so that a plane says less about them.
        if !(value - reach > 0.0 && value + reach < f64::from(FARTHEST)) {
            return false;
        }
        let Some(middle) = self.middle.get_mut(cell) else { return false };
        let known = f64::from(*middle) + f64::from(self.rest[cell]) + f64::from(self.noise[cell]);
        let offered = value + f64::from(plane.noise);
        if offered > known || (offered == known && rank <= self.rank[cell]) {
            return false;
        }
        *middle = value as f32;
        self.rest[cell] = (value - f64::from(*middle)) as f32;
        (self.dx[cell], self.dy[cell]) = (plane.dx, plane.dy);
        (self.noise[cell], self.rank[cell]) = (plane.noise, rank);
        self.farthest[cell] = not_below(value + reach);
        true
    }
}

/// The smallest number that is not below this one.
pub(super) fn not_below(exact: f64) -> f32 {
    let rounded = exact as f32;
    if f64::from(rounded) < exact {
        rounded.next_up()
    } else {
        rounded
    }
}
