//! The spectrum of the picture, read off the grid: slices across the eye ray, in pixels.

use std::f64::consts::PI;

use covbeam::{
    Column, EyeRay, FluenceCell, FluenceGrid, FluenceSpectrum, GridLayout, ImageFilter, ImageSpectrum,
    Medium, PixelStep, Vec3,
};
use covbeam_tests::random::Stream;
use glam::DVec3;
use proptest::prelude::*;

pub(super) const LAYOUT: GridLayout =
    GridLayout { min: Vec3::new(-1.5, -1.0, -2.0), max: Vec3::new(2.0, 1.6, 2.4), cells: [35, 26, 44] };

/// Dense and unequal, so that swapped axes show: \[xx, yy, zz, xy, xz, yz\].
const DENSE: [f64; 6] = [30.0, 11.0, 50.0, 7.0, -16.0, 9.0];

pub(super) fn cells(flux: impl Fn(DVec3) -> f64, spectrum: impl Fn(DVec3) -> [f64; 6]) -> Vec<FluenceCell> {
    let [nx, ny, _] = LAYOUT.cells;
    let size = (LAYOUT.max - LAYOUT.min).as_dvec3() / DVec3::from(LAYOUT.cells.map(f64::from));
    (0..LAYOUT.cell_count() as u32)
        .map(|i| {
            let at = [i % nx, i / nx % ny, i / nx / ny].map(|place| f64::from(place) + 0.5);
            let center = LAYOUT.min.as_dvec3() + DVec3::from(at) * size;
            let spectrum = FluenceSpectrum::from_array(spectrum(center).map(|x| x as f32));
            FluenceCell { spectrum, weight: flux(center) as f32 }
        })
        .collect()
}

/// Where a ray enters and leaves the grid's box, from its origin on.
pub(super) fn inside(ray: &EyeRay) -> [f64; 2] {
    let (origin, direction) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
    let [a, b] = [LAYOUT.min, LAYOUT.max].map(|corner| (corner.as_dvec3() - origin) / direction);
    [a.min(b).max_element().max(0.0), a.max(b).min_element().min(f64::from(ray.length))]
}

/// How a point at this distance moves, across the ray, with a step to the right and a step down.
pub(super) fn across(ray: &EyeRay, steps: &[PixelStep; 2], distance: f64) -> [DVec3; 2] {
    let direction = ray.direction.as_dvec3();
    steps.map(|step| {
        let moved = step.origin.as_dvec3() + distance * step.direction.as_dvec3();
        moved - moved.dot(direction) * direction
    })
}

/// Jᵀ S J by components: \[xx, xy, yy\].
pub(super) fn slice([xx, yy, zz, xy, xz, yz]: [f64; 6], j: [DVec3; 2]) -> [f64; 3] {
    let s = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]];
    let entry = |a: DVec3, b: DVec3| (0..9).map(|i| a[i / 3] * s[i / 3][i % 3] * b[i % 3]).sum();
    [entry(j[0], j[0]), entry(j[0], j[1]), entry(j[1], j[1])]
}

/// Rays with their steps: of pinholes inside and outside of the box, of an orthographic camera, and of one that is both. No step is at a
/// right angle to the ray or to the other one.
pub(super) fn views() -> Vec<(EyeRay, [PixelStep; 2])> {
    let ray = |origin: [f32; 3], towards: [f32; 3], length| {
        let direction = (Vec3::from(towards) - Vec3::from(origin)).normalize();
        EyeRay { origin: origin.into(), direction, length }
    };
    let step = |origin: [f32; 3], direction: [f32; 3]| PixelStep {
        origin: origin.into(),
        direction: direction.into(),
    };
    let turn = [step([0.0; 3], [0.004, 0.001, -0.002]), step([0.0; 3], [0.0005, -0.003, 0.001])];
    let shift = [step([0.01, 0.002, 0.003], [0.0; 3]), step([-0.001, -0.006, 0.004], [0.0; 3])];
    let both =
        [step([0.01, 0.0, 0.002], [-0.003, 0.004, 0.001]), step([0.003, 0.005, 0.0], [0.001, -0.006, 0.002])];
    vec![
        (ray([-0.7, 0.4, -1.6], [1.7, -0.3, 2.0], f32::INFINITY), turn),
        (ray([-0.7, 0.4, -1.6], [1.7, -0.3, 2.0], 2.1), turn),
        (ray([3.0, 2.0, 4.0], [-0.5, 0.1, -1.0], f32::INFINITY), turn),
        (ray([1.2, -0.8, 1.9], [-1.1, 1.5, 0.3], f32::INFINITY), shift),
        (ray([1.2, -0.8, 1.9], [-1.1, 1.5, 0.3], 2.5), both),
    ]
}

/// Of the channels of [`fog`]: share of the scattering, and extinction over the mean one.
const CHANNELS: [[f64; 2]; 3] = [[1.0 / 6.0, 0.75], [1.0 / 3.0, 1.0], [0.5, 1.25]];

/// Extinction in the mean over the channels.
fn fog(extinction: f32) -> Medium<'static> {
    Medium {
        scattering: 0.5 * extinction * Vec3::new(0.5, 1.0, 1.5),
        absorption: Vec3::splat(0.5 * extinction),
        ..Medium::default()
    }
}

/// What is left of scattered light behind a way.
fn left(extinction: f64, distance: f64) -> f64 {
    CHANNELS.iter().map(|[share, ratio]| share * (-ratio * extinction * distance).exp()).sum()
}

/// Its integral along a way.
fn through([from, to]: [f64; 2], extinction: f64) -> f64 {
    let of = |[share, ratio]: &[f64; 2]| {
        let s = ratio * extinction;
        share * ((-s * from).exp() - (-s * to).exp()) / s
    };
    CHANNELS.iter().map(of).sum()
}

fn homogeneous(
    ray: &EyeRay,
    steps: &[PixelStep; 2],
    cells: &[FluenceCell],
    extinction: f32,
) -> ImageSpectrum {
    let grid = FluenceGrid::new(LAYOUT, cells).unwrap();
    ImageSpectrum::along(ray, steps, &grid, &fog(extinction), &Column::Uniform)
}

#[track_caller]
pub(super) fn assert_close(found: &ImageSpectrum, expected: [f64; 3], weight: f64, tolerance: f64) {
    let size = expected[0] + expected[2];
    for (found, expected) in [found.xx, found.xy, found.yy].into_iter().zip(expected) {
        assert!((f64::from(found) - expected).abs() <= tolerance * size, "{found}, not {expected} of {size}");
    }
    assert!((f64::from(found.weight) / weight - 1.0).abs() < tolerance, "{}, not {weight}", found.weight);
}

/// A point moves by distance x step: C = JᵀΣJ ∫ t² e^(-σt) dt / ∫ e^(-σt) dt, with J of the steps of direction; both integrals are means of the
/// channels by their scattering.
#[test]
fn a_pinholes_picture_of_even_light_has_the_spectrum_of_its_mean_squared_distance() {
    let cells = cells(|_| 1.0, |_| DENSE);
    for (ray, steps) in &views()[..3] {
        for extinction in [0.05, 0.4, 3.0] {
            let of_channel = |t: f64, s: f64| {
                [t * t / s + 2.0 * t / (s * s) + 2.0 / (s * s * s), 1.0 / s].map(|x| x * (-s * t).exp())
            };
            let from_on = |t: f64| {
                CHANNELS.iter().fold([0.0; 2], |sum, [share, ratio]| {
                    let of = of_channel(t, ratio * f64::from(extinction));
                    [0, 1].map(|i| sum[i] + share * of[i])
                })
            };
            let [[a2, a0], [b2, b0]] = inside(ray).map(from_on);
            let unit = slice(
                DENSE,
                across(ray, &steps.map(|step| PixelStep { origin: step.direction, ..step }), 0.0),
            );
            let expected = unit.map(|x| x * (a2 - b2) / (a0 - b0));
            assert!((expected[0] / expected[2] - 1.0).abs() > 0.2 && expected[1].abs() > 0.05 * expected[0]);
            // The midpoint rule in steps of 0.1: (σ 0.1)²/24 = 0.6 % of the weights where extinction is largest.
            assert_close(&homogeneous(ray, steps, &cells, extinction), expected, a0 - b0, 0.007);
        }
    }
}

#[test]
fn an_orthographic_picture_of_even_light_has_the_spectrum_of_its_slice() {
    let cells = cells(|_| 0.5, |_| DENSE);
    let (ray, steps) = views()[3];
    let expected = slice(DENSE, across(&ray, &steps, 0.0));
    let [from, to] = inside(&ray);
    // The same at each step: rounding alone.
    assert_close(&homogeneous(&ray, &steps, &cells, 0.0), expected, 0.5 * (to - from), 1e-5);
    assert_close(&homogeneous(&ray, &steps, &cells, 0.7), expected, 0.5 * through([from, to], 0.7), 1e-3);
}

/// Light and spectrum that vary smoothly, integrated in f64 in a thousand steps.
#[test]
fn what_is_brighter_and_nearer_counts_for_more() {
    let flux = |p: DVec3| (0.4 * p.x - 0.7 * p.y + 0.2 * p.z - 1.0).exp();
    let spectrum = |p: DVec3| DENSE.map(|x| x * (1.0 + 0.3 * (1.3 * p.z - p.x).sin()));
    let cells = cells(flux, spectrum);
    for (ray, steps) in views() {
        for extinction in [0.0, 0.6] {
            let [from, to] = inside(&ray);
            let (mut sum, mut weights) = ([0.0; 3], 0.0);
            for i in 0..1000 {
                let distance = from + (to - from) * (f64::from(i) + 0.5) / 1000.0;
                let at = ray.origin.as_dvec3() + distance * ray.direction.as_dvec3();
                let weight = flux(at) * left(extinction, distance) * (to - from) / 1000.0;
                let here = slice(spectrum(at), across(&ray, &steps, distance));
                sum = std::array::from_fn(|i| sum[i] + weight * here[i]);
                weights += weight;
            }
            // Interpolation between voxels of 0.1, where the flux has a scale of 1.2: (0.1/1.2)²/8 = 0.1 %; within half a voxel of the
            // border, values that are held instead: 4 % of 1/30 of the way at each end.
            let found = homogeneous(&ray, &steps, &cells, extinction as f32);
            assert_close(&found, sum.map(|x| x / weights), weights, 0.005);
        }
    }
}

#[test]
fn what_is_along_the_ray_does_not_count() {
    for (ray, steps) in views() {
        let d = ray.direction.as_dvec3();
        let along = [d.x * d.x, d.y * d.y, d.z * d.z, d.x * d.y, d.x * d.z, d.y * d.z];
        let more = cells(|_| 1.0, |_| std::array::from_fn(|i| DENSE[i] + 40.0 * along[i]));
        let plain = homogeneous(&ray, &steps, &cells(|_| 1.0, |_| DENSE), 0.3);
        let longer = steps.map(|step| PixelStep {
            origin: step.origin - 0.01 * ray.direction,
            direction: step.direction + 0.02 * ray.direction,
        });
        let expected = [plain.xx, plain.xy, plain.yy].map(f64::from);
        for found in [homogeneous(&ray, &steps, &more, 0.3), homogeneous(&ray, &longer, &more, 0.3)] {
            // Rounding of the product with J, 40 times what is left of it.
            assert_close(&found, expected, f64::from(plain.weight), 1e-4);
        }
    }
}

#[test]
fn voxels_without_data_and_rays_beside_the_box_have_no_opinion() {
    let (ray, steps) = views()[0];
    let dark = vec![FluenceCell::default(); LAYOUT.cell_count()];
    assert_eq!(homogeneous(&ray, &steps, &dark, 0.3), ImageSpectrum::default());
    let lit = cells(|_| 1.0, |_| DENSE);
    let past = EyeRay { origin: Vec3::new(0.0, 5.0, 0.0), direction: Vec3::X, length: 9.0 };
    let away = EyeRay { origin: Vec3::new(9.0, 0.0, 0.0), direction: Vec3::X, length: 9.0 };
    let short = EyeRay { origin: Vec3::new(-9.0, 0.0, 0.0), direction: Vec3::X, length: 7.0 };
    for ray in [past, away, short] {
        assert_eq!(homogeneous(&ray, &steps, &lit, 0.3), ImageSpectrum::default(), "{ray:?}");
    }
    let unsound = |change: &dyn Fn(&mut EyeRay, &mut [PixelStep; 2])| {
        let (mut ray, mut steps) = (ray, steps);
        change(&mut ray, &mut steps);
        assert_eq!(homogeneous(&ray, &steps, &lit, 0.3), ImageSpectrum::default(), "{ray:?}, {steps:?}");
    };
    unsound(&|ray, _| ray.direction = Vec3::ZERO);
    for bad in [0.0, -1.0, f32::NAN, f32::NEG_INFINITY] {
        unsound(&|ray, _| ray.length = bad);
    }
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        for axis in 0..3 {
            unsound(&|ray, _| ray.origin[axis] = bad);
            unsound(&|ray, _| ray.direction[axis] = bad);
            for side in 0..2 {
                unsound(&|_, steps| steps[side].origin[axis] = bad);
                unsound(&|_, steps| steps[side].direction[axis] = bad);
            }
        }
    }
    // An extinction that is no number, and one that lets nothing through.
    assert_eq!(homogeneous(&ray, &steps, &lit, f32::NAN), ImageSpectrum::default());
    assert_eq!(homogeneous(&ray, &steps, &lit, f32::INFINITY), ImageSpectrum::default());
    // No steps: everything stands still, so nothing changes from pixel to pixel.
    let still = homogeneous(&ray, &[PixelStep::default(); 2], &lit, 0.3);
    assert!(still.weight > 0.0 && [still.xx, still.xy, still.yy] == [0.0; 3]);
}

#[test]
fn one_lit_voxel_speaks_for_the_rays_that_come_near() {
    let mut cells = vec![FluenceCell::default(); LAYOUT.cell_count()];
    let [nx, ny, _] = LAYOUT.cells;
    let center = Vec3::new(0.25, 0.25, 0.15);
    let index = (21 * ny + 12) * nx + 17;
    cells[index as usize] =
        FluenceCell { spectrum: FluenceSpectrum::from_array(DENSE.map(|x| x as f32)), weight: 1.0 };
    let steps = [Vec3::new(0.0, 0.01, 0.003), Vec3::new(0.0, -0.002, 0.02)]
        .map(|origin| PixelStep { origin, direction: Vec3::ZERO });
    let towards = |aside: f32| EyeRay {
        origin: center + Vec3::new(-9.0, aside, 0.0),
        direction: Vec3::X,
        length: f32::INFINITY,
    };
    let found = homogeneous(&towards(0.04), &steps, &cells, 0.0);
    let expected = slice(DENSE, across(&towards(0.0), &steps, 0.0));
    // The flux falls linearly to 0 over a voxel's width on each side: in the middle, a triangle of 0.1 x 1; 0.4 of a voxel aside, 0.6
    // of that. Steps as long as the triangle's half get it right within a tenth.
    for (found, expected) in [found.xx, found.xy, found.yy].into_iter().zip(expected) {
        assert!((f64::from(found) / expected - 1.0).abs() < 1e-4, "{found}, not {expected}");
    }
    assert!((found.weight / 0.06 - 1.0).abs() < 0.1, "{}", found.weight);
    assert_eq!(homogeneous(&towards(0.11), &steps, &cells, 0.0), ImageSpectrum::default());
}

/// A spectrum S = BBᵀ, nearly of one direction, of two, or any between; its largest eigenvalue is at most 2 `scale`².
fn any_spectrum(stream: &mut Stream, scale: f64) -> [f64; 6] {
    let [a, b] = [(); 2].map(|()| stream.direction().as_dvec3());
    let (a, b) = (scale * a, scale * stream.decades(-6.0, 0.0) * b);
    [
        a.x * a.x + b.x * b.x,
        a.y * a.y + b.y * b.y,
        a.z * a.z + b.z * b.z,
        a.x * a.y + b.x * b.y,
        a.x * a.z + b.x * b.z,
        a.y * a.z + b.y * b.z,
    ]
}

proptest! {
    #[test]
    fn spectra_are_finite_and_positive_semi_definite(seed in any::<u64>(), extinction in 0.0..3.0_f32) {
        let mut stream = Stream::new(seed);
        let layout = GridLayout { cells: [5, 4, 6], ..LAYOUT };
        // Products with weights and squared steps keep all digits of an f32.
        let scale = stream.decades(-2.0, 6.0);
        let cells: Vec<FluenceCell> = (0..120)
            .map(|_| {
                let spectrum = FluenceSpectrum::from_array(any_spectrum(&mut stream, scale).map(|x| x as f32));
                FluenceCell { spectrum, weight: if stream.uniform() < 0.5 { stream.decades(-2.0, 0.0) as f32 } else { 0.0 } }
            })
            .collect();
        let grid = FluenceGrid::new(layout, &cells).unwrap();
        for _ in 0..10 {
            let size = stream.decades(-4.0, 1.0) as f32;
            let origin = Vec3::from([(); 3].map(|()| stream.between(-3.0, 3.0) as f32));
            let ray = EyeRay { origin, direction: stream.direction(), length: stream.decades(-2.0, 2.0) as f32 };
            let steps = [(); 2].map(|()| PixelStep { origin: size * stream.direction(), direction: size * stream.direction() });
            let found = ImageSpectrum::along(&ray, &steps, &grid, &fog(extinction), &Column::Uniform);
            let ImageSpectrum { xx, xy, yy, weight } = found;
            prop_assert!((xx + xy + yy + weight).is_finite() && weight >= 0.0, "{found:?}");
            prop_assert!(weight > 0.0 || found == ImageSpectrum::default());
            if weight > 0.0 {
                // Sums of nine products of f32, each rounded to 6e-8 of |S| |J|² at the far end; of voxels up to 100 times as bright
                // as those that the mean is over.
                let [_, to] = inside(&ray);
                let largest = across(&ray, &steps, to).map(|v| v.length_squared()).iter().sum::<f64>();
                let rounding = 1e-4 * 2.0 * scale * scale * largest.max(2.0 * f64::from(size * size));
                let [xx, xy, yy] = [xx, xy, yy].map(f64::from);
                let least = 0.5 * (xx + yy) - (0.25 * (xx - yy).powi(2) + xy * xy).sqrt();
                prop_assert!(least >= -rounding, "{found:?}: {least} beyond {rounding}");
            }
            let filter = found.filter(0.04, 64.0);
            prop_assert!(filter.density() > 0.0 && filter.density() <= 1.0);
            prop_assert!(weight > 0.0 || filter == ImageFilter::NONE);
        }
    }

    #[test]
    fn cells_of_any_numbers_give_a_finite_spectrum_or_none(seed in any::<u64>(), bad in any::<[u32; 7]>()) {
        let mut stream = Stream::new(seed);
        let layout = GridLayout { cells: [3, 3, 3], ..LAYOUT };
        let [xx, yy, zz, xy, xz, yz, weight] = bad.map(f32::from_bits);
        let hostile = [f32::NAN, f32::INFINITY, -1.0, 3e38, 1e-45, 0.0, 1.0];
        let mut any = |number: f32| if stream.uniform() < 0.5 { number } else { hostile[(stream.uniform() * 7.0) as usize] };
        let cells: Vec<FluenceCell> = (0..27)
            .map(|_| {
                let spectrum = FluenceSpectrum { xx: any(xx), yy: any(yy), zz: any(zz), xy: any(xy), xz: any(xz), yz: any(yz) };
                FluenceCell { spectrum, weight: any(weight) }
            })
            .collect();
        let grid = FluenceGrid::new(layout, &cells).unwrap();
        for (ray, steps) in views() {
            let found = ImageSpectrum::along(&ray, &steps, &grid, &fog(0.3), &Column::Uniform);
            prop_assert!((found.xx + found.xy + found.yy + found.weight).is_finite(), "{found:?}");
            prop_assert!(found.weight > 0.0 || found == ImageSpectrum::default());
        }
    }
}

/// 4π² is the one constant between a spectrum and the curvature of a picture.
#[test]
fn a_gaussian_glow_has_the_spectrum_of_its_width() {
    // Fluence exp(-x²/2w²) at its middle: Σ = 1/(4π²w²), and so in pixels of 0.01 m: w is 30 pixels.
    let variance = 1.0 / (4.0 * PI * PI * 0.09);
    let cells = cells(|_| 1.0, |_| [variance, 0.0, 0.0, 0.0, 0.0, 0.0]);
    let ray = EyeRay { origin: Vec3::new(0.2, 0.2, -9.0), direction: Vec3::Z, length: f32::INFINITY };
    let steps = [Vec3::X, Vec3::NEG_Y].map(|axis| PixelStep { origin: 0.01 * axis, direction: Vec3::ZERO });
    let found = homogeneous(&ray, &steps, &cells, 0.2);
    assert!((f64::from(found.xx) * 4.0 * PI * PI * 900.0 - 1.0).abs() < 1e-5 && found.yy == 0.0);
}

#[test]
fn between_a_bright_and_a_dim_voxel_the_spectrum_is_relative_to_the_dim_one() {
    let layout = GridLayout { min: Vec3::ZERO, max: Vec3::new(2.0, 1.0, 1.0), cells: [2, 1, 1] };
    let spectrum = FluenceSpectrum { xx: 4.0, yy: 9.0, zz: 1.0, ..FluenceSpectrum::default() };
    let cells = [1.0, 0.01].map(|weight| FluenceCell { spectrum, weight });
    let grid = FluenceGrid::new(layout, &cells).unwrap();
    // Through the middle between the two, orthographic.
    let ray = EyeRay { origin: Vec3::new(1.0, 0.5, -3.0), direction: Vec3::Z, length: f32::INFINITY };
    let steps = [Vec3::X, Vec3::Y].map(|origin| PixelStep { origin, direction: Vec3::ZERO });
    let found = ImageSpectrum::along(&ray, &steps, &grid, &Medium::default(), &Column::Uniform);
    // Arithmetic mean of the weights over their harmonic mean: 0.505 / (2/101).
    let contrast = 0.505 * 101.0 / 2.0;
    assert!((found.xx / (4.0 * contrast) - 1.0).abs() < 2e-6, "{found:?}");
    assert!((found.yy / (9.0 * contrast) - 1.0).abs() < 2e-6, "{found:?}");
}
