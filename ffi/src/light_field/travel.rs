//! Travel along the ray, and the frame about it.

use super::field::{covbeam_light_field, update};
use crate::check::{direction, finite, finite_not_negative, vector};
use crate::medium::options::{covbeam_medium, read_medium};
use crate::memory::{inputs, outputs};
use crate::status::{covbeam_status, run};

/// Travel through vacuum or a homogeneous medium. The frame turns to the principal axes of the light's angles,
/// where a rounding costs least.
///
/// @param count number of fields; with 0 nothing is done.
/// @param fields, field_stride the light fields, changed in place.
/// @param distances, distance_stride [m], finite; 0 changes nothing, a negative one goes back.
/// @note Thesis 5.3.1.
/// @kinds =field <f:f
/// @single covbeam_light_field_travel
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_light_fields_travel(
    count: usize,
    fields: *mut covbeam_light_field,
    field_stride: usize,
    distances: *const f32,
    distance_stride: usize,
) -> covbeam_status {
    run(|| {
        outputs!(count, fields, field_stride);
        inputs!(count, distances, distance_stride);
        update(fields, |i| finite(distances.get(i)), |_, field, distance| field.travel(distance))
    })
}

/// Travel through a medium: in a homogeneous one covbeam_light_field_travel, else with the attenuation that
/// varies across the ray.
///
/// @param count number of fields; with 0 nothing is done.
/// @param fields, field_stride the light fields, changed in place; they move along their directions.
/// @param medium what it travels in; the mean extinction of the channels counts.
/// @param origins, origin_stride where the field is [m].
/// @param distances, distance_stride [m] >= 0, finite.
/// @note Thesis 5.3.1. Costs up to 256 look-ups of the density's derivatives.
/// @kinds =field <medium <f:fff <f:q
/// @single covbeam_light_field_carry
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_light_fields_carry(
    count: usize,
    fields: *mut covbeam_light_field,
    field_stride: usize,
    medium: *const covbeam_medium,
    origins: *const f32,
    origin_stride: usize,
    distances: *const f32,
    distance_stride: usize,
) -> covbeam_status {
    run(|| {
        outputs!(count, fields, field_stride);
        // SAFETY: by the caller's promise.
        let medium = unsafe { read_medium(medium, "medium") }?;
        inputs!(count, origins: [f32; 3], origin_stride);
        inputs!(count, distances, distance_stride);
        update(
            fields,
            |i| Ok((vector(origins.get(i))?, finite_not_negative(distances.get(i))?)),
            |_, field, (origin, distance)| field.travel_through(&medium, origin, distance),
        )
    })
}

/// Turns the frame about the ray, to read covbeam_light_field_slice along given axes: every other operator may
/// turn it, so rotate right before. The light stays what it is.
///
/// @param count number of fields; with 0 nothing is done.
/// @param fields, field_stride the light fields, changed in place.
/// @param x_axes, x_axis_stride any length but 0; its part across the ray becomes the x axis; along the ray:
///     nothing changes.
/// @note Thesis 5.3.1.2.
/// @kinds =field <f:ddd
/// @single covbeam_light_field_rotate
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_light_fields_rotate(
    count: usize,
    fields: *mut covbeam_light_field,
    field_stride: usize,
    x_axes: *const f32,
    x_axis_stride: usize,
) -> covbeam_status {
    run(|| {
        outputs!(count, fields, field_stride);
        inputs!(count, x_axes: [f32; 3], x_axis_stride);
        update(fields, |i| direction(x_axes.get(i)), |_, field, x_axis| field.rotate(x_axis))
    })
}
