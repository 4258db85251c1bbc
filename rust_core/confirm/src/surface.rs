//! The measured surface as seen from the projector: a depth buffer over the cells of the drawn image.
//!
//! ```text
//! points ─► projected, holes closed ─► quads between neighbours ─► nearest surface, nearest side wall ─► bounds
//! ```
//!
//! Four neighbouring pixels of the depth image are a quad: a measured surface, or a side wall where they jump. A quad
//! covers the cells whose centres it contains; one of a few cells, as most are, those in its bounding box. A measured
//! point at a jump covers its own cell, too, so that nothing thin is lost.

use fearless_simd::{dispatch, Level};
use nalgebra::Isometry3;
use rcs_scene::Intrinsics;

use crate::cells::cells_of;
use crate::grazing::{widening, write_codes, Directions};
use crate::projected::{cells_from_sensor, Projected};
use crate::quads::{Quads, NOTHING};
use crate::settings::TOLERANCE_PER_METRE;
use crate::PointGrid;

/// Rows of the depth image that share the angles of the first one.
const ROWS_PER_ANGLE: usize = 2;

/// Depths at which an object in a cell is confirmed, metres along the optical axis; NaN where no surface was measured,
/// or a side wall is before it.
#[derive(Debug, Default)]
pub(crate) struct Bounds {
    /// Columns and rows.
    pub(crate) size: [usize; 2],
    /// Nearest depth that agrees with the surface; what is nearer is gone.
    pub(crate) nearest: Vec<f32>,
    /// Farthest depth that agrees with the surface; what is farther is blocked by it.
    pub(crate) farthest: Vec<f32>,
}

impl Bounds {
    pub(crate) fn reset(&mut self, size: [usize; 2]) {
        self.size = size;
        for bounds in [&mut self.nearest, &mut self.farthest] {
            bounds.clear();
            bounds.resize(size[0] * size[1], f32::NAN);
        }
    }
}

/// Draws the surface; keeps its memory.
#[derive(Debug, Default)]
pub(crate) struct SurfaceDrawing {
    points: Projected,
    codes: Vec<u32>,
    quads: Quads,
}

impl SurfaceDrawing {
    /// Draws the surface of a depth image into the cells of the drawn image.
    pub(crate) fn draw(
        &mut self,
        intrinsics: &Intrinsics,
        projector_from_sensor: &Isometry3<f64>,
        grid: &PointGrid,
        tolerance_m: f64,
        bounds: &mut Bounds,
    ) {
        let size = cells_of([intrinsics.width_px, intrinsics.height_px]);
        self.points.take(grid, &cells_from_sensor(intrinsics, projector_from_sensor));
        self.quads.reset(size);
        let directions = Directions::new(intrinsics);
        for y in 1..self.points.height {
            if (y - 1) % ROWS_PER_ANGLE == 0 {
                write_codes(&self.points, directions, y - 1, &mut self.codes);
            }
            self.quads.draw(&self.points, y - 1, &self.codes);
        }
        bounds.reset(size);
        dispatch!(Level::new(), _simd => write_bounds(&self.quads, tolerance_m as f32, bounds));
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
