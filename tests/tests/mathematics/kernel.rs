//! Kernels, radii and schedules, against quadrature and closed forms in f64.

use std::f64::consts::PI;

use covbeam::{
    FluenceCell, FluenceGrid, FluenceSpectrum, GridLayout, Kernel, KernelShape, Vec3, error_bound,
    progressive_radius,
};

const KERNELS: [KernelShape; 3] = [KernelShape::Box, KernelShape::Epanechnikov, KernelShape::Biweight];

/// ∫ K_r(d) f(d) dd over the support, midpoint rule.
fn blurred(kernel: KernelShape, radius: f32, f: impl Fn(f64) -> f64) -> f64 {
    let n = 4000;
    let step = 2.0 * f64::from(radius) / f64::from(n);
    (0..n)
        .map(|i| {
            let d = (f64::from(i) + 0.5) * step - f64::from(radius);
            f64::from(kernel.evaluate(d as f32, radius)) * f(d) * step
        })
        .sum()
}

#[test]
fn kernels_hold_all_the_light() {
    for kernel in KERNELS {
        for radius in [1e-6, 0.01, 0.3, 7.0, 1e8] {
            // Midpoint rule: (1/4000)² of a smooth bump; f32 rounding averages out below 1e-7.
            let integral = blurred(kernel, radius, |_| 1.0);
            assert!((integral - 1.0).abs() < 1e-6, "{kernel:?} r {radius}: {integral}");
        }
    }
}

#[test]
fn second_moments_are_those_of_the_kernels() {
    for kernel in KERNELS {
        let moment = blurred(kernel, 1.0, |d| d * d);
        assert!((moment - f64::from(kernel.second_moment())).abs() < 1e-6, "{kernel:?}: {moment}");
    }
    assert_eq!(KERNELS.map(KernelShape::second_moment), [1.0 / 3.0, 1.0 / 5.0, 1.0 / 7.0]);
}

#[test]
fn a_kernel_is_zero_outside_its_support_and_for_nonsense() {
    for kernel in KERNELS {
        for (distance, radius) in [
            (0.3, 0.3),
            (-0.3, 0.3),
            (1.0, 0.3),
            (f32::INFINITY, 0.3),
            (f32::NAN, 0.3),
            (0.0, 0.0),
            (0.0, -1.0),
            (0.0, f32::NAN),
            (f32::INFINITY, f32::INFINITY),
        ] {
            assert_eq!(kernel.evaluate(distance, radius), 0.0, "{kernel:?} d {distance} r {radius}");
        }
        assert!(kernel.evaluate(0.299, 0.3) > 0.0);
        assert_eq!(kernel.evaluate(-0.1, 0.3), kernel.evaluate(0.1, 0.3));
    }
}

/// Relative loss at the peak of a Gaussian of standard deviation `w` blurred by the kernel.
fn exact_bias(kernel: KernelShape, radius: f32, w: f64) -> f64 {
    1.0 - blurred(kernel, radius, |d| (-0.5 * (d / w).powi(2)).exp())
}

#[test]
fn blurring_a_gaussian_costs_the_known_bias() {
    // w = 0.7, r = 0.3: to the five digits given.
    for (kernel, known) in KERNELS.into_iter().zip([0.029_79, 0.018_01, 0.012_92]) {
        let bias = exact_bias(kernel, 0.3, 0.7);
        assert!((bias - known).abs() < 5e-6, "{kernel:?}: {bias} for {known}");
    }
}

#[test]
fn the_radius_from_an_error_costs_that_error() {
    for kernel in KERNELS {
        for w in [0.01_f64, 0.7, 30.0] {
            let variance = 1.0 / (4.0 * PI * PI * w * w);
            for error in [1e-3_f32, 0.01, 0.05] {
                let radius = kernel.radius_from_error(error, variance as f32);
                let bias = exact_bias(kernel, radius, w);
                // The next order: for these kernels the bias is ε (1 - c ε), c = μ₄/(2 μ₂²) < 1.2; quadrature 1e-6.
                let error = f64::from(error);
                assert!(bias <= error + 1e-6, "{kernel:?} w {w}: {bias} above {error}");
                assert!(bias >= error * (1.0 - 1.2 * error) - 1e-6, "{kernel:?} w {w}: {bias} below {error}");
            }
        }
    }
}

#[test]
fn flat_light_wants_an_infinite_radius_and_the_radius_falls_with_the_variance() {
    for kernel in KERNELS {
        assert_eq!(kernel.radius_from_error(0.01, 0.0), f32::INFINITY);
        let mut previous = f32::INFINITY;
        for exponent in -36..=38 {
            let radius = kernel.radius_from_error(0.01, 10_f32.powi(exponent));
            assert!(radius > 0.0 && radius < previous, "{kernel:?} at 1e{exponent}: {radius}");
            previous = radius;
        }
    }
}

#[test]
fn the_progressive_radius_is_the_quotient_of_gamma_functions() {
    for alpha in [0.5_f32, 2.0 / 3.0, 0.9] {
        for pass in [1_u32, 2, 3, 10, 64, 1000, 100_000] {
            let (n, a) = (f64::from(pass), f64::from(alpha));
            let log = libm::lgamma(n + a) - libm::lgamma(1.0 + a) - libm::lgamma(n + 1.0);
            let exact = 0.05_f32 as f64 * log.exp();
            let radius = f64::from(progressive_radius(0.05, alpha, pass));
            // One f32 rounding (6e-8); lgamma(1e5) = 1e6 is itself rounded at 1e-10.
            assert!((radius / exact - 1.0).abs() < 1e-7, "α {alpha} pass {pass}: {radius} for {exact}");
        }
    }
}

#[test]
fn the_progressive_radius_starts_at_the_initial_one_and_alpha_one_keeps_it() {
    assert_eq!(progressive_radius(0.05, 2.0 / 3.0, 1), 0.05);
    assert_eq!(progressive_radius(0.05, 2.0 / 3.0, 0), 0.05);
    assert_eq!(progressive_radius(0.05, 1.0, 1000), 0.05);
    // r_2 = r_1 (1 + α)/2.
    assert_eq!(progressive_radius(0.5, 0.5, 2), 0.375);
}

/// Γ(n+α)/(Γ(1+α) Γ(n+1)) by Stirling's formula for both, with what cancels between them taken out: the
/// next term is below n⁻³/360.
fn gamma_quotient(n: f64, alpha: f64) -> f64 {
    let stirling = (alpha - 1.0) * libm::log(n) + (n + alpha - 0.5) * libm::log1p(alpha / n)
        - (n + 0.5) * libm::log1p(1.0 / n)
        + (1.0 - alpha)
        + (1.0 / (n + alpha) - 1.0 / (n + 1.0)) / 12.0;
    libm::exp(stirling) / libm::tgamma(1.0 + alpha)
}

/// The last pass whose radius is the product itself.
const SWITCH: u32 = 4096;

const ALPHAS: [f32; 6] = [1e-3, 0.1, 0.5, 2.0 / 3.0, 0.9, 0.999];

#[test]
fn beyond_the_product_the_radius_is_the_quotient_of_gamma_functions() {
    for alpha in ALPHAS {
        for pass in [1000, 4095, 4096, 4097, 5000, 100_000, 10_000_000, 1 << 31, u32::MAX] {
            let exact = gamma_quotient(f64::from(pass), f64::from(alpha));
            let radius = f64::from(progressive_radius(0.05, alpha, pass)) / f64::from(0.05_f32);
            // One rounding to f32, 5.97e-8, and 1e-9 of the power.
            assert!((radius / exact - 1.0).abs() < 6.1e-8, "α {alpha} pass {pass}: {radius} for {exact}");
        }
    }
}

#[test]
fn beyond_the_switch_the_radius_is_the_product_still() {
    for alpha in ALPHAS {
        let mut product = f64::from(0.05_f32);
        for i in 1..1_000_000 {
            product *= (f64::from(i) + f64::from(alpha)) / f64::from(i + 1);
            let pass = i + 1;
            if pass <= SWITCH {
                assert_eq!(progressive_radius(0.05, alpha, pass), product as f32, "α {alpha} pass {pass}");
            } else if pass < SWITCH + 1000 || pass % 100_000 == 0 {
                let radius = progressive_radius(0.05, alpha, pass);
                // One rounding to f32, 5.97e-8, and 1e-9 of the power; a million f64 steps lose 3e-10 at
                // most.
                let error = f64::from(radius) / product - 1.0;
                assert!(error.abs() < 6.12e-8, "α {alpha} pass {pass}: {error}");
            }
        }
    }
}

#[test]
fn the_radius_never_rises_and_falls_across_the_switch() {
    for alpha in ALPHAS {
        let mut previous = f32::INFINITY;
        for pass in SWITCH - 200..SWITCH + 200 {
            let radius = progressive_radius(0.05, alpha, pass);
            assert!(radius <= previous, "α {alpha} pass {pass}: {radius} after {previous}");
            // A step is (1-α)/4096 of the radius: 2.4e-7 at α = 0.999, four f32 steps.
            assert!(alpha > 0.99 || radius < previous, "α {alpha} pass {pass}: {radius} twice");
            previous = radius;
        }
        for exponent in 13..32 {
            let radius = progressive_radius(0.05, alpha, 1 << exponent);
            assert!(radius < previous, "α {alpha} pass 2^{exponent}: {radius} after {previous}");
            previous = radius;
        }
    }
}

#[test]
fn the_last_pass_of_all_keeps_what_the_limits_of_alpha_say() {
    assert_eq!(progressive_radius(0.05, 1.0, u32::MAX), 0.05);
    // r_i = r_1/i.
    assert_eq!(progressive_radius(1.0, 0.0, u32::MAX), 1.0 / u32::MAX as f32);
    for pass in [2, SWITCH, SWITCH + 1, u32::MAX] {
        assert!(progressive_radius(0.05, f32::NAN, pass).is_nan());
        assert!(progressive_radius(f32::NAN, 0.5, pass).is_nan());
    }
}

#[test]
fn the_error_bound_falls_as_the_two_fifths_power() {
    // 32^(2/5) = 4, 243^(2/5) = 9, 1024^(2/5) = 16, exact in f32 but for the last rounding.
    for (pass, quotient) in [(0, 1.0), (1, 1.0), (32, 4.0), (243, 9.0), (1024, 16.0)] {
        let bound = error_bound(0.02, pass);
        assert!((bound * quotient / 0.02 - 1.0).abs() < 1.2e-7, "pass {pass}: {bound}");
    }
}

const LAYOUT: GridLayout = GridLayout { min: Vec3::ZERO, max: Vec3::ONE, cells: [1, 1, 1] };

#[test]
fn the_radius_of_a_pair_lies_between_the_progressive_one_and_the_ceiling() {
    let cell = |xx: f32, yy: f32| FluenceCell {
        spectrum: FluenceSpectrum { xx, yy, ..FluenceSpectrum::default() },
        weight: 1.0,
    };
    // Along x the light is as busy as a Gaussian of 0.1 m, along y all but flat, along z flat.
    let cells = [cell(1.0 / (4.0 * std::f32::consts::PI.powi(2) * 0.01), 1e-9)];
    let grid = FluenceGrid::new(LAYOUT, &cells).unwrap();
    let at = |min_radius: f32, max_radius: f32, grid: Option<FluenceGrid<'_>>, axis: Vec3| {
        let kernel = Kernel { shape: KernelShape::Box, min_radius, max_radius, error: 0.01, grid };
        kernel.radius_at(Vec3::splat(0.5), axis)
    };
    // r_σ = w sqrt(2 ε / μ₂) = 0.1 sqrt(0.06).
    let (radius, sigma) = at(0.001, 1.0, Some(grid), Vec3::X);
    assert!((radius / 0.024_494_897 - 1.0).abs() < 3e-7, "{radius}");
    assert!((sigma * (2.0 * std::f32::consts::PI * 0.1) - 1.0).abs() < 3e-7, "{sigma}");
    assert_eq!(at(0.03, 1.0, Some(grid), Vec3::X).0, 0.03);
    assert_eq!(at(0.001, 0.02, Some(grid), Vec3::X).0, 0.02);
    assert_eq!(at(0.001, 0.5, Some(grid), Vec3::Y).0, 0.5);
    assert_eq!(at(0.001, 0.5, Some(grid), Vec3::Z), (0.5, 0.0));
    assert_eq!(at(0.03, 0.02, Some(grid), Vec3::Z).0, 0.03);
    assert_eq!(at(0.03, 0.5, None, Vec3::X), (0.03, 0.0));
}

#[test]
fn without_data_the_radius_is_the_progressive_one() {
    let cells = [FluenceCell::default()];
    let grid = FluenceGrid::new(LAYOUT, &cells).unwrap();
    let kernel =
        Kernel { shape: KernelShape::Box, min_radius: 0.03, max_radius: 0.5, error: 0.01, grid: Some(grid) };
    assert_eq!(kernel.radius_at(Vec3::splat(0.5), Vec3::X), (0.03, 0.0));
    assert_eq!(kernel.radius_at(Vec3::splat(5.0), Vec3::X), (0.03, 0.0));
}

#[test]
fn beside_a_bright_voxel_the_bias_is_bounded_relative_to_the_dim_one() {
    let layout = GridLayout { min: Vec3::ZERO, max: Vec3::new(2.0, 1.0, 1.0), cells: [2, 1, 1] };
    let spectrum = FluenceSpectrum { xx: 4.0, yy: 9.0, zz: 1.0, ..FluenceSpectrum::default() };
    for dim in [1.0_f32, 0.5, 0.01, 1e-6] {
        let cells = [FluenceCell { spectrum, weight: 1.0 }, FluenceCell { spectrum, weight: dim }];
        let grid = FluenceGrid::new(layout, &cells).unwrap();
        let kernel = Kernel {
            shape: KernelShape::Box,
            min_radius: 1e-6,
            max_radius: 100.0,
            error: 0.01,
            grid: Some(grid),
        };
        for share in [0.0, 0.25, 0.5, 1.0] {
            let (w, t) = (f64::from(dim), f64::from(share));
            // Arithmetic over harmonic mean of the two weights.
            let contrast = (1.0 - t + t * w) * (1.0 - t + t / w);
            let sigma = f64::from(kernel.radius_at(Vec3::new(0.5 + share, 0.5, 0.5), Vec3::Y).1);
            // A dozen f32 roundings.
            assert!((sigma / (3.0 * contrast.sqrt()) - 1.0).abs() < 2e-6, "{dim} {share}: {sigma}");
        }
    }
    // A voxel without data is no dim one.
    let cells = [FluenceCell { spectrum, weight: 1.0 }, FluenceCell::default()];
    let grid = Some(FluenceGrid::new(layout, &cells).unwrap());
    let kernel = Kernel { shape: KernelShape::Box, min_radius: 1e-6, max_radius: 100.0, error: 0.01, grid };
    assert_eq!(kernel.radius_at(Vec3::new(1.0, 0.5, 0.5), Vec3::Y).1, 3.0);
}
