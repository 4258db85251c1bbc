//! Triangles, from clip coordinates to fragments.
//!
//! A pixel belongs to a triangle where its centre lies inside, or on a left or top edge, of the triangle whose corners
//! are snapped to 1/256 pixel. All of that is decided in whole numbers, so that triangles which share an edge draw
//! every pixel along it once. For each row the three edges give the first and the last pixel; between them depth is
//! linear in the window, and everything else is linear in space: it is carried divided by w, and divided by 1/w per
//! pixel.

use std::ops::Range;

use fearless_simd::{dispatch, Simd};
use rcs_scene::CullMode;
use wide::f32x4;

use super::band::{meet, pack, unorm8, Band};
use super::clip::{ClipVertex, Outside, Polygon};
use super::edges::{Edge, EdgeRows, SmallEdges};
use super::fill::{can_fill, Fill};
use super::occlusion::{Area, Occluders, SeenTiles};
use super::ranked::Extent;
use super::screen::{first_pixel, snap_lanes, Screen, FARTHEST, SUBPIXELS};
use super::surface::{DepthBias, Paint, Surface};

/// A quantity that is linear in the window: its value at the reference pixel and the change by a pixel to the right
/// and by a pixel down.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Plane {
    pub at: f32,
    pub dx: f32,
    pub dy: f32,
}

impl Plane {
    #[inline]
    pub(super) fn value(&self, x: f32, y: f32) -> f32 {
        self.at + self.dx * x + self.dy * y
    }
}

/// A vertex's position on the picture.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ScreenPosition {
    pub x: i32,
    pub y: i32,
    pub depth: f32,
    pub inverse_w: f32,
}

impl ScreenPosition {
    /// The position of clip coordinates in front of the near plane.
    #[inline]
    pub(super) fn new(position: [f32; 4], screen: &Screen) -> Self {
        let inverse_w = 1.0 / position[3];
        // Window x and y, and the depth from 0 to 1.
        let window = screen.window(f32x4::new(position) * f32x4::splat(inverse_w));
        let [x, y, ..] = snap_lanes(window).to_array();
        let [_, _, depth, _] = window.to_array();
        Self { x, y, depth: depth * FARTHEST, inverse_w }
    }

    /// All of its numbers.
    pub(super) fn bits(&self) -> [u32; 4] {
        [self.x as u32, self.y as u32, self.depth.to_bits(), self.inverse_w.to_bits()]
    }
}

/// How large a triangle is in the picture.
#[inline]
pub(super) fn extent([a, b, c]: [&ScreenPosition; 3], screen: &Screen) -> Extent {
    Extent::of_triangle(between(a.x, b.x, c.x), between(a.y, b.y, c.y), doubled_area([a, b, c]), screen)
}

/// Twice the area in snapped places. Window y points down, so what runs counter-clockwise to the eye has a negative
/// one.
#[inline]
fn doubled_area(positions: [&ScreenPosition; 3]) -> i64 {
    doubled_area_of(positions.map(|position| [position.x, position.y]))
}

/// As [`doubled_area`], of places anywhere.
#[inline]
pub(super) fn doubled_area_of([a, b, c]: [[i32; 2]; 3]) -> i64 {
    let (bx, by) = (i64::from(b[0]) - i64::from(a[0]), i64::from(b[1]) - i64::from(a[1]));
    let (cx, cy) = (i64::from(c[0]) - i64::from(a[0]), i64::from(c[1]) - i64::from(a[1]));
    bx * cy - cx * by
}

/// Whether the sides that are not drawn include the one that is seen.
#[inline]
fn is_hidden(doubled_area: i64, cull: CullMode) -> bool {
    match cull {
        CullMode::None => doubled_area == 0,
        CullMode::Back => doubled_area >= 0,
        CullMode::Front => doubled_area <= 0,
    }
}

/// Whether a triangle between these snapped places covers the centre of a pixel, of the picture or beside it; says so
/// of all but tiny ones.
#[inline]
pub(super) fn covers_any_centre(places: [[i32; 2]; 3]) -> bool {
    const TINY_PX: i32 = 2;
    let [a, b, c] = places.map(|[x, y]| ScreenPosition { x, y, ..ScreenPosition::default() });
    let ((left, right), (top, bottom)) = (between(a.x, b.x, c.x), between(a.y, b.y, c.y));
    if right - left > TINY_PX || bottom - top > TINY_PX {
        return true;
    }
    let positions = if doubled_area([&a, &b, &c]) < 0 { [&a, &c, &b] } else { [&a, &b, &c] };
    let edges = SmallEdges::around(positions, left, top);
    (0..bottom - top).any(|y| {
        let (first, after) = edges.row(y, right - left);
        first < after
    })
}

/// Whether a triangle that needs no cutting may touch the centre of a pixel of the picture with a side that is drawn.
/// Of a detailed mesh most do not, and are spared the light on their corners.
#[inline]
pub(super) fn may_be_seen([a, b, c]: [&ScreenPosition; 3], surface: &Surface, screen: &Screen) -> bool {
    let touches = |a: i32, b: i32, c: i32, end: u32| {
        let (first, after) = between(a, b, c);
        first.max(0) < after.min(end as i32)
    };
    touches(a.x, b.x, c.x, screen.width_px)
        && touches(a.y, b.y, c.y, screen.height_px)
        && !is_hidden(doubled_area([a, b, c]), surface.cull)
}

/// A vertex on the picture, with the values that are interpolated over its triangles.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Corner {
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

/// The first row of a triangle and the row after its last; may lie outside of the picture.
#[inline]
pub(super) fn rows([a, b, c]: [&ScreenPosition; 3]) -> (i32, i32) {
    between(a.y, b.y, c.y)
}

/// The first pixel and the pixel after the last that snapped places reach over.
#[inline]
pub(super) fn between(a: i32, b: i32, c: i32) -> (i32, i32) {
    (first_pixel(a.min(b).min(c)), first_pixel(a.max(b).max(c) + 1))
}

/// Clips a triangle and passes on the parts that are to be drawn.
pub(super) fn cut(triangle: [&ClipVertex; 3], surface: &Surface, screen: &Screen, mut out: impl FnMut(&[Corner; 3])) {
    let outside = triangle.map(|vertex| Outside::new(vertex.position));
    if outside.iter().all(|outside| outside.guard == 0) {
        // Nothing is cut off.
        let corners = triangle.map(|vertex| Corner::new(vertex, screen));
        let positions = corners.each_ref().map(|corner| &corner.position);
        if outside.iter().fold(!0, |all, outside| all & outside.view) == 0 && may_be_seen(positions, surface, screen) {
            out(&corners);
        }
        return;
    }
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

/// Draws the rows of a band. Culling is done by then.
pub(super) fn draw(corners: [&Corner; 3], surface: &Surface, band: &mut Band<'_>) {
    let Some((corners, area)) = clockwise(corners) else { return };
    let positions = corners.map(|corner| &corner.position);
    let (left, right) = between(positions[0].x, positions[1].x, positions[2].x);
    if right - left >= Wide::MIN_WIDTH_PX && can_fill(surface) {
        let wide = Wide { planes: Planes::new(corners, area, surface), edges: Edge::around(positions) };
        dispatch!(band.simd_level, simd => wide.draw(simd, surface, (left, right), rows(positions), band));
        return;
    }
    // Many a triangle of a detailed mesh lies between the pixels' centres.
    let mut planes = None;
    for_rows(positions, band, |y, first, after, band| {
        let planes = planes.get_or_insert_with(|| Planes::new(corners, area, surface));
        planes.draw_row(surface, y, first, after, band);
    });
}

/// Draws the pixels of a small triangle, given the rows that it covers.
pub(super) fn draw_rows(
    corners: [&Corner; 3],
    surface: &Surface,
    rows: impl Iterator<Item = (i32, i32, i32)>,
    band: &mut Band<'_>,
) {
    let Some((corners, area)) = clockwise(corners) else { return };
    let planes = Planes::new(corners, area, surface);
    for (y, first, after) in rows {
        planes.draw_row(surface, y, first, after, band);
    }
}

/// Draws the pixels of a small opaque triangle in its colour, given the rows that it covers, not in its turn but with
/// its rank in it.
pub(super) fn draw_among(
    corners: [&Corner; 3],
    surface: &Surface,
    rows: impl Iterator<Item = (i32, i32, i32)>,
    rank: u32,
    band: &mut Band<'_>,
) {
    let Some((corners, area)) = clockwise(corners) else { return };
    let planes = Planes::new(corners, area, surface);
    for (y, first, after) in rows {
        planes.draw_row_among(y, first, after, rank, band);
    }
}

/// The corners in the order in which the inside is on the right of each edge as the picture shows it, and twice the
/// area; none where that is zero.
#[inline]
pub(super) fn clockwise([a, b, c]: [&Corner; 3]) -> Option<([&Corner; 3], i64)> {
    match doubled_area([&a.position, &b.position, &c.position]) {
        0 => None,
        area if area < 0 => Some(([a, c, b], -area)),
        area => Some(([a, b, c], area)),
    }
}

/// Passes on the pixels of each of the band's rows that a triangle covers: the row, the first one, and the one after
/// the last.
#[inline(always)]
pub(super) fn for_rows(
    positions: [&ScreenPosition; 3],
    band: &mut Band<'_>,
    mut draw_row: impl FnMut(i32, i32, i32, &mut Band<'_>),
) {
    let (left, right) = between(positions[0].x, positions[1].x, positions[2].x);
    let (begin, end) = rows(positions);
    let rows = band.rows(begin, end);
    let mut draw_row = |y, first, after, band: &mut Band<'_>| {
        if first < after {
            draw_row(y, first, after, band);
        }
    };
    if right - left <= SmallEdges::MAX_WIDTH_PX && end - begin <= SmallEdges::MAX_HEIGHT_PX {
        let edges = SmallEdges::around(positions, left, begin);
        for y in rows {
            let (first, after) = edges.row(y - begin, right - left);
            draw_row(y, left + first, left + after, band);
        }
    } else {
        let mut edges = Edge::around(positions).map(|edge| EdgeRows::new(&edge, rows.start));
        for y in rows {
            let (mut first, mut after) = (left, right);
            for edge in &mut edges {
                edge.narrow(&mut first, &mut after);
            }
            draw_row(y, first, after, band);
        }
    }
}

/// Draws the rows of a band of an opaque triangle, not in its turn but with its rank in it; the surface is one that
/// [`can_fill`]. If it is known in which tiles something of it may be seen, only these are drawn.
pub(super) fn draw_ranked(
    corners: [&Corner; 3],
    surface: &Surface,
    rank: u32,
    tiles: Option<&[SeenTiles]>,
    band: &mut Band<'_>,
    occluders: &mut Occluders,
) {
    let Some((corners, area)) = clockwise(corners) else { return };
    let positions = corners.map(|corner| &corner.position);
    let (left, right) = between(positions[0].x, positions[1].x, positions[2].x);
    let (begin, end) = rows(positions);
    let Range { start: top, end: bottom } = band.rows(begin, end);
    let pixels = Area { left: left.max(0), right: right.min(band.width), top, bottom };
    if pixels.left < pixels.right && pixels.top < pixels.bottom {
        let least = least_depth(positions, surface);
        if tiles.is_none() && occluders.hides_from(least) {
            return;
        }
        let planes = Planes::new(corners, area, surface);
        let edges = Edge::around(positions);
        dispatch!(band.simd_level, simd => {
            Fill::new(simd, &planes, surface).ranked(&edges, least, (pixels, tiles), rank, band, occluders);
        });
    }
}

/// A depth that no fragment of a triangle is nearer than, by however much its plane is rounded; infinitely near for
/// thin ones, whose planes are steep.
#[inline]
pub(super) fn least_depth(positions: [&ScreenPosition; 3], surface: &Surface) -> f32 {
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

/// A triangle with long rows.
struct Wide {
    planes: Planes,
    edges: [Edge; 3],
}

impl Wide {
    const MIN_WIDTH_PX: i32 = 24;

    #[inline(always)]
    fn draw<S: Simd>(
        &self,
        simd: S,
        surface: &Surface,
        (left, right): (i32, i32),
        (begin, end): (i32, i32),
        band: &mut Band<'_>,
    ) {
        let fill = Fill::new(simd, &self.planes, surface);
        let (left, right) = (left.max(0), right.min(band.width));
        let rows = band.rows(begin, end);
        let mut edges = self.edges.each_ref().map(|edge| EdgeRows::new(edge, rows.start));
        for y in rows {
            let (mut first, mut after) = (left, right.max(left));
            for edge in &mut edges {
                edge.narrow(&mut first, &mut after);
            }
            fill.row(y, first, after, band);
        }
    }
}

/// How a triangle lies in the picture, for what is linear over it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Slopes {
    along: [f32; 4],
    per_area: f32,
    first: [f32; 2],
}

impl Slopes {
    /// Of corners whose inside is on the right of each edge as the picture shows it.
    #[inline]
    pub(super) fn new([a, b, c]: [&ScreenPosition; 3], doubled_area: i64) -> Self {
        let scale = SUBPIXELS as f32;
        let along = [b.x - a.x, b.y - a.y, c.x - a.x, c.y - a.y].map(|d| d as f32 / scale);
        let per_area = (scale as f64 * scale as f64 / doubled_area as f64) as f32;
        Self { along, per_area, first: [a.x as f32 / scale, a.y as f32 / scale] }
    }

    /// What has these values at the corners.
    #[inline]
    pub(super) fn plane(&self, [va, vb, vc]: [f32; 3]) -> Plane {
        let ([dx1, dy1, dx2, dy2], [x, y]) = (self.along, self.first);
        let dx = ((vb - va) * dy2 - (vc - va) * dy1) * self.per_area;
        let dy = ((vc - va) * dx1 - (vb - va) * dx2) * self.per_area;
        Plane { at: va - dx * x - dy * y, dx, dy }
    }

    /// The depth, nearer by a surface's bias.
    #[inline]
    pub(super) fn depth(&self, depths: [f32; 3], surface: &Surface) -> Plane {
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
pub(super) struct Planes {
    /// All corners have one colour, which `color` holds undivided.
    pub flat: bool,
    pub depth: Plane,
    pub inverse_w: Plane,
    pub color: [Plane; 4],
    /// Only where the surface has use for it.
    pub uv: [Plane; 2],
}

impl Planes {
    /// Of corners whose inside is on the right of each edge as the picture shows it.
    pub(super) fn new(corners: [&Corner; 3], doubled_area: i64, surface: &Surface) -> Self {
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

    /// Draws in the interpolated colour; of equal depths that of the higher rank wins.
    fn draw_row_among(&self, y: i32, first: i32, after: i32, rank: u32, band: &mut Band<'_>) {
        let (first, pixels) = band.ranked_span(y, first, after);
        let row = y as f32;
        let flat = self.flat.then(|| pack(self.color.map(|plane| unorm8(plane.at))));
        for ((pixel, pixel_depth, pixel_rank), x) in pixels.zip(first..) {
            let column = x as f32;
            let depth = self.depth.value(column, row).clamp(0.0, FARTHEST);
            if depth < *pixel_depth || (depth == *pixel_depth && rank >= *pixel_rank) {
                *pixel = flat.unwrap_or_else(|| {
                    let w = 1.0 / self.inverse_w.value(column, row);
                    pack(self.color.map(|plane| unorm8(plane.value(column, row) * w)))
                });
                (*pixel_depth, *pixel_rank) = (depth, rank);
            }
        }
    }

    fn draw_row(&self, surface: &Surface, y: i32, first: i32, after: i32, band: &mut Band<'_>) {
        let (first, colors, depths) = band.span(y, first, after);
        let row = y as f32;
        let fragments = colors.iter_mut().zip(depths).zip(first..);
        if matches!(surface.paint, Paint::Color) {
            // Most of a scene is painted so.
            let flat = self.flat.then(|| self.color.map(|plane| unorm8(plane.at)));
            for ((pixel, depth), x) in fragments {
                let column = x as f32;
                let fragment_depth = self.depth.value(column, row).clamp(0.0, FARTHEST);
                if surface.mode.depth_test && fragment_depth > *depth {
                    continue;
                }
                let color = flat.unwrap_or_else(|| {
                    let w = 1.0 / self.inverse_w.value(column, row);
                    self.color.map(|plane| unorm8(plane.value(column, row) * w))
                });
                meet(pixel, depth, fragment_depth, color, surface.mode);
            }
            return;
        }
        for ((pixel, depth), x) in fragments {
            let column = x as f32;
            let fragment_depth = self.depth.value(column, row).clamp(0.0, FARTHEST);
            if surface.mode.depth_test && fragment_depth > *depth {
                continue;
            }
            let w = 1.0 / self.inverse_w.value(column, row);
            let color = if self.flat {
                self.color.map(|plane| plane.at)
            } else {
                self.color.map(|plane| plane.value(column, row) * w)
            };
            let uv = self.uv.map(|plane| plane.value(column, row) * w);
            let footprint = || {
                let change = |plane: &Plane, value: f32| {
                    [(plane.dx - value * self.inverse_w.dx) * w, (plane.dy - value * self.inverse_w.dy) * w]
                };
                let [[ux, uy], [vx, vy]] = [change(&self.uv[0], uv[0]), change(&self.uv[1], uv[1])];
                [[ux, vx], [uy, vy]]
            };
            if let Some(color) = surface.fragment(color, uv, footprint) {
                meet(pixel, depth, fragment_depth, color, surface.mode);
            }
        }
    }
}
