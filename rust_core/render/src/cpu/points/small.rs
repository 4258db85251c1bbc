//! A small face that is drawn tile by tile: see [`ranked`](super::ranked).

use fearless_simd::prelude::*;
use fearless_simd::Simd;

use super::paint::{first_row_of, in_disc, in_row, FacePaint, DISC};
use super::place::{FaceBlock, Plane, DEPTH, EDGES, PLACE};
use crate::cpu::band::Band;
use crate::cpu::cells::half;
use crate::cpu::lanes::{inlined, lane_indices, map, wide_indices, WideF, F, I, M};
use crate::cpu::occlusion::{rounding, Area, DepthPlane, TILE_PX};
use crate::cpu::screen::{FARTHEST, SUBPIXELS};
use crate::shading::DISC_RADIUS_SQUARED;

/// A bound of a small face's depths, and its pixels.
#[inline(always)]
pub(super) fn depths_of(faces: &FaceBlock, i: usize) -> (DepthPlane, Area) {
    let [left, right, top, bottom] = faces.bounds.each_ref().map(|all| all[i]);
    let area = Area { left, right, top, bottom };
    let [at, dx, dy] = faces.plane(DEPTH, i);
    let first_row = faces.first_rows[i];
    let (columns, rows) = ((right - left) as f32, (bottom - first_row) as f32);
    let noise = if dx == 0.0 && dy == 0.0 {
        0.0
    } else {
        let (right, down) = (dx.abs() * columns, dy.abs() * rows);
        let from_first = right + down;
        let depth = (at.abs() + from_first).min(2.0 * FARTHEST);
        1.01 * (rounding(right) + rounding(down) + rounding(from_first) + rounding(depth))
    };
    // At the nearest corner of its pixels.
    let row = if dy < 0.0 { rows - 1.0 } else { (top - first_row) as f32 };
    let least = at + dx.min(0.0) * (columns - 1.0) + dy * row - noise;
    (DepthPlane { at, dx, dy, x: left as f32, y: first_row as f32, noise, least }, area)
}

/// A small face, ready to be drawn.
pub(super) struct SmallFace<S: Simd, const PAINT: u8> {
    simd: S,
    pub depths: DepthPlane,
    /// Its pixels in the band.
    pub area: Area,
    /// The row from which all below is measured.
    first_row: i32,
    edges: [Plane<i32>; EDGES],
    /// 1/w, u/w and v/w.
    places: [Plane<f32>; 3],
    paint: FacePaint<S, PAINT>,
}

impl<S: Simd, const PAINT: u8> SmallFace<S, PAINT> {
    /// A face of a block that was traced, given what [`depths_of`] says of it; of a box it is the side along or against
    /// an axis.
    #[inline(always)]
    pub(super) fn new(
        simd: S,
        faces: &FaceBlock,
        i: usize,
        (depths, area): (DepthPlane, Area),
        axis: usize,
        color: u32,
    ) -> Self {
        Self {
            simd,
            depths,
            area,
            first_row: faces.first_rows[i],
            edges: [faces.edge(0, i), faces.edge(1, i), faces.edge(2, i), faces.edge(3, i)],
            places: [faces.plane(PLACE, i), faces.plane(PLACE + 1, i), faces.plane(PLACE + 2, i)],
            paint: FacePaint::new(simd, color, axis, faces.along & 1 << i != 0),
        }
    }

    /// Draws the pixels of a tile. Returns whether something is seen.
    #[inline(always)]
    pub(super) fn draw(&self, tile: Area, rank: u32, band: &mut Band<'_>) -> bool {
        let Area { top, bottom, .. } = self.area;
        let pixels = Area { top: tile.top.max(top), bottom: tile.bottom.min(bottom), ..tile };
        // A disc is seen in one of three tiles that are drawn, which needs no colours to be known; others are in more.
        if PAINT == DISC {
            let seen = self.seen(pixels, band);
            self.draw_seen(seen, pixels, rank, band)
        } else {
            self.draw_all(pixels, rank, band)
        }
    }

    /// Draws the pixels of a tile row by row.
    #[inline(always)]
    fn draw_all(&self, pixels: Area, rank: u32, band: &mut Band<'_>) -> bool {
        let Self { simd, depths, area, first_row, edges, places, ref paint } = *self;
        let columns = lane_indices(simd) + (pixels.left - area.left);
        let rows = pixels.top - first_row;
        let mut edges_at = map(
            edges,
            #[inline(always)]
            |[at, dx, dy]| columns * dx + (at + dy * rows),
        );
        let columns = columns.to_float::<F<S>>();
        let from_first = columns * depths.dx;
        let first_places = first_row_of::<S, _, PAINT>(places, columns);
        let mut row = rows as f32;
        let mut is_seen = false;
        band.for_ranked_windows(
            pixels.top..pixels.bottom,
            pixels.left,
            #[inline(always)]
            |window| {
                let [e0, e1, e2, e3] = edges_at;
                let mask = ((e0 | e1) | (e2 | e3)).simd_ge(I::splat(simd, 0));
                is_seen |= window.meet(
                    mask,
                    (from_first + depths.dy * row) + depths.at,
                    rank,
                    #[inline(always)]
                    |seen| {
                        let places_at = in_row::<S, _, PAINT>(first_places, places, F::splat(simd, row));
                        (paint.mask(places_at, seen), paint.colors(places_at))
                    },
                );
                for k in 0..EDGES {
                    edges_at[k] += edges[k][2];
                }
                row += 1.0;
            },
        );
        is_seen
    }

    /// The pixels of a tile in which a face is not farther away than what is there: a bit for each, row by row.
    #[inline(always)]
    fn seen(&self, pixels: Area, band: &Band<'_>) -> u64 {
        let Self { simd, depths, area, first_row, edges, places, .. } = *self;
        let lane = wide_indices(simd);
        let columns = (lane & (TILE_PX - 1)) + (pixels.left - area.left);
        let rows = (lane >> TILE_PX.ilog2()) + (pixels.top - first_row);
        let mut edges_at = map(
            edges,
            #[inline(always)]
            |[at, dx, dy]| columns * dx + at + rows * dy,
        );
        let (columns, mut row) = (columns.to_float::<WideF<S>>(), rows.to_float::<WideF<S>>());
        let from_first = columns * depths.dx;
        let first_places = first_row_of::<S, _, PAINT>(places, columns);
        let (mut seen, mut bit) = (0, 0);
        band.for_row_pairs(
            simd,
            pixels.top..pixels.bottom,
            pixels.left,
            #[inline(always)]
            |behind| {
                let [e0, e1, e2, e3] = edges_at;
                let mut mask = ((e0 | e1) | (e2 | e3)).simd_ge(0);
                mask &= ((from_first + row * depths.dy) + depths.at).simd_le(behind);
                if PAINT == DISC {
                    mask &= in_disc(in_row::<S, _, PAINT>(first_places, places, row));
                }
                seen |= mask.to_bitmask() << bit;
                bit += 2 * TILE_PX;
                for k in 0..EDGES {
                    edges_at[k] += 2 * edges[k][2];
                }
                row += 2.0;
            },
        );
        seen
    }

    /// Draws those pixels of a tile that are [seen](Self::seen), unless equally far ones there have a higher rank.
    #[inline(always)]
    fn draw_seen(&self, mut seen: u64, pixels: Area, rank: u32, band: &mut Band<'_>) -> bool {
        let Self { simd, depths, area, first_row, places, ref paint, .. } = *self;
        let columns = (lane_indices(simd) + (pixels.left - area.left)).to_float::<F<S>>();
        let from_first = columns * depths.dx;
        let first_places = first_row_of::<S, _, PAINT>(places, columns);
        let mut is_seen = false;
        while seen != 0 {
            let row = seen.trailing_zeros() as i32 / TILE_PX;
            let of_row = seen >> (row * TILE_PX) & ((1 << TILE_PX) - 1);
            seen ^= of_row << (row * TILE_PX);
            let row = pixels.top + row;
            let down = (row - first_row) as f32;
            band.for_ranked_windows(
                row..row + 1,
                pixels.left,
                #[inline(always)]
                |window| {
                    is_seen |= window.meet(
                        M::from_bitmask(simd, of_row),
                        (from_first + depths.dy * down) + depths.at,
                        rank,
                        #[inline(always)]
                        |seen| {
                            let places_at = in_row::<S, _, PAINT>(first_places, places, F::splat(simd, down));
                            (seen, paint.colors(places_at))
                        },
                    );
                },
            );
        }
        is_seen
    }

    /// Whether the face surely covers some pixels.
    #[inline(always)]
    pub(super) fn covers(&self, pixels: Area) -> bool {
        let Area { left, right, top, bottom } = self.area;
        let corners = [
            [pixels.left, pixels.top],
            [pixels.right - 1, pixels.top],
            [pixels.left, pixels.bottom - 1],
            [pixels.right - 1, pixels.bottom - 1],
        ];
        corners.iter().all(|[x, y]| {
            // Beyond the face's bounds an edge's value might not fit into its number.
            let is_within = *x >= left && *y >= top && *x < right && *y < bottom;
            let (x, y) = (x - left, y - self.first_row);
            let is_inside = is_within && self.edges.iter().all(|[at, dx, dy]| at + dx * x + dy * y >= 0);
            is_inside && (PAINT != DISC || is_in_disc(&self.places, x as f32, y as f32))
        })
    }

    /// Whether to look for tiles beside the face, by its [limit](Self::limit): of a face that is about as wide as its
    /// bounds there are too few.
    #[inline(always)]
    pub(super) fn leaves_tiles_out(&self) -> bool {
        PAINT == DISC || is_turned(&self.edges)
    }

    /// What is positive only beside the face, given the middles of some tiles: its values there, and its changes to the
    /// right and down.
    #[inline(always)]
    pub(super) fn limit(&self, [x, y]: [WideF<S>; 2]) -> [WideF<S>; 3] {
        let from_first = [x - self.area.left as f32, y - self.first_row as f32];
        if PAINT == DISC {
            limit_of_disc(&self.places, from_first)
        } else {
            limit_of_edges(&self.edges, from_first)
        }
    }
}

/// What is positive only beside a disc, beyond a line along its rim where that is nearest to the middle of a tile,
/// given by its pixel from the face's first one: its value there, and its changes to the right and down.
#[inline(always)]
fn limit_of_disc<S: Simd>(places: &[[f32; 3]; 3], [x, y]: [WideF<S>; 2]) -> [WideF<S>; 3] {
    const HALF: f32 = half(TILE_PX);
    let [q, u, v] = map(
        *places,
        #[inline(always)]
        |[at, dx, dy]| x * dx + at + y * dy,
    );
    // The square of the distance from the disc's middle, less that of its radius. It lies above the plane that touches
    // it, but for what the square of 1/w bends the other way.
    let (distance, radius) = (u * u + v * v, q * DISC_RADIUS_SQUARED);
    let change = inlined(
        #[inline(always)]
        |i: usize| (u * places[1][i] + v * places[2][i] - radius * places[0][i]) * 2.0,
    );
    let [_, q_right, q_down] = places[0];
    let bend = (q_right.abs() + q_down.abs()) * HALF;
    let bend = bend * bend * DISC_RADIUS_SQUARED;
    [distance - q * radius - ((distance + q * q) * 2e-4 + bend), change(1), change(2)]
}

/// Whether an edge of a face runs across several tiles in both directions.
#[inline(always)]
fn is_turned(edges: &[[i32; 3]; EDGES]) -> bool {
    const ACROSS: i32 = 3 * TILE_PX * SUBPIXELS;
    edges.iter().any(|[_, dx, dy]| dx.abs().min(dy.abs()) >= ACROSS)
}

/// What is positive only beyond the edge of a face that is the nearest to a place, or farthest beyond.
#[inline(always)]
fn limit_of_edges<S: Simd>(edges: &[[i32; 3]; EDGES], [x, y]: [WideF<S>; 2]) -> [WideF<S>; 3] {
    let simd = x.token();
    let splat = |value: f32| WideF::splat(simd, value);
    let mut limit = [splat(f32::NEG_INFINITY), splat(0.0), splat(0.0)];
    for [at, dx, dy] in edges.map(|edge| edge.map(|value| -value as f32)) {
        let (right, down) = (x * dx, y * dy);
        let beyond = (right + at) + down;
        let beyond = beyond - ((right.abs() + down.abs()) + at.abs()) * 1e-6;
        let is_nearer = beyond.simd_gt(limit[0]);
        for (known, value) in limit.iter_mut().zip([beyond, splat(dx), splat(dy)]) {
            *known = is_nearer.select(value, *known);
        }
    }
    limit
}

/// Whether a place on a face, given by its pixel from the first one, surely is in its disc.
fn is_in_disc(places: &[[f32; 3]; 3], x: f32, y: f32) -> bool {
    let [q, u, v] = places.map(|[at, dx, dy]| at + dx * x + dy * y);
    u * u + v * v < q * q * (DISC_RADIUS_SQUARED * 0.999)
}
