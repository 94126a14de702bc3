//! The plan of a pass: filters, and where eye rays are needed.

use super::handle::covbeam_film;
use super::size::{as_many, one_a_pixel};
use super::state::Film;
use crate::check::positive;
use crate::handle::{run_on, shared};
use crate::heap::reserved;
use crate::image::spectrum::{covbeam_image_spectrum, image_spectrum};
use crate::memory::{Element, Slot, inputs, outputs};
use crate::status::{Failure, covbeam_poll, covbeam_status, covbeam_status::*, fail, go_on, run};
use core::ffi::c_void;

/// At how many pixels the spectrum of the picture is wanted: about 43 x 43, whatever the picture's size.
///
/// @param film the film.
/// @param count receives their number.
/// @kinds @picture >size
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_film_get_node_count(
    film: *const covbeam_film,
    count: *mut usize,
) -> covbeam_status {
    run(|| {
        let count = Slot::new(count, "count")?;
        // SAFETY: by the caller's promise.
        count.set(unsafe { shared(film, "film") }?.lattice().node_count());
        Ok(())
    })
}

/// At which pixels the spectrum of the picture is wanted.
///
/// @param film the film.
/// @param count as many as covbeam_film_get_node_count says.
/// @param pixels, pixel_stride receive two numbers each: x to the right and y down.
/// @kinds @picture >f:ii
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_film_nodes(
    film: *const covbeam_film,
    count: usize,
    pixels: *mut u32,
    pixel_stride: usize,
) -> covbeam_status {
    run(|| {
        // SAFETY: by the caller's promise.
        let film = unsafe { shared(film, "film") }?;
        let lattice = film.lattice();
        as_many(count, lattice.node_count(), format_args!("the nodes of the film"))?;
        outputs!(count, pixels: [u32; 2], pixel_stride);
        for i in 0..count {
            pixels.set(i, lattice.pixel(i));
        }
        Ok(())
    })
}

/// Plans a pass: as wide filters as the spectra allow, none of which reaches where a narrower one is asked for; and two
/// eye rays under each. In place of the plan before, if that has not been added. Stopped, that stays.
///
/// @param film the film.
/// @param pass its number. The passes with odd numbers are one half of all, the others are the other: what they differ by
///     tells the error, so a picture needs as many of both.
/// @param error relative bias > 0 that a filter may cause, as covbeam_image_spectrum_filter takes it: of a
///     covbeam_kernel.
/// @param light_paths of the pass: it gets at least half as many eye rays.
/// @param count as many as covbeam_film_get_node_count says.
/// @param spectra, spectrum_stride of covbeam_image_spectra_along the eye rays through the middles of the pixels of
///     covbeam_film_nodes; all 0 where there is no fog: such pixels have no filter, and a ray in each pass.
/// @param poll may be NULL; asked at least every few milliseconds. Not 0 ends the call with COVBEAM_CANCELLED.
/// @param user given to poll.
/// @note Thesis 5.3.2. 1 us a node and 30 ns a pixel.
/// @kinds !picture #any $+ #any <image
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_film_plan(
    film: *mut covbeam_film,
    pass: u32,
    error: f32,
    light_paths: u32,
    count: usize,
    spectra: *const covbeam_image_spectrum,
    spectrum_stride: usize,
    poll: covbeam_poll,
    user: *mut c_void,
) -> covbeam_status {
    let plan = |film: &mut Film| {
        as_many(count, film.lattice().node_count(), format_args!("the nodes of the film"))?;
        let error = positive(Element::single(error, "error"))?;
        inputs!(count, spectra, spectrum_stride);
        let mut given = reserved(count)?;
        for i in 0..count {
            given.push(image_spectrum(spectra.get(i))?);
        }
        film.plan(pass, error, light_paths, &given, &mut go_on(poll, user))
    };
    // SAFETY: by the caller's promise.
    unsafe { run_on(film, "film", plan) }
}

pub(super) fn not_planned() -> Failure {
    fail(COVBEAM_WRONG_ORDER, format_args!("film: no pass is planned; call covbeam_film_plan first"))
}

/// Eye rays that pixels get in the pass that is planned.
///
/// @param film a film with a plan whose pass has not been added.
/// @param count width x height.
/// @param densities, density_stride receive numbers in (0, 1].
/// @kinds @picture.resolved >f:l
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_film_density(
    film: *const covbeam_film,
    count: usize,
    densities: *mut f32,
    density_stride: usize,
) -> covbeam_status {
    run(|| {
        // SAFETY: by the caller's promise.
        let film = unsafe { shared(film, "film") }?;
        one_a_pixel(count, film.lattice().width, film.lattice().height)?;
        outputs!(count, densities, density_stride);
        let density = film.density().ok_or_else(not_planned)?;
        for (i, density) in density.iter().enumerate() {
            densities.set(i, *density);
        }
        Ok(())
    })
}
