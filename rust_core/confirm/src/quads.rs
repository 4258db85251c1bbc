//! Quads between neighbouring pixels of a depth image, drawn into two depth buffers: surfaces and side walls.

use fearless_simd::{dispatch, Level};

use crate::projected::{jump_m, Projected};

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
    /// Surface of at most 2×2 cells, or of none: as most quads are.
    #[default]
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
    row: QuadRow,
}

/// The quads between two rows of the depth image.
#[derive(Debug, Default)]
struct QuadRow {
    /// First and last column and row whose centres are in the bounding box, clipped.
    left: Vec<i32>,
    right: Vec<i32>,
    top: Vec<i32>,
    bottom: Vec<i32>,
    /// Depth: the mean one of a surface with the code of its angle, the farthest one of a side wall.
    depth: Vec<u32>,
    kind: Vec<QuadKind>,
}

impl QuadRow {
    fn resize(&mut self, count: usize) {
        for plane in [&mut self.left, &mut self.right, &mut self.top, &mut self.bottom] {
            plane.resize(count, 0);
        }
        self.depth.resize(count, 0);
        self.kind.resize(count, QuadKind::Tiny);
    }
}

/// The corners of the quads below a row, in one plane of the points: above left and right, below left and right. Of
/// equal lengths, so that loops over them need no checks.
#[inline(always)]
fn corners(plane: &[f32], y: usize, width: usize) -> [&[f32]; 4] {
    let count = width - 1;
    let begin = y * width;
    [begin, begin + 1, begin + width, begin + width + 1].map(|begin| &plane[begin..begin + count])
}

/// First cell whose centre is not before a place.
#[inline(always)]
#[expect(clippy::manual_clamp, reason = "NaN becomes 0")]
fn first(least: f32) -> i32 {
    (least - 0.5).max(0.0).min(FARTHEST_CELL).ceil() as i32
}

/// Last cell whose centre is not behind a place, among `count`.
#[inline(always)]
fn last(most: f32, count: f32) -> i32 {
    (most - 0.5).max(-1.0).min(count - 1.0).floor() as i32
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

    /// Draws the quads between row `y` and the next one. `codes` are those of the points' angles.
    pub(crate) fn draw(&mut self, points: &Projected, y: usize, codes: &[u32]) {
        let Some(count) = points.width.checked_sub(1) else { return };
        self.row.resize(count);
        let size = self.size;
        dispatch!(Level::new(), _simd => self.row.place(points, y, codes, size));
        let (row, surfaces) = (&self.row, &mut self.surfaces[..]);
        let columns = row.left.iter().zip(&row.right);
        let rows = row.top.iter().zip(&row.bottom);
        for (((columns, rows), depth), kind) in columns.zip(rows).zip(&row.depth).zip(&row.kind) {
            if *kind != QuadKind::Tiny {
                continue;
            }
            let (left, right) = (*columns.0 as usize, *columns.1 as usize);
            let (top, bottom) = (*rows.0 as usize * size[0], *rows.1 as usize * size[0]);
            // Some are the same. All are read before the first is written, so that none waits for another.
            let cells = [top + left, top + right, bottom + left, bottom + right];
            let depths = cells.map(|cell| surfaces[cell].min(*depth));
            for (cell, depth) in cells.into_iter().zip(depths) {
                surfaces[cell] = depth;
            }
        }
        for i in 0..count {
            if self.row.kind[i] != QuadKind::Tiny {
                self.draw_other(points, y, i, codes);
            }
        }
    }

    /// Draws a quad that is not tiny.
    fn draw_other(&mut self, points: &Projected, y: usize, i: usize, codes: &[u32]) {
        let is_wall = self.row.kind[i] == QuadKind::Wall;
        if is_wall {
            self.draw_edge_points(points, y, i, codes);
        }
        let (left, right, top, bottom) = (self.row.left[i], self.row.right[i], self.row.top[i], self.row.bottom[i]);
        if left > right || top > bottom {
            return;
        }
        if right - left > SMALL || bottom - top > SMALL {
            self.draw_large(points, y, i, codes);
            return;
        }
        let cells = if is_wall { &mut self.walls } else { &mut self.surfaces };
        let depth = self.row.depth[i];
        for y in top..=bottom {
            let begin = y as usize * self.size[0];
            for cell in &mut cells[begin + left as usize..=begin + right as usize] {
                *cell = depth.min(*cell);
            }
        }
    }

    /// Draws the measured points of a quad that jumps.
    fn draw_edge_points(&mut self, points: &Projected, y: usize, i: usize, codes: &[u32]) {
        let begin = y * points.width + i;
        for (column, index) in [(0, begin), (1, begin + 1), (0, begin + points.width), (1, begin + points.width + 1)] {
            let (u, v) = (points.u[index], points.v[index]);
            let is_inside = u >= 0.0 && v >= 0.0 && (u as usize) < self.size[0] && (v as usize) < self.size[1];
            if points.z[index] > 0.0 && is_inside {
                let depth = (1.0 / points.w[index]).to_bits() & DEPTH_BITS | codes[i + column];
                let cell = &mut self.surfaces[v as usize * self.size[0] + u as usize];
                *cell = depth.min(*cell);
            }
        }
    }

    /// Draws a quad as two triangles.
    fn draw_large(&mut self, points: &Projected, y: usize, i: usize, codes: &[u32]) {
        let begin = y * points.width + i;
        let corner = |index: usize| [points.u[index], points.v[index], points.w[index]];
        let [a, b, c, d] = [begin, begin + 1, begin + points.width, begin + points.width + 1].map(corner);
        let is_wall = self.row.kind[i] == QuadKind::Wall;
        let cells = if is_wall { &mut self.walls } else { &mut self.surfaces };
        let code = if is_wall { None } else { Some(codes[i]) };
        let box_of = [self.row.left[i], self.row.right[i], self.row.top[i], self.row.bottom[i]];
        for triangle in [[a, b, c], [d, c, b]] {
            draw_triangle(&triangle, box_of, |column, row, w| {
                let depth = (1.0 / w).to_bits();
                let depth = code.map_or(depth, |code| depth & DEPTH_BITS | code);
                let cell = &mut cells[row * self.size[0] + column];
                *cell = depth.min(*cell);
            });
        }
    }
}

/// Calls `write` with the column, row and inverse depth of each cell in a box whose centre is in a triangle.
fn draw_triangle(
    [a, b, c]: &[[f32; 3]; 3],
    [left, right, top, bottom]: [i32; 4],
    mut write: impl FnMut(usize, usize, f32),
) {
    let edge = |from: &[f32; 3], to: &[f32; 3], x: f32, y: f32| {
        (to[0] - from[0]) * (y - from[1]) - (to[1] - from[1]) * (x - from[0])
    };
    let area = edge(a, b, c[0], c[1]);
    if area == 0.0 || !area.is_finite() {
        return;
    }
    for row in top..=bottom {
        for column in left..=right {
            let (x, y) = (column as f32 + 0.5, row as f32 + 0.5);
            let shares = [edge(b, c, x, y), edge(c, a, x, y), edge(a, b, x, y)].map(|share| share / area);
            if shares.iter().all(|share| *share >= 0.0) {
                write(column as usize, row as usize, shares[0] * a[2] + shares[1] * b[2] + shares[2] * c[2]);
            }
        }
    }
}

impl QuadRow {
    /// Finds the boxes, depths and kinds of the quads below row `y`.
    #[inline(always)]
    fn place(&mut self, points: &Projected, y: usize, codes: &[u32], [columns, rows]: [usize; 2]) {
        let (width, count) = (points.width, self.depth.len());
        let [u0, u1, u2, u3] = corners(&points.u, y, width).map(|plane| &plane[..count]);
        let [v0, v1, v2, v3] = corners(&points.v, y, width).map(|plane| &plane[..count]);
        let [w0, w1, w2, w3] = corners(&points.w, y, width).map(|plane| &plane[..count]);
        let [z0, z1, z2, z3] = corners(&points.z, y, width).map(|plane| &plane[..count]);
        let (last_column, last_row) = (columns as f32, rows as f32);
        let codes = &codes[..count];
        let (left, right) = (&mut self.left[..count], &mut self.right[..count]);
        let (top, bottom) = (&mut self.top[..count], &mut self.bottom[..count]);
        let (depth, kind) = (&mut self.depth[..count], &mut self.kind[..count]);
        for i in 0..count {
            let (u, v) = ([u0[i], u1[i], u2[i], u3[i]], [v0[i], v1[i], v2[i], v3[i]]);
            let (w, z) = ([w0[i], w1[i], w2[i], w3[i]], [z0[i], z1[i], z2[i], z3[i]]);
            let sum = w[0] + w[1] + w[2] + w[3];
            // Not where a corner is missing: its NaN is in the sum.
            let is_whole = sum > 0.0;
            let (z_least, z_most) = (least(z), most(z));
            let jumps = z_least < 0.0 || z_most - z_least > jump_m(z_least);
            let across = [first(least(u)), if is_whole { last(most(u), last_column) } else { -1 }];
            let down = [first(least(v)), last(most(v), last_row)];
            let surface = (4.0 / sum).to_bits() & DEPTH_BITS | codes[i];
            let wall = (1.0 / least(w)).to_bits();
            // Of an incomplete quad only the points are drawn.
            let is_wall = jumps | !is_whole;
            let is_empty = (across[0] > across[1]) | (down[0] > down[1]);
            let is_tiny = (across[1] - across[0] <= 1) & (down[1] - down[0] <= 1) & !is_wall;
            // A tiny quad without cells writes nothing into the first one.
            let is_none = is_empty & !is_wall;
            depth[i] = if is_none {
                NOTHING
            } else if jumps {
                wall
            } else {
                surface
            };
            [left[i], right[i]] = if is_none { [0, 0] } else { across };
            [top[i], bottom[i]] = if is_none { [0, 0] } else { down };
            let of_surface = if is_tiny | is_none { QuadKind::Tiny } else { QuadKind::Surface };
            kind[i] = if is_wall { QuadKind::Wall } else { of_surface };
        }
    }
}
