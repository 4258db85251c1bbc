//! Very many small things made of triangles: [`Solids`](rcs_scene::Solids).
//!
//! A scene may have hundreds of thousands of solids of a few hundred triangles each, most of which cover a few pixels.
//! So what is computed for one is thrown away at once but for four bytes for each triangle that may be seen, and
//! computed again, for these few triangles alone, where their band is drawn. A solid goes through two tests:
//!
//! 1. Its box in clip coordinates: beyond a side of the view, or between the pixels' centres, it is not looked at.
//! 2. Its vertices, eight at a time, as the rows and columns of pixel centres between which they lie. A triangle whose
//!    corners are all in one gap covers no centre, which is true of most triangles of a small solid.
//!
//! Solids that reach out of the view take the longer way of [`meshes`](super::meshes), vertex by vertex; the image is
//! the same on both.

mod batch;
mod placement;
mod places;
mod shape;
#[cfg(test)]
mod tests;

use std::ops::Range;

use fearless_simd::dispatch;
use rcs_scene::{CullMode, Material};

use self::batch::SolidInstance;
pub(in crate::cpu) use self::batch::{Batch, Batches};
use self::placement::{place_box, Placement};
use self::places::place_vertices;
pub(in crate::cpu) use self::places::InstanceScratch;
use self::shape::Shape;
pub(in crate::cpu) use self::shape::Shapes;
use super::vertices::{Source, VertexCache};
use crate::cpu::raster::triangle;
use crate::cpu::tile::band::Band;
use crate::cpu::tile::bins::Bins;
use crate::cpu::tile::screen::{ObjectTransform, Screen};

/// The triangles of a solid that are ready to be drawn.
#[derive(Clone, Debug)]
struct Placed {
    /// The number of its first triangle.
    first: u32,
    batch: u32,
    /// Index of the solid.
    item: u32,
    transform: ObjectTransform,
}

/// Solids that are ready to be drawn.
#[derive(Debug, Default)]
pub(in crate::cpu) struct Instances {
    placed: Vec<Placed>,
    /// The numbers of triangles: all those of the first solid, seen or not, then all those of the second, and so on.
    bins: Bins,
    next: u32,
}

impl Instances {
    /// Forgets everything.
    pub(in crate::cpu) fn clear(&mut self, screen: &Screen) {
        self.placed.clear();
        self.bins.reset(screen);
        self.next = 0;
    }

    /// Makes some solids of a batch ready.
    pub(in crate::cpu) fn add(
        &mut self,
        (batch, range): (usize, Range<usize>),
        batches: &Batches<'_>,
        screen: &Screen,
        scratch: &mut InstanceScratch,
    ) {
        for item in range {
            if let Some(instance) = batches.solid([batch, item]) {
                self.add_solid(&instance, [batch as u32, item as u32], (batches, screen), scratch);
            }
        }
    }

    fn add_solid(
        &mut self,
        instance: &SolidInstance<'_>,
        [batch, item]: [u32; 2],
        (view, screen): (&Batches<'_>, &Screen),
        scratch: &mut InstanceScratch,
    ) {
        let &SolidInstance { solid, shape, .. } = instance;
        let view_from_object = view.view_from_fixed * solid.matrix();
        let rows = ObjectTransform::clip_rows(view.view.camera, &view_from_object);
        let placement = shape.bounds.map_or(Placement::Crossing, |bounds| place_box(&bounds, &rows, screen));
        let mut transform = None;
        let is_seen = match placement {
            Placement::Unseen => false,
            Placement::Inside => {
                dispatch!(screen.simd_level, simd => place_vertices(simd, shape, &rows, screen, scratch));
                self.add_inside(shape, view.surface_of_solid(solid).cull, scratch)
            }
            Placement::Crossing => {
                let transform = transform.insert(view.transform(&view_from_object));
                let material = Material::lit(solid.color);
                let source = instance.source(&material, transform, view, screen);
                scratch.vertices.cache.clear();
                let numbers = (self.next..).zip(&shape.triangles);
                // Each triangle is looked at, whether others are seen or not.
                numbers.fold(false, |seen, (number, corners)| {
                    self.add_triangle(number, *corners, &source, &mut scratch.vertices.cache) || seen
                })
            }
        };
        if is_seen {
            let transform = transform.unwrap_or_else(|| view.transform(&view_from_object));
            self.placed.push(Placed { first: self.next, batch, item, transform });
            self.next += shape.triangles.len() as u32;
        }
    }

    /// Makes the triangles of a solid inside the view ready that may be seen, given where its vertices were placed.
    /// Returns `true` if there are some.
    fn add_inside(&mut self, shape: &Shape, cull: CullMode, scratch: &InstanceScratch) -> bool {
        let mut is_seen = false;
        for (number, &corners) in (self.next..).zip(&shape.places) {
            let [gap_a, gap_b, gap_c] = corners.map(|place| scratch.gap_of(place));
            let differences = (gap_a ^ gap_b) | (gap_a ^ gap_c);
            if differences & 0xffff == 0 || differences >> 16 == 0 {
                continue;
            }
            let places = corners.map(|place| scratch.place_of(place));
            if triangle::is_hidden(triangle::doubled_area_of(places), cull) || !triangle::covers_any_centre(places) {
                continue;
            }
            let [a, b, c] = places;
            self.bins.add_rows(number, triangle::between(a[1], b[1], c[1]));
            is_seen = true;
        }
        is_seen
    }

    /// Makes a triangle ready. Returns whether it may be seen.
    fn add_triangle(&mut self, number: u32, keys: [u32; 3], source: &Source<'_>, cache: &mut VertexCache) -> bool {
        let rows = source.rows(keys, cache);
        rows.into_iter().for_each(|rows| self.bins.add_rows(number, rows));
        rows.is_some()
    }

    /// The solid that a triangle belongs to, of those that are not before an index; near ones are found soonest. With
    /// its own index before it, and behind it the number of the next solid's first triangle.
    fn placed_from(&self, from: usize, number: u32) -> Option<(usize, &Placed, u32)> {
        let rest = self.placed.get(from..)?;
        let mut end = 1;
        while rest.get(end).is_some_and(|placed| placed.first <= number) {
            end *= 2;
        }
        let (begin, end) = (end / 2, end.min(rest.len()));
        let after = begin + rest.get(begin..end)?.partition_point(|placed| placed.first <= number);
        let end = rest.get(after).map_or(u32::MAX, |placed| placed.first);
        let at = after.checked_sub(1)?;
        Some((from + at, rest.get(at)?, end))
    }

    /// Draws the rows of a band.
    pub(in crate::cpu) fn draw(
        &self,
        batches: &Batches<'_>,
        index: usize,
        screen: &Screen,
        scratch: &mut InstanceScratch,
        band: &mut Band<'_>,
    ) {
        let mut numbers = self.bins.band(index);
        let mut from = 0;
        while let Some((at, placed, end)) = numbers.first().and_then(|&number| self.placed_from(from, number)) {
            from = at + 1;
            // Numbers ascend, so that those of a solid lie side by side; mostly they are few of very many.
            let after = numbers.iter().position(|&number| number >= end);
            let (these, rest) = numbers.split_at(after.unwrap_or(numbers.len()));
            numbers = rest;
            let at = [placed.batch as usize, placed.item as usize];
            let Some(instance) = batches.solid(at) else { continue };
            let material = Material::lit(instance.solid.color);
            let source = instance.source(&material, &placed.transform, batches, screen);
            scratch.vertices.clear();
            for number in these {
                if let Some(&keys) = instance.shape.triangles.get((number - placed.first) as usize) {
                    source.draw(keys, &mut scratch.vertices, band);
                }
            }
        }
    }
}

impl SolidInstance<'_> {
    fn source<'s>(
        &'s self,
        material: &'s Material,
        transform: &'s ObjectTransform,
        view: &'s Batches<'_>,
        screen: &'s Screen,
    ) -> Source<'s> {
        let surface = view.surface_of_solid(self.solid);
        Source { vertices: &self.mesh.vertices, material, transform, surface, screen }
    }
}
