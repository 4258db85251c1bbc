//! Choosing points: which ones may be seen, and in which bands.
//!
//! See the [module above](super) for how this is used.

use std::ops::Range;

use fearless_simd::{dispatch, Simd};
use nalgebra::Matrix4;
use rcs_scene::{Aabb, Camera, InFrustum, PointBuffer};

use super::faces::diameter_px;
use super::{Cloud, BLOCK};
use crate::cpu::tile::band::pack;
use crate::cpu::tile::bins::Bins;
use crate::cpu::tile::near_to_far::Load;
use crate::cpu::tile::screen::Screen;

/// Points of a cloud, sorted into bands.
#[derive(Debug, Default)]
pub(in crate::cpu) struct BinnedPoints {
    /// Their indices.
    pub bins: Bins,
    /// The amount that is to be drawn.
    pub load: Load,
}

impl Cloud<'_> {
    /// Sorts the points of a range that may be seen into the image's bands.
    pub(in crate::cpu) fn select(&self, screen: &Screen, range: Range<usize>, out: &mut BinnedPoints) {
        out.bins.reset(screen);
        out.load = dispatch!(screen.simd_level, simd => self.select_by_lanes(simd, screen, range, &mut out.bins));
    }

    #[inline(always)]
    fn select_by_lanes<S: Simd>(&self, _: S, screen: &Screen, range: Range<usize>, out: &mut Bins) -> Load {
        let mut load = Load::default();
        // The farthest that a point's faces or disc reach from its position, and a margin.
        let extent = (self.clip_extent(), diameter_px(self.points).unwrap_or(0.0) * 0.5 + 0.01);
        let positions = self.points.buffer.positions.get(range.clone()).unwrap_or(&[]);
        let mut rows = [[0u32; BLOCK]; 2];
        let mut coordinates = [[f32::NAN; BLOCK]; 3];
        for (positions, begin) in positions.chunks(BLOCK).zip(range.step_by(BLOCK)) {
            transpose(positions, &mut coordinates);
            self.rows(screen, extent, &coordinates, &mut rows);
            let [first, after] = &rows;
            // About as wide as high.
            let pixels = first.iter().zip(after).take(positions.len()).map(|(first, after)| {
                let height = after.saturating_sub(*first);
                (height.wrapping_mul(height), u32::from(height != 0))
            });
            let (pixels, faces) = pixels.fold((0, 0), |(pixels, faces), (p, f)| (pixels + u64::from(p), faces + f));
            load = load.and(Load { pixels, faces: u64::from(faces), in_order: false });
            for (i, (first, after)) in first.iter().zip(after).take(positions.len()).enumerate() {
                out.add((begin + i) as u32, *first, *after);
            }
        }
        load
    }

    /// True if Ogre culls the whole cloud: it tests only the box around the points' positions, so that faces that reach
    /// into the view from outside are not seen where all positions are off the same side of the view.
    ///
    /// A position inside of the view settles the question at once.
    pub(in crate::cpu) fn lies_outside(&self, camera: &Camera, fixed_from_object: &Matrix4<f64>) -> bool {
        let positions = &self.points.buffer.positions;
        let is_inside = |position: &[f32; 3]| {
            let [x, y, z, w] = self.transform.clip(*position);
            x.abs() <= w && y.abs() <= w && z.abs() <= w
        };
        // A few from everywhere first: a depth camera's upper rows may all be above the view.
        if positions.iter().step_by(1024).chain(positions).any(is_inside) {
            return false;
        }
        let clip_from_fixed = camera.clip_from_view() * camera.fixed_from_view().inverse().to_homogeneous();
        // The box lies along the fixed frame's axes.
        let bounds = Aabb::around(positions.iter().copied()).map(|bounds| bounds.transformed(fixed_from_object));
        bounds.is_none_or(|bounds| bounds.in_frustum(&clip_from_fixed, 0.0) == InFrustum::Outside)
    }

    #[inline(always)]
    fn rows(
        &self,
        screen: &Screen,
        (extent, margin_px): ([f32; 4], f32),
        coordinates: &[[f32; BLOCK]; 3],
        rows: &mut [[u32; BLOCK]; 2],
    ) {
        let [xs, ys, zs] = coordinates;
        let m = &self.transform.clip_from_object;
        let height = screen.height_px as f32;
        for i in 0..BLOCK {
            let row = |r: [f32; 4]| r[0] * xs[i] + r[1] * ys[i] + r[2] * zs[i] + r[3];
            let (x, y, z, w) = (row(m[0]), row(m[1]), row(m[2]), row(m[3]));
            let factor = if self.points.auto_size { zs[i].abs() } else { 1.0 };
            let [rx, ry, rz, rw] = extent.map(|r| r * factor);
            let (far_w, near_w) = (w + rw, w - rw);
            let inside = (z + rz >= -far_w) & (z - rz <= far_w) & (x - rx <= far_w) & (x + rx >= -far_w);
            // The smallest and the largest y over w, where w stays in front of the eye's plane.
            let (far, near) = (1.0 / far_w, 1.0 / near_w);
            let (low, high) = (y - ry, y + ry);
            let low = low * if low < 0.0 { near } else { far };
            let high = high * if high < 0.0 { far } else { near };
            let is_bounded = near_w > 1e-3 * w.abs();
            let first = if is_bounded { screen.y(high) - margin_px } else { 0.0 };
            let last = if is_bounded { screen.y(low) + margin_px } else { height };
            // To the rows whose centres lie between.
            let first = if first > 0.5 { first + 0.5 } else { 0.0 };
            let last = if last < height - 0.5 { (last + 0.5).max(0.0) } else { height };
            rows[0][i] = first as i32 as u32;
            rows[1][i] = if inside { last as i32 as u32 } else { 0 };
        }
    }
}

/// All x, all y and all z of up to [`BLOCK`] positions.
#[inline(always)]
fn transpose(positions: &[[f32; 3]], coordinates: &mut [[f32; BLOCK]; 3]) {
    let [xs, ys, zs] = coordinates;
    for (i, position) in positions.iter().enumerate().take(BLOCK) {
        (xs[i], ys[i], zs[i]) = (position[0], position[1], position[2]);
    }
}

/// A block of a cloud's points, gathered by their indices.
#[derive(Debug)]
pub(in crate::cpu) struct PointBlock {
    /// Their number.
    pub len: usize,
    /// Their indices.
    pub indices: [u32; BLOCK],
    /// Their ranks, where they are drawn by these.
    pub ranks: [u32; BLOCK],
    /// Their positions in the cloud's frame, all x, all y and all z.
    pub positions: [[f32; BLOCK]; 3],
    /// Their colours, packed.
    pub colors: [u32; BLOCK],
}

impl Default for PointBlock {
    fn default() -> Self {
        Self { len: 0, indices: [0; BLOCK], ranks: [0; BLOCK], positions: [[0.0; BLOCK]; 3], colors: [0; BLOCK] }
    }
}

impl PointBlock {
    /// Replaces the content by up to [`BLOCK`] points, without those that are too faint. `ranks` are their ranks, or
    /// empty.
    #[inline(always)]
    pub(in crate::cpu) fn gather(&mut self, cloud: &Cloud<'_>, indices: &[u32], ranks: &[u32]) {
        let PointBuffer { positions, colors } = &*cloud.points.buffer;
        let mut count = 0;
        let [xs, ys, zs] = &mut self.positions;
        for (place, &index) in indices.iter().take(BLOCK).enumerate() {
            let Some(position) = positions.get(index as usize) else { continue };
            let [r, g, b, a] = colors.get(index as usize);
            let Some(opacity) = cloud.opacities[usize::from(a)] else { continue };
            // There are at most as many as there is room for.
            let i = count % BLOCK;
            (self.indices[i], self.ranks[i]) = (index, ranks.get(place).copied().unwrap_or_default());
            (xs[i], ys[i], zs[i]) = (position[0], position[1], position[2]);
            self.colors[i] = pack([r, g, b, opacity]);
            count += 1;
        }
        self.len = count;
    }
}
