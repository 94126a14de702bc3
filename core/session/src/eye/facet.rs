//! The facet of a rough surface by which an eye ray goes on: of one of sixteen kinds a pass, each of them once in a square of four by four pixels.
//!
//! So what pixels side by side see is even (A. Keller and W. Heidrich, Interleaved Sampling, 2001), and those of one kind go about the same way on
//! from a plane: their beams are found together, which costs a fraction of as many ways at random. Which pixel of a square has which is random,
//! or a screen of dots would be seen, and so is where in its kind a facet is, or sixteen images of what is bright.

use crate::random::{Random, mix, spread};

/// Pixels along a square's side.
const SIDE: u32 = 4;

/// Purpose of random numbers.
const KEY: u32 = 0xface7;

/// How wide a kind is: a sixteenth of all facets.
const WIDTH: f32 = 1.0 / SIDE as f32;

/// A facet, as rough surfaces draw it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Facet {
    /// Of its kind, from 1: facets of one kind in a pass are alike.
    pub(crate) number: u32,
    /// Uniform.
    pub(crate) xi: [f32; 2],
}

impl Facet {
    /// That of a pixel in a pass, counted from 1.
    pub(crate) fn of(seed: u32, [x, y]: [u32; 2], pass: u32) -> Self {
        let kind = Self::kind(seed, [x, y], pass);
        let mut random = Random::new([seed, pass, y << 16 | x, KEY]);
        let inside = |middle: f32| (middle + WIDTH * (random.uniform() - 0.5)).rem_euclid(1.0);
        Self { xi: kind.xi.map(inside).map(|xi| xi.min(1.0 - f32::EPSILON)), ..kind }
    }

    /// The middle of its kind: over sixteen passes a pixel has sixteen that fill the square evenly.
    fn kind(seed: u32, [x, y]: [u32; 2], pass: u32) -> Self {
        let all = SIDE * SIDE;
        let before = pass - 1;
        let square =
            mix(u64::from(seed) << 32 | u64::from(KEY)) ^ (u64::from(y / SIDE) << 32 | u64::from(x / SIDE));
        let turn = mix(square) as u32 % all;
        let place = ((dithered(x, y) ^ turn) + before) % all;
        let mut random = Random::new([seed, 0, 0, KEY]);
        let shift = [random.uniform(), random.uniform()];
        let index = u64::from(before / all) * u64::from(all) + u64::from(place);
        Self { number: 1 + place, xi: spread(shift, index as usize) }
    }
}

/// From 0 to 15 in a square of four pixels by four, neighbours far apart (B. Bayer 1973).
fn dithered(x: u32, y: u32) -> u32 {
    let across = x ^ y;
    (across & 1) << 3 | (y & 1) << 2 | (across & 2) | (y & 2) >> 1
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Way from one number to another in [0, 1) that goes on at its ends.
    fn apart(one: f32, other: f32) -> f32 {
        let way = (one - other).abs();
        way.min(1.0 - way)
    }

    /// In a square of pixels in one pass, and in one pixel over sixteen passes, no two are alike or near: of sixteen at random, four pairs would be.
    #[test]
    fn kinds_fill_the_square_in_a_pass_and_over_passes() {
        for seed in 0..50 {
            let (x, y) = (4 * seed, 8 * seed);
            let around = (0..16).map(|at| Facet::kind(seed, [x + at % 4, y + at / 4], 1 + 7 * seed));
            let over = (0..16).map(|at| Facet::kind(seed, [x, y], 1 + 16 * seed + at));
            for facets in [around.collect::<Vec<Facet>>(), over.collect()] {
                for (number, one) in facets.iter().enumerate() {
                    for other in &facets[..number] {
                        let [u, v] = [0, 1].map(|axis| apart(one.xi[axis], other.xi[axis]));
                        assert!(u.hypot(v) > 0.1 && one.number != other.number, "{one:?}, {other:?}");
                    }
                }
            }
        }
    }

    /// Facets of one number are near each other; no two are the same, all together are even, and they stand at no fixed place in their squares.
    #[test]
    fn facets_of_a_number_are_alike_and_no_screen() {
        let (mut at_corner, mut cells) = (std::collections::HashMap::new(), [0_u32; 64]);
        let mut all = std::collections::HashSet::new();
        for (x, y) in (0..256).flat_map(|x| (0..256).map(move |y| (4 * x, 4 * y))) {
            let Facet { number, xi } = Facet::of(3, [x, y], 21);
            let (middle, count) = at_corner.entry(number).or_insert((Facet::kind(3, [x, y], 21).xi, 0));
            assert!([0, 1].iter().all(|&axis| apart(middle[axis], xi[axis]) < 0.126), "{middle:?}, {xi:?}");
            *count += 1;
            all.insert(xi.map(f32::to_bits));
            cells[(8.0 * xi[0]) as usize * 8 + (8.0 * xi[1]) as usize] += 1;
        }
        // 65,536 squares: 4,096 of each of 16, give or take 62.
        assert!((1..=16).all(|number| (3848..4344).contains(&at_corner[&number].1)), "{at_corner:?}");
        assert!(all.len() > 65_000, "{} different ones", all.len());
        // Of 1,024; kinds overlap and leave gaps, no cell is without.
        assert!(cells.iter().all(|count| (250..2600).contains(count)), "{cells:?}");
    }
}
