//! Sampling textures.
//!
//! Mipmaps are made by averaging two by two texels and rounding, down to one texel. The level of a fragment is the one
//! whose texels are nearest in size to a pixel, by the larger of the distances that the place in the texture moves
//! from a pixel to the next in its row and in its column.

use std::sync::Arc;

use fearless_simd::prelude::*;
use fearless_simd::Simd;
use rcs_scene::{Filtering, Texture, Wrapping};

use super::tile::color::{channel_shift, pack};
use super::tile::lanes::{inlined, map, F, I, LANES, M, U};
use crate::cache::Derived;

/// A texture with its smaller copies.
#[derive(Clone, Debug)]
pub(in crate::cpu) struct MipTexture {
    full: Arc<Texture>,
    /// Its smaller copies, where the filtering asks for them.
    smaller: Arc<[Texture]>,
}

/// The smaller copies of the textures that are alive.
pub(in crate::cpu) type Textures = Derived<Texture, Arc<[Texture]>>;

impl MipTexture {
    /// A texture with its mipmaps out of the cache, which are made now if there are none.
    pub(in crate::cpu) fn new(texture: &Arc<Texture>, textures: &mut Textures) -> Self {
        let copies = |texture: &Texture| match texture.filtering {
            Filtering::BilinearMipmap => std::iter::successors(texture.halved(), Texture::halved).collect(),
            _ => Arc::default(),
        };
        Self { full: texture.clone(), smaller: textures.get(texture, copies).clone() }
    }

    /// The texture's colours at the texture coordinates of the lanes seen, each channel 0 to 1. `level` is the
    /// [level](Self::level_for) of all of them, or else `level_of` gives that of a lane.
    #[inline(always)]
    pub(in crate::cpu) fn sample<S: Simd>(
        &self,
        uv: [F<S>; 2],
        seen: M<S>,
        level: Option<usize>,
        level_of: impl Fn(usize, [f32; 2]) -> usize,
    ) -> [F<S>; 4] {
        if let Some(level) = level {
            return sample(self.level(level), uv, seen);
        }
        let ([u, v], mut left) = ([uv[0].to_array(), uv[1].to_array()], seen.to_bitmask());
        let mut levels = [0; LANES];
        while left != 0 {
            let lane = left.trailing_zeros() as usize % LANES;
            left &= left - 1;
            levels[lane] = level_of(lane, [u[lane], v[lane]]) as u32;
        }
        // The lanes of one level after the other.
        let (lanes, mut left, mut colors) = (U::load_array(seen.token(), levels), seen, [uv[0]; 4]);
        while left.any_true() {
            let level = levels[left.to_bitmask().trailing_zeros() as usize % LANES];
            let same = left & lanes.simd_eq(level);
            let sampled = sample(self.level(level as usize), uv, same);
            for channel in 0..4 {
                colors[channel] = same.select(sampled[channel], colors[channel]);
            }
            left &= !same;
        }
        colors
    }

    fn level(&self, index: usize) -> &Texture {
        index.checked_sub(1).and_then(|i| self.smaller.get(i)).unwrap_or(&self.full)
    }

    /// True if it has smaller copies.
    pub(in crate::cpu) fn has_smaller(&self) -> bool {
        !self.smaller.is_empty()
    }

    /// The level for a change of the texture coordinates to the next pixel along the row and along the column, which
    /// is asked for where it matters.
    #[inline]
    pub(in crate::cpu) fn level_for(&self, footprint: impl FnOnce() -> [[f32; 2]; 2]) -> usize {
        if self.smaller.is_empty() {
            return 0;
        }
        let footprint = footprint();
        let (width, height) = (self.full.width as f32, self.full.height as f32);
        let texels = footprint.map(|[du, dv]| (du * width).hypot(dv * height));
        let level = (texels[0].max(texels[1]).max(1e-6).log2() + 0.5).floor();
        (level.max(0.0) as usize).min(self.smaller.len())
    }
}

/// The colours of a level at the texture coordinates of the lanes seen, each channel 0 to 1.
#[inline(always)]
fn sample<S: Simd>(level: &Texture, [u, v]: [F<S>; 2], seen: M<S>) -> [F<S>; 4] {
    let ([width, height], is_nearest) = (size(level), level.filtering == Filtering::Nearest);
    let to_center = if is_nearest { 0.0 } else { 0.5 };
    let (x, y) = (u * width as f32 - to_center, v * height as f32 - to_center);
    let (column, row) = (x.floor(), y.floor());
    let nothing = F::splat(seen.token(), 0.0);
    let (right, down) = if is_nearest { (nothing, nothing) } else { (x - column, y - row) };
    let places = map(
        [column, row],
        #[inline(always)]
        |place| seen.select(place, nothing).to_int_precise::<I<S>>(),
    );
    let around = around(level, places);
    map(
        [0, 1, 2, 3],
        #[inline(always)]
        |channel| {
            let [a, b, c, d] = map(
                around,
                #[inline(always)]
                |texels| ((texels >> channel_shift(channel)) & 255).bitcast::<I<S>>().to_float::<F<S>>(),
            );
            let (top, bottom) = (a + (b - a) * right, c + (d - c) * right);
            (top + (bottom - top) * down) / 255.0
        },
    )
}

/// The packed texels at some columns and rows, those to the right of them, and those below both.
#[inline(always)]
fn around<S: Simd>(level: &Texture, [columns, rows]: [I<S>; 2]) -> [U<S>; 4] {
    let [width, height] = size(level);
    let outside = columns.simd_lt(0) | columns.simd_ge(width - 1) | rows.simd_lt(0) | rows.simd_ge(height - 1);
    let load = inlined(
        #[inline(always)]
        |texels: [u32; LANES]| U::load_array(columns.token(), texels),
    );
    // Nearly always all are there and side by side.
    if outside.any_true() || level.rgba.len() < width as usize * height as usize {
        let [[a, b], [c, d]] = wrapped(level, [columns.to_array(), rows.to_array()]);
        [load(a), load(b), load(c), load(d)]
    } else {
        let at = (rows * width + columns).to_array();
        let [a, b] = pairs(&level.rgba, at);
        let [c, d] = pairs(level.rgba.get(width as usize..).unwrap_or(&[]), at);
        [load(a), load(b), load(c), load(d)]
    }
}

/// As [`around`], where some are beyond the texture's edge.
#[inline(never)]
fn wrapped(level: &Texture, [columns, rows]: [[i32; LANES]; 2]) -> [[[u32; LANES]; 2]; 2] {
    let at = |lane: usize, right, down| {
        pack(texel(level, columns[lane].saturating_add(right), rows[lane].saturating_add(down)))
    };
    let all = |right, down| std::array::from_fn(|lane| at(lane, right, down));
    [[all(0, 0), all(1, 0)], [all(0, 1), all(1, 1)]]
}

/// A texel, which is white where it is missing.
#[inline]
fn texel(level: &Texture, x: i32, y: i32) -> [u8; 4] {
    let [width, height] = size(level);
    let (x, y) = match level.wrapping {
        Wrapping::Repeat => (x.rem_euclid(width), y.rem_euclid(height)),
        Wrapping::Clamp => (x.clamp(0, width - 1), y.clamp(0, height - 1)),
    };
    level.rgba.get(y as usize * width as usize + x as usize).copied().unwrap_or([255; 4])
}

/// Width and height, at least 1.
#[inline]
fn size(level: &Texture) -> [i32; 2] {
    [level.width, level.height].map(|side| side.clamp(1, i32::MAX as u32) as i32)
}

/// The packed texels at some places, and those to the right of them.
#[inline(always)]
fn pairs(rgba: &[[u8; 4]], at: [i32; LANES]) -> [[u32; LANES]; 2] {
    let pair = inlined(
        #[inline(always)]
        |lane: usize| match rgba.get(at[lane] as usize..) {
            Some([left, right, ..]) => [pack(*left), pack(*right)],
            _ => [0; 2],
        },
    );
    // Spelled out, so that they need not go through memory.
    let [a, b, c, d, e, f, g, h] = [pair(0), pair(1), pair(2), pair(3), pair(4), pair(5), pair(6), pair(7)];
    [[a[0], b[0], c[0], d[0], e[0], f[0], g[0], h[0]], [a[1], b[1], c[1], d[1], e[1], f[1], g[1], h[1]]]
}

#[cfg(test)]
mod tests {
    use fearless_simd::{dispatch, Level};
    use proptest::prelude::*;

    use super::*;

    fn mipped(texture: Texture) -> MipTexture {
        MipTexture::new(&Arc::new(texture), &mut Textures::default())
    }

    fn gradient(filtering: Filtering, wrapping: Wrapping) -> MipTexture {
        let rgba = (0..16u8).map(|i| [i * 16, 0, 0, 255]).collect();
        mipped(Texture { width: 4, height: 4, rgba, filtering, wrapping })
    }

    fn sample(texture: &MipTexture, [u, v]: [f32; 2], footprint: f32) -> [f32; 4] {
        dispatch!(Level::new(), simd => {
            let uv = [F::splat(simd, u), F::splat(simd, v)];
            let level = |_: usize, _: [f32; 2]| texture.level_for(|| [[footprint, 0.0], [0.0, footprint]]);
            texture.sample(uv, uv[0].simd_eq(u), None, level).map(|channel| channel.to_array()[LANES - 1])
        })
    }

    fn red(texture: &MipTexture, u: f32, v: f32, footprint: f32) -> f32 {
        sample(texture, [u, v], footprint)[0] * 255.0
    }

    #[test]
    fn nearest_takes_the_texel_and_wraps() {
        let texture = gradient(Filtering::Nearest, Wrapping::Repeat);
        assert_eq!(red(&texture, 0.3, 0.3, 0.0), 80.0);
        assert_eq!(red(&texture, 1.3, -0.7, 0.0), 80.0);
        let texture = gradient(Filtering::Nearest, Wrapping::Clamp);
        assert_eq!(red(&texture, 1.3, -0.7, 0.0), 48.0);
    }

    #[test]
    fn bilinear_lies_between_the_texels() {
        let texture = gradient(Filtering::Bilinear, Wrapping::Clamp);
        assert!((red(&texture, 0.25, 0.125, 0.0) - 8.0).abs() < 1e-3);
        assert!((red(&texture, 0.25, 0.25, 0.0) - 40.0).abs() < 1e-3);
    }

    #[test]
    fn far_away_a_smaller_copy_is_sampled() {
        let texture = gradient(Filtering::BilinearMipmap, Wrapping::Repeat);
        assert!((red(&texture, 0.7, 0.7, 1.0) - 120.0).abs() < 1e-3);
        assert!((red(&texture, 0.25, 0.25, 0.5) - 40.0).abs() < 1e-3);
    }

    #[test]
    fn a_texture_with_missing_texels_is_white_there() {
        let texture = Texture {
            width: 2,
            height: 2,
            rgba: vec![[0; 4]],
            filtering: Filtering::Nearest,
            wrapping: Wrapping::Clamp,
        };
        assert_eq!(sample(&mipped(texture), [0.9, 0.9], 0.0), [1.0; 4]);
    }

    fn texture() -> impl Strategy<Value = Texture> {
        let filtering = prop_oneof![Just(Filtering::Nearest), Just(Filtering::Bilinear)];
        let wrapping = prop_oneof![Just(Wrapping::Repeat), Just(Wrapping::Clamp)];
        (1..5_u32, 1..5_u32, 0..17_usize, filtering, wrapping).prop_map(
            |(width, height, missing, filtering, wrapping)| {
                let texel = |i: usize| [i * 37, i * 101, i * 11, i * 59].map(|level| level as u8);
                let rgba = (0..(width * height) as usize).map(texel).take(16 - missing.min(16)).collect();
                Texture { width, height, rgba, filtering, wrapping }
            },
        )
    }

    proptest! {
        #[test]
        fn lanes_have_the_colors_that_their_four_texels_give(
            texture in texture(),
            us in prop::array::uniform8(-2.0..3.0_f32),
            vs in prop::array::uniform8(prop_oneof![-2.0..3.0_f32, 0.2..0.8_f32]),
        ) {
            let [width, height] = size(&texture);
            let expected = |lane: usize, channel: usize| {
                let to_center = if texture.filtering == Filtering::Nearest { 0.0 } else { 0.5 };
                let (x, y) = (us[lane] * width as f32 - to_center, vs[lane] * height as f32 - to_center);
                let texel = |right: i32, down: i32| {
                    let texel = super::texel(&texture, x.floor() as i32 + right, y.floor() as i32 + down);
                    f32::from(texel[channel])
                };
                let between = |one: f32, other: f32, share: f32| match texture.filtering {
                    Filtering::Nearest => one,
                    _ => one + (other - one) * share,
                };
                let row = |down: i32| between(texel(0, down), texel(1, down), x - x.floor());
                between(row(0), row(1), y - y.floor()) / 255.0
            };
            let sampled = dispatch!(Level::new(), simd => {
                let (us, vs) = (F::load_array(simd, us), F::load_array(simd, vs));
                super::sample(&texture, [us, vs], us.simd_eq(us)).map(|channel| channel.to_array())
            });
            for (channel, lanes) in sampled.iter().enumerate() {
                for (lane, sampled) in lanes.iter().enumerate() {
                    prop_assert_eq!(*sampled, expected(lane, channel), "lane {} channel {}", lane, channel);
                }
            }
        }
    }
}
