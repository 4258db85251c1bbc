//! Placing a block's faces: quadrangles of a few pixels, many of them.
//!
//! A cloud's faces are mostly small: a square of some pixels, the three sides of a box that are seen. Such a face is
//! drawn as one quadrangle, without going through the general way of triangles: its four edges, its depth and its
//! place (u, v) are linear in the window, found here for several points at once and then evaluated for several pixels
//! at once ([`Quad`]). The corners are those of [`faces`](super::faces), snapped as everywhere, and the edges are the
//! same, so that the pixels are the same.
//!
//! Rectangles of a fixed orientation are seen from both sides; their corners go round the other way from behind.
//!
//! Of a box only the three sides that are turned to the eye are set up. They share a corner, and four more in pairs, so
//! that a box has seven corners to project.
//!
//! Whatever is larger, cut by the near plane or so thin that its corners do not go round, is left for
//! [`triangles`](crate::cpu::raster::triangle).

use fearless_simd::prelude::*;
use fearless_simd::Simd;
use rcs_scene::{CullMode, PointStyle};

use super::choose::PointBlock;
use super::faces::{cross, size_m, upright};
use super::{Cloud, BLOCK};
use crate::cpu::paint::{FaceColor, BOX_SIDE, PLAIN};
use crate::cpu::raster::edges::Edge;
use crate::cpu::raster::quad::{Gradient, Quad, EDGES};
use crate::cpu::tile::band::Band;
use crate::cpu::tile::lanes::{
    inlined, load, map, nearest, store, store_integers, to_integers, transform, F, LANES, M,
};
use crate::cpu::tile::screen::{Area, Screen, FARTHEST, SUBPIXELS};
use crate::shading::{BOX_SIDES_AGAINST, BOX_SIDES_ALONG};

/// Sides of a box that can be seen at once: those across z, x and y. Other faces have one.
pub(in crate::cpu) const SIDES: usize = 3;

/// The axes that they are across, in the order in which they are drawn.
pub(in crate::cpu) const AXES: [usize; SIDES] = [2, 0, 1];

/// A face up to this size, in pixels, is small: then its edges' values fit into 32 bits, in whole pixels.
const SMALL_PX: f32 = 512.0;

/// Snapped places to a pixel.
const SUB: f32 = SUBPIXELS as f32;

/// Values that are linear in the window: the depth, and 1/w, u/w and v/w in units of the middle's 1/w.
const PLANES: usize = 4;
const DEPTH: usize = 0;
const PLACE: usize = 1;

/// One face of each point of a block, each of their numbers side by side.
#[derive(Clone, Debug)]
pub(in crate::cpu) struct FaceBlock {
    /// Bit i: the face of point i is to be drawn as a quadrangle.
    pub small: u32,
    /// Bit i: the face of point i has to be drawn as triangles.
    pub general: u32,
    /// Bit i: the face of point i is turned along its axis, not against it.
    pub along: u32,
    /// The face's pixels: left, right (past the last), top, bottom (past the last).
    pub bounds: [[i32; BLOCK]; 4],
    /// The face's first row in the image, whether the band has it or not: from there all that is linear is measured,
    /// so that no pixel depends on how high bands are.
    pub first_rows: [i32; BLOCK],
    /// A pixel is inside of an edge where the edge's value is not negative.
    edges: [Gradient<[i32; BLOCK]>; EDGES],
    planes: [Gradient<[f32; BLOCK]>; PLANES],
}

const _: () = assert!(BLOCK <= u32::BITS as usize && BLOCK.is_multiple_of(LANES));

impl FaceBlock {
    /// Room for the faces of a block of boxes.
    pub(in crate::cpu) fn of_boxes() -> Box<[Self; SIDES]> {
        let none = || Self {
            small: 0,
            general: 0,
            along: 0,
            bounds: [[0; BLOCK]; 4],
            first_rows: [0; BLOCK],
            edges: [[[0; BLOCK]; 3]; EDGES],
            planes: [[[0.0; BLOCK]; 3]; PLANES],
        };
        Box::new([none(), none(), none()])
    }

    /// Forgets all faces.
    pub(in crate::cpu) fn clear(&mut self) {
        (self.small, self.general, self.along) = (0, 0, 0);
    }

    /// A face that was traced, in its packed colour; of a box it is the side across an axis.
    #[inline(always)]
    pub(in crate::cpu) fn quad<S: Simd, const PAINT: u8>(
        &self,
        simd: S,
        i: usize,
        axis: usize,
        color: u32,
    ) -> Quad<S, PAINT> {
        let [left, right, top, bottom] = self.bounds.each_ref().map(|all| all[i]);
        let edge = inlined(
            #[inline(always)]
            |edge: usize| {
                let [at, dx, dy] = &self.edges[edge];
                Edge { at: at[i], dx: dx[i], dy: dy[i] }
            },
        );
        let sides = if self.along & 1 << i != 0 { BOX_SIDES_ALONG } else { BOX_SIDES_AGAINST };
        let brightness = if PAINT == BOX_SIDE { sides[axis] } else { 1.0 };
        Quad {
            simd,
            area: Area { left, right, top, bottom },
            first_row: self.first_rows[i],
            edges: [edge(0), edge(1), edge(2), edge(3)],
            depth: self.plane(DEPTH, i),
            place: [self.plane(PLACE, i), self.plane(PLACE + 1, i), self.plane(PLACE + 2, i)],
            color: FaceColor::new(simd, color, brightness),
        }
    }

    #[inline(always)]
    fn plane(&self, plane: usize, i: usize) -> Gradient<f32> {
        let [at, dx, dy] = &self.planes[plane];
        [at[i], dx[i], dy[i]]
    }
}

/// A corner of several faces on the image.
#[derive(Clone, Copy)]
struct FaceCorner<S: Simd> {
    /// Snapped.
    x: F<S>,
    /// Snapped.
    y: F<S>,
    /// 0 to [`FARTHEST`].
    depth: F<S>,
    /// 1/w in units of the middle's 1/w.
    q: F<S>,
    is_between_the_planes: M<S>,
}

impl<S: Simd> FaceCorner<S> {
    #[inline(always)]
    fn new([x, y, z, w]: [F<S>; 4], middle_w: F<S>, (half_width, half_height): (f32, f32)) -> Self {
        let inverse_w = 1.0 / w;
        let window_x = (x * inverse_w) * half_width + half_width;
        let window_y = half_height - (y * inverse_w) * half_height;
        Self {
            x: snap(window_x),
            y: snap(window_y),
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

/// As [`snap`](crate::cpu::tile::screen::snap): what lies in the middle of two snapped places goes away from zero.
#[inline(always)]
fn snap<S: Simd>(window: F<S>) -> F<S> {
    let scaled = (window - 0.5) * SUB;
    (scaled + F::splat(scaled.token(), 0.5).copysign(scaled)).trunc()
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

/// The band that faces are placed in.
#[derive(Clone, Copy)]
pub(in crate::cpu) struct BandView {
    /// Of the image.
    pub width_px: f32,
    /// The band's first row and the one after its last.
    pub rows: [f32; 2],
    /// Half of the image's width and height in pixels.
    pub half_size: (f32, f32),
}

impl BandView {
    /// Of a band of the image.
    pub(in crate::cpu) fn new(screen: &Screen, band: &Band<'_>) -> Self {
        let rows = [band.first_row as f32, band.end_row as f32];
        Self { width_px: screen.width_px as f32, rows, half_size: screen.half_size() }
    }
}

/// Some points' faces on the image.
#[derive(Clone, Copy)]
struct Quads<S: Simd> {
    /// Counter-clockwise from the lower left.
    corners: [FaceCorner<S>; 4],
    /// The first pixels' columns and rows in the image.
    left: F<S>,
    first_row: F<S>,
    per_spread: F<S>,
}

impl<S: Simd> Quads<S> {
    /// A value that is linear in the window, given at the first corner with its changes to the neighbours: in the first
    /// pixel, and its changes by a pixel.
    #[inline(always)]
    fn plane(&self, at: F<S>, along_right: F<S>, along_up: F<S>) -> Gradient<F<S>> {
        let [a, b, _, d] = &self.corners;
        let (x1, y1, x3, y3) = (b.x - a.x, b.y - a.y, d.x - a.x, d.y - a.y);
        let (dx, dy) = (self.left * SUB - a.x, self.first_row * SUB - a.y);
        let slope_x = (along_right * y3 - along_up * y1) * self.per_spread;
        let slope_y = (along_up * x1 - along_right * x3) * self.per_spread;
        [at + (slope_x * dx + slope_y * dy), slope_x * SUB, slope_y * SUB]
    }

    /// The doubled area between three corners, in snapped places, negative where they turn left; and how far off it may
    /// be.
    #[inline(always)]
    fn doubled_area(&self, [a, b, c]: [usize; 3]) -> [F<S>; 2] {
        // Up to this the products of whole numbers are exact.
        const EXACT: f32 = 16_777_216.0;
        let [a, b, c] = [&self.corners[a], &self.corners[b], &self.corners[c]];
        let (one, other) = ((b.x - a.x) * (c.y - a.y), (c.x - a.x) * (b.y - a.y));
        let extent = one.abs() + other.abs();
        let noise = extent.simd_lt(EXACT).select(F::splat(extent.token(), 0.0), extent * (1.0 / (1 << 22) as f32));
        [one - other, noise]
    }
}

impl FaceBlock {
    /// Places the faces of the points from `begin` on, given by their corners counter-clockwise from the lower left.
    #[inline(always)]
    fn place<S: Simd, const PAINT: u8>(&mut self, lanes: &PointLanes<'_, S>, corners: [FaceCorner<S>; 4]) {
        let PointLanes { simd, cloud, view, begin, .. } = *lanes;
        let [a, b, c, d] = &corners;
        let (xs, ys) = ([a.x, b.x, c.x, d.x], [a.y, b.y, c.y, d.y]);
        let (x_low, x_high, y_low, y_high) = (least(xs), greatest(xs), least(ys), greatest(ys));
        let is_between_the_planes =
            a.is_between_the_planes & b.is_between_the_planes & c.is_between_the_planes & d.is_between_the_planes;
        let small_size = F::splat(simd, SMALL_PX * SUB);
        let is_small =
            is_between_the_planes & (x_high - x_low).simd_le(small_size) & (y_high - y_low).simd_le(small_size);

        let per_sub = 1.0 / SUB;
        let left = ceil(x_low * per_sub).max(0.0);
        let right = (floor(x_high * per_sub) + 1.0).min(view.width_px);
        let first_row = ceil(y_low * per_sub).max(0.0);
        let top = first_row.max(view.rows[0]);
        let bottom = (floor(y_high * per_sub) + 1.0).min(view.rows[1]);
        let is_seen = left.simd_lt(right) & top.simd_lt(bottom);

        let mut quads = Quads { corners, left, first_row, per_spread: left };
        let [half_a, half_b, spread] =
            [quads.doubled_area([0, 3, 2]), quads.doubled_area([0, 2, 1]), quads.doubled_area([0, 1, 3])];
        quads.per_spread = 1.0 / spread[0];
        let is_convex = half_a[0].simd_gt(half_a[1]) & half_b[0].simd_gt(half_b[1]) & spread[0].simd_lt(-spread[1]);
        let is_back = half_a[0].simd_le(-half_a[1]) & half_b[0].simd_le(-half_b[1]);
        let small = (is_small & is_convex & is_seen).to_bitmask() as u32;
        let is_done = if cloud.surface.cull == CullMode::None { is_convex } else { is_convex | is_back };
        let is_done = is_small & is_done;
        self.small |= small << begin;
        self.general |= (!is_done.to_bitmask() as u32 & ((1 << LANES) - 1)) << begin;
        if small != 0 {
            for (all, value) in self.bounds.iter_mut().zip([left, right, top, bottom]) {
                store_integers(all, begin, to_integers(value));
            }
            self.set_up::<_, PAINT>(&quads, begin);
        }
    }

    /// Sets up the edges of faces, and what is linear in the window.
    #[inline(always)]
    fn set_up<S: Simd, const PAINT: u8>(&mut self, quads: &Quads<S>, begin: usize) {
        let [a, b, c, d] = &quads.corners;
        let origin = [to_integers(quads.left), to_integers(quads.first_row)];
        store_integers(&mut self.first_rows, begin, origin[1]);
        let (xs, ys) = (map([a.x, b.x, c.x, d.x], to_integers), map([a.y, b.y, c.y, d.y], to_integers));
        for (all, (from, to)) in self.edges.iter_mut().zip([(0, 3), (3, 2), (2, 1), (1, 0)]) {
            let edge = Edge::new([xs[from], ys[from]], [xs[to], ys[to]], origin);
            for (all, value) in all.iter_mut().zip([edge.at, edge.dx, edge.dy]) {
                store_integers(all, begin, value);
            }
        }
        self.store_plane(DEPTH, begin, quads.plane(a.depth, b.depth - a.depth, d.depth - a.depth));
        // The colour of the others does not depend on the place.
        if PAINT != PLAIN {
            self.store_plane(PLACE, begin, quads.plane(a.q, b.q - a.q, d.q - a.q));
            self.store_plane(PLACE + 1, begin, quads.plane(a.q * -0.5, (b.q + a.q) * 0.5, (a.q - d.q) * 0.5));
            self.store_plane(PLACE + 2, begin, quads.plane(a.q * -0.5, (a.q - b.q) * 0.5, (d.q + a.q) * 0.5));
        }
    }

    #[inline(always)]
    fn store_plane<S: Simd>(&mut self, plane: usize, begin: usize, values: Gradient<F<S>>) {
        for (all, value) in self.planes[plane].iter_mut().zip(values) {
            store(all, begin, value);
        }
    }
}

/// Some points of a block, as many as there are lanes.
#[derive(Clone, Copy)]
pub(in crate::cpu) struct PointLanes<'a, S: Simd> {
    /// The instructions.
    pub simd: S,
    /// Whose points they are.
    pub cloud: &'a Cloud<'a>,
    /// The band.
    pub view: &'a BandView,
    /// The block.
    pub points: &'a PointBlock,
    /// The index of the first of these points in the block.
    pub begin: usize,
}

/// The points' positions, the factors of their sizes, and their positions in clip coordinates.
#[inline(always)]
fn positions<S: Simd>(lanes: &PointLanes<'_, S>) -> ([F<S>; 3], F<S>, [F<S>; 4]) {
    let PointLanes { simd, cloud, points, begin, .. } = *lanes;
    let [x, y, z] = &points.positions;
    let position = [load(simd, x, begin), load(simd, y, begin), load(simd, z, begin)];
    let factor = if cloud.points.auto_size { position[2] } else { F::splat(simd, 1.0) };
    (position, factor, transform(&cloud.transform.clip_from_object, position))
}

/// The number of faces of a point that may be seen.
pub(in crate::cpu) const fn sides_of<const PAINT: u8>() -> usize {
    if PAINT == BOX_SIDE {
        SIDES
    } else {
        1
    }
}

/// Places the faces of some points: of each point those that [may be seen](sides_of).
#[inline(always)]
pub(in crate::cpu) fn place_faces<S: Simd, const PAINT: u8>(lanes: &PointLanes<'_, S>, faces: &mut [FaceBlock; SIDES]) {
    if PAINT == BOX_SIDE {
        return place_boxes::<_, PAINT>(lanes, faces);
    }
    let [faces, ..] = faces;
    match lanes.cloud.points.style {
        PointStyle::Tiles { .. } => place_tiles::<_, PAINT>(lanes, faces),
        _ => place_upright::<_, PAINT>(lanes, faces),
    }
}

/// Places faces that face the eye and stand upright.
#[inline(always)]
fn place_upright<S: Simd, const PAINT: u8>(lanes: &PointLanes<'_, S>, faces: &mut FaceBlock) {
    let PointLanes { cloud, view, .. } = *lanes;
    let ([x, y, z], factor, middle) = positions(lanes);
    let [eye_x, eye_y, eye_z] = cloud.eye;
    let [width, height] = size_m(cloud.points.style);
    let half = [factor * (width * 0.5), factor * (height * 0.5)];
    let (right, up) = upright([eye_x - x, eye_y - y, eye_z - z], half);
    let m = &cloud.transform.clip_from_object;
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
    faces.place::<_, PAINT>(lanes, corners(middle, right, up, view));
}

/// Places rectangles of a fixed orientation, which are seen from both sides.
#[inline(always)]
fn place_tiles<S: Simd, const PAINT: u8>(lanes: &PointLanes<'_, S>, faces: &mut FaceBlock) {
    let PointLanes { simd, cloud, view, .. } = *lanes;
    let [right, up] = cloud.tile_sides().unwrap_or_default();
    let (position, _, middle) = positions(lanes);
    let across = cross(right, up);
    let [x, y, z] = cloud.eye;
    let from_above = (x - position[0]) * across[0] + (y - position[1]) * across[1] + (z - position[2]) * across[2];
    let is_turned = from_above.simd_lt(0.0);
    let m = cloud.transform.clip_from_object;
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
    let [lower_left, right, upper_right, up] = corners(middle, along(right), along(up), view);
    let lower_right = FaceCorner::select(is_turned, &up, &right);
    let upper_left = FaceCorner::select(is_turned, &right, &up);
    faces.place::<_, PAINT>(lanes, [lower_left, lower_right, upper_right, upper_left]);
}

/// The corners of faces by their middles and half sides in clip coordinates: lower left, lower right, upper right and
/// upper left.
#[inline(always)]
fn corners<S: Simd>(middle: [F<S>; 4], right: [F<S>; 4], up: [F<S>; 4], view: &BandView) -> [FaceCorner<S>; 4] {
    let corner = inlined(
        #[inline(always)]
        |is_right: bool, is_up: bool| {
            let mut at = middle;
            for i in 0..4 {
                at[i] = if is_right { at[i] + right[i] } else { at[i] - right[i] };
                at[i] = if is_up { at[i] + up[i] } else { at[i] - up[i] };
            }
            FaceCorner::new(at, middle[3], view.half_size)
        },
    );
    [corner(false, false), corner(true, false), corner(true, true), corner(false, true)]
}

/// The boxes that a negative size turns inside out, so that they show other sides: bit i for point i.
#[inline(always)]
fn inside_out<S: Simd>(size_m: [f32; 3], factor: F<S>, begin: usize) -> u32 {
    let is_mirrored = !size_m.iter().all(|side_m| *side_m >= 0.0);
    if is_mirrored {
        u32::MAX
    } else {
        (factor.simd_lt(0.0).to_bitmask() as u32) << begin
    }
}

/// Places the sides of boxes that are turned to the eye.
#[inline(always)]
fn place_boxes<S: Simd, const PAINT: u8>(lanes: &PointLanes<'_, S>, sides: &mut [FaceBlock; SIDES]) {
    let PointLanes { simd, cloud, view, begin, .. } = *lanes;
    let size_m = if let PointStyle::Boxes { size_m } = cloud.points.style { size_m } else { [0.0; 3] };
    let (position, factor, middle) = positions(lanes);
    let (zero, one) = (F::splat(simd, 0.0), F::splat(simd, 1.0));
    let eye = cloud.eye;
    let along = map(
        [0, 1, 2],
        #[inline(always)]
        |axis: usize| (eye[axis] - position[axis]).simd_ge(zero),
    );
    // Half a side along each axis, towards the eye.
    let half = map(
        [0, 1, 2],
        #[inline(always)]
        |axis: usize| {
            let half = factor * along[axis].select(one, -one);
            map(
                cloud.transform.clip_from_object,
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
            FaceCorner::new(at, middle[3], view.half_size)
        },
    );
    let near = corner([true, true, true]);
    // Away along one axis, and along all but one.
    let without = [corner([false, true, true]), corner([true, false, true]), corner([true, true, false])];
    let only = [corner([true, false, false]), corner([false, true, false]), corner([false, false, true])];
    // Where an odd number of axes point away from the eye, the sides' corners go round the other way.
    let is_turned = !(along[0] ^ along[1] ^ along[2]);
    let is_inside_out = inside_out(size_m, factor, begin);
    let mut place = inlined(
        #[inline(always)]
        |side: usize| {
            let (side, axis) = (&mut sides[side], AXES[side]);
            let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
            let lower_right = FaceCorner::select(is_turned, &without[next], &without[last]);
            let upper_left = FaceCorner::select(is_turned, &without[last], &without[next]);
            side.along |= (along[axis].to_bitmask() as u32) << begin;
            side.general |= is_inside_out;
            side.place::<_, PAINT>(lanes, [only[axis], lower_right, near, upper_left]);
        },
    );
    place(0);
    place(1);
    place(2);
}
