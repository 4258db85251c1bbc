//! Point clouds, drawn in three steps: choosing, placing, painting.
//!
//! ```text
//! choosing   choose    which points of a cloud may be seen, and the bands that they touch; the points of a band,
//!                      gathered in blocks; whether Ogre culls the whole cloud
//! placing    faces     what one point's face is: its corners in clip coordinates, as triangles
//!            place     the faces of a block on the picture, as quadrangles of a few pixels
//!            sprites   the round points of a block on the picture (and their painting, which is one colour)
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
//! [`triangles`](super::triangles) instead; the pixels are the same.

mod choose;
mod faces;
mod hiding;
mod paint;
mod place;
mod ranked;
mod rough;
mod small;
mod sprites;
#[cfg(test)]
mod tests;

use fearless_simd::dispatch;
use nalgebra::Matrix4;
use rcs_scene::{Camera, PointStyle, Points};

use self::choose::PointBlock;
use self::faces::Faces;
use self::hiding::InnerAreas;
use self::paint::{BOX_SIDE, DISC, EDGED, PLAIN};
use self::place::FaceBlock;
use self::rough::RoughFaces;
use super::band::Mode;
use super::band::{unorm8, Band};
use super::ranked::RankedScratch;
use super::screen::{ObjectTransform, Screen};
use super::surface::Surface;
use crate::shading::MAX_REJECTED_ALPHA;

/// Points of a block.
const BLOCK: usize = 32;

/// A cloud and all that is the same for its points.
#[derive(Clone, Debug)]
pub(super) struct Cloud<'a> {
    /// The scene's cloud.
    pub points: &'a Points,
    transform: ObjectTransform,
    faces: Faces<'a>,
    surface: Surface,
    camera: &'a Camera,
    fixed_from_object: &'a Matrix4<f64>,
    /// Ogre would not draw it.
    pub is_culled: bool,
    /// For each opacity of a colour that which is drawn; none where that is too faint.
    opacities: [Option<u8>; 256],
}

impl<'a> Cloud<'a> {
    /// A cloud at a pose, seen by a camera.
    pub(super) fn new(
        points: &'a Points,
        transform: ObjectTransform,
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
        Self { points, transform, faces, surface, camera, fixed_from_object, is_culled: false, opacities }
    }
}

impl Cloud<'_> {
    /// Whether its faces need not be drawn in their order.
    pub(super) fn can_be_ranked(&self) -> bool {
        let has_faces = match self.points.style {
            PointStyle::Points { .. } => false,
            PointStyle::Boxes { size_m } => !is_inside_out(size_m),
            _ => true,
        };
        has_faces && self.surface.mode == Mode::OPAQUE
    }
}

/// Boxes that a negative size turns inside out show other sides.
fn is_inside_out(size_m: [f32; 3]) -> bool {
    !size_m.iter().all(|side_m| *side_m >= 0.0)
}

/// Draws a band's rows of a cloud by the ranks of its points, given the indices of those that touch the band, by job.
pub(super) fn draw_ranked<'i>(
    cloud: &Cloud<'_>,
    indices: impl Fn(usize) -> &'i [u32],
    jobs: usize,
    screen: &Screen,
    scratch: &mut PointScratch,
    ranked: &mut RankedScratch,
    band: &mut Band<'_>,
) {
    if cloud.is_culled {
        return;
    }
    let Some(first_rank) = ranked.list_chunks(&indices, jobs, band) else {
        return (0..jobs).for_each(|job| draw(cloud, indices(job), screen, scratch, band));
    };
    let (eye, positions) = (cloud.faces.eye(), &cloud.points.buffer.positions);
    ranked.order_chunks(&indices, |_, index| match positions.get(index as usize) {
        Some([x, y, z]) => (x - eye[0]).powi(2) + (y - eye[1]).powi(2) + (z - eye[2]).powi(2),
        None => f32::INFINITY,
    });
    let run = ranked::Run { cloud, indices, first_rank };
    match cloud.points.style {
        PointStyle::Points { .. } => {}
        PointStyle::FlatSquares { .. } => run.draw::<{ PLAIN }>(screen, scratch, ranked, band),
        PointStyle::Squares { .. } | PointStyle::Tiles { .. } => run.draw::<{ EDGED }>(screen, scratch, ranked, band),
        PointStyle::Spheres { .. } => run.draw::<{ DISC }>(screen, scratch, ranked, band),
        PointStyle::Boxes { .. } => run.draw::<{ BOX_SIDE }>(screen, scratch, ranked, band),
    }
}

/// Whether something of this opacity is drawn at all; boxes are, whatever theirs is.
#[inline]
fn is_visible(alpha: f32) -> bool {
    alpha > MAX_REJECTED_ALPHA
}

/// Draws a band's rows of a cloud, given the indices of the points that touch the band.
pub(super) fn draw(
    cloud: &Cloud<'_>,
    indices: &[u32],
    screen: &Screen,
    scratch: &mut PointScratch,
    band: &mut Band<'_>,
) {
    if cloud.is_culled || indices.is_empty() {
        return;
    }
    match cloud.points.style {
        PointStyle::Points { .. } => {
            let points = &mut scratch.points;
            dispatch!(screen.simd_level, simd => sprites::draw(simd, cloud, indices, screen, points, band));
        }
        PointStyle::FlatSquares { .. } => paint_faces::<{ PLAIN }>(cloud, indices, screen, scratch, band),
        PointStyle::Squares { .. } | PointStyle::Tiles { .. } => {
            paint_faces::<{ EDGED }>(cloud, indices, screen, scratch, band);
        }
        PointStyle::Spheres { .. } => paint_faces::<{ DISC }>(cloud, indices, screen, scratch, band),
        PointStyle::Boxes { size_m } if is_inside_out(size_m) => {
            paint::draw_exactly(cloud, indices, screen, band);
        }
        PointStyle::Boxes { .. } => paint_faces::<{ BOX_SIDE }>(cloud, indices, screen, scratch, band),
    }
}

/// Draws faces of one kind. Each kind is compiled by itself: all of them in one function take minutes.
fn paint_faces<const PAINT: u8>(
    cloud: &Cloud<'_>,
    indices: &[u32],
    screen: &Screen,
    scratch: &mut PointScratch,
    band: &mut Band<'_>,
) {
    dispatch!(screen.simd_level, simd => paint::draw::<_, PAINT>(simd, cloud, indices, screen, scratch, band));
}

/// The memory in which a worker draws points.
#[derive(Debug)]
pub(super) struct PointScratch {
    /// A block's points.
    points: PointBlock,
    /// Their faces.
    faces: Box<[FaceBlock; place::SIDES]>,
    /// The pixels that surely are theirs.
    inner: [InnerAreas; place::SIDES],
    /// Their large faces.
    rough: RoughFaces,
}

impl Default for PointScratch {
    fn default() -> Self {
        Self {
            points: PointBlock::default(),
            faces: FaceBlock::of_boxes(),
            inner: Default::default(),
            rough: RoughFaces::default(),
        }
    }
}
