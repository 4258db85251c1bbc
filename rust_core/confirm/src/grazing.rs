//! Angle at which the projector's rays meet the measured surface, and what it adds to the tolerance.
//!
//! On a plane the inverse depth is linear over the image: w = a x + b y + c with directions (x, y, 1), and (a, b, c) is
//! along the normal. The slopes are measured over some pixels, as neighbours differ by noise, and on the flatter side,
//! as the other one may reach over an edge.

use fearless_simd::{dispatch, Level};
use rcs_scene::Intrinsics;

use crate::cells::CELL_PX;
use crate::projected::{jump_m, Projected};

/// Cosine below which a surface is seen at a grazing angle.
const GRAZING: f32 = 0.3;
/// Largest factor of the tolerance.
const MOST: f32 = 10.0;
/// Steps of a [code](widening) per factor of 1.
const STEPS: f32 = 16.0;
/// Pixels over which slopes are measured, to either side.
const REACH: usize = 4;
/// Jumps over half of that, above which it is an edge: less than the tolerance, so that nothing in the way is a slope.
const EDGE: f32 = 1.5;

/// Factor of the tolerance for a code.
#[inline(always)]
pub(crate) fn widening(code: u32) -> f32 {
    1.0 + code as f32 / STEPS
}

/// Code of the factor by which a surface widens the tolerance where a ray meets it with this cosine: 1 for NaN.
#[inline(always)]
fn code_of(cosine: f32) -> u32 {
    let extra = if cosine < GRAZING { (1.0 / cosine).min(MOST) - 1.0 } else { 0.0 };
    (extra * STEPS) as u32
}

/// Changes of direction and inverse depth along the surface.
#[derive(Clone, Copy)]
struct Slope {
    x: f32,
    y: f32,
    w: f32,
}

/// Directions of the places in the drawn image, in cells.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Directions {
    scale: [f32; 2],
    center: [f32; 2],
}

impl Directions {
    /// Directions of a camera without its skew.
    pub(crate) fn new(intrinsics: &Intrinsics) -> Self {
        let cell = CELL_PX as f64;
        Self {
            scale: [intrinsics.fx_px, intrinsics.fy_px].map(|focal| (cell / focal) as f32),
            center: [intrinsics.cx_px, intrinsics.cy_px].map(|center| (center / cell) as f32),
        }
    }
}

/// Writes the [codes](widening) of a row's points.
pub(crate) fn write_codes(points: &Projected, directions: Directions, y: usize, codes: &mut Vec<u32>) {
    codes.clear();
    codes.resize(points.width, 0);
    if points.width > 2 * REACH {
        dispatch!(Level::new(), _simd => write_row(points, directions, y, &mut codes[REACH..points.width - REACH]));
    }
}

#[inline(always)]
fn write_row(points: &Projected, directions: Directions, y: usize, codes: &mut [u32]) {
    let row_at = |y: usize| y.min(points.height - 1) * points.width;
    let row = row_at(y);
    let count = codes.len();
    let at = |begin: usize| {
        let range = begin..begin + count;
        Strip {
            u: &points.u[range.clone()],
            v: &points.v[range.clone()],
            w: &points.w[range.clone()],
            z: &points.z[range],
        }
    };
    let own = at(row + REACH);
    let (left, half_left, half_right, right) =
        (at(row), at(row + REACH / 2), at(row + REACH + REACH / 2), at(row + 2 * REACH));
    let [above, half_above] = [REACH, REACH / 2].map(|rows| at(row_at(y.saturating_sub(rows)) + REACH));
    let [below, half_below] = [REACH, REACH / 2].map(|rows| at(row_at(y + rows) + REACH));
    for (i, code) in codes.iter_mut().enumerate() {
        let limit_m = EDGE * jump_m(own.z[i]);
        let across =
            flatter(slope([&left, &half_left, &own], i, limit_m), slope([&own, &half_right, &right], i, limit_m));
        let down =
            flatter(slope([&above, &half_above, &own], i, limit_m), slope([&own, &half_below, &below], i, limit_m));
        *code = code_of(cosine(directions, [own.u[i], own.v[i], own.w[i]], [across, down]));
    }
}

/// Part of a row.
#[derive(Clone, Copy)]
struct Strip<'a> {
    u: &'a [f32],
    v: &'a [f32],
    w: &'a [f32],
    z: &'a [f32],
}

/// Slope from the first to the last of three points; NaN over an edge.
#[inline(always)]
fn slope([from, half, to]: [&Strip<'_>; 3], i: usize, limit_m: f32) -> Slope {
    let is_edge = ((half.z[i] - from.z[i]).abs() > limit_m) | ((to.z[i] - half.z[i]).abs() > limit_m);
    let w = if is_edge { f32::NAN } else { to.w[i] - from.w[i] };
    Slope { x: to.u[i] - from.u[i], y: to.v[i] - from.v[i], w }
}

#[inline(always)]
fn flatter(one: Slope, other: Slope) -> Slope {
    // A slope over an edge is NaN.
    let is_one = (one.w.abs() <= other.w.abs()) | other.w.is_nan();
    let pick = |one: f32, other: f32| if is_one { one } else { other };
    Slope { x: pick(one.x, other.x), y: pick(one.y, other.y), w: pick(one.w, other.w) }
}

/// Cosine between the normal and the ray at a point; NaN where a slope is unknown.
#[inline(always)]
fn cosine(directions: Directions, [u, v, w]: [f32; 3], [across, down]: [Slope; 2]) -> f32 {
    let Directions { scale, center } = directions;
    let scaled = |slope: Slope| [slope.x * scale[0], slope.y * scale[1], slope.w];
    let ([x1, y1, w1], [x2, y2, w2]) = (scaled(across), scaled(down));
    let (x, y) = ((u - center[0]) * scale[0], (v - center[1]) * scale[1]);
    // Multiplied by the determinant, which is 0 on a surface seen from its edge.
    let determinant = x1 * y2 - x2 * y1;
    let (a, b) = (w1 * y2 - w2 * y1, x1 * w2 - x2 * w1);
    let c = w * determinant - a * x - b * y;
    (w * determinant).abs() / ((a * a + b * b + c * c) * (x * x + y * y + 1.0)).sqrt()
}
