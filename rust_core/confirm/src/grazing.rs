//! Angle at which the projector's rays meet the measured surface, and what it adds to the tolerance.
//!
//! On a plane the inverse depth is linear over the image: w = a x + b y + c with directions (x, y, 1), and (a, b, c) is
//! along the normal. The slopes are measured over some pixels, as neighbours differ by noise, and on the flatter side,
//! as the other one may reach over an edge.

use rcs_scene::Intrinsics;

use crate::cells::CELL_PX;
use crate::projected::{chunk, jump_m, Chunk, Projected, CHUNK, PADDING};

/// Measured cosine below which a surface is seen at a grazing angle: 0.3, less what noise moves most of them by. Where
/// it is not certain that the tolerance is wider, it is not.
const GRAZING: f32 = 0.28;
/// Largest factor of the tolerance.
const MOST: f32 = 10.0;
/// Steps of a [code](widening) per factor of 1.
const STEPS: f32 = 16.0;
/// Pixels over which slopes are measured, to either side.
const REACH: usize = PADDING;
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
#[derive(Clone, Copy, Debug, Default)]
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

/// [Codes](widening) of [`CHUNK`] points from column x of row y on. Beside missing points and near the ends of a row,
/// they are those of a surface that is seen from the front.
#[inline(always)]
pub(crate) fn codes_of(points: &Projected, directions: Directions, [x, y]: [usize; 2]) -> [u32; CHUNK] {
    let (begin, half) = (points.index(x, y), REACH / 2);
    let own = Strip::new(points, begin);
    let [left, half_left, half_right, right] =
        [begin - REACH, begin - half, begin + half, begin + REACH].map(|begin| Strip::new(points, begin));
    let [above, half_above, half_below, below] = [y.saturating_sub(REACH), y.saturating_sub(half), y + half, y + REACH]
        .map(|y| Strip::new(points, points.index(x, y.min(points.height - 1))));
    let mut codes = [0; CHUNK];
    for (i, code) in codes.iter_mut().enumerate() {
        let limit_m = EDGE * jump_m(own.z[i]);
        let slope = |strips: [&Strip<'_>; 3]| slope(strips, i, limit_m);
        let across = flatter(slope([&left, &half_left, &own]), slope([&own, &half_right, &right]));
        let down = flatter(slope([&above, &half_above, &own]), slope([&own, &half_below, &below]));
        *code = code_of(cosine(directions, [own.u[i], own.v[i], own.w[i]], [across, down]));
    }
    codes
}

/// [`CHUNK`] points of a row.
#[derive(Clone, Copy)]
struct Strip<'a> {
    u: &'a Chunk,
    v: &'a Chunk,
    w: &'a Chunk,
    z: &'a Chunk,
}

impl<'a> Strip<'a> {
    #[inline(always)]
    fn new(points: &'a Projected, begin: usize) -> Self {
        let Projected { u, v, w, z, .. } = points;
        Self { u: chunk(u, begin), v: chunk(v, begin), w: chunk(w, begin), z: chunk(z, begin) }
    }
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
