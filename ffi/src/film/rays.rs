//! Eye rays: what they saw.

use super::handle::covbeam_film;
use super::plan::not_planned;
use super::state::{Film, Seen};
use crate::check::finite_not_negative;
use crate::handle::run_on;
use crate::memory::{Element, Inputs, field, inputs};
use crate::status::{Failure, covbeam_status};
use covbeam_core::FilmLattice;
use glam::Vec3;

/// What one eye ray saw of what it was asked for.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct covbeam_film_ray {
    /// x to the right and y down.
    pub pixel: [u32; 2],
    /// 1 if it was asked for the fog before the first surface, whose light is filtered; else 0.
    pub has_volume: u32,
    /// 1 if it was asked for what lies beyond, which the pixel keeps to itself; else 0.
    pub has_rest: u32,
    /// The fog's radiance, per channel, finite and not negative [W/(m^2 sr)].
    pub volume: [f32; 3],
    /// That of the rest.
    pub rest: [f32; 3],
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
