//! Sampling textures.
//!
//! Mipmaps are made by averaging two by two texels and rounding, down to one texel. The level of a fragment is the one
//! whose texels are nearest in size to a pixel, by the larger of the distances that the place in the texture moves
//! from a pixel to the next in its row and in its column.

use std::sync::Arc;

use fearless_simd::prelude::*;
use fearless_simd::Simd;
use rcs_scene::{halved, Filtering, Texture, Wrapping};

use super::tile::color::{channel_shift, pack};
use super::tile::lanes::{map, F, I, LANES, M, U};
use crate::cache::Derived;

/// A texture with its smaller copies.
#[derive(Clone, Debug)]
pub(in crate::cpu) struct MipTexture {
    full: Arc<Texture>,
    /// Its smaller copies, where the filtering asks for them.
    smaller: Arc<[Texels]>,
}

/// The mipmaps of the textures that are alive.
pub(in crate::cpu) type Textures = Derived<Texture, Arc<[Texels]>>;

/// The texels of a smaller copy.
#[derive(Debug)]
pub(in crate::cpu) struct Texels {
    width: i32,
    height: i32,
    rgba: Vec<[u8; 4]>,
}

/// One size of the texture. Missing texels are white.
#[derive(Clone, Copy)]
struct MipLevel<'a> {
    width: i32,
    height: i32,
    rgba: &'a [[u8; 4]],
}

impl MipTexture {
    /// A texture with its mipmaps out of the cache, which are made now if there are none.
    pub(in crate::cpu) fn new(texture: &Arc<Texture>, textures: &mut Textures) -> Self {
        let copies = |texture: &Texture| match texture.filtering {
            Filtering::BilinearMipmap => {
                let first = MipLevel::of(texture).halved();
                std::iter::successors(first, |last| last.level().halved()).collect()
            }
            _ => Arc::default(),
        };
        Self { full: texture.clone(), smaller: textures.get(texture, copies).clone() }
    }

    /// The texture's colours at the texture coordinates of some lanes, each channel 0 to 1. `level_of` gives a lane's
    /// [level](Self::level_for).
    #[inline(always)]
    pub(in crate::cpu) fn sample<S: Simd>(
        &self,
        uv: [F<S>; 2],
        seen: M<S>,
        level_of: impl Fn(usize, [f32; 2]) -> usize,
    ) -> [F<S>; 4] {
        let simd = seen.token();
        let [u, v] = [uv[0].to_array(), uv[1].to_array()];
        let (mut around, mut right, mut down) = ([[0; LANES]; 4], [0.0; LANES], [0.0; LANES]);
        let mut left = seen.to_bitmask();
        while left != 0 {
            let lane = left.trailing_zeros() as usize % LANES;
            left &= left - 1;
            let level = self.level(level_of(lane, [u[lane], v[lane]]));
            let (x, y) = (u[lane] * level.width as f32, v[lane] * level.height as f32);
            if self.full.filtering == Filtering::Nearest {
                let texel = level.texel(self.full.wrapping, floor(x).0, floor(y).0);
                around.iter_mut().for_each(|all| all[lane] = pack(texel));
            } else {
                let ((column, way_right), (row, way_down)) = (floor(x - 0.5), floor(y - 0.5));
                (right[lane], down[lane]) = (way_right, way_down);
                let [[a, b], [c, d]] = level.four_texels(self.full.wrapping, column, row);
                [around[0][lane], around[1][lane]] = [pack(a), pack(b)];
                [around[2][lane], around[3][lane]] = [pack(c), pack(d)];
            }
        }
        let [a, b, c, d] = around;
        let around = [a, b, c, d].map(|texels| U::load_array(simd, texels));
        let (right, down) = (F::load_array(simd, right), F::load_array(simd, down));
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

    fn level(&self, index: usize) -> MipLevel<'_> {
        let smaller = index.checked_sub(1).and_then(|i| self.smaller.get(i));
        smaller.map_or_else(|| MipLevel::of(&self.full), Texels::level)
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

impl Texels {
    fn level(&self) -> MipLevel<'_> {
        MipLevel { width: self.width, height: self.height, rgba: &self.rgba }
    }
}

impl<'a> MipLevel<'a> {
    fn of(texture: &'a Texture) -> Self {
        let side = |length: u32| length.clamp(1, i32::MAX as u32) as i32;
        Self { width: side(texture.width), height: side(texture.height), rgba: &texture.rgba }
    }
}

impl MipLevel<'_> {
    fn halved(&self) -> Option<Texels> {
        let ([width, height], rgba) = halved([self.width as u32, self.height as u32], self.rgba)?;
        Some(Texels { width: width as i32, height: height as i32, rgba })
    }

    /// A texel, the one to the right of it, and those below both.
    #[inline]
    fn four_texels(&self, wrapping: Wrapping, x: i32, y: i32) -> [[[u8; 4]; 2]; 2] {
        // Nearly always all four are there and side by side.
        if x >= 0 && y >= 0 && x < self.width - 1 && y < self.height - 1 {
            let begin = y as usize * self.width as usize + x as usize;
            let row = |begin: usize| self.rgba.get(begin..).and_then(|rest| rest.first_chunk::<2>()).copied();
            if let (Some(upper), Some(lower)) = (row(begin), row(begin + self.width as usize)) {
                return [upper, lower];
            }
        }
        let texel = |dx: i32, dy: i32| self.texel(wrapping, x.saturating_add(dx), y.saturating_add(dy));
        [[texel(0, 0), texel(1, 0)], [texel(0, 1), texel(1, 1)]]
    }

    #[inline]
    fn texel(&self, wrapping: Wrapping, x: i32, y: i32) -> [u8; 4] {
        let (x, y) = match wrapping {
            Wrapping::Repeat => (x.rem_euclid(self.width), y.rem_euclid(self.height)),
            Wrapping::Clamp => (x.clamp(0, self.width - 1), y.clamp(0, self.height - 1)),
        };
        self.rgba.get(y as usize * self.width as usize + x as usize).copied().unwrap_or([255; 4])
    }
}

/// The whole number below and the rest; huge numbers end at the range of `i32`.
#[inline]
fn floor(value: f32) -> (i32, f32) {
    // From here on there are no fractions.
    const WHOLE_FROM: f32 = (1 << 23) as f32;
    if value.abs() < WHOLE_FROM {
        // Without a call, which old processors need to round.
        let cut = value as i32;
        let whole = cut - i32::from(cut as f32 > value);
        return (whole, value - whole as f32);
    }
    let whole = value.floor();
    (whole as i32, value - whole)
}

#[cfg(test)]
mod tests {
    use fearless_simd::{dispatch, Level};

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
            texture.sample(uv, uv[0].simd_eq(u), level).map(|channel| channel.to_array()[LANES - 1])
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
    fn numbers_are_cut_below() {
        for value in [-2.0_f32, -1.5, -0.0, 0.0, 0.25, 7.0, 7.99, -8_388_607.5, 8_388_607.5, 3e9, -3e9] {
            let whole = value.floor();
            assert_eq!(floor(value), (whole as i32, value - whole), "{value}");
        }
        assert!(floor(f32::NAN).1.is_nan());
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
}
