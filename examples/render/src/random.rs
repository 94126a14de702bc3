//! Random numbers that depend on nothing but (seed, pass, photon): a low-discrepancy sequence for the first decisions
//! of a path, continued over the passes, and a counter-based generator for the rest.

/// Dimensions of a path's decisions that the Sobol' sequence serves.
pub const SOBOL_DIMENSIONS: usize = 8;

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
    index: u32,
    scramble: u64,
    dimension: usize,
    random: Random,
}

impl PathSampler {
    /// `sequence` keeps sequences of one seed apart; `index` = the path's place in its sequence, continued over passes.
    pub fn new(emission: Emission, seed: u32, sequence: u32, index: u32) -> Self {
        Self {
            index,
            scramble: mix((u64::from(seed) << 32) | u64::from(sequence)),
            dimension: match emission {
                Emission::LowDiscrepancy => 0,
                Emission::Independent => SOBOL_DIMENSIONS,
            },
            random: Random::new([seed, sequence, index, 0x5eed]),
        }
    }

    /// Next decision, uniform in [0, 1).
    pub fn uniform(&mut self) -> f32 {
        if self.dimension >= SOBOL_DIMENSIONS {
            return self.random.uniform();
        }
        let key = mix(self.scramble ^ self.dimension as u64) as u32;
        let bits = owen_scramble(sobol(self.index, self.dimension), key);
        self.dimension += 1;
        unit(bits)
    }

    /// Next two decisions.
    pub fn uniform_pair(&mut self) -> [f32; 2] {
        [self.uniform(), self.uniform()]
    }
}

/// Degree, coefficients and initial direction numbers of the primitive polynomials of dimensions 1, 2, …
/// (S. Joe and F. Y. Kuo, 2008, new-joe-kuo-6).
const POLYNOMIALS: [(u32, u32, &[u32]); SOBOL_DIMENSIONS - 1] = [
    (1, 0, &[1]),
    (2, 1, &[1, 3]),
    (3, 1, &[1, 3, 1]),
    (3, 2, &[1, 1, 1]),
    (4, 1, &[1, 1, 3, 3]),
    (4, 4, &[1, 3, 5, 13]),
    (5, 2, &[1, 1, 5, 5, 17]),
];

const DIRECTIONS: [[u32; 32]; SOBOL_DIMENSIONS] = direction_numbers();

const fn direction_numbers() -> [[u32; 32]; SOBOL_DIMENSIONS] {
    let mut table = [[0u32; 32]; SOBOL_DIMENSIONS];
    let mut bit = 0;
    while bit < 32 {
        table[0][bit] = 1 << (31 - bit);
        bit += 1;
    }
    let mut dimension = 1;
    while dimension < SOBOL_DIMENSIONS {
        let (degree, coefficients, initial) = POLYNOMIALS[dimension - 1];
        let degree = degree as usize;
        let mut i = 0;
        while i < 32 {
            if i < degree {
                table[dimension][i] = initial[i] << (31 - i);
            } else {
                let mut v = table[dimension][i - degree] ^ (table[dimension][i - degree] >> degree);
                let mut k = 1;
                while k < degree {
                    if (coefficients >> (degree - 1 - k)) & 1 == 1 {
                        v ^= table[dimension][i - k];
                    }
                    k += 1;
                }
                table[dimension][i] = v;
            }
            i += 1;
        }
        dimension += 1;
    }
    table
}

/// Point `index` of the Sobol' sequence in one dimension, as a 32-bit fraction.
fn sobol(index: u32, dimension: usize) -> u32 {
    let mut bits = index;
    let mut value = 0;
    while bits != 0 {
        value ^= DIRECTIONS[dimension][bits.trailing_zeros() as usize];
        bits &= bits - 1;
    }
    value
}

/// Nested uniform (Owen) scramble by a hash of the leading bits (B. Burley, *Practical Hash-based Owen Scrambling*,
/// JCGT 2020; the hash constants are N. Vegdahl's).
fn owen_scramble(value: u32, key: u32) -> u32 {
    let mut x = value.reverse_bits();
    x = x.wrapping_add(key);
    x ^= x.wrapping_mul(0x6c50_b47c);
    x ^= x.wrapping_mul(0xb82f_1e52);
    x ^= x.wrapping_mul(0xc7af_e638);
    x ^= x.wrapping_mul(0x8d22_f6e6);
    x.reverse_bits()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_dimension_puts_one_point_in_each_interval_of_a_power_of_two() {
        for dimension in 0..SOBOL_DIMENSIONS {
            for key in [0u32, 77, 0xdead_beef] {
                let mut seen = [false; 1024];
                for index in 0..1024 {
                    let cell = (owen_scramble(sobol(index, dimension), key) >> 22) as usize;
                    assert!(!seen[cell], "dimension {dimension}, key {key}: cell {cell} twice");
                    seen[cell] = true;
                }
            }
        }
    }

    #[test]
    fn the_first_two_dimensions_are_a_net_in_every_elementary_interval() {
        // A (0, 2)-sequence: 2^8 points put exactly one into each of 2^a x 2^(8-a) boxes.
        for a in 0..=8u32 {
            let mut seen = [false; 256];
            for index in 256..512 {
                let x = u64::from(owen_scramble(sobol(index, 0), 5)) >> (32 - a);
                let y = u64::from(owen_scramble(sobol(index, 1), 9)) >> (24 + a);
                let cell = ((x << (8 - a)) | y) as usize;
                assert!(!seen[cell], "2^{a} columns: box {cell} twice");
                seen[cell] = true;
            }
        }
    }

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
