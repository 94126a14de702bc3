//! Random numbers that depend on nothing but (seed, pass, photon): those of light paths are core's, those of eye rays and
//! shadow rays come from a counter-based generator.

use covbeam::{EMISSION_DIMENSIONS, path_number};

/// How the first decisions of light paths are drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Emission {
    /// Scrambled Sobol' points, continued over the passes.
    #[default]
    LowDiscrepancy,
    /// Independent uniform numbers; to measure what the sequence is worth.
    Independent,
}

/// A 64-bit mixing function (the finaliser of SplitMix64): every input bit changes half of the output bits.
pub fn mix(mut z: u64) -> u64 {
    z = z.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// Uniform in [0, 1), a multiple of 2^-24.
fn unit(bits: u32) -> f32 {
    (bits >> 8) as f32 * (1.0 / 16_777_216.0)
}

/// Points that fill the unit square evenly, neighbours far apart: Roberts' R2 sequence, shifted.
pub fn spread(shift: [f32; 2], index: usize) -> [f32; 2] {
    let turn = |shift: f32, step: f64| {
        ((f64::from(shift) + step * index as f64).fract() as f32).min(1.0 - f32::EPSILON)
    };
    [turn(shift[0], 0.754_877_666_246_692_7), turn(shift[1], 0.569_840_290_998_053_2)]
}

/// Uniform numbers for one purpose, e.g. one pixel of one pass.
#[derive(Clone, Debug)]
pub struct Random {
    state: u64,
}

impl Random {
    /// The stream of this key; different keys give unrelated streams.
    pub fn new(key: [u32; 4]) -> Self {
        let [a, b, c, d] = key.map(u64::from);
        Self { state: mix(mix((a << 32) | b) ^ ((c << 32) | d)) }
    }

    /// Next number in [0, 1).
    pub fn uniform(&mut self) -> f32 {
        self.state = self.state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        unit((mix(self.state) >> 32) as u32)
    }
}

/// The decisions of one light path.
#[derive(Clone, Debug)]
pub struct PathSampler {
    seed: u32,
    sequence: u32,
    index: u32,
    dimension: u32,
}

impl PathSampler {
    /// `sequence` keeps sequences of one seed apart; `index` = the path's place in its sequence, continued over passes.
    pub fn new(emission: Emission, seed: u32, sequence: u32, index: u32) -> Self {
        let dimension = match emission {
            Emission::LowDiscrepancy => 0,
            Emission::Independent => EMISSION_DIMENSIONS,
        };
        Self { seed, sequence, index, dimension }
    }

    /// The independent decisions of a new branch here. They depend on where the path branches, not on how many branches others have: who
    /// follows only some of them sees the same ones.
    pub fn branch(&mut self) -> Self {
        self.dimension += 1;
        let sequence = mix((u64::from(self.sequence) << 32) | u64::from(self.dimension)) as u32;
        Self { sequence, dimension: EMISSION_DIMENSIONS, ..*self }
    }

    /// Next decision, uniform in [0, 1).
    pub fn uniform(&mut self) -> f32 {
        self.dimension += 1;
        path_number(self.seed, self.sequence, self.index, self.dimension - 1)
    }

    /// Next two decisions.
    pub fn uniform_pair(&mut self) -> [f32; 2] {
        [self.uniform(), self.uniform()]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_uniform_and_below_one() {
        let mut random = Random::new([1, 2, 3, 4]);
        let count = 100_000;
        let mean = (0..count).map(|_| f64::from(random.uniform())).sum::<f64>() / f64::from(count);
        // Standard error 1/sqrt(12 n) = 9e-4; 5 of them.
        assert!((mean - 0.5).abs() < 4.6e-3, "mean {mean}");
        assert!(unit(u32::MAX) < 1.0);
    }
}
