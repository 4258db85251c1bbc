//! Filling triangles: the fragments of large ones, several at once, with the arithmetic of
//! [`triangles`](super::triangles).

use fearless_simd::prelude::*;
use fearless_simd::Simd;

use super::band::{channel_shift, pack, unorm8, Band};
use super::edges::Edge;
use super::lanes::{lane_indices, map, F, I, LANES, M, U};
use super::occlusion::{rounding, Area, DepthPlane, Drawn, Occluders, SeenTiles, TILE_PX};
use super::screen::{FARTHEST, SUBPIXELS};
use super::surface::{Paint, Surface};
use super::triangles::{Plane, Planes};
use crate::shading::{box_brightness, disc_brightness, edge_contrast, inside, with_edge, DISC_RADIUS_SQUARED};

/// Whether a surface's fragments can be made here. Textures and cells are looked up pixel by pixel.
#[inline]
pub(super) fn can_fill(surface: &Surface) -> bool {
    matches!(surface.paint, Paint::Color | Paint::Edged | Paint::BoxSide | Paint::Disc)
}

/// A triangle with all that its fragments need.
pub(super) struct Fill<'a, S: Simd> {
    simd: S,
    planes: &'a Planes,
    surface: &'a Surface,
    /// The only colour, packed.
    single: Option<u32>,
}

#[inline(always)]
fn value<S: Simd>(plane: &Plane, x: F<S>, y: f32) -> F<S> {
    (x * plane.dx + plane.at) + plane.dy * y
}

/// 0 to 1 as a byte in the place of a channel.
#[inline(always)]
pub(super) fn in_channel<S: Simd>(value: F<S>, channel: usize) -> U<S> {
    // As `unorm8`.
    const NO_FRACTION: f32 = 8_388_608.0;
    let level = value.simd_gt(0.0).select(value.min(1.0) * 255.0, F::splat(value.token(), 0.0));
    ((level + NO_FRACTION).bitcast::<U<S>>() & 255) << channel_shift(channel)
}

impl<'a, S: Simd> Fill<'a, S> {
    #[inline(always)]
    pub(super) fn new(simd: S, planes: &'a Planes, surface: &'a Surface) -> Self {
        let is_single = planes.flat && matches!(surface.paint, Paint::Color);
        let single = is_single.then(|| pack(planes.color.map(|plane| unorm8(plane.at))));
        Self { simd, planes, surface, single }
    }

    /// The places of [`LANES`] pixels from `x` on.
    #[inline(always)]
    fn columns(&self, x: i32) -> F<S> {
        lane_indices(self.simd).to_float::<F<S>>() + x as f32
    }

    #[inline(always)]
    fn depths(&self, x: F<S>, y: f32) -> F<S> {
        let depth = value(&self.planes.depth, x, y);
        // NaN stays.
        let depth = depth.simd_lt(0.0).select(F::splat(self.simd, 0.0), depth);
        depth.simd_gt(FARTHEST).select(F::splat(self.simd, FARTHEST), depth)
    }

    /// Which of the fragments that are seen there really are, and their colours.
    #[inline(always)]
    fn colors(&self, x: F<S>, y: f32, seen: M<S>) -> (M<S>, U<S>) {
        if let Some(single) = self.single {
            return (seen, U::splat(self.simd, single));
        }
        let planes = self.planes;
        let w = 1.0 / value(&planes.inverse_w, x, y);
        let [r, g, b, a] = if planes.flat {
            map(
                planes.color,
                #[inline(always)]
                |plane| F::splat(self.simd, plane.at),
            )
        } else {
            map(
                planes.color,
                #[inline(always)]
                |plane| value(&plane, x, y) * w,
            )
        };
        let [u, v] = map(
            planes.uv,
            #[inline(always)]
            |plane| value(&plane, x, y) * w,
        );
        let (seen, [r, g, b]) = match self.surface.paint {
            Paint::Edged => {
                let (contrast, inside) = (edge_contrast(r, g, b), inside(u, v));
                let channels = map(
                    [r, g, b],
                    #[inline(always)]
                    |channel| with_edge(channel, contrast, inside),
                );
                (seen, channels)
            }
            Paint::BoxSide => {
                let brightness = box_brightness(inside(u, v));
                (seen, [r * brightness, g * brightness, b * brightness])
            }
            Paint::Disc => {
                let distance_squared = u * u + v * v;
                let brightness = disc_brightness(distance_squared);
                let is_outside = distance_squared.simd_ge(DISC_RADIUS_SQUARED);
                (seen & !is_outside, [r * brightness, g * brightness, b * brightness])
            }
            _ => (seen, [r, g, b]),
        };
        (seen, in_channel(r, 0) | in_channel(g, 1) | in_channel(b, 2) | in_channel(a, 3))
    }

    /// Draws the pixels of a row from `first` to before `after`, which must be the picture's.
    #[inline(always)]
    pub(super) fn row(&self, y: i32, first: i32, after: i32, band: &mut Band<'_>) {
        let row = y as f32;
        for begin in (first..after).step_by(LANES) {
            let columns = self.columns(begin);
            let mask = columns.simd_lt(after as f32);
            let depths = self.depths(columns, row);
            band.for_windows(
                y..y + 1,
                begin,
                #[inline(always)]
                |window| {
                    window.meet(
                        mask,
                        depths,
                        self.surface.mode,
                        #[inline(always)]
                        |seen| self.colors(columns, row, seen),
                    );
                },
            );
        }
    }

    /// Draws the pixels within an area that are not hidden, in the order that ranks give; if tiles are given, only in
    /// these.
    ///
    /// No fragment's depth is below `least`, but for rounding.
    #[inline(always)]
    pub(super) fn ranked(
        &self,
        edges: &[Edge; 3],
        least: f32,
        (area, tiles): (Area, Option<&[SeenTiles]>),
        rank: u32,
        band: &mut Band<'_>,
        occluders: &mut Occluders,
    ) {
        let plane = self.depth_plane(area, least);
        let is_disc = matches!(self.surface.paint, Paint::Disc);
        let covers = |area: Area| edges.iter().all(|edge| edge.covers(area)) && (!is_disc || self.disc_covers(area));
        let in_steps = edges.each_ref().map(Edge::in_whole_pixels);
        occluders.draw(
            self.simd,
            &plane,
            rank,
            (area, tiles),
            #[inline(always)]
            |tile| {
                let is_inside = edges.iter().all(|edge| edge.covers(tile));
                if !is_inside && edges.iter().any(|edge| edge.excludes(tile)) {
                    return Drawn::Nothing;
                }
                let columns = self.columns(tile.left);
                let (mut y, bottom) = (tile.top.max(area.top), tile.bottom.min(area.bottom));
                let mut is_seen = false;
                let mut edges_at = map(
                    in_steps,
                    #[inline(always)]
                    |edge| lane_indices(self.simd) * edge.dx + edge.at(tile.left, y),
                );
                band.for_ranked_windows(
                    y..bottom,
                    tile.left,
                    #[inline(always)]
                    |window| {
                        let row = y as f32;
                        let [a, b, c] = edges_at;
                        let mask = (a | b | c).simd_ge(I::splat(self.simd, 0));
                        is_seen |= window.meet(
                            mask,
                            self.depths(columns, row),
                            rank,
                            #[inline(always)]
                            |seen| self.colors(columns, row, seen),
                        );
                        for k in 0..3 {
                            edges_at[k] += in_steps[k].dy;
                        }
                        y += 1;
                    },
                );
                if !is_seen {
                    Drawn::Nothing
                } else if is_inside && (!is_disc || self.disc_covers(tile)) {
                    Drawn::Covered
                } else {
                    band.farthest(self.simd, tile, [plane.dx, plane.dy])
                }
            },
            covers,
        );
    }

    /// The depths of the fragments in an area, not below `least` but for rounding.
    fn depth_plane(&self, area: Area, least: f32) -> DepthPlane {
        let Plane { at, dx, dy } = self.planes.depth;
        let (right, down) = (dx.abs() * area.right as f32, dy.abs() * area.bottom as f32);
        let noise = if dx == 0.0 && dy == 0.0 {
            0.0
        } else {
            let sum = at.abs() + right;
            1.01 * (rounding(right) + rounding(sum) + rounding(down) + rounding((sum + down).min(2.0 * FARTHEST)))
        };
        let (x, y) =
            (if dx < 0.0 { area.right - 1 } else { area.left }, if dy < 0.0 { area.bottom - 1 } else { area.top });
        let least = least.max(at + dx * x as f32 + dy * y as f32) - noise;
        DepthPlane { at, dx, dy, x: 0.0, y: 0.0, noise, least }
    }

    /// Whether an area surely lies within the disc; its corners do, with a margin for rounding.
    fn disc_covers(&self, area: Area) -> bool {
        let is_inside = |x: i32, y: i32| {
            let (x, y) = (x as f32, y as f32);
            let w = 1.0 / self.planes.inverse_w.value(x, y);
            let [u, v] = self.planes.uv.map(|plane| plane.value(x, y) * w);
            u * u + v * v < DISC_RADIUS_SQUARED * 0.999
        };
        let (right, bottom) = (area.right - 1, area.bottom - 1);
        is_inside(area.left, area.top)
            && is_inside(right, area.top)
            && is_inside(area.left, bottom)
            && is_inside(right, bottom)
    }
}

/// An edge in whole pixels; small enough for 32 bits around the tile where it is looked at.
#[derive(Clone, Copy)]
pub(super) struct SteppedEdge {
    c: i64,
    wide_dx: i64,
    wide_dy: i64,
    dx: i32,
    dy: i32,
}

impl Edge {
    #[inline(always)]
    fn in_whole_pixels(&self) -> SteppedEdge {
        let scale = i64::from(SUBPIXELS);
        // The changes are multiples of the subpixels, so that the fraction of c never matters.
        SteppedEdge {
            c: self.c.div_euclid(scale),
            wide_dx: self.dx / scale,
            wide_dy: self.dy / scale,
            dx: (self.dx / scale) as i32,
            dy: (self.dy / scale) as i32,
        }
    }

    /// The smallest and the largest value in an area.
    #[inline(always)]
    fn range(&self, area: Area) -> (i64, i64) {
        let at = self.c + self.dx * i64::from(area.left) + self.dy * i64::from(area.top);
        let (right, down) =
            (self.dx * i64::from(area.right - 1 - area.left), self.dy * i64::from(area.bottom - 1 - area.top));
        (at + right.min(0) + down.min(0), at + right.max(0) + down.max(0))
    }

    /// Whether all pixels of an area are on the inner side.
    #[inline(always)]
    pub(super) fn covers(&self, area: Area) -> bool {
        self.range(area).0 >= 0
    }

    /// Whether none are.
    #[inline(always)]
    pub(super) fn excludes(&self, area: Area) -> bool {
        self.range(area).1 < 0
    }
}

impl SteppedEdge {
    /// The value at a pixel, or one of the same sign in all of the tile that begins there.
    #[inline(always)]
    fn at(&self, x: i32, y: i32) -> i32 {
        // Snapped places reach to ±2^24, and a tile's pixels are fewer than 8 away on each axis.
        const FAR: i64 = (1 << 29) + (1 << 28);
        let at = self.c + self.wide_dx * i64::from(x) + self.wide_dy * i64::from(y);
        at.clamp(-FAR, FAR) as i32
    }
}

const _: () = assert!(TILE_PX <= 8);
