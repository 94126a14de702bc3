//! A picture from few eye rays: its regions, where it needs eye rays, what they saw, and each pixel through
//! its filter.
//!
//! The sums are the handle's own memory: blocks of them are summed once and then read by all threads, and
//! must not change in between.

use crate::check::{finite_not_negative, positive};
use crate::handle::{Opaque, free, handle_to, run_on, shared};
use crate::heap::reserved;
use crate::memory::{Element, Inputs, Slot, field, inputs, outputs};
use crate::picture::{Film, Seen};
use crate::status::{Failure, covbeam_poll, covbeam_status, covbeam_status::*, fail, go_on, run};
use crate::types::*;
use core::ffi::c_void;
use covbeam_core::{FILM_TILE, FilmLattice, RegionNode, film_regions, part_regions, standard_errors};
use glam::Vec3;

/// Most pixels across or down, and in all.
const MOST_ACROSS: u32 = 1 << 16;
const MOST: u64 = 1 << 31;

/// Number of pixels of a picture that is not too large.
fn pixel_count(width: u32, height: u32) -> Result<usize, Failure> {
    for (name, value) in [("width", width), ("height", height)] {
        if !(1..=MOST_ACROSS).contains(&value) {
            return Err(Element::single(value, name).is(format_args!("{value} is not in 1 to {MOST_ACROSS}")));
        }
    }
    let count = u64::from(width) * u64::from(height);
    if count > MOST {
        let message = format_args!("{width} x {height} pixels are more than {MOST}");
        return Err(Element::single(width, "width").is(message));
    }
    Ok(count as usize)
}

/// Whether arrays have an element a pixel.
fn whole(count: usize, width: u32, height: u32) -> Result<(), Failure> {
    let pixels = pixel_count(width, height)?;
    as_many(count, pixels, format_args!("{width} x {height} pixels"))
}

fn as_many(count: usize, wanted: usize, what: core::fmt::Arguments) -> Result<(), Failure> {
    if count == wanted {
        Ok(())
    } else {
        Err(fail(COVBEAM_SHORT_BUFFER, format_args!("count: {count}, but {what} want {wanted}")))
    }
}

/// Splits a picture into regions in which the depth of the first surface is continuous: filters do not reach
/// from one into another.
///
/// @param width, height of the picture, each 1 to 65536; at most 2^31 pixels.
/// @param count width x height.
/// @param depths, depth_stride of the first surface seen through the middle of each pixel [m], row by row from
///     the upper left, measured along the viewing axis and not along the ray. Infinity where there is none; NaN,
///     0 or less makes the pixel a border.
/// @param labels, label_stride receive each pixel's region: the number of its first pixel, from 1 on; 0 for a
///     pixel at a border, which filters leave alone, because its own light may come from both sides.
/// @note Two neighbours are apart where neither surface, continued as a plane, comes within 1 % of the other in
///     inverse depth: floors seen at a grazing angle are no edges. A region that lies on both sides of a silhouette
///     is taken apart where its surface bends most: a pillar from the floor that it stands on, which goes on
///     behind its top. Needs 24 bytes a pixel for the call.
/// @kinds #extent #extent <f:* >f:i
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_film_regions(
    width: u32,
    height: u32,
    count: usize,
    depths: *const f32,
    depth_stride: usize,
    labels: *mut u32,
    label_stride: usize,
) -> covbeam_status {
    run(|| {
        whole(count, width, height)?;
        inputs!(count, depths, depth_stride);
        outputs!(count, labels, label_stride);
        let mut depth = reserved(count)?;
        depth.extend((0..count).map(|i| depths.get(i).value));
        let mut found = reserved(count)?;
        found.resize(count, 0);
        film_regions(width, height, &depth, &mut found).expect("as many of both as pixels");
        let mut nodes = reserved(count)?;
        nodes.resize(count, RegionNode::default());
        part_regions(width, height, &depth, &mut found, &mut nodes).expect("as many of both as pixels");
        for (i, label) in found.into_iter().enumerate() {
            labels.set(i, label);
        }
        Ok(())
    })
}

/// Few eye rays for a picture whose light is smooth: where they are needed, what they saw, and the picture from
/// them. A pass:
///
/// covbeam_film_plan from spectra at some pixels; covbeam_film_density, and an eye ray through each pixel whose
/// covbeam_pixel_threshold is below its density; covbeam_film_add what they saw. When a picture is wanted,
/// covbeam_film_verify, then covbeam_film_picture, by several threads at once. About 60 bytes a pixel, 40 more with light
/// from beyond the fog, and 35 or 70 once verified.
pub struct covbeam_film(());

impl Opaque for covbeam_film {
    type Object = Film;
    const TAG: u64 = u64::from_le_bytes(*b"cb-film-");
    const NAME: &'static str = "covbeam_film";
}

/// Makes the film of a picture, without rays so far.
///
/// @param width, height of the picture, each 1 to 65536; at most 2^31 pixels.
/// @param typical_radiance of the picture, give or take a factor of a thousand [W/(m^2 sr)] > 0: light is added up in whole
///     multiples of 2^-32 of it, so that the order of passes and rays does not count; sums stop at 2^31 times it.
/// @param count width x height.
/// @param regions, region_stride of covbeam_film_regions, copied: filters do not reach from one into another, and
///     leave pixels with 0 alone. NULL is one region everywhere.
/// @param out the handle.
/// @kinds #extent #extent $+ <f:i? +picture
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_film_new(
    width: u32,
    height: u32,
    typical_radiance: f32,
    count: usize,
    regions: *const u32,
    region_stride: usize,
    out: *mut *mut covbeam_film,
) -> covbeam_status {
    run(|| {
        whole(count, width, height)?;
        let typical = positive(Element::single(typical_radiance, "typical_radiance"))?;
        let one = 1;
        let (regions, region_stride) =
            if regions.is_null() { (&raw const one, 0) } else { (regions, region_stride) };
        inputs!(count, regions, region_stride);
        let out = Slot::new(out, "out")?;
        let mut labels = reserved(count)?;
        labels.extend((0..count).map(|i| regions.get(i).value));
        let lattice = FilmLattice::new(width, height).expect("checked above");
        out.set(handle_to(Film::new(lattice, typical, labels)?)?);
        Ok(())
    })
}

/// Frees a film.
///
/// @param film NULL is fine.
/// @kinds !picture
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_film_free(film: *mut covbeam_film) -> covbeam_status {
    // SAFETY: by the caller's promise.
    unsafe { free(film, "film") }
}

/// How much memory a film holds.
///
/// @param film the film.
/// @param bytes receives it.
/// @kinds @picture >size
/// @extra
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_film_get_memory(
    film: *const covbeam_film,
    bytes: *mut usize,
) -> covbeam_status {
    run(|| {
        let bytes = Slot::new(bytes, "bytes")?;
        // SAFETY: by the caller's promise.
        bytes.set(unsafe { shared(film, "film") }?.memory());
        Ok(())
    })
}

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

fn not_planned() -> Failure {
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
        whole(count, film.lattice().width, film.lattice().height)?;
        outputs!(count, densities, density_stride);
        let density = film.density().ok_or_else(not_planned)?;
        for (i, density) in density.iter().enumerate() {
            densities.set(i, *density);
        }
        Ok(())
    })
}

/// Adds the pass that is planned: what its eye rays saw.
///
/// @param film a film with a plan whose pass has not been added.
/// @param count number of rays, in any order, any number of them through a pixel; 0 is a pass that saw nothing.
/// @param rays, ray_stride all of the pass.
/// @note 20 ns a ray and 2 ns a pixel.
/// @kinds !picture.resolved <seen
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_film_add(
    film: *mut covbeam_film,
    count: usize,
    rays: *const covbeam_film_ray,
    ray_stride: usize,
) -> covbeam_status {
    let add = |film: &mut Film| {
        inputs!(count, rays, ray_stride);
        film.density().ok_or_else(not_planned)?;
        let FilmLattice { width, height, .. } = *film.lattice();
        let mut beyond = false;
        for i in 0..count {
            beyond |= film_ray(&rays, i, [width, height])?.rest.is_some();
        }
        if beyond {
            film.want_rest()?;
        }
        film.add((0..count).map(|i| film_ray(&rays, i, [width, height]).expect("checked above")));
        Ok(())
    };
    // SAFETY: by the caller's promise.
    unsafe { run_on(film, "film", add) }
}

fn film_ray(rays: &Inputs<covbeam_film_ray>, i: usize, [width, height]: [u32; 2]) -> Result<Seen, Failure> {
    let ray = rays.get(i);
    let [x, y] = ray.value.pixel;
    if x >= width || y >= height {
        return Err(
            field!(ray, pixel).is(format_args!("({x}, {y}) is outside of the picture, {width} x {height}"))
        );
    }
    let seen = |has: Element<u32>, light: Element<[f32; 3]>| {
        for value in light.value {
            finite_not_negative(light.part(|_| value))?;
        }
        match has.value {
            0 => Ok(None),
            1 => Ok(Some(Vec3::from_array(light.value))),
            other => Err(has.is(format_args!("{other} is neither 0 nor 1"))),
        }
    };
    let pixel = y as usize * width as usize + x as usize;
    Ok(Seen {
        pixel,
        volume: seen(field!(ray, has_volume), field!(ray, volume))?,
        rest: seen(field!(ray, has_rest), field!(ray, rest))?,
    })
}

/// Makes a film ready for covbeam_film_picture: where a filter of the latest pass disagrees with narrower ones by more
/// than the noise of the two halves of the passes, it is narrowed. Stopped, the film is as before.
///
/// @param film the film.
/// @param poll may be NULL; asked at least every few milliseconds, in a picture of a million pixels. Not 0 ends the call with
///     COVBEAM_CANCELLED.
/// @param user given to poll.
/// @note After O. V. Lepski (1991): the widest filter that agrees with all narrower ones. 50 ms, and 30 ns a pixel.
/// @kinds !picture
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_film_verify(
    film: *mut covbeam_film,
    poll: covbeam_poll,
    user: *mut c_void,
) -> covbeam_status {
    // SAFETY: by the caller's promise.
    unsafe { run_on(film, "film", |film: &mut Film| film.verify(&mut go_on(poll, user))) }
}

/// Some rows of the picture. Threads may share the work, each with rows of its own.
///
/// @param film a film that has been verified since the latest pass was added.
/// @param first_row a multiple of 8.
/// @param count width x number of rows, which is a multiple of 8 or reaches the last row.
/// @param pixels, pixel_stride receive the rows; 0 in a picture without rays.
/// @note 0.2 us a pixel where filters are wide, up to 3 us where they are not.
/// @kinds @picture.committed #row >shown
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_film_picture(
    film: *const covbeam_film,
    first_row: u32,
    count: usize,
    pixels: *mut covbeam_film_pixel,
    pixel_stride: usize,
) -> covbeam_status {
    run(|| {
        // SAFETY: by the caller's promise.
        let film = unsafe { shared(film, "film") }?;
        let FilmLattice { width, height, .. } = *film.lattice();
        if first_row >= height || !first_row.is_multiple_of(FILM_TILE) {
            let row = Element::single(first_row, "first_row");
            return Err(row.is(format_args!("{first_row} is no multiple of {FILM_TILE} below {height}")));
        }
        let (columns, left) = (width as usize, (height - first_row) as usize);
        let rows = count / columns;
        let whole = count.is_multiple_of(columns)
            && (rows == left || (rows < left && rows.is_multiple_of(FILM_TILE as usize)));
        if !whole {
            let message = format_args!(
                "count: {count} is not {width} x a multiple of {FILM_TILE}, or the {left} rows left"
            );
            return Err(fail(COVBEAM_SHORT_BUFFER, message));
        }
        outputs!(count, pixels, pixel_stride);
        if !film.is_verified() {
            let message =
                format_args!("film: not verified since a pass was added; call covbeam_film_verify first");
            return Err(fail(COVBEAM_WRONG_ORDER, message));
        }
        let before = first_row as usize * columns;
        film.rows(first_row..first_row + rows as u32, |index, pixel, volume| {
            pixels.set(index - before, film_pixel(pixel, volume));
        });
        Ok(())
    })
}

/// Standard errors of a picture, from the two halves of its passes: squared differences averaged over 5x5 pixels, and what
/// is known of the filtered light.
///
/// @param width, height of the picture, or of a part of it that threads share: then rows at least 2 away from the
///     part's ends have the errors that they have in the whole.
/// @param count width x height.
/// @param pixels, pixel_stride of covbeam_film_picture.
/// @param errors, error_stride receive the standard error of each pixel's luminance (Rec. 709) [W/(m^2 sr)].
/// @note 40 ns and 20 bytes a pixel for the call.
/// @kinds #extent #extent <pixel >f:q
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_film_errors(
    width: u32,
    height: u32,
    count: usize,
    pixels: *const covbeam_film_pixel,
    pixel_stride: usize,
    errors: *mut f32,
    error_stride: usize,
) -> covbeam_status {
    run(|| {
        whole(count, width, height)?;
        inputs!(count, pixels, pixel_stride);
        outputs!(count, errors, error_stride);
        let (mut given, mut found) = (reserved(count)?, reserved(count)?);
        for i in 0..count {
            given.push(film_pixel_of(pixels.get(i))?);
        }
        found.resize(count, 0.0);
        standard_errors(width, height, &given, 0, &mut found).expect("as many of both as pixels");
        for (i, error) in found.into_iter().enumerate() {
            errors.set(i, error);
        }
        Ok(())
    })
}

#[cfg(test)]
#[path = "film_tests.rs"]
mod tests;
