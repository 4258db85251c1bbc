//! Drawing a cloud whose faces lie over each other many times, by [ranks](crate::cpu::ranked).
//!
//! Small faces are placed as always; [`paint`](super::paint)'s way over their pixels leads through the tiles in which
//! something may be seen; for boxes and tiles, those of the strip that the face before [leaves](super::hiding). Of
//! large faces only a plane below all of their depths is set up at first, several at once: most are hidden and need no
//! more. The triangles of the others are made and drawn one by one.

use fearless_simd::{dispatch, Simd};

use super::hiding::FaceBefore;
use super::paint::{place_faces, sides_of, BOX_SIDE, EDGED};
use super::place::{BandView, Batch, FaceBlock, AXES, SIDES};
use super::rough::RoughFaces;
use super::small::{depths_of, SmallFace};
use super::{Cloud, PointScratch, BLOCK};
use crate::cpu::band::Band;
use crate::cpu::lanes::LANES;
use crate::cpu::occlusion::Drawn;
use crate::cpu::ranked::{in_chunk, RankedScratch, CHUNK};
use crate::cpu::screen::{Screen, FARTHEST};
use crate::cpu::triangles;

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
        let PointScratch { points, faces, inner, rough } = scratch;
        points.gather(cloud, indices);
        // Faces that are turned to the eye each are nearer than their neighbours somewhere.
        let is_fixed = PAINT == BOX_SIDE || PAINT == EDGED && cloud.faces.tile_sides().is_some();
        let mut before: [Option<FaceBefore>; SIDES] = [None; SIDES];
        faces.iter_mut().take(sides_of::<PAINT>()).for_each(FaceBlock::clear);
        for begin in (0..points.len).step_by(LANES) {
            let batch = Batch { simd, cloud, view, points, begin };
            let quads = place_faces::<S, PAINT>(&batch, faces);
            if is_fixed {
                for side in 0..sides_of::<PAINT>() {
                    inner[side].find(&quads[side], begin);
                }
            }
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
                    let mut left = area;
                    if is_fixed {
                        if let Some(before) = &before[side] {
                            left = before.leaves(&plane, ranks[i], area);
                        }
                        before[side] = Some(FaceBefore { depths: plane, rank: ranks[i], inner: inner[side].of(i) });
                        if left.left >= left.right || left.top >= left.bottom {
                            continue;
                        }
                    }
                    ranked.tiles.clear();
                    ranked.occluders.list_seen(simd, &plane, ranks[i], left, &mut ranked.tiles);
                    if ranked.tiles.is_empty() {
                        continue;
                    }
                    if !is_traced[side] {
                        faces.trace(simd, &quads[side], begin);
                        is_traced[side] = true;
                    }
                    let face = SmallFace::<S, PAINT>::new(simd, faces, i, (plane, area), AXES[side], points.colors[i]);
                    draw_small(simd, &face, ranks[i], ranked, band);
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

/// Draws a small face in the tiles that are listed.
#[inline(always)]
fn draw_small<S: Simd, const PAINT: u8>(
    simd: S,
    face: &SmallFace<S, PAINT>,
    rank: u32,
    ranked: &mut RankedScratch,
    band: &mut Band<'_>,
) {
    let plane = face.depths;
    if face.leaves_tiles_out() {
        for tiles in &mut ranked.tiles {
            *tiles = ranked.occluders.seen_within(
                simd,
                &plane,
                face.area,
                *tiles,
                #[inline(always)]
                |middles| face.limit(middles),
            );
        }
    }
    ranked.occluders.draw_listed(
        &plane,
        rank,
        &ranked.tiles,
        #[inline(always)]
        |tile| {
            if !face.draw(tile, rank, band) {
                Drawn::Nothing
            } else if face.covers(tile) {
                Drawn::Covered
            } else {
                band.farthest(simd, tile, [plane.dx, plane.dy])
            }
        },
        #[inline(always)]
        |pixels| face.covers(pixels),
    );
}
