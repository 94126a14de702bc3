//! What density and attenuation add to the spectrum of the picture, against finite differences.

use std::f64::consts::PI;

use covbeam::{
    Density, DensityGrid, ExponentialDensity, EyeRay, FluenceGrid, GridLayout, ImageSpectrum, Medium,
    PixelStep, Vec3,
};
use glam::DVec3;

use super::spectrum::{LAYOUT, across, assert_close, cells, inside, slice, views};

/// Steps of the quadrature in f64.
const STEPS: usize = 2000;

/// A medium and the light in it, in f64.
struct Twin<'a> {
    density: &'a dyn Fn(DVec3) -> f64,
    extinction: f64,
    flux: &'a dyn Fn(DVec3) -> f64,
    spectrum: [f64; 6],
}

/// Magnitudes of the eigenvalues of \[xx, xy, yy\], along the same axes.
fn magnitudes([xx, xy, yy]: [f64; 3]) -> [f64; 3] {
    let angle = 0.5 * (2.0 * xy).atan2(xx - yy);
    let (sin, cos) = angle.sin_cos();
    let high = (xx * cos * cos + 2.0 * xy * sin * cos + yy * sin * sin).abs();
    let low = (xx * sin * sin - 2.0 * xy * sin * cos + yy * cos * cos).abs();
    [high * cos * cos + low * sin * sin, (high - low) * sin * cos, high * sin * sin + low * cos * cos]
}

/// Second derivatives from values at offsets of -h, 0, h: `[across][down]`.
fn hessian(values: [[f64; 3]; 3], h: f64) -> [f64; 3] {
    let middle = values[1][1];
    [
        (values[0][1] - 2.0 * middle + values[2][1]) / (h * h),
        (values[2][2] - values[2][0] - values[0][2] + values[0][0]) / (4.0 * h * h),
        (values[1][0] - 2.0 * middle + values[1][2]) / (h * h),
    ]
}

/// What a walk along a ray and its eight neighbours found.
struct Found {
    /// Slices and the magnitudes of each point's curvature, averaged.
    spectrum: [f64; 3],
    /// The same without magnitudes.
    signed: [f64; 3],
    /// Of the whole picture: the Hessian of radiance over radiance and 4π².
    picture: [f64; 3],
    weight: f64,
}

impl Twin<'_> {
    fn walk(&self, ray: &EyeRay, steps: &[PixelStep; 2]) -> Found {
        let [from, to] = inside(ray);
        assert_eq!(from, 0.0, "the eye is in the box");
        let step = to / STEPS as f64;
        // Two hundredths of a metre where points move most.
        let h = [0.0, to]
            .map(|end| across(ray, steps, end))
            .iter()
            .flatten()
            .fold(0.0_f64, |most, v| most.max(v.length()));
        let h = 0.02 / h;
        let (mut depth, mut radiance) = ([[0.0; 3]; 3], [[0.0; 3]; 3]);
        let mut found = Found { spectrum: [0.0; 3], signed: [0.0; 3], picture: [0.0; 3], weight: 0.0 };
        for i in 0..STEPS {
            let distance = (i as f64 + 0.5) * step;
            let at = ray.origin.as_dvec3() + distance * ray.direction.as_dvec3();
            let moved = across(ray, steps, distance);
            let mut light = [[0.0; 3]; 3];
            for (i, j) in (0..9).map(|k| (k / 3, k % 3)) {
                let density =
                    (self.density)(at + h * ((i as f64 - 1.0) * moved[0] + (j as f64 - 1.0) * moved[1]));
                let half = 0.5 * self.extinction * density * step;
                light[i][j] = density * (-depth[i][j] - half).exp();
                depth[i][j] += 2.0 * half;
                radiance[i][j] += light[i][j] * step;
            }
            let curvature = hessian(light, h).map(|x| x / light[1][1] / (4.0 * PI * PI));
            let (magnitudes, slice) = (magnitudes(curvature), slice(self.spectrum, moved));
            let weight = (self.flux)(at) * light[1][1] * step;
            for k in 0..3 {
                found.spectrum[k] += weight * (slice[k] + magnitudes[k]);
                found.signed[k] += weight * (slice[k] + curvature[k]);
            }
            found.weight += weight;
        }
        found.spectrum = found.spectrum.map(|x| x / found.weight);
        found.signed = found.signed.map(|x| x / found.weight);
        found.picture = hessian(radiance, h).map(|x| x / radiance[1][1] / (4.0 * PI * PI));
        found
    }

    fn core(&self, ray: &EyeRay, steps: &[PixelStep; 2], density: &Density) -> ImageSpectrum {
        let cells = cells(self.flux, |_| self.spectrum);
        let grid = FluenceGrid::new(LAYOUT, &cells).unwrap();
        // Structure is that of the mean extinction.
        let medium = Medium {
            density: *density,
            ..Medium::homogeneous(0.5 * self.extinction as f32, 0.5 * self.extinction as f32)
        };
        let mut knots = Vec::new();
        medium.tabulate(ray.origin, ray.direction, ray.length, &mut |knot| knots.push(knot));
        let column = density.column(ray.origin, ray.direction, &knots);
        ImageSpectrum::along(ray, steps, &grid, &medium, &column)
    }
}

/// The views whose eye is in the box.
fn inner_views() -> Vec<(EyeRay, [PixelStep; 2])> {
    views().into_iter().filter(|(ray, _)| inside(ray)[0] == 0.0).collect()
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|i| (a[i] - b[i]).abs()).fold(0.0, f64::max) / (a[0] + a[2])
}

const AIR: ExponentialDensity = ExponentialDensity {
    origin: Vec3::new(0.1, 0.3, -0.2),
    up: Vec3::new(0.36, 0.8, 0.48),
    scale_height: 0.9,
};

fn air(at: DVec3) -> f64 {
    (-(at - AIR.origin.as_dvec3()).dot(AIR.up.as_dvec3()) / f64::from(AIR.scale_height)).exp()
}

#[test]
fn exponential_air_adds_the_curvature_of_density_times_transmittance() {
    let mut changes = 0.0_f64;
    for (ray, steps) in inner_views() {
        for extinction in [0.0, 0.3, 1.5] {
            for spectrum in [[0.0; 6], [0.05, 0.02, 0.1, 0.01, -0.03, 0.02]] {
                let flux = |p: DVec3| (0.3 * p.x + 0.2 * p.z - 0.4 * p.y - 1.5).exp();
                let twin = Twin { density: &air, extinction, flux: &flux, spectrum };
                let expected = twin.walk(&ray, &steps);
                // The midpoint rule in steps of 0.1, over a scale height of 0.9 and optical depths of up to several: measured at up to 0.6 %.
                let found = twin.core(&ray, &steps, &Density::Exponential(AIR));
                assert_close(&found, expected.spectrum, expected.weight, 0.01);
                changes = changes.max(distance(expected.spectrum, expected.signed));
            }
        }
    }
    assert!(changes > 0.3, "magnitudes make no difference here: {changes}");
}

#[test]
fn smoke_in_voxels_adds_the_curvature_of_density_times_transmittance() {
    let smoke = |p: DVec3| 1.0 + 0.6 * (1.7 * p.x + 0.6 * p.y).sin() * (1.1 * p.z - 0.8 * p.y + 0.4).cos();
    let layout = GridLayout { cells: [140, 104, 176], ..LAYOUT };
    let size = (layout.max - layout.min).as_dvec3() / DVec3::from(layout.cells.map(f64::from));
    let center =
        |i: u32| DVec3::from([i % 140, i / 140 % 104, i / (140 * 104)].map(|place| f64::from(place) + 0.5));
    let values: Vec<f32> = (0..layout.cell_count() as u32)
        .map(|i| smoke(layout.min.as_dvec3() + center(i) * size) as f32)
        .collect();
    let density = Density::Grid(DensityGrid::new(layout, &values).unwrap());
    let mut changes = 0.0_f64;
    for (ray, steps) in inner_views() {
        for extinction in [0.0, 0.4, 1.5] {
            let twin = Twin { density: &smoke, extinction, flux: &|_| 1.0, spectrum: [0.0; 6] };
            let expected = twin.walk(&ray, &steps);
            // Derivatives are those of the voxel around a point, of a place up to 0.02 m away; the error falls with the voxels: 4.4 % of voxels
            // twice as large, 0.4 % of voxels two thirds as large.
            assert_close(&twin.core(&ray, &steps, &density), expected.spectrum, expected.weight, 0.02);
            changes = changes.max(distance(expected.spectrum, expected.signed));
        }
    }
    assert!(changes > 0.2, "magnitudes make no difference here: {changes}");
}

/// Where no curvature changes its sign on the way, the mean of the points' spectra is that of the picture.
#[test]
fn the_spectrum_is_that_of_the_picture_where_no_sign_changes() {
    for (ray, steps) in inner_views() {
        let twin = Twin { density: &air, extinction: 0.002, flux: &|_| 1.0, spectrum: [0.0; 6] };
        let expected = twin.walk(&ray, &steps);
        assert!(distance(expected.spectrum, expected.signed) < 1e-3);
        let found = twin.core(&ray, &steps, &Density::Exponential(AIR));
        // 2e-4 measured.
        assert_close(&found, expected.picture, expected.weight, 0.002);
    }
}

#[test]
fn a_medium_without_structure_adds_nothing() {
    let layout = GridLayout { cells: [4, 5, 6], ..LAYOUT };
    let even = vec![2.0; 120];
    for (ray, steps) in inner_views() {
        let twin = Twin { density: &|_| 2.0, extinction: 1.5, flux: &|_| 1.0, spectrum: [0.0; 6] };
        for density in [Density::Uniform, Density::Grid(DensityGrid::new(layout, &even).unwrap())] {
            let found = twin.core(&ray, &steps, &density);
            assert!(found.weight > 0.0 && [found.xx, found.xy, found.yy] == [0.0; 3], "{found:?}");
        }
    }
}

#[test]
fn densities_at_the_ends_of_what_f32_holds_give_a_finite_spectrum_or_none() {
    let layout = GridLayout { cells: [2, 2, 2], ..LAYOUT };
    let heights = [1e-30, 1e-3, 0.02, 1e3, 1e30]
        .map(|scale_height| Density::Exponential(ExponentialDensity { scale_height, ..AIR }));
    let voxels = [[0.0; 8], [3e38; 8], [1e-45; 8], [0.0, 3e38, 1e-45, 1.0, 0.0, 1e20, 1e-20, 3e38]];
    let grids = voxels.iter().map(|values| Density::Grid(DensityGrid::new(layout, values).unwrap()));
    for density in heights.into_iter().chain(grids) {
        for (ray, steps) in views() {
            for extinction in [0.0, 1e-30, 1.0, 1e30] {
                let twin = Twin {
                    density: &|_| 1.0,
                    extinction,
                    flux: &|_| 1.0,
                    spectrum: [1.0, 2.0, 3.0, 0.0, 0.0, 0.0],
                };
                let found = twin.core(&ray, &steps, &density);
                assert!(
                    (found.xx + found.xy + found.yy + found.weight).is_finite(),
                    "{found:?} in {density:?}"
                );
                assert!(found.weight > 0.0 || found == ImageSpectrum::default());
            }
        }
    }
}
