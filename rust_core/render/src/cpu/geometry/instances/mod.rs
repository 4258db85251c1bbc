//! Very many small things made of triangles: [`Solids`], and the glyphs of [`Text`](rcs_scene::Text).
//!
//! A scene may have hundreds of thousands of solids of a few hundred triangles each, most of which cover a few pixels.
//! So what is computed for one is thrown away at once but for four bytes for each triangle that may be seen, and
//! computed again, for these few triangles alone, where their band is drawn. A solid goes through two tests:
//!
//! 1. Its box in clip coordinates: beyond a side of the view, or between the pixels' centres, it is not looked at.
//! 2. Its vertices, eight at a time, as the rows and columns of pixel centres between which they lie. A triangle whose
//!    corners are all in one gap covers no centre, which is true of most triangles of a small solid.
//!
//! Solids that reach out of the view take the longer way, vertex by vertex, with the arithmetic of [`solids`]; the
//! picture is the same on both. Text is a solid whose triangles are its glyphs' quads; the glyphs are tested in groups.
//!
//! [`solids`]: super::meshes

mod batch;
mod corners;
mod placement;
mod shape;
#[cfg(test)]
mod tests;
mod text;

use std::sync::Arc;

use fearless_simd::dispatch;
use rcs_scene::{CullMode, Material, Mesh, Solid, Solids};

pub(in crate::cpu) use self::batch::{Batch, BatchPiece, BatchView, InstanceContext};
pub(in crate::cpu) use self::corners::InstanceScratch;
use self::corners::{place_vertices, CornerSource, Vertices};
use self::placement::{place_box, Placement};
use self::shape::Shape;
pub(in crate::cpu) use self::shape::Shapes;
use self::text::glyph_triangles;
use crate::cpu::raster::clip::ClipVertex;
use crate::cpu::raster::triangle::{self, Corner};
use crate::cpu::tile::band::Band;
use crate::cpu::tile::bins::Bins;
use crate::cpu::tile::screen::{ObjectTransform, Screen};

/// The triangles of a solid or a text that are ready to be drawn.
#[derive(Clone, Debug)]
struct Placed {
    /// The number of its first triangle.
    first: u32,
    batch: u32,
    /// Index of the solid; of a text that of its first glyph.
    item: u32,
    /// A triangle may have to be cut.
    may_be_cut: bool,
    /// Index of its transform.
    transform: u32,
}

/// Things that are ready to be drawn.
#[derive(Debug, Default)]
pub(in crate::cpu) struct Instances {
    placed: Vec<Placed>,
    transforms: Vec<ObjectTransform>,
    /// The numbers of triangles: all those of the first thing, seen or not, then all those of the second, and so on.
    bins: Bins,
    next: u32,
}

impl Instances {
    /// Forgets everything.
    pub(in crate::cpu) fn clear(&mut self, screen: &Screen) {
        self.placed.clear();
        self.transforms.clear();
        self.bins.reset(screen);
        self.next = 0;
    }

    /// Makes some things ready.
    pub(in crate::cpu) fn add(
        &mut self,
        piece: &BatchPiece,
        context: &InstanceContext<'_>,
        scratch: &mut InstanceScratch,
    ) {
        match context.batches.get(piece.batch) {
            Some(Batch::Text(text, drawable)) => self.add_text(text, drawable, piece, context, scratch),
            Some(Batch::Solids(solids, shapes)) => {
                for item in piece.range.clone() {
                    if let Some(placed) = SolidInstance::new(solids, shapes, item) {
                        self.add_solid(&placed, [piece.batch as u32, item as u32], context, scratch);
                    }
                }
            }
            None => {}
        }
    }

    fn add_solid(
        &mut self,
        &SolidInstance { solid, mesh, shape }: &SolidInstance<'_>,
        [batch, item]: [u32; 2],
        &InstanceContext { view, screen, .. }: &InstanceContext<'_>,
        scratch: &mut InstanceScratch,
    ) {
        let view_from_object = view.view_from_fixed * solid.matrix();
        let rows = ObjectTransform::clip_rows(view.view.camera, &view_from_object);
        let placement = shape.bounds.map_or(Placement::Crossing, |bounds| place_box(&bounds, &rows, screen));
        if placement == Placement::Unseen {
            return;
        }
        let (material, surface) = (&Material::lit(solid.color), view.surface_of_solid(solid));
        let first = self.next;
        let is_inside = placement == Placement::Inside;
        let is_seen = if is_inside {
            dispatch!(screen.simd_level, simd => place_vertices(simd, shape, &rows, screen, scratch));
            self.add_inside(shape, surface.cull, screen, scratch)
        } else {
            let transform = view.transform(&view_from_object);
            let source = CornerSource { vertices: Vertices::Mesh(mesh), material, transform: &transform, surface };
            scratch.begin();
            let numbers = (first..).zip(&shape.triangles);
            // Each triangle is looked at, whether others are seen or not.
            numbers.fold(false, |seen, (number, corners)| {
                self.add_triangle(number, *corners, &source, screen, scratch) || seen
            })
        };
        if is_seen {
            let transform = view.transform(&view_from_object);
            let transform = self.keep(transform);
            self.placed.push(Placed { first, batch, item, may_be_cut: !is_inside, transform });
            self.next += shape.triangles.len() as u32;
        }
    }

    /// Keeps a transform; returns its index.
    fn keep(&mut self, transform: ObjectTransform) -> u32 {
        self.transforms.push(transform);
        self.transforms.len() as u32 - 1
    }

    /// Makes the triangles of a solid inside the view ready that may be seen, given where its vertices were placed.
    /// Returns `true` if there are some.
    fn add_inside(&mut self, shape: &Shape, cull: CullMode, screen: &Screen, scratch: &InstanceScratch) -> bool {
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
            let rows = triangle::between(a[1], b[1], c[1]);
            self.bin(number, rows.0, rows.1, screen);
            is_seen = true;
        }
        is_seen
    }

    /// Makes a triangle ready. Returns whether it may be seen.
    fn add_triangle(
        &mut self,
        number: u32,
        corners: [u32; 3],
        source: &CornerSource<'_>,
        screen: &Screen,
        scratch: &mut InstanceScratch,
    ) -> bool {
        let mut place = |key| scratch.corner(key, source, screen, false);
        let [Some((a, out_a)), Some((b, out_b)), Some((c, out_c))] = corners.map(&mut place) else { return false };
        if out_a.view & out_b.view & out_c.view != 0 {
            return false;
        }
        if out_a.guard | out_b.guard | out_c.guard != 0 {
            let mut rows: Option<(i32, i32)> = None;
            cut(corners, source, screen, |corners| {
                let positions = corners.each_ref().map(|corner| &corner.position);
                let (begin, end) = triangle::rows(positions);
                rows = Some(rows.map_or((begin, end), |rows| (rows.0.min(begin), rows.1.max(end))));
            });
            if let Some((begin, end)) = rows {
                self.bin(number, begin, end, screen);
            }
            return rows.is_some();
        }
        let positions = [&a.position, &b.position, &c.position];
        let is_seen = triangle::may_be_seen(positions, source.surface, screen);
        if is_seen {
            let (begin, end) = triangle::rows(positions);
            self.bin(number, begin, end, screen);
        }
        is_seen
    }

    #[inline]
    fn bin(&mut self, number: u32, begin: i32, end: i32, screen: &Screen) {
        let row = |row: i32| row.clamp(0, screen.height_px as i32) as u32;
        self.bins.add(number, row(begin), row(end));
    }

    /// The thing that a triangle belongs to, of those that are not before an index; near ones are found soonest. With
    /// its own index before it, and behind it the number of the next thing's first triangle.
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
        context: &InstanceContext<'_>,
        index: usize,
        scratch: &mut InstanceScratch,
        band: &mut Band<'_>,
    ) {
        let mut numbers = self.bins.band(index);
        let mut from = 0;
        while let Some((at, placed, end)) = numbers.first().and_then(|&number| self.placed_from(from, number)) {
            from = at + 1;
            // Numbers ascend, so that those of a thing lie side by side; mostly they are few of very many.
            let after = numbers.iter().position(|&number| number >= end);
            let (these, rest) = numbers.split_at(after.unwrap_or(numbers.len()));
            numbers = rest;
            let Some(transform) = self.transforms.get(placed.transform as usize) else { continue };
            scratch.begin();
            placed.with_source(transform, context, |source, triangle| {
                for number in these {
                    if let Some(corners) = triangle(number - placed.first) {
                        draw_triangle((corners, placed.may_be_cut), source, context.screen, scratch, band);
                    }
                }
            });
        }
    }
}

impl Placed {
    /// Passes on where the corners come from, and which of them make a triangle of this thing.
    #[inline]
    fn with_source(
        &self,
        transform: &ObjectTransform,
        &InstanceContext { batches, view, .. }: &InstanceContext<'_>,
        work: impl FnOnce(&CornerSource<'_>, &dyn Fn(u32) -> Option<[u32; 3]>),
    ) {
        match batches.get(self.batch as usize) {
            Some(Batch::Solids(solids, shapes)) => {
                let instance = SolidInstance::new(solids, shapes, self.item as usize);
                let Some(SolidInstance { solid, mesh, shape }) = instance else { return };
                let (material, surface) = (&Material::lit(solid.color), view.surface_of_solid(solid));
                let source = CornerSource { vertices: Vertices::Mesh(mesh), material, transform, surface };
                work(&source, &|triangle| shape.triangles.get(triangle as usize).copied());
            }
            Some(Batch::Text(text, _)) => {
                let material = text.material();
                let Some(surface) = view.surface_of_texts(!material.depth_test) else { return };
                let source = CornerSource { vertices: Vertices::Text(text), material, transform, surface };
                work(&source, &|triangle| {
                    glyph_triangles(self.item + triangle / 2).get(triangle as usize % 2).copied()
                });
            }
            None => {}
        }
    }
}

/// A solid with its shape.
struct SolidInstance<'a> {
    solid: &'a Solid,
    mesh: &'a Mesh,
    shape: &'a Shape,
}

impl<'a> SolidInstance<'a> {
    fn new(solids: &'a Solids, shapes: &'a [Arc<Shape>], item: usize) -> Option<Self> {
        let solid = solids.as_slice().get(item)?;
        Some(Self { solid, mesh: solids.shapes().get(solid.shape())?, shape: shapes.get(solid.shape())? })
    }
}

fn draw_triangle(
    (corners, may_be_cut): ([u32; 3], bool),
    source: &CornerSource<'_>,
    screen: &Screen,
    scratch: &mut InstanceScratch,
    band: &mut Band<'_>,
) {
    let mut place = |key| scratch.corner(key, source, screen, true);
    let [Some((a, out_a)), Some((b, out_b)), Some((c, out_c))] = corners.map(&mut place) else { return };
    if may_be_cut && out_a.guard | out_b.guard | out_c.guard != 0 {
        cut(corners, source, screen, |corners| triangle::draw(corners.each_ref(), source.surface, band));
    } else {
        triangle::draw([&a, &b, &c], source.surface, band);
    }
}

/// Clips a triangle that reaches far out of the picture, and passes on the parts that are to be drawn.
fn cut(keys: [u32; 3], source: &CornerSource<'_>, screen: &Screen, out: impl FnMut(&[Corner; 3])) {
    let vertex = |key: u32| {
        let vertex = source.vertex(key)?;
        let position = source.transform.clip(vertex.position);
        Some(ClipVertex { position, color: source.color(&vertex), uv: vertex.uv })
    };
    if let [Some(a), Some(b), Some(c)] = keys.map(vertex) {
        triangle::cut([&a, &b, &c], source.surface, screen, out);
    }
}
