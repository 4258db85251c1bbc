//! `Style: Points`: round spots of a fixed size on the picture.
//!
//! A pixel belongs to the spot where its centre lies less than half the size from the point's place, so that a spot of
//! 1 px can miss every pixel centre. A point whose place is outside of the picture is not drawn at all, however far
//! its spot would reach inside. A spot has one depth, that of its place.

use fearless_simd::prelude::*;
use fearless_simd::Simd;
use rcs_scene::{PointStyle, Points};

use super::band::Band;
use super::lanes::{load, map, numbers, store, store_whole, transform, whole, F, LANES, U};
use super::points::{Cloud, Gathered, BLOCK};
use super::screen::{Screen, FARTHEST};

/// The largest spot, in pixels, as on Mesa's software rasteriser.
const LARGEST_PX: f32 = 255.0;

/// The spots' diameter in pixels; none where the cloud has another style.
pub(super) fn diameter_px(points: &Points) -> Option<f32> {
    match points.style {
        PointStyle::Points { diameter_px } => Some(if diameter_px > 0.0 { diameter_px.min(LARGEST_PX) } else { 0.0 }),
        _ => None,
    }
}

/// What is the same for all spots.
struct Frame<'a> {
    cloud: &'a Cloud<'a>,
    half_size: (f32, f32),
    width_px: f32,
    /// The band's first row and the one after its last.
    rows: [f32; 2],
    diameter_px: f32,
}

/// Spots on the picture.
struct Block {
    x: [f32; BLOCK],
    y: [f32; BLOCK],
    depth: [f32; BLOCK],
    /// The first pixel and the one after the last of those that a spot may touch along a row, and the same along a
    /// column; none where it is not drawn.
    bounds: [[i32; BLOCK]; 4],
}

impl Block {
    /// Projects the points from `begin` on.
    #[inline(always)]
    fn project<S: Simd>(&mut self, simd: S, frame: &Frame<'_>, places: &[[f32; BLOCK]; 3], begin: usize) {
        let [x, y, z] = places;
        let place = [load(simd, x, begin), load(simd, y, begin), load(simd, z, begin)];
        let [x, y, z, w] = transform(&frame.cloud.placement.clip_from_object, place);
        let is_inside = w.simd_gt(0.0) & z.simd_ge(-w) & z.simd_le(w) & x.abs().simd_le(w) & y.abs().simd_le(w);
        let inverse_w = 1.0 / w;
        let (half_width, half_height) = frame.half_size;
        let (x, y) = ((x * inverse_w) * half_width + half_width, half_height - (y * inverse_w) * half_height);
        store(&mut self.x, begin, x);
        store(&mut self.y, begin, y);
        store(&mut self.depth, begin, (z * inverse_w) * (0.5 * FARTHEST) + 0.5 * FARTHEST);
        let reach = frame.diameter_px * 0.5 + 0.5;
        let columns = [(x - reach).ceil().max(0.0), (x + reach).ceil().min(frame.width_px)];
        let rows = [(y - reach).ceil().max(frame.rows[0]), (y + reach).ceil().min(frame.rows[1])];
        let [left, right] = map(columns, whole);
        let [top, bottom] = map(rows, whole);
        let right = is_inside.select(right, left);
        for (all, value) in self.bounds.iter_mut().zip([left, right, top, bottom]) {
            store_whole(all, begin, value);
        }
    }
}

/// Draws the rows of a band.
#[inline(always)]
pub(super) fn draw<S: Simd>(
    simd: S,
    cloud: &Cloud<'_>,
    indices: &[u32],
    screen: &Screen,
    points: &mut Gathered,
    band: &mut Band<'_>,
) {
    let Some(diameter_px) = diameter_px(cloud.points).filter(|&diameter_px| diameter_px > 0.0) else { return };
    let mode = cloud.surface.mode;
    let per_px = 1.0 / diameter_px;
    let frame = Frame {
        cloud,
        half_size: screen.half_size(),
        width_px: band.width as f32,
        rows: [band.first_row as f32, band.end_row as f32],
        diameter_px,
    };
    let mut block = Block { x: [0.0; BLOCK], y: [0.0; BLOCK], depth: [0.0; BLOCK], bounds: [[0; BLOCK]; 4] };
    let numbers = numbers(simd).to_float::<F<S>>();
    for indices in indices.chunks(BLOCK) {
        points.gather(cloud, indices);
        for begin in (0..points.len).step_by(LANES) {
            block.project(simd, &frame, &points.places, begin);
        }
        for i in 0..points.len {
            let [left, right, top, bottom] = block.bounds.each_ref().map(|all| all[i]);
            let depths = F::splat(simd, block.depth[i]);
            let colors = U::splat(simd, points.colors[i]);
            for begin in (left..right).step_by(LANES) {
                let dx = (numbers + (begin as f32 + 0.5 - block.x[i])) * per_px;
                let dx_squared = dx * dx;
                let mut dy = F::splat(simd, top as f32 + 0.5 - block.y[i]);
                band.for_windows(
                    top..bottom,
                    begin,
                    #[inline(always)]
                    |window| {
                        let scaled = dy * per_px;
                        let mask = (dx_squared + scaled * scaled).simd_lt(0.25);
                        window.meet(
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
}
