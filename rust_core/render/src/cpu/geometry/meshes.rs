//! Meshes, lines, ribbons and text up to their pixels: everything that is made of triangles and lines.
//!
//! Their primitives are transformed, lit, clipped and made ready in the order in which they are to be drawn; then they
//! are sorted into the bands of the picture by reference.

use std::borrow::Cow;
use std::ops::Range;

use rcs_scene::{Lines, Material, Mesh};

use super::lighting::vertex_color;
use crate::cpu::paint::Surface;
use crate::cpu::raster::clip::{ClipVertex, Outside};
use crate::cpu::raster::line::{self, Line};
use crate::cpu::raster::triangle::{self, Corner};
use crate::cpu::tile::band::{Band, Mode};
use crate::cpu::tile::bins::Bins;
use crate::cpu::tile::near_to_far::{Load, NearToFar};
use crate::cpu::tile::screen::{ObjectTransform, Screen, ScreenPosition};

/// Something made of triangles or lines.
#[derive(Debug)]
pub(in crate::cpu) struct Solid<'a> {
    /// From its frame to the picture.
    pub transform: ObjectTransform,
    /// How it is painted.
    pub surface: Surface,
    /// Its triangles or lines.
    pub shape: Shape<'a>,
}

/// The triangles or lines of a [`Solid`].
#[derive(Debug)]
pub(in crate::cpu) enum Shape<'a> {
    /// Triangles with a material.
    Mesh(Cow<'a, Mesh>, Cow<'a, Material>),
    /// Lines of a pixel.
    Lines(&'a Lines),
}

impl Shape<'_> {
    /// The number of its triangles or lines.
    pub(in crate::cpu) fn primitive_count(&self) -> usize {
        match self {
            Self::Mesh(mesh, _) => mesh.indices.len() / 3,
            Self::Lines(lines) => lines.segment_count(),
        }
    }
}

/// A triangle that is ready to be drawn. The values interpolated over it are computed where it covers pixels: to keep
/// them for each would take ten times the memory, and time with it.
#[derive(Clone, Copy, Debug)]
struct Triangle {
    /// Indices of its corners.
    corners: [u32; 3],
    /// Index of the solid.
    solid: u32,
}

/// The mesh that triangles come from.
struct Source<'a> {
    mesh: &'a Mesh,
    material: &'a Material,
    transform: &'a ObjectTransform,
    surface: &'a Surface,
    /// Of the solid.
    index: u32,
    screen: &'a Screen,
}

/// Primitives that are ready to be drawn.
#[derive(Debug, Default)]
pub(in crate::cpu) struct Primitives {
    /// Corners of triangles that may be seen, which share them.
    corners: Vec<Corner>,
    triangles: Vec<Triangle>,
    /// A depth that no fragment of a triangle is nearer than.
    least: Vec<f32>,
    lines: Vec<Line>,
    /// Twice a triangle's index, or twice a line's and one.
    bins: Bins,
    load: Load,
}

impl Primitives {
    /// Forgets everything.
    pub(in crate::cpu) fn clear(&mut self, screen: &Screen) {
        self.corners.clear();
        self.triangles.clear();
        self.least.clear();
        self.lines.clear();
        self.bins.reset(screen);
        self.load = Load::default();
    }

    /// The amount that is to be drawn.
    pub(in crate::cpu) fn load(&self) -> Load {
        self.load
    }

    /// Makes a range of a solid's primitives ready, given the solid's index.
    pub(in crate::cpu) fn add(
        &mut self,
        solid: &Solid<'_>,
        (index, range): (u32, Range<usize>),
        screen: &Screen,
        cache: &mut VertexCache,
    ) {
        match &solid.shape {
            Shape::Mesh(mesh, material) => {
                self.load.in_order |= solid.surface.mode != Mode::OPAQUE;
                cache.clear();
                let source =
                    Source { mesh, material, transform: &solid.transform, surface: &solid.surface, index, screen };
                let corners = mesh.indices.get(range.start * 3..range.end * 3).unwrap_or(&[]);
                for corners in corners.chunks_exact(3) {
                    self.add_triangle(&source, corners, cache);
                }
            }
            Shape::Lines(lines) => {
                self.load.in_order = true;
                for (a, b) in lines.segments(range) {
                    let vertex = |i: usize| {
                        Some(ClipVertex {
                            position: solid.transform.clip(*lines.positions.get(i)?),
                            color: lines.color(i).map(|c| f32::from(c) / 255.0),
                            uv: [0.0; 2],
                        })
                    };
                    if let (Some(a), Some(b)) = (vertex(a), vertex(b)) {
                        self.add_line(a, b, solid.surface.mode, screen);
                    }
                }
            }
        }
    }

    /// Makes the triangle of three corners ready.
    #[inline]
    fn add_triangle(&mut self, source: &Source<'_>, corners: &[u32], cache: &mut VertexCache) {
        let &[a, b, c] = corners else { return };
        let mut place = |key| cache.place(key, source);
        let (Some((a, out_a)), Some((b, out_b)), Some((c, out_c))) = (place(a), place(b), place(c)) else { return };
        if out_a.view & out_b.view & out_c.view != 0 {
            return;
        }
        if out_a.guard | out_b.guard | out_c.guard != 0 {
            self.add_cut(source, corners);
            return;
        }
        let positions = [&a, &b, &c];
        if !triangle::may_be_seen(positions, source.surface, source.screen) {
            return;
        }
        let (rows, least) = (triangle::rows(positions), triangle::least_depth(positions, source.surface));
        let mut indices = [0; 3];
        for ((index, &key), position) in indices.iter_mut().zip(corners).zip(positions) {
            *index = cache.index(key, position, source, &mut self.corners);
        }
        self.push_triangle(indices, rows, least, source);
        self.load.pixels += triangle::covered_px(positions, source.screen);
    }

    /// Clips a triangle that reaches far out of the picture, and makes ready the parts that are to be drawn.
    fn add_cut(&mut self, source: &Source<'_>, keys: &[u32]) {
        let vertex = |key: u32| {
            let vertex = source.mesh.vertices.get(key as usize)?;
            Some(ClipVertex {
                position: source.transform.clip(vertex.position),
                color: vertex_color(source.material, source.transform, vertex),
                uv: vertex.uv,
            })
        };
        let &[a, b, c] = keys else { return };
        let (Some(a), Some(b), Some(c)) = (vertex(a), vertex(b), vertex(c)) else { return };
        triangle::cut([&a, &b, &c], source.surface, source.screen, |corners| {
            let first = self.corners.len() as u32;
            self.corners.extend_from_slice(corners);
            let positions = corners.each_ref().map(|corner| &corner.position);
            let (rows, least) = (triangle::rows(positions), triangle::least_depth(positions, source.surface));
            self.push_triangle([first, first + 1, first + 2], rows, least, source);
            self.load.pixels += triangle::covered_px(positions, source.screen);
        });
    }

    fn push_triangle(&mut self, corners: [u32; 3], rows: (i32, i32), least: f32, source: &Source<'_>) {
        bin_rows(&mut self.bins, self.triangles.len() as u32 * 2, rows, source.screen);
        self.triangles.push(Triangle { corners, solid: source.index });
        self.load.faces += 1;
        self.least.push(least);
    }

    fn add_line(&mut self, a: ClipVertex, b: ClipVertex, mode: Mode, screen: &Screen) {
        if let Some(line) = line::set_up(a, b, mode, screen) {
            bin_rows(&mut self.bins, self.lines.len() as u32 * 2 + 1, line.rows(), screen);
            self.lines.push(line);
        }
    }

    /// Draws a band's rows of the triangles of several jobs that need not be drawn in their order.
    pub(in crate::cpu) fn draw_ranked(
        jobs: &[&Self],
        solids: &[Solid<'_>],
        index: usize,
        order: &mut NearToFar,
        band: &mut Band<'_>,
    ) {
        let lists: Vec<&[u32]> = jobs.iter().map(|job| job.bins.band(index)).collect();
        let least = |job: usize, number: u32| jobs.get(job).and_then(|job| job.least.get(number as usize / 2)).copied();
        let count = order.sort(&lists, |job, number| least(job, number).unwrap_or(f32::INFINITY));
        match band.begin_ranks(count) {
            Some(first) => {
                for face in order.faces(&lists) {
                    if let Some(job) = jobs.get(face.job) {
                        band.set_rank(first + face.rank);
                        job.draw_one(solids, face.number, band);
                    }
                }
            }
            None => jobs.iter().for_each(|job| job.draw(solids, index, band)),
        }
        band.end_ranks();
    }

    /// Draws the rows of a band.
    pub(in crate::cpu) fn draw(&self, solids: &[Solid<'_>], index: usize, band: &mut Band<'_>) {
        self.bins.band(index).iter().for_each(|&number| self.draw_one(solids, number, band));
    }

    #[inline]
    fn draw_one(&self, solids: &[Solid<'_>], number: u32, band: &mut Band<'_>) {
        let at = (number / 2) as usize;
        if number & 1 == 1 {
            if let Some(line) = self.lines.get(at) {
                line.draw(band);
            }
        } else if let Some(triangle) = self.triangles.get(at) {
            if let Some(solid) = solids.get(triangle.solid as usize) {
                let corners = triangle.corners.map(|index| &self.corners[index as usize]);
                triangle::draw(corners, &solid.surface, band);
            }
        }
    }
}

fn bin_rows(bins: &mut Bins, number: u32, (begin, end): (i32, i32), screen: &Screen) {
    let row = |row: i32| row.clamp(0, screen.height_px as i32) as u32;
    bins.add(number, row(begin), row(end));
}

/// The last transformed vertices, so that a vertex that neighbouring triangles share is computed once.
#[derive(Debug)]
pub(in crate::cpu) struct VertexCache {
    entries: [CachedVertex; Self::SIZE],
}

#[derive(Clone, Copy, Debug)]
struct CachedVertex {
    /// Its index in the mesh.
    key: Option<u32>,
    /// Its index among the corners: it is one, with its colour, from the first triangle on that may be seen. Of a
    /// detailed mesh most vertices never are.
    index: Option<u32>,
    outside: Outside,
    position: ScreenPosition,
}

impl Default for VertexCache {
    fn default() -> Self {
        let (outside, position) = (Outside::default(), ScreenPosition::default());
        Self { entries: [CachedVertex { key: None, index: None, outside, position }; Self::SIZE] }
    }
}

impl VertexCache {
    const SIZE: usize = 256;

    fn clear(&mut self) {
        self.entries.iter_mut().for_each(|entry| entry.key = None);
    }

    /// Position of a vertex, if the mesh has it.
    #[inline]
    fn place(&mut self, key: u32, source: &Source<'_>) -> Option<(ScreenPosition, Outside)> {
        let entry = &mut self.entries[key as usize % Self::SIZE];
        if entry.key != Some(key) {
            let position = source.transform.clip(source.mesh.vertices.get(key as usize)?.position);
            let outside = Outside::new(position);
            let position = ScreenPosition::new(position, source.screen);
            *entry = CachedVertex { key: Some(key), index: None, outside, position };
        }
        Some((entry.position, entry.outside))
    }

    /// The index of a vertex among the corners, given where it is.
    #[inline]
    fn index(&mut self, key: u32, position: &ScreenPosition, source: &Source<'_>, corners: &mut Vec<Corner>) -> u32 {
        let entry = &mut self.entries[key as usize % Self::SIZE];
        // Another vertex of the same triangle may have taken its place.
        let is_there = entry.key == Some(key);
        if let Some(index) = entry.index.filter(|_| is_there) {
            return index;
        }
        let index = corners.len() as u32;
        let corner = source.mesh.vertices.get(key as usize).map_or_else(Corner::default, |vertex| {
            let color = vertex_color(source.material, source.transform, vertex);
            Corner { position: *position, color, uv: vertex.uv }
        });
        corners.push(corner);
        if is_there {
            entry.index = Some(index);
        }
        index
    }
}
