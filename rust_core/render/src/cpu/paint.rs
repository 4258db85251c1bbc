//! The colours of fragments, several at once: the only place that makes them, but for lines.
//!
//! The formulas are those of [`shading`](crate::shading). A [`Surface`] says how the fragments of triangles get their
//! colour and meet the pixels; [`FaceColor`] is a point's face, whose colour depends on the place on it alone.

use fearless_simd::prelude::*;
use fearless_simd::Simd;
use rcs_scene::{CellSheet, CullMode, Material};

use super::texture::MipTexture;
use super::tile::band::Mode;
use super::tile::color::{channel_shift, pack, unorm8};
use super::tile::lanes::{map, F, LANES, M, U};
use crate::shading::{box_brightness, disc_brightness, edge_contrast, inside, with_edge, DISC_RADIUS_SQUARED};

/// How a fragment gets its colour.
#[derive(Clone, Debug)]
pub(in crate::cpu) enum Paint {
    /// The interpolated vertex colour.
    Color,
    /// The interpolated vertex colour times a texture.
    Texture(MipTexture),
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
pub(in crate::cpu) struct Surface {
    /// Source of the colour.
    pub paint: Paint,
    /// How fragments meet the pixels.
    pub mode: Mode,
    /// Which side is not drawn.
    pub cull: CullMode,
    /// Shift towards the eye.
    pub depth_bias: DepthBias,
}

/// A shift of depth towards the eye.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(in crate::cpu) struct DepthBias {
    /// Smallest depth steps.
    pub steps: f32,
    /// Changes of the depth from a pixel to the next.
    pub slopes: f32,
}

impl DepthBias {
    /// None.
    pub(in crate::cpu) const NONE: Self = Self { steps: 0.0, slopes: 0.0 };
}

impl Surface {
    /// The surface of a mesh.
    pub(in crate::cpu) fn of(material: &Material, texture: Option<MipTexture>) -> Self {
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
    pub(in crate::cpu) fn of_cells(sheet: &CellSheet) -> Self {
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
    pub(in crate::cpu) fn mirrored(self) -> Self {
        let cull = match self.cull {
            CullMode::None => CullMode::None,
            CullMode::Back => CullMode::Front,
            CullMode::Front => CullMode::Back,
        };
        Self { cull, ..self }
    }

    /// Of the fragments seen, given their interpolated vertex colours and texture coordinates, those that the surface
    /// has, and their colours. `texture_level` is that of its texture, or else `level_of` gives it for a lane and its
    /// texture coordinates.
    #[inline(always)]
    pub(in crate::cpu) fn colors<S: Simd>(
        &self,
        color: [F<S>; 4],
        uv: [F<S>; 2],
        seen: M<S>,
        texture_level: Option<usize>,
        level_of: impl Fn(&MipTexture, usize, [f32; 2]) -> usize,
    ) -> (M<S>, U<S>) {
        match &self.paint {
            Paint::Color => {
                let [r, g, b, a] = map(color, level);
                (seen, in_channel(r, 0) | in_channel(g, 1) | in_channel(b, 2) | in_channel(a, 3))
            }
            Paint::Edged => FaceColor::<S, _, EDGED>::of_fragments(color).fragments(uv, seen),
            Paint::BoxSide => FaceColor::<S, _, BOX_SIDE>::of_fragments(color).fragments(uv, seen),
            Paint::Disc => FaceColor::<S, _, DISC>::of_fragments(color).fragments(uv, seen),
            Paint::Texture(texture) => {
                let texel = texture.sample(
                    uv,
                    seen,
                    texture_level,
                    #[inline(always)]
                    |lane, uv| level_of(texture, lane, uv),
                );
                let [r, g, b, a] = map(
                    [0, 1, 2, 3],
                    #[inline(always)]
                    |channel: usize| in_channel(level(color[channel] * texel[channel]), channel),
                );
                (seen, r | g | b | a)
            }
            Paint::Cells(sheet) => (seen, each_seen(uv, seen, |_, uv| pack(cell_color(sheet, uv)))),
        }
    }
}

/// The packed colours of the fragments seen, each looked up by its texture coordinates.
fn each_seen<S: Simd>(uv: [F<S>; 2], seen: M<S>, color: impl Fn(usize, [f32; 2]) -> u32) -> U<S> {
    let [u, v] = uv.map(|all| all.to_array());
    let mut colors = [0; LANES];
    let mut left = seen.to_bitmask();
    while left != 0 {
        let lane = left.trailing_zeros() as usize % LANES;
        left &= left - 1;
        colors[lane] = color(lane, [u[lane], v[lane]]);
    }
    U::load_array(seen.token(), colors)
}

/// A channel of 0 to 1 as a level of 0 to 255; NaN becomes 0.
#[inline(always)]
fn level<S: Simd>(value: F<S>) -> F<S> {
    value.simd_gt(0.0).select(value.min(1.0) * 255.0, F::splat(value.token(), 0.0))
}

/// Levels of 0 to 255, to the nearest whole number, in the place of a channel of a packed colour.
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

/// A face of one colour, for [`FaceColor`].
pub(in crate::cpu) const PLAIN: u8 = 0;
/// As [`Paint::Edged`].
pub(in crate::cpu) const EDGED: u8 = 1;
/// As [`Paint::BoxSide`].
pub(in crate::cpu) const BOX_SIDE: u8 = 2;
/// As [`Paint::Disc`].
pub(in crate::cpu) const DISC: u8 = 3;

/// The colour of a point's face, by the place on it: 1/w, u/w and v/w, in any unit.
///
/// `T` is one level for all of the face, which is an operand from memory then, or one for each fragment.
pub(in crate::cpu) struct FaceColor<S: Simd, T, const PAINT: u8> {
    /// The opacity, or all of a plain colour.
    packed: U<S>,
    /// 0 to 255.
    rgb: [T; 3],
    /// 0 to 255.
    contrast: T,
}

/// A number for all lanes, or one for each.
pub(in crate::cpu) trait Lanes<S: Simd>: Copy {
    /// One for each lane.
    fn lanes(self, simd: S) -> F<S>;
}

impl<S: Simd> Lanes<S> for f32 {
    #[inline(always)]
    fn lanes(self, simd: S) -> F<S> {
        F::splat(simd, self)
    }
}

impl<S: Simd> Lanes<S> for F<S> {
    #[inline(always)]
    fn lanes(self, _: S) -> F<S> {
        self
    }
}

impl<S: Simd, const PAINT: u8> FaceColor<S, f32, PAINT> {
    /// A packed colour, of this brightness.
    #[inline(always)]
    pub(in crate::cpu) fn new(simd: S, color: u32, brightness: f32) -> Self {
        if PAINT == PLAIN {
            return Self { packed: U::splat(simd, color), rgb: [0.0; 3], contrast: 0.0 };
        }
        let [r, g, b, a] = color.to_ne_bytes();
        let rgb = [f32::from(r) * brightness, f32::from(g) * brightness, f32::from(b) * brightness];
        let contrast =
            if PAINT == EDGED { edge_contrast(rgb[0] / 255.0, rgb[1] / 255.0, rgb[2] / 255.0) * 255.0 } else { 0.0 };
        Self { packed: U::splat(simd, pack([0, 0, 0, a])), rgb, contrast }
    }
}

impl<S: Simd, const PAINT: u8> FaceColor<S, F<S>, PAINT> {
    /// Interpolated colours, of 0 to 1.
    #[inline(always)]
    fn of_fragments([r, g, b, a]: [F<S>; 4]) -> Self {
        let contrast = if PAINT == EDGED { edge_contrast(r, g, b) * 255.0 } else { r };
        Self { packed: in_channel(level(a), 3), rgb: [r * 255.0, g * 255.0, b * 255.0], contrast }
    }

    /// The fragments at texture coordinates that belong to the face, and their colours.
    #[inline(always)]
    fn fragments(&self, [u, v]: [F<S>; 2], seen: M<S>) -> (M<S>, U<S>) {
        let place = [F::splat(u.token(), 1.0), u, v];
        (self.mask(place, seen), self.colors(place))
    }
}

impl<S: Simd, T: Lanes<S>, const PAINT: u8> FaceColor<S, T, PAINT> {
    /// The places that belong to the face.
    #[inline(always)]
    pub(in crate::cpu) fn mask(&self, [q, u, v]: [F<S>; 3], mask: M<S>) -> M<S> {
        if PAINT == DISC {
            mask & (u * u + v * v).simd_lt(q * q * DISC_RADIUS_SQUARED)
        } else {
            mask
        }
    }

    /// The colours at places.
    #[inline(always)]
    pub(in crate::cpu) fn colors(&self, [q, u, v]: [F<S>; 3]) -> U<S> {
        if PAINT == PLAIN {
            return self.packed;
        }
        let (simd, w) = (q.token(), 1.0 / q);
        let [r, g, b] = match PAINT {
            EDGED => {
                let (inside, contrast) = (inside(u * w, v * w), self.contrast.lanes(simd));
                map(
                    self.rgb,
                    #[inline(always)]
                    |level| with_edge(level.lanes(simd), contrast, inside).max(0.0).min(255.0),
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
                    |level| brightness * level.lanes(simd),
                )
            }
        };
        self.packed | in_channel(r, 0) | in_channel(g, 1) | in_channel(b, 2)
    }
}

/// The colour of the cell at a place. The cells repeat outside of 0 to 1, which shows where an edge runs through a
/// pixel.
#[inline]
fn cell_color(sheet: &CellSheet, [u, v]: [f32; 2]) -> [u8; 4] {
    let index = |place: f32, count: u32| {
        // Within the image places are hardly outside of 0 to 1, so that this fits.
        let cell = (place * count as f32).floor() as i64;
        cell.rem_euclid(i64::from(count.max(1))) as u32
    };
    let cells = &sheet.cells;
    let value = cells.get(index(u, cells.width()), index(v, cells.height()));
    let [r, g, b, a] = sheet.palette[usize::from(value)];
    [r, g, b, unorm8(f32::from(a) / 255.0 * sheet.alpha)]
}
