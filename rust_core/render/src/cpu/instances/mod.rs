//! Very many small things made of triangles: [`Solids`](rcs_scene::Solids), other meshes of few triangles, and the
//! glyphs of [`Text`].
//!
//! A scene may have hundreds of thousands of solids of a few hundred triangles each, most of which cover a few pixels.
//! So what is computed for one is thrown away at once but for four bytes for each triangle that may be seen, and
//! computed again, for these few triangles alone, where their band is drawn. A solid goes through three sieves:
//!
//! 1. Its box in clip coordinates: beyond a side of the view, or between the pixels' centres, it is not looked at.
//! 2. Its triangles, eight at a time: those that are sure to turn their hidden side to the eye are left out.
//! 3. Its vertices, eight at a time, as the rows and columns of pixel centres between which they lie. A triangle whose
//!    corners are all in one gap covers no centre, which is true of most triangles of a small solid.
//!
//! Solids that reach out of the view take the longer way, vertex by vertex, with the arithmetic of [`solids`]; the
//! picture is the same on both. Text is a solid whose triangles are its glyphs' quads; the glyphs are sieved in groups.
//!
//! [`solids`]: super::solids

mod batch;
mod corners;
mod glyphs;
mod reach;
mod shape;
mod sieve;
#[cfg(test)]
mod tests;
mod text;

use fearless_simd::dispatch;
use nalgebra::Matrix4;
use rcs_scene::{Material, Mesh, Solid};

pub(super) use self::batch::{Batch, BatchPiece, BatchView, SmallMesh};
pub(super) use self::corners::InstanceScratch;
use self::corners::{place_vertices, Source, Vertices};
use self::glyphs::GlyphRect;
use self::reach::{place_box, Placement};
use self::shape::Shape;
pub(super) use self::shape::{shape_of, Shapes};
use self::sieve::{sieve, Facing};
use self::text::{glyph_triangles, UprightText};
use crate::cpu::band::{Band, Mode};
use crate::cpu::bins::Bins;
use crate::cpu::clip::ClipVertex;
use crate::cpu::paint::Surface;
use crate::cpu::ranked::{Extent, Load, NearToFar};
use crate::cpu::screen::{ObjectTransform, Screen};
use crate::cpu::triangles::{self, Corner};

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
    /// Index of its transform; of a text that has rectangles alone there is none.
    transform: Option<u32>,
    /// Index of what is known of an upright text.
    upright: Option<u32>,
}

/// Things that are ready to be drawn.
#[derive(Debug, Default)]
pub(super) struct Instances {
    placed: Vec<Placed>,
    transforms: Vec<ObjectTransform>,
    upright: Vec<UprightText>,
    /// Those of upright texts, a place for each of their glyphs.
    rects: Vec<GlyphRect>,
    /// The numbers of triangles: all those of the first thing, seen or not, then all those of the second, and so on.
    bins: Bins,
    next: u32,
    load: Load,
}

/// A mesh where it stands.
struct PlacedMesh<'a> {
    fixed_from_mesh: Matrix4<f64>,
    mesh: &'a Mesh,
    shape: &'a Shape,
    look: Look<'a>,
}

/// How a mesh is lit and painted; of a solid that is worked out where it may be seen.
enum Look<'a> {
    Solid(&'a Solid),
    Mesh(&'a Material, &'a Surface),
}

impl Instances {
    /// Forgets everything.
    pub(super) fn clear(&mut self, screen: &Screen) {
        self.placed.clear();
        self.transforms.clear();
        self.upright.clear();
        self.rects.clear();
        self.bins.reset(screen);
        self.next = 0;
        self.load = Load::default();
    }

    /// How much there is to draw.
    pub(super) fn load(&self) -> Load {
        self.load
    }

    /// Makes some things ready.
    pub(super) fn add(
        &mut self,
        piece: &BatchPiece,
        batches: &[Batch<'_>],
        view: &BatchView<'_>,
        screen: &Screen,
        scratch: &mut InstanceScratch,
    ) {
        if let Some(Batch::Text(text, drawable)) = batches.get(piece.batch) {
            self.add_text(text, drawable, piece, view, screen, scratch);
        }
        for_each_mesh(piece, batches, |placed, ids| self.add_mesh(placed, ids, view, screen, scratch));
    }

    fn add_mesh(
        &mut self,
        placed: &PlacedMesh<'_>,
        [batch, item]: [u32; 2],
        view: &BatchView<'_>,
        screen: &Screen,
        scratch: &mut InstanceScratch,
    ) {
        let &PlacedMesh { mesh, shape, .. } = placed;
        let view_from_object = view.view_from_fixed * placed.fixed_from_mesh;
        let rows = ObjectTransform::clip_rows(view.view.camera, &view_from_object);
        let placement = shape.bounds.map_or(Placement::Crossing, |bounds| place_box(&bounds, &rows, screen));
        if placement == Placement::Unseen {
            return;
        }
        let of_solid;
        let (material, surface) = match placed.look {
            Look::Solid(solid) => {
                of_solid = Material::lit(solid.color);
                (&of_solid, view.surface_of_solid(solid))
            }
            Look::Mesh(material, surface) => (material, surface),
        };
        self.load.in_order |= surface.mode != Mode::OPAQUE;
        let first = self.next;
        let is_inside = matches!(placement, Placement::Inside(_));
        let is_seen = if let Placement::Inside(footprint) = placement {
            let facing = Facing::of(shape, surface, &rows, &footprint, screen);
            dispatch!(screen.simd_level, simd => {
                place_vertices(simd, shape, &rows, screen, scratch);
                sieve(simd, shape, surface, facing.as_ref(), scratch);
            });
            self.add_inside(shape, screen, scratch)
        } else {
            let transform = view.transform(&view_from_object);
            let source = Source { vertices: Vertices::Mesh(mesh), material, transform: &transform, surface };
            scratch.begin();
            let numbers = (first..).zip(&shape.triangles);
            // Each triangle is looked at, whether others are seen or not.
            numbers.fold(false, |seen, (number, corners)| {
                self.add_triangle(number, *corners, &source, screen, scratch) || seen
            })
        };
        if is_seen {
            let transform = view.transform(&view_from_object);
            let transform = Some(self.keep(transform));
            self.placed.push(Placed { first, batch, item, may_be_cut: !is_inside, transform, upright: None });
            self.next += shape.triangles.len() as u32;
        }
    }

    /// Keeps a transform; returns its index.
    fn keep(&mut self, transform: ObjectTransform) -> u32 {
        self.transforms.push(transform);
        self.transforms.len() as u32 - 1
    }

    fn transform_of(&self, placed: &Placed) -> Option<&ObjectTransform> {
        self.transforms.get(placed.transform? as usize)
    }

    /// Makes the triangles of a solid inside the view ready that are left of it. Returns whether any may be seen.
    fn add_inside(&mut self, shape: &Shape, screen: &Screen, scratch: &InstanceScratch) -> bool {
        let mut is_seen = false;
        for &triangle in &scratch.seen {
            let Some(places) = shape.places.get(triangle as usize) else { continue };
            let places = places.map(|place| scratch.place_of(place));
            if !triangles::covers_any_centre(places) {
                continue;
            }
            let [a, b, c] = places;
            let (columns, rows) = (triangles::between(a[0], b[0], c[0]), triangles::between(a[1], b[1], c[1]));
            self.load.add(Extent::of_triangle(columns, rows, triangles::doubled_area_of(places), screen));
            self.bin(self.next + triangle, rows.0, rows.1, screen);
            is_seen = true;
        }
        is_seen
    }

    /// Makes a triangle ready. Returns whether it may be seen.
    fn add_triangle(
        &mut self,
        number: u32,
        corners: [u32; 3],
        source: &Source<'_>,
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
                let (begin, end) = triangles::rows(positions);
                self.load.add(triangles::extent(positions, screen));
                rows = Some(rows.map_or((begin, end), |rows| (rows.0.min(begin), rows.1.max(end))));
            });
            if let Some((begin, end)) = rows {
                self.bin(number, begin, end, screen);
            }
            return rows.is_some();
        }
        let positions = [&a.position, &b.position, &c.position];
        let is_seen = triangles::may_be_seen(positions, source.surface, screen);
        if is_seen {
            let (begin, end) = triangles::rows(positions);
            self.load.add(triangles::extent(positions, screen));
            self.bin(number, begin, end, screen);
        }
        is_seen
    }

    #[inline]
    fn bin(&mut self, number: u32, begin: i32, end: i32, screen: &Screen) {
        let row = |row: i32| row.clamp(0, screen.height_px as i32) as u32;
        self.bins.add(number, row(begin), row(end));
    }

    /// The thing that a triangle belongs to.
    fn placed(&self, number: u32) -> Option<&Placed> {
        let after = self.placed.partition_point(|placed| placed.first <= number);
        self.placed.get(after.checked_sub(1)?)
    }

    /// The same of a thing that is not before an index, what is near to that being found soonest; with its own index
    /// before it, and behind it the number of the next thing's first triangle.
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
    pub(super) fn draw(
        &self,
        batches: &[Batch<'_>],
        view: &BatchView<'_>,
        screen: &Screen,
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
            let glyphs = self.upright_glyphs(placed, view);
            let Some(transform) = self.transform_of(placed) else {
                if let Some(glyphs) = glyphs {
                    for number in these {
                        glyphs.draw(number - placed.first, band);
                    }
                }
                continue;
            };
            scratch.begin();
            placed.with_source(transform, batches, view, |source, triangle| {
                for number in these {
                    if glyphs.as_ref().is_some_and(|glyphs| glyphs.draw(number - placed.first, band)) {
                        continue;
                    }
                    if let Some(corners) = triangle(number - placed.first) {
                        draw_triangle(corners, source, placed.may_be_cut, screen, scratch, band);
                    }
                }
            });
        }
    }

    /// Draws a band's rows of the triangles of several jobs that need not be drawn in their order.
    pub(super) fn draw_ranked(
        jobs: &[&Self],
        (batches, view): (&[Batch<'_>], &BatchView<'_>),
        (screen, index): (&Screen, usize),
        (scratch, order): (&mut InstanceScratch, &mut NearToFar),
        band: &mut Band<'_>,
    ) {
        let lists: Vec<&[u32]> = jobs.iter().map(|job| job.bins.band(index)).collect();
        let count = order.sort(&lists, |job, number| jobs.get(job).map_or(0.0, |job| job.nearness(number, batches)));
        match band.begin_ranks(count) {
            Some(first) => {
                for face in order.faces(&lists) {
                    let Some(job) = jobs.get(face.job) else { continue };
                    let Some(placed) = job.placed(face.number) else { continue };
                    let Some(transform) = job.transform_of(placed) else { continue };
                    band.set_rank(first + face.rank);
                    scratch.begin();
                    placed.with_source(transform, batches, view, |source, triangle| {
                        if let Some(corners) = triangle(face.number - placed.first) {
                            draw_triangle(corners, source, placed.may_be_cut, screen, scratch, band);
                        }
                    });
                }
            }
            None => jobs.iter().for_each(|job| job.draw(batches, view, screen, index, scratch, band)),
        }
        band.end_ranks();
    }

    /// How near a triangle of a solid or a mesh is: the w of its first corner.
    fn nearness(&self, number: u32, batches: &[Batch<'_>]) -> f32 {
        let vertex = |placed: &Placed| {
            let shape = placed.shape(batches)?;
            let [place, ..] = *shape.places.get((number - placed.first) as usize)?;
            let [x, y, z] =
                shape.coordinates.each_ref().map(|all| all.get(place as usize).copied().unwrap_or_default());
            let [.., w] = self.transform_of(placed)?.clip([x, y, z]);
            Some(w)
        };
        self.placed(number).and_then(vertex).unwrap_or(f32::INFINITY)
    }
}

impl Placed {
    /// The shape of a solid or a mesh.
    fn shape<'b>(&self, batches: &'b [Batch<'_>]) -> Option<&'b Shape> {
        match batches.get(self.batch as usize)? {
            Batch::Solids(solids, shapes) => shapes.get(solids.as_slice().get(self.item as usize)?.shape()),
            Batch::Mesh(SmallMesh { shape, .. }) => Some(shape),
            Batch::Text(..) => None,
        }
        .map(AsRef::as_ref)
    }

    /// Passes on where the corners come from, and which of them make a triangle of this thing.
    #[inline]
    fn with_source(
        &self,
        transform: &ObjectTransform,
        batches: &[Batch<'_>],
        view: &BatchView<'_>,
        work: impl FnOnce(&Source<'_>, &dyn Fn(u32) -> Option<[u32; 3]>),
    ) {
        match batches.get(self.batch as usize) {
            Some(Batch::Solids(solids, shapes)) => {
                let Some(solid) = solids.as_slice().get(self.item as usize) else { return };
                let (mesh, shape) = (solids.shapes().get(solid.shape()), shapes.get(solid.shape()));
                let (Some(mesh), Some(shape)) = (mesh, shape) else { return };
                let (material, surface) = (&Material::lit(solid.color), view.surface_of_solid(solid));
                let source = Source { vertices: Vertices::Mesh(mesh), material, transform, surface };
                work(&source, &|triangle| shape.triangles.get(triangle as usize).copied());
            }
            Some(Batch::Mesh(SmallMesh { mesh, material, surface, shape, .. })) => {
                let source = Source { vertices: Vertices::Mesh(mesh), material, transform, surface };
                work(&source, &|triangle| shape.triangles.get(triangle as usize).copied());
            }
            Some(Batch::Text(text, _)) => {
                let material = text.material();
                let Some(surface) = view.surface_of_texts(!material.depth_test) else { return };
                let source = Source { vertices: Vertices::Text(text), material, transform, surface };
                work(&source, &|triangle| {
                    glyph_triangles(self.item + triangle / 2).get(triangle as usize % 2).copied()
                });
            }
            None => {}
        }
    }
}

/// Passes on the solids or the mesh of a piece, each with the indices of its batch and in it.
fn for_each_mesh(piece: &BatchPiece, batches: &[Batch<'_>], mut work: impl FnMut(&PlacedMesh<'_>, [u32; 2])) {
    match batches.get(piece.batch) {
        Some(Batch::Solids(solids, shapes)) => {
            let range = piece.range.clone();
            for (item, solid) in range.clone().zip(solids.as_slice().get(range).unwrap_or(&[])) {
                let (mesh, shape) = (solids.shapes().get(solid.shape()), shapes.get(solid.shape()));
                let (Some(mesh), Some(shape)) = (mesh, shape) else { continue };
                let look = Look::Solid(solid);
                let placed = PlacedMesh { fixed_from_mesh: solid.matrix(), mesh, shape, look };
                work(&placed, [piece.batch as u32, item as u32]);
            }
        }
        Some(Batch::Mesh(SmallMesh { drawable, mesh, material, surface, shape })) => {
            let fixed_from_mesh = drawable.fixed_from_object;
            let look = Look::Mesh(material, surface);
            work(&PlacedMesh { fixed_from_mesh, mesh, shape, look }, [piece.batch as u32, 0]);
        }
        Some(Batch::Text(..)) | None => {}
    }
}

fn draw_triangle(
    corners: [u32; 3],
    source: &Source<'_>,
    may_be_cut: bool,
    screen: &Screen,
    scratch: &mut InstanceScratch,
    band: &mut Band<'_>,
) {
    let mut place = |key| scratch.corner(key, source, screen, true);
    let [Some((a, out_a)), Some((b, out_b)), Some((c, out_c))] = corners.map(&mut place) else { return };
    if may_be_cut && out_a.guard | out_b.guard | out_c.guard != 0 {
        cut(corners, source, screen, |corners| triangles::draw(corners.each_ref(), source.surface, band));
    } else {
        triangles::draw([&a, &b, &c], source.surface, band);
    }
}

/// Clips a triangle that reaches far out of the picture, and passes on the parts that are to be drawn.
fn cut(keys: [u32; 3], source: &Source<'_>, screen: &Screen, out: impl FnMut(&[Corner; 3])) {
    let vertex = |key: u32| {
        let vertex = source.vertex(key)?;
        let position = source.transform.clip(vertex.position);
        Some(ClipVertex { position, color: source.color(&vertex), uv: vertex.uv })
    };
    if let [Some(a), Some(b), Some(c)] = keys.map(vertex) {
        triangles::cut([&a, &b, &c], source.surface, screen, out);
    }
}
