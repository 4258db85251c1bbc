//! Quads between neighbouring pixels of a depth image, drawn into two depth buffers: surfaces and side walls.

use crate::projected::{chunk, jump_m, Chunk, Projected, CHUNK};

/// Value of a cell that nothing covers.
pub(crate) const NOTHING: u32 = f32::INFINITY.to_bits();

/// Bits of a surface's depth; the others are the code of its angle. What they lose is less than a tenth of a
/// millimetre at 2 m.
const DEPTH_BITS: u32 = !0xff;

/// A column or row that no image has.
const FARTHEST_CELL: f32 = 4e4;

/// Largest distance of the last from the first column or row of a quad that covers its bounding box.
const SMALL: i32 = 3;

/// How a quad is drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum QuadKind {
    /// Not at all: no cell has its centre in it.
    #[default]
    Empty,
    /// Surface of at most 2×2 cells, as most are.
    Tiny,
    /// Larger surface.
    Surface,
    /// Side wall, or points without a surface.
    Wall,
}

/// The depth buffers. The bits of positive numbers are ordered like the numbers.
#[derive(Debug, Default)]
pub(crate) struct Quads {
    size: [usize; 2],
    surfaces: Vec<u32>,
    walls: Vec<u32>,
    placed: PlacedQuads,
}

/// [`CHUNK`] quads between two rows of the depth image.
#[derive(Debug, Default)]
struct PlacedQuads {
    /// First and last column and row whose centres are in the bounding box, clipped.
    left: [i32; CHUNK],
    right: [i32; CHUNK],
    top: [i32; CHUNK],
    bottom: [i32; CHUNK],
    /// Depth: the mean one of a surface with the code of its angle, the farthest one of a side wall.
    depth: [u32; CHUNK],
    kind: [QuadKind; CHUNK],
}

/// The corners of quads in one plane of the points: above left and right, below left and right.
#[inline(always)]
fn corners(plane: &[f32], begin: usize, stride: usize) -> [&Chunk; 4] {
    [begin, begin + 1, begin + stride, begin + stride + 1].map(|begin| chunk(plane, begin))
}

/// First cell whose centre is not before a place.
#[inline(always)]
#[expect(clippy::manual_clamp, reason = "NaN becomes 0")]
fn first(least: f32) -> i32 {
    integer((least - 0.5).max(0.0).min(FARTHEST_CELL).ceil())
}

/// Last cell whose centre is not behind a place, among `count`.
#[inline(always)]
fn last(most: f32, count: f32) -> i32 {
    integer((most - 0.5).max(-1.0).min(count - 1.0).floor())
}

/// The value of a whole number of at most 4 million. The checks of `as` would keep the compiler from using SIMD.
#[inline(always)]
fn integer(whole: f32) -> i32 {
    // Where floats are all whole numbers, their bits count them.
    const BASE: f32 = 12_582_912.0;
    (whole + BASE).to_bits().wrapping_sub(BASE.to_bits()) as i32
}

#[inline(always)]
fn least([a, b, c, d]: [f32; 4]) -> f32 {
    let min = |a: f32, b: f32| if a < b { a } else { b };
    min(min(a, b), min(c, d))
}

#[inline(always)]
fn most([a, b, c, d]: [f32; 4]) -> f32 {
    let max = |a: f32, b: f32| if a > b { a } else { b };
    max(max(a, b), max(c, d))
}

impl Quads {
    /// Empties the buffers for this number of columns and rows of cells.
    pub(crate) fn reset(&mut self, size: [usize; 2]) {
        self.size = size;
        for cells in [&mut self.surfaces, &mut self.walls] {
            cells.clear();
            cells.resize(size[0] * size[1], NOTHING);
        }
    }

    /// Depths of the nearest surfaces, with the codes of their angles in the lowest 8 bits.
    pub(crate) fn surfaces(&self) -> &[u32] {
        &self.surfaces
    }

    /// Depths of the nearest side walls.
    pub(crate) fn walls(&self) -> &[u32] {
        &self.walls
    }

    /// Draws [`CHUNK`] quads whose upper left points begin at an index of the planes. `codes` are those of the points'
    /// angles.
    #[inline(always)]
    pub(crate) fn draw(&mut self, points: &Projected, begin: usize, codes: &[u32; CHUNK]) {
        self.placed = PlacedQuads::new(points, begin, codes, self.size);
        let (placed, surfaces, columns) = (&self.placed, &mut self.surfaces[..], self.size[0]);
        for i in 0..CHUNK {
            if placed.kind[i] != QuadKind::Tiny {
                continue;
            }
            let (left, right) = (placed.left[i] as usize, placed.right[i] as usize);
            let (top, bottom) = (placed.top[i] as usize * columns, placed.bottom[i] as usize * columns);
            // Some are the same. All are read before the first is written, so that none waits for another.
            let cells = [top + left, top + right, bottom + left, bottom + right];
            let depths = cells.map(|cell| surfaces[cell].min(placed.depth[i]));
            for (cell, depth) in cells.into_iter().zip(depths) {
                surfaces[cell] = depth;
            }
        }
        for (i, code) in codes.iter().enumerate() {
            if matches!(self.placed.kind[i], QuadKind::Surface | QuadKind::Wall) {
                self.draw_other(points, begin, i, *code);
            }
        }
    }

    /// Draws a quad that is not tiny.
    #[inline(always)]
    fn draw_other(&mut self, points: &Projected, begin: usize, i: usize, code: u32) {
        let is_wall = self.placed.kind[i] == QuadKind::Wall;
        if is_wall {
            let has_drawn_left = i > 0 && self.placed.kind[i - 1] == QuadKind::Wall;
            self.draw_edge_points(points, begin + i, code, has_drawn_left);
        }
        let PlacedQuads { left, right, top, bottom, .. } = &self.placed;
        let (left, right, top, bottom) = (left[i], right[i], top[i], bottom[i]);
        if left > right || top > bottom {
            return;
        }
        if right - left > SMALL || bottom - top > SMALL {
            self.draw_large(points, begin, i, code);
            return;
        }
        let cells = if is_wall { &mut self.walls } else { &mut self.surfaces };
        let depth = self.placed.depth[i];
        for y in top..=bottom {
            let begin = y as usize * self.size[0];
            for cell in &mut cells[begin + left as usize..=begin + right as usize] {
                *cell = depth.min(*cell);
            }
        }
    }

    /// Draws the measured points of a quad that jumps; only the right ones if its left neighbour has drawn the others.
    fn draw_edge_points(&mut self, points: &Projected, begin: usize, code: u32, has_drawn_left: bool) {
        let corners = [begin + 1, begin + points.stride + 1, begin, begin + points.stride];
        for index in corners.into_iter().take(if has_drawn_left { 2 } else { 4 }) {
            let (u, v) = (points.u[index], points.v[index]);
            let is_inside = u >= 0.0 && v >= 0.0 && (u as usize) < self.size[0] && (v as usize) < self.size[1];
            if points.z[index] > 0.0 && is_inside {
                let depth = (1.0 / points.w[index]).to_bits() & DEPTH_BITS | code;
                let cell = &mut self.surfaces[v as usize * self.size[0] + u as usize];
                *cell = depth.min(*cell);
            }
        }
    }

    /// Draws quad `i` as two triangles.
    #[inline(always)]
    fn draw_large(&mut self, points: &Projected, begin: usize, i: usize, code: u32) {
        let corner = |index: usize| [points.u[begin + index], points.v[begin + index], points.w[begin + index]];
        let (a, b) = (corner(i), corner(i + 1));
        let (c, d) = (corner(i + points.stride), corner(i + points.stride + 1));
        let PlacedQuads { left, right, top, bottom, kind, .. } = &self.placed;
        let is_wall = kind[i] == QuadKind::Wall;
        let (cells, bits, code) =
            if is_wall { (&mut self.walls, !0, 0) } else { (&mut self.surfaces, DEPTH_BITS, code) };
        for triangle in [[a, b, c], [d, c, b]] {
            let Some(triangle) = Triangle::new(triangle) else { continue };
            for row in top[i]..=bottom[i] {
                let begin = row as usize * self.size[0];
                let cells = &mut cells[begin + left[i] as usize..=begin + right[i] as usize];
                triangle.draw_row(row, left[i], cells, |depth| depth & bits | code);
            }
        }
    }
}

/// Triangle of places and inverse depths.
struct Triangle {
    /// First place and direction of the edges, each opposite to a corner. The inside is on their positive side.
    edges: [[[f32; 2]; 2]; 3],
    inverse_depths: [f32; 3],
    area: f32,
}

impl Triangle {
    /// `None` without an area.
    #[inline(always)]
    fn new([a, b, c]: [[f32; 3]; 3]) -> Option<Self> {
        let area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        if area == 0.0 || !area.is_finite() {
            return None;
        }
        let edges = if area > 0.0 { [(b, c), (c, a), (a, b)] } else { [(c, b), (a, c), (b, a)] };
        let edges = edges.map(
            #[inline(always)]
            |(from, to)| [[from[0], from[1]], [to[0] - from[0], to[1] - from[1]]],
        );
        Some(Self { edges, inverse_depths: [a[2], b[2], c[2]], area: area.abs() })
    }

    /// Draws the depths of the cells of a row whose centres are inside, from a column on, for which the compiler uses
    /// SIMD. `encode` makes a cell's value of a depth's bits.
    #[inline(always)]
    fn draw_row(&self, row: i32, first: i32, cells: &mut [u32], encode: impl Fn(u32) -> u32) {
        let y = row as f32 + 0.5;
        let [a, b, c] = &self.edges;
        let along = |[from, step]: &[[f32; 2]; 2]| step[0] * (y - from[1]);
        let (along_a, along_b, along_c) = (along(a), along(b), along(c));
        let inside = |along: f32, [from, step]: &[[f32; 2]; 2], x: f32| along - step[1] * (x - from[0]);
        let [w_a, w_b, w_c] = self.inverse_depths;
        for (column, cell) in (first..).zip(cells) {
            let x = column as f32 + 0.5;
            let (of_a, of_b, of_c) = (inside(along_a, a, x), inside(along_b, b, x), inside(along_c, c, x));
            let w = (of_a * w_a + of_b * w_b + of_c * w_c) / self.area;
            let depth = encode((1.0 / w).to_bits()).min(*cell);
            *cell = if (of_a >= 0.0) & (of_b >= 0.0) & (of_c >= 0.0) { depth } else { *cell };
        }
    }
}

impl PlacedQuads {
    /// Finds the boxes, depths and kinds of the quads whose upper left points begin at an index of the planes.
    #[inline(always)]
    fn new(points: &Projected, begin: usize, codes: &[u32; CHUNK], [columns, rows]: [usize; 2]) -> Self {
        let mut placed = Self::default();
        let [u0, u1, u2, u3] = corners(&points.u, begin, points.stride);
        let [v0, v1, v2, v3] = corners(&points.v, begin, points.stride);
        let [w0, w1, w2, w3] = corners(&points.w, begin, points.stride);
        let [z0, z1, z2, z3] = corners(&points.z, begin, points.stride);
        let (last_column, last_row) = (columns as f32, rows as f32);
        for i in 0..CHUNK {
            let (u, v) = ([u0[i], u1[i], u2[i], u3[i]], [v0[i], v1[i], v2[i], v3[i]]);
            let (w, z) = ([w0[i], w1[i], w2[i], w3[i]], [z0[i], z1[i], z2[i], z3[i]]);
            let sum = w[0] + w[1] + w[2] + w[3];
            // Not where a corner is missing: its NaN is in the sum.
            let is_whole = sum > 0.0;
            let (z_least, z_most) = (least(z), most(z));
            let jumps = z_least < 0.0 || z_most - z_least > jump_m(z_least);
            [placed.left[i], placed.right[i]] =
                [first(least(u)), if is_whole { last(most(u), last_column) } else { -1 }];
            [placed.top[i], placed.bottom[i]] = [first(least(v)), last(most(v), last_row)];
            let (width, height) = (placed.right[i] - placed.left[i], placed.bottom[i] - placed.top[i]);
            let surface = (4.0 / sum).to_bits() & DEPTH_BITS | codes[i];
            let wall = (1.0 / least(w)).to_bits();
            placed.depth[i] = if jumps { wall } else { surface };
            let of_surface = if (width <= 1) & (height <= 1) { QuadKind::Tiny } else { QuadKind::Surface };
            let of_whole = if (width < 0) | (height < 0) { QuadKind::Empty } else { of_surface };
            // Of an incomplete quad only the points are drawn.
            placed.kind[i] = if jumps | !is_whole { QuadKind::Wall } else { of_whole };
        }
        placed
    }
}
