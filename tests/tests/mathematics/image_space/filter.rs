//! From a spectrum to a filter, and from a filter to a density of rays.

use std::f64::consts::PI;

use covbeam::{FilmNode, FilmSample, ImageFilter, ImageSpectrum, Reconstruction, Vec3};
use covbeam_tests::random::Stream;

fn spectrum(xx: f64, xy: f64, yy: f64) -> ImageSpectrum {
    ImageSpectrum { xx: xx as f32, xy: xy as f32, yy: yy as f32, weight: 1.0 }
}

/// A picture of 241 x 241 pixels with a ray through each, and what its middle is through a filter.
fn middle_through(filter: &ImageFilter, picture: &dyn Fn(f64, f64) -> f64) -> f64 {
    const SIZE: u32 = 241;
    let value = |i: u32| picture(f64::from(i % SIZE) - 120.0, f64::from(i / SIZE) - 120.0);
    let samples: Vec<FilmSample> = (0..SIZE * SIZE)
        .map(|i| FilmSample { radiance: Vec3::splat(value(i) as f32), weight: 1.0, ..FilmSample::default() })
        .collect();
    let mut nodes = vec![FilmNode::default(); Reconstruction::node_count(SIZE, SIZE)];
    let regions = vec![1; samples.len()];
    let picture = Reconstruction::new(SIZE, SIZE, &samples, &regions, &mut nodes).unwrap();
    f64::from(picture.pixel(120, 120, filter).x)
}

/// Share of a Gaussian's variance, per axis, that is left when its value at 3 standard deviations is subtracted and the rest cut:
/// ∫r³ w / 2∫r w of w = exp(-r²/2) - c up to 3, c = exp(-9/2).
fn left_of_variance() -> f64 {
    let c = (-4.5_f64).exp();
    let (second, all) = (2.0 - 11.0 * c - c * 81.0 / 4.0, 1.0 - c - c * 9.0 / 2.0);
    second / (2.0 * all)
}

/// The crest of a wave, or of two crossed ones, sinks by ε/2 for each. The wave's covariance is that of its two lines, k kᵀ.
#[test]
fn blurring_a_wave_by_its_filter_lowers_its_crest_by_half_the_error_a_direction() {
    let error = 0.04_f64;
    for (angle, slow) in [(0.0_f64, 1.0 / 90.0), (PI / 2.0, 1.0 / 60.0), (0.5, 1.0 / 70.0)] {
        let fast = 1.0 / 30.0;
        let (sin, cos) = angle.sin_cos();
        let [k, l] = [[fast * cos, fast * sin], [-slow * sin, slow * cos]];
        let wave = |k: [f64; 2], x: f64, y: f64| (2.0 * PI * (k[0] * x + k[1] * y)).cos();
        // What the truncation leaves of ε/2; the rest of the series, exp(-ε/2), is 1 % of it; the pixel's own variance adds 1/12 to
        // variances of 1 to 9 pixels², and blocks add at most a fiftieth.
        let expected = |k: f64| {
            let variance = error / (4.0 * PI * PI * k * k) + 1.0 / 12.0;
            2.0 * PI * PI * k * k * variance * left_of_variance()
        };
        let one = spectrum(k[0] * k[0], k[0] * k[1], k[1] * k[1]).filter(error as f32, 12.0);
        let bias = 1.0 - middle_through(&one, &|x, y| wave(k, x, y));
        assert!((bias / expected(fast) - 1.0).abs() < 0.03, "{angle}: {bias} for {}", expected(fast));
        assert!((0.8..1.1).contains(&(bias / (0.5 * error))), "{angle}: {bias}");

        let both = spectrum(k[0] * k[0] + l[0] * l[0], k[0] * k[1] + l[0] * l[1], k[1] * k[1] + l[1] * l[1]);
        let filter = both.filter(error as f32, 100.0);
        let bias = 1.0 - middle_through(&filter, &|x, y| wave(k, x, y) * wave(l, x, y));
        let total = expected(fast) + expected(slow);
        assert!((bias / total - 1.0).abs() < 0.03, "{angle}: {bias} for {total}");
        assert!((0.8..1.1).contains(&(bias / error)), "{angle}: {bias}");
    }
}

/// H = ε/(4π²) C⁻¹, by the closed form of the inverse in f64.
#[test]
fn a_filter_is_the_scaled_inverse_of_the_spectrum() {
    let mut stream = Stream::new(3);
    for _ in 0..1000 {
        let (a, b) = (stream.decades(-4.0, 0.0), stream.decades(-4.0, 0.0));
        let (sin, cos) = stream.between(0.0, PI).sin_cos();
        let (xx, xy, yy) =
            (a * cos * cos + b * sin * sin, (a - b) * sin * cos, a * sin * sin + b * cos * cos);
        let error = stream.decades(-3.0, 0.0);
        let filter = spectrum(xx, xy, yy).filter(error as f32, 1e6);
        let scale = error / (4.0 * PI * PI) / (a * b);
        let expected = [scale * yy, -scale * xy, scale * xx];
        // f32 carries the larger eigenvalue of the filter to a few digits' rounding times the ratio of the two.
        let tolerance = 1e-6 * expected[0].max(expected[2]) * (a / b).max(b / a);
        for (found, expected) in [filter.xx, filter.xy, filter.yy].into_iter().zip(expected) {
            assert!((f64::from(found) - expected).abs() < tolerance, "{filter:?}, not {expected}");
        }
        let wider = spectrum(xx, xy, yy).filter(4.0 * error as f32, 1e6);
        assert!((wider.xx / filter.xx - 4.0).abs() < 1e-3 && (wider.yy / filter.yy - 4.0).abs() < 1e-3);
    }
}

#[test]
fn the_widest_filter_is_respected_along_each_principal_axis() {
    let widest = 20.0_f32;
    // Fast along (0.6, 0.8), slow across it: only the slow axis is cut.
    let (fast, slow) = (0.01, 1e-9);
    let (x, y) = (0.6, 0.8);
    let askew = spectrum(fast * x * x + slow * y * y, (fast - slow) * x * y, fast * y * y + slow * x * x);
    let filter = askew.filter(0.04, widest);
    let along = |x: f32, y: f32| filter.xx * x * x + 2.0 * filter.xy * x * y + filter.yy * y * y;
    let thin = 0.04 / (4.0 * PI as f32 * PI as f32 * 0.01);
    assert!((along(0.6, 0.8) - thin).abs() < 1e-3, "{} across the fringes", along(0.6, 0.8));
    assert!((along(-0.8, 0.6) - 400.0).abs() < 0.1, "{} along them", along(-0.8, 0.6));
    // Longer against the slope of the fringes: x falls as y grows.
    assert!(filter.xy < -100.0);
    // No variance at all, and less than none by rounding.
    let flat = ImageFilter { xx: 400.0, xy: 0.0, yy: 400.0 };
    assert_eq!(spectrum(0.0, 0.0, 0.0).filter(0.04, widest), flat);
    assert_eq!(spectrum(-1e-12, 0.0, -1e-12).filter(0.04, widest), flat);
    let line = spectrum(0.01, 0.0, 0.0).filter(0.04, widest);
    assert_eq!((line.yy, line.xy), (400.0, 0.0));
    assert!((line.xx / thin - 1.0).abs() < 1e-5);
}

/// As a difference of large numbers the thin side would be lost, or negative, which is no filter.
#[test]
fn a_filter_keeps_its_thin_side_however_long_it_is() {
    let thin = 0.04 / (4.0 * PI * PI * 0.25);
    let across = spectrum(0.25, 0.0, 0.0).filter(0.04, 1e4);
    let down = spectrum(0.0, 0.0, 0.25).filter(0.04, 1e4);
    for (short, long) in [(across.xx, across.yy), (down.yy, down.xx)] {
        assert!((f64::from(short) / thin - 1.0).abs() < 1e-6 && long == 1e8, "{short} x {long}");
    }
    for angle in 0..64 {
        let (sin, cos) = (f64::from(angle) * PI / 64.0).sin_cos();
        let askew = spectrum(0.25 * cos * cos, 0.25 * cos * sin, 0.25 * sin * sin).filter(0.04, 1e4);
        assert!(f64::from(askew.xx) > 0.9 * thin && f64::from(askew.yy) > 0.9 * thin, "{askew:?}");
    }
}

#[test]
fn without_an_opinion_or_a_sound_error_there_is_no_filter() {
    assert_eq!(ImageSpectrum::default().filter(0.04, 20.0), ImageFilter::NONE);
    let sound = spectrum(0.01, 0.002, 0.02);
    for bad in [0.0, -1.0, f32::NAN] {
        assert_eq!(sound.filter(bad, 20.0), ImageFilter::NONE, "error {bad}");
        assert_eq!(sound.filter(0.04, bad), ImageFilter::NONE, "widest {bad}");
    }
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        for broken in [
            ImageSpectrum { xx: bad, ..sound },
            ImageSpectrum { xy: bad, ..sound },
            ImageSpectrum { yy: bad, ..sound },
        ] {
            assert_eq!(broken.filter(0.04, 20.0), ImageFilter::NONE, "{broken:?}");
        }
    }
    let hostile = [0.0, 1e-45, -1e-3, 1e-30, 1.0, 1e10, 1e30, 3e38, f32::NAN, f32::INFINITY];
    for (xx, xy) in hostile.iter().flat_map(|xx| hostile.map(|xy| (*xx, xy))) {
        for (yy, error) in hostile.iter().flat_map(|yy| hostile.map(|error| (*yy, error))) {
            for widest in hostile {
                let found = ImageSpectrum { xx, xy, yy, weight: 1.0 }.filter(error, widest);
                let finite = found.xx.is_finite() && found.xy.is_finite() && found.yy.is_finite();
                assert!(finite, "{found:?} of {xx}, {xy}, {yy}, error {error}, widest {widest}");
            }
        }
    }
}

/// A Gaussian of covariance K averages over (∫w)²/∫w² = 4π sqrt(det K) pixels; a pixel is a box of variance 1/12.
#[test]
fn there_are_two_rays_under_each_filter() {
    let mut stream = Stream::new(4);
    let mut ratios = Vec::new();
    for _ in 0..2000 {
        let (a, b) = (stream.decades(-3.0, 4.0), stream.decades(-3.0, 4.0));
        let c = (a * b).sqrt() * stream.between(-0.9, 0.9);
        let density = f64::from(ImageFilter { xx: a as f32, xy: c as f32, yy: b as f32 }.density());
        let area = 4.0 * PI * ((a + 1.0 / 12.0) * (b + 1.0 / 12.0) - c * c).sqrt();
        let expected = (2.0 / area).min(1.0);
        assert!((density / expected - 1.0).abs() < 1e-5, "{density}, not {expected}");
        assert!(density > 0.0 && density <= 1.0);
        ratios.push(expected);
        // Wider never asks for more.
        let wider = ImageFilter { xx: 1.5 * a as f32, xy: c as f32, yy: b as f32 };
        assert!(f64::from(wider.density()) <= density);
    }
    assert!(ratios.contains(&1.0) && ratios.iter().any(|density| *density < 1e-3));
    assert_eq!(ImageFilter::NONE.density(), 1.0);
}

#[test]
fn every_filter_has_a_density_in_range() {
    let hostile =
        [0.0, -0.0, 1e-45, -1.0, -1e30, 1e19, 1e30, 3e38, f32::NAN, f32::INFINITY, f32::NEG_INFINITY];
    for (xx, xy) in hostile.iter().flat_map(|xx| hostile.map(|xy| (*xx, xy))) {
        for yy in hostile {
            let density = ImageFilter { xx, xy, yy }.density();
            assert!(density > 0.0 && density <= 1.0, "{density} for {xx}, {xy}, {yy}");
        }
    }
}
