//! Text that turns to the eye.
//!
//! Reproduces `rviz::MovableText`: one quad a glyph, all as tall as a line; a space is as wide as an `A`; lines are
//! 1 cm apart whatever their height.

use crate::{glyph_atlas, Blending, CullMode, Lighting, Material, Mesh, Rgba, Vertex};

/// Where the text stands to its origin, sideways.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HorizontalAlignment {
    /// It begins at the origin.
    Left,
    /// Its widest line is centred on the origin (all lines begin at that line's start).
    Center,
}

/// Where the text stands to its origin, upwards.
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
#[derive(Clone, Debug)]
pub struct Text {
    mesh: Mesh,
    material: Material,
}

const LINE_SPACING_M: f32 = 0.01;

impl Text {
    /// Lays text out. `height_m` is that of a line; newlines begin another.
    pub fn new(caption: &str, height_m: f32, color: Rgba, alignment: (HorizontalAlignment, VerticalAlignment)) -> Self {
        let atlas = glyph_atlas();
        let advance = |c: char| height_m * atlas.glyph(if c == ' ' { 'A' } else { c }).map_or(1.0, |g| g.aspect);
        let lines: Vec<&str> = caption.split('\n').collect();
        let width_m = lines.iter().map(|line| line.chars().map(advance).sum::<f32>()).fold(0.0, f32::max);
        let total_height_m = height_m + (lines.len() - 1) as f32 * (height_m + LINE_SPACING_M);
        let left_m = match alignment.0 {
            HorizontalAlignment::Left => 0.0,
            HorizontalAlignment::Center => -width_m / 2.0,
        };
        let mut top_m = match alignment.1 {
            VerticalAlignment::Below => 0.0,
            VerticalAlignment::Center => total_height_m / 2.0,
            VerticalAlignment::Above => total_height_m,
        };
        let color = color.to_rgba8();
        let mut mesh = Mesh::default();
        for line in lines {
            let mut x = left_m;
            for character in line.chars() {
                let right = x + advance(character);
                if let Some(glyph) = atlas.glyph(character).filter(|_| character != ' ') {
                    let [u1, v1, u2, v2] = glyph.uv;
                    let bottom_m = top_m - height_m;
                    let base = mesh.vertices.len() as u32;
                    for (x, y, uv) in [
                        (x, top_m, [u1, v1]),
                        (x, bottom_m, [u1, v2]),
                        (right, top_m, [u2, v1]),
                        (right, bottom_m, [u2, v2]),
                    ] {
                        mesh.vertices.push(Vertex { position: [x, y, 0.0], normal: [0.0, 0.0, 1.0], uv, color });
                    }
                    mesh.indices.extend([0, 1, 2, 2, 1, 3].map(|i| base + i));
                }
                x = right;
            }
            top_m -= height_m + LINE_SPACING_M;
        }
        let material = Material {
            lighting: Lighting::Unlit,
            texture: Some(atlas.texture().clone()),
            blending: Blending::Alpha,
            depth_write: false,
            depth_bias: 1.0,
            cull: CullMode::None,
            ..Material::unlit(true)
        };
        Self { mesh, material }
    }

    /// The same text, drawn over everything that was drawn before it.
    pub fn on_top(mut self) -> Self {
        self.material.depth_test = false;
        self.material.depth_write = true;
        self
    }

    /// The glyphs as textured quads in the text's frame.
    pub fn mesh(&self) -> &Mesh {
        &self.mesh
    }

    /// How the quads are drawn.
    pub fn material(&self) -> &Material {
        &self.material
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bounds(text: &Text) -> ([f32; 2], [f32; 2]) {
        let axis = |i: usize| {
            let values = text.mesh().vertices.iter().map(move |v| v.position[i]);
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
        assert_eq!(text.mesh().indices.len(), 3 * 6);
        let ([_, right], [bottom, top]) = bounds(&text);
        let aspect = |c| glyph_atlas().glyph(c).unwrap().aspect;
        let expected = aspect('a') + aspect('A') + aspect('b') + 1.0 + aspect('c');
        assert!((right - expected).abs() < 1e-5);
        assert_eq!((bottom, top), (-1.0, 0.0));
    }

    #[test]
    fn empty_text_has_no_triangles() {
        let text = Text::new("", 1.0, Rgba::WHITE, (HorizontalAlignment::Center, VerticalAlignment::Above));
        assert!(text.mesh().indices.is_empty());
    }
}
