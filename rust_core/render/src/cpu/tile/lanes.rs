//! Several points or pixels at once.
//!
//! The loops over points and their pixels are written for eight numbers side by side and compiled for each of the
//! processor's instruction sets that the build's target may have (on x86-64 SSE2, SSE4.2, AVX2 and AVX-512); which one
//! runs is chosen at run time. All do the same arithmetic in the same order, so the image is the same on each.
//!
//! For that everything between [`fearless_simd::dispatch!`] and the arithmetic has to be `#[inline(always)]`, closures
//! included: a function that is compiled on its own is compiled for the oldest processor. So lanes go through [`map`]
//! and [`inlined`] instead of an array's `map` and plain closures.

use fearless_simd::prelude::*;
use fearless_simd::{f32x16, f32x8, i32x16, i32x8, mask32x8, u32x16, u32x8};

use crate::shading::Number;

/// Numbers side by side.
pub(in crate::cpu) const LANES: usize = 8;

/// Cells that are compared at once: twice as many, in one go where the processor can.
pub(in crate::cpu) const WIDE: usize = 2 * LANES;

/// Numbers.
pub(in crate::cpu) type F<S> = f32x8<S>;
/// Whole numbers.
pub(in crate::cpu) type I<S> = i32x8<S>;
/// Colours.
pub(in crate::cpu) type U<S> = u32x8<S>;
/// [`WIDE`] numbers.
pub(in crate::cpu) type WideF<S> = f32x16<S>;
/// [`WIDE`] whole numbers.
pub(in crate::cpu) type WideI<S> = i32x16<S>;
/// [`WIDE`] whole numbers without a sign.
pub(in crate::cpu) type WideU<S> = u32x16<S>;
/// A mask of the lanes.
pub(in crate::cpu) type M<S> = mask32x8<S>;

/// 0, 1, 2, …: the index of each lane.
#[inline(always)]
pub(in crate::cpu) fn lane_indices<S: Simd>(simd: S) -> I<S> {
    I::load_array(simd, [0, 1, 2, 3, 4, 5, 6, 7])
}

/// As [`lane_indices`], of [`WIDE`] lanes.
#[inline(always)]
pub(in crate::cpu) fn wide_indices<S: Simd>(simd: S) -> WideI<S> {
    WideI::load_array(simd, [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15])
}

/// The numbers from `begin` on, which must exist.
#[inline(always)]
pub(in crate::cpu) fn load<S: Simd>(simd: S, all: &[f32], begin: usize) -> F<S> {
    all.get(begin..)
        .and_then(<[f32]>::first_chunk)
        .map_or(F::splat(simd, 0.0), |values| F::load_array_ref(simd, values))
}

/// Writes numbers at `begin`, where there must be room.
#[inline(always)]
pub(in crate::cpu) fn store<S: Simd>(all: &mut [f32], begin: usize, value: F<S>) {
    if let Some(place) = all.get_mut(begin..).and_then(<[f32]>::first_chunk_mut) {
        value.store_array(place);
    }
}

/// Writes whole numbers at `begin`, where there must be room.
#[inline(always)]
pub(in crate::cpu) fn store_integers<S: Simd>(all: &mut [i32], begin: usize, value: I<S>) {
    if let Some(place) = all.get_mut(begin..).and_then(<[i32]>::first_chunk_mut) {
        value.store_array(place);
    }
}

/// To the nearest whole number, of two equally near ones to the even; for numbers within ±2^22.
#[inline(always)]
pub(in crate::cpu) fn nearest<S: Simd>(value: F<S>) -> F<S> {
    // In a sum with this, nothing is left of a fraction.
    const NO_FRACTION: f32 = 12_582_912.0;
    (value + NO_FRACTION) - NO_FRACTION
}

/// As an array's `map`.
#[inline(always)]
pub(in crate::cpu) fn map<T: Copy, R: Copy, const N: usize>(all: [T; N], compute: impl Fn(T) -> R) -> [R; N] {
    let mut done = [compute(all[0]); N];
    for i in 1..N {
        done[i] = compute(all[i]);
    }
    done
}

/// The given closure: only as an argument may a closure be marked `#[inline(always)]`.
#[inline(always)]
pub(in crate::cpu) fn inlined<C>(closure: C) -> C {
    closure
}

/// A matrix, given by its rows, times a place.
#[inline(always)]
pub(in crate::cpu) fn transform<S: Simd>(rows: &[[f32; 4]; 4], [x, y, z]: [F<S>; 3]) -> [F<S>; 4] {
    map(
        *rows,
        #[inline(always)]
        |[a, b, c, d]| x * a + y * b + z * c + d,
    )
}

/// Cut to whole numbers.
#[inline(always)]
pub(in crate::cpu) fn to_integers<S: Simd>(value: F<S>) -> I<S> {
    value.to_int()
}

impl<S: Simd> Number for F<S> {
    #[inline(always)]
    fn magnitude(self) -> Self {
        self.abs()
    }

    #[inline(always)]
    fn at_least(self, low: f32) -> Self {
        self.max(low)
    }

    #[inline(always)]
    fn at_most(self, high: f32) -> Self {
        self.min(high)
    }

    #[inline(always)]
    fn root(self) -> Self {
        self.sqrt()
    }

    #[inline(always)]
    fn sign(self) -> Self {
        let (none, one) = (Self::splat(self.token(), 0.0), Self::splat(self.token(), 1.0));
        self.simd_gt(0.0).select(one, self.simd_lt(0.0).select(-one, none))
    }
}
