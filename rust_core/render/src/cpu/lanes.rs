//! Several points or pixels at once.
//!
//! The loops over points and their pixels are written for eight numbers side by side and compiled for each of the
//! processor's instruction sets that the build's target may have (on x86-64 SSE2, SSE4.2, AVX2 and AVX-512); which one
//! runs is found out at run time. All do the same sums in the same order, so the picture is the same on each.
//!
//! For that everything between [`fearless_simd::dispatch!`] and the arithmetic has to be `#[inline(always)]`, closures
//! included: what is compiled on its own is compiled for the oldest processor. So lanes go through [`map`] and [`inlined`]
//! instead of an array's `map` and plain closures.

use fearless_simd::prelude::*;
use fearless_simd::{f32x8, i32x8, mask32x8, u32x8};

/// How many.
pub(super) const LANES: usize = 8;

/// Numbers.
pub(super) type F<S> = f32x8<S>;
/// Whole numbers.
pub(super) type I<S> = i32x8<S>;
/// Colours.
pub(super) type U<S> = u32x8<S>;
/// Which of them.
pub(super) type M<S> = mask32x8<S>;

/// The lanes' numbers.
#[inline(always)]
pub(super) fn numbers<S: Simd>(simd: S) -> I<S> {
    I::load_array(simd, [0, 1, 2, 3, 4, 5, 6, 7])
}

/// The numbers from `begin` on, which have to be there.
#[inline(always)]
pub(super) fn load<S: Simd>(simd: S, all: &[f32], begin: usize) -> F<S> {
    all.get(begin..)
        .and_then(<[f32]>::first_chunk)
        .map_or(F::splat(simd, 0.0), |values| F::load_array_ref(simd, values))
}

/// Puts numbers at `begin`, where they have to have room.
#[inline(always)]
pub(super) fn store<S: Simd>(all: &mut [f32], begin: usize, value: F<S>) {
    if let Some(place) = all.get_mut(begin..).and_then(<[f32]>::first_chunk_mut) {
        value.store_array(place);
    }
}

/// Puts whole numbers at `begin`, where they have to have room.
#[inline(always)]
pub(super) fn store_whole<S: Simd>(all: &mut [i32], begin: usize, value: I<S>) {
    if let Some(place) = all.get_mut(begin..).and_then(<[i32]>::first_chunk_mut) {
        value.store_array(place);
    }
}

/// To the nearest whole number, of two equally near ones to the even; for numbers within ±2^22.
#[inline(always)]
pub(super) fn nearest<S: Simd>(value: F<S>) -> F<S> {
    // In a sum with this, nothing is left of a fraction.
    const NO_FRACTION: f32 = 12_582_912.0;
    (value + NO_FRACTION) - NO_FRACTION
}

/// What becomes of each element, as an array's `map`.
#[inline(always)]
pub(super) fn map<T: Copy, R: Copy, const N: usize>(all: [T; N], compute: impl Fn(T) -> R) -> [R; N] {
    let mut done = [compute(all[0]); N];
    for i in 1..N {
        done[i] = compute(all[i]);
    }
    done
}

/// The closure that it is given: only as an argument may a closure be marked `#[inline(always)]`.
#[inline(always)]
pub(super) fn inlined<C>(closure: C) -> C {
    closure
}

/// A matrix, given by its rows, times a place.
#[inline(always)]
pub(super) fn transform<S: Simd>(rows: &[[f32; 4]; 4], [x, y, z]: [F<S>; 3]) -> [F<S>; 4] {
    map(
        *rows,
        #[inline(always)]
        |[a, b, c, d]| x * a + y * b + z * c + d,
    )
}

/// Cut to whole numbers.
#[inline(always)]
pub(super) fn whole<S: Simd>(value: F<S>) -> I<S> {
    value.to_int()
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use fearless_simd::Level;
    use nalgebra::{Isometry3, Matrix4, Point3, Vector3};
    use rcs_scene::{
        Camera, DisplayMask, Drawable, Encoding, Geometry, Intrinsics, Picture, PointBuffer, PointColors, PointStyle,
        Points, RenderGroup, Scene,
    };

    use crate::{CpuRenderer, Renderer, View};

    /// Scattered points of many sizes on the picture; some are behind the eye, at the near plane or off the picture.
    fn scattered() -> PointBuffer {
        let mut state = 1_u32;
        let mut next = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / (1 << 24) as f32
        };
        let mut position = || {
            let z = -0.1 + 3.0 * next();
            [(next() - 0.5) * 2.0 * z, (next() - 0.5) * 2.0 * z, z]
        };
        let positions: Vec<[f32; 3]> = (0..3000).map(|_| position()).collect();
        let colors = (0..3000_u32).map(|i| (i.wrapping_mul(0x9e37_79b9) | 0x8000_0000).to_le_bytes()).collect();
        PointBuffer { positions, colors: PointColors::PerPoint(colors) }
    }

    fn levels() -> Vec<Level> {
        let best = Level::new();
        #[cfg_attr(not(target_arch = "x86_64"), expect(unused_mut, reason = "there is only one"))]
        let mut levels = vec![best];
        #[cfg(target_arch = "x86_64")]
        {
            use fearless_simd::Simd;
            levels.extend(best.as_sse2().map(Simd::level));
            levels.extend(best.as_sse4_2().map(Simd::level));
            levels.extend(best.as_avx2().map(Simd::level));
        }
        levels
    }

    #[test]
    fn all_instruction_sets_draw_the_same_picture() {
        let p = [300.0, 0.0, 160.0, 0.0, 0.0, 300.0, 120.0, 0.0, 0.0, 0.0, 1.0, 0.0];
        let pose = Isometry3::new(Vector3::new(0.05, -0.05, 0.0), Vector3::new(0.1, 0.2, 0.3));
        let camera = Camera::new(Intrinsics::from_p(320, 240, &p).unwrap(), &pose, 0.05);
        let buffer = Arc::new(scattered());
        let mut names = Vec::new();
        for style in [
            PointStyle::Points { diameter_px: 7.5 },
            PointStyle::FlatSquares { side_m: 0.02 },
            PointStyle::Squares { size_m: [0.03; 2] },
            PointStyle::Spheres { size_m: [0.02, 0.04] },
            PointStyle::Boxes { size_m: [0.01, 0.02, 0.03] },
            PointStyle::Tiles { size_m: [0.03, 0.02], normal: [0.0, 0.6, -0.8], up: [0.0, 0.8, 0.6] },
        ] {
            for blended in [false, true] {
                let points = Points { buffer: buffer.clone(), style, alpha: 0.7, blended, auto_size: false };
                let drawable = Drawable {
                    display: 0,
                    fixed_from_object: Matrix4::identity(),
                    sort_point: Point3::origin(),
                    group: RenderGroup::Main,
                    geometry: Geometry::Points(points),
                };
                let scene = Scene { drawables: vec![drawable], light: None };
                let visible = DisplayMask::all();
                let (background, encoding) = ([9, 9, 9], Encoding::Rgba8);
                let view = View { scene: &scene, camera: &camera, visible: &visible, background, encoding };
                let pictures: Vec<(Level, Picture)> = levels()
                    .into_iter()
                    .map(|level| {
                        let mut renderer = CpuRenderer { level: Some(level), ..CpuRenderer::with_threads(1) };
                        let mut picture = Picture::default();
                        renderer.render(&view, &mut picture).unwrap();
                        (level, picture)
                    })
                    .collect();
                let (_, first) = &pictures[0];
                assert!(first.data.chunks(4).any(|pixel| pixel[0] != 9));
                for (level, picture) in &pictures {
                    let different = picture.data.iter().zip(&first.data).filter(|(a, b)| a != b).count();
                    assert_eq!(different, 0, "{style:?}, blended: {blended}, {level:?}");
                }
                names = pictures.iter().map(|(level, _)| format!("{level:?}")).collect();
            }
        }
        println!("{names:?}");
    }
}
