//! A depth image's points projected into the projector's drawn image, as a surface without holes.
//!
//! The drawn image is that of the pinhole, before the lens, so straight lines stay straight: between two points, place
//! and inverse depth are interpolated linearly and stay on the line through both.

use fearless_simd::{dispatch, Level};
use nalgebra::{Isometry3, Matrix3x4};
use rcs_scene::Intrinsics;

use crate::cells::CELL_PX;
use crate::PointGrid;

/// Widest hole of the depth image that is closed where both of its sides are one surface, pixels along a row or column.
pub const HOLE_PX: usize = 4;

/// Depth from the projector at which surfaces begin, metres.
const NEAREST_M: f32 = 0.01;

/// [`Projected::z`] of a pixel on a side wall: nothing is measured there.
const BRIDGE: f32 = -1.0;

/// Pixels of a row that are worked on at once, so that the compiler uses SIMD.
pub(crate) const CHUNK: usize = 32;

/// Missing points before and behind each row, at least: slopes are measured over as many.
pub(crate) const PADDING: usize = 4;

/// Pixels that are skipped at once where there is no hole to close.
const SKIPPED: usize = 16;

/// [`CHUNK`] values of a plane.
pub(crate) type Chunk = [f32; CHUNK];

/// A chunk of a plane of points; missing ones if it goes beyond its end.
#[inline(always)]
pub(crate) fn chunk(plane: &[f32], begin: usize) -> &Chunk {
    const MISSING: Chunk = [f32::NAN; CHUNK];
    plane.get(begin..).and_then(<[f32]>::first_chunk).unwrap_or(&MISSING)
}

/// Least and largest value in chunks of a plane that begin at these indices, and in the values behind the chunks.
/// Infinite and −infinite if all are NaN.
#[inline(always)]
pub(crate) fn extremes(plane: &[f32], begins: impl Iterator<Item = usize>) -> [f32; 2] {
    let (mut least, mut most) = ([f32::INFINITY; CHUNK], [f32::NEG_INFINITY; CHUNK]);
    // By themselves: written among the others, they would wait for memory.
    let (mut least_behind, mut most_behind) = (f32::INFINITY, f32::NEG_INFINITY);
    for begin in begins {
        let values = chunk(plane, begin);
        // Of a number and NaN, the number is the least and the most.
        for i in 0..CHUNK {
            least[i] = least[i].min(values[i]);
            most[i] = most[i].max(values[i]);
        }
        let behind = plane[begin + CHUNK];
        (least_behind, most_behind) = (least_behind.min(behind), most_behind.max(behind));
    }
    let mut count = CHUNK;
    while count > 1 {
        count /= 2;
        for i in 0..count {
            least[i] = least[i].min(least[i + count]);
            most[i] = most[i].max(most[i + count]);
        }
    }
    [least[0].min(least_behind), most[0].max(most_behind)]
}

/// Difference of two neighbours' depths above which they are two surfaces, metres. It grows like the noise and the
/// steps of a depth camera.
#[inline(always)]
pub(crate) fn jump_m(depth_m: f32) -> f32 {
    0.02 + 0.005 * depth_m * depth_m
}

/// Points of a depth image in the drawn image, row by row. A pixel without a point has NaN everywhere. Rows are padded
/// with such, so that chunks and [`PADDING`] points around them are within the planes.
#[derive(Debug, Default)]
pub(crate) struct Projected {
    pub(crate) width: usize,
    pub(crate) height: usize,
    /// Distance of rows in the planes.
    pub(crate) stride: usize,
    /// Places, in cells from the drawn image's left edge.
    pub(crate) u: Vec<f32>,
    /// Places, in cells from the drawn image's upper edge.
    pub(crate) v: Vec<f32>,
    /// Inverse depths from the projector, 1/m.
    pub(crate) w: Vec<f32>,
    /// Depths from the sensor, metres; [`BRIDGE`] on side walls.
    pub(crate) z: Vec<f32>,
}

/// Projection of the sensor's points: places in cells times depth, and depth.
pub(crate) fn cells_from_sensor(intrinsics: &Intrinsics, projector_from_sensor: &Isometry3<f64>) -> Matrix3x4<f64> {
    let Intrinsics { fx_px, fy_px, skew_px: [s, t], cx_px, cy_px, tx, ty, .. } = *intrinsics;
    #[rustfmt::skip]
    let pixels_from_projector = Matrix3x4::new(
        fx_px, s, cx_px, tx,
        t, fy_px, cy_px, ty,
        0.0, 0.0, 1.0, 0.0,
    );
    let mut cells = pixels_from_projector * projector_from_sensor.to_homogeneous();
    cells.fixed_view_mut::<2, 4>(0, 0).scale_mut(1.0 / CELL_PX as f64);
    cells
}

impl Projected {
    /// Projects the points and closes the surface.
    pub(crate) fn take(&mut self, grid: &PointGrid, cells_from_sensor: &Matrix3x4<f64>) {
        self.fit(grid.size_px.map(|side| side as usize));
        let rows = [0, 1, 2].map(|row| [0, 1, 2, 3].map(|column| cells_from_sensor[(row, column)] as f32));
        dispatch!(Level::new(), _simd => self.project(&rows, &grid.points));
        let sensor = [rows[0][3], rows[1][3], rows[2][3]];
        dispatch!(Level::new(), _simd => self.close(sensor));
    }

    #[inline(always)]
    fn close(&mut self, sensor: [f32; 3]) {
        for y in 0..self.height {
            self.close_columns_from(y);
            self.close_row(y, sensor);
        }
    }

    /// Index of a point in the planes.
    #[inline(always)]
    pub(crate) fn index(&self, x: usize, y: usize) -> usize {
        PADDING + y * self.stride + x
    }

    /// Makes room for as many columns and rows.
    fn fit(&mut self, [width, height]: [usize; 2]) {
        if [self.width, self.height] == [width, height] {
            return;
        }
        (self.width, self.height, self.stride) = (width, height, width.next_multiple_of(CHUNK) + 2 * PADDING);
        for plane in [&mut self.u, &mut self.v, &mut self.w, &mut self.z] {
            plane.clear();
            plane.resize(self.stride * height, f32::NAN);
        }
    }

    #[inline(always)]
    fn project(&mut self, matrix: &[[f32; 4]; 3], points: &[[f32; 3]]) {
        if self.width == 0 {
            return;
        }
        for (y, points) in points.chunks_exact(self.width).enumerate() {
            self.project_row(matrix, self.index(0, y), points);
        }
    }

    #[inline(always)]
    fn project_row(&mut self, matrix: &[[f32; 4]; 3], begin: usize, points: &[[f32; 3]]) {
        let [u, v, w, z] =
            [&mut self.u, &mut self.v, &mut self.w, &mut self.z].map(|plane| &mut plane[begin..begin + points.len()]);
        for ((((point, u), v), w), z) in points.iter().zip(u).zip(v).zip(w).zip(z) {
            let [x, y, d] = *point;
            let [along_u, along_v, depth] =
                matrix.map(|[by_x, by_y, by_z, offset]| by_x * x + by_y * y + by_z * d + offset);
            let is_ahead = d > 0.0 && depth > NEAREST_M;
            let inverse = if is_ahead { 1.0 / depth } else { f32::NAN };
            *u = along_u * inverse;
            *v = along_v * inverse;
            *w = inverse;
            *z = if is_ahead { d } else { f32::NAN };
        }
    }

    /// Closes the small holes that begin in this row below a point.
    #[inline(always)]
    fn close_columns_from(&mut self, y: usize) {
        let (begin, width) = (self.index(0, y), self.width);
        if y == 0 {
            return;
        }
        for first in (begin..begin + width).step_by(SKIPPED) {
            let end = (first + SKIPPED).min(begin + width);
            let above = &self.z[first - self.stride..end - self.stride];
            let is_hole = |any, (own, above): (&f32, &f32)| any | (own.is_nan() & (*above > 0.0));
            if !self.z[first..end].iter().zip(above).fold(false, is_hole) {
                continue;
            }
            for index in first..end {
                if self.z[index].is_nan() && self.z[index - self.stride] > 0.0 {
                    self.close_column(index);
                }
            }
        }
    }

    /// Closes the hole that begins here, below a point, if it is small.
    fn close_column(&mut self, index: usize) {
        let above = index - self.stride;
        let others = (1..=HOLE_PX).map(|rows| index + rows * self.stride);
        let below = others.take_while(|index| *index < self.z.len()).find(|index| self.z[*index] > 0.0);
        if let Some(below) = below.filter(|below| self.are_one_surface(above, *below)) {
            self.connect(above, below, self.stride);
        }
    }

    /// Closes all holes between points of a row: small ones as surface, others as side walls.
    /// `sensor` is the sensor's place times depth, and depth.
    #[inline(always)]
    fn close_row(&mut self, y: usize, sensor: [f32; 3]) {
        let (begin, end) = (self.index(0, y), self.index(self.width, y));
        let mut last = None;
        for first in (begin..end).step_by(SKIPPED) {
            let end = (first + SKIPPED).min(end);
            let missing = self.z[first..end].iter().fold(0, |count, z| count + u32::from(z.is_nan()));
            if missing as usize == end - first {
                continue;
            }
            let is_whole = missing == 0;
            for index in first..if is_whole { first + 1 } else { end } {
                if self.z[index].is_nan() {
                    continue;
                }
                if let Some(last) = last.filter(|last| last + 1 < index) {
                    if index - last <= HOLE_PX + 1 && self.are_one_surface(last, index) {
                        self.connect(last, index, 1);
                    } else {
                        self.bridge(last, index, sensor);
                    }
                }
                last = Some(index);
            }
            if is_whole {
                last = Some(end - 1);
            }
        }
    }

    fn are_one_surface(&self, one: usize, other: usize) -> bool {
        let (one, other) = (self.z[one], self.z[other]);
        one > 0.0 && other > 0.0 && (one - other).abs() <= jump_m(one.min(other))
    }

    /// Fills the pixels between two points, which are `step` apart in memory.
    fn connect(&mut self, from: usize, to: usize, step: usize) {
        let share_of_one = step as f32 / (to - from) as f32;
        for plane in [&mut self.u, &mut self.v, &mut self.w, &mut self.z] {
            let (first, last) = (plane[from], plane[to]);
            for (count, index) in (from + step..to).step_by(step).enumerate() {
                plane[index] = first + (last - first) * share_of_one * (count + 1) as f32;
            }
        }
    }

    /// Fills the pixels between two points of a row with side walls: from the nearer point away from the sensor to the
    /// depth of the farther one, and from there to that.
    fn bridge(&mut self, from: usize, to: usize, sensor: [f32; 3]) {
        let (near, far, next) = if self.z[from] < self.z[to] { (from, to, from + 1) } else { (to, from, to - 1) };
        let scale = self.z[far] / self.z[near];
        let ahead = |of_sensor: f32, of_near: f32| of_sensor + scale * (of_near / self.w[near] - of_sensor);
        let depth = ahead(sensor[2], 1.0);
        if depth > NEAREST_M {
            let place = [ahead(sensor[0], self.u[near]), ahead(sensor[1], self.v[near])];
            (self.u[next], self.v[next], self.w[next]) = (place[0] / depth, place[1] / depth, 1.0 / depth);
            self.connect(next.min(far), next.max(far), 1);
        } else {
            self.connect(from, to, 1);
        }
        self.z[from + 1..to].fill(BRIDGE);
    }
}
