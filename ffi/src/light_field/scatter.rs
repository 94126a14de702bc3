//! Scattering: by media, by lobes, by diffuse surfaces.

use super::field::{covbeam_light_field, update};
use crate::check::{direction, not_negative};
use crate::memory::{inputs, outputs};
use crate::status::{covbeam_status, run};

/// Scattering in a medium, or by a rough surface's lobe, into a new direction.
///
/// @param count number of fields; with 0 nothing is done.
/// @param fields, field_stride the light fields, changed in place.
/// @param directions, direction_stride of propagation after the event, any length but 0.
/// @param angular_variances, angular_variance_stride of the lobe [cycles^2/rad^2] >= 0, see
///     covbeam_phase_angular_variance: 0 is isotropic, infinity does not blur.
/// @note Thesis 5.3.1.
/// @kinds =field <f:ddd <f:p
/// @single covbeam_light_field_scatter
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_light_fields_scatter(
    count: usize,
    fields: *mut covbeam_light_field,
    field_stride: usize,
    directions: *const f32,
    direction_stride: usize,
    angular_variances: *const f32,
    angular_variance_stride: usize,
) -> covbeam_status {
    run(|| {
        outputs!(count, fields, field_stride);
        inputs!(count, directions: [f32; 3], direction_stride);
        inputs!(count, angular_variances, angular_variance_stride);
        update(
            fields,
            |i| Ok((direction(directions.get(i))?, not_negative(angular_variances.get(i))?)),
            |_, field, (direction, angular_variance)| field.scatter(direction, angular_variance),
        )
    })
}

/// Diffuse reflection or transmission into a new direction. A cosine below 1e-12 on either side leaves the
/// field as it was.
///
/// @param count number of fields; with 0 nothing is done.
/// @param fields, field_stride the light fields, changed in place.
/// @param normals, normal_stride of the surface, any length, either sign.
/// @param directions, direction_stride of propagation after the event, any length but 0.
/// @note Thesis 5.3.1.
/// @kinds =field <f:ddd <f:ddd
/// @single covbeam_light_field_diffuse
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_light_fields_diffuse(
    count: usize,
    fields: *mut covbeam_light_field,
    field_stride: usize,
    normals: *const f32,
    normal_stride: usize,
    directions: *const f32,
    direction_stride: usize,
) -> covbeam_status {
    run(|| {
        outputs!(count, fields, field_stride);
        inputs!(count, normals: [f32; 3], normal_stride);
        inputs!(count, directions: [f32; 3], direction_stride);
        update(
            fields,
            |i| Ok((direction(normals.get(i))?, direction(directions.get(i))?)),
            |_, field, (normal, direction)| field.diffuse(normal, direction),
        )
    })
}
