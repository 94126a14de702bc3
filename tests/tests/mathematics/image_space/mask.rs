//! Which pixels get a ray in which pass.

use covbeam::pixel_threshold;
use covbeam_tests::random::Stream;

/// A point set on the circle [0, 1): the most by which the number of points in any arc differs from the arc's share of
/// them. Thresholds below a density lie in an arc, and another block, pass or seed moves all points alike, so this bounds every
/// density, block, pass and seed at once.
fn worst_arc(mut points: Vec<f64>) -> f64 {
    points.sort_by(f64::total_cmp);
    let count = points.len();
    let around = |i: usize| points[i % count] + if i < count { 0.0 } else { 1.0 };
    let mut worst = 0.0_f64;
    for first in 0..count {
        for last in first..first + count {
            let (inside, share) = ((last - first + 1) as f64, count as f64 * (around(last) - around(first)));
            // With both of its ends, and without.
            worst = worst.max(inside - share).max(share - (inside - 2.0));
        }
    }
    worst
}

/// Root of the mean square of (number below a density - its share), over its standard deviation if the points were random.
fn spread_against_chance(thresholds: &[f64]) -> f64 {
    let densities = (1..64).map(|i| f64::from(i) / 64.0);
    let count = thresholds.len() as f64;
    let terms = densities.map(|density| {
        let below = thresholds.iter().filter(|threshold| **threshold < density).count() as f64;
        (below - count * density).powi(2) / (count * density * (1.0 - density))
    });
    (terms.sum::<f64>() / 63.0).sqrt()
}

fn block(x: u32, y: u32, pass: u32, seed: u32) -> Vec<f64> {
    (0..256).map(|i| f64::from(pixel_threshold(x + i % 16, y + i / 16, pass, seed))).collect()
}

#[test]
fn a_pixel_is_chosen_evenly_over_the_passes() {
    let mut stream = Stream::new(1);
    for _ in 0..64 {
        let mut number = || (stream.uniform() * 4294967296.0) as u32;
        let (x, y, first, seed) = (number() >> 16, number() >> 16, number(), number());
        let passes: Vec<f64> =
            (0..64).map(|i| f64::from(pixel_threshold(x, y, first.wrapping_add(i), seed))).collect();
        // 2.688 for multiples of the golden ratio; thresholds are rounded to 2^-24.
        let worst = worst_arc(passes);
        assert!(worst < 2.7, "{worst} at {x}, {y}, pass {first}, seed {seed}");
        // Negative control: random thresholds stray by several times as much.
        let random = worst_arc((0..64).map(|_| stream.uniform()).collect());
        assert!(random > 4.0, "{random}");
    }
}

#[test]
fn every_block_of_pixels_gets_its_share_in_every_pass() {
    let mut stream = Stream::new(2);
    let (mut spreads, mut random_spreads) = (0.0, 0.0);
    for _ in 0..40 {
        let mut number = || (stream.uniform() * 4294967296.0) as u32;
        let found = block(number() >> 16, number() >> 16, number(), number());
        spreads += spread_against_chance(&found) / 40.0;
        // 7.33 for this pattern on 16 x 16 pixels; random ones stray by 20.
        let worst = worst_arc(found);
        assert!(worst < 7.4, "{worst}");
        let random: Vec<f64> = (0..256).map(|_| stream.uniform()).collect();
        random_spreads += spread_against_chance(&random) / 40.0;
        assert!(worst_arc(random) > 9.0);
    }
    println!("spread over that of chance: {spreads:.3}; of random thresholds: {random_spreads:.3}");
    // Measured 0.32, the same for every block. Random thresholds have 1 on average.
    assert!(spreads < 0.4, "{spreads}");
    assert!((random_spreads - 1.0).abs() < 0.3, "the control: {random_spreads}");
}

#[test]
fn a_pass_chooses_other_pixels_than_the_one_before() {
    for pass in 0..64 {
        for i in 0..1024 {
            let (x, y) = (i % 32, i / 32);
            let chosen = |pass| pixel_threshold(x, y, pass, 7) < 0.38;
            assert!(!(chosen(pass) && chosen(pass + 1)), "{x}, {y} in pass {pass} and the next");
        }
    }
}

/// Passes turn a pixel's threshold by the same angle each: it comes back only after 2³² of them if half as many turn it by a half.
#[test]
fn thresholds_come_equally_often_over_all_passes() {
    for (x, y, pass) in [(0, 0, 0), (5, 900, 77), (65_535, 65_535, u32::MAX)] {
        let (a, b) = (pixel_threshold(x, y, pass, 3), pixel_threshold(x, y, pass.wrapping_add(1 << 31), 3));
        assert_eq!((a - b).abs(), 0.5);
    }
}

#[test]
fn thresholds_are_below_one_and_a_seed_shifts_them_all_alike() {
    let turn = |x, y| (pixel_threshold(x, y, 5, 1 << 30) - pixel_threshold(x, y, 5, 0)).rem_euclid(1.0);
    for i in 0..100_000_u32 {
        let (x, y) = (i.wrapping_mul(2_654_435_761) >> 16, i % 977);
        assert!((0.0..1.0).contains(&pixel_threshold(x, y, i, i.rotate_left(9))));
        assert_eq!(turn(x, y), 0.25, "2^30 of 2^32");
    }
    assert!(pixel_threshold(0, 0, 0, u32::MAX) < 1.0, "the largest");
}
