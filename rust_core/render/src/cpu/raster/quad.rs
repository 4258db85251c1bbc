//! The pixels of one face of a point: a quadrangle of some pixels, several of them at once.

use fearless_simd::prelude::*;
use fearless_simd::Simd;

use super::edges::{Edge, RowEdges};
use crate::cpu::paint::{FaceColor, PLAIN};
use crate::cpu::tile::band::{Band, Mode};
use crate::cpu::tile::lanes::{lane_indices, map, F, LANES};
use crate::cpu::tile::screen::{rounding, Area, DepthPlane, FARTHEST};

/// A value that is linear in the window: at the centre of the first pixel of the face's first row, and its change by a
/// pixel to the right and down.
pub(in crate::cpu) type Gradient<T> = [T; 3];

/// Edges of a face.
pub(in crate::cpu) const EDGES: usize = 4;

/// A face on the image. All that is linear is measured from the first pixel of its first row, whether the band has it
/// or not, so that no pixel depends on how high bands are.
pub(in crate::cpu) struct Quad<S: Simd, const PAINT: u8> {
    pub simd: S,
    /// Its pixels in the band.
    pub area: Area,
    pub first_row: i32,
    pub edges: [Edge<i32>; EDGES],
    pub depth: Gradient<f32>,
    /// 1/w, u/w and v/w.
    pub place: [Gradient<f32>; 3],
    pub color: FaceColor<S, f32, PAINT>,
}

impl<S: Simd, const PAINT: u8> Quad<S, PAINT> {
    /// Draws those of its pixels that are in an area, which reaches from its first to its last row at most. Returns
    /// true if some are seen.
    #[inline(always)]
    pub(in crate::cpu) fn draw(&self, area: Area, mode: Mode, band: &mut Band<'_>) -> bool {
        let Self { simd, first_row, edges, place, ref color, .. } = *self;
        let [depth, depth_right, depth_down] = self.depth;
        let rows_above = area.top - first_row;
        let mut is_seen = false;
        for begin in (area.left..area.right).step_by(LANES) {
            let columns = lane_indices(simd) + (begin - self.area.left);
            let mut rows = RowEdges::new(&edges, columns, rows_above);
            let columns = columns.to_float::<F<S>>();
            let from_first = columns * depth_right;
            let mut row = rows_above as f32;
            // Faces of one colour have no use for it.
            let first_place = if PAINT == PLAIN {
                [columns; 3]
            } else {
                map(
                    place,
                    #[inline(always)]
                    |[at, dx, _]| columns * dx + at,
                )
            };
            band.for_windows(
                area.top..area.bottom,
                begin,
                #[inline(always)]
                |window| {
                    is_seen |= window.write_fragments(
                        rows.next(),
                        // A depth's steps are whole numbers: fractions would be lost in sums with it.
                        (from_first + depth_down * row) + depth,
                        mode,
                        #[inline(always)]
                        |seen| {
                            let mut at = first_place;
                            for k in 0..3 {
                                at[k] = first_place[k] + F::splat(simd, row) * place[k][2];
                            }
                            (color.mask(at, seen), color.colors(at))
                        },
                    );
                    row += 1.0;
                },
            );
        }
        is_seen
    }
}

/// A bound of the depths of a face's fragments in an area, given its first row.
#[inline(always)]
pub(in crate::cpu) fn depth_bound([at, dx, dy]: Gradient<f32>, area: Area, first_row: i32) -> DepthPlane {
    let (columns, rows) = ((area.right - area.left) as f32, (area.bottom - first_row) as f32);
    let noise = if dx == 0.0 && dy == 0.0 {
        0.0
    } else {
        let (right, down) = (dx.abs() * columns, dy.abs() * rows);
        let from_first = right + down;
        let depth = (at.abs() + from_first).min(2.0 * FARTHEST);
        1.01 * (rounding(right) + rounding(down) + rounding(from_first) + rounding(depth))
    };
    // At the nearest corner of its pixels.
    let row = if dy < 0.0 { rows - 1.0 } else { (area.top - first_row) as f32 };
    let least = at + dx.min(0.0) * (columns - 1.0) + dy * row - noise;
    DepthPlane { at, dx, dy, x: area.left as f32, y: first_row as f32, noise, least }
}
