//! Crowds: so many opaque solids in a row that most of them are hidden by others.
//!
//! Of each [`Member`] only its footprint is worked out at first: a box on the picture and the least depth. A band draws
//! its members from near to far, by ranks as in [`ranked`](crate::cpu::ranked), and does not look at those that lie
//! behind what it has drawn: their vertices are neither placed nor lit.

use fearless_simd::dispatch;
use rcs_scene::Material;

use super::batch::{Batch, BatchPiece, BatchView};
use super::corners::{place_vertices, InstanceScratch, Source, Vertices};
use super::covered::for_covered;
use super::reach::{reach, Footprint, Reach};
use super::sieve::{sieve, Facing};
use super::Instances;
use crate::cpu::band::Band;
use crate::cpu::occlusion::{Area, DepthPlane};
use crate::cpu::ranked::RankedScratch;
use crate::cpu::screen::{ObjectTransform, Screen};
use crate::cpu::triangles;

/// A solid that may be seen.
#[derive(Clone, Copy, Debug)]
pub(super) struct Member {
    /// The number of its first triangle, and how many it has.
    first: u32,
    triangles: u32,
    batch: u32,
    /// Index of the solid.
    item: u32,
    footprint: Footprint,
}

/// A member in a band: the bits of its least depth, and below them its place in the band's list.
pub(super) type Turn = u64;

/// All that is needed of a member that is hidden: the members themselves lie anywhere in memory, as they come from near
/// to far.
#[derive(Clone, Copy, Debug)]
pub(super) struct Listed {
    job: u32,
    number: u32,
    /// Its pixels in the band: left, right, top and bottom.
    area: [u16; 4],
}

impl Listed {
    fn new(job: u32, number: u32, area: Area) -> Self {
        // Pictures have at most 16384 columns and rows.
        let area = [area.left, area.right, area.top, area.bottom].map(|place| place as u16);
        Self { job, number, area }
    }

    fn area(&self) -> Area {
        let [left, right, top, bottom] = self.area.map(i32::from);
        Area { left, right, top, bottom }
    }
}

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
        super::for_each_mesh(piece, batches, |placed, [batch, item]| {
            let view_from_object = view.view_from_fixed * placed.fixed_from_mesh;
            let rows = ObjectTransform::clip_rows(view.view.camera, &view_from_object);
            match placed.shape.bounds.map(|bounds| reach(&bounds, &rows, screen)) {
                Some(Reach::Unseen) => {}
                Some(Reach::Inside(footprint)) if footprint.is_small() => {
                    let [top, bottom] = footprint.rows.map(|row| row.clamp(0, screen.height_px as i32) as u32);
                    self.member_bins.add(self.members.len() as u32, top, bottom);
                    let (first, triangles) = (self.next, placed.shape.triangles.len() as u32);
                    self.members.push(Member { first, triangles, batch, item, footprint });
                    self.next += triangles;
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
        let (mut turns, mut listed) = (std::mem::take(&mut scratch.turns), std::mem::take(&mut scratch.listed));
        turns.clear();
        listed.clear();
        for (job, instances) in (0..).zip(jobs) {
            let instances = instances.as_ref();
            for &number in instances.member_bins.band(index) {
                let Some(member) = instances.members.get(number as usize) else { continue };
                let area = member.area(band);
                if area.left < area.right && area.top < area.bottom {
                    turns.push(Turn::from(member.footprint.least_depth.to_bits()) << u32::BITS | listed.len() as Turn);
                    listed.push(Listed::new(job, number, area));
                }
            }
        }
        // Of numbers that are not negative, the larger one has the larger bits.
        turns.sort_unstable();
        scratch.ranks.clear();
        scratch.ranks.extend(jobs.iter().scan(first_rank, |next, job| {
            let first = *next;
            *next += job.as_ref().next;
            Some(first)
        }));
        for &turn in &turns {
            let Some(listed) = listed.get(turn as u32 as usize) else { continue };
            // Of the same depth it is not hidden here: its rank is not known yet.
            let nearest = DepthPlane::level(f32::from_bits((turn >> u32::BITS) as u32));
            let area = listed.area();
            if dispatch!(screen.simd_level, simd => ranked.occluders.hides(simd, &nearest, u32::MAX, area)) {
                continue;
            }
            let instances = jobs.get(listed.job as usize).map(AsRef::as_ref);
            let member = instances.and_then(|instances| instances.members.get(listed.number as usize));
            let (Some(member), Some(&first_rank)) = (member, scratch.ranks.get(listed.job as usize)) else { continue };
            member.draw(area, first_rank + member.first, (batches, view), screen, scratch, ranked, band);
        }
        (scratch.turns, scratch.listed) = (turns, listed);
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

    /// Draws what may be seen of it in an area; `first_rank` is that of its first triangle.
    #[expect(clippy::too_many_arguments, reason = "it is a part of the loop above")]
    fn draw(
        &self,
        area: Area,
        first_rank: u32,
        (batches, view): (&[Batch<'_>], &BatchView<'_>),
        screen: &Screen,
        scratch: &mut InstanceScratch,
        ranked: &mut RankedScratch,
        band: &mut Band<'_>,
    ) {
        let (nearest, last_rank) = (DepthPlane::level(self.footprint.least_depth), first_rank + self.triangles);
        if dispatch!(screen.simd_level, simd => ranked.occluders.hides(simd, &nearest, last_rank, area)) {
            return;
        }
        let from = self.footprint.least_depth;
        let Some(area) = dispatch!(screen.simd_level, simd => band.area_from_depth(simd, area, from)) else { return };
        let Some(Batch::Solids(solids, shapes)) = batches.get(self.batch as usize) else { return };
        let Some(solid) = solids.as_slice().get(self.item as usize) else { return };
        let (mesh, shape) = (solids.shapes().get(solid.shape()), shapes.get(solid.shape()));
        let (Some(mesh), Some(shape)) = (mesh, shape) else { return };
        let transform = view.transform(&(view.view_from_fixed * solid.matrix()));
        let (material, surface) = (&Material::lit(solid.color), view.surface_of_solid(solid));
        let source = Source { vertices: Vertices::Mesh(mesh), material, transform: &transform, surface };
        let rows = &transform.clip_from_object;
        let facing = Facing::of(shape, surface, rows, &self.footprint, screen);
        dispatch!(screen.simd_level, simd => {
            place_vertices(simd, shape, rows, screen, scratch);
            sieve(simd, shape, surface, facing.as_ref(), scratch);
        });
        let (seen, mut cover) = (std::mem::take(&mut scratch.seen), std::mem::take(&mut scratch.cover));
        let mut is_drawn = false;
        let (numbers, view) = (seen.iter().copied(), (&source, area, screen));
        for_covered((shape, numbers), view, scratch, &mut cover, |corners, triangle, rows| {
            triangles::draw_among(corners, surface, rows, first_rank + triangle, band);
            is_drawn = true;
        });
        (scratch.seen, scratch.cover) = (seen, cover);
        if is_drawn {
            dispatch!(screen.simd_level, simd => ranked.occluders.look(simd, band, area));
        }
    }
}
