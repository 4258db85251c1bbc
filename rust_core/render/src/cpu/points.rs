//! Point clouds, before they are pixels: projecting the points and dropping those that are not to be seen.
//!
//! Points are projected in blocks whose coordinates stand apart (all x, all y, …), so that the compiler can do several
//! at once.

use rcs_scene::{PointBuffer, Points};

use super::band::Mode;
use super::faces::is_visible;
use super::screen::{depth24, Placement, Screen};

/// Points of a block.
pub(super) const BLOCK: usize = 64;

/// Projected points.
#[derive(Debug)]
pub(super) struct Block {
    /// Window x of the centre.
    pub x: [f32; BLOCK],
    /// Window y of the centre.
    pub y: [f32; BLOCK],
    /// Depth of the centre.
    pub depth: [u32; BLOCK],
    /// Whether the centre lies between the near and the far plane, and not far outside of the picture's sides.
    pub inside: [bool; BLOCK],
}

impl Default for Block {
    fn default() -> Self {
        Self { x: [0.0; BLOCK], y: [0.0; BLOCK], depth: [0; BLOCK], inside: [false; BLOCK] }
    }
}

impl Block {
    /// Projects up to [`BLOCK`] points. `side_limit` is how far outside of the picture a centre may lie, in w.
    pub(super) fn project(&mut self, cloud: &Cloud<'_>, screen: &Screen, positions: &[[f32; 3]], side_limit: f32) {
        let mut places = [[0.0f32; BLOCK]; 3];
        let [px, py, pz] = &mut places;
        for (i, position) in positions.iter().enumerate().take(BLOCK) {
            (px[i], py[i], pz[i]) = (position[0], position[1], position[2]);
        }
        let rows = &cloud.placement.clip_from_object;
        for i in 0..BLOCK {
            let row = |r: [f32; 4]| r[0] * px[i] + r[1] * py[i] + r[2] * pz[i] + r[3];
            let (x, y, z, w) = (row(rows[0]), row(rows[1]), row(rows[2]), row(rows[3]));
            let inverse_w = 1.0 / w;
            self.x[i] = screen.x(x * inverse_w);
            self.y[i] = screen.y(y * inverse_w);
            self.depth[i] = depth24(z * inverse_w * 0.5 + 0.5);
            let side = side_limit * w;
            self.inside[i] = (w > 0.0) & (z >= -w) & (z <= w) & (x.abs() <= side) & (y.abs() <= side);
        }
    }
}

/// A cloud and all that is the same for its points.
#[derive(Clone, Debug)]
pub(super) struct Cloud<'a> {
    /// What the scene says.
    pub points: &'a Points,
    /// Where it stands.
    pub placement: Placement,
    /// How its fragments meet the pixels.
    pub mode: Mode,
}

impl<'a> Cloud<'a> {
    /// A cloud at a place.
    pub(super) fn new(points: &'a Points, placement: Placement) -> Self {
        Self { points, placement, mode: Mode::new(points.blended) }
    }

    /// Its points.
    pub(super) fn buffer(&self) -> &'a PointBuffer {
        &self.points.buffer
    }

    /// The colour of a point with the cloud's opacity applied; `None` where it is too faint to be drawn.
    #[inline]
    pub(super) fn color(&self, index: usize) -> Option<[u8; 4]> {
        let [r, g, b, a] = self.buffer().colors.get(index);
        let alpha = f32::from(a) / 255.0 * self.points.alpha;
        is_visible(alpha).then(|| [r, g, b, super::band::unorm8(alpha)])
    }
}
