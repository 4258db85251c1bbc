//! Crowds: so many opaque solids in a row that most of them are hidden by others.
//!
//! Of each [`Member`] only its footprint is worked out at first: a box on the picture and the least depth. A band draws
//! its members from near to far, by ranks as in [`ranked`](crate::cpu::ranked), and does not look at those that lie
//! behind what it has drawn: their vertices are neither placed nor lit.

use fearless_simd::dispatch;
use rcs_scene::Material;

use super::batch::{Batch, BatchPiece, BatchView};
use super::corners::{place_vertices, InstanceScratch, Source, Vertices};
use super::reach::{reach, Footprint, Reach};
use super::{sieve, Instances};
use crate::cpu::band::Band;
use crate::cpu::occlusion::{Area, DepthPlane};
use crate::cpu::ranked::RankedScratch;
use crate::cpu::screen::{ObjectTransform, Screen};
use crate::cpu::triangles;

/// A solid that may be seen.
#[derive(Clone, Copy, Debug)]
pub(super) struct Member {
    /// The number of its first triangle.
    first: u32,
    batch: u32,
    /// Index of the solid.
    item: u32,
    footprint: Footprint,
}

/// A member in a band: by depth, then in any order.
pub(super) type Turn = [u32; 3];

impl Instances {
    /// Works out where some solids are on the picture. Those that reach out of it are made ready as any others.
    pub(in crate::cpu) fn add_members(
        &mut self,
        piece: &BatchPiece,
        batches: &[Batch<'_>],
        view: &BatchView<'_>,
        screen: &Screen,
        scratch: &mut InstanceScratch,
    ) {
        super::for_each_mesh(piece, batches, view, |placed, [batch, item]| {
            let view_from_object = view.view_from_fixed * placed.fixed_from_mesh;
            let rows = ObjectTransform::clip_rows(view.view.camera, &view_from_object);
            match placed.shape.bounds.map(|bounds| reach(&bounds, &rows, screen)) {
                Some(Reach::Unseen) => {}
                Some(Reach::Inside(footprint)) if footprint.is_small() => {
                    let [top, bottom] = footprint.rows.map(|row| row.clamp(0, screen.height_px as i32) as u32);
                    self.member_bins.add(self.members.len() as u32, top, bottom);
                    self.members.push(Member { first: self.next, batch, item, footprint });
                    self.next += placed.shape.triangles.len() as u32;
                }
                _ => self.add_mesh(placed, [batch, item], view, screen, scratch),
            }
        });
    }

    /// Draws a band's rows of the solids of several jobs.
    pub(in crate::cpu) fn draw_crowd(
        jobs: &[impl AsRef<Self>],
        (batches, view): (&[Batch<'_>], &BatchView<'_>),
        (screen, index): (&Screen, usize),
        scratch: &mut InstanceScratch,
        ranked: &mut RankedScratch,
        band: &mut Band<'_>,
    ) {
        let triangles = jobs.iter().map(|job| job.as_ref().next as usize).sum();
        let Some(first_rank) = ranked.begin_again_for(triangles, band) else { return };
        let mut turns = std::mem::take(&mut scratch.turns);
        turns.clear();
        for (job, instances) in (0..).zip(jobs) {
            let instances = instances.as_ref();
            let depth = |member: u32| instances.members.get(member as usize).map_or(0.0, |m| m.footprint.least_depth);
            turns
                .extend(instances.member_bins.band(index).iter().map(|&member| [depth(member).to_bits(), job, member]));
        }
        // Of numbers that are not negative, the larger one has the larger bits.
        turns.sort_unstable();
        scratch.ranks.clear();
        scratch.ranks.extend(jobs.iter().scan(first_rank, |next, job| {
            let first = *next;
            *next += job.as_ref().next;
            Some(first)
        }));
        for &[_, job, member] in &turns {
            let instances = jobs.get(job as usize).map(AsRef::as_ref);
            let member = instances.and_then(|instances| instances.members.get(member as usize));
            let (Some(member), Some(&first_rank)) = (member, scratch.ranks.get(job as usize)) else { continue };
            member.draw(first_rank + member.first, (batches, view), screen, scratch, ranked, band);
        }
        scratch.turns = turns;
        for (job, instances) in jobs.iter().enumerate() {
            let Some(&first_rank) = scratch.ranks.get(job) else { continue };
            let instances = instances.as_ref();
            for &number in instances.bins.band(index) {
                instances.draw_one_ranked(number, first_rank + number, (batches, view), screen, ranked, band);
            }
        }
    }
}

impl Member {
    fn area(&self, band: &Band<'_>) -> Area {
        let ([left, right], [top, bottom]) = (self.footprint.columns, self.footprint.rows);
        let rows = band.rows(top, bottom);
        Area { left: left.max(0), right: right.min(band.width), top: rows.start, bottom: rows.end }
    }

    /// Draws what may be seen of it; `first_rank` is that of its first triangle.
    fn draw(
        &self,
        first_rank: u32,
        (batches, view): (&[Batch<'_>], &BatchView<'_>),
        screen: &Screen,
        scratch: &mut InstanceScratch,
        ranked: &mut RankedScratch,
        band: &mut Band<'_>,
    ) {
        let area = self.area(band);
        if area.left >= area.right || area.top >= area.bottom {
            return;
        }
        let Some(Batch::Solids(solids, shapes)) = batches.get(self.batch as usize) else { return };
        let shape = solids.as_slice().get(self.item as usize).and_then(|solid| shapes.get(solid.shape()));
        let Some(shape) = shape else { return };
        let (nearest, last_rank) =
            (DepthPlane::level(self.footprint.least_depth), first_rank + shape.triangles.len() as u32);
        let occluders = &mut ranked.occluders;
        if dispatch!(screen.simd_level, simd => occluders.hides(simd, &nearest, last_rank, area)) {
            return;
        }
        let mut is_drawn = false;
        self.with_source(batches, view, screen, scratch, band, |corners, source, triangle, scratch, band| {
            let mut place = |key| scratch.corner(key, source, screen, true);
            if let [Some((a, _)), Some((b, _)), Some((c, _))] = corners.map(&mut place) {
                triangles::draw_among([&a, &b, &c], source.surface, first_rank + triangle, band);
                is_drawn = true;
            }
        });
        if is_drawn {
            dispatch!(screen.simd_level, simd => occluders.look(simd, band, area));
        }
    }

    /// Passes on the corners of each triangle that may be seen in the band, and its number.
    fn with_source(
        &self,
        batches: &[Batch<'_>],
        view: &BatchView<'_>,
        screen: &Screen,
        scratch: &mut InstanceScratch,
        band: &mut Band<'_>,
        mut work: impl FnMut([u32; 3], &Source<'_>, u32, &mut InstanceScratch, &mut Band<'_>),
    ) {
        let Some(Batch::Solids(solids, shapes)) = batches.get(self.batch as usize) else { return };
        let Some(solid) = solids.as_slice().get(self.item as usize) else { return };
        let (mesh, shape) = (solids.shapes().get(solid.shape()), shapes.get(solid.shape()));
        let (Some(mesh), Some(shape)) = (mesh, shape) else { return };
        let transform = view.transform(&(view.view_from_fixed * solid.matrix()));
        let (material, surface) = (&Material::lit(solid.color), view.surface_of_solid(solid));
        let source = Source { vertices: Vertices::Mesh(mesh), material, transform: &transform, surface };
        let rows = &transform.clip_from_object;
        dispatch!(screen.simd_level, simd => place_vertices(simd, shape, rows, screen, scratch));
        scratch.begin();
        sieve(shape, surface, scratch);
        let seen = std::mem::take(&mut scratch.seen);
        for &triangle in &seen {
            let Some(&corners) = shape.triangles.get(triangle as usize) else { continue };
            let places = corners.map(|corner| scratch.place_of(corner));
            let (begin, end) = triangles::between(places[0][1], places[1][1], places[2][1]);
            if begin < band.end_row && end > band.first_row && triangles::covers_any_centre(places) {
                work(corners, &source, triangle, scratch, band);
            }
        }
        scratch.seen = seen;
    }
}
