//! Painting a block's faces: the pixels of small quadrangles, several at once.
//!
//! The colours are those of [`surface`](crate::cpu::surface) for the paints that clouds have, by the same formulas of
//! [`shading`](crate::shading), over places that are linear in the window once they are divided by w.

use fearless_simd::prelude::*;
use fearless_simd::Simd;
use rcs_scene::PointStyle;

use super::place::{
    place_boxes, place_tiles, place_upright, BandView, Batch, FaceBlock, Plane, Quads, AXES, DEPTH, EDGES, PLACE, SIDES,
};
use super::{Cloud, PointScratch, BLOCK};
use crate::cpu::band::{channel_shift, pack, Band};
use crate::cpu::lanes::{lane_indices, map, Floats, F, I, LANES, M, U};
use crate::cpu::screen::Screen;
use crate::cpu::triangles;
use crate::shading::{
    box_brightness, disc_brightness, edge_contrast, inside, with_edge, BOX_SIDES_AGAINST, BOX_SIDES_ALONG,
    DISC_RADIUS_SQUARED,
};

/// One colour.
pub(super) const PLAIN: u8 = 0;
/// One colour with a contrasting edge.
pub(super) const EDGED: u8 = 1;
/// One colour with a dark edge: a box's side.
pub(super) const BOX_SIDE: u8 = 2;
/// A disc, darker to its rim.
pub(super) const DISC: u8 = 3;

/// Draws a band's rows of a cloud.
#[inline(always)]
pub(super) fn draw<S: Simd, const PAINT: u8>(
    simd: S,
    cloud: &Cloud<'_>,
    indices: &[u32],
    screen: &Screen,
    scratch: &mut PointScratch,
    band: &mut Band<'_>,
) {
    let PointScratch { points, faces, .. } = scratch;
    let view = BandView {
        width_px: screen.width_px as f32,
        rows: [band.first_row as f32, band.end_row as f32],
        half_size: screen.half_size(),
    };
    for indices in indices.chunks(BLOCK) {
        points.gather(cloud, indices);
        faces.iter_mut().take(sides_of::<PAINT>()).for_each(FaceBlock::clear);
        for begin in (0..points.len).step_by(LANES) {
            let batch = Batch { simd, cloud, view: &view, points, begin };
            let quads = place_faces::<S, PAINT>(&batch, faces);
            for side in 0..sides_of::<PAINT>() {
                if (faces[side].small >> begin) & ((1 << LANES) - 1) != 0 {
                    faces[side].trace(simd, &quads[side], begin);
                }
            }
        }
        let sides = &faces[..sides_of::<PAINT>()];
        let there = (!0u32).checked_shr(u32::BITS - points.len as u32).unwrap_or(0);
        let general = sides.iter().fold(0, |any, faces| any | faces.general) & there;
        let mut seen = sides.iter().fold(general, |any, faces| any | faces.small) & there;
        while seen != 0 {
            let i = seen.trailing_zeros() as usize;
            seen &= seen - 1;
            if general & 1 << i != 0 {
                draw_triangles(cloud, points.indices[i], screen, band);
                continue;
            }
            for (faces, axis) in sides.iter().zip(AXES) {
                if faces.small & 1 << i != 0 {
                    draw_face::<S, PAINT>(simd, cloud, faces, i, axis, points.colors[i], band);
                }
            }
        }
    }
}

/// How many faces of a point may be seen.
pub(super) const fn sides_of<const PAINT: u8>() -> usize {
    if PAINT == BOX_SIDE {
        SIDES
    } else {
        1
    }
}

/// Places a batch's faces, so many of a point as there [may be seen](sides_of).
#[inline(always)]
pub(super) fn place_faces<S: Simd, const PAINT: u8>(
    batch: &Batch<'_, S>,
    faces: &mut [FaceBlock; SIDES],
) -> [Quads<S>; SIDES] {
    if PAINT == BOX_SIDE {
        return place_boxes(batch, faces);
    }
    let [faces, ..] = faces;
    let quads = match batch.cloud.points.style {
        PointStyle::Tiles { .. } => place_tiles(batch, faces),
        _ => place_upright(batch, PAINT != PLAIN, faces),
    };
    [quads; SIDES]
}

/// Draws a band's rows of a cloud as triangles.
pub(super) fn draw_exactly(cloud: &Cloud<'_>, indices: &[u32], screen: &Screen, band: &mut Band<'_>) {
    for &index in indices {
        draw_triangles(cloud, index, screen, band);
    }
}

#[cold]
fn draw_triangles(cloud: &Cloud<'_>, index: u32, screen: &Screen, band: &mut Band<'_>) {
    cloud.faces.triangles(&cloud.transform, index as usize, !0, |triangle| {
        triangles::cut(triangle, &cloud.surface, screen, |corners| {
            triangles::draw(corners.each_ref(), &cloud.surface, band);
        });
    });
}

#[inline(always)]
fn draw_face<S: Simd, const PAINT: u8>(
    simd: S,
    cloud: &Cloud<'_>,
    faces: &FaceBlock,
    i: usize,
    axis: usize,
    color: u32,
    band: &mut Band<'_>,
) {
    let [left, right, top, bottom] = faces.bounds.each_ref().map(|all| all[i]);
    let edges = [faces.edge(0, i), faces.edge(1, i), faces.edge(2, i), faces.edge(3, i)];
    let [depth, depth_right, depth_down] = faces.plane(DEPTH, i);
    let places = [faces.plane(PLACE, i), faces.plane(PLACE + 1, i), faces.plane(PLACE + 2, i)];
    let paint = FacePaint::<S, PAINT>::new(simd, color, axis, faces.along & 1 << i != 0);
    let mode = cloud.surface.mode;
    let rows_above = top - faces.first_rows[i];
    for begin in (left..right).step_by(LANES) {
        let columns = lane_indices(simd) + (begin - left);
        let mut edges_at = map(
            edges,
            #[inline(always)]
            |[at, dx, dy]| columns * dx + (at + dy * rows_above),
        );
        let columns = columns.to_float::<F<S>>();
        let from_first = columns * depth_right;
        let mut row = rows_above as f32;
        let first_places = first_row_of::<S, _, PAINT>(places, columns);
        band.for_windows(
            top..bottom,
            begin,
            #[inline(always)]
            |window| {
                let [e0, e1, e2, e3] = edges_at;
                let mask = ((e0 | e1) | (e2 | e3)).simd_ge(I::splat(simd, 0));
                window.meet(
                    mask,
                    // A depth's steps are whole numbers: fractions would be lost in sums with it.
                    (from_first + depth_down * row) + depth,
                    mode,
                    #[inline(always)]
                    |seen| {
                        let places_at = in_row::<S, _, PAINT>(first_places, places, F::splat(simd, row));
                        (paint.mask(places_at, seen), paint.colors(places_at))
                    },
                );
                for k in 0..EDGES {
                    edges_at[k] += edges[k][2];
                }
                row += 1.0;
            },
        );
    }
}

/// The places of a face's pixels in its first row, for faces whose colour depends on them.
#[inline(always)]
pub(super) fn first_row_of<S: Simd, T: Floats<S>, const PAINT: u8>(places: [Plane<f32>; 3], columns: T) -> [T; 3] {
    if PAINT == PLAIN {
        return [columns; 3];
    }
    map(
        places,
        #[inline(always)]
        |[at, dx, _]| columns * dx + at,
    )
}

/// As [`first_row_of`], so many rows below.
#[inline(always)]
pub(super) fn in_row<S: Simd, T: Floats<S>, const PAINT: u8>(first: [T; 3], places: [Plane<f32>; 3], row: T) -> [T; 3] {
    if PAINT == PLAIN {
        return first;
    }
    let mut at = first;
    for k in 0..3 {
        at[k] = first[k] + row * places[k][2];
    }
    at
}

/// Which of the places given by 1/w, u/w and v/w lie in their disc.
#[inline(always)]
pub(super) fn in_disc<S: Simd, T: Floats<S>>([q, u, v]: [T; 3]) -> T::Mask {
    (u * u + v * v).simd_lt(q * q * DISC_RADIUS_SQUARED)
}

/// How a face is painted.
pub(super) struct FacePaint<S: Simd, const PAINT: u8> {
    packed: U<S>,
    /// 0 to 255, with a box's side's brightness.
    rgb: [f32; 3],
    /// 0 to 255.
    contrast: f32,
}

impl<S: Simd, const PAINT: u8> FacePaint<S, PAINT> {
    /// For a face of a packed colour; of a box it is the side along or against an axis.
    #[inline(always)]
    pub(super) fn new(simd: S, color: u32, axis: usize, is_along: bool) -> Self {
        if PAINT == PLAIN {
            return Self { packed: U::splat(simd, color), rgb: [0.0; 3], contrast: 0.0 };
        }
        let [r, g, b, a] = color.to_ne_bytes();
        let packed = U::splat(simd, pack([0, 0, 0, a]));
        let brightness = match (PAINT == BOX_SIDE, is_along) {
            (false, _) => 1.0,
            (true, true) => BOX_SIDES_ALONG[axis],
            (true, false) => BOX_SIDES_AGAINST[axis],
        };
        let rgb = [f32::from(r) * brightness, f32::from(g) * brightness, f32::from(b) * brightness];
        let contrast = if PAINT == EDGED {
            let [r, g, b] = rgb.map(|c| c / 255.0);
            edge_contrast(r, g, b) * 255.0
        } else {
            0.0
        };
        Self { packed, rgb, contrast }
    }

    /// Which of the places given by 1/w, u/w and v/w belong to the face.
    #[inline(always)]
    pub(super) fn mask(&self, places: [F<S>; 3], mask: M<S>) -> M<S> {
        if PAINT == DISC {
            mask & in_disc(places)
        } else {
            mask
        }
    }

    /// The colours at places given by 1/w, u/w and v/w.
    #[inline(always)]
    pub(super) fn colors(&self, [q, u, v]: [F<S>; 3]) -> U<S> {
        if PAINT == PLAIN {
            return self.packed;
        }
        let w = 1.0 / q;
        let [r, g, b] = match PAINT {
            EDGED => {
                let inside = inside(u * w, v * w);
                let contrast = F::splat(q.token(), self.contrast);
                map(
                    self.rgb,
                    #[inline(always)]
                    |level| with_edge(F::splat(q.token(), level), contrast, inside).max(0.0).min(255.0),
                )
            }
            _ => {
                let brightness = if PAINT == DISC {
                    disc_brightness((u * u + v * v) / (q * q))
                } else {
                    box_brightness(inside(u * w, v * w))
                };
                map(
                    self.rgb,
                    #[inline(always)]
                    |level| brightness * level,
                )
            }
        };
        self.packed | in_channel(r, 0) | in_channel(g, 1) | in_channel(b, 2)
    }
}

/// Levels of 0 to 255, to the nearest whole number, at the place that a channel has in a packed colour.
#[inline(always)]
fn in_channel<S: Simd>(level: F<S>, channel: usize) -> U<S> {
    // At 2^23 there is no fraction left, so that the sum is rounded and its lowest byte is the whole number. The next
    // two are zero, and the first is shifted out of the number where the last is shifted at all.
    const NO_FRACTION: f32 = 8_388_608.0;
    let bits = (level + NO_FRACTION).bitcast::<U<S>>();
    match channel_shift(channel) {
        0 => bits & 255,
        shift => bits << shift,
    }
}
