//! Eight numbers, and eight vectors, side by side: one instruction for all where the processor has it.
//!
//! What is called from here on down to a call of `dispatch!` is marked `inline(always)`, and no closure
//! computes with eight numbers: what is not inlined is compiled for the oldest processor.
//!
//! Each operation rounds as its scalar counterpart does, and none are fused: results are the same bits on
//! every processor.
//!
//! By hand, since the compiler finds vectors in only half of these loops. Pairs stand in dense blocks, not in
//! lists of those that may meet: to gather eight beams from memory costs more than the lanes that are lost.

use core::ops::{Add, Mul, Sub};
use fearless_simd::{Bytes, Select, Simd, SimdBase, f32x8, u32x8};
use glam::Vec3;

use crate::beam::BLOCK;
use crate::math::{EXP_LIMIT, EXP_SERIES, LN_2, ROUND, SERIES_LIMIT};

/// Pairs that are worked on side by side.
pub(super) const LANES: usize = BLOCK;

/// A number for each of eight lanes, in memory.
pub(super) type Floats = [f32; BLOCK];

/// A vector for each of eight lanes, in memory.
pub(super) type Vectors = [Floats; 3];

/// A vector for each of eight lanes.
#[derive(Clone, Copy)]
pub(super) struct Vec3x8<S: Simd> {
    pub(super) x: f32x8<S>,
    pub(super) y: f32x8<S>,
    pub(super) z: f32x8<S>,
}

#[inline(always)]
pub(super) fn load<S: Simd>(simd: S, floats: &Floats) -> f32x8<S> {
    f32x8::from_slice(simd, floats)
}

/// `a < b ? a : b`: b of two equal numbers or zeros of either sign, and if one is NaN. The crate's own
/// minimum leaves these to the processor.
#[inline(always)]
pub(super) fn min<S: Simd>(a: f32x8<S>, b: f32x8<S>) -> f32x8<S> {
    a.simd_lt(b).select(a, b)
}

/// `a > b ? a : b`; see [`min`].
#[inline(always)]
pub(super) fn max<S: Simd>(a: f32x8<S>, b: f32x8<S>) -> f32x8<S> {
    a.simd_gt(b).select(a, b)
}

impl<S: Simd> Vec3x8<S> {
    #[inline(always)]
    pub(super) fn load(simd: S, vectors: &Vectors) -> Self {
        let [x, y, z] = vectors;
        Self { x: load(simd, x), y: load(simd, y), z: load(simd, z) }
    }

    #[inline(always)]
    pub(super) fn splat(simd: S, vector: Vec3) -> Self {
        let [x, y, z] = vector.to_array();
        Self { x: f32x8::splat(simd, x), y: f32x8::splat(simd, y), z: f32x8::splat(simd, z) }
    }

    #[inline(always)]
    pub(super) fn store(self) -> Vectors {
        [self.x.into(), self.y.into(), self.z.into()]
    }

    #[inline(always)]
    pub(super) fn dot(self, other: Self) -> f32x8<S> {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    #[inline(always)]
    pub(super) fn cross(self, other: Self) -> Self {
        Self {
            x: self.y * other.z - other.y * self.z,
            y: self.z * other.x - other.z * self.x,
            z: self.x * other.y - other.x * self.y,
        }
    }
}

impl<S: Simd> Add for Vec3x8<S> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self { x: self.x + other.x, y: self.y + other.y, z: self.z + other.z }
    }
}

impl<S: Simd> Sub for Vec3x8<S> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self { x: self.x - other.x, y: self.y - other.y, z: self.z - other.z }
    }
}

impl<S: Simd> Mul<f32x8<S>> for Vec3x8<S> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, factor: f32x8<S>) -> Self {
        Self { x: self.x * factor, y: self.y * factor, z: self.z * factor }
    }
}

impl<S: Simd> Mul for Vec3x8<S> {
    type Output = Self;

    /// Component by component.
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self { x: self.x * other.x, y: self.y * other.y, z: self.z * other.z }
    }
}

/// [`crate::math::exp`], bit for bit.
#[inline(always)]
pub(super) fn exp<S: Simd>(simd: S, x: f32x8<S>) -> f32x8<S> {
    let rounded = x * core::f32::consts::LOG2_E + ROUND;
    let power = rounded - ROUND;
    let r = x - power * LN_2[0] - power * LN_2[1];
    let mut p = f32x8::splat(simd, EXP_SERIES[0]);
    for term in &EXP_SERIES[1..] {
        p = p * r + *term;
    }
    let p = p * (r * r) + r + 1.0;
    let bits: u32x8<S> = (rounded.bitcast::<u32x8<S>>() + u32x8::splat(simd, 127)) << 23;
    let value = p * bits.bitcast::<f32x8<S>>();
    let low = x.simd_lt(f32x8::splat(simd, -EXP_LIMIT));
    let high = x.simd_gt(f32x8::splat(simd, EXP_LIMIT));
    let value = high.select(f32x8::splat(simd, f32::INFINITY), value);
    low.select(f32x8::splat(simd, 0.0), value)
}

/// [`crate::math::exp_mean`], bit for bit.
#[inline(always)]
pub(super) fn exp_mean<S: Simd>(simd: S, x: f32x8<S>) -> f32x8<S> {
    let mut p = f32x8::splat(simd, EXP_SERIES[0]);
    for term in &EXP_SERIES[1..] {
        p = p * x + *term;
    }
    let is_small = x.abs().simd_le(f32x8::splat(simd, SERIES_LIMIT));
    is_small.select(p * x + 1.0, (exp(simd, x) - 1.0) / x)
}

/// The places of the bits that are set, lowest first.
#[inline(always)]
pub(super) fn bits(mut mask: u32) -> impl Iterator<Item = usize> {
    core::iter::from_fn(move || {
        let place = mask.trailing_zeros() as usize;
        let found = mask != 0;
        mask &= mask.wrapping_sub(1);
        found.then_some(place)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use fearless_simd::{Level, dispatch};

    #[test]
    fn the_exponentials_of_eight_numbers_are_those_of_one_bit_for_bit() {
        let odd = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 87.5, -87.5, 0.0, -0.0, 1e-40];
        let ramp = (0..200_000u32).map(|i| f32::from_bits(i * 11_003));
        let numbers: std::vec::Vec<f32> = odd.into_iter().chain(ramp.flat_map(|x| [x, -x])).collect();
        for level in [Level::new(), Level::baseline()] {
            for numbers in numbers.chunks_exact(BLOCK) {
                let numbers: Floats = numbers.try_into().unwrap();
                let wide: Floats = dispatch!(level, simd => exp(simd, load(simd, &numbers)).into());
                let means: Floats = dispatch!(level, simd => exp_mean(simd, load(simd, &numbers)).into());
                for (lane, x) in numbers.into_iter().enumerate() {
                    let same = |a: f32, b: f32| a.to_bits() == b.to_bits() || a.is_nan() && b.is_nan();
                    assert!(same(wide[lane], crate::math::exp(x)), "{x:e}");
                    assert!(same(means[lane], crate::math::exp_mean(x)), "mean, {x:e}");
                }
            }
        }
    }
}
