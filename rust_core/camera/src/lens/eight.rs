//! Warp of eight pixels at once.
//!
//! The source pixels around a run's places are mostly consecutive: then the eight upper left neighbours are in a row,
//! and so are the three other ones. A lens that stretches or turns its image breaks that order now and then, by
//! skipping or repeating a source pixel or changing the row. Each order is then loaded as if it were that of the whole
//! run, and each pixel selects its own.
//!
//! Each channel has 16 bits while it is interpolated; two channels of all eight pixels are one vector. Compiled for
//! each instruction set: functions are `#[inline(always)]`.

use fearless_simd::prelude::*;
use fearless_simd::{i32x8, mask32x8, u16x16, u32x8, u8x32};
use rcs_scene::MapRun;

use super::Source;

/// Pixels at once: a whole run.
const LANES: usize = MapRun::PIXELS;

/// Bytes of a pixel.
const CELL: usize = 4;

/// Writes the pixels of a whole run. `None`, and nothing is written, where that would read beyond the source.
#[inline(always)]
pub(super) fn write<S: Simd>(
    simd: S,
    source: &Source<'_>,
    run: MapRun,
    pixels: &mut [[u8; CELL]; LANES],
) -> Option<()> {
    let neighbors = Neighbors::of_run(simd, source, run)?;
    let colors = if neighbors.are_alike() { neighbors.above[0] } else { neighbors.mixed(simd, run) };
    let colors: u8x32<S> = colors.bitcast();
    colors.store_array(pixels.as_flattened_mut().first_chunk_mut()?);
    Some(())
}

/// Neighbours of eight places: the left and the right one of each row.
#[derive(Clone, Copy, Debug)]
struct Neighbors<S: Simd> {
    above: [u32x8<S>; 2],
    below: [u32x8<S>; 2],
}

impl<S: Simd> Neighbors<S> {
    #[inline(always)]
    fn of_run(simd: S, source: &Source<'_>, run: MapRun) -> Option<Self> {
        let MapRun { place, step } = run;
        let end = [place[0] + (LANES as i32 - 1) * step[0], place[1] + (LANES as i32 - 1) * step[1]];
        let first = source.index(place);
        let side_by_side = Self::side_by_side(simd, source, first)?;
        // Places change evenly, so that nothing between them is out of order if the last one is not.
        let moved = [(end[0] >> 16) - (place[0] >> 16), (end[1] >> 16) - (place[1] >> 16)];
        if moved == [LANES as i32 - 1, 0] {
            return Some(side_by_side);
        }
        side_by_side.and_other_orders(simd, source, run)
    }

    /// Replaces the neighbours of places that are in another order.
    #[inline(always)]
    fn and_other_orders(mut self, simd: S, source: &Source<'_>, run: MapRun) -> Option<Self> {
        let MapRun { place, step } = run;
        let lanes = i32x8::load_array(simd, [0, 1, 2, 3, 4, 5, 6, 7]);
        let x = (lanes * step[0] + place[0]) >> 16;
        let y = (lanes * step[1] + place[1]) >> 16;
        // Index of the first pixel's neighbour if all were in the order of this one.
        let first = y * source.width + (x - lanes);
        let all = first.to_array();
        // Mostly there are two, that of the first pixel and that of the last one.
        let mut order = all[LANES - 1];
        let mut missing = !first.simd_eq(all[0]);
        loop {
            let in_this_order = first.simd_eq(order);
            self = Self::side_by_side(simd, source, order)?.or(self, in_this_order);
            missing &= !in_this_order;
            let Some(next) = all.get(missing.to_bitmask().trailing_zeros() as usize) else { break };
            order = *next;
        }
        Some(self)
    }

    /// Neighbours of consecutive places, by the index of the first one's upper left neighbour. `None` beside the
    /// source.
    #[inline(always)]
    fn side_by_side(simd: S, source: &Source<'_>, first: i32) -> Option<Self> {
        let begin = usize::try_from(first).ok()? * CELL;
        let above = neighbors_of_row(simd, source.bytes, begin)?;
        let below = neighbors_of_row(simd, source.below, begin)?;
        Some(Self { above, below })
    }

    /// These for the pixels of the mask, and others for the rest.
    #[inline(always)]
    fn or(self, others: Self, mask: mask32x8<S>) -> Self {
        let ([a, b], [c, d]) = (self.above, self.below);
        let ([e, f], [g, h]) = (others.above, others.below);
        Self { above: [mask.select(a, e), mask.select(b, f)], below: [mask.select(c, g), mask.select(d, h)] }
    }

    /// `true` if no pixel has neighbours of two colours, so that nothing is to be interpolated.
    #[inline(always)]
    fn are_alike(&self) -> bool {
        let ([a, b], [c, d]) = (self.above, self.below);
        ((a ^ b) | (a ^ c) | (a ^ d)).simd_eq(0).all_true()
    }

    /// The colours at a run's places.
    #[inline(always)]
    fn mixed(self, simd: S, run: MapRun) -> u32x8<S> {
        let [right, down] = [fractions(simd, run.place[0], run.step[0]), fractions(simd, run.place[1], run.step[1])];
        let ([a, b], [c, d]) = (self.above, self.below);
        let even = between(between(even(a), even(c), down), between(even(b), even(d), down), right);
        let odd = between(between(odd(a), odd(c), down), between(odd(b), odd(d), down), right);
        (even | (odd << 8)).bitcast()
    }
}

/// Eight pixels from a byte on, and those to their right.
#[inline(always)]
fn neighbors_of_row<S: Simd>(simd: S, bytes: &[u8], begin: usize) -> Option<[u32x8<S>; 2]> {
    let bytes = bytes.get(begin..)?.first_chunk::<{ (LANES + 1) * CELL }>()?;
    let [left, right] = [bytes.first_chunk()?, bytes.last_chunk()?];
    Some([u8x32::load_array_ref(simd, left).bitcast(), u8x32::load_array_ref(simd, right).bitcast()])
}

/// The fractions of eight coordinates in 1/256, each twice.
#[inline(always)]
fn fractions<S: Simd>(simd: S, place: i32, step: i32) -> u16x16<S> {
    let lanes = u16x16::load_array(simd, [0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 5, 5, 6, 6, 7, 7]);
    // What is more than a fraction leaves the 16 bits.
    (lanes * step as u16 + place as u16) >> 8
}

/// Two of a pixel's channels.
#[inline(always)]
fn even<S: Simd>(pixels: u32x8<S>) -> u16x16<S> {
    pixels.bitcast::<u16x16<S>>() & 0xff
}

/// The two others.
#[inline(always)]
fn odd<S: Simd>(pixels: u32x8<S>) -> u16x16<S> {
    pixels.bitcast::<u16x16<S>>() >> 8
}

/// Like [`super::between`]; the sum fits into 16 bits, whatever the difference borrows before.
#[inline(always)]
fn between<S: Simd>(first: u16x16<S>, second: u16x16<S>, share: u16x16<S>) -> u16x16<S> {
    ((first << 8) + (second - first) * share + 128) >> 8
}
