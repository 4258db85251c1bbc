//! Drawing a band's rows of a cloud, block by block.

use fearless_simd::{dispatch, Simd};
use rcs_scene::PointStyle;

use super::place::{place_faces, sides_of, BandView, FaceBlock, PointLanes, AXES};
use super::{sprites, Cloud, PointScratch, BLOCK};
use crate::cpu::paint::{BOX_SIDE, DISC, EDGED, PLAIN};
use crate::cpu::raster::quad::depth_bound;
use crate::cpu::raster::triangle;
use crate::cpu::tile::band::{Band, Mode};
use crate::cpu::tile::lanes::LANES;
use crate::cpu::tile::near_to_far::NearToFar;
use crate::cpu::tile::screen::{Area, Screen};

/// Points in the order of drawing.
#[derive(Debug, Default)]
pub(super) struct PointOrder {
    indices: Vec<u32>,
    ranks: Vec<u32>,
}

/// Draws a band's rows of a cloud by the ranks of its points, given the indices of those that touch the band, by job.
pub(in crate::cpu) fn draw_ranked(
    cloud: &Cloud<'_>,
    indices: &[&[u32]],
    screen: &Screen,
    (scratch, order): (&mut PointScratch, &mut NearToFar),
    band: &mut Band<'_>,
) {
    let (eye, positions) = (cloud.eye, &cloud.points.buffer.positions);
    let count = order.sort(indices, |_, index| match positions.get(index as usize) {
        Some([x, y, z]) => (x - eye[0]).powi(2) + (y - eye[1]).powi(2) + (z - eye[2]).powi(2),
        None => f32::INFINITY,
    });
    match band.begin_ranks(count) {
        Some(first) => {
            let PointOrder { indices: mut sorted, mut ranks } = std::mem::take(&mut scratch.order);
            sorted.clear();
            ranks.clear();
            for face in order.faces(indices) {
                sorted.push(face.number);
                ranks.push(first + face.rank);
            }
            draw(cloud, (&sorted, &ranks), screen, scratch, band);
            scratch.order = PointOrder { indices: sorted, ranks };
        }
        None => indices.iter().for_each(|indices| draw(cloud, (indices, &[]), screen, scratch, band)),
    }
    band.end_ranks();
}

/// Draws a band's rows of a cloud, given the indices of the points that touch the band, and their ranks where they have
/// some.
pub(in crate::cpu) fn draw(
    cloud: &Cloud<'_>,
    points: (&[u32], &[u32]),
    screen: &Screen,
    scratch: &mut PointScratch,
    band: &mut Band<'_>,
) {
    match cloud.points.style {
        PointStyle::Points { .. } => {
            dispatch!(screen.simd_level, simd => sprites::draw(simd, cloud, points.0, screen, scratch, band));
        }
        PointStyle::FlatSquares { .. } => draw_faces::<{ PLAIN }>(cloud, points, screen, scratch, band),
        PointStyle::Squares { .. } | PointStyle::Tiles { .. } => {
            draw_faces::<{ EDGED }>(cloud, points, screen, scratch, band);
        }
        PointStyle::Spheres { .. } => draw_faces::<{ DISC }>(cloud, points, screen, scratch, band),
        PointStyle::Boxes { .. } => draw_faces::<{ BOX_SIDE }>(cloud, points, screen, scratch, band),
    }
}

/// Draws faces of one kind. Each kind is compiled by itself: all of them in one function take minutes.
fn draw_faces<const PAINT: u8>(
    cloud: &Cloud<'_>,
    (indices, ranks): (&[u32], &[u32]),
    screen: &Screen,
    scratch: &mut PointScratch,
    band: &mut Band<'_>,
) {
    dispatch!(screen.simd_level, simd => {
        for (indices, begin) in indices.chunks(BLOCK).zip((0..).step_by(BLOCK)) {
            scratch.points.gather(cloud, indices, ranks.get(begin..).unwrap_or(&[]));
            draw_block::<_, PAINT>(simd, cloud, screen, scratch, band);
        }
    });
}

/// Draws the faces of a block.
#[inline(always)]
fn draw_block<S: Simd, const PAINT: u8>(
    simd: S,
    cloud: &Cloud<'_>,
    screen: &Screen,
    scratch: &mut PointScratch,
    band: &mut Band<'_>,
) {
    let PointScratch { points, faces, .. } = scratch;
    let view = BandView::new(screen, band);
    faces.iter_mut().take(sides_of::<PAINT>()).for_each(FaceBlock::clear);
    for begin in (0..points.len).step_by(LANES) {
        place_faces::<S, PAINT>(&PointLanes { simd, cloud, view: &view, points, begin }, faces);
    }
    let sides = &faces[..sides_of::<PAINT>()];
    let there = (!0u32).checked_shr(u32::BITS - points.len as u32).unwrap_or(0);
    let general = sides.iter().fold(0, |any, faces| any | faces.general) & there;
    let mut seen = sides.iter().fold(general, |any, faces| any | faces.small) & there;
    while seen != 0 {
        let i = seen.trailing_zeros() as usize;
        seen &= seen - 1;
        band.set_rank(points.ranks[i]);
        if general & 1 << i != 0 {
            draw_triangles(cloud, points.indices[i], screen, band);
            continue;
        }
        for (faces, axis) in sides.iter().zip(AXES) {
            if faces.small & 1 << i != 0 {
                draw_quad::<S, PAINT>(simd, cloud, faces, (i, axis, points.colors[i]), band);
            }
        }
    }
}

/// Draws the small face of a point: in its turn, or the tiles in which something of it may be seen.
#[inline(always)]
fn draw_quad<S: Simd, const PAINT: u8>(
    simd: S,
    cloud: &Cloud<'_>,
    faces: &FaceBlock,
    (i, axis, color): (usize, usize, u32),
    band: &mut Band<'_>,
) {
    let quad = faces.quad::<S, PAINT>(simd, i, axis, color);
    if !band.is_ranked() {
        // The most common mode as a constant.
        match cloud.surface.mode {
            Mode::OPAQUE => quad.draw(quad.area, Mode::OPAQUE, band),
            mode => quad.draw(quad.area, mode, band),
        };
        return;
    }
    let area = quad.area;
    band.draw_visible(
        simd,
        depth_bound(quad.depth, area, quad.first_row),
        area,
        #[inline(always)]
        |band, tile| {
            let pixels = Area { top: tile.top.max(area.top), bottom: tile.bottom.min(area.bottom), ..tile };
            quad.draw(pixels, Mode::OPAQUE, band)
        },
    );
}

/// Draws a point's faces as triangles: those that are too large for quadrangles, or cut by the near plane.
#[cold]
pub(in crate::cpu) fn draw_triangles(cloud: &Cloud<'_>, index: u32, screen: &Screen, band: &mut Band<'_>) {
    cloud.triangles(index as usize, |triangle| {
        triangle::cut(triangle, &cloud.surface, screen, |corners| {
            triangle::draw(corners.each_ref(), &cloud.surface, band);
        });
    });
}
