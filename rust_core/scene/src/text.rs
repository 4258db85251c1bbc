//! Text that turns to the eye.
//!
//! Reproduces `rviz::MovableText`: one quad a glyph, all as tall as a line; a space is as wide as an `A`; lines are
//! 1 cm apart whatever their height.

use std::sync::OnceLock;

use crate::{glyph_atlas, Blending, CullMode, GlyphAtlas, Lighting, Material, Rgba, Vertex};

/// Horizontal place of a text relative to its origin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HorizontalAlignment {
    /// It begins at the origin.
    Left,
    /// Its widest line is centred on the origin (all lines begin at that line's start).
    Center,
}

/// Vertical place of a text relative to its origin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VerticalAlignment {
    /// Its first line hangs below the origin.
    Below,
    /// Its middle is at the origin.
    Center,
    /// Its last line stands on the origin.
    Above,
}

/// Text laid out in the plane z = 0 of its own frame, x along the line, y up, metres. Only the position and the scale
/// of its drawable count: it is turned to the camera.
///
/// A text may have millions of characters, of 16 bytes each; a renderer makes quads of those that are visible.
#[derive(Clone, Debug)]
pub struct Text {
    glyphs: Box<[Glyph]>,
    height_m: f32,
    color: [u8; 4],
    is_on_top: bool,
}

/// A character that leaves ink, and its place in the text.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Glyph {
    /// Left edge of its quad.
    pub left_m: f32,
    /// Right edge.
    pub right_m: f32,
    /// Upper edge; the lower one is a line's height below.
    pub top_m: f32,
    /// The character, below 1000.
    code: u16,
}

const LINE_SPACING_M: f32 = 0.01;

/// The width of a character over the height of its line.
fn advance(atlas: &GlyphAtlas, character: char) -> f32 {
    atlas.glyph(if character == ' ' { 'A' } else { character }).map_or(1.0, |glyph| glyph.aspect)
}

impl Text {
    /// Corners of [`Text::quad`] of a glyph's two triangles.
    pub const QUAD_INDICES: [usize; 6] = [0, 1, 2, 2, 1, 3];

    /// Lays text out. `height_m` is that of a line; newlines begin another.
    pub fn new(caption: &str, height_m: f32, color: Rgba, alignment: (HorizontalAlignment, VerticalAlignment)) -> Self {
        let atlas = glyph_atlas();
        let advance = |character| height_m * advance(atlas, character);
        let (mut width_m, mut lines, mut inked) = (0.0_f32, 0, 0);
        for line in caption.split('\n') {
            width_m = width_m.max(line.chars().map(advance).sum::<f32>());
            lines += 1;
            inked += line.chars().filter(|&character| has_ink(atlas, character)).count();
        }
        let total_height_m = height_m + (lines - 1) as f32 * (height_m + LINE_SPACING_M);
        let left_m = match alignment.0 {
            HorizontalAlignment::Left => 0.0,
            HorizontalAlignment::Center => -width_m / 2.0,
        };
        let mut top_m = match alignment.1 {
            VerticalAlignment::Below => 0.0,
            VerticalAlignment::Center => total_height_m / 2.0,
            VerticalAlignment::Above => total_height_m,
        };
        let mut glyphs = Vec::with_capacity(inked);
        for line in caption.split('\n') {
            let mut left = left_m;
            for character in line.chars() {
                let right = left + advance(character);
                if has_ink(atlas, character) {
                    glyphs.push(Glyph { left_m: left, right_m: right, top_m, code: character as u16 });
                }
                left = right;
            }
            top_m -= height_m + LINE_SPACING_M;
        }
        Self { glyphs: glyphs.into(), height_m, color: color.to_rgba8(), is_on_top: false }
    }

    /// Draws it over everything that was drawn before it.
    pub fn on_top(mut self) -> Self {
        self.is_on_top = true;
        self
    }

    /// The characters that leave ink, line by line.
    pub fn glyphs(&self) -> &[Glyph] {
        &self.glyphs
    }

    /// Height of a line.
    pub fn height_m(&self) -> f32 {
        self.height_m
    }

    /// Colour of all glyphs.
    pub fn color(&self) -> [u8; 4] {
        self.color
    }

    /// The corners of a glyph's quad: the upper left, lower left, upper right and lower right one.
    pub fn quad(&self, glyph: &Glyph) -> [Vertex; 4] {
        let [u1, v1, u2, v2] = glyph.uv();
        let bottom_m = glyph.top_m - self.height_m;
        [
            (glyph.left_m, glyph.top_m, [u1, v1]),
            (glyph.left_m, bottom_m, [u1, v2]),
            (glyph.right_m, glyph.top_m, [u2, v1]),
            (glyph.right_m, bottom_m, [u2, v2]),
        ]
        .map(|(x, y, uv)| Vertex { position: [x, y, 0.0], normal: [0.0, 0.0, 1.0], uv, color: self.color })
    }

    /// Material of the quads.
    pub fn material(&self) -> &'static Material {
        static MATERIALS: OnceLock<[Material; 2]> = OnceLock::new();
        let [plain, on_top] = MATERIALS.get_or_init(|| {
            let plain = Material {
                lighting: Lighting::Unlit,
                texture: Some(glyph_atlas().texture().clone()),
                blending: Blending::Alpha,
                depth_write: false,
                depth_bias: 1.0,
                cull: CullMode::None,
                ..Material::unlit(true)
            };
            let on_top = Material { depth_test: false, depth_write: true, ..plain.clone() };
            [plain, on_top]
        });
        if self.is_on_top {
            on_top
        } else {
            plain
        }
    }
}

impl Glyph {
    /// The character, below 1000.
    pub fn code(&self) -> u16 {
        self.code
    }

    /// Texture coordinates of its left, upper, right and lower edge.
    pub fn uv(&self) -> [f32; 4] {
        Self::uv_of(self.code)
    }

    /// Like [`Self::uv`], given the [code](Self::code).
    pub fn uv_of(code: u16) -> [f32; 4] {
        let glyph = char::from_u32(code.into()).and_then(|character| glyph_atlas().glyph(character));
        glyph.map_or([0.0; 4], |glyph| glyph.uv)
    }
}

fn has_ink(atlas: &GlyphAtlas, character: char) -> bool {
    character != ' ' && atlas.glyph(character).is_some()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bounds(text: &Text) -> ([f32; 2], [f32; 2]) {
        let axis = |i: usize| {
            let corners = text.glyphs().iter().flat_map(|glyph| text.quad(glyph));
            let values = corners.map(move |corner| corner.position[i]);
            [values.clone().fold(f32::INFINITY, f32::min), values.fold(f32::NEG_INFINITY, f32::max)]
        };
        (axis(0), axis(1))
    }

    #[test]
    fn centred_text_has_its_middle_at_the_origin() {
        let text = Text::new("ab\nabcd", 0.2, Rgba::WHITE, (HorizontalAlignment::Center, VerticalAlignment::Center));
        let ([left, right], [bottom, top]) = bounds(&text);
        assert!((left + right).abs() < 1e-6 && (top + bottom).abs() < 1e-6);
        assert!((top - bottom - 0.41).abs() < 1e-6, "two lines of 0.2 m, 1 cm apart");
    }

    #[test]
    fn spaces_and_unknown_characters_take_room_without_a_glyph() {
        let alignment = (HorizontalAlignment::Left, VerticalAlignment::Below);
        let text = Text::new("a b世c", 1.0, Rgba::WHITE, alignment);
        assert_eq!(text.glyphs().len(), 3);
        let ([_, right], [bottom, top]) = bounds(&text);
        let aspect = |c| glyph_atlas().glyph(c).unwrap().aspect;
        let expected = aspect('a') + aspect('A') + aspect('b') + 1.0 + aspect('c');
        assert!((right - expected).abs() < 1e-5);
        assert_eq!((bottom, top), (-1.0, 0.0));
    }

    #[test]
    fn empty_text_has_no_glyphs() {
        let text = Text::new("", 1.0, Rgba::WHITE, (HorizontalAlignment::Center, VerticalAlignment::Above));
        assert!(text.glyphs().is_empty());
    }

    #[test]
    fn a_glyph_takes_16_bytes() {
        assert_eq!(size_of::<Glyph>(), 16);
    }
}
