//! The measured surface as seen from the projector: a depth buffer over the cells of the drawn image.
//!
//! ```text
//! points ─► projected, holes closed ─► quads between neighbours ─► nearest surface, nearest side wall ─► bounds
//! ```
//!
//! Four neighbouring pixels of the depth image are a quad: a measured surface, or a side wall where they jump. A quad
//! covers the cells whose centres it contains; one of a few cells, as most are, those in its bounding box. A measured
//! point at a jump covers its own cell, too, so that nothing thin is lost.
//!
//! Only light is compared with the surface, so a block of quads waits until there is light in a tile that it may cover.
//! The points are kept: light that moves between two depth images meets the surface there as well.

use fearless_simd::{dispatch, Level};
use nalgebra::Isometry3;
use rcs_scene::Intrinsics;

use crate::cells::cells_of;
use crate::grazing::{codes_of, widening, Directions};
use crate::projected::{cells_from_sensor, extremes, Projected, CHUNK};
use crate::quads::{Quads, NOTHING};
use crate::settings::TOLERANCE_PER_METRE;
use crate::tiles::{TileRange, Tiles};
use crate::PointGrid;

/// Rows of the depth image that share the angles of the first one.
const ROWS_PER_ANGLE: usize = 2;

/// Rows of quads in a block. A block has [`CHUNK`] columns.
const BLOCK_ROWS: usize = 8;

/// Depths at which an object in a cell is confirmed, metres along the optical axis; NaN where no surface was measured,
/// a side wall is before it, or nothing is drawn because there is no light.
#[derive(Debug, Default)]
pub(crate) struct Bounds {
    /// Nearest depth that agrees with the surface; what is nearer is gone.
    pub(crate) nearest: Vec<f32>,
    /// Farthest depth that agrees with the surface; what is farther is blocked by it.
    pub(crate) farthest: Vec<f32>,
}

impl Bounds {
    /// Makes room for the cells of an image, which are then written.
    pub(crate) fn fit(&mut self, [columns, rows]: [usize; 2]) {
        for bounds in [&mut self.nearest, &mut self.farthest] {
            bounds.resize(columns * rows, f32::NAN);
        }
    }
}

/// The surface of a depth image; keeps its memory.
#[derive(Debug, Default)]
pub(crate) struct Surface {
    /// Columns and rows of the drawn image's cells.
    size: [usize; 2],
    points: Projected,
    directions: Directions,
    quads: Quads,
    /// The blocks that are not drawn yet.
    waiting: Vec<Block>,
    /// `true` until the bounds are those of this depth image.
    is_new: bool,
}

/// Neighbouring quads: their first column and row, and the tiles that they may cover.
#[derive(Clone, Copy, Debug)]
struct Block {
    first: [usize; 2],
    tiles: TileRange,
}

impl Surface {
    /// Takes a depth image.
    pub(crate) fn take(&mut self, intrinsics: &Intrinsics, projector_from_sensor: &Isometry3<f64>, grid: &PointGrid) {
        self.size = cells_of([intrinsics.width_px, intrinsics.height_px]);
        self.points.take(grid, &cells_from_sensor(intrinsics, projector_from_sensor));
        self.directions = Directions::new(intrinsics);
        self.quads.reset(self.size);
        self.waiting.clear();
        dispatch!(Level::new(), _simd => self.find_blocks());
        self.is_new = true;
    }

    #[inline(always)]
    fn find_blocks(&mut self) {
        let [columns, rows] = [self.points.width, self.points.height].map(|points| points.saturating_sub(1));
        for y in (0..rows).step_by(BLOCK_ROWS) {
            for x in (0..columns).step_by(CHUNK) {
                let begins = (y..=(y + BLOCK_ROWS).min(rows)).map(|y| self.points.index(x, y));
                let [left, right] = extremes(&self.points.u, begins.clone());
                let [top, bottom] = extremes(&self.points.v, begins);
                let tiles = TileRange::between([left, top], [right, bottom]);
                self.waiting.push(Block { first: [x, y], tiles });
            }
        }
    }

    /// Draws what is still missing of the surface where there is light, and writes the bounds of all cells. Returns
    /// `false` if nothing was missing: the bounds are those of before.
    pub(crate) fn draw(&mut self, lit: &Tiles, tolerance_m: f64, bounds: &mut Bounds) -> bool {
        let Self { points, directions, quads, waiting, is_new, .. } = self;
        let count = waiting.len();
        waiting.retain(|block| {
            let is_lit = lit.meets(block.tiles);
            if is_lit {
                dispatch!(Level::new(), _simd => block.draw(points, *directions, quads));
            }
            !is_lit
        });
        if count == waiting.len() && !*is_new {
            return false;
        }
        *is_new = false;
        bounds.fit(self.size);
        dispatch!(Level::new(), _simd => write_bounds(&self.quads, tolerance_m as f32, bounds));
        true
    }
}

impl Block {
    #[inline(always)]
    fn draw(&self, points: &Projected, directions: Directions, quads: &mut Quads) {
        let [x, first] = self.first;
        let mut codes = [0; CHUNK];
        for y in first..(first + BLOCK_ROWS).min(points.height - 1) {
            if (y - first) % ROWS_PER_ANGLE == 0 {
                codes = codes_of(points, directions, [x, y]);
            }
            quads.draw(points, points.index(x, y), &codes);
        }
    }
}

#[inline(always)]
fn write_bounds(quads: &Quads, tolerance_m: f32, bounds: &mut Bounds) {
    let to = bounds.nearest.iter_mut().zip(&mut bounds.farthest);
    for ((surface, wall), (nearest, farthest)) in quads.surfaces().iter().zip(quads.walls()).zip(to) {
        let depth_m = f32::from_bits(surface & !0xff);
        let tolerance_m = (tolerance_m + TOLERANCE_PER_METRE * depth_m) * widening(surface & 0xff);
        // A wall at the surface's depth is the edge of that surface.
        let is_hidden = *surface == NOTHING || f32::from_bits(*wall) < depth_m - tolerance_m;
        *nearest = if is_hidden { f32::NAN } else { depth_m - tolerance_m };
        *farthest = if is_hidden { f32::NAN } else { depth_m + tolerance_m };
    }
}
