//! Point clouds: which points are to be seen, and in which bands.
//!
//! A first pass over all points of a cloud drops those that are surely outside of the view and finds the rows that
//! each of the others can touch, with a little to spare; the bands of these rows note the point's index. When a band
//! is drawn, its points are gathered again in blocks and drawn by [`round_points`](super::round_points) or
//! [`quads`](super::quads). So a cloud costs little more than 4 bytes a point, however it is drawn.
//!
//! Both passes keep the coordinates of a block of points apart (all x, all y, …), so that the compiler does several
//! points at once.

use std::ops::Range;

use fearless_simd::{dispatch, Simd};
use nalgebra::Matrix4;
use rcs_scene::{Camera, PointBuffer, PointStyle, Points};

use super::band::{pack, unorm8, Band};
use super::bins::Bins;
use super::faces::{is_visible, Faces};
use super::quad_paint::{DARK_EDGED, DISC, EDGED, PLAIN};
use super::quads::{self, Quads};
use super::round_points;
use super::screen::{Placement, Screen};
use super::surface::Surface;
use crate::bounds::Bounds;

/// Points of a block.
pub(super) const BLOCK: usize = 32;

/// A cloud and all that is the same for its points.
#[derive(Clone, Debug)]
pub(super) struct Cloud<'a> {
    /// What the scene says.
    pub points: &'a Points,
    /// Where it stands.
    pub placement: Placement,
    /// Its points' faces.
    pub faces: Faces<'a>,
    /// What they look like.
    pub surface: Surface,
    camera: &'a Camera,
    fixed_from_object: &'a Matrix4<f64>,
    /// It is not drawn.
    pub is_culled: bool,
    /// For each opacity of a colour that which is drawn; none where that is too faint.
    opacities: [Option<u8>; 256],
}

impl<'a> Cloud<'a> {
    /// A cloud at a place, seen by a camera.
    pub(super) fn new(
        points: &'a Points,
        placement: Placement,
        camera: &'a Camera,
        fixed_from_object: &'a Matrix4<f64>,
    ) -> Self {
        let faces = Faces::of(points, camera.eye_in_object(fixed_from_object));
        let is_box = matches!(points.style, PointStyle::Boxes { .. });
        let opacities = std::array::from_fn(|level| {
            let alpha = level as f32 / 255.0 * points.alpha;
            (is_box || is_visible(alpha)).then(|| unorm8(alpha))
        });
        let surface = faces.surface();
        Self { points, placement, faces, surface, camera, fixed_from_object, is_culled: false, opacities }
    }

    /// Sorts the points of a range that may be seen into the picture's bands.
    pub(super) fn select(&self, screen: &Screen, range: Range<usize>, out: &mut Bins) {
        dispatch!(screen.level, simd => self.select_by_lanes(simd, screen, range, out));
    }

    #[inline(always)]
    fn select_by_lanes<S: Simd>(&self, _: S, screen: &Screen, range: Range<usize>, out: &mut Bins) {
        let reach = Reach::of(self);
        let positions = self.points.buffer.positions.get(range.clone()).unwrap_or(&[]);
        let mut rows = [[0u32; BLOCK]; 2];
        let mut places = [[f32::NAN; BLOCK]; 3];
        for (positions, begin) in positions.chunks(BLOCK).zip(range.step_by(BLOCK)) {
            transpose(positions, &mut places);
            self.rows(screen, &reach, &places, &mut rows);
            let [first, after] = &rows;
            for (i, (first, after)) in first.iter().zip(after).take(positions.len()).enumerate() {
                out.add((begin + i) as u32, *first, *after);
            }
        }
    }

    /// Whether Ogre leaves the whole cloud out: it looks only at the box around the points' places, so that faces that
    /// reach into the view from outside are not seen where all places are off the same side of the view.
    ///
    /// `selected` are the points that may be seen; a place inside of the view settles the question at once.
    pub(super) fn lies_outside(&self, mut selected: impl Iterator<Item = u32>) -> bool {
        let positions = &self.points.buffer.positions;
        let outside = |position: [f32; 3]| {
            let [x, y, z, w] = self.placement.clip(position);
            [z < -w, z > w, x < -w, x > w, y < -w, y > w]
        };
        let is_inside =
            |index: u32| positions.get(index as usize).is_some_and(|position| outside(*position) == [false; 6]);
        if selected.any(is_inside) {
            return false;
        }
        let bounds = Bounds::around(positions);
        bounds.is_none_or(|bounds| !bounds.may_be_seen(self.camera, self.fixed_from_object))
    }

    #[inline(always)]
    fn rows(&self, screen: &Screen, reach: &Reach, places: &[[f32; BLOCK]; 3], rows: &mut [[u32; BLOCK]; 2]) {
        let [xs, ys, zs] = places;
        let m = &self.placement.clip_from_object;
        let height = screen.height_px as f32;
        for i in 0..BLOCK {
            let row = |r: [f32; 4]| r[0] * xs[i] + r[1] * ys[i] + r[2] * zs[i] + r[3];
            let (x, y, z, w) = (row(m[0]), row(m[1]), row(m[2]), row(m[3]));
            let factor = if self.points.auto_size { zs[i].abs() } else { 1.0 };
            let [rx, ry, rz, rw] = reach.clip.map(|r| r * factor);
            let (far_w, near_w) = (w + rw, w - rw);
            let inside = (z + rz >= -far_w) & (z - rz <= far_w) & (x - rx <= far_w) & (x + rx >= -far_w);
            // The smallest and the largest y over w, where w stays in front of the eye's plane.
            let (far, near) = (1.0 / far_w, 1.0 / near_w);
            let (low, high) = (y - ry, y + ry);
            let low = low * if low < 0.0 { near } else { far };
            let high = high * if high < 0.0 { far } else { near };
            let spare = reach.pixels + 0.01;
            let is_bounded = near_w > 1e-3 * w.abs();
            let first = if is_bounded { screen.y(high) - spare } else { 0.0 };
            let last = if is_bounded { screen.y(low) + spare } else { height };
            // To the rows whose centres lie between.
            let first = if first > 0.5 { first + 0.5 } else { 0.0 };
            let last = if last < height - 0.5 { (last + 0.5).max(0.0) } else { height };
            rows[0][i] = first as i32 as u32;
            rows[1][i] = if inside { last as i32 as u32 } else { 0 };
        }
    }
}

/// How far a point's faces or spot reach from its place, at most.
struct Reach {
    /// In clip coordinates, for a size factor of 1.
    clip: [f32; 4],
    /// On the picture.
    pixels: f32,
}

impl Reach {
    fn of(cloud: &Cloud<'_>) -> Self {
        let length = |v: [f32; 3]| v[0].hypot(v[1]).hypot(v[2]);
        if let Some(diameter_px) = round_points::diameter_px(cloud.points) {
            return Self { clip: [0.0; 4], pixels: diameter_px * 0.5 };
        }
        let radius_m = cloud.faces.reach_m();
        let clip = cloud.placement.clip_from_object.map(|row| length([row[0], row[1], row[2]]) * radius_m);
        Self { clip, pixels: 0.0 }
    }
}

/// All x, all y and all z of up to [`BLOCK`] places.
#[inline(always)]
fn transpose(positions: &[[f32; 3]], places: &mut [[f32; BLOCK]; 3]) {
    let [xs, ys, zs] = places;
    for (i, position) in positions.iter().enumerate().take(BLOCK) {
        (xs[i], ys[i], zs[i]) = (position[0], position[1], position[2]);
    }
}

/// Draws the rows of a band.
pub(super) fn draw(cloud: &Cloud<'_>, indices: &[u32], screen: &Screen, scratch: &mut Scratch, band: &mut Band<'_>) {
    if cloud.is_culled || indices.is_empty() {
        return;
    }
    dispatch!(screen.level, simd => draw_by_lanes(simd, cloud, indices, screen, scratch, band));
}

#[inline(always)]
fn draw_by_lanes<S: Simd>(
    simd: S,
    cloud: &Cloud<'_>,
    indices: &[u32],
    screen: &Screen,
    scratch: &mut Scratch,
    band: &mut Band<'_>,
) {
    match cloud.points.style {
        PointStyle::Points { .. } => round_points::draw(simd, cloud, indices, screen, &mut scratch.points, band),
        PointStyle::FlatSquares { .. } => {
            quads::draw::<S, { PLAIN }>(simd, cloud, indices, screen, scratch, band);
        }
        PointStyle::Squares { .. } | PointStyle::Tiles { .. } => {
            quads::draw::<S, { EDGED }>(simd, cloud, indices, screen, scratch, band);
        }
        PointStyle::Spheres { .. } => quads::draw::<S, { DISC }>(simd, cloud, indices, screen, scratch, band),
        // Of what is turned inside out, other sides are seen.
        PointStyle::Boxes { size_m } if !size_m.iter().all(|side_m| *side_m >= 0.0) => {
            quads::draw_exactly(cloud, indices, screen, band);
        }
        PointStyle::Boxes { .. } => {
            quads::draw::<S, { DARK_EDGED }>(simd, cloud, indices, screen, scratch, band);
        }
    }
}

/// What a worker keeps for drawing points.
#[derive(Debug)]
pub(super) struct Scratch {
    /// The points of a block.
    pub points: Gathered,
    /// Their faces.
    pub quads: Vec<Quads>,
}

impl Default for Scratch {
    fn default() -> Self {
        Self { points: Gathered::default(), quads: Quads::of_boxes() }
    }
}

/// A block of a cloud's points, gathered by their indices.
#[derive(Debug)]
pub(super) struct Gathered {
    /// How many there are.
    pub len: usize,
    /// Their indices.
    pub indices: [u32; BLOCK],
    /// Their places in the cloud's frame, all x, all y and all z.
    pub places: [[f32; BLOCK]; 3],
    /// Their colours, packed.
    pub colors: [u32; BLOCK],
}

impl Default for Gathered {
    fn default() -> Self {
        Self { len: 0, indices: [0; BLOCK], places: [[0.0; BLOCK]; 3], colors: [0; BLOCK] }
    }
}

impl Gathered {
    /// Replaces the content by up to [`BLOCK`] points; those that are too faint are left out.
    #[inline(always)]
    pub(super) fn gather(&mut self, cloud: &Cloud<'_>, indices: &[u32]) {
        let PointBuffer { positions, colors } = &*cloud.points.buffer;
        let mut count = 0;
        let [xs, ys, zs] = &mut self.places;
        for &index in indices.iter().take(BLOCK) {
            let Some(position) = positions.get(index as usize) else { continue };
            let [r, g, b, a] = colors.get(index as usize);
            let Some(opacity) = cloud.opacities[usize::from(a)] else { continue };
            // There are at most as many as there is room for.
            let i = count % BLOCK;
            self.indices[i] = index;
            (xs[i], ys[i], zs[i]) = (position[0], position[1], position[2]);
            self.colors[i] = pack([r, g, b, opacity]);
            count += 1;
        }
        self.len = count;
    }
}
