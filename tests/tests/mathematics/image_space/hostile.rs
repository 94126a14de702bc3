//! Image space given what no honest host would give it.

use covbeam::{FilmSample, ImageFilter, Vec3, pixel_threshold};
use covbeam_tests::random::Stream;
use proptest::prelude::*;

use super::reconstruction::{Rays, rays, turned};

const BAD: [f32; 3] = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY];

fn bad_sample() -> impl Strategy<Value = FilmSample> {
    let bad = BAD.iter().flat_map(|bad| {
        [
            FilmSample { radiance: Vec3::new(*bad, 1.0, 1.0), weight: 2.0, ..FilmSample::default() },
            FilmSample { radiance: Vec3::new(1.0, *bad, 1.0), weight: 2.0, ..FilmSample::default() },
            FilmSample { radiance: Vec3::new(1.0, 1.0, *bad), weight: 2.0, ..FilmSample::default() },
            FilmSample { radiance: Vec3::ONE, weight: *bad, ..FilmSample::default() },
        ]
    });
    let extreme = [
        FilmSample { radiance: Vec3::ONE, weight: -1.0, ..FilmSample::default() },
        FilmSample { radiance: Vec3::ONE, weight: 0.0, ..FilmSample::default() },
        FilmSample { radiance: Vec3::ONE, weight: 1e-40, ..FilmSample::default() },
        FilmSample { radiance: Vec3::splat(3e38), weight: 1.0, ..FilmSample::default() },
        FilmSample { radiance: Vec3::splat(-3e38), weight: 1.0, ..FilmSample::default() },
        FilmSample { radiance: Vec3::ONE, weight: 3e38, ..FilmSample::default() },
    ];
    prop::sample::select(bad.chain(extreme).collect::<Vec<_>>())
}

fn bits(picture: &[Vec3]) -> Vec<[u32; 3]> {
    picture.iter().map(|pixel| pixel.to_array().map(f32::to_bits)).collect()
}

proptest! {
    /// Its own pixel too.
    #[test]
    fn a_bad_sample_is_a_pixel_without_rays(
        rays in rays(),
        bad in prop::collection::vec((0..1089_usize, bad_sample()), 1..5),
        filter in prop::sample::select(vec![ImageFilter::NONE, turned(0.4, 0.4, 0.0), turned(3.0, 1.0, 0.5), turned(12.0, 9.0, 0.0)]),
    ) {
        let (mut broken, mut cleared) = (rays.clone(), rays);
        for (at, sample) in bad {
            let at = at % broken.samples.len();
            broken.samples[at] = sample;
            cleared.samples[at] = FilmSample::default();
        }
        prop_assert_eq!(bits(&broken.picture(&filter)), bits(&cleared.picture(&filter)));
    }

    /// Numbers of any bit pattern, indefinite matrices among them.
    #[test]
    fn every_filter_gives_a_finite_pixel(rays in rays(), numbers in any::<[u32; 3]>(), at in (0..33_u32, 0..33_u32)) {
        let [xx, xy, yy] = numbers.map(f32::from_bits);
        let (x, y) = (at.0 % rays.width, at.1 % rays.height);
        rays.reconstruct(|from| {
            let without = from.pixel(x, y, &ImageFilter::NONE);
            let is_none = |xx, xy, yy| from.pixel(x, y, &ImageFilter { xx, xy, yy }) == without;
            for filter in [ImageFilter { xx, xy, yy }, ImageFilter { xx: xx.abs(), xy, yy: yy.abs() }] {
                let pixel = from.pixel(x, y, &filter);
                prop_assert!(pixel.cmpge(Vec3::splat(-1e-5)).all() && pixel.cmple(Vec3::splat(1.0 + 1e-5)).all(), "{pixel}");
            }
            for bad in BAD.into_iter().chain([-1.0, -1e-30]) {
                prop_assert!(is_none(bad, 0.1, 9.0));
                prop_assert!(is_none(9.0, 0.1, bad));
            }
            for bad in BAD {
                prop_assert!(is_none(9.0, bad, 9.0));
            }
            Ok(())
        })?;
    }
}

/// Filters whose products are beyond what `f32` holds, and covariances that no variances allow.
#[test]
fn a_huge_filter_is_the_mean_of_the_region_and_an_impossible_one_is_finite() {
    let mut stream = Stream::new(7);
    let values: Vec<f32> = (0..600).map(|_| stream.uniform() as f32).collect();
    let rays = Rays::full(30, 20, |x, y| values[(y * 30 + x) as usize]);
    let mean = values.iter().map(|value| f64::from(*value)).sum::<f64>() / 600.0;
    for variance in [1e6, 1e12, 1e19, 1e30, 3e38] {
        let pixel =
            rays.reconstruct(|from| from.pixel(7, 3, &ImageFilter { xx: variance, xy: 0.0, yy: variance }));
        assert!((f64::from(pixel.x) - mean).abs() < 1e-3, "{pixel}, not {mean}, of {variance}");
        // One axis alone: the mean of the row.
        let row = values[90..120].iter().map(|value| f64::from(*value)).sum::<f64>() / 30.0;
        let pixel =
            rays.reconstruct(|from| from.pixel(7, 3, &ImageFilter { xx: variance, xy: 0.0, yy: 0.0 }));
        assert!((f64::from(pixel.x) - row).abs() < 1e-3, "{pixel}, not {row}, of {variance}");
    }
    for xy in [2.0, 1e3, 1e6, 1e20, 3e38].into_iter().flat_map(|xy| [xy, -xy]) {
        for variance in [0.0, 1.0, 100.0, 1e12] {
            let filter = ImageFilter { xx: variance, xy, yy: 4.0 * variance };
            if xy.abs() >= 2.0 * variance {
                // A line, the most that these variances allow.
                let line = ImageFilter {
                    xy: (2.0 * variance).copysign(xy),
                    yy: (4.0 * variance).min(1e12),
                    ..filter
                };
                assert_eq!(bits(&rays.picture(&filter)), bits(&rays.picture(&line)), "{filter:?}");
            }
            for pixel in rays.picture(&filter) {
                assert!((0.0..=1.0).contains(&pixel.x), "{pixel} through {filter:?}");
            }
        }
    }
}

#[test]
fn sums_of_the_largest_samples_stay_finite() {
    let mut rays = Rays::full(64, 64, |_, _| 1.0);
    for (radiance, weight) in
        [(1e29, 1e29), (1e29, 1.0), (1e29, 1e-9), (1.0, 1e29), (1e-30, 1e-9), (-1e29, 1e-9)]
    {
        rays.samples.fill(FilmSample { radiance: Vec3::splat(radiance), weight, ..FilmSample::default() });
        for filter in [ImageFilter::NONE, turned(5.0, 5.0, 0.0), turned(1e4, 1e4, 0.0)] {
            let pixel = rays.reconstruct(|from| from.pixel(31, 30, &filter));
            assert!((pixel.x / (radiance / weight) - 1.0).abs() < 1e-5, "{pixel} of {radiance} / {weight}");
        }
    }
}

#[test]
fn one_ray_lights_all_of_a_picture_and_none_leaves_it_dark() {
    for (width, height) in [(1, 1), (1, 40), (5, 3), (17, 33), (64, 64)] {
        let mut rays = Rays::none(width, height);
        let filters =
            [ImageFilter::NONE, turned(0.5, 0.5, 0.0), turned(4.0, 16.0, 0.3), turned(300.0, 300.0, 0.0)];
        for filter in filters {
            assert!(rays.picture(&filter).iter().all(|pixel| *pixel == Vec3::ZERO));
        }
        let last = rays.samples.len() - 1;
        rays.samples[last] =
            FilmSample { radiance: Vec3::new(3.0, 6.0, -12.0), weight: 3.0, ..FilmSample::default() };
        for filter in filters {
            assert!(rays.picture(&filter).iter().all(|pixel| *pixel == Vec3::new(1.0, 2.0, -4.0)));
        }
        rays.reconstruct(|from| {
            for (x, y) in [(width, 0), (0, height), (u32::MAX, u32::MAX)] {
                assert_eq!(from.pixel(x, y, &turned(4.0, 4.0, 0.0)), Vec3::ZERO, "outside");
            }
        });
    }
}

/// Fewer rays than tiles of 16 x 16: some passes have none at all, and later ones fill the picture.
#[test]
fn a_budget_below_one_ray_a_tile_still_makes_a_picture() {
    let density = 1.0 / 4096.0;
    let mut rays = Rays::none(32, 32);
    let (mut empty, mut count) = (0, 0);
    for pass in 0..64 {
        let before = count;
        for i in 0..1024 {
            let (x, y) = (i % 32, i / 32);
            if pixel_threshold(x, y, pass, 0) < density {
                let sample = &mut rays.samples[i as usize];
                sample.weight += 1.0 / density;
                sample.radiance += Vec3::new(2.0, 4.0, 8.0) / density;
                count += 1;
            }
        }
        empty += u32::from(count == before);
        let expected = if count > 0 { Vec3::new(2.0, 4.0, 8.0) } else { Vec3::ZERO };
        for filter in [ImageFilter::NONE, turned(20.0, 20.0, 0.0)] {
            assert!(rays.picture(&filter).iter().all(|pixel| *pixel == expected));
        }
    }
    // A quarter of a ray a pass: 16 in all, within what a pixel's threshold and a block's allow.
    assert!((8..=24).contains(&count) && empty > 32, "{count} rays, {empty} passes without");
}

fn a_picture_with_a_handful_of_rays_is_filled(width: u32, height: u32) {
    let mut rays = Rays::none(width, height);
    let mut stream = Stream::new(8);
    for _ in 0..5 {
        let at = (stream.uniform() * f64::from(width) * f64::from(height)) as usize;
        rays.samples[at] = FilmSample { radiance: Vec3::splat(8.0), weight: 2.0, ..FilmSample::default() };
    }
    rays.reconstruct(|from| {
        for i in 0..300 {
            let (x, y) = (i * 7919 % width, i * 31 % height);
            for filter in
                [ImageFilter::NONE, turned(0.5, 0.5, 0.0), turned(4.0, 32.0, 0.8), turned(1e5, 1e5, 0.0)]
            {
                assert_eq!(from.pixel(x, y, &filter), Vec3::splat(4.0));
            }
        }
    });
}

#[test]
fn a_picture_8192_pixels_wide_with_a_handful_of_rays_is_filled() {
    a_picture_with_a_handful_of_rays_is_filled(8192, 64);
}

#[test]
#[ignore = "takes 1.8 GB of memory"]
fn a_picture_of_8192_by_8192_pixels_with_a_handful_of_rays_is_filled() {
    a_picture_with_a_handful_of_rays_is_filled(8192, 8192);
}
