//! `Style: Points`: round points of a fixed size on the image, drawn as OpenGL draws point sprites.
//!
//! A pixel belongs to a point where its centre lies less than half the size from the point's position, so that a point
//! of 1 px can miss every pixel centre. No point is smaller than that: see [`drawn_point_size_px`]. A point whose
//! position is outside of the image is not drawn at all, however far its disc would reach inside. A disc has one
//! depth, that of its point.

use fearless_simd::prelude::*;
use fearless_simd::Simd;

use super::faces::diameter_px;
use super::place::BandView;
use super::{Cloud, PointScratch, BLOCK};
use crate::cpu::tile::band::Band;
use crate::cpu::tile::lanes::{lane_indices, load, map, store, store_integers, to_integers, transform, F, LANES, U};
use crate::cpu::tile::screen::{Screen, FARTHEST};
use crate::shading::DISC_RADIUS_SQUARED;

/// The points that are drawn, and the band that they are drawn in.
struct SpriteBand<'a> {
    cloud: &'a Cloud<'a>,
    view: BandView,
    diameter_px: f32,
}

/// A block of points on the image.
#[derive(Debug)]
pub(super) struct SpriteBlock {
    x: [f32; BLOCK],
    y: [f32; BLOCK],
    depth: [f32; BLOCK],
    /// The first pixel and the one after the last of those that a point may touch along a row, and the same along a
    /// column; none where it is not drawn.
    bounds: [[i32; BLOCK]; 4],
}

impl Default for SpriteBlock {
    fn default() -> Self {
        Self { x: [0.0; BLOCK], y: [0.0; BLOCK], depth: [0.0; BLOCK], bounds: [[0; BLOCK]; 4] }
    }
}

impl SpriteBlock {
    /// Projects the points from `begin` on.
    #[inline(always)]
    fn project<S: Simd>(&mut self, simd: S, in_band: &SpriteBand<'_>, positions: &[[f32; BLOCK]; 3], begin: usize) {
        let [x, y, z] = positions;
        let position = [load(simd, x, begin), load(simd, y, begin), load(simd, z, begin)];
        let [x, y, z, w] = transform(&in_band.cloud.transform.clip_from_object, position);
        let is_inside = w.simd_gt(0.0) & z.simd_ge(-w) & z.simd_le(w) & x.abs().simd_le(w) & y.abs().simd_le(w);
        let inverse_w = 1.0 / w;
        let (half_width, half_height) = in_band.view.half_size;
        let (x, y) = ((x * inverse_w) * half_width + half_width, half_height - (y * inverse_w) * half_height);
        store(&mut self.x, begin, x);
        store(&mut self.y, begin, y);
        store(&mut self.depth, begin, (z * inverse_w) * (0.5 * FARTHEST) + 0.5 * FARTHEST);
        let extent = in_band.diameter_px * 0.5 + 0.5;
        let columns = [(x - extent).ceil().max(0.0), (x + extent).ceil().min(in_band.view.width_px)];
        let rows = [(y - extent).ceil().max(in_band.view.rows[0]), (y + extent).ceil().min(in_band.view.rows[1])];
        let [left, right] = map(columns, to_integers);
        let [top, bottom] = map(rows, to_integers);
        let right = is_inside.select(right, left);
        for (all, value) in self.bounds.iter_mut().zip([left, right, top, bottom]) {
            store_integers(all, begin, value);
        }
    }

    /// Draws a point of a packed colour.
    #[inline(always)]
    fn draw<S: Simd>(&self, simd: S, in_band: &SpriteBand<'_>, (i, color): (usize, u32), band: &mut Band<'_>) {
        let (mode, per_px) = (in_band.cloud.surface.mode, 1.0 / in_band.diameter_px);
        let [left, right, top, bottom] = self.bounds.each_ref().map(|all| all[i]);
        let (depths, colors) = (F::splat(simd, self.depth[i]), U::splat(simd, color));
        let lane_indices = lane_indices(simd).to_float::<F<S>>();
        for begin in (left..right).step_by(LANES) {
            let dx = (lane_indices + (begin as f32 + 0.5 - self.x[i])) * per_px;
            let dx_squared = dx * dx;
            let mut dy = F::splat(simd, top as f32 + 0.5 - self.y[i]);
            band.for_windows(
                top..bottom,
                begin,
                #[inline(always)]
                |window| {
                    let scaled = dy * per_px;
                    let mask = (dx_squared + scaled * scaled).simd_lt(DISC_RADIUS_SQUARED);
                    window.write_fragments(
                        mask,
                        depths,
                        mode,
                        #[inline(always)]
                        |seen| (seen, colors),
                    );
                    dy += 1.0;
                },
            );
        }
    }
}

/// Draws points, given by their indices.
#[inline(always)]
pub(in crate::cpu) fn draw<S: Simd>(
    simd: S,
    cloud: &Cloud<'_>,
    indices: &[u32],
    screen: &Screen,
    scratch: &mut PointScratch,
    band: &mut Band<'_>,
) {
    let Some(diameter_px) = diameter_px(cloud.points) else { return };
    let in_band = SpriteBand { cloud, view: BandView::new(screen, band), diameter_px };
    let PointScratch { points, sprites, .. } = scratch;
    for indices in indices.chunks(BLOCK) {
        points.gather(cloud, indices, &[]);
        for begin in (0..points.len).step_by(LANES) {
            sprites.project(simd, &in_band, &points.positions, begin);
        }
        for i in 0..points.len {
            sprites.draw(simd, &in_band, (i, points.colors[i]), band);
        }
    }
}
