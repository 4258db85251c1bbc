//! Point clouds, drawn in three steps: choosing, placing, painting.
//!
//! ```text
//! choosing   choose    which points of a cloud may be seen, and the bands that they touch; the points of a band,
//!                      gathered in blocks; whether Ogre culls the whole cloud
//! placing    faces     what one point's face is: its corners in clip coordinates, as triangles
//!            place     the faces of a block on the image, as quadrangles of a few pixels
//!            sprites   the round points of a block on the image (and their painting, which is one colour)
//! painting   paint     the pixels of a block's quadrangles, with the colours of `shading`
//!            (triangles, in the folder above, paints faces that are too large for that)
//! ```
//!
//! **Choosing** is done twice. Before drawing, a pass over all points drops those that are surely outside of the view
//! and finds the rows that each of the others can touch, with a margin; the bands of these rows note the point's index.
//! So a cloud costs little more than 4 bytes a point, however it is drawn. When a band is drawn, its points are
//! gathered by their indices in blocks of [`BLOCK`], without those that are too faint.
//!
//! **Placing** projects a block's points and sets up what is linear in the window, several points at once; for that a
//! block keeps its coordinates apart (all x, all y, …). **Painting** goes over the pixels of one face after another,
//! several pixels at once. Faces that are large, cut by the near plane or turned to a line go as two triangles through
//! [`triangles`](crate::cpu::raster::triangle) instead; the pixels are the same.

mod choose;
mod draw;
mod faces;
mod place;
mod sprites;
#[cfg(test)]
mod tests;

use nalgebra::Point3;
use rcs_scene::{PointStyle, Points};

pub(in crate::cpu) use self::choose::BinnedPoints;
use self::choose::PointBlock;
use self::draw::PointOrder;
pub(in crate::cpu) use self::draw::{draw, draw_ranked};
use self::place::{FaceBlock, SIDES};
use self::sprites::SpriteBlock;
use crate::cpu::paint::Surface;
use crate::cpu::tile::band::{unorm8, Mode};
use crate::cpu::tile::screen::ObjectTransform;
use crate::shading::MAX_REJECTED_ALPHA;

/// Points of a block.
const BLOCK: usize = 32;

/// A cloud and all that is the same for its points.
#[derive(Clone, Debug)]
pub(in crate::cpu) struct Cloud<'a> {
    /// The scene's cloud.
    pub points: &'a Points,
    transform: ObjectTransform,
    /// The eye in the cloud's frame.
    eye: [f32; 3],
    surface: Surface,
    /// For each opacity of a colour that which is drawn; none where that is too faint.
    opacities: [Option<u8>; 256],
}

impl<'a> Cloud<'a> {
    /// A cloud at a pose, given the eye in its frame.
    pub(in crate::cpu) fn new(points: &'a Points, transform: ObjectTransform, eye: Point3<f32>) -> Self {
        let is_box = matches!(points.style, PointStyle::Boxes { .. });
        let opacities = std::array::from_fn(|level| {
            let alpha = level as f32 / 255.0 * points.alpha;
            (is_box || is_visible(alpha)).then(|| unorm8(alpha))
        });
        Self { points, transform, eye: eye.coords.into(), surface: faces::surface(points), opacities }
    }
}

impl Cloud<'_> {
    /// True if its faces need not be drawn in their order.
    pub(in crate::cpu) fn can_be_ranked(&self) -> bool {
        self.surface.mode == Mode::OPAQUE && !matches!(self.points.style, PointStyle::Points { .. })
    }
}

/// True if something of this opacity is drawn at all; boxes are, whatever theirs is.
#[inline]
fn is_visible(alpha: f32) -> bool {
    alpha > MAX_REJECTED_ALPHA
}

/// Scratch buffers of a worker that draws points.
#[derive(Debug)]
pub(in crate::cpu) struct PointScratch {
    /// A block's points.
    points: PointBlock,
    /// Their faces.
    faces: Box<[FaceBlock; SIDES]>,
    /// Their round points.
    sprites: SpriteBlock,
    order: PointOrder,
}

impl Default for PointScratch {
    fn default() -> Self {
        let (points, sprites, order) = (PointBlock::default(), SpriteBlock::default(), PointOrder::default());
        Self { points, faces: FaceBlock::of_boxes(), sprites, order }
    }
}
