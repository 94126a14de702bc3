//! The spectrum of the fluence that a light field makes.

use super::field::{covbeam_light_field, light_field};
use crate::arrays::write;
use crate::check::{finite_not_negative, positive_or_infinite};
use crate::memory::{inputs, outputs};
use crate::spectrum::covbeam_spectrum;
use crate::status::{covbeam_status, run};

/// The spectrum of the fluence across the ray, along the frame's axes: x_axis, and direction x x_axis. They are
/// not those of the field before an operator: covbeam_light_field_rotate chooses them, and
/// covbeam_light_field_fluence answers along the axes of the world.
///
/// @param count number of fields; with 0 nothing is done.
/// @param fields, field_stride the light fields.
/// @param variances_out, out_stride [xx, xy, yy] [cycles^2/m^2].
/// @note Thesis Eq 5.14.
/// @kinds <field >f:qfq
/// @single covbeam_light_field_slice
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_light_fields_slice(
    count: usize,
    fields: *const covbeam_light_field,
    field_stride: usize,
    variances_out: *mut f32,
    out_stride: usize,
) -> covbeam_status {
    run(|| {
        inputs!(count, fields, field_stride);
        outputs!(count, variances_out: [f32; 3], out_stride);
        write(variances_out, |i| light_field(fields.get(i)), |field| field.slice())
    })
}

/// The spectrum of the fluence around the ray, in world axes.
///
/// @param count number of fields; with 0 nothing is done.
/// @param fields, field_stride the light fields.
/// @param limits, limit_stride largest deviation kept [cycles/m] > 0, such as the Nyquist frequency 1/(2h)
///     of voxels of side h; infinity keeps all.
/// @param spectrum_out, out_stride covariance [cycles^2/m^2].
/// @note Thesis Eq 5.14.
/// @kinds <field <f:P >spectrum
/// @single covbeam_light_field_fluence
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_light_fields_fluence(
    count: usize,
    fields: *const covbeam_light_field,
    field_stride: usize,
    limits: *const f32,
    limit_stride: usize,
    spectrum_out: *mut covbeam_spectrum,
    out_stride: usize,
) -> covbeam_status {
    run(|| {
        inputs!(count, fields, field_stride);
        inputs!(count, limits, limit_stride);
        outputs!(count, spectrum_out, out_stride);
        write(
            spectrum_out,
            |i| Ok((light_field(fields.get(i))?, positive_or_infinite(limits.get(i))?)),
            |(field, limit)| field.fluence_within(limit).into(),
        )
    })
}

/// Variance of the fluence's spectrum along the ray, from how the rays spread and from extinction; for light
/// that has not been scattered.
///
/// @param count number of fields; with 0 nothing is done.
/// @param fields, field_stride the light fields.
/// @param extinctions, extinction_stride around the ray [1/m] >= 0.
/// @param variance_out, out_stride [cycles^2/m^2] >= 0.
/// @note Derived.
/// @kinds <field <f:q >f:q
/// @single covbeam_light_field_variance_along_ray
/// @extra
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_light_fields_variance_along_ray(
    count: usize,
    fields: *const covbeam_light_field,
    field_stride: usize,
    extinctions: *const f32,
    extinction_stride: usize,
    variance_out: *mut f32,
    out_stride: usize,
) -> covbeam_status {
    run(|| {
        inputs!(count, fields, field_stride);
        inputs!(count, extinctions, extinction_stride);
        outputs!(count, variance_out, out_stride);
        write(
            variance_out,
            |i| Ok((light_field(fields.get(i))?, finite_not_negative(extinctions.get(i))?)),
            |(field, extinction)| field.variance_along_ray(extinction),
        )
    })
}
