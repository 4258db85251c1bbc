//! Materials of surfaces: light, textures, blending, culling.
//!
//! This is the part of Ogre's fixed-function material that rviz uses. Light is computed for each vertex and
//! interpolated (Gouraud), and rviz's scene has no ambient light, so a material's ambient colour never shows.

use std::sync::Arc;

use crate::Rgba;

/// Combination of a fragment with the pixel behind it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Blending {
    /// The fragment replaces the pixel (Ogre's `SBT_REPLACE`), whatever its alpha.
    #[default]
    Replace,
    /// `colour · alpha + behind · (1 − alpha)` (`SBT_TRANSPARENT_ALPHA`).
    Alpha,
}

/// Side of a triangle that is not drawn. The front is the side from which the vertices run counter-clockwise.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum CullMode {
    /// Both sides are drawn.
    None,
    /// The back is not drawn: Ogre's default, `CULL_CLOCKWISE`.
    #[default]
    Back,
    /// The front is not drawn: `CULL_ANTICLOCKWISE`.
    Front,
}

/// Source of a surface's colour before its texture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Lighting {
    /// The vertex colour where the mesh has one, else white.
    Unlit,
    /// `emissive + diffuse · max(0, n·l)` at each vertex, clamped to 1; the diffuse alpha is the surface's alpha.
    /// Without a light, emissive alone. rviz's light has no specular part, so there is none here.
    Lit {
        /// Diffuse colour and opacity. Replaced by the vertex colour where [`Material::vertex_colors`] is set.
        diffuse: Rgba,
        /// Colour given off in the dark.
        emissive: Rgba,
    },
}

/// Filter of a texture between its texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Filtering {
    /// The nearest texel.
    Nearest,
    /// Between the four nearest texels of the full-size image.
    Bilinear,
    /// Between the four nearest texels of the nearest mipmap level (Ogre's default `TFO_BILINEAR`: linear within a
    /// level, the nearest level).
    BilinearMipmap,
}

/// Continuation of a texture outside of 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wrapping {
    /// It repeats (Ogre's default).
    Repeat,
    /// The edge texel goes on.
    Clamp,
}

/// An image on a surface. Row 0 is at v = 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// Width in texels, at least 1.
    pub width: u32,
    /// Height in texels, at least 1.
    pub height: u32,
    /// `width · height` texels, row by row, red first.
    pub rgba: Vec<[u8; 4]>,
    /// Filter between texels.
    pub filtering: Filtering,
    /// Continuation outside of 0 to 1.
    pub wrapping: Wrapping,
}

/// Material of a mesh.
#[derive(Clone, Debug)]
pub struct Material {
    /// Source of the colour.
    pub lighting: Lighting,
    /// The mesh's vertex colours are used: as the colour when unlit, as the diffuse colour when lit.
    pub vertex_colors: bool,
    /// Multiplied with the colour, alpha included (fixed-function modulate).
    pub texture: Option<Arc<Texture>>,
    /// Combination with the pixels behind it.
    pub blending: Blending,
    /// `true` if it occludes drawables that come later and are farther away.
    pub depth_write: bool,
    /// `true` if nearer drawables that came earlier occlude it.
    pub depth_test: bool,
    /// Draw in front of a surface of the same depth by this many smallest depth steps and slopes
    /// (`glPolygonOffset(-bias, -bias)`); 0 for most.
    pub depth_bias: f32,
    /// Side that is not drawn.
    pub cull: CullMode,
}

impl Material {
    /// A lit surface of one colour, as `rviz::Shape::setColor` makes it: blended and without depth writes when its
    /// opacity is below 0.9998.
    pub fn lit(color: Rgba) -> Self {
        let translucent = color.a < Self::OPAQUE_FROM_ALPHA;
        Self {
            lighting: Lighting::Lit { diffuse: color, emissive: Rgba::TRANSPARENT },
            vertex_colors: false,
            texture: None,
            blending: if translucent { Blending::Alpha } else { Blending::Replace },
            depth_write: !translucent,
            depth_test: true,
            depth_bias: 0.0,
            cull: CullMode::Back,
        }
    }

    /// The colour of a surface that is as [`Material::lit`] makes it; `None` for others.
    pub fn as_lit(&self) -> Option<Rgba> {
        let Lighting::Lit { diffuse, emissive } = self.lighting else { return None };
        let lit = Self::lit(diffuse);
        let is_same = self.texture.is_none()
            && emissive == Rgba::TRANSPARENT
            && (self.vertex_colors, self.depth_bias) == (lit.vertex_colors, lit.depth_bias)
            && (self.blending, self.cull) == (lit.blending, lit.cull)
            && (self.depth_write, self.depth_test) == (lit.depth_write, lit.depth_test);
        is_same.then_some(diffuse)
    }

    /// An unlit surface in its vertex colours; blended and without depth writes when `translucent`.
    pub fn unlit(translucent: bool) -> Self {
        Self { lighting: Lighting::Unlit, vertex_colors: true, ..Self::lit(Rgba::WHITE) }.translucent(translucent)
    }

    /// Makes it blended and without depth writes, or opaque.
    pub fn translucent(mut self, translucent: bool) -> Self {
        self.blending = if translucent { Blending::Alpha } else { Blending::Replace };
        self.depth_write = !translucent;
        self
    }

    /// Alpha from which on rviz takes a colour for opaque.
    pub const OPAQUE_FROM_ALPHA: f32 = 0.9998;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lit_surface_is_known_by_its_colour_and_others_are_not() {
        for alpha in [1.0, 0.5] {
            let color = Rgba::new(0.1, 0.2, 0.3, alpha);
            let lit = Material::lit(color);
            assert_eq!(lit.as_lit(), Some(color));
            let others = [
                Material::unlit(false),
                Material { cull: CullMode::None, ..lit.clone() },
                Material { depth_write: !lit.depth_write, ..lit.clone() },
                Material { lighting: Lighting::Lit { diffuse: color, emissive: Rgba::WHITE }, ..lit },
            ];
            assert!(others.iter().all(|other| other.as_lit().is_none()), "{others:?}");
        }
    }
}
