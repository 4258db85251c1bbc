//! Meshes, lines, ribbons and text up to their pixels: everything that is made of triangles and lines.
//!
//! Their primitives are transformed, lit, clipped and made ready in the order in which they are to be drawn; then they
//! are sorted into the bands of the image by reference.

use std::borrow::Cow;
use std::ops::Range;

use rcs_scene::{Lines, Material, Mesh, Text};

use super::vertices::{joined, InView, Source, VertexCache, VertexScratch};
use crate::cpu::paint::Surface;
use crate::cpu::raster::clip::ClipVertex;
use crate::cpu::raster::line::{self, Line};
use crate::cpu::raster::triangle::{self, Corner};
use crate::cpu::tile::band::{Band, Mode};
use crate::cpu::tile::bins::Bins;
use crate::cpu::tile::near_to_far::{Load, NearToFar};
use crate::cpu::tile::screen::{ObjectTransform, Screen, ScreenPosition};

/// Something made of triangles or lines.
#[derive(Debug)]
pub(in crate::cpu) struct Solid<'a> {
    /// From its frame to the image.
    pub transform: ObjectTransform,
    /// How it is painted.
    pub surface: Surface,
    /// Its triangles or lines.
    pub shape: Shape<'a>,
}

/// The triangles, glyphs or lines of a [`Solid`].
#[derive(Debug)]
pub(in crate::cpu) enum Shape<'a> {
    /// Triangles with a material.
    Mesh(Cow<'a, Mesh>, Cow<'a, Material>),
    /// Two triangles for each glyph.
    Text(&'a Text),
    /// Lines of a pixel.
    Lines(&'a Lines),
}

impl Shape<'_> {
    /// The number of its triangles, glyphs or lines.
    pub(in crate::cpu) fn primitive_count(&self) -> usize {
        match self {
            Self::Mesh(mesh, _) => mesh.indices.len() / 3,
            Self::Text(text) => text.glyphs().len(),
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

/// The kind of a primitive: the rest of its number in the bins, which is its index times [`KINDS`] and the kind.
const TRIANGLE: u32 = 0;
const LINE: u32 = 1;
const GLYPH: u32 = 2;
const KINDS: u32 = 3;

/// Primitives that are ready to be drawn.
#[derive(Debug, Default)]
pub(in crate::cpu) struct Primitives {
    /// Corners of triangles that may be seen, which share them.
    corners: Vec<Corner>,
    triangles: Vec<Triangle>,
    /// A depth that no fragment of a triangle is nearer than.
    least: Vec<f32>,
    lines: Vec<Line>,
    /// The solid and the glyph of it. Their corners are found again in each band: very many would take much memory.
    glyphs: Vec<[u32; 2]>,
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
        self.glyphs.clear();
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
        let Solid { transform, surface, shape } = solid;
        self.load.in_order |= surface.mode != Mode::OPAQUE;
        cache.clear();
        match shape {
            Shape::Mesh(mesh, material) => {
                let source = Source { vertices: &mesh.vertices, material, transform, surface, screen };
                let corners = mesh.indices.get(range.start * 3..range.end * 3).unwrap_or(&[]);
                corners.as_chunks().0.iter().for_each(|keys| self.add_triangle(&source, index, *keys, cache));
            }
            Shape::Text(text) => {
                for (at, glyph) in range.clone().zip(text.glyphs().get(range).unwrap_or(&[])) {
                    let (vertices, material) = (&text.quad(glyph), text.material());
                    let source = Source { vertices, material, transform, surface, screen };
                    cache.clear();
                    let [one, other] = glyph_triangles().map(|keys| source.rows(keys, cache));
                    if let Some(rows) = joined(one, other) {
                        self.bins.add_rows(self.glyphs.len() as u32 * KINDS + GLYPH, rows);
                        self.glyphs.push([index, at as u32]);
                    }
                }
            }
            Shape::Lines(lines) => {
                self.load.in_order = true;
                for (a, b) in lines.segments(range) {
                    let vertex = |i: usize| {
                        Some(ClipVertex {
                            position: transform.clip(*lines.positions.get(i)?),
                            color: lines.color(i).map(|c| f32::from(c) / 255.0),
                            uv: [0.0; 2],
                        })
                    };
                    if let (Some(a), Some(b)) = (vertex(a), vertex(b)) {
                        self.add_line(a, b, surface.mode, screen);
                    }
                }
            }
        }
    }

    /// Makes the parts of a triangle ready that may be seen.
    #[inline]
    fn add_triangle(&mut self, source: &Source<'_>, solid: u32, keys: [u32; 3], cache: &mut VertexCache) {
        match source.look(keys, cache) {
            InView::Nothing => {}
            InView::Whole(positions) => {
                let corners = cache.indices(keys, &positions, source, &mut self.corners);
                self.push_triangle(Triangle { corners, solid }, positions.each_ref(), source);
            }
            InView::Crossing => source.cut(keys, |corners| {
                let first = self.corners.len() as u32;
                self.corners.extend_from_slice(corners);
                let triangle = Triangle { corners: [first, first + 1, first + 2], solid };
                self.push_triangle(triangle, corners.each_ref().map(|corner| &corner.position), source);
            }),
        }
    }

    fn push_triangle(&mut self, triangle: Triangle, positions: [&ScreenPosition; 3], source: &Source<'_>) {
        self.bins.add_rows(self.triangles.len() as u32 * KINDS + TRIANGLE, triangle::rows(positions));
        self.triangles.push(triangle);
        self.least.push(triangle::least_depth(positions, source.surface));
        self.load.faces += 1;
        self.load.pixels += triangle::covered_px(positions, source.screen);
    }

    fn add_line(&mut self, a: ClipVertex, b: ClipVertex, mode: Mode, screen: &Screen) {
        if let Some(line) = line::set_up(a, b, mode, screen) {
            self.bins.add_rows(self.lines.len() as u32 * KINDS + LINE, line.rows);
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
        let least =
            |job: usize, number: u32| jobs.get(job).and_then(|job| job.least.get((number / KINDS) as usize)).copied();
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
            // In their order, which is right as well.
            None => {
                for job in jobs {
                    job.bins.band(index).iter().for_each(|&number| job.draw_one(solids, number, band));
                }
            }
        }
        band.end_ranks();
    }

    /// Draws the rows of a band.
    pub(in crate::cpu) fn draw(
        &self,
        solids: &[Solid<'_>],
        index: usize,
        screen: &Screen,
        scratch: &mut VertexScratch,
        band: &mut Band<'_>,
    ) {
        for &number in self.bins.band(index) {
            if number % KINDS == GLYPH {
                self.draw_glyph(solids, (number / KINDS) as usize, screen, scratch, band);
            } else {
                self.draw_one(solids, number, band);
            }
        }
    }

    fn draw_glyph(
        &self,
        solids: &[Solid<'_>],
        at: usize,
        screen: &Screen,
        scratch: &mut VertexScratch,
        band: &mut Band<'_>,
    ) {
        let Some(&[solid, glyph]) = self.glyphs.get(at) else { return };
        let Some(Solid { transform, surface, shape: Shape::Text(text) }) = solids.get(solid as usize) else { return };
        let Some(glyph) = text.glyphs().get(glyph as usize) else { return };
        let (vertices, material) = (&text.quad(glyph), text.material());
        let source = Source { vertices, material, transform, surface, screen };
        scratch.clear();
        source.draw_pair(glyph_triangles(), scratch, band);
    }

    /// Draws a triangle or a line.
    #[inline]
    fn draw_one(&self, solids: &[Solid<'_>], number: u32, band: &mut Band<'_>) {
        let at = (number / KINDS) as usize;
        if number % KINDS == LINE {
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

/// The corners of both triangles of a glyph.
fn glyph_triangles() -> [[u32; 3]; 2] {
    let [a, b, c, d, e, f] = Text::QUAD_INDICES.map(|corner| corner as u32);
    [[a, b, c], [d, e, f]]
}
