//! The facet of a rough surface by which an eye ray goes on: one of sixteen a pass, each of them once in a square of four by four pixels.
//!
//! So what pixels side by side see is even (A. Keller and W. Heidrich, Interleaved Sampling, 2001), and those of one facet go about the same way on
//! from a plane: their beams are found together, which costs a fraction of as many ways at random. Which pixel of a square has which is random,
//! or a screen of dots would be seen.

use crate::random::{Random, mix, spread};

/// Pixels along a square's side.
const SIDE: u32 = 4;

/// Purpose of random numbers.
const KEY: u32 = 0xface7;

/// A facet, as rough surfaces draw it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Facet {
    /// From 1: equal for those of a pass that are the same.
    pub(crate) number: u32,
    /// Uniform.
    pub(crate) xi: [f32; 2],
}

impl Facet {
    /// That of a pixel in a pass, counted from 1: over sixteen passes a pixel has sixteen that fill the square evenly.
    pub(crate) fn of(seed: u32, [x, y]: [u32; 2], pass: u32) -> Self {
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

    /// In a square of pixels in one pass, and in one pixel over sixteen passes, no two are alike or near: of sixteen at random, four pairs would be.
    #[test]
    fn facets_fill_the_square_in_a_pass_and_over_passes() {
        let apart = |one: f32, other: f32| {
            let way = (one - other).abs();
            way.min(1.0 - way)
        };
        for seed in 0..50 {
            let (x, y) = (4 * seed, 8 * seed);
            let around = (0..16).map(|at| Facet::of(seed, [x + at % 4, y + at / 4], 1 + 7 * seed));
            let over = (0..16).map(|at| Facet::of(seed, [x, y], 1 + 16 * seed + at));
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

    /// Pixels of one number are of one facet; they stand at no fixed place in their squares.
    #[test]
    fn a_number_is_a_facet_and_no_screen() {
        let mut at_corner = std::collections::HashMap::new();
        for (x, y) in (0..256).flat_map(|x| (0..256).map(move |y| (4 * x, 4 * y))) {
            let Facet { number, xi } = Facet::of(3, [x, y], 21);
            let (known, count) = at_corner.entry(number).or_insert((xi, 0));
            assert_eq!(*known, xi);
            *count += 1;
        }
        // 65,536 squares: 4,096 of each of 16, give or take 62.
        assert!((1..=16).all(|number| (3848..4344).contains(&at_corner[&number].1)), "{at_corner:?}");
    }
}
