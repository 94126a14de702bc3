//! The spectrum of the picture around pixels.

use crate::check::{finite, finite_not_negative, vector};
use crate::eye_ray::{covbeam_eye_ray, eye_ray};
use crate::grid::handle::covbeam_grid;
use crate::grid::look_up::resolved;
use crate::handle::shared;
use crate::medium::options::{covbeam_medium, read_medium, reserve_table, tabulated};
use crate::memory::{Element, field, inputs, outputs};
use crate::status::{Failure, covbeam_status, run};
use covbeam_core::{ImageSpectrum, PixelStep};

/// How much an eye ray changes from one pixel to the next.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct covbeam_pixel_step {
    /// Of its origin [m/pixel]: 0 for a pinhole.
    pub origin: [f32; 3],
    /// Of its unit direction [1/pixel]: 0 for an orthographic camera. Only what is across the ray counts.
    pub direction: [f32; 3],
}

fn pixel_step(e: Element<covbeam_pixel_step>) -> Result<PixelStep, Failure> {
    Ok(PixelStep { origin: vector(field!(e, origin))?, direction: vector(field!(e, direction))? })
}

/// Covariance of the spectrum of the in-scattered light around a pixel, in the plane of the picture
/// [cycles^2/pixel^2]: x to the right, y down.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct covbeam_image_spectrum {
    /// Variance across.
    pub xx: f32,
    /// Covariance of across and down.
    pub xy: f32,
    /// Variance down.
    pub yy: f32,
    /// In-scattered light on the way, in the grid's relative unit; 0 = the grid has no data, and the other
    /// numbers are 0.
    pub weight: f32,
}

impl From<ImageSpectrum> for covbeam_image_spectrum {
    fn from(ImageSpectrum { xx, xy, yy, weight }: ImageSpectrum) -> Self {
        Self { xx, xy, yy, weight }
    }
}

pub(crate) fn image_spectrum(e: Element<covbeam_image_spectrum>) -> Result<ImageSpectrum, Failure> {
    let covbeam_image_spectrum { xx, xy, yy, weight } = e.value;
    for variance in [field!(e, xx), field!(e, xy), field!(e, yy)] {
        finite(variance)?;
    }
    finite_not_negative(field!(e, weight))?;
    Ok(ImageSpectrum { xx, xy, yy, weight })
}

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
        let medium = unsafe { read_medium(medium, "medium") }?;
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
        reserve_table(&medium, &mut knots)?;
        for i in 0..count {
            let (ray, steps) = arguments(i)?;
            let column = tabulated(&medium, ray.origin, ray.direction, ray.length, &mut knots);
            let found = ImageSpectrum::along(&ray, &steps, &grid, &medium, &column);
            spectra.set(i, found.into());
        }
        Ok(())
    })
}
