//! Drawing a cloud whose faces lie over each other many times, by [ranks](crate::cpu::ranked).
//!
//! Small faces are placed as always; [`paint`](super::paint)'s way over their pixels leads through the tiles of which
//! something may be seen. Of large faces only a plane below all of their depths is set up at first, several at once:
//! most are hidden and need no more. The triangles of the others are made and drawn one by one.

use fearless_simd::prelude::*;
use fearless_simd::{dispatch, Simd};

use super::paint::{first_row_of, in_row, place_faces, sides_of, FacePaint, DISC};
use super::place::{BandView, Batch, FaceBlock, AXES, DEPTH, EDGES, PLACE, SIDES};
use super::rough::RoughFaces;
use super::{Cloud, PointScratch, BLOCK};
use crate::cpu::band::Band;
use crate::cpu::lanes::{inlined, lane_indices, map, F, I, LANES};
use crate::cpu::occlusion::{rounding, Area, DepthPlane, Drawn, TILE_PX};
use crate::cpu::ranked::{in_chunk, RankedScratch, CHUNK};
use crate::cpu::screen::{Screen, FARTHEST, SUBPIXELS};
use crate::cpu::triangles;
use crate::shading::DISC_RADIUS_SQUARED;

/// After so many chunks it is asked again how far away a band is covered everywhere.
const CHUNKS_TO_ASK: usize = 128;

/// How many points were looked at, and how many of them were not too far away.
#[derive(Default)]
struct LookedAt {
    all: u32,
    near: u32,
}

impl LookedAt {
    /// Whether most points are hidden by those that came before. The others may come in any order then: in that of
    /// memory they come several times as fast.
    fn are_mostly_hidden(&self) -> bool {
        self.near < self.all / 8
    }
}

/// The points of a cloud that touch a band.
pub(super) struct Run<'a, I> {
    pub cloud: &'a Cloud<'a>,
    /// Their indices, by job.
    pub indices: I,
    pub first_rank: u32,
}

/// From which w on nothing of a cloud is seen where a band is covered everywhere up to some depth.
///
/// Depth grows with w alone where the view's depth does not depend on x and y, as always with rviz's cameras.
struct Range {
    /// Depth over w, from -1 to 1, is at least `far + near_w / w`.
    far: f64,
    near_w: f64,
    /// How far a face reaches from its point, in w.
    reach_w: f64,
}

impl Range {
    /// By how much of their magnitude sums of coordinates may be off, generously.
    const ROUNDING: f64 = 4e-6;

    /// None where that does not hold.
    fn of(cloud: &Cloud<'_>) -> Option<Self> {
        let [.., z, w] = cloud.transform.clip_from_object.map(|row| row.map(f64::from));
        let dot = |a: &[f64; 4], b: &[f64; 4]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let scale = dot(&w, &w).sqrt();
        let far = dot(&z, &w) / dot(&w, &w);
        let is_along = [0, 1, 2].iter().all(|&i| (z[i] - far * w[i]).abs() < 1e-6 * scale);
        // Coordinates in the cloud's frame are as large as its distance.
        let from_eye = cloud.faces.eye().map(f64::from).iter().map(|c| c * c).sum::<f64>().sqrt() * scale;
        let near_w = z[3] - far * w[3];
        let reach_w = scale * f64::from(cloud.faces.reach_m()) + Self::ROUNDING * from_eye;
        (is_along && near_w < 0.0 && !cloud.points.auto_size).then_some(Self {
            far: far - 3.0 * Self::ROUNDING,
            near_w: near_w - Self::ROUNDING * from_eye,
            reach_w,
        })
    }

    /// The w from which on points are hidden.
    fn hidden_from(&self, farthest: f64) -> f32 {
        let farthest = (farthest + 16.0) / f64::from(FARTHEST) * 2.0 - 1.0;
        let from = self.near_w / (farthest - self.far);
        if farthest < self.far && from.is_finite() {
            ((from + self.reach_w) * 1.001) as f32
        } else {
            f32::INFINITY
        }
    }
}

impl<'i, I: Fn(usize) -> &'i [u32]> Run<'_, I> {
    /// Draws the points with faces of one kind.
    pub(super) fn draw<const PAINT: u8>(
        &self,
        screen: &Screen,
        scratch: &mut PointScratch,
        ranked: &mut RankedScratch,
        band: &mut Band<'_>,
    ) {
        dispatch!(screen.simd_level, simd => self.draw_by_lanes::<_, PAINT>(simd, screen, scratch, ranked, band));
    }

    #[inline(always)]
    fn draw_by_lanes<S: Simd, const PAINT: u8>(
        &self,
        simd: S,
        screen: &Screen,
        scratch: &mut PointScratch,
        ranked: &mut RankedScratch,
        band: &mut Band<'_>,
    ) {
        let view = BandView {
            width_px: screen.width_px as f32,
            rows: [band.first_row as f32, band.end_row as f32],
            half_size: screen.half_size(),
        };
        let (mut indices, mut ranks, mut count) = ([0; BLOCK], [0; BLOCK], 0);
        let range = Range::of(self.cloud);
        let mut hidden_from = f32::INFINITY;
        let mut looked_at = LookedAt::default();
        // Once chunks come in the order in which they lie in memory, how many had come before.
        let mut in_memory_order = None;
        let mut come = 0;
        loop {
            let next = match in_memory_order {
                None => ranked.order.get(come).map(|&at| at as usize),
                Some(before) => Some(come - before),
            };
            let next = next.and_then(|at| Some((at, *ranked.chunks.get(at)?)));
            come += 1;
            if next.is_some() && come % CHUNKS_TO_ASK == 0 {
                let farthest = |range: &Range| range.hidden_from(f64::from(ranked.occluders.farthest()));
                hidden_from = range.as_ref().map_or(f32::INFINITY, farthest);
                if in_memory_order.is_none() && std::mem::take(&mut looked_at).are_mostly_hidden() {
                    in_memory_order = Some(come);
                }
            }
            // In one place, because all of it becomes a part of this function.
            if next.is_none() || count + CHUNK > BLOCK {
                self.draw_block::<S, PAINT>(simd, &indices[..count], &ranks, &view, screen, scratch, ranked, band);
                count = 0;
            }
            let Some((at, chunk)) = next else { break };
            for (index, rank) in in_chunk(&self.indices, chunk, self.first_rank, at) {
                looked_at.all += 1;
                let Some(position) = self.nearer_than(index, hidden_from) else { continue };
                looked_at.near += 1;
                if self.is_needed(index, position, rank, ranked) {
                    (indices[count % BLOCK], ranks[count % BLOCK]) = (index, rank);
                    count += 1;
                }
            }
        }
    }

    /// The position of a point, unless it is too far away.
    #[inline(always)]
    fn nearer_than(&self, index: u32, hidden_from: f32) -> Option<[f32; 3]> {
        let position = *self.cloud.points.buffer.positions.get(index as usize)?;
        let [.., [x, y, z, w]] = self.cloud.transform.clip_from_object;
        let is_hidden = position[0] * x + position[1] * y + position[2] * z + w > hidden_from;
        (!is_hidden).then_some(position)
    }

    /// Whether a point is not too faint, and no later one lies in the same place.
    #[inline(always)]
    fn is_needed(&self, index: u32, position: [f32; 3], rank: u32, ranked: &mut RankedScratch) -> bool {
        let [.., alpha] = self.cloud.points.buffer.colors.get(index as usize);
        self.cloud.opacities[usize::from(alpha)].is_some()
            && !ranked.recent_points.covers(&position.map(f32::to_bits), rank)
    }

    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "it is a part of the loop above")]
    fn draw_block<S: Simd, const PAINT: u8>(
        &self,
        simd: S,
        indices: &[u32],
        ranks: &[u32; BLOCK],
        view: &BandView,
        screen: &Screen,
        scratch: &mut PointScratch,
        ranked: &mut RankedScratch,
        band: &mut Band<'_>,
    ) {
        let cloud = self.cloud;
        let PointScratch { points, faces, rough } = scratch;
        points.gather(cloud, indices);
        faces.iter_mut().take(sides_of::<PAINT>()).for_each(FaceBlock::clear);
        for begin in (0..points.len).step_by(LANES) {
            let batch = Batch { simd, cloud, view, points, begin };
            let quads = place_faces::<S, PAINT>(&batch, faces);
            let mut is_traced = [false; SIDES];
            let there = ((1 << (points.len - begin).min(LANES)) - 1) << begin;
            let sides = 0..sides_of::<PAINT>();
            let general = faces[sides.clone()].iter().fold(0, |any, faces| any | faces.general) & there;
            if general != 0 {
                rough.set_up(&batch);
            }
            let mut seen = faces[sides.clone()].iter().fold(general, |any, faces| any | faces.small) & there;
            while seen != 0 {
                let i = seen.trailing_zeros() as usize;
                seen &= seen - 1;
                if general & 1 << i != 0 {
                    self.draw_large(simd, rough, i - begin, points.indices[i], ranks[i], screen, ranked, band);
                    continue;
                }
                for side in sides.clone() {
                    let faces = &mut faces[side];
                    if faces.small & 1 << i == 0 {
                        continue;
                    }
                    let (plane, area) = depths_of(faces, i);
                    ranked.tiles.clear();
                    ranked.occluders.list_seen(simd, &plane, ranks[i], area, &mut ranked.tiles);
                    if ranked.tiles.is_empty() {
                        continue;
                    }
                    if !is_traced[side] {
                        faces.trace(simd, &quads[side], begin);
                        is_traced[side] = true;
                    }
                    let color = (AXES[side], points.colors[i]);
                    draw_small::<S, PAINT>(simd, faces, i, (&plane, area), color, ranks[i], ranked, band);
                }
            }
        }
    }

    /// In a function of its own, compiled for the same instructions: it is long, and the same for each kind of face.
    #[inline(never)]
    #[expect(clippy::too_many_arguments, reason = "it is a part of the loop above")]
    fn draw_large<S: Simd>(
        &self,
        simd: S,
        rough: &RoughFaces,
        lane: usize,
        index: u32,
        rank: u32,
        screen: &Screen,
        ranked: &mut RankedScratch,
        band: &mut Band<'_>,
    ) {
        simd.vectorize(
            #[inline(always)]
            || {
                for number in 0..self.cloud.faces.count() {
                    ranked.tiles.clear();
                    let known = rough.face(number, lane);
                    let is_seen = match &known {
                        Some((_, area)) if area.left >= area.right || area.top >= area.bottom => false,
                        Some((plane, area)) => {
                            ranked.occluders.list_seen(simd, plane, rank, *area, &mut ranked.tiles);
                            !ranked.tiles.is_empty()
                        }
                        None => rough.may_be_front(number, lane),
                    };
                    if !is_seen {
                        continue;
                    }
                    ranked.cut.clear();
                    make_triangles(self.cloud, index, 1 << number, screen, ranked);
                    let tiles = known.is_some().then_some(ranked.tiles.as_slice());
                    for corners in &ranked.cut {
                        let surface = &self.cloud.surface;
                        triangles::draw_ranked(corners.each_ref(), surface, rank, tiles, band, &mut ranked.occluders);
                    }
                }
            },
        );
    }
}

/// Makes the triangles of some faces of a point.
#[inline(never)]
fn make_triangles(cloud: &Cloud<'_>, index: u32, faces: u32, screen: &Screen, ranked: &mut RankedScratch) {
    cloud.faces.triangles(&cloud.transform, index as usize, faces, |triangle| {
        triangles::cut(triangle, &cloud.surface, screen, |corners| ranked.cut.push(*corners));
    });
}

/// A bound of a small face's depths, and its pixels.
#[inline(always)]
fn depths_of(faces: &FaceBlock, i: usize) -> (DepthPlane, Area) {
    let [left, right, top, bottom] = faces.bounds.each_ref().map(|all| all[i]);
    let area = Area { left, right, top, bottom };
    let [at, dx, dy] = faces.plane(DEPTH, i);
    let (columns, rows) = ((right - left) as f32, (bottom - top) as f32);
    let noise = if dx == 0.0 && dy == 0.0 {
        0.0
    } else {
        let (right, down) = (dx.abs() * columns, dy.abs() * rows);
        let from_first = right + down;
        let depth = (at.abs() + from_first).min(2.0 * FARTHEST);
        1.01 * (rounding(right) + rounding(down) + rounding(from_first) + rounding(depth))
    };
    // At the nearest corner of its pixels.
    let least = at + dx.min(0.0) * (columns - 1.0) + dy.min(0.0) * (rows - 1.0) - noise;
    (DepthPlane { at, dx, dy, x: left as f32, y: top as f32, noise, least }, area)
}

/// Draws a small face in the tiles that are listed.
#[inline(always)]
#[expect(clippy::too_many_arguments, reason = "it is a part of the loop above")]
fn draw_small<S: Simd, const PAINT: u8>(
    simd: S,
    faces: &FaceBlock,
    i: usize,
    (plane, area): (&DepthPlane, Area),
    (axis, color): (usize, u32),
    rank: u32,
    ranked: &mut RankedScratch,
    band: &mut Band<'_>,
) {
    let Area { left, right, top, bottom } = area;
    let [depth, depth_right, depth_down] = faces.plane(DEPTH, i);
    let edges = [faces.edge(0, i), faces.edge(1, i), faces.edge(2, i), faces.edge(3, i)];
    let places = [faces.plane(PLACE, i), faces.plane(PLACE + 1, i), faces.plane(PLACE + 2, i)];
    let paint = FacePaint::<S, PAINT>::new(simd, color, axis, faces.along & 1 << i != 0);
    let covers = |pixels: Area| {
        let corners = [
            [pixels.left, pixels.top],
            [pixels.right - 1, pixels.top],
            [pixels.left, pixels.bottom - 1],
            [pixels.right - 1, pixels.bottom - 1],
        ];
        corners.iter().all(|[x, y]| {
            let (x, y) = (x - left, y - top);
            // Beyond the face's bounds an edge's value might not fit into its number.
            let is_inside = x >= 0
                && y >= 0
                && x < right - left
                && y < bottom - top
                && edges.iter().all(|[at, dx, dy]| at + dx * x + dy * y >= 0);
            is_inside && (PAINT != DISC || is_in_disc(&places, x as f32, y as f32))
        })
    };
    // Of tiles beside a face that is about as wide as its bounds there are too few to look for.
    if PAINT == DISC || is_turned(&edges) {
        for tiles in &mut ranked.tiles {
            *tiles = ranked.occluders.seen_within(
                simd,
                plane,
                area,
                *tiles,
                #[inline(always)]
                |[x, y]| {
                    let from_first = [x - left as f32, y - top as f32];
                    if PAINT == DISC {
                        limit_of_disc(&places, from_first)
                    } else {
                        limit_of_edges(&edges, from_first)
                    }
                },
            );
        }
    }
    ranked.occluders.draw_listed(
        plane,
        rank,
        &ranked.tiles,
        #[inline(always)]
        |tile| {
            let columns = lane_indices(simd) + (tile.left - left);
            let mut edges_at = map(
                edges,
                #[inline(always)]
                |[at, dx, _]| columns * dx + at,
            );
            let columns = columns.to_float::<F<S>>();
            let from_first = columns * depth_right;
            let first_places = first_row_of::<S, PAINT>(simd, places, columns);
            let rows = tile.top.max(top) - top;
            for k in 0..EDGES {
                edges_at[k] += edges[k][2] * rows;
            }
            let mut row = rows as f32;
            let mut is_seen = false;
            band.for_ranked_windows(
                tile.top.max(top)..tile.bottom.min(bottom),
                tile.left,
                #[inline(always)]
                |window| {
                    let [e0, e1, e2, e3] = edges_at;
                    let mask = ((e0 | e1) | (e2 | e3)).simd_ge(I::splat(simd, 0));
                    is_seen |= window.meet(
                        mask,
                        (from_first + depth_down * row) + depth,
                        rank,
                        #[inline(always)]
                        |seen| {
                            let places_at = in_row::<S, PAINT>(first_places, places, row);
                            (paint.mask(places_at, seen), paint.colors(places_at))
                        },
                    );
                    for k in 0..EDGES {
                        edges_at[k] += edges[k][2];
                    }
                    row += 1.0;
                },
            );
            if !is_seen {
                Drawn::Nothing
            } else if covers(tile) {
                Drawn::Covered
            } else {
                band.farthest(simd, tile, [depth_right, depth_down])
            }
        },
        covers,
    );
}

/// What is positive only beside a disc, beyond a line that touches it where it is nearest to a place, given by its
/// pixel from the face's first one: its value there, and its changes to the right and down.
#[inline(always)]
fn limit_of_disc<S: Simd>(places: &[[f32; 3]; 3], [x, y]: [F<S>; 2]) -> [F<S>; 3] {
    let [q, u, v] = map(
        *places,
        #[inline(always)]
        |[at, dx, dy]| x * dx + at + y * dy,
    );
    let radius = DISC_RADIUS_SQUARED.sqrt();
    let distance = (u * u + v * v).sqrt();
    let per_distance = 1.0 / distance;
    let (along_u, along_v) = (u * per_distance, v * per_distance);
    let change = inlined(
        #[inline(always)]
        |i: usize| along_u * places[1][i] + along_v * places[2][i] - radius * places[0][i],
    );
    [distance - q * radius - (distance + q.abs()) * 1e-4, change(1), change(2)]
}

/// Whether an edge of a face runs across several tiles in both directions.
#[inline(always)]
fn is_turned(edges: &[[i32; 3]; EDGES]) -> bool {
    const ACROSS: i32 = 3 * TILE_PX * SUBPIXELS;
    edges.iter().any(|[_, dx, dy]| dx.abs().min(dy.abs()) >= ACROSS)
}

/// What is positive only beyond the edge of a face that is the nearest to a place, or farthest beyond.
#[inline(always)]
fn limit_of_edges<S: Simd>(edges: &[[i32; 3]; EDGES], [x, y]: [F<S>; 2]) -> [F<S>; 3] {
    let simd = x.token();
    let splat = |value: f32| F::splat(simd, value);
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
