//! Phase functions, their samplers and bandwidths, and transmittance, against textbook formulas in f64.

use std::f64::consts::PI;

use covbeam::{Column, Medium, PhaseFunction, PhaseKind, PhaseShare, Vec3};
use covbeam_tests::random::Stream;

/// The largest uniform number that a 24-bit generator makes.
const LAST_XI: f32 = 1.0 - f32::EPSILON / 2.0;

const ASYMMETRIES: [f32; 13] =
    [-0.999_999, -0.98, -0.7, -0.1, -1e-4, -1e-20, 0.0, 1e-8, 1e-3, 0.3, 0.85, 0.99, 0.999_999];

fn hg(asymmetry: f32) -> PhaseFunction {
    PhaseFunction { kind: PhaseKind::HenyeyGreenstein, asymmetry }
}

const RAYLEIGH: PhaseFunction = PhaseFunction { kind: PhaseKind::Rayleigh, asymmetry: 0.0 };

fn all_phases() -> Vec<PhaseFunction> {
    let mut phases: Vec<_> = ASYMMETRIES.into_iter().map(hg).collect();
    phases.extend([PhaseFunction::ISOTROPIC, RAYLEIGH]);
    phases
}

/// Textbook density over directions \[1/sr\].
fn exact_density(phase: &PhaseFunction, cosine: f64) -> f64 {
    match phase.kind {
        PhaseKind::Isotropic => 1.0 / (4.0 * PI),
        PhaseKind::Rayleigh => 3.0 / (16.0 * PI) * (1.0 + cosine * cosine),
        PhaseKind::HenyeyGreenstein => {
            let g = f64::from(phase.asymmetry);
            (1.0 - g * g) / (4.0 * PI * (1.0 + g * g - 2.0 * g * cosine).powf(1.5))
        }
    }
}

/// Textbook cumulative distribution of the cosine.
fn exact_cdf(phase: &PhaseFunction, cosine: f64) -> f64 {
    match phase.kind {
        PhaseKind::Isotropic => 0.5 * (1.0 + cosine),
        PhaseKind::Rayleigh => (4.0 + 3.0 * cosine + cosine.powi(3)) / 8.0,
        PhaseKind::HenyeyGreenstein => {
            let g = f64::from(phase.asymmetry);
            if g.abs() < 1e-6 {
                // First order in g; the rest is below 1e-12.
                return 0.5 * (1.0 + cosine) - 0.75 * g * (1.0 - cosine * cosine);
            }
            (1.0 - g * g) / (2.0 * g) * (1.0 / (1.0 + g * g - 2.0 * g * cosine).sqrt() - 1.0 / (1.0 + g))
        }
    }
}

/// Uniform in [0, 1) with 24 bits, as renderers draw it: never rounded up to 1.
fn xi(stream: &mut Stream) -> f32 {
    (stream.uniform() * f64::from(1 << 24)) as u32 as f32 / (1 << 24) as f32
}

#[test]
fn the_value_is_the_textbook_one_at_the_cosine_as_given() {
    for phase in all_phases() {
        for i in 0..=2000 {
            // Dense at both ends, where lobes are narrow.
            let x = f64::from(i) / 1000.0 - 1.0;
            let cosine = (1.5 * x - 0.5 * x.powi(3)) as f32;
            let exact = exact_density(&phase, f64::from(cosine));
            let value = f64::from(phase.evaluate(cosine));
            // A dozen roundings of 6e-8.
            assert!((value / exact - 1.0).abs() < 6e-7, "{phase:?} at {cosine}: {value} for {exact}");
        }
    }
}

#[test]
fn phase_functions_hold_all_the_light() {
    for phase in all_phases() {
        if phase.asymmetry.abs() > 0.99 {
            continue; // Narrower than the steps of an f32 cosine; pinned point by point above.
        }
        // Midpoint rule in the angle: the lobe is smooth there.
        let n = 20_000;
        let step = PI / f64::from(n);
        let integral: f64 = (0..n)
            .map(|i| {
                let theta = (f64::from(i) + 0.5) * step;
                2.0 * PI * theta.sin() * f64::from(phase.evaluate(theta.cos() as f32)) * step
            })
            .sum();
        // At g = 0.98 the rounding of the cosine (3e-8 of a lobe 2e-4 wide) leaves up to 2e-4 a point, of random
        // sign; the midpoint rule leaves less than 1e-6.
        assert!((integral - 1.0).abs() < 2e-5, "{phase:?}: {integral}");
    }
}

/// Kolmogorov-Smirnov: sqrt(n) times the largest gap between the distribution of the samples and `phase`'s own.
fn kolmogorov(samples: &[f32], phase: &PhaseFunction) -> f64 {
    let mut sorted = samples.to_vec();
    sorted.sort_by(f32::total_cmp);
    let n = sorted.len() as f64;
    let gap = sorted.iter().enumerate().fold(0.0_f64, |gap, (i, &cosine)| {
        let expected = exact_cdf(phase, f64::from(cosine));
        gap.max((expected - i as f64 / n).abs()).max((expected - (i + 1) as f64 / n).abs())
    });
    gap * n.sqrt()
}

/// Chance of 1e-3 over all the comparisons of a test with up to 16 cases (Sidak: 6e-5 each).
const KOLMOGOROV_LIMIT: f64 = 2.28;

#[test]
fn sampled_cosines_follow_the_distribution() {
    let mut stream = Stream::new(1);
    let phases =
        [PhaseFunction::ISOTROPIC, RAYLEIGH, hg(0.0), hg(1e-3), hg(-0.4), hg(0.5), hg(0.9), hg(-0.98)];
    for phase in phases {
        let samples: Vec<f32> = (0..200_000).map(|_| phase.sample_cosine(xi(&mut stream))).collect();
        let distance = kolmogorov(&samples, &phase);
        assert!(distance < KOLMOGOROV_LIMIT, "{phase:?}: {distance}");
    }
}

#[test]
fn the_distribution_test_sees_a_slightly_wrong_lobe() {
    let mut stream = Stream::new(2);
    let samples: Vec<f32> = (0..200_000).map(|_| hg(0.5).sample_cosine(xi(&mut stream))).collect();
    assert!(kolmogorov(&samples, &hg(0.52)) > 2.0 * KOLMOGOROV_LIMIT);
    let samples: Vec<f32> = (0..200_000).map(|_| RAYLEIGH.sample_cosine(xi(&mut stream))).collect();
    assert!(kolmogorov(&samples, &PhaseFunction::ISOTROPIC) > 2.0 * KOLMOGOROV_LIMIT);
}

#[test]
fn the_sampler_inverts_the_cumulative_distribution() {
    for phase in all_phases() {
        if phase.asymmetry.abs() > 0.999 {
            continue; // Cosines as steps; the angles of such lobes are checked below.
        }
        let peak = 2.0 * PI * exact_density(&phase, 1.0_f64.copysign(f64::from(phase.asymmetry)));
        for i in 0..4096 {
            let xi = i as f32 / 4096.0;
            let cosine = f64::from(phase.sample_cosine(xi));
            // One rounding of the cosine (6e-8) moves the distribution by that times its slope, at most the peak's.
            let step = 6e-8 * peak;
            let error = (exact_cdf(&phase, cosine) - f64::from(xi)).abs();
            assert!(error < step + 4e-7, "{phase:?} at {xi}: off by {error}");
        }
    }
}

#[test]
fn the_sampler_is_exact_where_the_textbook_inverse_divides_by_zero() {
    for g in [0.0, 1e-30, -1e-30, 1e-8, -1e-8] {
        for i in 0..=256 {
            let xi = (i as f32 / 256.0).min(LAST_XI);
            // g shifts the cosine by at most 1.5 g; f32 rounds it by 6e-8.
            assert!((hg(g).sample_cosine(xi) - (2.0 * xi - 1.0)).abs() <= 1.2e-7, "g {g} xi {xi}");
        }
    }
}

#[test]
fn extremes_stay_in_range_and_grow_with_xi() {
    let mut asymmetries = ASYMMETRIES.to_vec();
    asymmetries.extend([1.0, -1.0, 2.0, f32::INFINITY, f32::NEG_INFINITY, 1.0 - f32::EPSILON / 2.0]);
    let mut phases: Vec<_> = asymmetries.into_iter().map(hg).collect();
    phases.extend([PhaseFunction::ISOTROPIC, RAYLEIGH]);
    for phase in phases {
        let mut previous = -1.0;
        for i in 0..=4096 {
            let xi = (i as f32 / 4096.0).min(LAST_XI);
            let cosine = phase.sample_cosine(xi);
            assert!((-1.0..=1.0).contains(&cosine), "{phase:?} at {xi}: {cosine}");
            assert!(cosine >= previous, "{phase:?} falls at {xi}: {previous} to {cosine}");
            previous = cosine;
        }
        // ξ = 0 gives -1, to the two roundings before it.
        assert!(phase.sample_cosine(0.0) < -1.0 + 2.5e-7, "{phase:?}: {}", phase.sample_cosine(0.0));
        for cosine in [-1.000_000_1, -1.0, 0.0, 1.0, 1.000_000_1] {
            let value = phase.evaluate(cosine);
            assert!(value > 0.0 && value.is_finite(), "{phase:?} at {cosine}: {value}");
        }
        for xi in [0.0, LAST_XI] {
            for direction in [Vec3::X, Vec3::Y, Vec3::Z, -Vec3::Z, Vec3::new(0.6, -0.64, 0.48)] {
                let sampled = phase.sample(direction, [xi, xi]);
                assert!((sampled.length() - 1.0).abs() < 2e-7, "{phase:?}: {sampled}");
            }
        }
        assert!(phase.angular_variance() >= 0.0 && phase.angular_variance().is_finite());
    }
}

#[test]
fn the_mean_cosine_is_g() {
    for g in [-0.9, -0.3, 0.0, 0.5, 0.95] {
        let n = 1 << 16;
        // Stratified: the sum is a midpoint rule, whose error here is far below the bound.
        let mean: f64 =
            (0..n).map(|i| f64::from(hg(g).sample_cosine((i as f32 + 0.5) / n as f32))).sum::<f64>()
                / n as f64;
        assert!((mean - f64::from(g)).abs() < 1e-5, "g {g}: {mean}");
    }
}

#[test]
fn sampled_directions_have_the_sampled_angle_and_any_azimuth() {
    let mut stream = Stream::new(3);
    let direction = Vec3::new(-0.48, 0.64, 0.6);
    let side = Vec3::new(0.8, 0.6, 0.0);
    let other = direction.cross(side);
    for phase in [PhaseFunction::ISOTROPIC, RAYLEIGH, hg(-0.6), hg(0.8)] {
        let mut azimuths = [0_u32; 16];
        let n = 160_000;
        for _ in 0..n {
            let pair = [xi(&mut stream), xi(&mut stream)];
            let sampled = phase.sample(direction, pair);
            // Three products and two sums of unit vectors: a few 6e-8.
            assert!((sampled.dot(direction) - phase.sample_cosine(pair[0])).abs() < 5e-7);
            let turn = sampled.dot(other).atan2(sampled.dot(side)) / std::f32::consts::TAU + 0.5;
            azimuths[((turn * 16.0) as usize).min(15)] += 1;
        }
        let expected = f64::from(n) / 16.0;
        let chi2: f64 = azimuths.iter().map(|&k| (f64::from(k) - expected).powi(2) / expected).sum();
        // 15 degrees of freedom: 1e-4 by chance.
        assert!(chi2 < 44.3, "{phase:?}: {chi2}");
    }
}

#[test]
fn the_angle_of_a_lobe_narrower_than_an_f32_cosine_is_exact() {
    let g = 0.999_999_f32;
    for xi in [0.01, 0.3, 0.5, 0.9, 0.999] {
        let sampled = hg(g).sample(Vec3::Z, [xi, 0.2]);
        let sine = f64::from(sampled.x).hypot(f64::from(sampled.y));
        let (a, x) = (f64::from(g), f64::from(xi));
        // The textbook inverse: in f64 it keeps 1e-16 of a versine of 1e-9 or more.
        let cosine = (1.0 + a * a - ((1.0 - a * a) / (1.0 - a + 2.0 * a * x)).powi(2)) / (2.0 * a);
        let exact = (1.0 - cosine * cosine).sqrt();
        // ξ = 0.999 leaves a versine of 1e-15, of which f64 keeps one digit.
        let tolerance = 2e-6 + 4e-16 / (1.0 - cosine);
        assert!((sine / exact - 1.0).abs() < tolerance, "xi {xi}: {sine} for {exact}");
    }
}

#[test]
fn the_angular_variance_is_the_lobes_relative_curvature_at_its_peak() {
    let curvature = |phase: &PhaseFunction, peak: f64| {
        let scale = 1.0 - f64::from(phase.asymmetry).abs();
        let value = |angle: f64| exact_density(phase, peak * angle.cos());
        let second = |h: f64| 2.0 * (value(h) - value(0.0)) / (h * h);
        // Richardson: the h² error goes, about 10 h⁴ = 1e-7 of it stays.
        let h = 1e-2 * scale;
        -(4.0 * second(h) - second(2.0 * h)) / (3.0 * value(0.0)) / (4.0 * PI * PI)
    };
    for g in [-0.9, -0.3, 1e-3, 0.1, 0.5, 0.85, 0.99] {
        let phase = hg(g);
        let exact = curvature(&phase, 1.0_f64.copysign(f64::from(g)));
        // Differences in f64 lose up to 1e-8 at g = 0.99; f32 rounds to 3e-7.
        let error = (f64::from(phase.angular_variance()) - exact).abs();
        assert!(error < 1e-6 * exact + 1e-9, "g {g}: {} for {exact}", phase.angular_variance());
    }
    let exact = curvature(&RAYLEIGH, 1.0);
    assert!((f64::from(RAYLEIGH.angular_variance()) / exact - 1.0).abs() < 1e-6);
    assert_eq!(PhaseFunction::ISOTROPIC.angular_variance(), 0.0);
    assert_eq!(hg(0.0).angular_variance(), 0.0);
}

#[test]
fn transmittance_is_the_exponential_of_the_optical_depth() {
    let medium = Medium {
        scattering: Vec3::new(0.3, 2.0, 0.0),
        absorption: Vec3::new(0.1, 0.0, 7.0),
        ..Medium::default()
    };
    assert_eq!(medium.extinction(), Vec3::new(0.3 + 0.1, 2.0, 7.0));
    let grey = Medium { scattering: Vec3::splat(0.7), ..Medium::default() };
    for distance in [0.0, 1e-6, 0.1, 1.0, 5.0, 12.0] {
        for medium in [medium, grey] {
            for channel in 0..3 {
                let depth = f64::from(medium.extinction()[channel]) * f64::from(distance);
                let exact = (-depth).exp();
                // The product is rounded to 6e-8 of the depth, the exponential and the sum to 6e-8 each.
                let error = (f64::from(medium.transmittance(distance)[channel]) / exact - 1.0).abs();
                assert!(error < 1.2e-7 * (1.0 + depth), "depth {depth}: {error}");
            }
        }
    }
}

#[test]
fn transmittance_is_whole_without_extinction_and_nothing_at_infinity() {
    let medium = Medium { scattering: Vec3::new(0.0, 1e-30, 3.0), ..Medium::default() };
    assert_eq!(medium.transmittance(f32::INFINITY), Vec3::new(1.0, 0.0, 0.0));
    assert_eq!(medium.transmittance(0.0), Vec3::ONE);
    assert_eq!(Medium::default().transmittance(f32::INFINITY), Vec3::ONE);
    // Optical depth 200 is below the smallest f32.
    assert_eq!(medium.transmittance(200.0 / 3.0).z, 0.0);
}

/// e^x as core computes it: what an extinction of 1 lets through on the way -x.
fn exp(x: f32) -> f32 {
    Medium::homogeneous(1.0, 0.0).transmittance(-x).x
}

#[test]
fn the_exponential_is_right_to_a_digit_over_all_its_range() {
    let mut worst: f64 = 0.0;
    // Every 89th number from -87 to 87, and so numbers of each exponent.
    for bits in (0..=87f32.to_bits()).step_by(89) {
        for x in [f32::from_bits(bits), -f32::from_bits(bits)] {
            let exact = libm::exp(f64::from(x));
            worst = worst.max((f64::from(exp(x)) / exact - 1.0).abs());
        }
    }
    assert!(worst < 1.2e-7, "{worst:e}");
}

/// (e^x - 1)/x as core computes it: the column of a way of length 1.
#[test]
fn the_mean_of_the_exponential_does_not_cancel() {
    let mut worst: f64 = 0.0;
    for bits in (0..=87f32.to_bits()).step_by(89) {
        for x in [f32::from_bits(bits), -f32::from_bits(bits)] {
            let exact = if x == 0.0 { 1.0 } else { libm::expm1(f64::from(x)) / f64::from(x) };
            let found = Column::Exponential { density: 1.0, rate: -x }.at(1.0);
            worst = worst.max((f64::from(found) / exact - 1.0).abs());
        }
    }
    println!("worst relative error: {worst:e}");
    // The exponential errs by 1.2e-7, of which at x = -ln 2 / 2 a difference of .29 has .71/.29 times; quotient and difference round by 6e-8 each.
    assert!(worst < 4e-7, "{worst:e}");
}

#[test]
fn the_exponential_of_what_is_far_out_or_no_number() {
    assert_eq!(exp(0.0), 1.0);
    assert_eq!(exp(-0.0), 1.0);
    for x in [-87.01, -1e30, f32::NEG_INFINITY] {
        assert_eq!(exp(x), 0.0, "{x}");
    }
    for x in [87.01, 1e30, f32::INFINITY] {
        assert_eq!(exp(x), f32::INFINITY, "{x}");
    }
    for bits in [0x7fc0_0000, 0x7fc0_0001, 0xffff_ffff, 0x7fc0_00ff] {
        assert!(exp(f32::from_bits(bits)).is_nan(), "{bits:x}");
    }
}

/// Samples of a mixture, weighed for each channel, have the mean cosine of its textbook lobes: g times their shares.
#[test]
fn directions_of_a_mixture_weigh_what_its_lobes_send_there() {
    let more = [
        PhaseShare { phase: hg(0.8), share: Vec3::new(0.1, 0.3, 0.6) },
        PhaseShare { phase: RAYLEIGH, share: Vec3::new(0.5, 0.2, 0.0) },
    ];
    let medium = Medium { more: &more, phase: hg(-0.4), ..Medium::homogeneous(1.0, 0.0) };
    let (along, mut stream) = (Vec3::Z, Stream::new(5));
    let (mut weights, mut cosines) = ([0.0; 3], [0.0; 3]);
    const COUNT: u32 = 200_000;
    for _ in 0..COUNT {
        let direction = medium.sample_direction(along, [xi(&mut stream), xi(&mut stream)]);
        let cosine = along.dot(direction);
        let weight = medium.sampling_weight(cosine);
        assert!(weight.min_element() >= 0.0 && weight.max_element() <= 3.0001);
        for channel in 0..3 {
            weights[channel] += f64::from(weight[channel]) / f64::from(COUNT);
            cosines[channel] += f64::from(weight[channel] * cosine) / f64::from(COUNT);
        }
    }
    for (channel, expected) in
        [0.1 * 0.8 - 0.4 * 0.4, 0.3 * 0.8 - 0.5 * 0.4, 0.6 * 0.8 - 0.4 * 0.4].into_iter().enumerate()
    {
        // Weights up to 3 have a standard deviation of less than 1.5: 0.0034 of this many.
        assert!((weights[channel] - 1.0).abs() < 0.014, "{weights:?}");
        assert!((cosines[channel] - expected).abs() < 0.014, "{cosines:?}, not {expected}");
    }
}
