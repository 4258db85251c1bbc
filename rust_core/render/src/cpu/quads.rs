//! Faces of a few pixels, many of them.
//!
//! A cloud's faces are mostly small: a square of some pixels, the three sides of a box that are seen. Such a face is
//! drawn as one quadrangle, without going through the general way of triangles: its four edges, its depth and its
//! place (u, v) are linear in the window, set up for several points at once and then evaluated for several pixels at
//! once. The corners are those of [`faces`](super::faces), snapped as everywhere, and the edges own the pixels on them
//! by the same rule, so that the pixels are the same.
//!
//! Whatever is larger, cut by the near plane or so thin that its corners do not go round, is drawn as two
//! [`triangles`](super::triangles).

use rcs_scene::PointStyle;
use wide::{f32x4, u32x4};

use super::band::{pack, Band, LANE, LANES};
use super::faces::{size_m, BRIGHTNESS};
use super::points::{Cloud, Gathered, PointRef, Scratch, BLOCK};
use super::screen::{Screen, FARTHEST, SUBPIXELS};
use super::surface::contrast;
use super::triangles;

/// One colour.
pub(super) const PLAIN: u8 = 0;
/// One colour with a contrasting edge.
pub(super) const EDGED: u8 = 1;
/// One colour with a dark edge: the sides of boxes.
pub(super) const DARK_EDGED: u8 = 2;
/// A disc, darker to its rim.
pub(super) const DISC: u8 = 3;

/// Sides of a box; other faces have one.
const SIDES: usize = 6;

/// A face up to this size, in pixels, is small: then its edges' values are whole numbers that an `f32` holds.
const SMALL_PX: f32 = 12.0;

/// Snapped places to a pixel.
const SUB: f32 = SUBPIXELS as f32;

/// In a sum with this, which has no fraction, a value within ±2^22 is rounded to the nearest whole number.
const NO_FRACTION: f32 = 12_582_912.0;

/// Values of several points or pixels.
type V = f32x4;

/// A value that is linear in the window: at the centre of the face's first pixel, and its change by a pixel to the
/// right and down.
type Plane<T> = [T; 3];

/// How many planes a face has: four edges, the depth, and 1/w, u/w and v/w in units of the middle's 1/w.
const PLANES: usize = 8;
const DEPTH: usize = 4;
const PLACE: usize = 5;

/// One face of each point of a block, each of their numbers side by side.
#[derive(Clone, Debug)]
pub(super) struct Quads {
    /// Bit i: the face of point i is to be drawn here.
    small: u32,
    /// Bit i: the face of point i has to be drawn as triangles.
    general: u32,
    /// The face's pixels: left, right (past the last), top, bottom (past the last). Whole numbers.
    bounds: [[f32; BLOCK]; 4],
    planes: [Plane<[f32; BLOCK]>; PLANES],
}

const _: () = assert!(BLOCK <= u32::BITS as usize && BLOCK.is_multiple_of(LANES));

impl Quads {
    /// Room for the faces of a block of boxes.
    pub(super) fn of_boxes() -> Vec<Self> {
        let none = Self { small: 0, general: 0, bounds: [[0.0; BLOCK]; 4], planes: [[[0.0; BLOCK]; 3]; PLANES] };
        vec![none; SIDES]
    }

    #[inline(always)]
    fn plane(&self, plane: usize, i: usize) -> Plane<f32> {
        let [at, dx, dy] = &self.planes[plane];
        [at[i], dx[i], dy[i]]
    }
}

/// Several faces by their middles and half sides in clip coordinates, each seen from its front.
struct Corners {
    middle: [V; 4],
    right: [V; 4],
    up: [V; 4],
}

#[inline(always)]
fn store(all: &mut [f32; BLOCK], begin: usize, value: V) {
    if let Some(place) = all.get_mut(begin..).and_then(<[f32]>::first_chunk_mut::<LANES>) {
        *place = value.to_array();
    }
}

#[inline(always)]
fn load(all: &[f32; BLOCK], begin: usize) -> V {
    all.get(begin..).and_then(<[f32]>::first_chunk::<LANES>).map_or(V::ZERO, |values| V::new(*values))
}

/// To the nearest whole number.
#[inline(always)]
fn whole(value: V) -> V {
    (value + V::splat(NO_FRACTION)) - V::splat(NO_FRACTION)
}

/// The largest whole number not above a value that is a multiple of 1/256.
#[inline(always)]
fn floor(value: V) -> V {
    whole(value - V::splat(0.5 - 0.5 / SUB))
}

/// The smallest whole number not below a value that is a multiple of 1/256.
#[inline(always)]
fn ceil(value: V) -> V {
    whole(value + V::splat(0.5 - 0.5 / SUB))
}

impl Corners {
    /// Sets up the faces of the points from `begin` on.
    #[inline(always)]
    fn set_up(&self, screen: &Screen, rows: (i32, i32), begin: usize, with_uv: bool, out: &mut Quads) {
        let (half_width, half_height) = screen.half_size();
        // Snapped places, counter-clockwise from the lower left.
        let signs = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
        let (mut xs, mut ys, mut ds, mut qs) = ([V::ZERO; 4], [V::ZERO; 4], [V::ZERO; 4], [V::ZERO; 4]);
        let mut is_between_the_planes = V::ZERO.simd_eq(V::ZERO);
        for k in 0..4 {
            let (s, t) = signs[k];
            let at = |i: usize| {
                let along = if s > 0.0 { self.middle[i] + self.right[i] } else { self.middle[i] - self.right[i] };
                if t > 0.0 {
                    along + self.up[i]
                } else {
                    along - self.up[i]
                }
            };
            let (x, y, z, w) = (at(0), at(1), at(2), at(3));
            let inverse_w = V::ONE / w;
            let window_x = (x * inverse_w) * V::splat(half_width) + V::splat(half_width);
            let window_y = V::splat(half_height) - (y * inverse_w) * V::splat(half_height);
            xs[k] = whole((window_x - V::splat(0.5)) * V::splat(SUB));
            ys[k] = whole((window_y - V::splat(0.5)) * V::splat(SUB));
            ds[k] = (z * inverse_w) * V::splat(0.5 * FARTHEST) + V::splat(0.5 * FARTHEST);
            qs[k] = inverse_w * self.middle[3];
            is_between_the_planes = is_between_the_planes & z.simd_le(w) & z.simd_ge(-w);
        }
        let side = |a: usize, b: usize, c: usize| (xs[b] - xs[a]) * (ys[c] - ys[a]) - (xs[c] - xs[a]) * (ys[b] - ys[a]);
        let (half_a, half_b) = (side(0, 3, 2), side(0, 2, 1));
        let spread = side(0, 1, 3);
        let low = |v: &[V; 4]| v[0].fast_min(v[1]).fast_min(v[2].fast_min(v[3]));
        let high = |v: &[V; 4]| v[0].fast_max(v[1]).fast_max(v[2].fast_max(v[3]));
        let (x_low, x_high, y_low, y_high) = (low(&xs), high(&xs), low(&ys), high(&ys));
        let small_size = V::splat(SMALL_PX * SUB);
        let is_small = (x_high - x_low).simd_le(small_size) & (y_high - y_low).simd_le(small_size);
        let is_convex = half_a.simd_gt(V::ZERO) & half_b.simd_gt(V::ZERO) & spread.simd_le(-V::ONE);
        let is_back = half_a.simd_le(V::ZERO) & half_b.simd_le(V::ZERO);
        let is_simple = is_between_the_planes & is_small & is_convex;

        let per_sub = V::splat(1.0 / SUB);
        let left = ceil(x_low * per_sub).fast_max(V::ZERO);
        let right = (floor(x_high * per_sub) + V::ONE).fast_min(V::splat(screen.width_px as f32));
        let top = ceil(y_low * per_sub).fast_max(V::splat(rows.0 as f32));
        let bottom = (floor(y_high * per_sub) + V::ONE).fast_min(V::splat(rows.1 as f32));
        let is_seen = left.simd_lt(right) & top.simd_lt(bottom);
        let small = (is_simple & is_seen).to_bitmask();
        let done = is_simple | (is_between_the_planes & is_back);
        out.small |= small << begin;
        out.general |= (!done.to_bitmask() & ((1 << LANES) - 1)) << begin;
        if small == 0 {
            return;
        }
        for (all, value) in out.bounds.iter_mut().zip([left, right, top, bottom]) {
            store(all, begin, value);
        }

        let (px, py) = (left * V::splat(SUB), top * V::splat(SUB));
        let edges = [(0, 3), (3, 2), (2, 1), (1, 0)];
        for (plane, (a, b)) in out.planes.iter_mut().zip(edges) {
            let (along_x, along_y) = (xs[b] - xs[a], ys[b] - ys[a]);
            // Left edges go up, top edges go right: these own the pixels on them.
            let owns = along_y.simd_lt(V::ZERO) | (along_y.simd_eq(V::ZERO) & along_x.simd_gt(V::ZERO));
            let at = along_x * (py - ys[a]) - along_y * (px - xs[a]) - owns.bitselect(V::ZERO, V::ONE);
            store(&mut plane[0], begin, at);
            store(&mut plane[1], begin, -along_y * V::splat(SUB));
            store(&mut plane[2], begin, along_x * V::splat(SUB));
        }
        let (x1, y1, x3, y3) = (xs[1] - xs[0], ys[1] - ys[0], xs[3] - xs[0], ys[3] - ys[0]);
        let per_spread = V::ONE / spread;
        let (dx, dy) = (px - xs[0], py - ys[0]);
        let mut plane = |plane: usize, at: V, along_right: V, along_up: V| {
            let slope_x = (along_right * y3 - along_up * y1) * per_spread;
            let slope_y = (along_up * x1 - along_right * x3) * per_spread;
            let plane = &mut out.planes[plane];
            store(&mut plane[0], begin, at + (slope_x * dx + slope_y * dy));
            store(&mut plane[1], begin, slope_x * V::splat(SUB));
            store(&mut plane[2], begin, slope_y * V::splat(SUB));
        };
        plane(DEPTH, ds[0], ds[1] - ds[0], ds[3] - ds[0]);
        if with_uv {
            let half = V::splat(0.5);
            plane(PLACE, qs[0], qs[1] - qs[0], qs[3] - qs[0]);
            plane(PLACE + 1, -half * qs[0], half * (qs[1] + qs[0]), half * (qs[0] - qs[3]));
            plane(PLACE + 2, -half * qs[0], half * (qs[0] - qs[1]), half * (qs[3] + qs[0]));
        }
    }
}

/// Draws the rows of a band.
pub(super) fn draw<const PAINT: u8>(
    cloud: &Cloud<'_>,
    refs: &[PointRef],
    screen: &Screen,
    scratch: &mut Scratch,
    band: &mut Band<'_>,
) {
    let Scratch { points, quads } = scratch;
    let sides = if PAINT == DARK_EDGED { SIDES } else { 1 };
    let quads = quads.get_mut(..sides).unwrap_or(&mut []);
    for refs in refs.chunks(BLOCK) {
        points.gather(cloud, refs);
        set_up::<PAINT>(cloud, screen, band, points, quads);
        let there = (!0u32).checked_shr(u32::BITS - points.len as u32).unwrap_or(0);
        let general = quads.iter().fold(0, |any, quads| any | quads.general) & there;
        let mut seen = (quads.iter().fold(general, |any, quads| any | quads.small)) & there;
        while seen != 0 {
            let i = seen.trailing_zeros() as usize;
            seen &= seen - 1;
            if general & 1 << i != 0 {
                draw_triangles(cloud, points.indices[i], screen, band);
                continue;
            }
            for (side, quads) in quads.iter().enumerate() {
                if quads.small & 1 << i != 0 {
                    draw_quad::<PAINT>(cloud, quads, i, side, points.colors[i], band);
                }
            }
        }
    }
}

/// Draws the rows of a band as triangles.
pub(super) fn draw_exactly(cloud: &Cloud<'_>, refs: &[PointRef], screen: &Screen, band: &mut Band<'_>) {
    for point in refs {
        draw_triangles(cloud, point.index as usize, screen, band);
    }
}

#[cold]
fn draw_triangles(cloud: &Cloud<'_>, index: usize, screen: &Screen, band: &mut Band<'_>) {
    cloud.faces.triangles(&cloud.placement, index, |triangle| {
        triangles::cut(triangle, &cloud.surface, screen, |corners| {
            triangles::draw(corners.each_ref(), &cloud.surface, band);
        });
    });
}

/// The side of a box with this number: its axis and whether it looks along it or against it.
#[inline(always)]
const fn box_side(side: usize) -> (usize, bool) {
    ([2, 0, 1][side / 2], side.is_multiple_of(2))
}

#[inline(always)]
fn set_up<const PAINT: u8>(
    cloud: &Cloud<'_>,
    screen: &Screen,
    band: &Band<'_>,
    points: &Gathered,
    quads: &mut [Quads],
) {
    let rows = (band.first_row, band.end_row);
    for quads in quads.iter_mut() {
        (quads.small, quads.general) = (0, 0);
    }
    let m = cloud.placement.clip_from_object;
    for begin in (0..points.len).step_by(LANES) {
        let [x, y, z] = [0, 1, 2].map(|axis: usize| load(&points.places[axis], begin));
        let factor = if cloud.points.auto_size { z } else { V::ONE };
        let row = |i: usize| {
            let [a, b, c, d] = m[i];
            V::splat(a) * x + V::splat(b) * y + V::splat(c) * z + V::splat(d)
        };
        let center = [row(0), row(1), row(2), row(3)];
        match cloud.points.style {
            PointStyle::Boxes { size_m } => {
                let axis = |axis: usize| {
                    let half = size_m[axis] * 0.5;
                    let row = |i: usize| V::splat(m[i][axis] * half) * factor;
                    [row(0), row(1), row(2), row(3)]
                };
                let axes = [axis(0), axis(1), axis(2)];
                for (side, quads) in quads.iter_mut().enumerate() {
                    let (axis, is_along) = box_side(side);
                    let normal = axes[axis];
                    let row = |i: usize| if is_along { center[i] + normal[i] } else { center[i] - normal[i] };
                    let middle = [row(0), row(1), row(2), row(3)];
                    let (next, last) = (axes[(axis + 1) % 3], axes[(axis + 2) % 3]);
                    let (right, up) = if is_along { (next, last) } else { (last, next) };
                    Corners { middle, right, up }.set_up(screen, rows, begin, true, quads);
                }
            }
            style => {
                let [eye_x, eye_y, eye_z] = cloud.faces.eye().map(V::splat);
                let (x, y, z) = (eye_x - x, eye_y - y, eye_z - z);
                let level = x * x + z * z;
                let [width, height] = size_m(style).map(|length| V::splat(length * 0.5) * factor);
                let right = width / level.sqrt();
                let up = height / (level * (level + y * y)).sqrt();
                let right = [z * right, -x * right];
                let up = [-x * y * up, level * up, -y * z * up];
                let right_row = |i: usize| V::splat(m[i][0]) * right[0] + V::splat(m[i][2]) * right[1];
                let up_row =
                    |i: usize| V::splat(m[i][0]) * up[0] + V::splat(m[i][1]) * up[1] + V::splat(m[i][2]) * up[2];
                let right = [right_row(0), right_row(1), right_row(2), right_row(3)];
                let up = [up_row(0), up_row(1), up_row(2), up_row(3)];
                if let Some(quads) = quads.first_mut() {
                    Corners { middle: center, right, up }.set_up(screen, rows, begin, PAINT != PLAIN, quads);
                }
            }
        }
    }
}

#[inline(always)]
fn draw_quad<const PAINT: u8>(
    cloud: &Cloud<'_>,
    quads: &Quads,
    i: usize,
    side: usize,
    color: [u8; 4],
    band: &mut Band<'_>,
) {
    let bound = |k: usize| quads.bounds[k][i] as i32;
    let (left, right, top, bottom) = (bound(0), bound(1), bound(2), bound(3));
    let edges = [quads.plane(0, i), quads.plane(1, i), quads.plane(2, i), quads.plane(3, i)];
    let depth = quads.plane(DEPTH, i);
    let paint = Paint::<PAINT>::new(color, side);
    let mode = cloud.surface.mode;
    let lanes = V::new(LANE);
    for begin in (left..right).step_by(LANES) {
        let columns = V::splat((begin - left) as f32) + lanes;
        let row_of = |[at, dx, _]: Plane<f32>| V::splat(at) + V::splat(dx) * columns;
        let [mut e0, mut e1, mut e2, mut e3] = [row_of(edges[0]), row_of(edges[1]), row_of(edges[2]), row_of(edges[3])];
        let [d0, d1, d2, d3] =
            [V::splat(edges[0][2]), V::splat(edges[1][2]), V::splat(edges[2][2]), V::splat(edges[3][2])];
        let depth_columns = V::splat(depth[1]) * columns;
        let (mut place, mut place_down) = ([V::ZERO; 3], [V::ZERO; 3]);
        if PAINT != PLAIN {
            let planes = [quads.plane(PLACE, i), quads.plane(PLACE + 1, i), quads.plane(PLACE + 2, i)];
            place = [row_of(planes[0]), row_of(planes[1]), row_of(planes[2])];
            place_down = [V::splat(planes[0][2]), V::splat(planes[1][2]), V::splat(planes[2][2])];
        }
        // A depth's steps are whole numbers, so that adding up small changes from row to row would lose them.
        let mut down = 0.0;
        for window in band.windows(top..bottom, begin) {
            let mut mask = e0.fast_min(e1).fast_min(e2.fast_min(e3)).simd_ge(V::ZERO);
            let colors = paint.colors(place, &mut mask);
            let depths = V::splat(depth[0] + depth[2] * down) + depth_columns;
            window.meet(mask, depths, colors, mode);
            (e0, e1, e2, e3) = (e0 + d0, e1 + d1, e2 + d2, e3 + d3);
            if PAINT != PLAIN {
                place = [place[0] + place_down[0], place[1] + place_down[1], place[2] + place_down[2]];
            }
            down += 1.0;
        }
    }
}

/// What a face's colour is made of.
struct Paint<const PAINT: u8> {
    color: [u8; 4],
    /// 0 to 1, with a box's side's brightness.
    rgb: [f32; 3],
    contrast: f32,
}

impl<const PAINT: u8> Paint<PAINT> {
    #[inline(always)]
    fn new(color: [u8; 4], side: usize) -> Self {
        if PAINT == PLAIN {
            return Self { color, rgb: [0.0; 3], contrast: 0.0 };
        }
        let (axis, is_along) = box_side(side);
        let brightness = if PAINT == DARK_EDGED { BRIGHTNESS[usize::from(!is_along)][axis] } else { 1.0 };
        let channel = |i: usize| f32::from(color[i]) / 255.0;
        let (r, g, b) = (channel(0), channel(1), channel(2));
        let contrast = if PAINT == EDGED { contrast([r, g, b, 1.0]) } else { 0.0 };
        Self { color, rgb: [r * brightness, g * brightness, b * brightness], contrast }
    }

    /// The colours at places given by 1/w, u/w and v/w, and which of them there are; see [`super::surface`].
    #[inline(always)]
    fn colors(&self, place: [V; 3], mask: &mut V) -> u32x4 {
        if PAINT == PLAIN {
            return u32x4::splat(pack(self.color));
        }
        let w = V::ONE / place[0];
        let (u, v) = (place[1] * w, place[2] * w);
        let edge_shade = |from_middle: V| {
            let t = (V::splat(0.48) - from_middle.abs()) * V::splat(1.0 / 0.03);
            let t = t.fast_max(V::ZERO).fast_min(V::ONE);
            t * t * (V::splat(3.0) - V::splat(2.0) * t)
        };
        let (multiplied, added) = match PAINT {
            EDGED => (V::ONE, V::splat(self.contrast) * (V::ONE - edge_shade(u) * edge_shade(v))),
            DARK_EDGED => (V::splat(0.5) + V::splat(0.5) * (edge_shade(u) * edge_shade(v)), V::ZERO),
            _ => {
                let height = (V::splat(0.25) - (u * u + v * v)) * V::splat(4.0);
                *mask &= height.simd_gt(V::ZERO);
                (V::splat(0.8) + V::splat(0.2) * height, V::ZERO)
            }
        };
        let channel = |i: usize| {
            let level = (V::splat(self.rgb[i]) * multiplied + added).fast_max(V::ZERO).fast_min(V::ONE);
            let bits: u32x4 = bytemuck::cast(level * V::splat(255.0) + V::splat(NO_FRACTION));
            (bits & u32x4::splat(255)) << shift(i)
        };
        let alpha = u32x4::splat(u32::from(self.color[3]) << shift(3));
        channel(0) | channel(1) | channel(2) | alpha
    }
}

/// By how much a channel's byte is shifted in a packed colour.
#[inline(always)]
fn shift(channel: usize) -> u32 {
    let mut color = [0; 4];
    color[channel] = 1;
    pack(color).trailing_zeros()
}
