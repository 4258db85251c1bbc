//! Faces of a few pixels, many of them.
//!
//! A cloud's faces are mostly small: a square of some pixels, the three sides of a box that are seen. Such a face is
//! drawn as one quadrangle, without going through the general way of triangles: its four edges, its depth and its
//! place (u, v) are linear in the window, set up for several points at once and then evaluated for several pixels at
//! once. The corners are those of [`faces`](super::faces), snapped as everywhere, and the edges own the pixels on them
//! by the same rule, so that the pixels are the same.
//!
//! Rectangles of a fixed orientation are seen from both sides; their corners go round the other way from behind.
//!
//! Of a box only the three sides that look towards the eye are set up. They share a corner, and four more in pairs, so
//! that a box has seven corners to project.
//!
//! Whatever is larger, cut by the near plane or so thin that its corners do not go round, is drawn as two
//! [`triangles`](super::triangles).

use fearless_simd::prelude::*;
use fearless_simd::Simd;
use rcs_scene::PointStyle;

use super::band::Band;
use super::faces::{cross, size_m};
use super::lanes::{inlined, load, map, nearest, numbers, store, store_whole, transform, whole, F, I, LANES, M};
use super::points::{Cloud, Gathered, Scratch, BLOCK};
use super::quad_paint::{Paint, DARK_EDGED, PLAIN};
use super::screen::{Screen, FARTHEST, SUBPIXELS};
use super::triangles;

/// Sides of a box that can be seen at once: those across z, x and y. Other faces have one.
const SIDES: usize = 3;

/// The axes that they are across, in the order in which they are drawn.
const AXES: [usize; SIDES] = [2, 0, 1];

/// A face up to this size, in pixels, is small: then its edges' values fit into 32 bits.
const SMALL_PX: f32 = 64.0;

/// Snapped places to a pixel.
const SUB: f32 = SUBPIXELS as f32;

/// A value that is linear in the window: at the centre of the face's first pixel, and its change by a pixel to the
/// right and down.
type Plane<T> = [T; 3];

/// Edges of a face.
const EDGES: usize = 4;

/// What is linear in the window: the depth, and 1/w, u/w and v/w in units of the middle's 1/w.
const PLANES: usize = 4;
const DEPTH: usize = 0;
const PLACE: usize = 1;

/// One face of each point of a block, each of their numbers side by side.
#[derive(Clone, Debug)]
pub(super) struct Quads {
    /// Bit i: the face of point i is to be drawn here.
    small: u32,
    /// Bit i: the face of point i has to be drawn as triangles.
    general: u32,
    /// Bit i: the face of point i looks along its axis, not against it.
    along: u32,
    /// The face's pixels: left, right (past the last), top, bottom (past the last).
    bounds: [[i32; BLOCK]; 4],
    /// A pixel is inside of an edge where the edge's value is not negative.
    edges: [Plane<[i32; BLOCK]>; EDGES],
    planes: [Plane<[f32; BLOCK]>; PLANES],
}

const _: () = assert!(BLOCK <= u32::BITS as usize && BLOCK.is_multiple_of(LANES));

impl Quads {
    /// Room for the faces of a block of boxes.
    pub(super) fn of_boxes() -> Vec<Self> {
        let none = Self {
            small: 0,
            general: 0,
            along: 0,
            bounds: [[0; BLOCK]; 4],
            edges: [[[0; BLOCK]; 3]; EDGES],
            planes: [[[0.0; BLOCK]; 3]; PLANES],
        };
        vec![none; SIDES]
    }

    #[inline(always)]
    fn edge(&self, edge: usize, i: usize) -> Plane<i32> {
        let [at, dx, dy] = &self.edges[edge];
        [at[i], dx[i], dy[i]]
    }

    #[inline(always)]
    fn plane(&self, plane: usize, i: usize) -> Plane<f32> {
        let [at, dx, dy] = &self.planes[plane];
        [at[i], dx[i], dy[i]]
    }
}

/// A corner of several faces on the picture.
#[derive(Clone, Copy)]
struct Corner<S: Simd> {
    /// Snapped.
    x: F<S>,
    /// Snapped.
    y: F<S>,
    depth: F<S>,
    /// 1/w in units of the middle's 1/w.
    q: F<S>,
    is_between_the_planes: M<S>,
}

impl<S: Simd> Corner<S> {
    #[inline(always)]
    fn new([x, y, z, w]: [F<S>; 4], middle_w: F<S>, (half_width, half_height): (f32, f32)) -> Self {
        let inverse_w = 1.0 / w;
        let window_x = (x * inverse_w) * half_width + half_width;
        let window_y = half_height - (y * inverse_w) * half_height;
        Self {
            x: nearest((window_x - 0.5) * SUB),
            y: nearest((window_y - 0.5) * SUB),
            depth: (z * inverse_w) * (0.5 * FARTHEST) + 0.5 * FARTHEST,
            q: inverse_w * middle_w,
            is_between_the_planes: z.simd_le(w) & z.simd_ge(-w),
        }
    }

    /// `one` where the mask is set, else `other`.
    #[inline(always)]
    fn select(mask: M<S>, one: &Self, other: &Self) -> Self {
        Self {
            x: mask.select(one.x, other.x),
            y: mask.select(one.y, other.y),
            depth: mask.select(one.depth, other.depth),
            q: mask.select(one.q, other.q),
            // Where only one of them is, neither is used.
            is_between_the_planes: one.is_between_the_planes & other.is_between_the_planes,
        }
    }
}

/// The largest whole number not above a value that is a multiple of 1/256.
#[inline(always)]
fn floor<S: Simd>(value: F<S>) -> F<S> {
    nearest(value - (0.5 - 0.5 / SUB))
}

/// The smallest whole number not below a value that is a multiple of 1/256.
#[inline(always)]
fn ceil<S: Simd>(value: F<S>) -> F<S> {
    nearest(value + (0.5 - 0.5 / SUB))
}

#[inline(always)]
fn least<S: Simd>([a, b, c, d]: [F<S>; 4]) -> F<S> {
    a.min(b).min(c.min(d))
}

#[inline(always)]
fn greatest<S: Simd>([a, b, c, d]: [F<S>; 4]) -> F<S> {
    a.max(b).max(c.max(d))
}

/// What faces are like.
#[derive(Clone, Copy)]
struct What {
    /// Nothing is seen of them from behind.
    is_one_sided: bool,
    /// They look different from place to place.
    with_place: bool,
}

const BOX_SIDE: What = What { is_one_sided: true, with_place: true };

/// What is the same for all faces of a block.
#[derive(Clone, Copy)]
struct Frame {
    /// Of the picture.
    width_px: f32,
    /// The band's first row and the one after its last.
    rows: [f32; 2],
    half_size: (f32, f32),
}

impl Quads {
    /// Sets up the faces of the points from `begin` on, given by their corners counter-clockwise from the lower left.
    #[inline(always)]
    fn set_up<S: Simd>(&mut self, simd: S, corners: [&Corner<S>; 4], frame: &Frame, begin: usize, what: What) {
        let [a, b, c, d] = corners;
        let (xs, ys) = ([a.x, b.x, c.x, d.x], [a.y, b.y, c.y, d.y]);
        let (x_low, x_high, y_low, y_high) = (least(xs), greatest(xs), least(ys), greatest(ys));
        let is_between_the_planes =
            a.is_between_the_planes & b.is_between_the_planes & c.is_between_the_planes & d.is_between_the_planes;
        let small_size = F::splat(simd, SMALL_PX * SUB);
        let is_small =
            is_between_the_planes & (x_high - x_low).simd_le(small_size) & (y_high - y_low).simd_le(small_size);

        let per_sub = 1.0 / SUB;
        let left = ceil(x_low * per_sub).max(0.0);
        let right = (floor(x_high * per_sub) + 1.0).min(frame.width_px);
        let top = ceil(y_low * per_sub).max(frame.rows[0]);
        let bottom = (floor(y_high * per_sub) + 1.0).min(frame.rows[1]);
        let is_seen = left.simd_lt(right) & top.simd_lt(bottom);

        // Of what is small all products fit; of the rest nothing is used.
        let (xs, ys) = (map(xs, whole), map(ys, whole));
        let side = inlined(
            #[inline(always)]
            |a: usize, b: usize, c: usize| (xs[b] - xs[a]) * (ys[c] - ys[a]) - (xs[c] - xs[a]) * (ys[b] - ys[a]),
        );
        let (half_a, half_b, spread) = (side(0, 3, 2), side(0, 2, 1), side(0, 1, 3));
        let none = I::splat(simd, 0);
        let is_convex = half_a.simd_gt(none) & half_b.simd_gt(none) & spread.simd_lt(none);
        let is_back = half_a.simd_le(none) & half_b.simd_le(none);
        let small = (is_small & is_convex & is_seen).to_bitmask() as u32;
        let is_done = if what.is_one_sided { is_convex | is_back } else { is_convex };
        let is_done = is_small & is_done;
        self.small |= small << begin;
        self.general |= (!is_done.to_bitmask() as u32 & ((1 << LANES) - 1)) << begin;
        if small == 0 {
            return;
        }
        for (all, value) in self.bounds.iter_mut().zip([left, right, top, bottom]) {
            store_whole(all, begin, whole(value));
        }

        let (px, py) = (whole(left * SUB), whole(top * SUB));
        for (plane, (a, b)) in self.edges.iter_mut().zip([(0, 3), (3, 2), (2, 1), (1, 0)]) {
            let (along_x, along_y) = (xs[b] - xs[a], ys[b] - ys[a]);
            // Left edges go up, top edges go right: these own the pixels on them.
            let owns = along_y.simd_lt(none) | (along_y.simd_eq(none) & along_x.simd_gt(none));
            let at = along_x * (py - ys[a]) - along_y * (px - xs[a]) - owns.select(none, I::splat(simd, 1));
            store_whole(&mut plane[0], begin, at);
            store_whole(&mut plane[1], begin, along_y * -SUBPIXELS);
            store_whole(&mut plane[2], begin, along_x * SUBPIXELS);
        }
        let (x1, y1, x3, y3) = (b.x - a.x, b.y - a.y, d.x - a.x, d.y - a.y);
        let per_spread = 1.0 / spread.to_float::<F<S>>();
        let (dx, dy) = (left * SUB - a.x, top * SUB - a.y);
        let mut plane = inlined(
            #[inline(always)]
            |plane: usize, at: F<S>, along_right: F<S>, along_up: F<S>| {
                let slope_x = (along_right * y3 - along_up * y1) * per_spread;
                let slope_y = (along_up * x1 - along_right * x3) * per_spread;
                let plane = &mut self.planes[plane];
                store(&mut plane[0], begin, at + (slope_x * dx + slope_y * dy));
                store(&mut plane[1], begin, slope_x * SUB);
                store(&mut plane[2], begin, slope_y * SUB);
            },
        );
        plane(DEPTH, a.depth, b.depth - a.depth, d.depth - a.depth);
        if what.with_place {
            plane(PLACE, a.q, b.q - a.q, d.q - a.q);
            plane(PLACE + 1, a.q * -0.5, (b.q + a.q) * 0.5, (a.q - d.q) * 0.5);
            plane(PLACE + 2, a.q * -0.5, (a.q - b.q) * 0.5, (d.q + a.q) * 0.5);
        }
    }
}

/// Some points of a block, as many as there are lanes.
#[derive(Clone, Copy)]
struct Batch<'a, S: Simd> {
    simd: S,
    cloud: &'a Cloud<'a>,
    frame: &'a Frame,
    points: &'a Gathered,
    /// Of the block's points the first of these.
    begin: usize,
}

/// Draws the rows of a band.
#[inline(always)]
pub(super) fn draw<S: Simd, const PAINT: u8>(
    simd: S,
    cloud: &Cloud<'_>,
    indices: &[u32],
    screen: &Screen,
    scratch: &mut Scratch,
    band: &mut Band<'_>,
) {
    let Scratch { points, quads } = scratch;
    let sides = if PAINT == DARK_EDGED { SIDES } else { 1 };
    let quads = quads.get_mut(..sides).unwrap_or(&mut []);
    let frame = Frame {
        width_px: screen.width_px as f32,
        rows: [band.first_row as f32, band.end_row as f32],
        half_size: screen.half_size(),
    };
    for indices in indices.chunks(BLOCK) {
        points.gather(cloud, indices);
        for quads in quads.iter_mut() {
            (quads.small, quads.general, quads.along) = (0, 0, 0);
        }
        for begin in (0..points.len).step_by(LANES) {
            let batch = Batch { simd, cloud, frame: &frame, points, begin };
            if PAINT == DARK_EDGED {
                set_up_boxes(&batch, quads);
            } else if let Some(quads) = quads.first_mut() {
                match cloud.points.style {
                    PointStyle::Tiles { .. } => set_up_tiles(&batch, quads),
                    _ => set_up_upright(&batch, PAINT != PLAIN, quads),
                }
            }
        }
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
            for (quads, axis) in quads.iter().zip(AXES) {
                if quads.small & 1 << i != 0 {
                    draw_quad::<S, PAINT>(simd, cloud, quads, i, axis, points.colors[i], band);
                }
            }
        }
    }
}

/// Draws the rows of a band as triangles.
pub(super) fn draw_exactly(cloud: &Cloud<'_>, indices: &[u32], screen: &Screen, band: &mut Band<'_>) {
    for &index in indices {
        draw_triangles(cloud, index, screen, band);
    }
}

#[cold]
fn draw_triangles(cloud: &Cloud<'_>, index: u32, screen: &Screen, band: &mut Band<'_>) {
    cloud.faces.triangles(&cloud.placement, index as usize, |triangle| {
        triangles::cut(triangle, &cloud.surface, screen, |corners| {
            triangles::draw(corners.each_ref(), &cloud.surface, band);
        });
    });
}

/// A block's places from `begin` on, what their sizes are multiplied by, and their places in clip coordinates.
#[inline(always)]
fn places<S: Simd>(batch: &Batch<'_, S>) -> ([F<S>; 3], F<S>, [F<S>; 4]) {
    let Batch { simd, cloud, points, begin, .. } = *batch;
    let [x, y, z] = &points.places;
    let place = [load(simd, x, begin), load(simd, y, begin), load(simd, z, begin)];
    let factor = if cloud.points.auto_size { place[2] } else { F::splat(simd, 1.0) };
    (place, factor, transform(&cloud.placement.clip_from_object, place))
}

/// Sets up faces that look at the eye and stand upright.
#[inline(always)]
fn set_up_upright<S: Simd>(batch: &Batch<'_, S>, with_place: bool, quads: &mut Quads) {
    let Batch { simd, cloud, frame, begin, .. } = *batch;
    let ([x, y, z], factor, middle) = places(batch);
    let [eye_x, eye_y, eye_z] = cloud.faces.eye();
    let (x, y, z) = (eye_x - x, eye_y - y, eye_z - z);
    let level = x * x + z * z;
    let [width, height] = size_m(cloud.points.style);
    let (width, height) = (factor * (width * 0.5), factor * (height * 0.5));
    let right = width / level.sqrt();
    let up = height / (level * (level + y * y)).sqrt();
    let right = [z * right, -x * right];
    let up = [-x * y * up, level * up, -y * z * up];
    let m = &cloud.placement.clip_from_object;
    let right = map(
        *m,
        #[inline(always)]
        |row| right[0] * row[0] + right[1] * row[2],
    );
    let up = map(
        *m,
        #[inline(always)]
        |row| up[0] * row[0] + up[1] * row[1] + up[2] * row[2],
    );
    let [lower_left, lower_right, upper_right, upper_left] = corners(middle, right, up, frame);
    let around = [&lower_left, &lower_right, &upper_right, &upper_left];
    quads.set_up(simd, around, frame, begin, What { is_one_sided: true, with_place });
}

/// Sets up rectangles of a fixed orientation, which are seen from both sides.
#[inline(always)]
fn set_up_tiles<S: Simd>(batch: &Batch<'_, S>, quads: &mut Quads) {
    let Batch { simd, cloud, frame, begin, .. } = *batch;
    let Some([right, up]) = cloud.faces.tile_sides() else { return };
    let (place, _, middle) = places(batch);
    let across = cross(right, up);
    let [x, y, z] = cloud.faces.eye();
    let from_above = (x - place[0]) * across[0] + (y - place[1]) * across[1] + (z - place[2]) * across[2];
    let is_turned = from_above.simd_lt(0.0);
    let m = cloud.placement.clip_from_object;
    let along = inlined(
        #[inline(always)]
        |side: [f32; 3]| {
            map(
                m,
                #[inline(always)]
                |row| F::splat(simd, row[0] * side[0] + row[1] * side[1] + row[2] * side[2]),
            )
        },
    );
    let [lower_left, right, upper_right, up] = corners(middle, along(right), along(up), frame);
    let lower_right = Corner::select(is_turned, &up, &right);
    let upper_left = Corner::select(is_turned, &right, &up);
    let around = [&lower_left, &lower_right, &upper_right, &upper_left];
    quads.set_up(simd, around, frame, begin, What { is_one_sided: false, with_place: true });
}

/// The corners of faces by their middles and half sides in clip coordinates: lower left, lower right, upper right and
/// upper left.
#[inline(always)]
fn corners<S: Simd>(middle: [F<S>; 4], right: [F<S>; 4], up: [F<S>; 4], frame: &Frame) -> [Corner<S>; 4] {
    let corner = inlined(
        #[inline(always)]
        |is_right: bool, is_up: bool| {
            let mut at = middle;
            for i in 0..4 {
                at[i] = if is_right { at[i] + right[i] } else { at[i] - right[i] };
                at[i] = if is_up { at[i] + up[i] } else { at[i] - up[i] };
            }
            Corner::new(at, middle[3], frame.half_size)
        },
    );
    [corner(false, false), corner(true, false), corner(true, true), corner(false, true)]
}

/// Sets up the sides of boxes that look towards the eye.
#[inline(always)]
fn set_up_boxes<S: Simd>(batch: &Batch<'_, S>, quads: &mut [Quads]) {
    let Batch { simd, cloud, frame, begin, .. } = *batch;
    let PointStyle::Boxes { size_m } = cloud.points.style else { return };
    let (place, factor, middle) = places(batch);
    let (zero, one) = (F::splat(simd, 0.0), F::splat(simd, 1.0));
    let eye = cloud.faces.eye();
    let along = map(
        [0, 1, 2],
        #[inline(always)]
        |axis: usize| (eye[axis] - place[axis]).simd_ge(zero),
    );
    // Half a side along each axis, towards the eye.
    let half = map(
        [0, 1, 2],
        #[inline(always)]
        |axis: usize| {
            let half = factor * along[axis].select(one, -one);
            map(
                cloud.placement.clip_from_object,
                #[inline(always)]
                |row| half * (row[axis] * (size_m[axis] * 0.5)),
            )
        },
    );
    // The corner on this side of each axis: towards the eye or away from it.
    let corner = inlined(
        #[inline(always)]
        |towards: [bool; 3]| {
            let mut at = middle;
            for axis in 0..3 {
                for i in 0..4 {
                    at[i] = if towards[axis] { at[i] + half[axis][i] } else { at[i] - half[axis][i] };
                }
            }
            Corner::new(at, middle[3], frame.half_size)
        },
    );
    let near = corner([true, true, true]);
    // Away along one axis, and along all but one.
    let without = [corner([false, true, true]), corner([true, false, true]), corner([true, true, false])];
    let only = [corner([true, false, false]), corner([false, true, false]), corner([false, false, true])];
    // Where an odd number of axes point away from the eye, the sides' corners go round the other way.
    let is_turned = !(along[0] ^ along[1] ^ along[2]);
    let is_inside_out = (factor.simd_lt(zero).to_bitmask() as u32) << begin;
    for (quads, axis) in quads.iter_mut().zip(AXES) {
        let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
        let (right, up) = (&without[last], &without[next]);
        let lower_right = Corner::select(is_turned, up, right);
        let upper_left = Corner::select(is_turned, right, up);
        quads.along |= (along[axis].to_bitmask() as u32) << begin;
        quads.general |= is_inside_out;
        quads.set_up(simd, [&only[axis], &lower_right, &near, &upper_left], frame, begin, BOX_SIDE);
    }
}

#[inline(always)]
fn draw_quad<S: Simd, const PAINT: u8>(
    simd: S,
    cloud: &Cloud<'_>,
    quads: &Quads,
    i: usize,
    axis: usize,
    color: u32,
    band: &mut Band<'_>,
) {
    let [left, right, top, bottom] = quads.bounds.each_ref().map(|all| all[i]);
    let edges = [quads.edge(0, i), quads.edge(1, i), quads.edge(2, i), quads.edge(3, i)];
    let [depth, depth_right, depth_down] = quads.plane(DEPTH, i);
    let places = [quads.plane(PLACE, i), quads.plane(PLACE + 1, i), quads.plane(PLACE + 2, i)];
    let paint = Paint::<S, PAINT>::new(simd, color, axis, quads.along & 1 << i != 0);
    let mode = cloud.surface.mode;
    for begin in (left..right).step_by(LANES) {
        let columns = numbers(simd) + (begin - left);
        let mut edges_at = map(
            edges,
            #[inline(always)]
            |[at, dx, _]| columns * dx + at,
        );
        let columns = columns.to_float::<F<S>>();
        // A depth's steps are whole numbers: what is below one would be lost in adding up from row to row.
        let mut depth_from_first = columns * depth_right;
        let mut places_at = [F::splat(simd, 0.0); 3];
        if PAINT != PLAIN {
            places_at = map(
                places,
                #[inline(always)]
                |[at, dx, _]| columns * dx + at,
            );
        }
        band.for_windows(
            top..bottom,
            begin,
            #[inline(always)]
            |window| {
                let [e0, e1, e2, e3] = edges_at;
                let mask = ((e0 | e1) | (e2 | e3)).simd_ge(I::splat(simd, 0));
                window.meet(
                    mask,
                    depth_from_first + depth,
                    mode,
                    #[inline(always)]
                    |seen| (paint.mask(places_at, seen), paint.colors(places_at)),
                );
                for k in 0..EDGES {
                    edges_at[k] += edges[k][2];
                }
                depth_from_first += depth_down;
                if PAINT != PLAIN {
                    for k in 0..3 {
                        places_at[k] += places[k][2];
                    }
                }
            },
        );
    }
}
