//! The spectrum of the picture around pixels, the filters that it allows, and which pixels get an eye ray in which pass.

use crate::arrays::write;
use crate::check::positive;
use crate::grid::{covbeam_grid, resolved};
use crate::handle::shared;
use crate::medium::{self, covbeam_medium};
use crate::memory::{inputs, outputs};
use crate::status::{covbeam_status, run};
use crate::types::*;
use covbeam_core::{ImageSpectrum, pixel_threshold};

/// The spectrum of the in-scattered light around a pixel, read off a grid along its eye ray: how fast the
/// picture varies there.
///
/// @param grid a grid that has been resolved.
/// @param medium what the ray is in.
/// @param ray from the eye to where the light that it gathers ends, or infinite.
/// @param steps two: how the ray changes with a pixel to the right, and with one down.
/// @param spectrum positive semi-definite up to rounding; all 0 where the grid has no data.
/// @note Surfaces that end the rays of neighbouring pixels at other distances are no part of it: see
///     covbeam_film_regions. Thesis 5.3.2, with the exact second derivatives of density x transmittance for its
///     attenuation. About 40 ns a voxel passed in a homogeneous medium, 95 ns in an exponential one, 200 ns in
///     voxels.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_image_spectrum_along(
    grid: *const covbeam_grid,
    medium: *const covbeam_medium,
    ray: *const covbeam_eye_ray,
    steps: *const covbeam_pixel_step,
    spectrum: *mut covbeam_image_spectrum,
) -> covbeam_status {
    // SAFETY: the caller's promises about single values are those about arrays of one.
    unsafe { covbeam_image_spectra_along(grid, medium, 1, ray, 0, steps, 0, spectrum, 0) }
}

/// covbeam_image_spectrum_along for `count` pixels.
///
/// @param grid as grid there.
/// @param medium as medium there.
/// @param count number of pixels; with 0 nothing is done.
/// @param rays, ray_stride as ray there.
/// @param steps, step_stride as steps there, the two of a pixel side by side; a stride of 0 gives all pixels the
///     same.
/// @param spectra, spectrum_stride as spectrum there.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_image_spectra_along(
    grid: *const covbeam_grid,
    medium: *const covbeam_medium,
    count: usize,
    rays: *const covbeam_eye_ray,
    ray_stride: usize,
    steps: *const covbeam_pixel_step,
    step_stride: usize,
    spectra: *mut covbeam_image_spectrum,
    spectrum_stride: usize,
) -> covbeam_status {
    run(|| {
        // SAFETY: by the caller's promise.
        let grid = unsafe { shared(grid, "grid") }?;
        let grid = resolved(&grid)?;
        // SAFETY: by the caller's promise.
        let medium = unsafe { medium::read(medium, "medium") }?;
        inputs!(count, rays, ray_stride);
        inputs!(count, steps: [covbeam_pixel_step; 2], step_stride);
        outputs!(count, spectra, spectrum_stride);
        let arguments = |i| {
            let both = steps.get(i);
            Ok((eye_ray(rays.get(i))?, [pixel_step(both.part(|s| s[0]))?, pixel_step(both.part(|s| s[1]))?]))
        };
        for i in 0..count {
            arguments(i)?;
        }
        let mut knots = Vec::new();
        medium::reserve_table(&medium, &mut knots)?;
        for i in 0..count {
            let (ray, steps) = arguments(i)?;
            let column = medium::tabulated(&medium, ray.origin, ray.direction, ray.length, &mut knots);
            let found = ImageSpectrum::along(&ray, &steps, &grid, &medium, &column);
            spectra.set(i, found.into());
        }
        Ok(())
    })
}

/// The reconstruction filter that blurs the picture by a relative bias: a Gaussian of covariance
/// error / (4 pi^2) x the inverse of the spectrum's, wide where the spectrum is narrow.
///
/// @param spectrum the spectrum around the pixel.
/// @param error the relative bias > 0, half of it along each principal axis.
/// @param widest largest standard deviation [pixels] > 0.
/// @param filter all 0 where the spectrum has a weight of 0.
/// @note Thesis 5.3.2, whose filter has an error of 1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_image_spectrum_filter(
    spectrum: *const covbeam_image_spectrum,
    error: f32,
    widest: f32,
    filter: *mut covbeam_image_filter,
) -> covbeam_status {
    // SAFETY: the caller's promises about single values are those about arrays of one.
    unsafe { covbeam_image_spectra_filter(1, spectrum, 0, &error, 0, &widest, 0, filter, 0) }
}

/// covbeam_image_spectrum_filter for `count` pixels.
///
/// @param count number of pixels; with 0 nothing is done.
/// @param spectra, spectrum_stride as spectrum there.
/// @param errors, error_stride as error there; a stride of 0 gives all pixels the same.
/// @param widests, widest_stride as widest there; a stride of 0 gives all pixels the same.
/// @param filters, filter_stride as filter there.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_image_spectra_filter(
    count: usize,
    spectra: *const covbeam_image_spectrum,
    spectrum_stride: usize,
    errors: *const f32,
    error_stride: usize,
    widests: *const f32,
    widest_stride: usize,
    filters: *mut covbeam_image_filter,
    filter_stride: usize,
) -> covbeam_status {
    run(|| {
        inputs!(count, spectra, spectrum_stride);
        inputs!(count, errors, error_stride);
        inputs!(count, widests, widest_stride);
        outputs!(count, filters, filter_stride);
        write(
            filters,
            |i| Ok((image_spectrum(spectra.get(i))?, positive(errors.get(i))?, positive(widests.get(i))?)),
            |(spectrum, error, widest)| spectrum.filter(error, widest).into(),
        )
    })
}

/// Eye rays that a pixel needs in a pass: two under each filter.
///
/// @param filter the pixel's filter.
/// @param density in (0, 1]; no filter gives 1.
/// @note Thesis 5.3.2.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_image_filter_density(
    filter: *const covbeam_image_filter,
    density: *mut f32,
) -> covbeam_status {
    // SAFETY: the caller's promises about single values are those about arrays of one.
    unsafe { covbeam_image_filters_density(1, filter, 0, density, 0) }
}

/// covbeam_image_filter_density for `count` pixels.
///
/// @param count number of pixels; with 0 nothing is done.
/// @param filters, filter_stride as filter there.
/// @param densities, density_stride as density there.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_image_filters_density(
    count: usize,
    filters: *const covbeam_image_filter,
    filter_stride: usize,
    densities: *mut f32,
    density_stride: usize,
) -> covbeam_status {
    run(|| {
        inputs!(count, filters, filter_stride);
        outputs!(count, densities, density_stride);
        write(densities, |i| image_filter(filters.get(i)), |filter| filter.density())
    })
}

/// A pixel's threshold in a pass: the pixel gets an eye ray if its density is above. At any density the pixels
/// chosen are spread evenly over the picture, and a pixel is chosen evenly over the passes.
///
/// @param pass any number; each chooses other pixels.
/// @param seed any number; shifts the pattern.
/// @param pixel two numbers: x to the right and y down, any.
/// @param threshold in [0, 1).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_pixel_threshold(
    pass: u32,
    seed: u32,
    pixel: *const u32,
    threshold: *mut f32,
) -> covbeam_status {
    // SAFETY: the caller's promises about single values are those about arrays of one.
    unsafe { covbeam_pixel_threshold_many(pass, seed, 1, pixel, 0, threshold, 0) }
}

/// covbeam_pixel_threshold for `count` pixels, such as those of a tile.
///
/// @param pass as pass there.
/// @param seed as seed there.
/// @param count number of pixels; with 0 nothing is done.
/// @param pixels, pixel_stride as pixel there.
/// @param thresholds, threshold_stride as threshold there.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_pixel_threshold_many(
    pass: u32,
    seed: u32,
    count: usize,
    pixels: *const u32,
    pixel_stride: usize,
    thresholds: *mut f32,
    threshold_stride: usize,
) -> covbeam_status {
    run(|| {
        inputs!(count, pixels: [u32; 2], pixel_stride);
        outputs!(count, thresholds, threshold_stride);
        write(thresholds, |i| Ok(pixels.get(i).value), |[x, y]| pixel_threshold(x, y, pass, seed))
    })
}

#[cfg(test)]
#[allow(clippy::undocumented_unsafe_blocks, reason = "every argument is a local, or refused")]
mod tests {
    use super::*;
    use crate::grid::{
        covbeam_grid_deposit_spectra, covbeam_grid_free, covbeam_grid_new, covbeam_grid_resolve,
    };
    use crate::hostile::{Rule, Rule::*, UNTOUCHED, padded, refuses, values};
    use crate::medium::samples::{fog, haze, smoke};
    use crate::status::covbeam_status::*;
    use core::ptr;

    const NO_SPECTRUM: covbeam_image_spectrum =
        covbeam_image_spectrum { xx: UNTOUCHED, xy: UNTOUCHED, yy: UNTOUCHED, weight: UNTOUCHED };
    const NO_FILTER: covbeam_image_filter =
        covbeam_image_filter { xx: UNTOUCHED, xy: UNTOUCHED, yy: UNTOUCHED };

    /// One voxel of 1 m with a variance of its own on each axis.
    fn lit() -> *mut covbeam_grid {
        let layout = covbeam_grid_layout { min: [0.0; 3], max: [1.0; 3], cells: [1; 3] };
        let spectrum = covbeam_spectrum { xx: 4.0, yy: 9.0, zz: 1.0, xy: 0.5, xz: 0.0, yz: 0.0 };
        let mut grid = ptr::null_mut();
        unsafe {
            assert_eq!(covbeam_grid_new(&layout, &mut grid), COVBEAM_OK);
            let middle = [0.5_f32; 3];
            let status = covbeam_grid_deposit_spectra(grid, 1, middle.as_ptr(), 0, &spectrum, 0, &1.0, 0);
            assert_eq!(status, COVBEAM_OK);
            assert_eq!(covbeam_grid_resolve(grid), COVBEAM_OK);
        }
        grid
    }

    /// Along z through the voxel; a pixel is 0.1 m to the right and 0.2 m down, wherever it is.
    const RAY: covbeam_eye_ray =
        covbeam_eye_ray { origin: [0.5, 0.5, -1.0], direction: [0.0, 0.0, 1.0], length: 9.0 };
    const STEPS: [covbeam_pixel_step; 2] = [
        covbeam_pixel_step { origin: [0.1, 0.0, 0.0], direction: [0.0; 3] },
        covbeam_pixel_step { origin: [0.0, 0.2, 0.0], direction: [0.0; 3] },
    ];

    #[test]
    fn a_bad_argument_is_refused_and_nothing_is_written() {
        let (grid, smoke) = (lit(), smoke());
        let step = [(0.1, Finite); 6];
        let ray: [(f32, Rule); 7] = [
            (0.5, Finite),
            (0.5, Finite),
            (-1.0, Finite),
            (0.0, Across),
            (0.0, Across),
            (1.0, Along),
            (9.0, NotNegative),
        ];
        for medium in [fog(), haze(), smoke.medium] {
            refuses(5, &[&ray[..], &step, &step].concat(), |bad, n| {
                let mut out = NO_SPECTRUM;
                let status = unsafe {
                    covbeam_image_spectrum_along(
                        bad.at(0, grid),
                        bad.at(1, &medium),
                        bad.at(2, n.as_ptr()).cast(),
                        bad.at(3, n[7..].as_ptr()).cast(),
                        bad.at_mut(4, &mut out),
                    )
                };
                (status, out != NO_SPECTRUM)
            });
        }
        let numbers = [
            (4.0, Finite),
            (0.5, Finite),
            (9.0, Finite),
            (1.0, FiniteNotNegative),
            (0.1, Positive),
            (50.0, Positive),
        ];
        refuses(2, &numbers, |bad, n| {
            let mut out = NO_FILTER;
            let spectrum = bad.at(0, n.as_ptr()).cast();
            let to = bad.at_mut(1, &mut out);
            let status = unsafe { covbeam_image_spectrum_filter(spectrum, n[4], n[5], to) };
            (status, out != NO_FILTER)
        });
        refuses(2, &[(4.0, FiniteNotNegative), (0.5, Finite), (9.0, FiniteNotNegative)], |bad, n| {
            let mut out = UNTOUCHED;
            let to = bad.at_mut(1, &mut out);
            let status = unsafe { covbeam_image_filter_density(bad.at(0, n.as_ptr()).cast(), to) };
            (status, out != UNTOUCHED)
        });
        refuses(2, &[], |bad, _| {
            let (pixel, mut out) = ([3_u32, 4], UNTOUCHED);
            let to = bad.at_mut(1, &mut out);
            let status = unsafe { covbeam_pixel_threshold(1, 2, bad.at(0, pixel.as_ptr()), to) };
            (status, out != UNTOUCHED)
        });
        unsafe { covbeam_grid_free(grid) };
    }

    #[test]
    fn the_spectrum_of_a_pixel_is_the_grids_in_pixels() {
        let grid = lit();
        let mut found = NO_SPECTRUM;
        let status = unsafe { covbeam_image_spectrum_along(grid, &fog(), &RAY, STEPS.as_ptr(), &mut found) };
        assert_eq!(status, COVBEAM_OK);
        // 4 x 0.1^2, 0.5 x 0.1 x 0.2, 9 x 0.2^2, to a few roundings.
        for (found, expected) in [(found.xx, 0.04), (found.xy, 0.01), (found.yy, 0.36)] {
            assert!((found / expected - 1.0_f32).abs() < 1e-5, "{found} for {expected}");
        }
        assert!(found.weight > 0.0);
        // An error of 1 and the covariance matrix is inverted: det = 0.0143.
        let mut filter = NO_FILTER;
        assert_eq!(unsafe { covbeam_image_spectrum_filter(&found, 1.0, 1e3, &mut filter) }, COVBEAM_OK);
        let scale = 1.0 / (4.0 * core::f32::consts::PI.powi(2) * 0.0143);
        for (found, expected) in [(filter.xx, 0.36), (filter.xy, -0.01), (filter.yy, 0.04)] {
            assert!((found / (scale * expected) - 1.0).abs() < 1e-4, "{found} for {expected}");
        }
        unsafe { covbeam_grid_free(grid) };
    }

    #[test]
    fn a_grid_that_is_not_resolved_comes_too_early() {
        let layout = covbeam_grid_layout { min: [0.0; 3], max: [1.0; 3], cells: [2; 3] };
        let (mut grid, mut out) = (ptr::null_mut(), NO_SPECTRUM);
        let statuses = unsafe {
            [
                covbeam_grid_new(&layout, &mut grid),
                covbeam_image_spectrum_along(grid, &fog(), &RAY, STEPS.as_ptr(), &mut out),
            ]
        };
        assert_eq!((statuses, out), ([COVBEAM_OK, COVBEAM_WRONG_ORDER], NO_SPECTRUM));
        unsafe { covbeam_grid_free(grid) };
    }

    #[test]
    fn many_are_the_same_bits_as_one_each() {
        let (grid, smoke) = (lit(), smoke());
        let rays = [0.3, 0.5, 0.7].map(|x| covbeam_eye_ray { origin: [x, 0.4, -1.0], ..RAY });
        let steps = [STEPS, [STEPS[1], STEPS[0]], STEPS];
        let (rays, steps) = (padded(&rays), padded(&steps));
        let mut spectra = padded(&[NO_SPECTRUM; 3]);
        let mut filters = padded(&[NO_FILTER; 3]);
        let mut densities = padded(&[UNTOUCHED; 3]);
        let pixels = padded(&[[0_u32, 0], [7, 3], [u32::MAX, 1]]);
        let mut thresholds = padded(&[UNTOUCHED; 3]);
        let statuses = unsafe {
            [
                covbeam_image_spectra_along(
                    grid,
                    &smoke.medium,
                    3,
                    &rays[0].value,
                    size_of_val(&rays[0]),
                    steps[0].value.as_ptr(),
                    size_of_val(&steps[0]),
                    &mut spectra[0].value,
                    size_of_val(&spectra[1]),
                ),
                covbeam_image_spectra_filter(
                    3,
                    &spectra[0].value,
                    size_of_val(&spectra[1]),
                    &0.1,
                    0,
                    [4.0_f32, 8.0, 0.5].as_ptr(),
                    4,
                    &mut filters[0].value,
                    size_of_val(&filters[1]),
                ),
                covbeam_image_filters_density(
                    3,
                    &filters[0].value,
                    size_of_val(&filters[1]),
                    &mut densities[0].value,
                    size_of_val(&densities[1]),
                ),
                covbeam_pixel_threshold_many(
                    5,
                    9,
                    3,
                    pixels[0].value.as_ptr(),
                    size_of_val(&pixels[0]),
                    &mut thresholds[0].value,
                    size_of_val(&thresholds[1]),
                ),
            ]
        };
        assert_eq!(statuses, [COVBEAM_OK; 4]);
        let (rays, steps, pixels) = (values(&rays), values(&steps), values(&pixels));
        for i in 0..3 {
            let (mut spectrum, mut filter) = (NO_SPECTRUM, NO_FILTER);
            let (mut density, mut threshold) = (UNTOUCHED, UNTOUCHED);
            let statuses = unsafe {
                [
                    covbeam_image_spectrum_along(
                        grid,
                        &smoke.medium,
                        &rays[i],
                        steps[i].as_ptr(),
                        &mut spectrum,
                    ),
                    covbeam_image_spectrum_filter(&spectrum, 0.1, [4.0, 8.0, 0.5][i], &mut filter),
                    covbeam_image_filter_density(&filter, &mut density),
                    covbeam_pixel_threshold(5, 9, pixels[i].as_ptr(), &mut threshold),
                ]
            };
            assert_eq!(statuses, [COVBEAM_OK; 4]);
            assert_eq!((spectrum, filter), (values(&spectra)[i], values(&filters)[i]));
            assert_eq!((density, threshold), (values(&densities)[i], values(&thresholds)[i]));
        }
        unsafe { covbeam_grid_free(grid) };
    }
}
