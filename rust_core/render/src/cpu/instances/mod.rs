//! Very many small things made of triangles: [`Solids`], other meshes of few triangles, and the glyphs of [`Text`].
//!
//! A scene may have hundreds of thousands of solids of a few hundred triangles each, most of which cover a few pixels.
//! So what is computed for one is thrown away at once but for four bytes for each triangle that may be seen, and
//! computed again, for these few triangles alone, where their band is drawn. A solid goes through three sieves:
//!
//! 1. Its box in clip coordinates: beyond a side of the view, or between the pixels' centres, it is not looked at.
//! 2. Its vertices, eight at a time, as the rows and columns of pixel centres between which they lie. A triangle whose
//!    corners are all in one gap covers no centre, which is true of most triangles of a small solid.
//! 3. Which way the rest of its triangles face.
//!
//! Solids that reach out of the view take the longer way, vertex by vertex, with the arithmetic of [`solids`]; the
//! picture is the same on both. Text is a solid whose triangles are its glyphs' quads; the glyphs are sieved in groups.
//!
//! [`solids`]: super::solids

mod reach;
#[cfg(test)]
mod tests;

use std::collections::HashMap;
use std::ops::Range;
use std::sync::{Arc, Weak};

use fearless_simd::dispatch;
use fearless_simd::prelude::*;
use nalgebra::{Matrix4, Vector3};
use rcs_scene::{CullMode, Drawable, Glyph, Material, Mesh, Solid, Solids, Text, Vertex};

use self::reach::{reach, Reach, ShapeBounds};
use crate::cpu::band::Band;
use crate::cpu::bins::Bins;
use crate::cpu::clip::{ClipVertex, Outside};
use crate::cpu::lanes::{load, map, store_whole, transform, whole, F, LANES};
use crate::cpu::lighting::vertex_color;
use crate::cpu::screen::{ObjectTransform, Screen, SUBPIXELS};
use crate::cpu::surface::Surface;
use crate::cpu::triangles::{self, Corner, ScreenPosition};
use crate::shading::to_light;
use crate::View;

/// Glyphs that are sieved together.
const GLYPHS_IN_GROUP: usize = 64;

/// A mesh as solids use it.
#[derive(Debug)]
pub(super) struct Shape {
    /// The coordinates of the vertices, each filled up to a whole number of lanes.
    coordinates: [Vec<f32>; 3],
    /// The corners of each triangle, which all exist.
    triangles: Vec<[u32; 3]>,
    /// The box around the vertices; `None` where one is not finite.
    bounds: Option<ShapeBounds>,
}

impl Shape {
    fn new(mesh: &Mesh) -> Self {
        let count = mesh.vertices.len();
        let coordinates = [0, 1, 2].map(|axis| {
            let mut values: Vec<f32> = mesh.vertices.iter().map(|vertex| vertex.position[axis]).collect();
            values.resize(count.next_multiple_of(LANES), 0.0);
            values
        });
        let corners = mesh.indices.chunks_exact(3).map(|corners| [corners[0], corners[1], corners[2]]);
        let triangles = corners.filter(|corners| corners.iter().all(|&corner| (corner as usize) < count)).collect();
        let positions = || mesh.vertices.iter().map(|vertex| Vector3::from(vertex.position));
        let is_finite = positions().all(|position| position.iter().all(|c| c.is_finite()));
        let low = positions().reduce(|low, position| low.inf(&position));
        let high = positions().reduce(|high, position| high.sup(&position));
        let bounds = low.zip(high).filter(|_| is_finite).map(|(low, high)| ShapeBounds::new(low, high));
        Self { coordinates, triangles, bounds }
    }
}

/// The shapes that are alive.
#[derive(Debug, Default)]
pub(super) struct Shapes {
    by_address: HashMap<usize, (Weak<Mesh>, Arc<Shape>)>,
}

impl Shapes {
    /// The shape of a mesh, made now if it is new.
    pub(super) fn get(&mut self, mesh: &Arc<Mesh>) -> Arc<Shape> {
        let address = Arc::as_ptr(mesh) as usize;
        let make = || (Arc::downgrade(mesh), Arc::new(Shape::new(mesh)));
        self.by_address.entry(address).or_insert_with(make).1.clone()
    }

    /// Drops those whose meshes are gone.
    pub(super) fn forget_dead(&mut self) {
        self.by_address.retain(|_, (mesh, _)| mesh.strong_count() > 0);
    }
}

/// Many things of one drawable.
#[derive(Debug)]
pub(super) enum Batch<'a> {
    /// Solids, with the shapes that they are made of.
    Solids(&'a Solids, Vec<Arc<Shape>>),
    /// A mesh of few triangles.
    Mesh(SmallMesh<'a>),
    /// The glyphs of a text.
    Text(&'a Text, &'a Drawable),
}

/// A drawable of few triangles.
#[derive(Debug)]
pub(super) struct SmallMesh<'a> {
    /// Where it stands.
    pub drawable: &'a Drawable,
    /// Its triangles.
    pub mesh: &'a Mesh,
    /// How they are lit.
    pub material: &'a Material,
    /// How they are painted, mirrored where the mesh is.
    pub surface: Surface,
    /// As made from the mesh.
    pub shape: Arc<Shape>,
}

impl<'a> Batch<'a> {
    /// Of solids.
    pub(super) fn of_solids(solids: &'a Solids, shapes: &mut Shapes) -> Self {
        Self::Solids(solids, solids.shapes().iter().map(|mesh| shapes.get(mesh)).collect())
    }
}

/// Some things of the batch with this index.
#[derive(Clone, Debug)]
pub(super) struct BatchPiece {
    /// Index of the batch.
    pub batch: usize,
    /// Which of its solids or glyphs.
    pub range: Range<usize>,
}

/// What all batches of a picture share.
#[derive(Debug)]
pub(super) struct BatchView<'a> {
    view: View<'a>,
    view_from_fixed: Matrix4<f64>,
    to_light: Option<Vector3<f32>>,
    /// Of solids: opaque and translucent, each as it is and mirrored.
    surfaces: [[Surface; 2]; 2],
    /// Of the picture's texts: tested against the depth, and on top of everything.
    text_surfaces: Option<[Surface; 2]>,
}

impl<'a> BatchView<'a> {
    /// In a picture.
    pub(super) fn new(view: &View<'a>) -> Self {
        let surface = |is_translucent| {
            let surface = Surface::of(&Material::unlit(is_translucent), None);
            [surface.clone(), surface.mirrored()]
        };
        Self {
            view: *view,
            view_from_fixed: view.camera.fixed_from_view().inverse().to_homogeneous(),
            to_light: to_light(view.camera, view.scene.light.as_ref()),
            surfaces: [surface(false), surface(true)],
            text_surfaces: None,
        }
    }

    /// Takes note of a text's surface.
    pub(super) fn note_text(&mut self, text: &Text, mut surface_of: impl FnMut(&Material) -> Surface) {
        if self.text_surfaces.is_none() {
            let plain = surface_of(text.material());
            let mode = |depth_test| crate::cpu::band::Mode { blend: true, depth_test, depth_write: false };
            self.text_surfaces =
                Some([true, false].map(|depth_test| Surface { mode: mode(depth_test), ..plain.clone() }));
        }
    }

    fn surface_of_solid(&self, solid: &Solid) -> &Surface {
        &self.surfaces[usize::from(solid.is_translucent())][usize::from(solid.is_mirrored())]
    }

    fn surface_of_text(&self, text: &Text) -> Option<&Surface> {
        self.text_surfaces.as_ref().map(|surfaces| &surfaces[usize::from(!text.material().depth_test)])
    }

    fn transform(&self, view_from_object: &Matrix4<f64>) -> ObjectTransform {
        ObjectTransform::with_light(self.view.camera, view_from_object, self.to_light)
    }
}

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
    transform: ObjectTransform,
}

/// Things that are ready to be drawn.
#[derive(Debug, Default)]
pub(super) struct Instances {
    placed: Vec<Placed>,
    /// The numbers of triangles: all those of the first thing, seen or not, then all those of the second, and so on.
    bins: Bins,
    next: u32,
}

/// Where the corners of a thing's triangles come from.
struct Source<'a> {
    vertices: Vertices<'a>,
    material: &'a Material,
    transform: &'a ObjectTransform,
    surface: &'a Surface,
}

enum Vertices<'a> {
    Mesh(&'a Mesh),
    Text(&'a Text),
}

impl Source<'_> {
    fn vertex(&self, key: u32) -> Option<Vertex> {
        match &self.vertices {
            Vertices::Mesh(mesh) => mesh.vertices.get(key as usize).copied(),
            Vertices::Text(text) => {
                let glyph = text.glyphs().get(key as usize / 4)?;
                text.quad(glyph).get(key as usize % 4).copied()
            }
        }
    }

    fn color(&self, vertex: &Vertex) -> [f32; 4] {
        vertex_color(self.material, self.transform, vertex)
    }
}

/// A mesh where it stands.
struct PlacedMesh<'a> {
    fixed_from_mesh: Matrix4<f64>,
    mesh: &'a Mesh,
    material: &'a Material,
    surface: &'a Surface,
    shape: &'a Shape,
}

/// The memory of a thread that makes things ready and draws them.
#[derive(Debug, Default)]
pub(super) struct InstanceScratch {
    /// The snapped places of a solid's vertices, and the gaps between pixel centres that they are in.
    x: Vec<i32>,
    y: Vec<i32>,
    gaps: Vec<i32>,
    /// By the number of the vertex; of the present thing where `generation` is.
    corners: Vec<CachedCorner>,
    generation: u64,
}

#[derive(Clone, Copy, Debug, Default)]
struct CachedCorner {
    generation: u64,
    key: u32,
    outside: Outside,
    corner: Corner,
    is_lit: bool,
}

impl InstanceScratch {
    /// The most corners that are remembered.
    const MAX_CORNERS: usize = 512;

    /// The corners of another thing follow.
    fn begin(&mut self) {
        self.corners.resize(Self::MAX_CORNERS, CachedCorner::default());
        self.generation += 1;
    }

    /// A corner; without its colour unless `light`.
    #[inline]
    fn corner(&mut self, key: u32, source: &Source<'_>, screen: &Screen, light: bool) -> Option<(Corner, Outside)> {
        let generation = self.generation;
        let cached = self.corners.get_mut(key as usize % Self::MAX_CORNERS)?;
        let is_known = cached.generation == generation && cached.key == key;
        if !is_known || (light && !cached.is_lit) {
            let vertex = source.vertex(key)?;
            if !is_known {
                let position = source.transform.clip(vertex.position);
                let (outside, position) = (Outside::new(position), ScreenPosition::new(position, screen));
                let corner = Corner { position, color: [0.0; 4], uv: vertex.uv };
                *cached = CachedCorner { generation, key, outside, corner, is_lit: false };
            }
            if light {
                cached.corner.color = source.color(&vertex);
                cached.is_lit = true;
            }
        }
        Some((cached.corner, cached.outside))
    }
}

/// Where the vertices of a solid inside the view are: their snapped places, and for each the gaps between the columns
/// and the rows of pixel centres that it is in, each as an odd number (an even one is a centre), packed into one.
#[inline(always)]
fn place_vertices<S: Simd>(
    simd: S,
    shape: &Shape,
    rows: &[[f32; 4]; 4],
    screen: &Screen,
    scratch: &mut InstanceScratch,
) {
    let count = shape.coordinates[0].len();
    for memory in [&mut scratch.x, &mut scratch.y, &mut scratch.gaps] {
        memory.resize(count, 0);
    }
    let (half_width, half_height) = screen.half_size();
    let [x, y, z] = &shape.coordinates;
    for begin in (0..count).step_by(LANES) {
        let place = [load(simd, x, begin), load(simd, y, begin), load(simd, z, begin)];
        let [clip_x, clip_y, _, w] = transform(rows, place);
        let inverse_w = F::splat(simd, 1.0) / w;
        let window = [clip_x * inverse_w * half_width + half_width, clip_y * inverse_w * -half_height + half_height];
        let [x, y] = map(
            window,
            #[inline(always)]
            |window| {
                let scaled = (window - 0.5) * (SUBPIXELS as f32);
                let half = scaled.simd_ge(0.0).select(F::splat(simd, 0.5), F::splat(simd, -0.5));
                whole(scaled + half)
            },
        );
        let [gap_x, gap_y] = map(
            [x, y],
            #[inline(always)]
            |place| (place >> 8) + ((place + (SUBPIXELS - 1)) >> 8),
        );
        store_whole(&mut scratch.x, begin, x);
        store_whole(&mut scratch.y, begin, y);
        store_whole(&mut scratch.gaps, begin, (gap_x & 0xffff) | (gap_y << 16));
    }
}

impl Instances {
    /// Forgets everything.
    pub(super) fn clear(&mut self, screen: &Screen) {
        self.placed.clear();
        self.bins.reset(screen);
        self.next = 0;
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
        match batches.get(piece.batch) {
            Some(Batch::Solids(solids, shapes)) => {
                let range = piece.range.clone();
                for (item, solid) in range.clone().zip(solids.as_slice().get(range).unwrap_or(&[])) {
                    let (Some(mesh), Some(shape)) = (solids.shapes().get(solid.shape()), shapes.get(solid.shape()))
                    else {
                        continue;
                    };
                    let fixed_from_mesh = solid.matrix();
                    let (surface, material) = (view.surface_of_solid(solid), &Material::lit(solid.color));
                    let placed = PlacedMesh { fixed_from_mesh, mesh, material, surface, shape };
                    self.add_mesh(&placed, [piece.batch as u32, item as u32], view, screen, scratch);
                }
            }
            Some(Batch::Mesh(SmallMesh { drawable, mesh, material, surface, shape })) => {
                let fixed_from_mesh = drawable.fixed_from_object;
                let placed = PlacedMesh { fixed_from_mesh, mesh, material, surface, shape };
                self.add_mesh(&placed, [piece.batch as u32, 0], view, screen, scratch);
            }
            Some(Batch::Text(text, drawable)) => self.add_text(text, drawable, piece, view, screen, scratch),
            None => {}
        }
    }

    fn add_mesh(
        &mut self,
        placed: &PlacedMesh<'_>,
        [batch, item]: [u32; 2],
        view: &BatchView<'_>,
        screen: &Screen,
        scratch: &mut InstanceScratch,
    ) {
        let &PlacedMesh { mesh, material, surface, shape, .. } = placed;
        let view_from_object = view.view_from_fixed * placed.fixed_from_mesh;
        let rows = ObjectTransform::clip_rows(view.view.camera, &view_from_object);
        let reach = shape.bounds.map_or(Reach::Crossing, |bounds| reach(&bounds, &rows, screen));
        if reach == Reach::Unseen {
            return;
        }
        let first = self.next;
        let is_seen = if reach == Reach::Inside {
            dispatch!(screen.simd_level, simd => place_vertices(simd, shape, &rows, screen, scratch));
            self.add_inside(shape, surface, screen, scratch)
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
            let may_be_cut = reach != Reach::Inside;
            self.placed.push(Placed { first, batch, item, may_be_cut, transform });
            self.next += shape.triangles.len() as u32;
        }
    }

    /// Makes the triangles of a solid inside the view ready whose vertices were placed. Returns whether any may be seen.
    fn add_inside(&mut self, shape: &Shape, surface: &Surface, screen: &Screen, scratch: &InstanceScratch) -> bool {
        let (x, y, gaps) = (scratch.x.as_slice(), scratch.y.as_slice(), scratch.gaps.as_slice());
        let is_hidden = |doubled_area: i64| match surface.cull {
            CullMode::None => doubled_area == 0,
            CullMode::Back => doubled_area >= 0,
            CullMode::Front => doubled_area <= 0,
        };
        let mut is_seen = false;
        for (number, corners) in (self.next..).zip(&shape.triangles) {
            let [a, b, c] = corners.map(|corner| corner as usize);
            let (Some(&gap_a), Some(&gap_b), Some(&gap_c)) = (gaps.get(a), gaps.get(b), gaps.get(c)) else { continue };
            let differences = (gap_a ^ gap_b) | (gap_a ^ gap_c);
            if differences & 0xffff == 0 || differences >> 16 == 0 {
                continue;
            }
            let (ax, ay) = (i64::from(x[a]), i64::from(y[a]));
            let (bx, by) = (i64::from(x[b]) - ax, i64::from(y[b]) - ay);
            let (cx, cy) = (i64::from(x[c]) - ax, i64::from(y[c]) - ay);
            if is_hidden(bx * cy - cx * by) {
                continue;
            }
            let [low, high] = [y[a].min(y[b]).min(y[c]), y[a].max(y[b]).max(y[c])];
            self.bin(number, (low + (SUBPIXELS - 1)) >> 8, (high >> 8) + 1, screen);
            is_seen = true;
        }
        is_seen
    }

    fn add_text(
        &mut self,
        text: &Text,
        drawable: &Drawable,
        piece: &BatchPiece,
        view: &BatchView<'_>,
        screen: &Screen,
        scratch: &mut InstanceScratch,
    ) {
        let Some(surface) = view.surface_of_text(text) else { return };
        let view_from_object = view.view.camera.view_from_facing(&drawable.fixed_from_object).cast();
        let transform = view.transform(&view_from_object);
        let source =
            Source { vertices: Vertices::Text(text), material: text.material(), transform: &transform, surface };
        scratch.begin();
        let range = piece.range.clone();
        let (batch, item) = (piece.batch as u32, range.start as u32);
        let (first, mut is_seen) = (self.next, false);
        for begin in range.clone().step_by(GLYPHS_IN_GROUP) {
            let group = begin..range.end.min(begin + GLYPHS_IN_GROUP);
            let glyphs = text.glyphs().get(group.clone()).unwrap_or(&[]);
            if reach(&bounds_of_glyphs(glyphs, text.height_m()), &transform.clip_from_object, screen) == Reach::Unseen {
                continue;
            }
            for glyph in group {
                let number = first + 2 * (glyph - range.start) as u32;
                for (number, corners) in (number..).zip(glyph_triangles(glyph as u32)) {
                    is_seen |= self.add_triangle(number, corners, &source, screen, scratch);
                }
            }
        }
        if is_seen {
            self.placed.push(Placed { first, batch, item, may_be_cut: true, transform });
            self.next += 2 * range.len() as u32;
        }
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
                let (begin, end) = triangles::rows(corners.each_ref().map(|corner| &corner.position));
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
            self.bin(number, begin, end, screen);
        }
        is_seen
    }

    #[inline]
    fn bin(&mut self, number: u32, begin: i32, end: i32, screen: &Screen) {
        let row = |row: i32| row.clamp(0, screen.height_px as i32) as u32;
        self.bins.add(number, row(begin), row(end));
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
        while let Some(&number) = numbers.first() {
            // Numbers ascend, so that those of a thing lie side by side.
            let next = self.placed.partition_point(|placed| placed.first <= number);
            let end = self.placed.get(next).map_or(u32::MAX, |placed| placed.first);
            let (these, rest) = numbers.split_at(numbers.partition_point(|&number| number < end));
            numbers = rest;
            let Some(placed) = next.checked_sub(1).and_then(|index| self.placed.get(index)) else { continue };
            scratch.begin();
            let mut draw_mesh = |mesh, material, surface, shape: &Shape| {
                let source = Source { vertices: Vertices::Mesh(mesh), material, transform: &placed.transform, surface };
                for number in these {
                    if let Some(corners) = shape.triangles.get((number - placed.first) as usize) {
                        draw_triangle(*corners, &source, placed.may_be_cut, screen, scratch, band);
                    }
                }
            };
            match batches.get(placed.batch as usize) {
                Some(Batch::Solids(solids, shapes)) => {
                    let Some(solid) = solids.as_slice().get(placed.item as usize) else { continue };
                    let (mesh, shape) = (solids.shapes().get(solid.shape()), shapes.get(solid.shape()));
                    if let (Some(mesh), Some(shape)) = (mesh, shape) {
                        draw_mesh(mesh, &Material::lit(solid.color), view.surface_of_solid(solid), shape);
                    }
                }
                Some(Batch::Mesh(SmallMesh { mesh, material, surface, shape, .. })) => {
                    draw_mesh(mesh, material, surface, shape);
                }
                Some(Batch::Text(text, _)) => {
                    let Some(surface) = view.surface_of_text(text) else { continue };
                    let (vertices, material) = (Vertices::Text(text), text.material());
                    let source = Source { vertices, material, transform: &placed.transform, surface };
                    for number in these {
                        let triangle = number - placed.first;
                        let corners = glyph_triangles(placed.item + triangle / 2)[triangle as usize % 2];
                        draw_triangle(corners, &source, placed.may_be_cut, screen, scratch, band);
                    }
                }
                None => {}
            }
        }
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

/// The corners of both triangles of a glyph.
fn glyph_triangles(glyph: u32) -> [[u32; 3]; 2] {
    let [a, b, c, d, e, f] = Text::QUAD_INDICES.map(|corner| 4 * glyph + corner as u32);
    [[a, b, c], [d, e, f]]
}

/// The box around glyphs; not finite where one of them is not.
fn bounds_of_glyphs(glyphs: &[Glyph], height_m: f32) -> ShapeBounds {
    let infinity = Vector3::repeat(f32::INFINITY);
    let (mut low, mut high) = (infinity, -infinity);
    let mut poison = 0.0;
    for glyph in glyphs {
        let bottom_m = glyph.top_m - height_m;
        // Edges change sides in text of a negative height.
        low = low.inf(&Vector3::new(glyph.left_m.min(glyph.right_m), glyph.top_m.min(bottom_m), 0.0));
        high = high.sup(&Vector3::new(glyph.left_m.max(glyph.right_m), glyph.top_m.max(bottom_m), 0.0));
        poison += (glyph.left_m + glyph.right_m + glyph.top_m + bottom_m) * 0.0;
    }
    ShapeBounds::new(low.add_scalar(poison), high)
}
