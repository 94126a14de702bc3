//! What the camera sees, from which importance comes.

use super::handle::{Voxels, covbeam_importance};
use crate::arrays::each;
use crate::check::{finite_not_negative, vector};
use crate::eye_ray::{covbeam_eye_ray, eye_ray};
use crate::handle::run_on;
use crate::medium::options::{covbeam_medium, read_medium};
use crate::memory::inputs;
use crate::status::covbeam_status;
use covbeam_core::EyeRay;

/// Adds pieces of eye rays: beams that cross them are seen.
///
/// @param importance what is added to.
/// @param medium what the pieces run through; the means of the channels count.
/// @param count number of pieces; with 0 nothing is done.
/// @param rays, ray_stride the pieces.
/// @param weights, weight_stride of the ray at the piece's origin, finite and >= 0. At the camera it is
///     1/(N L), for N pixels and the luminance L that this one has about: pixels count by their relative
///     errors. Where L is next to nothing, bound it.
/// @note Costs what covbeam_importance_of_segments does.
/// @kinds !importance <medium <ray <f:q
/// @extra
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_importance_add_eye_rays(
    importance: *mut covbeam_importance,
    medium: *const covbeam_medium,
    count: usize,
    rays: *const covbeam_eye_ray,
    ray_stride: usize,
    weights: *const f32,
    weight_stride: usize,
) -> covbeam_status {
    let body = |importance: &mut Voxels| {
        inputs!(count, rays, ray_stride);
        inputs!(count, weights, weight_stride);
        // SAFETY: by the caller's promise.
        let medium = unsafe { read_medium(medium, "medium") }?;
        let piece = |i: usize| Ok((eye_ray(rays.get(i))?, finite_not_negative(weights.get(i))?));
        let mut grid = importance.collecting();
        each(count, piece, |_, (EyeRay { origin, direction, length }, weight)| {
            grid.add_eye_ray(&medium, origin, direction, length, weight);
        })
    };
    // SAFETY: by the caller's promise.
    unsafe { run_on(importance, "importance", body) }
}

/// Adds segments that paths from the camera fly after they were scattered, by the medium or by a diffuse
/// surface: light that is scattered on them goes on to where the camera sees it.
///
/// @param importance what is added to.
/// @param medium what the segments run through; the means of the channels count.
/// @param count number of segments; with 0 nothing is done.
/// @param paths, path_stride the segments, away from the camera.
/// @param weights, weight_stride of the path at the segment's origin, finite and >= 0: that at the camera, times
///     what scattering has left of it, over the probability that the path goes there.
/// @note Costs what covbeam_importance_of_segments does.
/// @kinds !importance <medium <ray <f:q
/// @extra
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_importance_add_paths(
    importance: *mut covbeam_importance,
    medium: *const covbeam_medium,
    count: usize,
    paths: *const covbeam_eye_ray,
    path_stride: usize,
    weights: *const f32,
    weight_stride: usize,
) -> covbeam_status {
    let body = |importance: &mut Voxels| {
        inputs!(count, paths, path_stride);
        inputs!(count, weights, weight_stride);
        // SAFETY: by the caller's promise.
        let medium = unsafe { read_medium(medium, "medium") }?;
        let piece = |i: usize| Ok((eye_ray(paths.get(i))?, finite_not_negative(weights.get(i))?));
        let mut grid = importance.collecting();
        each(count, piece, |_, (EyeRay { origin, direction, length }, weight)| {
            grid.add_path(&medium, origin, direction, length, weight);
        })
    };
    // SAFETY: by the caller's promise.
    unsafe { run_on(importance, "importance", body) }
}

/// Adds places on diffuse surfaces that paths from the camera see. One outside the box adds nothing.
///
/// @param importance what is added to.
/// @param count number of places; with 0 nothing is done.
/// @param positions, position_stride the places [m].
/// @param weights, weight_stride of the path there times albedo/pi, finite and >= 0.
/// @kinds !importance <f:fff <f:q
/// @extra
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_importance_add_surfaces(
    importance: *mut covbeam_importance,
    count: usize,
    positions: *const f32,
    position_stride: usize,
    weights: *const f32,
    weight_stride: usize,
) -> covbeam_status {
    let body = |importance: &mut Voxels| {
        inputs!(count, positions: [f32; 3], position_stride);
        inputs!(count, weights, weight_stride);
        let place = |i: usize| Ok((vector(positions.get(i))?, finite_not_negative(weights.get(i))?));
        let mut grid = importance.collecting();
        each(count, place, |_, (position, weight)| grid.add_surface(position, weight))
    };
    // SAFETY: by the caller's promise.
    unsafe { run_on(importance, "importance", body) }
}
