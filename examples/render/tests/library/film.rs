//! The film's sums: exact, and the same bits in whatever order the passes come.

use covbeam_session::film::samples::PassImage;
use covbeam_session::film::{Film, Picture};
use glam::Vec3;
use proptest::prelude::*;

const PIXELS: usize = 3;

/// Non-negative numbers over 12 decades, and 0.
fn value() -> impl Strategy<Value = f32> {
    prop_oneof![1 => Just(0.0_f32), 9 => (-6.0_f32..6.0).prop_map(|exponent| 10.0_f32.powf(exponent))]
}

fn pass() -> impl Strategy<Value = PassImage> {
    let radiance = prop::collection::vec([value(), value(), value()].prop_map(Vec3::from), PIXELS);
    let gather = prop::collection::vec([value(), value(), value(), value()], PIXELS);
    (1_u32..100, radiance, gather).prop_map(|(pass, radiance, gather)| PassImage {
        pass,
        width: PIXELS as u32,
        height: 1,
        radiance,
        gather,
        ..PassImage::default()
    })
}

fn picture(passes: &[PassImage]) -> Picture {
    let mut film = Film::new(PIXELS as u32, 1);
    for pass in passes {
        film.add(pass).unwrap();
    }
    film.picture()
}

fn bits(picture: &Picture) -> Vec<u32> {
    let layers = picture.layers.as_ref().unwrap();
    let radiance = picture.radiance.iter().flat_map(|v| v.to_array());
    let layers = layers.radius.iter().chain(&layers.sigma).chain(&layers.samples).copied();
    let error = picture.error.iter().flatten().copied();
    radiance.chain(layers).chain(error).map(f32::to_bits).collect()
}

fn passes_in_two_orders() -> impl Strategy<Value = (Vec<PassImage>, Vec<PassImage>)> {
    prop::collection::vec(pass(), 2..40)
        .prop_flat_map(|passes| (Just(passes.clone()), Just(passes).prop_shuffle()))
}

proptest! {
    #[test]
    fn passes_in_another_order_give_the_same_bits((passes, shuffled) in passes_in_two_orders()) {
        prop_assert_eq!(bits(&picture(&passes)), bits(&picture(&shuffled)));
    }
}

/// The negative control: what the film would be without exact sums.
#[test]
fn plain_sums_of_f32_do_depend_on_the_order() {
    let values = [16_777_216.0_f32, 1.0, 1.0];
    let forwards: f32 = values.iter().sum();
    let backwards: f32 = values.iter().rev().sum();
    assert_ne!(forwards.to_bits(), backwards.to_bits());
}

#[test]
fn small_passes_are_not_lost_beside_a_bright_one() {
    let one = |value: f32| PassImage {
        width: 1,
        height: 1,
        radiance: vec![Vec3::splat(value)],
        ..PassImage::default()
    };
    let mut film = Film::new(1, 1);
    film.add(&one(16_777_216.0)).unwrap();
    let mut running = 16_777_216.0_f32;
    for _ in 0..999 {
        film.add(&one(1.0)).unwrap();
        running += 1.0;
    }
    // (2^24 + 999) / 1000, while an f32 that adds 1 to 2^24 stands still.
    assert_eq!(film.picture().radiance[0], Vec3::splat(16_778.215));
    assert_eq!(running, 16_777_216.0);
}

#[test]
fn the_mean_is_the_same_in_every_unit() {
    // A power of two changes the exponents only, those of the film's unit too.
    for exponent in [-60, -30, -10, 10, 25, 60] {
        let unit = 2.0_f32.powi(exponent);
        let one = |value: f32| PassImage {
            width: 1,
            height: 1,
            radiance: vec![Vec3::splat(value)],
            ..PassImage::default()
        };
        let (mut film, mut scaled) = (Film::new(1, 1), Film::of_radiance(1, 1, unit));
        for value in [0.1, 0.2, 1e-3, 700.0, 3.0] {
            film.add(&one(value)).unwrap();
            scaled.add(&one(value * unit)).unwrap();
        }
        assert_eq!(film.picture().radiance[0] * unit, scaled.picture().radiance[0]);
    }
}

#[test]
fn sums_beyond_the_range_stop_there() {
    let mut film = Film::new(1, 1);
    for _ in 0..2 {
        film.add(&PassImage {
            width: 1,
            height: 1,
            radiance: vec![Vec3::splat(3e38)],
            ..PassImage::default()
        })
        .unwrap();
    }
    // 2^31 over two passes.
    assert_eq!(film.picture().radiance[0], Vec3::splat(2.0_f32.powi(30)));
}

#[test]
fn the_error_is_half_the_difference_of_the_halves() {
    let one = |pass: u32, value: f32| PassImage {
        pass,
        width: 1,
        height: 1,
        radiance: vec![Vec3::splat(value)],
        ..PassImage::default()
    };
    let mut film = Film::new(1, 1);
    film.add(&one(1, 1.0)).unwrap();
    assert_eq!(film.picture().error, None, "one half is empty");
    for (pass, value) in [(2, 5.0), (3, 3.0), (4, 9.0)] {
        film.add(&one(pass, value)).unwrap();
    }
    // Odd passes: 2, even passes: 7.
    let error = film.picture().error.unwrap()[0];
    assert!((error - 2.5).abs() < 1e-6, "{error}");
    assert!((film.picture().median_relative_error().unwrap() - 2.5 / 4.5).abs() < 1e-6);
}
