//! The surface of a triangle: how its fragments get their colour and meet the pixels.

use std::sync::Arc;

use rcs_scene::{CellSheet, CullMode, Material};

use super::band::{unorm8, Mode};
use super::texture::MipTexture;
use crate::shading::{box_brightness, disc_brightness, edge_contrast, inside, with_edge, DISC_RADIUS_SQUARED};

/// How a fragment gets its colour.
#[derive(Clone, Debug)]
pub(super) enum Paint {
    /// The interpolated vertex colour.
    Color,
    /// The interpolated vertex colour times a texture.
    Texture(Arc<MipTexture>),
    /// Cells, by the texture coordinates.
    Cells(CellSheet),
    /// One colour with a contrasting edge. The texture coordinates reach from −0.5 to 0.5.
    Edged,
    /// One colour with a darker edge: a box's side.
    BoxSide,
    /// The disc of diameter 1 around the texture coordinates' origin, darker to its rim.
    Disc,
}

/// A surface.
#[derive(Clone, Debug)]
pub(super) struct Surface {
    /// Where the colour comes from.
    pub paint: Paint,
    /// How fragments meet the pixels.
    pub mode: Mode,
    /// Which side is not drawn.
    pub cull: CullMode,
    /// How much nearer it is drawn than it is.
    pub depth_bias: DepthBias,
}

/// A shift of depth towards the eye.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct DepthBias {
    /// Smallest depth steps.
    pub steps: f32,
    /// Changes of the depth from a pixel to the next.
    pub slopes: f32,
}

impl DepthBias {
    /// None.
    pub(super) const NONE: Self = Self { steps: 0.0, slopes: 0.0 };
}

impl Surface {
    /// The surface of a mesh.
    pub(super) fn of(material: &Material, texture: Option<Arc<MipTexture>>) -> Self {
        Self {
            paint: texture.map_or(Paint::Color, Paint::Texture),
            mode: Mode {
                blend: material.blending == rcs_scene::Blending::Alpha,
                depth_test: material.depth_test,
                depth_write: material.depth_write && material.depth_test,
            },
            cull: material.cull,
            depth_bias: DepthBias { steps: material.depth_bias, slopes: material.depth_bias },
        }
    }

    /// The surface of cells.
    pub(super) fn of_cells(sheet: &CellSheet) -> Self {
        Self {
            paint: Paint::Cells(sheet.clone()),
            mode: Mode {
                blend: sheet.blending == rcs_scene::Blending::Alpha,
                depth_test: true,
                depth_write: sheet.depth_write,
            },
            cull: CullMode::None,
            depth_bias: DepthBias { steps: -CellSheet::DEPTH_STEPS_BACK, slopes: 0.0 },
        }
    }

    /// The surface with its sides exchanged: Ogre turns the culling round for objects that are mirrored.
    pub(super) fn mirrored(self) -> Self {
        let cull = match self.cull {
            CullMode::None => CullMode::None,
            CullMode::Back => CullMode::Front,
            CullMode::Front => CullMode::Back,
        };
        Self { cull, ..self }
    }

    /// A fragment's colour; `None` where there is none. Where it matters, `footprint` gives the
    /// change of the texture coordinates to the next pixel along the row and along the column.
    #[inline]
    pub(super) fn fragment(
        &self,
        color: [f32; 4],
        uv: [f32; 2],
        footprint: impl Fn() -> [[f32; 2]; 2],
    ) -> Option<[u8; 4]> {
        let bytes = match &self.paint {
            Paint::Color => color.map(unorm8),
            Paint::Texture(texture) => {
                let texel = if self.mode == Mode::TRANSLUCENT {
                    // What is fully transparent leaves a pixel as it is.
                    texture.sample_visible(uv, footprint)?
                } else {
                    texture.sample(uv, footprint)
                };
                [0, 1, 2, 3].map(|i| unorm8(color[i] * texel[i]))
            }
            Paint::Cells(sheet) => cell_color(sheet, uv),
            Paint::Edged => {
                let ([r, g, b, _], [u, v]) = (color, uv);
                let (contrast, inside) = (edge_contrast(r, g, b), inside(u, v));
                with_rgb(color, |channel| with_edge(channel, contrast, inside))
            }
            Paint::BoxSide => {
                let brightness = box_brightness(inside(uv[0], uv[1]));
                with_rgb(color, |channel| channel * brightness)
            }
            Paint::Disc => {
                let distance_squared = uv[0] * uv[0] + uv[1] * uv[1];
                if distance_squared >= DISC_RADIUS_SQUARED {
                    return None;
                }
                let brightness = disc_brightness(distance_squared);
                with_rgb(color, |channel| channel * brightness)
            }
        };
        Some(bytes)
    }
}

/// A colour with its red, green and blue changed, as bytes.
#[inline]
fn with_rgb([r, g, b, a]: [f32; 4], change: impl Fn(f32) -> f32) -> [u8; 4] {
    [change(r), change(g), change(b), a].map(unorm8)
}

/// The colour of the cell at a place. The cells repeat outside of 0 to 1, which shows where an edge runs through a
/// pixel.
#[inline]
fn cell_color(sheet: &CellSheet, [u, v]: [f32; 2]) -> [u8; 4] {
    let index = |place: f32, count: u32| {
        // Within the picture places are hardly outside of 0 to 1, so that this fits.
        let cell = (place * count as f32).floor() as i64;
        cell.rem_euclid(i64::from(count.max(1))) as u32
    };
    let cells = &sheet.cells;
    let value = cells.get(index(u, cells.width()), index(v, cells.height()));
    let [r, g, b, a] = sheet.palette[usize::from(value)];
    [r, g, b, unorm8(f32::from(a) / 255.0 * sheet.alpha)]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fragment(paint: Paint, color: [u8; 4], uv: [f32; 2]) -> Option<[u8; 4]> {
        let surface = Surface { paint, mode: Mode::OPAQUE, cull: CullMode::None, depth_bias: DepthBias::NONE };
        surface.fragment(color.map(|c| f32::from(c) / 255.0), uv, || [[0.0; 2]; 2])
    }

    #[test]
    fn the_edge_of_a_square_contrasts_with_its_inside() {
        assert_eq!(fragment(Paint::Edged, [10, 20, 30, 99], [0.0, 0.4]), Some([10, 20, 30, 99]));
        assert_eq!(fragment(Paint::Edged, [10, 20, 30, 99], [0.0, -0.49]), Some([61, 71, 81, 99]));
        assert_eq!(fragment(Paint::Edged, [200, 20, 250, 255], [0.49, 0.0]), Some([149, 0, 199, 255]));
    }

    #[test]
    fn the_edge_of_a_box_is_half_as_bright() {
        assert_eq!(fragment(Paint::BoxSide, [200, 100, 0, 7], [0.2, -0.1]), Some([200, 100, 0, 7]));
        assert_eq!(fragment(Paint::BoxSide, [200, 100, 0, 7], [0.2, -0.485]), Some([100, 50, 0, 7]));
    }

    #[test]
    fn a_sphere_is_darker_to_its_rim() {
        assert_eq!(fragment(Paint::Disc, [200, 100, 0, 255], [0.0, 0.0]), Some([200, 100, 0, 255]));
        assert_eq!(fragment(Paint::Disc, [200, 100, 0, 255], [0.3, 0.4]), None);
        let half = 0.5 * std::f32::consts::FRAC_1_SQRT_2;
        assert_eq!(fragment(Paint::Disc, [200, 100, 0, 255], [half, 0.0]), Some([180, 90, 0, 255]));
    }
}
