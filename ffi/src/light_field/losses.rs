//! Losses that vary across the ray: by edges, by media, by the rims of lamps.

use super::field::{covbeam_light_field, update};
use crate::check::{direction, finite_each, not_negative, vector};
use crate::memory::{inputs, outputs};
use crate::status::{covbeam_status, run};

/// Occlusion by an edge beside the ray, such as a silhouette that it passes. Across the edge 1/(2 pi distance)^2
/// [cycles^2/m^2] is added to the variance of the positions, as if a Gaussian as wide as the distance masked
/// them. The field must be where the ray passes the edge: travel there first, and make one call an edge.
/// (covbeam_segment_field_at and covbeam_grid_deposit do both for the edges of a segment.)
///
/// @param count number of fields; with 0 nothing is done.
/// @param fields, field_stride the light fields, changed in place.
/// @param towards_edges, towards_edge_stride from the ray to the nearest point of the edge, any length;
///     along the ray: nothing changes.
/// @param distances, distance_stride between ray and edge [m] >= 0; infinity is no edge.
/// @note Thesis 5.3.1.
/// @kinds =field <f:ddd <f:p
/// @single covbeam_light_field_occlude
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_light_fields_occlude(
    count: usize,
    fields: *mut covbeam_light_field,
    field_stride: usize,
    towards_edges: *const f32,
    towards_edge_stride: usize,
    distances: *const f32,
    distance_stride: usize,
) -> covbeam_status {
    run(|| {
        outputs!(count, fields, field_stride);
        inputs!(count, towards_edges: [f32; 3], towards_edge_stride);
        inputs!(count, distances, distance_stride);
        update(
            fields,
            |i| Ok((direction(towards_edges.get(i))?, not_negative(distances.get(i))?)),
            |_, field, (towards_edge, distance)| field.occlude(towards_edge, distance),
        )
    })
}

/// Attenuation by a stretch of medium whose optical depth varies across the ray. covbeam_light_field_carry does
/// this for the built-in media.
///
/// @param count number of fields; with 0 nothing is done.
/// @param fields, field_stride the light fields, changed in place.
/// @param gradients, gradient_stride of the optical depth of the stretch, in world axes [1/m].
/// @param hessians, hessian_stride of the same, [xx, yy, zz, xy, xz, yz] [1/m^2].
/// @note Thesis 5.3.1.
/// @kinds =field <f:fff <f:ffffff
/// @single covbeam_light_field_attenuate
/// @extra
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_light_fields_attenuate(
    count: usize,
    fields: *mut covbeam_light_field,
    field_stride: usize,
    gradients: *const f32,
    gradient_stride: usize,
    hessians: *const f32,
    hessian_stride: usize,
) -> covbeam_status {
    run(|| {
        outputs!(count, fields, field_stride);
        inputs!(count, gradients: [f32; 3], gradient_stride);
        inputs!(count, hessians: [f32; 6], hessian_stride);
        update(
            fields,
            |i| Ok((vector(gradients.get(i))?, finite_each(hessians.get(i))?)),
            |_, field, (gradient, hessian)| field.attenuate(gradient, &hessian),
        )
    })
}

/// Narrowing of the directions across one axis, such as by the soft rim of a spot light (a Gaussian rim of
/// standard deviation s has 1/(4 pi^2 s^2)).
///
/// @param count number of fields; with 0 nothing is done.
/// @param fields, field_stride the light fields, changed in place.
/// @param acrosses, across_stride in which the light falls off, any length; along the ray: nothing changes.
/// @param angular_variances, angular_variance_stride [cycles^2/rad^2] >= 0: 0 changes nothing, infinity
///     leaves one direction.
/// @note Thesis 5.3.1.
/// @kinds =field <f:ddd <f:p
/// @single covbeam_light_field_narrow
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_light_fields_narrow(
    count: usize,
    fields: *mut covbeam_light_field,
    field_stride: usize,
    acrosses: *const f32,
    across_stride: usize,
    angular_variances: *const f32,
    angular_variance_stride: usize,
) -> covbeam_status {
    run(|| {
        outputs!(count, fields, field_stride);
        inputs!(count, acrosses: [f32; 3], across_stride);
        inputs!(count, angular_variances, angular_variance_stride);
        update(
            fields,
            |i| Ok((direction(acrosses.get(i))?, not_negative(angular_variances.get(i))?)),
            |_, field, (across, angular_variance)| field.narrow(across, angular_variance),
        )
    })
}
