//! Where large faces are, roughly: the pixels that they may touch, and a plane below all of their depths.
//!
//! Follows the arithmetic of [`faces`](super::faces) and [`triangles`](crate::cpu::triangles), for several points at
//! once, so that faces of constant depth have exactly the depth of their fragments.

use fearless_simd::prelude::*;
use fearless_simd::Simd;
use rcs_scene::PointStyle;

use super::faces::{cross, size_m, upright};
use super::place::{BandView, Batch, AXES};
use crate::cpu::clip::GUARD;
use crate::cpu::lanes::{inlined, load, map, store, transform, F, LANES, M};
use crate::cpu::occlusion::{Area, DepthPlane};
use crate::cpu::screen::FARTHEST;

/// Faces of a point: six of a box, else one.
const FACES: usize = 6;

/// The numbers of a batch's faces, side by side.
type Lanes = [f32; LANES];

/// One face of each point of a batch.
#[derive(Clone, Copy, Debug, Default)]
struct RoughFace {
    /// Bit i: the numbers hold for point i.
    known: u32,
    /// Bit i: it is surely seen from behind.
    back: u32,
    /// at, dx, dy, x, y, noise, least.
    plane: [Lanes; 7],
    /// left, right, top, bottom.
    bounds: [Lanes; 4],
}

/// All faces of a batch's points.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct RoughFaces {
    faces: [RoughFace; FACES],
}

impl RoughFaces {
    /// A face's plane and the pixels of the band that it may touch; none where they are not known.
    #[inline(always)]
    pub(super) fn face(&self, number: usize, lane: usize) -> Option<(DepthPlane, Area)> {
        let face = self.faces.get(number)?;
        if face.known & !face.back & 1 << lane == 0 {
            return None;
        }
        let [at, dx, dy, x, y, noise, least] = face.plane.each_ref().map(|all| all[lane]);
        let [left, right, top, bottom] = face.bounds.each_ref().map(|all| all[lane] as i32);
        Some((DepthPlane { at, dx, dy, x, y, noise, least }, Area { left, right, top, bottom }))
    }

    /// Whether a face may be seen from its front.
    #[inline(always)]
    pub(super) fn may_be_front(&self, number: usize, lane: usize) -> bool {
        self.faces.get(number).is_none_or(|face| face.back & 1 << lane == 0)
    }

    /// Sets up a batch's faces, in the order in which [`faces`](super::faces) makes them.
    ///
    /// In a function of its own, compiled for the same instructions: it is long, and the same for each kind of face.
    #[inline(never)]
    pub(super) fn set_up<S: Simd>(&mut self, batch: &Batch<'_, S>) {
        batch.simd.vectorize(
            #[inline(always)]
            || self.set_up_by_lanes(batch),
        );
    }

    #[inline(always)]
    fn set_up_by_lanes<S: Simd>(&mut self, batch: &Batch<'_, S>) {
        let Batch { simd, cloud, view, points, begin } = *batch;
        let [x, y, z] = &points.positions;
        let position = [load(simd, x, begin), load(simd, y, begin), load(simd, z, begin)];
        let factor = if cloud.points.auto_size { position[2] } else { F::splat(simd, 1.0) };
        let m = &cloud.transform.clip_from_object;
        let center = transform(m, position);
        match cloud.points.style {
            PointStyle::Boxes { size_m } => {
                let axes = map(
                    [0, 1, 2],
                    #[inline(always)]
                    |axis: usize| {
                        let half = factor * size_m[axis] * 0.5;
                        map(
                            *m,
                            #[inline(always)]
                            |row| half * row[axis],
                        )
                    },
                );
                for (i, axis) in AXES.into_iter().enumerate() {
                    let (normal, u, v) = (axes[axis], axes[(axis + 1) % 3], axes[(axis + 2) % 3]);
                    let (mut near, mut far) = (center, center);
                    for k in 0..4 {
                        (near[k], far[k]) = (center[k] + normal[k], center[k] - normal[k]);
                    }
                    self.faces[2 * i] = RoughFace::new(simd, near, u, v, view, true);
                    self.faces[2 * i + 1] = RoughFace::new(simd, far, v, u, view, true);
                }
            }
            PointStyle::Tiles { size_m, normal, up } => {
                let along = inlined(
                    #[inline(always)]
                    |[x, y, z]: [f32; 3], length: f32| {
                        map(
                            *m,
                            #[inline(always)]
                            |row| F::splat(simd, (row[0] * x + row[1] * y + row[2] * z) * length),
                        )
                    },
                );
                let (right, up) = (along(cross(up, normal), size_m[0] * 0.5), along(up, size_m[1] * 0.5));
                self.faces[0] = RoughFace::new(simd, center, right, up, view, false);
            }
            style => {
                let [width, height] = size_m(style);
                let half = [factor * width * 0.5, factor * height * 0.5];
                let eye = cloud.faces.eye();
                let towards_eye = [eye[0] - position[0], eye[1] - position[1], eye[2] - position[2]];
                let ([right_x, right_z], up) = upright(towards_eye, half);
                let right = map(
                    *m,
                    #[inline(always)]
                    |row| right_x * row[0] + right_z * row[2],
                );
                let up = map(
                    *m,
                    #[inline(always)]
                    |row| up[0] * row[0] + up[1] * row[1] + up[2] * row[2],
                );
                self.faces[0] = RoughFace::new(simd, center, right, up, view, true);
            }
        }
    }
}

/// A corner on the picture.
#[derive(Clone, Copy)]
struct Corner<S: Simd> {
    x: F<S>,
    y: F<S>,
    depth: F<S>,
    is_whole: M<S>,
}

impl<S: Simd> Corner<S> {
    #[inline(always)]
    fn new([x, y, z, w]: [F<S>; 4], (half_width, half_height): (f32, f32)) -> Self {
        let inverse_w = 1.0 / w;
        let guard = w * GUARD;
        Self {
            // From the first pixel's centre.
            x: (x * inverse_w) * half_width + (half_width - 0.5),
            y: (y * inverse_w) * -half_height + (half_height - 0.5),
            depth: ((z * inverse_w) * 0.5 + 0.5) * FARTHEST,
            is_whole: z.abs().simd_le(w) & x.abs().simd_lt(guard) & y.abs().simd_lt(guard),
        }
    }
}

impl RoughFace {
    #[inline(always)]
    fn new<S: Simd>(
        simd: S,
        middle: [F<S>; 4],
        right: [F<S>; 4],
        up: [F<S>; 4],
        view: &BandView,
        is_one_sided: bool,
    ) -> Self {
        let corner = inlined(
            #[inline(always)]
            |is_right: bool, is_up: bool| {
                let mut at = middle;
                for i in 0..4 {
                    at[i] = if is_right { at[i] + right[i] } else { at[i] - right[i] };
                    at[i] = if is_up { at[i] + up[i] } else { at[i] - up[i] };
                }
                Corner::new(at, view.half_size)
            },
        );
        let (a, b, c, d) = (corner(false, false), corner(true, false), corner(false, true), corner(true, true));
        let is_whole = a.is_whole & b.is_whole & c.is_whole & d.is_whole;
        let (bx, by, cx, cy) = (b.x - a.x, b.y - a.y, c.x - a.x, c.y - a.y);
        let (dx, dy) = (d.x - a.x, d.y - a.y);
        let spread = bx * cy - by * cx;
        let (low_x, high_x) = (a.x.min(b.x).min(c.x.min(d.x)), a.x.max(b.x).max(c.x.max(d.x)));
        let (low_y, high_y) = (a.y.min(b.y).min(c.y.min(d.y)), a.y.max(b.y).max(c.y.max(d.y)));
        let reach = (high_x - low_x) + (high_y - low_y);
        // Of a face that is nearly turned to a line, neither its side nor its plane is certain.
        let is_thick = spread.abs().simd_gt(reach + 1.0);
        let other = (d.x - b.x) * (c.y - b.y) - (d.y - b.y) * (c.x - b.x);
        let mut back = M::splat(simd, false);
        if is_one_sided {
            // Window y points down. Both triangles, the second of which could be turned only beside the eye.
            back = is_thick & is_whole & spread.simd_gt(reach + 1.0) & other.simd_gt(reach + 1.0);
        }
        let per_spread = 1.0 / spread;
        let (to_b, to_c) = (b.depth - a.depth, c.depth - a.depth);
        let slope_x = (to_b * cy - to_c * by) * per_spread;
        let slope_y = (to_c * bx - to_b * cx) * per_spread;
        let zero = F::splat(simd, 0.0);
        // How far a corner lies before the plane through the first one.
        let before = zero
            .min(to_b - (slope_x * bx + slope_y * by))
            .min(to_c - (slope_x * cx + slope_y * cy))
            .min(d.depth - a.depth - (slope_x * dx + slope_y * dy));
        let is_level = to_b.simd_eq(0.0) & to_c.simd_eq(0.0) & d.depth.simd_eq(a.depth);
        let slopes = slope_x.abs() + slope_y.abs();
        // Rounding to steps of depth, over the whole picture, and to the subpixels.
        let sum = slopes * (view.half_size.0.max(view.half_size.1) * 2.0) + FARTHEST;
        let noise = sum * (1.0 / (1 << 22) as f32) + slopes * (1.0 / 128.0);
        let noise = is_level.select(zero, noise);
        let least = a.depth.min(b.depth).min(c.depth.min(d.depth));
        let greatest = a.depth.max(b.depth).max(c.depth.max(d.depth));
        let margin = 1.0 / 64.0;
        let left = (low_x - margin).ceil().max(0.0);
        let right = ((high_x + margin).floor() + 1.0).min(view.width_px);
        let top = (low_y - margin).ceil().max(view.rows[0]);
        let bottom = ((high_y + margin).floor() + 1.0).min(view.rows[1]);
        // Both at the corners and at the pixels of the area.
        let x = slope_x.simd_lt(0.0).select(right - 1.0, left) - a.x;
        let y = slope_y.simd_lt(0.0).select(bottom - 1.0, top) - a.y;
        let least = (least - (greatest - least) * (1.0 / 1024.0)).max(a.depth + before + (slope_x * x + slope_y * y));
        let least = least - noise;
        let mut face = Self { back: back.to_bitmask() as u32, ..Self::default() };
        face.known = (is_thick & is_whole).to_bitmask() as u32;
        for (all, value) in face.plane.iter_mut().zip([a.depth + before, slope_x, slope_y, a.x, a.y, noise, least]) {
            store(all, 0, value);
        }
        for (all, value) in face.bounds.iter_mut().zip([left, right, top, bottom]) {
            store(all, 0, value);
        }
        face
    }
}
