//! Columns and densities of eight pairs in a medium that thins exponentially with height, bit for bit those of one.

use super::eight::{Pairs, vector};
use super::simd::{LANES, Vec3x8, bits, exp, exp_mean, load, max, min};
use crate::beam::EyeRay;
use crate::medium::{ExponentialDensity, LARGEST_LOGARITHM};
use fearless_simd::{Select, Simd, SimdBase, SimdMask, f32x8};

/// The columns along both ways of pairs, and the density where they meet.
///
/// - `at_origins`: the density at each beam's origin.
#[inline(always)]
pub(super) fn columns<S: Simd>(
    simd: S,
    density: &ExponentialDensity,
    ray: &EyeRay,
    at_origins: &[f32],
    pairs: &Pairs<S>,
) -> (f32x8<S>, f32x8<S>) {
    let up = Vec3x8::splat(simd, density.up);
    let mut at_beams = [0.0; LANES];
    for lane in bits(pairs.accepted) {
        at_beams[lane] = at_origins[pairs.block.beams[lane] as usize];
    }
    let rates = pairs.block.directions(simd).dot(up) / density.scale_height;
    // Before a beam's start as far as the column says behind it: `along_beam` of pair.rs.
    let is_before = pairs.beam_distance.simd_lt(f32x8::splat(simd, 0.0));
    let of_beam = column(simd, load(simd, &at_beams), rates, pairs.beam_distance.abs());
    let of_beam = is_before.select(-of_beam, of_beam);
    let [at_ray, rate] =
        [density.at(ray.origin), density.rate(ray.direction)].map(|number| f32x8::splat(simd, number));
    let of_ray = column(simd, at_ray, rate, pairs.ray_distance);
    (of_beam + of_ray, at(simd, density, up, pairs))
}

/// [`crate::Column::at`] of exponential ones.
#[inline(always)]
fn column<S: Simd>(simd: S, density: f32x8<S>, rate: f32x8<S>, distance: f32x8<S>) -> f32x8<S> {
    let column = density * distance * exp_mean(simd, -rate * distance);
    let [zero, most] = [0.0, f32::MAX].map(|number| f32x8::splat(simd, number));
    let tail = rate.simd_gt(zero).select(density / rate, most);
    let tail = density.simd_eq(zero).select(zero, tail);
    column.simd_eq(column).select(min(column, most), tail)
}

/// [`ExponentialDensity::at`] the positions of pairs.
#[inline(always)]
fn at<S: Simd>(simd: S, density: &ExponentialDensity, up: Vec3x8<S>, pairs: &Pairs<S>) -> f32x8<S> {
    let height = (pairs.position - Vec3x8::splat(simd, density.origin)).dot(up);
    let [least, most] = [-LARGEST_LOGARITHM, LARGEST_LOGARITHM].map(|number| f32x8::splat(simd, number));
    let found = exp(simd, min(max(-height / density.scale_height, least), most));
    let is_number = height.simd_eq(height).to_bitmask() as u32;
    if pairs.accepted & !is_number == 0 {
        return found;
    }
    // At the ends of what `f32` holds.
    let positions = pairs.position.store();
    let mut found: [f32; LANES] = found.into();
    for lane in bits(pairs.accepted & !is_number) {
        found[lane] = density.at(vector(&positions, lane));
    }
    load(simd, &found)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::medium::Column;
    use fearless_simd::{Level, dispatch};

    #[test]
    fn the_columns_of_eight_are_those_of_one_bit_for_bit() {
        let numbers = [
            0.0,
            -0.0,
            1e-40,
            1e-20,
            1e-5,
            0.3,
            0.35,
            1.0,
            7.0,
            90.0,
            1e20,
            1e38,
            f32::MAX,
            f32::INFINITY,
            f32::NAN,
        ];
        for level in [Level::new(), Level::baseline()] {
            for density in numbers {
                for rate in numbers.into_iter().flat_map(|rate| [rate, -rate]) {
                    for distances in numbers.windows(LANES) {
                        let distances: [f32; LANES] = distances.try_into().unwrap();
                        let wide: [f32; LANES] = dispatch!(level, simd => {
                            let [density, rate] = [density, rate].map(|number| f32x8::splat(simd, number));
                            column(simd, density, rate, load(simd, &distances)).into()
                        });
                        for (wide, distance) in wide.into_iter().zip(distances) {
                            let single = Column::Exponential { density, rate }.at(distance);
                            assert_eq!(
                                wide.to_bits(),
                                single.to_bits(),
                                "{density:e}, {rate:e}, {distance:e}: {wide:e} for {single:e}"
                            );
                        }
                    }
                }
            }
        }
    }
}
