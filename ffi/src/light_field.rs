//! The operators of one light field.

use crate::light_fields::*;
use crate::medium::covbeam_medium;
use crate::status::covbeam_status;
use crate::types::{covbeam_curvature, covbeam_light_field, covbeam_spectrum};

/// Angular variance of the emission of a lamp that shines evenly [cycles^2/rad^2]: its light falls off as 1/d^2, a relative curvature of
/// 2/d^2 across its rays, so that 2/(4 pi^2).
pub const COVBEAM_EVEN_LAMP: f32 = 0.050_660_59;

const _: () = assert!(COVBEAM_EVEN_LAMP == covbeam_core::EVEN_LAMP);

/// Light of an exact point source.
///
/// @param direction of propagation, normalised by the library: any length but 0.
/// @param angular_variance of the emission [cycles^2/rad^2] >= 0: COVBEAM_EVEN_LAMP for a lamp that shines
///     evenly, because of the fall-off with the square of the distance; more where its intensity changes with
///     the angle.
/// @param out the light field.
/// @note Thesis 5.3.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_light_field_point(
    direction: *const f32,
    angular_variance: f32,
    out: *mut covbeam_light_field,
) -> covbeam_status {
    // SAFETY: the caller's promises about single values are those about arrays of one.
    unsafe { covbeam_light_fields_point(1, direction, 0, &angular_variance, 0, out, 0) }
}

/// Light of a disk source, at its centre.
///
/// @param direction of propagation, normalised by the library: any length but 0.
/// @param normal of the disk, any length, either sign.
/// @param radius [m] >= 0: 0 is a point, infinity a uniform field.
/// @param angular_variance as for covbeam_light_field_point.
/// @param out the light field.
/// @note Thesis 5.3.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_light_field_disk(
    direction: *const f32,
    normal: *const f32,
    radius: f32,
    angular_variance: f32,
    out: *mut covbeam_light_field,
) -> covbeam_status {
    // SAFETY: the caller's promises about single values are those about arrays of one.
    unsafe { covbeam_light_fields_disk(1, direction, 0, normal, 0, &radius, 0, &angular_variance, 0, out, 0) }
}

/// An exactly parallel beam, such as sunlight or a laser.
///
/// @param direction of propagation, normalised by the library: any length but 0.
/// @param radius of the beam [m] >= 0: infinity for a uniform one.
/// @param out the light field.
/// @note Thesis 5.3.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_light_field_collimated(
    direction: *const f32,
    radius: f32,
    out: *mut covbeam_light_field,
) -> covbeam_status {
    // SAFETY: the caller's promises about single values are those about arrays of one.
    unsafe { covbeam_light_fields_collimated(1, direction, 0, &radius, 0, out, 0) }
}

/// A light field without correlations, from its four variances. A Gaussian of standard deviation w has 1/(4
/// pi^2 w^2).
///
/// @param direction of propagation, normalised by the library: any length but 0.
/// @param x_axis its part across the direction is the x axis of the variances; some axis if it has none.
/// @param spatial_variance along x and y [cycles^2/m^2], each >= 0: 0 is uniform, infinity a point or a line.
/// @param angular_variance along x and y [cycles^2/rad^2], each >= 0: 0 is isotropic, infinity parallel.
/// @param out the light field.
/// @note Thesis Eq 5.12.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_light_field_gaussian(
    direction: *const f32,
    x_axis: *const f32,
    spatial_variance: *const f32,
    angular_variance: *const f32,
    out: *mut covbeam_light_field,
) -> covbeam_status {
    // SAFETY: the caller's promises about single values are those about arrays of one.
    unsafe {
        covbeam_light_fields_gaussian(
            1,
            direction,
            0,
            x_axis,
            0,
            spatial_variance,
            0,
            angular_variance,
            0,
            out,
            0,
        )
    }
}

/// Travel through vacuum or a homogeneous medium.
///
/// @param field the light field, changed in place.
/// @param distance [m], finite; 0 changes nothing, a negative one goes back.
/// @note Thesis 5.3.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_light_field_travel(
    field: *mut covbeam_light_field,
    distance: f32,
) -> covbeam_status {
    // SAFETY: the caller's promises about single values are those about arrays of one.
    unsafe { covbeam_light_fields_travel(1, field, 0, &distance, 0) }
}

/// Travel through a medium: in a homogeneous one covbeam_light_field_travel, else with the attenuation that
/// varies across the ray.
///
/// @param field the light field, changed in place; it moves along its direction.
/// @param medium what it travels in; the mean extinction of the channels counts.
/// @param origin where the field is [m].
/// @param distance [m] >= 0, finite.
/// @note Thesis 5.3.1. Costs up to 256 look-ups of the density's derivatives.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_light_field_carry(
    field: *mut covbeam_light_field,
    medium: *const covbeam_medium,
    origin: *const f32,
    distance: f32,
) -> covbeam_status {
    // SAFETY: the caller's promises about single values are those about arrays of one.
    unsafe { covbeam_light_fields_carry(1, field, 0, medium, origin, 0, &distance, 0) }
}

/// Turns the frame about the ray, to read covbeam_light_field_slice along given axes. The light stays what it
/// is.
///
/// @param field the light field, changed in place.
/// @param x_axis any length but 0; its part across the ray becomes the x axis; along the ray: nothing changes.
/// @note Thesis 5.3.1.2.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_light_field_rotate(
    field: *mut covbeam_light_field,
    x_axis: *const f32,
) -> covbeam_status {
    // SAFETY: the caller's promises about single values are those about arrays of one.
    unsafe { covbeam_light_fields_rotate(1, field, 0, x_axis, 0) }
}

/// Reflection by a smooth mirror. A ray that grazes it to below 1e-12 is left as it was.
///
/// @param field the light field, changed in place.
/// @param normal at the hit, any length, either side.
/// @param curvature of the surface on the side of the normal; may be NULL: a plane.
/// @note Coddington's equations.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_light_field_reflect(
    field: *mut covbeam_light_field,
    normal: *const f32,
    curvature: *const covbeam_curvature,
) -> covbeam_status {
    // SAFETY: the caller's promises about single values are those about arrays of one.
    unsafe { covbeam_light_fields_reflect(1, field, 0, normal, 0, curvature, 0) }
}

/// Refraction through a smooth surface.
///
/// @param field the light field, changed in place.
/// @param normal at the hit, any length, either side.
/// @param curvature of the surface on the side of the normal; may be NULL: a plane.
/// @param eta refractive index on the incoming side over that on the other, > 0.
/// @param passed 1 if light passes; 0 on total reflection (and exactly grazing light), which leaves the field
///     as it was.
/// @note Coddington's equations.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_light_field_refract(
    field: *mut covbeam_light_field,
    normal: *const f32,
    curvature: *const covbeam_curvature,
    eta: f32,
    passed: *mut u8,
) -> covbeam_status {
    // SAFETY: the caller's promises about single values are those about arrays of one.
    unsafe { covbeam_light_fields_refract(1, field, 0, normal, 0, curvature, 0, &eta, 0, passed, 0) }
}

/// Occlusion by an edge beside the ray, such as a silhouette that it passes.
///
/// @param field the light field, changed in place.
/// @param towards_edge from the ray to the nearest point of the edge, any length; along the ray: nothing
///     changes.
/// @param distance between ray and edge [m] >= 0; infinity is no edge.
/// @note Thesis 5.3.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_light_field_occlude(
    field: *mut covbeam_light_field,
    towards_edge: *const f32,
    distance: f32,
) -> covbeam_status {
    // SAFETY: the caller's promises about single values are those about arrays of one.
    unsafe { covbeam_light_fields_occlude(1, field, 0, towards_edge, 0, &distance, 0) }
}

/// Attenuation by a stretch of medium whose optical depth varies across the ray. covbeam_light_field_carry does
/// this for the built-in media.
///
/// @param field the light field, changed in place.
/// @param gradient of the optical depth of the stretch, in world axes [1/m].
/// @param hessian of the same, [xx, yy, zz, xy, xz, yz] [1/m^2].
/// @note Thesis 5.3.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_light_field_attenuate(
    field: *mut covbeam_light_field,
    gradient: *const f32,
    hessian: *const f32,
) -> covbeam_status {
    // SAFETY: the caller's promises about single values are those about arrays of one.
    unsafe { covbeam_light_fields_attenuate(1, field, 0, gradient, 0, hessian, 0) }
}

/// Narrowing of the directions across one axis, such as by the soft rim of a spot light (a Gaussian rim of
/// standard deviation s has 1/(4 pi^2 s^2)).
///
/// @param field the light field, changed in place.
/// @param across in which the light falls off, any length; along the ray: nothing changes.
/// @param angular_variance [cycles^2/rad^2] >= 0: 0 changes nothing, infinity leaves one direction.
/// @note Thesis 5.3.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_light_field_narrow(
    field: *mut covbeam_light_field,
    across: *const f32,
    angular_variance: f32,
) -> covbeam_status {
    // SAFETY: the caller's promises about single values are those about arrays of one.
    unsafe { covbeam_light_fields_narrow(1, field, 0, across, 0, &angular_variance, 0) }
}

/// Scattering in a medium, or by a rough surface's lobe, into a new direction.
///
/// @param field the light field, changed in place.
/// @param direction of propagation after the event, any length but 0.
/// @param angular_variance of the lobe [cycles^2/rad^2] >= 0, see covbeam_phase_angular_variance: 0 is
///     isotropic, infinity does not blur.
/// @note Thesis 5.3.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_light_field_scatter(
    field: *mut covbeam_light_field,
    direction: *const f32,
    angular_variance: f32,
) -> covbeam_status {
    // SAFETY: the caller's promises about single values are those about arrays of one.
    unsafe { covbeam_light_fields_scatter(1, field, 0, direction, 0, &angular_variance, 0) }
}

/// Diffuse reflection or transmission into a new direction. A cosine below 1e-12 on either side leaves the
/// field as it was.
///
/// @param field the light field, changed in place.
/// @param normal of the surface, any length, either sign.
/// @param direction of propagation after the event, any length but 0.
/// @note Thesis 5.3.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_light_field_diffuse(
    field: *mut covbeam_light_field,
    normal: *const f32,
    direction: *const f32,
) -> covbeam_status {
    // SAFETY: the caller's promises about single values are those about arrays of one.
    unsafe { covbeam_light_fields_diffuse(1, field, 0, normal, 0, direction, 0) }
}

/// The spectrum of the fluence across the ray, along the frame's axes.
///
/// @param field the light field.
/// @param variances [xx, xy, yy] [cycles^2/m^2].
/// @note Thesis Eq 5.14.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_light_field_slice(
    field: *const covbeam_light_field,
    variances: *mut f32,
) -> covbeam_status {
    // SAFETY: the caller's promises about single values are those about arrays of one.
    unsafe { covbeam_light_fields_slice(1, field, 0, variances, 0) }
}

/// The spectrum of the fluence around the ray, in world axes.
///
/// @param field the light field.
/// @param limit largest deviation kept [cycles/m] > 0, such as the Nyquist frequency 1/(2h) of voxels of side
///     h; infinity keeps all.
/// @param spectrum covariance [cycles^2/m^2].
/// @note Thesis Eq 5.14.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_light_field_fluence(
    field: *const covbeam_light_field,
    limit: f32,
    spectrum: *mut covbeam_spectrum,
) -> covbeam_status {
    // SAFETY: the caller's promises about single values are those about arrays of one.
    unsafe { covbeam_light_fields_fluence(1, field, 0, &limit, 0, spectrum, 0) }
}

/// Variance of the fluence's spectrum along the ray, from how the rays spread and from extinction; for light
/// that has not been scattered.
///
/// @param field the light field.
/// @param extinction around the ray [1/m] >= 0.
/// @param variance [cycles^2/m^2] >= 0.
/// @note Derived.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_light_field_variance_along_ray(
    field: *const covbeam_light_field,
    extinction: f32,
    variance: *mut f32,
) -> covbeam_status {
    // SAFETY: the caller's promises about single values are those about arrays of one.
    unsafe { covbeam_light_fields_variance_along_ray(1, field, 0, &extinction, 0, variance, 0) }
}
