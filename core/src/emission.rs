//! What light paths begin with: the bandwidth of an even lamp; the numbers that a path's decisions are drawn
//! with, a low-discrepancy sequence for the first ones, which places the paths evenly over what the lights
//! emit, continued over the passes; and a warp of these that sends more paths where they are worth more.

use crate::voxels::GridError;
use core::f64::consts::PI;

/// Angular variance of the emission of a lamp that shines evenly \[cycles²/rad²\]: its light falls off as
/// 1/d², a relative curvature of 2/d² across its rays, so that 2/(4π²).
pub const EVEN_LAMP: f32 = (2.0 / (4.0 * PI * PI)) as f32;

/// Decisions of a path that the sequence stratifies.
pub const EMISSION_DIMENSIONS: u32 = 8;

/// The number of one decision of one light path: uniform in [0, 1), a multiple of 2⁻²⁴.
///
/// The first [`EMISSION_DIMENSIONS`] decisions are the coordinates of a scrambled Sobol' point: 2ᵏ paths in a
/// row fill each evenly, the first two together as well. Those after them are independent. A pure function:
/// paths can be traced in any order, by any thread.
///
/// - `seed`: another seed is another scramble of all sequences.
/// - `sequence`: keeps sequences of one seed apart, such as the paths with light fields and those without.
/// - `path`: its place in the sequence, counted on over the passes of a picture.
/// - `dimension`: which decision of the path, from 0 on. The earlier ones are the better stratified.
///
/// Error: at equal numbers of paths that of the picture is 1.2 to 8 times below that of independent numbers.
///
/// Source: Sobol' (1967) with the direction numbers of S. Joe and F. Y. Kuo (2008, new-joe-kuo-6); nested
/// uniform (Owen) scramble by hash, B. Burley, *Practical Hash-based Owen Scrambling*, JCGT 2020, the hash
/// constants N. Vegdahl's; mixing and independent numbers by SplitMix64 (G. Steele et al., 2014).
///
/// ```
/// // Four paths, one in each quarter.
/// let mut first = [0, 1, 2, 3].map(|path| covbeam::path_number(1, 0, path, 0));
/// first.sort_by(f32::total_cmp);
/// assert_eq!(first.map(|number| (4.0 * number) as u32), [0, 1, 2, 3]);
/// ```
#[doc(alias = "Sobol")]
#[doc(alias = "quasi-Monte Carlo")]
pub fn path_number(seed: u32, sequence: u32, path: u32, dimension: u32) -> f32 {
    let own = pair(seed, sequence);
    let bits = if dimension < EMISSION_DIMENSIONS {
        owen_scramble(sobol(path, dimension as usize), mix(mix(own) ^ u64::from(dimension)) as u32)
    } else {
        let start = mix(mix(own) ^ pair(path, 0x5eed));
        let step = u64::from(dimension - EMISSION_DIMENSIONS) + 1;
        (mix(start.wrapping_add(GOLDEN.wrapping_mul(step))) >> 32) as u32
    };
    (bits >> 8) as f32 * (1.0 / 16_777_216.0)
}

/// More of a lamp's paths where they are worth more: a warp of the unit square in which its emission is drawn,
/// over the caller's numbers. It keeps what is stratified in the square stratified.
#[derive(Clone, Copy, Debug)]
pub struct EmissionGuide<'a> {
    side: usize,
    /// Cumulative shares of the rows, and in each row those of its cells.
    cumulative: &'a [f32],
}

impl<'a> EmissionGuide<'a> {
    /// Numbers that a guide of `side` x `side` cells takes.
    pub const fn size(side: usize) -> usize {
        side * (side + 1)
    }

    /// Writes a guide.
    ///
    /// - `weights`: what light that leaves through each of `side` x `side` cells is worth, the second number of
    ///   the square running fastest; >= 0, their scale does not matter.
    /// - `even`: share of the paths that go everywhere alike, in (0, 1\], and no less than
    ///   [`f32::MIN_POSITIVE`] a cell: no more than 1/`even` times its own power has any path, however wrong the
    ///   weights are. Where all weights are 0, all do.
    /// - `cumulative`: [`EmissionGuide::size`] numbers, overwritten.
    ///
    /// # Errors
    /// [`GridError::Length`]: no cells, or slices of other lengths; [`GridError::Value`]: weights that are
    /// negative or not finite or have no finite sum, or `even` out of range.
    pub fn fill(
        side: usize,
        weights: &[f32],
        even: f32,
        cumulative: &'a mut [f32],
    ) -> Result<Self, GridError> {
        if side == 0 || weights.len() != side * side || cumulative.len() != Self::size(side) {
            return Err(GridError::Length);
        }
        let total: f64 = weights.iter().map(|&weight| f64::from(weight)).sum();
        let even_in_cell = f64::from(even) / (side * side) as f64;
        let even_fits = even <= 1.0 && even_in_cell >= f64::from(f32::MIN_POSITIVE);
        if !(even_fits && weights.iter().all(|&weight| weight >= 0.0) && total.is_finite()) {
            return Err(GridError::Value);
        }
        let even = if total > 0.0 { f64::from(even) } else { 1.0 };
        let of_cell = even / (side * side) as f64;
        let scale = if total > 0.0 { (1.0 - even) / total } else { 0.0 };
        let (rows, columns) = cumulative.split_at_mut(side);
        let mut sum = 0.0;
        let lines = weights.chunks(side).zip(columns.chunks_mut(side));
        for (end, (weights, line)) in rows.iter_mut().zip(lines) {
            let mut within = 0.0;
            for (end, &weight) in line.iter_mut().zip(weights) {
                within += of_cell + scale * f64::from(weight);
                *end = within as f32;
            }
            line.iter_mut().for_each(|end| *end /= within as f32);
            sum += within;
            *end = sum as f32;
        }
        rows.iter_mut().for_each(|end| *end /= sum as f32);
        Ok(Self { side, cumulative })
    }

    /// A guide that was written before.
    ///
    /// # Errors
    /// [`GridError::Length`]: not as many numbers as [`EmissionGuide::size`] says.
    pub fn new(side: usize, cumulative: &'a [f32]) -> Result<Self, GridError> {
        if side == 0 || cumulative.len() != Self::size(side) {
            return Err(GridError::Length);
        }
        Ok(Self { side, cumulative })
    }

    /// Where a point of the unit square goes, and the density of points there, whose mean over the square is 1:
    /// a path's power is to be divided by it.
    pub fn warp(&self, [u, v]: [f32; 2]) -> ([f32; 2], f32) {
        let (rows, columns) = self.cumulative.split_at(self.side);
        let (row, u, of_row) = pick(rows, u);
        let (_, v, of_cell) = pick(&columns[row * self.side..(row + 1) * self.side], v);
        ([u, v], of_row * of_cell)
    }
}

/// The cell that a number falls into, the place in [0, 1) that it goes to, and the density there.
fn pick(cumulative: &[f32], number: f32) -> (usize, f32, f32) {
    let count = cumulative.len() as f32;
    let index = cumulative.partition_point(|&end| end <= number).min(cumulative.len() - 1);
    let start = if index == 0 { 0.0 } else { cumulative[index - 1] };
    let share = (cumulative[index] - start).max(f32::MIN_POSITIVE);
    let within = ((number - start) / share).clamp(0.0, 1.0);
    (index, ((index as f32 + within) / count).min(1.0 - f32::EPSILON), share * count)
}

fn pair(high: u32, low: u32) -> u64 {
    (u64::from(high) << 32) | u64::from(low)
}

const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;

/// SplitMix64: every input bit changes half of the output bits.
fn mix(z: u64) -> u64 {
    let z = z.wrapping_add(GOLDEN);
    let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// Degree, coefficients and initial direction numbers of the primitive polynomials of dimensions 1, 2, …
const POLYNOMIALS: [(usize, u32, &[u32]); EMISSION_DIMENSIONS as usize - 1] = [
    (1, 0, &[1]),
    (2, 1, &[1, 3]),
    (3, 1, &[1, 3, 1]),
    (3, 2, &[1, 1, 1]),
    (4, 1, &[1, 1, 3, 3]),
    (4, 4, &[1, 3, 5, 13]),
    (5, 2, &[1, 1, 5, 5, 17]),
];

const DIRECTIONS: [[u32; 32]; EMISSION_DIMENSIONS as usize] = direction_numbers();

const fn direction_numbers() -> [[u32; 32]; EMISSION_DIMENSIONS as usize] {
    let mut table = [[0; 32]; EMISSION_DIMENSIONS as usize];
    let mut bit = 0;
    while bit < 32 {
        table[0][bit] = 1 << (31 - bit);
        bit += 1;
    }
    let mut dimension = 1;
    while dimension < table.len() {
        let (degree, coefficients, initial) = POLYNOMIALS[dimension - 1];
        let row = &mut table[dimension];
        let mut i = 0;
        while i < 32 {
            if i < degree {
                row[i] = initial[i] << (31 - i);
            } else {
                row[i] = row[i - degree] ^ (row[i - degree] >> degree);
                let mut k = 1;
                while k < degree {
                    if (coefficients >> (degree - 1 - k)) & 1 == 1 {
                        row[i] ^= row[i - k];
                    }
                    k += 1;
                }
            }
            i += 1;
        }
        dimension += 1;
    }
    table
}

/// Point `index` of the Sobol' sequence in one dimension, as a 32-bit fraction.
fn sobol(mut index: u32, dimension: usize) -> u32 {
    let mut value = 0;
    while index != 0 {
        value ^= DIRECTIONS[dimension][index.trailing_zeros() as usize];
        index &= index - 1;
    }
    value
}

/// Nested uniform (Owen) scramble by a hash of the leading bits.
fn owen_scramble(value: u32, key: u32) -> u32 {
    let mut x = value.reverse_bits().wrapping_add(key);
    for factor in [0x6c50_b47c, 0xb82f_1e52, 0xc7af_e638, 0x8d22_f6e6] {
        x ^= x.wrapping_mul(factor);
    }
    x.reverse_bits()
}
