//! What small faces look like, several pixels at once: the sums of [`surface`](super::surface) for the paints that clouds
//! have, over places that are linear in the window once they are divided by w.

use fearless_simd::prelude::*;
use fearless_simd::Simd;

use super::band::{channel_shift, pack};
use super::faces::BRIGHTNESS;
use super::lanes::{map, F, M, U};
use super::surface::contrast;

/// One colour.
pub(super) const PLAIN: u8 = 0;
/// One colour with a contrasting edge.
pub(super) const EDGED: u8 = 1;
/// One colour with a dark edge: the sides of boxes.
pub(super) const DARK_EDGED: u8 = 2;
/// A disc, darker to its rim.
pub(super) const DISC: u8 = 3;

/// What a face's colour is made of.
pub(super) struct Paint<S: Simd, const PAINT: u8> {
    packed: U<S>,
    /// 0 to 255, with a box's side's brightness.
    rgb: [f32; 3],
    /// 0 to 255.
    contrast: f32,
}

impl<S: Simd, const PAINT: u8> Paint<S, PAINT> {
    /// Of a face of a packed colour; of a box it is the side along or against an axis.
    #[inline(always)]
    pub(super) fn new(simd: S, color: u32, axis: usize, is_along: bool) -> Self {
        if PAINT == PLAIN {
            return Self { packed: U::splat(simd, color), rgb: [0.0; 3], contrast: 0.0 };
        }
        let [r, g, b, a] = color.to_ne_bytes();
        let packed = U::splat(simd, pack([0, 0, 0, a]));
        let brightness = if PAINT == DARK_EDGED { BRIGHTNESS[usize::from(!is_along)][axis] } else { 1.0 };
        let rgb = [f32::from(r) * brightness, f32::from(g) * brightness, f32::from(b) * brightness];
        let contrast = if PAINT == EDGED {
            let [r, g, b] = rgb.map(|c| c / 255.0);
            contrast([r, g, b, 1.0]) * 255.0
        } else {
            0.0
        };
        Self { packed, rgb, contrast }
    }

    /// Which of the places given by 1/w, u/w and v/w belong to the face; see [`super::surface`].
    #[inline(always)]
    pub(super) fn mask(&self, [q, u, v]: [F<S>; 3], mask: M<S>) -> M<S> {
        if PAINT == DISC {
            mask & (u * u + v * v).simd_lt(q * q * 0.25)
        } else {
            mask
        }
    }

    /// The colours at places given by 1/w, u/w and v/w; see [`super::surface`].
    #[inline(always)]
    pub(super) fn colors(&self, [q, u, v]: [F<S>; 3]) -> U<S> {
        if PAINT == PLAIN {
            return self.packed;
        }
        let shade = if PAINT == DISC {
            (u * u + v * v) / (q * q) * -0.8 + 1.0
        } else {
            let w = 1.0 / q;
            let inside = edge_shade(u * w) * edge_shade(v * w);
            if PAINT == EDGED {
                (1.0 - inside) * self.contrast
            } else {
                inside * 0.5 + 0.5
            }
        };
        let [r, g, b] = map(
            self.rgb,
            #[inline(always)]
            |level| if PAINT == EDGED { (shade + level).max(0.0).min(255.0) } else { shade * level },
        );
        self.packed | in_channel(r, 0) | in_channel(g, 1) | in_channel(b, 2)
    }
}

/// How much a place belongs to the inside of a square along one axis.
#[inline(always)]
fn edge_shade<S: Simd>(from_middle: F<S>) -> F<S> {
    let t = ((0.48 - from_middle.abs()) * (1.0 / 0.03)).max(0.0).min(1.0);
    t * t * (3.0 - t * 2.0)
}

/// Levels of 0 to 255, to the nearest whole number, at the place that a channel has in a packed colour.
#[inline(always)]
fn in_channel<S: Simd>(level: F<S>, channel: usize) -> U<S> {
    // At 2^23 there is no fraction left, so that the sum is rounded and its lowest byte is the whole number. The next two
    // are zero, and the first is shifted out of the number where the last is shifted at all.
    const NO_FRACTION: f32 = 8_388_608.0;
    let bits = (level + NO_FRACTION).bitcast::<U<S>>();
    match channel_shift(channel) {
        0 => bits & 255,
        shift => bits << shift,
    }
}
