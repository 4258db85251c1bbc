//! Triangles, from clip coordinates to fragments.
//!
//! Which pixels belong to a triangle is decided by its [edges](super::edges). Between them depth is linear in the
//! window, and everything else is linear in space: it is carried divided by w, and divided by 1/w per pixel. Narrow
//! triangles are tested pixel by pixel, several at once; of wide ones the first and the last pixel of each row are
//! found. Where faces are drawn by ranks, a triangle is drawn tile by tile, without those in which it is hidden.

use std::ops::Range;

use fearless_simd::prelude::*;
use fearless_simd::{dispatch, Simd};
use rcs_scene::CullMode;

use super::clip::{ClipVertex, Polygon};
use super::edges::{Edge, RowEdges, SpanEdges};
use crate::cpu::paint::{DepthBias, Paint, Surface};
use crate::cpu::tile::band::Band;
use crate::cpu::tile::color::{pack, unorm8};
use crate::cpu::tile::lanes::{lane_indices, map, F, LANES, M, U};
use crate::cpu::tile::screen::{
    first_pixel, rounding, Area, DepthPlane, Screen, ScreenPosition, FARTHEST, SUBPIXELS, TILE_PX,
};

/// A quantity that is linear in the window: its value at the reference pixel and the change by a pixel to the right
/// and by a pixel down.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::cpu) struct Plane {
    pub at: f32,
    pub dx: f32,
    pub dy: f32,
}

impl Plane {
    /// The values in several columns of a row.
    #[inline(always)]
    pub(in crate::cpu) fn values<S: Simd>(&self, x: F<S>, y: f32) -> F<S> {
        (x * self.dx + self.at) + self.dy * y
    }
}

/// About as many of the image's pixels as a triangle covers; none for thin ones, such as wide lines, which cover no
/// tiles.
#[inline]
pub(in crate::cpu) fn covered_px([a, b, c]: [&ScreenPosition; 3], screen: &Screen) -> u64 {
    const THIN_PX: i64 = 32;
    let ((left, right), (top, bottom)) = (between(a.x, b.x, c.x), between(a.y, b.y, c.y));
    let doubled_px = doubled_area([a, b, c]).abs() / i64::from(SUBPIXELS * SUBPIXELS);
    if doubled_px < i64::from((right - left).max(bottom - top)) * THIN_PX {
        return 0;
    }
    let width = right.min(screen.width_px as i32) - left.max(0);
    let height = bottom.min(screen.height_px as i32) - top.max(0);
    (width.max(0) as u64 * height.max(0) as u64).min(doubled_px as u64) / 2
}

/// Twice the area in snapped places. Window y points down, so what runs counter-clockwise to the eye has a negative
/// one.
#[inline]
fn doubled_area(positions: [&ScreenPosition; 3]) -> i64 {
    doubled_area_of(positions.map(|position| [position.x, position.y]))
}

/// As [`doubled_area`], of places anywhere.
#[inline]
pub(in crate::cpu) fn doubled_area_of([a, b, c]: [[i32; 2]; 3]) -> i64 {
    let (bx, by) = (i64::from(b[0]) - i64::from(a[0]), i64::from(b[1]) - i64::from(a[1]));
    let (cx, cy) = (i64::from(c[0]) - i64::from(a[0]), i64::from(c[1]) - i64::from(a[1]));
    bx * cy - cx * by
}

/// True if the sides that are not drawn include the one that is seen.
#[inline]
pub(in crate::cpu) fn is_hidden(doubled_area: i64, cull: CullMode) -> bool {
    match cull {
        CullMode::None => doubled_area == 0,
        CullMode::Back => doubled_area >= 0,
        CullMode::Front => doubled_area <= 0,
    }
}

/// True if a triangle between these snapped places may cover the centre of a pixel, of the image or beside it: of
/// tiny ones it is found out.
#[inline]
pub(in crate::cpu) fn covers_any_centre(places: [[i32; 2]; 3]) -> bool {
    const TINY_PX: i32 = 2;
    let [a, b, c] = places.map(|[x, y]| ScreenPosition { x, y, ..ScreenPosition::default() });
    let ((left, right), (top, bottom)) = (between(a.x, b.x, c.x), between(a.y, b.y, c.y));
    if right - left > TINY_PX || bottom - top > TINY_PX {
        return true;
    }
    let positions = if doubled_area([&a, &b, &c]) < 0 { [&a, &c, &b] } else { [&a, &b, &c] };
    let edges = Edge::around(positions);
    (top..bottom).any(|y| (left..right).any(|x| edges.iter().all(|edge| edge.covers(x, y))))
}

/// True if a triangle that needs no cutting may touch the centre of a pixel of the image with a side that is drawn.
/// Of a detailed mesh most do not, and are spared the light on their corners.
#[inline]
pub(in crate::cpu) fn may_be_seen([a, b, c]: [&ScreenPosition; 3], surface: &Surface, screen: &Screen) -> bool {
    let touches = |a: i32, b: i32, c: i32, end: u32| {
        let (first, after) = between(a, b, c);
        first.max(0) < after.min(end as i32)
    };
    touches(a.x, b.x, c.x, screen.width_px)
        && touches(a.y, b.y, c.y, screen.height_px)
        && !is_hidden(doubled_area([a, b, c]), surface.cull)
}

/// A vertex on the image, with the values that are interpolated over its triangles.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::cpu) struct Corner {
    /// Its position.
    pub position: ScreenPosition,
    /// Red, green, blue, alpha, each 0 to 1.
    pub color: [f32; 4],
    /// Texture coordinates.
    pub uv: [f32; 2],
}

impl Corner {
    fn new(vertex: &ClipVertex, screen: &Screen) -> Self {
        Self { position: ScreenPosition::new(vertex.position, screen), color: vertex.color, uv: vertex.uv }
    }
}

/// The first row of a triangle and the row after its last; may lie outside of the image.
#[inline]
pub(in crate::cpu) fn rows([a, b, c]: [&ScreenPosition; 3]) -> (i32, i32) {
    between(a.y, b.y, c.y)
}

/// The first pixel and the pixel after the last that snapped places reach over.
#[inline]
pub(in crate::cpu) fn between(a: i32, b: i32, c: i32) -> (i32, i32) {
    (first_pixel(a.min(b).min(c)), first_pixel(a.max(b).max(c) + 1))
}

/// Clips a triangle and passes on the parts that are to be drawn.
pub(in crate::cpu) fn cut(
    triangle: [&ClipVertex; 3],
    surface: &Surface,
    screen: &Screen,
    mut out: impl FnMut(&[Corner; 3]),
) {
    let Some(polygon) = Polygon::clip(triangle) else { return };
    let Some((first, rest)) = polygon.vertices().split_first() else { return };
    let first = Corner::new(first, screen);
    for pair in rest.windows(2) {
        let corners = [first, Corner::new(&pair[0], screen), Corner::new(&pair[1], screen)];
        if may_be_seen(corners.each_ref().map(|corner| &corner.position), surface, screen) {
            out(&corners);
        }
    }
}

/// The corners in the order in which the inside is on the right of each edge as the image shows it, and twice the
/// area; none where that is zero.
#[inline]
pub(in crate::cpu) fn clockwise([a, b, c]: [&Corner; 3]) -> Option<([&Corner; 3], i64)> {
    match doubled_area([&a.position, &b.position, &c.position]) {
        0 => None,
        area if area < 0 => Some(([a, c, b], -area)),
        area => Some(([a, b, c], area)),
    }
}

/// Draws the rows of a band. Culling is done by then.
#[inline]
pub(in crate::cpu) fn draw(corners: [&Corner; 3], surface: &Surface, band: &mut Band<'_>) {
    let area = area_of(corners, band);
    if area.is_empty() {
        return;
    }
    if let Some((corners, doubled_area)) = clockwise(corners) {
        let triangle = Triangles { corners: [corners], doubled_areas: [doubled_area], surface, area };
        dispatch!(band.simd_level, simd => triangle.draw(simd, band));
    }
}

/// Draws the rows of a band of a glyph's triangles, which share an edge and have one colour: as [`draw`] does one after
/// the other, in less time.
pub(in crate::cpu) fn draw_pair(pair: [[&Corner; 3]; 2], surface: &Surface, band: &mut Band<'_>) {
    let is_clockwise = |corners: [&Corner; 3]| doubled_area(corners.map(|corner| &corner.position)) > 0;
    match pair.map(clockwise) {
        // Only those of one orientation lie on both sides of their edge.
        [Some((one, one_area)), Some((other, other_area))] if is_clockwise(pair[0]) == is_clockwise(pair[1]) => {
            let area = area_of(one, band).around(&area_of(other, band));
            let both = Triangles { corners: [one, other], doubled_areas: [one_area, other_area], surface, area };
            dispatch!(band.simd_level, simd => both.draw_tiles(simd, band));
        }
        _ => pair.into_iter().for_each(|corners| draw(corners, surface, band)),
    }
}

/// A band's pixels around a triangle.
#[inline]
fn area_of([a, b, c]: [&Corner; 3], band: &Band<'_>) -> Area {
    let (left, right) = between(a.position.x, b.position.x, c.position.x);
    let (begin, end) = rows([&a.position, &b.position, &c.position]);
    let Range { start: top, end: bottom } = band.rows(begin, end);
    Area { left: left.max(0), right: right.min(band.width), top, bottom }
}

/// A triangle in a band, or several that share no pixel and have one colour.
struct Triangles<'a, const N: usize> {
    /// With the inside on the right of each edge as the image shows it.
    corners: [[&'a Corner; 3]; N],
    doubled_areas: [i64; N],
    surface: &'a Surface,
    /// The band's pixels around them.
    area: Area,
}

impl<const N: usize> Triangles<'_, N> {
    /// Draws tile by tile.
    #[inline(always)]
    fn draw_tiles<S: Simd>(&self, simd: S, band: &mut Band<'_>) {
        let edges = self.corners.map(|corners| Edge::around(corners.map(|corner| &corner.position)));
        let (area, mut fragments) = (self.area, None);
        for top in (area.top..area.bottom).step_by(TILE_PX as usize) {
            for left in (area.left..area.right).step_by(TILE_PX as usize) {
                let tile = Area { left, right: left + TILE_PX, top, bottom: area.bottom.min(top + TILE_PX) };
                self.draw_tile(simd, &edges, tile, &mut fragments, band);
            }
        }
    }

    /// Draws the pixels of a tile, or of some rows of it. Returns true if some are seen.
    #[inline(always)]
    fn draw_tile<'b, S: Simd>(
        &'b self,
        simd: S,
        edges: &[[Edge<i64>; 3]; N],
        tile: Area,
        fragments: &mut Option<Fragments<'b, S, N>>,
        band: &mut Band<'_>,
    ) -> bool {
        let mut rows = map(
            *edges,
            #[inline(always)]
            |[a, b, c]| {
                let edges = [a, b, c].map(|edge| edge.measured_at(tile.left, tile.top));
                RowEdges::new(&edges, lane_indices(simd), 0)
            },
        );
        let (columns, mut y, mut is_seen) = (columns(simd, tile.left), tile.top as f32, false);
        band.for_windows(
            tile.top..tile.bottom,
            tile.left,
            #[inline(always)]
            |window| {
                let mut covered = [rows[0].next(); N];
                let mut all = covered[0];
                for k in 1..N {
                    covered[k] = rows[k].next();
                    all |= covered[k];
                }
                // Many a triangle of a detailed mesh lies between the pixels' centres.
                if all.any_true() {
                    let fragments = fragments.get_or_insert_with(|| Fragments::new(simd, self.planes(), self.surface));
                    is_seen |= window.write_fragments(
                        all,
                        fragments.depths(covered, columns, y),
                        self.surface.mode,
                        #[inline(always)]
                        |seen| fragments.colors(covered, columns, y, seen),
                    );
                }
                y += 1.0;
            },
        );
        is_seen
    }

    fn planes(&self) -> [Planes; N] {
        std::array::from_fn(|k| Planes::new(self.corners[k], self.doubled_areas[k], self.surface))
    }
}

impl Triangles<'_, 1> {
    #[inline(always)]
    fn draw<S: Simd>(&self, simd: S, band: &mut Band<'_>) {
        if band.is_ranked() {
            self.draw_visible(simd, band);
        } else if self.area.right - self.area.left <= TILE_PX {
            self.draw_tiles(simd, band);
        } else {
            let edges = Edge::around(self.corners[0].map(|corner| &corner.position));
            let mut spans = SpanEdges::new(&edges, self.area.top, self.area.left..self.area.right);
            let fragments = Fragments::new(simd, self.planes(), self.surface);
            for y in self.area.top..self.area.bottom {
                let span = spans.next();
                if span.start < span.end {
                    fragments.draw_span(y, span, band);
                }
            }
        }
    }

    /// Draws the tiles in which something of it may be seen.
    #[inline(always)]
    fn draw_visible<S: Simd>(&self, simd: S, band: &mut Band<'_>) {
        let positions = self.corners[0].map(|corner| &corner.position);
        let (edges, planes) = (Edge::around(positions), self.planes());
        let depth = planes[0].depth_bound(self.area, least_depth(positions, self.surface));
        let mut fragments = Some(Fragments::new(simd, planes, self.surface));
        band.draw_visible(
            simd,
            depth,
            self.area,
            #[inline(always)]
            |band, tile| {
                if edges.iter().any(|edge| edge.excludes(tile)) {
                    return false;
                }
                let pixels =
                    Area { top: tile.top.max(self.area.top), bottom: tile.bottom.min(self.area.bottom), ..tile };
                self.draw_tile(simd, &[edges], pixels, &mut fragments, band)
            },
        );
    }
}

/// A depth that no fragment of a triangle is nearer than, by however much its plane is rounded; infinitely near for
/// thin ones, whose planes are steep.
#[inline]
pub(in crate::cpu) fn least_depth(positions: [&ScreenPosition; 3], surface: &Surface) -> f32 {
    const THIN_PX: i64 = 16;
    const STEPS: f32 = 32.0;
    const SHARE: f32 = 1.0 / 1024.0;
    let [first, second, third] = positions;
    let (left, right) = between(first.x, second.x, third.x);
    let (top, bottom) = between(first.y, second.y, third.y);
    let longest = i64::from((right - left).max(bottom - top));
    let is_thin = doubled_area(positions).abs() / i64::from(SUBPIXELS * SUBPIXELS) < longest * THIN_PX;
    let [a, b, c] = positions.map(|position| position.depth);
    let (near, far) = (a.min(b).min(c), a.max(b).max(c));
    if surface.depth_bias != DepthBias::NONE {
        f32::NEG_INFINITY
    } else if near == far {
        near
    } else if is_thin {
        f32::NEG_INFINITY
    } else {
        near - (far - near) * SHARE - STEPS
    }
}

/// How a triangle lies in the image, for what is linear over it.
#[derive(Clone, Copy, Debug)]
pub(in crate::cpu) struct Slopes {
    along: [f32; 4],
    per_area: f32,
    first: [f32; 2],
}

impl Slopes {
    /// Of corners whose inside is on the right of each edge as the image shows it.
    #[inline]
    pub(in crate::cpu) fn new([a, b, c]: [&ScreenPosition; 3], doubled_area: i64) -> Self {
        let scale = SUBPIXELS as f32;
        let along = [b.x - a.x, b.y - a.y, c.x - a.x, c.y - a.y].map(|d| d as f32 / scale);
        let per_area = (scale as f64 * scale as f64 / doubled_area as f64) as f32;
        Self { along, per_area, first: [a.x as f32 / scale, a.y as f32 / scale] }
    }

    /// A plane with these values at the corners.
    #[inline]
    pub(in crate::cpu) fn plane(&self, [va, vb, vc]: [f32; 3]) -> Plane {
        let ([dx1, dy1, dx2, dy2], [x, y]) = (self.along, self.first);
        let dx = ((vb - va) * dy2 - (vc - va) * dy1) * self.per_area;
        let dy = ((vc - va) * dx1 - (vb - va) * dx2) * self.per_area;
        Plane { at: va - dx * x - dy * y, dx, dy }
    }

    /// The depth, nearer by a surface's bias.
    #[inline]
    pub(in crate::cpu) fn depth(&self, depths: [f32; 3], surface: &Surface) -> Plane {
        let mut depth = self.plane(depths);
        if surface.depth_bias != DepthBias::NONE {
            let DepthBias { steps, slopes } = surface.depth_bias;
            depth.at -= steps + slopes * depth.dx.abs().max(depth.dy.abs());
        }
        depth
    }
}

/// The values that are interpolated over a triangle.
#[derive(Clone, Copy, Debug)]
pub(in crate::cpu) struct Planes {
    /// All corners have one colour, which `color` holds undivided.
    pub flat: bool,
    pub depth: Plane,
    pub inverse_w: Plane,
    pub color: [Plane; 4],
    /// Only where the surface has use for it.
    pub uv: [Plane; 2],
}

impl Planes {
    /// Of corners whose inside is on the right of each edge as the image shows it.
    pub(in crate::cpu) fn new(corners: [&Corner; 3], doubled_area: i64, surface: &Surface) -> Self {
        let [(a, color_a, uv_a), (b, color_b, uv_b), (c, color_c, uv_c)] =
            corners.map(|corner| (&corner.position, &corner.color, &corner.uv));
        let slopes = Slopes::new([a, b, c], doubled_area);
        let plane = |va, vb, vc| slopes.plane([va, vb, vc]);
        let depth = slopes.depth([a.depth, b.depth, c.depth], surface);
        let flat = color_a == color_b && color_a == color_c;
        let color = if flat {
            color_a.map(|at| Plane { at, dx: 0.0, dy: 0.0 })
        } else {
            [0, 1, 2, 3].map(|i| plane(color_a[i] * a.inverse_w, color_b[i] * b.inverse_w, color_c[i] * c.inverse_w))
        };
        let uv = if matches!(surface.paint, Paint::Color) {
            [Plane::default(); 2]
        } else {
            [0, 1].map(|i| plane(uv_a[i] * a.inverse_w, uv_b[i] * b.inverse_w, uv_c[i] * c.inverse_w))
        };
        Self { flat, depth, inverse_w: plane(a.inverse_w, b.inverse_w, c.inverse_w), color, uv }
    }

    /// The change of texture coordinates to the next pixel along the row and along the column.
    fn footprint(&self, uv: [f32; 2], w: f32) -> [[f32; 2]; 2] {
        let change = |plane: &Plane, value: f32| {
            [(plane.dx - value * self.inverse_w.dx) * w, (plane.dy - value * self.inverse_w.dy) * w]
        };
        let [[ux, uy], [vx, vy]] = [change(&self.uv[0], uv[0]), change(&self.uv[1], uv[1])];
        [[ux, vx], [uy, vy]]
    }

    /// The depths of the fragments in an area, not below `least` but for rounding.
    fn depth_bound(&self, area: Area, least: f32) -> DepthPlane {
        let Plane { at, dx, dy } = self.depth;
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
}

/// The fragments of [`Triangles`], several at once.
struct Fragments<'a, S: Simd, const N: usize> {
    simd: S,
    planes: [Planes; N],
    surface: &'a Surface,
    /// The only colour, packed.
    single: Option<u32>,
    /// The texture's level, if it is the same everywhere: on surfaces that face the camera.
    level: Option<usize>,
}

impl<'a, S: Simd, const N: usize> Fragments<'a, S, N> {
    #[inline(always)]
    fn new(simd: S, planes: [Planes; N], surface: &'a Surface) -> Self {
        let first = &planes[0];
        let is_single = first.flat && matches!(surface.paint, Paint::Color);
        let single = is_single.then(|| pack(first.color.map(|plane| unorm8(plane.at))));
        let level = match &surface.paint {
            Paint::Texture(texture)
                if !texture.has_smaller() || (first.inverse_w.dx == 0.0 && first.inverse_w.dy == 0.0) =>
            {
                Some(texture.level_for(|| first.footprint([0.0; 2], 1.0 / first.inverse_w.at)))
            }
            _ => None,
        };
        Self { simd, planes, surface, single, level }
    }

    /// The values of the triangles that cover each pixel.
    #[inline(always)]
    fn values(&self, covered: [M<S>; N], x: F<S>, y: f32, plane: impl Fn(&Planes) -> Plane) -> F<S> {
        let mut values = plane(&self.planes[0]).values(x, y);
        for (covered, planes) in covered.into_iter().zip(&self.planes).skip(1) {
            values = covered.select(plane(planes).values(x, y), values);
        }
        values
    }

    #[inline(always)]
    fn depths(&self, covered: [M<S>; N], x: F<S>, y: f32) -> F<S> {
        let depth = self.values(covered, x, y, |planes| planes.depth);
        // NaN stays.
        let depth = depth.simd_lt(0.0).select(F::splat(self.simd, 0.0), depth);
        depth.simd_gt(FARTHEST).select(F::splat(self.simd, FARTHEST), depth)
    }

    /// The fragments seen there that the surface has, and their colours.
    #[inline(always)]
    fn colors(&self, covered: [M<S>; N], x: F<S>, y: f32, seen: M<S>) -> (M<S>, U<S>) {
        if let Some(single) = self.single {
            return (seen, U::splat(self.simd, single));
        }
        let first = &self.planes[0];
        let w = 1.0 / self.values(covered, x, y, |planes| planes.inverse_w);
        let color = if first.flat {
            map(
                first.color,
                #[inline(always)]
                |plane| F::splat(self.simd, plane.at),
            )
        } else {
            map(
                first.color,
                #[inline(always)]
                |plane| plane.values(x, y) * w,
            )
        };
        let uv = map(
            [0, 1],
            #[inline(always)]
            |i: usize| self.values(covered, x, y, |planes| planes.uv[i]) * w,
        );
        self.surface.colors(color, uv, seen, self.level, |texture, lane, uv| {
            texture.level_for(|| first.footprint(uv, w.to_array()[lane]))
        })
    }
}

impl<S: Simd> Fragments<'_, S, 1> {
    /// Draws the pixels of a row's span, which must be the image's.
    #[inline(always)]
    fn draw_span(&self, y: i32, span: Range<i32>, band: &mut Band<'_>) {
        let row = y as f32;
        for begin in span.clone().step_by(LANES) {
            let columns = columns(self.simd, begin);
            let mask = columns.simd_lt(span.end as f32);
            let depths = self.depths([mask], columns, row);
            let Some(window) = band.window(begin, y) else { return };
            window.write_fragments(
                mask,
                depths,
                self.surface.mode,
                #[inline(always)]
                |seen| self.colors([mask], columns, row, seen),
            );
        }
    }
}

/// The places of [`LANES`] pixels from `x` on.
#[inline(always)]
fn columns<S: Simd>(simd: S, x: i32) -> F<S> {
    lane_indices(simd).to_float::<F<S>>() + x as f32
}
