//! The corners of many things: transformed and lit one by one where they are asked for, or a solid's all at once.

use fearless_simd::prelude::*;
use rcs_scene::{Material, Mesh, Text, Vertex};

use super::shape::Shape;
use crate::cpu::geometry::lighting::vertex_color;
use crate::cpu::paint::Surface;
use crate::cpu::raster::clip::Outside;
use crate::cpu::raster::triangle::Corner;
use crate::cpu::tile::lanes::{load, map, store_whole, transform, whole, F, LANES};
use crate::cpu::tile::screen::{ObjectTransform, Screen, ScreenPosition, SUBPIXELS};

/// CornerSource of the corners of a thing's triangles.
pub(in crate::cpu) struct CornerSource<'a> {
    pub(in crate::cpu) vertices: Vertices<'a>,
    pub(in crate::cpu) material: &'a Material,
    pub(in crate::cpu) transform: &'a ObjectTransform,
    pub(in crate::cpu) surface: &'a Surface,
}

pub(in crate::cpu) enum Vertices<'a> {
    Mesh(&'a Mesh),
    Text(&'a Text),
}

impl CornerSource<'_> {
    pub(in crate::cpu) fn vertex(&self, key: u32) -> Option<Vertex> {
        match &self.vertices {
            Vertices::Mesh(mesh) => mesh.vertices.get(key as usize).copied(),
            Vertices::Text(text) => {
                let glyph = text.glyphs().get(key as usize / 4)?;
                text.quad(glyph).get(key as usize % 4).copied()
            }
        }
    }

    pub(in crate::cpu) fn color(&self, vertex: &Vertex) -> [f32; 4] {
        vertex_color(self.material, self.transform, vertex)
    }
}

/// The memory of a thread that makes things ready and draws them.
#[derive(Debug, Default)]
pub(in crate::cpu) struct InstanceScratch {
    /// The snapped places of a solid's corners, and the gaps between pixel centres that they are in.
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
    pub(in crate::cpu) fn begin(&mut self) {
        self.corners.resize(Self::MAX_CORNERS, CachedCorner::default());
        self.generation += 1;
    }

    /// A snapped place of the solid whose vertices were placed.
    #[inline]
    pub(in crate::cpu) fn place_of(&self, place: u32) -> [i32; 2] {
        [&self.x, &self.y].map(|all| all.get(place as usize).copied().unwrap_or_default())
    }

    /// The gaps that a place of the solid is in, whose vertices were placed.
    #[inline]
    pub(in crate::cpu) fn gap_of(&self, place: u32) -> i32 {
        self.gaps.get(place as usize).copied().unwrap_or_default()
    }

    /// A corner; without its colour unless `light`.
    #[inline]
    pub(in crate::cpu) fn corner(
        &mut self,
        key: u32,
        source: &CornerSource<'_>,
        screen: &Screen,
        light: bool,
    ) -> Option<(Corner, Outside)> {
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

/// Places the vertices of a solid inside the view: their snapped places, and for each the gaps between the columns and
/// the rows of pixel centres that it is in, each as an odd number (an even one is a centre), packed into one.
#[inline(always)]
pub(in crate::cpu) fn place_vertices<S: Simd>(
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
