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
/// @param count number of pixels; with 0 nothing is done.
/// @param rays, ray_stride from the eye to where the light that it gathers ends, or infinite.
/// @param steps, step_stride two a pixel, side by side: how the ray changes with a pixel to the right, and with
///     one down.
/// @param spectra, spectrum_stride positive semi-definite up to rounding; all 0 where the grid has no data.
/// @note Surfaces that end the rays of neighbouring pixels at other distances are no part of it: see
///     covbeam_film_regions. Thesis 5.3.2, with the exact second derivatives of density x transmittance for
///     its attenuation. About 40 ns a voxel passed in a homogeneous medium, 95 ns in an exponential one, 200
///     ns in voxels.
/// @kinds @grid.resolved <medium <ray <steps >image
/// @single covbeam_image_spectrum_along
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
/// @param count number of pixels; with 0 nothing is done.
/// @param spectra, spectrum_stride the spectrum around the pixel.
/// @param errors, error_stride the relative bias > 0, half of it along each principal axis.
/// @param widests, widest_stride largest standard deviation [pixels] > 0.
/// @param filters, filter_stride all 0 where the spectrum has a weight of 0.
/// @note Thesis 5.3.2, whose filter has an error of 1.
/// @kinds <image <f:+ <f:+ >filter
/// @single covbeam_image_spectrum_filter
/// @extra
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
/// @param count number of pixels; with 0 nothing is done.
/// @param filters, filter_stride the pixel's filter.
/// @param densities, density_stride in (0, 1]; no filter gives 1.
/// @note Thesis 5.3.2.
/// @kinds <filter >f:l
/// @single covbeam_image_filter_density
/// @extra
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
/// @param count number of pixels; with 0 nothing is done.
/// @param pixels, pixel_stride two numbers: x to the right and y down, any.
/// @param thresholds, threshold_stride in [0, 1).
/// @kinds #any #any <f:ii >f:r
/// @single covbeam_pixel_threshold
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
    use crate::hostile::{Rule, Rule::*, UNTOUCHED, refuses};
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
                    covbeam_image_spectra_along(
                        bad.at(0, grid),
                        bad.at(1, &medium),
                        1,
                        bad.at(2, n.as_ptr()).cast(),
                        0,
                        bad.at(3, n[7..].as_ptr()).cast(),
                        0,
                        bad.at_mut(4, &mut out),
                        0,
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
            let status = unsafe { covbeam_image_spectra_filter(1, spectrum, 0, &n[4], 0, &n[5], 0, to, 0) };
            (status, out != NO_FILTER)
        });
        refuses(2, &[(4.0, FiniteNotNegative), (0.5, Finite), (9.0, FiniteNotNegative)], |bad, n| {
            let mut out = UNTOUCHED;
            let to = bad.at_mut(1, &mut out);
            let status = unsafe { covbeam_image_filters_density(1, bad.at(0, n.as_ptr()).cast(), 0, to, 0) };
            (status, out != UNTOUCHED)
        });
        refuses(2, &[], |bad, _| {
            let (pixel, mut out) = ([3_u32, 4], UNTOUCHED);
            let to = bad.at_mut(1, &mut out);
            let status =
                unsafe { covbeam_pixel_threshold_many(1, 2, 1, bad.at(0, pixel.as_ptr()), 0, to, 0) };
            (status, out != UNTOUCHED)
        });
        unsafe { covbeam_grid_free(grid) };
    }

    #[test]
    fn the_spectrum_of_a_pixel_is_the_grids_in_pixels() {
        let grid = lit();
        let mut found = NO_SPECTRUM;
        let status = unsafe {
            covbeam_image_spectra_along(grid, &fog(), 1, &RAY, 0, STEPS.as_ptr(), 0, &mut found, 0)
        };
        assert_eq!(status, COVBEAM_OK);
        // 4 x 0.1^2, 0.5 x 0.1 x 0.2, 9 x 0.2^2, to a few roundings.
        for (found, expected) in [(found.xx, 0.04), (found.xy, 0.01), (found.yy, 0.36)] {
            assert!((found / expected - 1.0_f32).abs() < 1e-5, "{found} for {expected}");
        }
        assert!(found.weight > 0.0);
        // An error of 1 and the covariance matrix is inverted: det = 0.0143.
        let mut filter = NO_FILTER;
        assert_eq!(
            unsafe { covbeam_image_spectra_filter(1, &found, 0, &1.0, 0, &1e3, 0, &mut filter, 0) },
            COVBEAM_OK
        );
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
                covbeam_image_spectra_along(grid, &fog(), 1, &RAY, 0, STEPS.as_ptr(), 0, &mut out, 0),
            ]
        };
        assert_eq!((statuses, out), ([COVBEAM_OK, COVBEAM_WRONG_ORDER], NO_SPECTRUM));
        unsafe { covbeam_grid_free(grid) };
    }
}
