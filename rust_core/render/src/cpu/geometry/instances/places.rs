//! The places of a solid's vertices on the image, all at once.

use fearless_simd::prelude::*;

use super::shape::Shape;
use crate::cpu::geometry::vertices::VertexScratch;
use crate::cpu::tile::lanes::{load, map, store_integers, to_integers, transform, F, LANES};
use crate::cpu::tile::screen::{Screen, SUBPIXELS};

/// The memory of a thread that makes solids ready and draws them.
#[derive(Debug, Default)]
pub(in crate::cpu) struct InstanceScratch {
    /// The snapped places of a solid's corners, and the gaps between pixel centres that they are in.
    x: Vec<i32>,
    y: Vec<i32>,
    gaps: Vec<i32>,
    pub(super) vertices: VertexScratch,
}

impl InstanceScratch {
    /// A snapped place of the solid whose vertices were placed.
    #[inline]
    pub(in crate::cpu) fn place_of(&self, place: u32) -> [i32; 2] {
        [&self.x, &self.y].map(|all| all.get(place as usize).copied().unwrap_or_default())
    }

    /// The gaps that a place of the solid is in, whose vertices were placed.
    #[inline]
    pub(in crate::cpu) fn gap_of(&self, place: u32) -> i32 {
        self.gaps.get(place as usize).copied().unwrap_or_default()
    }
}

/// Places the vertices of a solid inside the view: their snapped places, and for each the gaps between the columns and
/// the rows of pixel centres that it is in, each as an odd number (an even one is a centre), packed into one.
#[inline(always)]
pub(in crate::cpu) fn place_vertices<S: Simd>(
    simd: S,
    shape: &Shape,
    rows: &[[f32; 4]; 4],
    screen: &Screen,
    scratch: &mut InstanceScratch,
) {
    let count = shape.coordinates[0].len();
    for memory in [&mut scratch.x, &mut scratch.y, &mut scratch.gaps] {
        memory.resize(count, 0);
    }
    let (half_width, half_height) = screen.half_size();
    let [x, y, z] = &shape.coordinates;
    for begin in (0..count).step_by(LANES) {
        let place = [load(simd, x, begin), load(simd, y, begin), load(simd, z, begin)];
        let [clip_x, clip_y, _, w] = transform(rows, place);
        let inverse_w = F::splat(simd, 1.0) / w;
        let window = [clip_x * inverse_w * half_width + half_width, clip_y * inverse_w * -half_height + half_height];
        let [x, y] = map(
            window,
            #[inline(always)]
            |window| {
                let scaled = (window - 0.5) * (SUBPIXELS as f32);
                let half = scaled.simd_ge(0.0).select(F::splat(simd, 0.5), F::splat(simd, -0.5));
                to_integers(scaled + half)
            },
        );
        let [gap_x, gap_y] = map(
            [x, y],
            #[inline(always)]
            |place| (place >> 8) + ((place + (SUBPIXELS - 1)) >> 8),
        );
        store_integers(&mut scratch.x, begin, x);
        store_integers(&mut scratch.y, begin, y);
        store_integers(&mut scratch.gaps, begin, (gap_x & 0xffff) | (gap_y << 16));
    }
}
