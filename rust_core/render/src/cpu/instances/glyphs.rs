//! Glyphs that stand upright in the picture.
//!
//! Text turns to the eye. Unless the projection is skewed, the quad of a glyph is then a rectangle of pixels with one
//! depth, over which one texture coordinate changes along a row and the other along a column. So the level of the
//! texture is chosen once for a triangle, its columns are found once for all rows, and nothing is divided by w. The
//! pixels are those of the quad's two [triangles], with the same arithmetic.

use rcs_scene::{Glyph, Text};

use crate::cpu::band::{meet, unorm8, Band, Mode};
use crate::cpu::clip::Outside;
use crate::cpu::ranked::Extent;
use crate::cpu::screen::{ObjectTransform, Screen, FARTHEST};
use crate::cpu::surface::{Paint, Surface};
use crate::cpu::texture::{Between, MipTexture, Sampler};
use crate::cpu::triangles::{self, Corner, Planes, ScreenPosition};

/// Columns that are found at once.
const COLUMNS: usize = 32;

/// Whether the quads of a text are drawn here: they are textured rectangles of the picture, whose x depends on x alone,
/// y on y alone and depth on neither.
pub(super) fn are_upright(surface: &Surface, transform: &ObjectTransform) -> bool {
    let [x, y, z, w] = &transform.clip_from_object;
    [x[1], y[0], z[0], z[1], w[0], w[1]] == [0.0; 6] && matches!(surface.paint, Paint::Texture(_))
}

/// How the glyphs of a text are painted.
pub(super) struct Ink<'a> {
    surface: &'a Surface,
    texture: &'a MipTexture,
    color: [f32; 4],
}

impl<'a> Ink<'a> {
    /// Of the surface and the colour of a text, each channel 0 to 1; `None` where it is not painted with a texture.
    pub(super) fn new(surface: &'a Surface, color: [f32; 4]) -> Option<Self> {
        let Paint::Texture(texture) = &surface.paint else { return None };
        Some(Self { surface, texture, color })
    }
}

/// A glyph on the picture.
#[derive(Clone, Copy, Debug)]
pub(super) struct GlyphRect {
    /// The upper left, lower left, upper right and lower right corner of its quad; text of a negative size has them
    /// elsewhere.
    corners: [ScreenPosition; 4],
    /// Texture coordinates of its left, upper, right and lower edge.
    uv: [f32; 4],
}

/// Where a glyph of an upright text is.
pub(super) enum Place {
    /// Beside the picture.
    Unseen,
    /// It has to be cut before it has pixels.
    Cut,
    /// In the picture, at least in part.
    Seen(GlyphRect),
}

impl GlyphRect {
    /// Finds a glyph of a text whose quads [are upright](are_upright).
    pub(super) fn place(text: &Text, glyph: &Glyph, transform: &ObjectTransform, screen: &Screen) -> Place {
        let bottom_m = glyph.top_m - text.height_m();
        let corners = [[glyph.left_m, glyph.top_m, 0.0], [glyph.right_m, bottom_m, 0.0]];
        let [first, last] = corners.map(|corner| transform.clip(corner));
        let outside = [Outside::new(first), Outside::new(last)];
        if outside[0].guard | outside[1].guard != 0 {
            return Place::Cut;
        }
        if outside[0].view & outside[1].view != 0 {
            return Place::Unseen;
        }
        let [first, last] = [first, last].map(|corner| ScreenPosition::new(corner, screen));
        let corners = [first, ScreenPosition { y: last.y, ..first }, ScreenPosition { x: last.x, ..first }, last];
        let rect = Self { corners, uv: glyph.uv() };
        let touches = |(first, after): (i32, i32), end: u32| first.max(0) < after.min(end as i32);
        if touches(rect.columns(), screen.width_px) && touches(rect.rows(), screen.height_px) {
            Place::Seen(rect)
        } else {
            Place::Unseen
        }
    }

    /// Columns that it reaches over: the first one and the one after the last; may lie outside of the picture.
    fn columns(&self) -> (i32, i32) {
        let [first, .., last] = &self.corners;
        triangles::between(first.x, last.x, last.x)
    }

    /// Rows that it reaches over: the first one and the one after the last; may lie outside of the picture.
    pub(super) fn rows(&self) -> (i32, i32) {
        let [first, .., last] = &self.corners;
        triangles::between(first.y, last.y, last.y)
    }

    /// How large each of its two triangles is.
    pub(super) fn extent(&self, screen: &Screen) -> Extent {
        let [a, b, c, _] = &self.corners;
        triangles::extent([a, b, c], screen)
    }

    /// Draws the rows of a band.
    pub(super) fn draw(&self, ink: &Ink<'_>, band: &mut Band<'_>) {
        let [u1, v1, u2, v2] = self.uv;
        let uv = [[u1, v1], [u1, v2], [u2, v1], [u2, v2]];
        let corner = |i: usize| Corner { position: self.corners[i], color: ink.color, uv: uv[i] };
        let [a, b, c, d, e, f] = Text::QUAD_INDICES.map(corner);
        draw_half([&a, &b, &c], ink, band);
        draw_half([&d, &e, &f], ink, band);
    }
}

/// Draws one of the two triangles of a glyph.
fn draw_half(corners: [&Corner; 3], ink: &Ink<'_>, band: &mut Band<'_>) {
    let Some((corners, area)) = triangles::clockwise(corners) else { return };
    let positions = corners.map(|corner| &corner.position);
    let (left, right) = triangles::between(positions[0].x, positions[1].x, positions[2].x);
    let half = Half::new(Planes::new(corners, area, ink.surface), ink);
    for begin in (left.max(0)..right.min(band.width)).step_by(COLUMNS) {
        let end = right.min(band.width).min(begin + COLUMNS as i32);
        let mut columns = [Between::default(); COLUMNS];
        for (column, x) in columns.iter_mut().zip(begin..end) {
            *column = half.column(x);
        }
        triangles::for_rows(positions, band, |y, first, after, band| {
            let (first, after) = (first.max(begin), after.min(end));
            if first < after {
                let columns = columns.get((first - begin) as usize..).unwrap_or(&[]);
                half.draw_row(columns, y, first, after, band);
            }
        });
    }
}

/// A triangle of a glyph, ready to be drawn.
struct Half<'a> {
    planes: Planes,
    /// One for all fragments.
    w: f32,
    sampler: Sampler<'a>,
    ink: &'a Ink<'a>,
}

impl<'a> Half<'a> {
    fn new(planes: Planes, ink: &'a Ink<'a>) -> Self {
        let w = 1.0 / planes.inverse_w.at;
        let [u, v] = &planes.uv;
        let sampler = ink.texture.sampler(|| [[u.dx * w, 0.0], [0.0, v.dy * w]]);
        Self { planes, w, sampler, ink }
    }

    /// Where a column of pixels is in the texture.
    #[inline]
    fn column(&self, x: i32) -> Between {
        self.sampler.column(self.planes.uv[0].value(x as f32, 0.0) * self.w)
    }

    /// Draws the pixels of a row whose columns were found, from the first of them on.
    #[inline]
    fn draw_row(&self, columns: &[Between], y: i32, first: i32, after: i32, band: &mut Band<'_>) {
        let Self { planes, sampler, ink, .. } = self;
        let mode = ink.surface.mode;
        let depth = planes.depth.at.clamp(0.0, FARTHEST);
        let row = sampler.row(planes.uv[1].value(0.0, y as f32) * self.w);
        let (_, colors, depths) = band.span(y, first, after);
        for ((pixel, pixel_depth), &column) in colors.iter_mut().zip(depths).zip(columns) {
            if mode.depth_test && depth > *pixel_depth {
                continue;
            }
            let texels = sampler.texels(column, row);
            // What is fully transparent leaves a pixel as it is.
            if mode == Mode::TRANSLUCENT && texels.as_flattened().iter().all(|[.., alpha]| *alpha == 0) {
                continue;
            }
            let ([r, g, b, a], [ink_r, ink_g, ink_b, ink_a]) = (sampler.mix(texels, column, row), ink.color);
            let color = [unorm8(ink_r * r), unorm8(ink_g * g), unorm8(ink_b * b), unorm8(ink_a * a)];
            meet(pixel, pixel_depth, depth, color, mode);
        }
    }
}
