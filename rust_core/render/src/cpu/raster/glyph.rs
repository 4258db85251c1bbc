//! Glyphs that stand upright in the picture.
//!
//! Text turns to the eye. Unless the projection is skewed, the quad of a glyph is then a rectangle of pixels with one
//! depth, over which one texture coordinate changes along a row and the other along a column. So the level of the
//! texture is chosen once for a triangle, its columns are found once for all rows, and nothing is divided by w. Both
//! triangles are drawn together, eight pixels of a row at once. The pixels are those of the quad's two
//! [triangles](super::triangle), with the same arithmetic, and large glyphs are drawn as these.

use std::ops::Range;

use fearless_simd::prelude::*;
use fearless_simd::{dispatch, Simd};
use rcs_scene::{Glyph, Text};
use wide::f32x4;

use super::clip::Outside;
use super::edges::{Edge, RowEdges, MAX_ROWS};
use super::triangle::{self, Corner, Plane, Slopes};
use crate::cpu::paint::{in_channel, level, Paint, Surface};
use crate::cpu::texture::{GreyTexels, MipTexture, Sampler};
use crate::cpu::tile::band::{Band, Mode};
use crate::cpu::tile::lanes::{lane_indices, map, whole, F, I, LANES, M, U};
use crate::cpu::tile::screen::{snap_lanes, ObjectTransform, Screen, ScreenPosition, FARTHEST};

/// True if the quads of a text are drawn here: they are textured rectangles of the picture, whose x depends on x alone,
/// y on y alone and depth on neither.
pub(in crate::cpu) fn are_upright(surface: &Surface, transform: &ObjectTransform) -> bool {
    let [x, y, z, w] = &transform.clip_from_object;
    [x[1], y[0], z[0], z[1], w[0], w[1]] == [0.0; 6] && matches!(surface.paint, Paint::Texture(_))
}

/// The part common to the glyphs of an upright text on the picture.
#[derive(Clone, Copy, Debug)]
pub(in crate::cpu) struct Line {
    /// One over w.
    inverse_w: f32,
    /// Of the quads, before the surface's bias.
    depth: f32,
    /// Each channel 0 to 1.
    color: [f32; 4],
}

/// How the glyphs of a text are painted.
pub(in crate::cpu) struct Ink<'a> {
    surface: &'a Surface,
    texture: &'a MipTexture,
    line: Line,
    /// One for all fragments.
    depth: f32,
    w: f32,
}

impl<'a> Ink<'a> {
    /// Of a text with this surface; `None` where that is not painted with a texture.
    pub(in crate::cpu) fn new(surface: &'a Surface, line: Line) -> Option<Self> {
        let Paint::Texture(texture) = &surface.paint else { return None };
        // No depth changes from pixel to pixel.
        let depth = (line.depth - surface.depth_bias.steps).clamp(0.0, FARTHEST);
        Some(Self { surface, texture, line, depth, w: 1.0 / line.inverse_w })
    }
}

/// A glyph on the picture.
#[derive(Clone, Copy, Debug)]
pub(in crate::cpu) struct GlyphRect {
    /// The snapped columns and rows of the upper left and the lower right corner of its quad; text of a negative size
    /// has them elsewhere.
    x: [i32; 2],
    y: [i32; 2],
    /// Of the character.
    code: u16,
}

/// Position of a glyph of an upright text.
pub(in crate::cpu) enum Place {
    /// Beside the picture.
    Unseen,
    /// It has to be cut before it has pixels.
    Cut,
    /// In the picture, at least in part.
    Seen(GlyphRect),
}

/// Finds the glyphs of a text whose quads [are upright](are_upright).
pub(in crate::cpu) struct Placer<'a> {
    transform: &'a ObjectTransform,
    screen: &'a Screen,
    height_m: f32,
    /// Of all quads.
    z: f32,
    w: f32,
    inverse_w: f32,
}

impl<'a> Placer<'a> {
    pub(in crate::cpu) fn new(text: &Text, transform: &'a ObjectTransform, screen: &'a Screen) -> Self {
        let [.., z, w] = transform.clip([0.0; 3]);
        Self { transform, screen, height_m: text.height_m(), z, w, inverse_w: 1.0 / w }
    }

    /// The part common to the glyphs, in the text's colour.
    pub(in crate::cpu) fn line(&self, color: [f32; 4]) -> Line {
        let depth = ScreenPosition::new([0.0, 0.0, self.z, self.w], self.screen).depth;
        Line { inverse_w: self.inverse_w, depth, color }
    }

    /// Position of a glyph.
    #[inline]
    pub(in crate::cpu) fn place(&self, glyph: &Glyph) -> Place {
        let bottom_m = glyph.top_m - self.height_m;
        let [a, b, ..] = &self.transform.clip_from_object;
        let row = |r: &[f32; 4], x: f32, y: f32| r[0] * x + r[1] * y + r[2] * 0.0 + r[3];
        let clip = |x: f32, y: f32| [row(a, x, y), row(b, x, y), self.z, self.w];
        let (first, last) = (clip(glyph.left_m, glyph.top_m), clip(glyph.right_m, bottom_m));
        let outside = [Outside::new(first), Outside::new(last)];
        if outside[0].guard | outside[1].guard != 0 {
            return Place::Cut;
        }
        if outside[0].view & outside[1].view != 0 {
            return Place::Unseen;
        }
        let both = f32x4::new([first[0], first[1], last[0], last[1]]) * f32x4::splat(self.inverse_w);
        let [left, top, right, bottom] = snap_lanes(self.screen.window_twice(both)).to_array();
        let rect = GlyphRect { x: [left, right], y: [top, bottom], code: glyph.code() };
        let touches = |(first, after): (i32, i32), end: u32| first.max(0) < after.min(end as i32);
        if touches(rect.columns(), self.screen.width_px) && touches(rect.rows(), self.screen.height_px) {
            Place::Seen(rect)
        } else {
            Place::Unseen
        }
    }
}

impl GlyphRect {
    /// In the place of a glyph that is not drawn as a rectangle.
    pub(in crate::cpu) const NONE: Self = Self { x: [0; 2], y: [0; 2], code: u16::MAX };

    /// True if it is drawn as a rectangle.
    pub(in crate::cpu) fn is_some(&self) -> bool {
        self.code != u16::MAX
    }

    /// Columns that it reaches over: the first one and the one after the last; may lie outside of the picture.
    fn columns(&self) -> (i32, i32) {
        let [first, last] = self.x;
        triangle::between(first, last, last)
    }

    /// Rows that it reaches over: the first one and the one after the last; may lie outside of the picture.
    pub(in crate::cpu) fn rows(&self) -> (i32, i32) {
        let [first, last] = self.y;
        triangle::between(first, last, last)
    }

    /// Draws the rows of a band.
    pub(in crate::cpu) fn draw(&self, ink: &Ink<'_>, band: &mut Band<'_>) {
        let ([left, right], [top, bottom], [u1, v1, u2, v2]) = (self.x, self.y, Glyph::uv_of(self.code));
        let Line { inverse_w, depth, color } = ink.line;
        let corner = |x, y, uv| Corner { position: ScreenPosition { x, y, depth, inverse_w }, color, uv };
        let quad = [
            corner(left, top, [u1, v1]),
            corner(left, bottom, [u1, v2]),
            corner(right, top, [u2, v1]),
            corner(right, bottom, [u2, v2]),
        ];
        let [a, b, c, d, e, f] = Text::QUAD_INDICES;
        let halves = [[&quad[a], &quad[b], &quad[c]], [&quad[d], &quad[e], &quad[f]]];
        if let Some(small) = SmallGlyph::new(self, halves, ink, band) {
            dispatch!(band.simd_level, simd => small.draw(simd, band));
            return;
        }
        halves.into_iter().for_each(|half| triangle::draw(half, ink.surface, band));
    }
}

/// A small glyph, whose two triangles are drawn together: of each row eight pixels at once, each from the triangle that
/// covers it.
struct SmallGlyph<'a> {
    halves: [Half<'a>; 2],
    edges: [[Edge<i32>; 3]; 2],
    texels: &'a GreyTexels,
    /// Its columns in the picture, and its rows in the band.
    columns: Range<i32>,
    rows: Range<i32>,
    /// The pixel from which the edges are measured.
    origin: (i32, i32),
}

impl<'a> SmallGlyph<'a> {
    const MAX_WIDTH_PX: i32 = 64;

    /// Of the triangles of a rectangle. `None` where it is not small, and where the texture has colours or is read in
    /// two sizes.
    #[inline]
    fn new(rect: &GlyphRect, halves: [[&Corner; 3]; 2], ink: &'a Ink<'a>, band: &Band<'_>) -> Option<Self> {
        let ((left, right), (top, bottom)) = (rect.columns(), rect.rows());
        if right - left > Self::MAX_WIDTH_PX || bottom - top > MAX_ROWS {
            return None;
        }
        let ((a, area_a), (b, area_b)) = (triangle::clockwise(halves[0])?, triangle::clockwise(halves[1])?);
        let around = |corners: [&Corner; 3]| {
            Edge::around(corners.map(|corner| &corner.position)).map(|edge| edge.measured_at(left, top))
        };
        let edges = [around(a), around(b)];
        let halves = [Half::new(a, area_a, ink), Half::new(b, area_b, ink)];
        let (texels, others) = (ink.texture.grey(&halves[0].sampler)?, ink.texture.grey(&halves[1].sampler)?);
        if !std::ptr::eq(texels, others) {
            return None;
        }
        let (columns, rows) = (left.max(0)..right.min(band.width), band.rows(top, bottom));
        Some(Self { halves, edges, texels, columns, rows, origin: (left, top) })
    }

    #[inline(always)]
    fn draw<S: Simd>(&self, simd: S, band: &mut Band<'_>) {
        let halves = [&self.halves[0], &self.halves[1]];
        for begin in self.columns.clone().step_by(LANES) {
            let x = lane_indices(simd) + begin;
            let columns = map(
                halves,
                #[inline(always)]
                |half| half.columns(x.to_float(), self.texels),
            );
            for top in self.rows.clone().step_by(LANES) {
                let y = lane_indices(simd) + top;
                let rows = map(
                    halves,
                    #[inline(always)]
                    |half| half.rows(y.to_float(), self.texels),
                );
                let edges = map(
                    [&self.edges[0], &self.edges[1]],
                    #[inline(always)]
                    |edges| RowEdges::new(edges, x - self.origin.0, top - self.origin.1),
                );
                let rows = Rows { range: top..self.rows.end.min(top + LANES as i32), places: rows, edges };
                let columns = Columns { begin, places: columns, is_there: x.simd_lt(self.columns.end) };
                self.draw_block(simd, columns, rows, band);
            }
        }
    }

    /// Draws [`LANES`] columns of as many rows.
    #[inline(always)]
    fn draw_block<S: Simd>(&self, simd: S, columns: Columns<S>, rows: Rows<S>, band: &mut Band<'_>) {
        const OPACITIES: u32 = 0xff00_ff00;
        let ink = self.halves[0].ink;
        let Columns { begin, places: columns, is_there } = columns;
        let Rows { range, places: [rows, other_rows], mut edges } = rows;
        let mut row = 0;
        band.for_windows(
            range,
            begin,
            #[inline(always)]
            |window| {
                let at = row % LANES;
                row += 1;
                let [first, second] = [edges[0].next(), edges[1].next()];
                let mask = (first | second) & is_there;
                let pairs = map(
                    [0, 1],
                    #[inline(always)]
                    |side: usize| {
                        let texels = columns[0].0 + rows.begin[side][at];
                        let texels = first.select(texels, columns[1].0 + other_rows.begin[side][at]);
                        let pairs = map(
                            texels.to_array(),
                            #[inline(always)]
                            |texel| self.texels.pairs.get(texel as usize).copied().unwrap_or_default(),
                        );
                        U::load_array(simd, pairs)
                    },
                );
                let [upper, lower] = pairs;
                // What is fully transparent leaves a pixel as it is.
                let is_seen = mask & ((upper | lower) & OPACITIES).simd_gt(0);
                if ink.surface.mode == Mode::TRANSLUCENT && !is_seen.any_true() {
                    return;
                }
                let right = first.select(columns[0].1, columns[1].1);
                let down = first.select(F::splat(simd, rows.way[at]), F::splat(simd, other_rows.way[at]));
                let depths = F::splat(simd, ink.depth);
                window.meet(
                    mask,
                    depths,
                    ink.surface.mode,
                    #[inline(always)]
                    |seen| (seen, ink.color(pairs, right, down)),
                );
            },
        );
    }
}

impl Ink<'_> {
    /// The colours between two rows of pairs of texels.
    #[inline(always)]
    fn color<S: Simd>(&self, pairs: [U<S>; 2], right: F<S>, down: F<S>) -> U<S> {
        let (brightness, opacity) = (mix(pairs, 0, right, down), mix(pairs, 8, right, down));
        let [r, g, b, a] = self.line.color;
        in_channel(level(brightness * r), 0)
            | in_channel(level(brightness * g), 1)
            | in_channel(level(brightness * b), 2)
            | in_channel(level(opacity * a), 3)
    }
}

/// Columns of a small glyph.
#[derive(Clone, Copy)]
struct Columns<S: Simd> {
    begin: i32,
    /// Their places in the texture, in each of the triangles.
    places: [(I<S>, F<S>); 2],
    /// The columns that the glyph has.
    is_there: M<S>,
}

/// Rows of a small glyph.
struct Rows<S: Simd> {
    range: Range<i32>,
    /// Their places in the texture, in each of the triangles.
    places: [RowPlaces; 2],
    edges: [RowEdges<S, 3>; 2],
}

/// Places of rows of pixels in a texture.
#[derive(Clone, Copy)]
struct RowPlaces {
    /// First texels in [`GreyTexels::pairs`] of the rows above each and below.
    begin: [[i32; LANES]; 2],
    /// The way from the upper to the lower.
    way: [f32; LANES],
}

/// As [`Sampler::mix`], of one of the two numbers in each half of the pairs.
#[inline(always)]
fn mix<S: Simd>(rows: [U<S>; 2], shift: u32, right: F<S>, down: F<S>) -> F<S> {
    let [top, bottom] = map(
        rows,
        #[inline(always)]
        |pairs| {
            let [a, b] = map(
                [shift, shift + 16],
                #[inline(always)]
                |shift| ((pairs >> shift) & 255).bitcast::<I<S>>().to_float::<F<S>>(),
            );
            a + (b - a) * right
        },
    );
    (top + (bottom - top) * down) / 255.0
}

/// The texels before some places, and the ways to the next, as in [`Sampler`].
#[inline(always)]
fn between<S: Simd>(place: F<S>) -> (I<S>, F<S>) {
    let place = place - 0.5;
    let cut = whole(place);
    let texel = cut.to_float::<F<S>>().simd_gt(place).select(cut - 1, cut);
    (texel, place - texel.to_float::<F<S>>())
}

/// A triangle of a glyph, ready to be drawn.
struct Half<'a> {
    /// Divided by w.
    u: Plane,
    v: Plane,
    sampler: Sampler<'a>,
    ink: &'a Ink<'a>,
}

impl<'a> Half<'a> {
    /// Of corners whose inside is on the right of each edge as the picture shows it.
    #[inline]
    fn new(corners: [&Corner; 3], doubled_area: i64, ink: &'a Ink<'a>) -> Self {
        let [a, b, c] = corners;
        let slopes = Slopes::new([&a.position, &b.position, &c.position], doubled_area);
        let of = |value: fn(&Corner) -> f32| slopes.plane([value(a), value(b), value(c)]);
        let u = of(|corner| corner.uv[0] * corner.position.inverse_w);
        let v = of(|corner| corner.uv[1] * corner.position.inverse_w);
        let sampler = ink.texture.sampler(|| [[u.dx * ink.w, 0.0], [0.0, v.dy * ink.w]]);
        Self { u, v, sampler, ink }
    }

    /// The places of some columns of pixels in a row of [`GreyTexels::pairs`], and the ways.
    #[inline(always)]
    fn columns<S: Simd>(&self, x: F<S>, texels: &GreyTexels) -> (I<S>, F<S>) {
        let Plane { at, dx, .. } = self.u;
        let (texel, way) = between((x * dx + at) * self.ink.w * self.sampler.size()[0]);
        (texel.max(-1).min(texels.last[1]) + 1, way)
    }

    /// The places of some rows of pixels in the texture.
    #[inline(always)]
    fn rows<S: Simd>(&self, y: F<S>, texels: &GreyTexels) -> RowPlaces {
        let Plane { at, dy, .. } = self.v;
        let (texel, way) = between((y * dy + at) * self.ink.w * self.sampler.size()[1]);
        let [last, stride] = [texels.last[0], texels.last[1] + 2];
        let (upper, lower) = (texel.max(0).min(last), texel.max(-1).min(last - 1) + 1);
        RowPlaces { begin: [(upper * stride).to_array(), (lower * stride).to_array()], way: way.to_array() }
    }
}
