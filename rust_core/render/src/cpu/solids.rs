//! Meshes, lines, ribbons, text, before they are pixels: everything that is made of triangles and
//! lines.
//!
//! Their primitives are transformed, lit, clipped and made ready in the order in which they are to be drawn; then they
//! are sorted into the bands of the picture by reference.

use std::borrow::Cow;

use rcs_scene::{Lines, Material, Mesh};

use super::band::{Band, Mode};
use super::bins::{Bins, Rows};
use super::clip::{ClipVertex, Outside};
use super::lighting::vertex_color;
use super::lines::{self, Line};
use super::screen::{Placement, Screen};
use super::surface::Surface;
use super::triangles::{self, Spot, Triangle};

/// Something made of triangles or lines.
#[derive(Debug)]
pub(super) struct Solid<'a> {
    /// Where it stands.
    pub placement: Placement,
    /// What it looks like.
    pub surface: Surface,
    /// What it is.
    pub shape: Shape<'a>,
}

/// What a [`Solid`] is.
#[derive(Debug)]
pub(super) enum Shape<'a> {
    /// Triangles with a material.
    Mesh(Cow<'a, Mesh>, Cow<'a, Material>),
    /// Lines of a pixel.
    Lines(&'a Lines),
}

impl Shape<'_> {
    /// Of how many triangles or lines it consists.
    pub(super) fn parts(&self) -> usize {
        match self {
            Self::Mesh(mesh, _) => mesh.indices.len() / 3,
            Self::Lines(lines) => lines.segments().size_hint().0,
        }
    }
}

/// A triangle or a line in a band.
#[derive(Clone, Copy, Debug)]
struct Primitive {
    /// Twice its index, plus one for a line.
    id: u32,
    y0: u16,
    y1: u16,
}

impl Rows for Primitive {
    fn rows(&self) -> (i32, i32) {
        (i32::from(self.y0), i32::from(self.y1))
    }
}

/// Primitives that are ready to be drawn.
#[derive(Debug, Default)]
pub(super) struct Primitives {
    triangles: Vec<Triangle>,
    lines: Vec<Line>,
    staged: Vec<Primitive>,
    bins: Bins<Primitive>,
}

impl Primitives {
    /// Forgets everything.
    pub(super) fn clear(&mut self) {
        self.triangles.clear();
        self.lines.clear();
        self.staged.clear();
        self.bins.clear();
    }

    /// Makes parts of a solid ready. Solids are told apart by their index.
    pub(super) fn add(
        &mut self,
        solid: &Solid<'_>,
        index: u32,
        parts: std::ops::Range<usize>,
        screen: &Screen,
        cache: &mut VertexCache,
    ) {
        match &solid.shape {
            Shape::Mesh(mesh, material) => {
                cache.clear();
                let corners = mesh.indices.get(parts.start * 3..parts.end * 3).unwrap_or(&[]);
                for corners in corners.chunks_exact(3) {
                    self.add_corners(mesh, material, corners, solid, index, screen, cache);
                }
            }
            Shape::Lines(lines) => {
                for (a, b) in lines.segments().skip(parts.start).take(parts.len()) {
                    let vertex = |i: usize| {
                        Some(ClipVertex {
                            position: solid.placement.clip(*lines.positions.get(i)?),
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
    #[expect(clippy::too_many_arguments, reason = "the inner loop of one caller")]
    #[inline]
    fn add_corners(
        &mut self,
        mesh: &Mesh,
        material: &Material,
        corners: &[u32],
        solid: &Solid<'_>,
        index: u32,
        screen: &Screen,
        cache: &mut VertexCache,
    ) {
        let &[a, b, c] = corners else { return };
        let mut place = |corner| cache.place(corner, mesh, &solid.placement, screen);
        let (Some((spot_a, out_a)), Some((spot_b, out_b)), Some((spot_c, out_c))) = (place(a), place(b), place(c))
        else {
            return;
        };
        if out_a.view & out_b.view & out_c.view != 0 {
            return;
        }
        let is_whole = out_a.guard | out_b.guard | out_c.guard == 0;
        if is_whole && !triangles::may_be_seen([&spot_a, &spot_b, &spot_c], &solid.surface, screen) {
            return;
        }
        let mut lit = |corner| cache.lit(corner, mesh, material, &solid.placement, screen);
        let (Some(a), Some(b), Some(c)) = (lit(a), lit(b), lit(c)) else { return };
        if is_whole {
            let corners = [(spot_a, &a), (spot_b, &b), (spot_c, &c)];
            if let Some(triangle) = triangles::set_up_whole(corners, &solid.surface, index) {
                self.push(triangle, screen);
            }
        } else {
            self.add_triangle([&a, &b, &c], &solid.surface, index, screen);
        }
    }

    fn push(&mut self, triangle: Triangle, screen: &Screen) {
        stage(&mut self.staged, self.triangles.len() as u32 * 2, triangle.rows(), screen);
        self.triangles.push(triangle);
    }

    fn add_triangle(&mut self, corners: [&ClipVertex; 3], surface: &Surface, index: u32, screen: &Screen) {
        triangles::set_up(corners, surface, index, screen, |triangle| {
            let (begin, end) = triangle.rows();
            stage(&mut self.staged, self.triangles.len() as u32 * 2, (begin, end), screen);
            self.triangles.push(triangle);
        });
    }

    fn add_line(&mut self, a: ClipVertex, b: ClipVertex, mode: Mode, screen: &Screen) {
        if let Some(line) = lines::set_up(a, b, mode, screen) {
            stage(&mut self.staged, self.lines.len() as u32 * 2 + 1, line.rows(), screen);
            self.lines.push(line);
        }
    }

    /// Sorts what was added into the bands.
    pub(super) fn finish(&mut self, screen: &Screen) {
        self.bins.fill(screen, &self.staged);
    }

    /// Draws the rows of a band.
    pub(super) fn draw(&self, solids: &[Solid<'_>], index: usize, band: &mut Band<'_>) {
        for primitive in self.bins.band(index) {
            let at = (primitive.id / 2) as usize;
            if primitive.id & 1 == 1 {
                if let Some(line) = self.lines.get(at) {
                    line.draw(band);
                }
            } else if let Some(triangle) = self.triangles.get(at) {
                if let Some(solid) = solids.get(triangle.surface as usize) {
                    triangle.draw(&solid.surface, band);
                }
            }
        }
    }
}

fn stage(staged: &mut Vec<Primitive>, id: u32, (begin, end): (i32, i32), screen: &Screen) {
    let (y0, y1) = (begin.max(0), end.min(screen.height_px as i32));
    if y0 < y1 {
        staged.push(Primitive { id, y0: y0 as u16, y1: y1 as u16 });
    }
}

/// The last transformed vertices, so that a vertex that neighbouring triangles share is computed once. Light is computed
/// where a triangle is seen.
#[derive(Debug)]
pub(super) struct VertexCache {
    keys: [Option<u32>; Self::SIZE],
    vertices: Vec<CachedVertex>,
}

#[derive(Clone, Copy, Debug, Default)]
struct CachedVertex {
    /// Without its colour until `is_lit`.
    vertex: ClipVertex,
    is_lit: bool,
    spot: Spot,
    outside: Outside,
}

impl Default for VertexCache {
    fn default() -> Self {
        Self { keys: [None; Self::SIZE], vertices: vec![CachedVertex::default(); Self::SIZE] }
    }
}

impl VertexCache {
    const SIZE: usize = 256;

    fn clear(&mut self) {
        self.keys.fill(None);
    }

    #[inline]
    fn get(&mut self, key: u32, mesh: &Mesh, placement: &Placement, screen: &Screen) -> Option<&mut CachedVertex> {
        let slot = key as usize % Self::SIZE;
        if self.keys[slot] != Some(key) {
            let vertex = mesh.vertices.get(key as usize)?;
            let position = placement.clip(vertex.position);
            let vertex = ClipVertex { position, color: [0.0; 4], uv: vertex.uv };
            let (spot, outside) = (Spot::new(position, screen), Outside::new(&vertex));
            self.vertices[slot] = CachedVertex { vertex, is_lit: false, spot, outside };
            self.keys[slot] = Some(key);
        }
        Some(&mut self.vertices[slot])
    }

    /// Where a vertex is, if the mesh has it.
    #[inline]
    fn place(&mut self, key: u32, mesh: &Mesh, placement: &Placement, screen: &Screen) -> Option<(Spot, Outside)> {
        self.get(key, mesh, placement, screen).map(|cached| (cached.spot, cached.outside))
    }

    /// A vertex with its colour.
    #[inline]
    fn lit(
        &mut self,
        key: u32,
        mesh: &Mesh,
        material: &Material,
        placement: &Placement,
        screen: &Screen,
    ) -> Option<ClipVertex> {
        let cached = self.get(key, mesh, placement, screen)?;
        if !cached.is_lit {
            cached.vertex.color = vertex_color(material, placement, mesh.vertices.get(key as usize)?);
            cached.is_lit = true;
        }
        Some(cached.vertex)
    }
}
