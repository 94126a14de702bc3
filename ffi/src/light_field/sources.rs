//! Sources: the light fields that light paths begin with.

use super::field::covbeam_light_field;
use crate::arrays::write;
use crate::check::{direction, not_negative, not_negative_each, vector};
use crate::memory::{inputs, outputs};
use crate::status::{covbeam_status, run};
use covbeam_core::LightField;

/// Angular variance of the emission of a lamp that shines evenly [cycles^2/rad^2]: its light falls off as 1/d^2, a relative curvature of
/// 2/d^2 across its rays, so that 2/(4 pi^2).
pub const COVBEAM_EVEN_LAMP: f32 = 0.050_660_59;

const _: () = assert!(COVBEAM_EVEN_LAMP == covbeam_core::EVEN_LAMP);

/// Light of an exact point source.
///
/// @param count number of fields; with 0 nothing is done.
/// @param directions, direction_stride of propagation, normalised by the library: any length but 0.
/// @param angular_variances, angular_variance_stride of the emission [cycles^2/rad^2] >= 0:
///     COVBEAM_EVEN_LAMP for a lamp that shines evenly, because of the fall-off with the square of the
///     distance; more where its intensity changes with the angle.
/// @param out, out_stride the light fields.
/// @note Thesis 5.3.1.
/// @kinds <f:ddd <f:p >field
/// @single covbeam_light_field_point
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_light_fields_point(
    count: usize,
    directions: *const f32,
    direction_stride: usize,
    angular_variances: *const f32,
    angular_variance_stride: usize,
    out: *mut covbeam_light_field,
    out_stride: usize,
) -> covbeam_status {
    run(|| {
        inputs!(count, directions: [f32; 3], direction_stride);
        inputs!(count, angular_variances, angular_variance_stride);
        outputs!(count, out, out_stride);
        write(
            out,
            |i| Ok((direction(directions.get(i))?, not_negative(angular_variances.get(i))?)),
            |(direction, angular_variance)| LightField::point(direction, angular_variance).into(),
        )
    })
}

/// Light of a disk source, at its centre.
///
/// @param count number of fields; with 0 nothing is done.
/// @param directions, direction_stride of propagation, normalised by the library: any length but 0.
/// @param normals, normal_stride of the disk, any length, either sign.
/// @param radii, radius_stride [m] >= 0: 0 is a point, infinity a uniform field.
/// @param angular_variances, angular_variance_stride as for covbeam_light_field_point.
/// @param out, out_stride the light fields.
/// @note Thesis 5.3.1.
/// @kinds <f:ddd <f:ddd <f:p <f:p >field
/// @single covbeam_light_field_disk
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_light_fields_disk(
    count: usize,
    directions: *const f32,
    direction_stride: usize,
    normals: *const f32,
    normal_stride: usize,
    radii: *const f32,
    radius_stride: usize,
    angular_variances: *const f32,
    angular_variance_stride: usize,
    out: *mut covbeam_light_field,
    out_stride: usize,
) -> covbeam_status {
    run(|| {
        inputs!(count, directions: [f32; 3], direction_stride);
        inputs!(count, normals: [f32; 3], normal_stride);
        inputs!(count, radii, radius_stride);
        inputs!(count, angular_variances, angular_variance_stride);
        outputs!(count, out, out_stride);
        write(
            out,
            |i| {
                Ok((
                    direction(directions.get(i))?,
                    direction(normals.get(i))?,
                    not_negative(radii.get(i))?,
                    not_negative(angular_variances.get(i))?,
                ))
            },
            |(direction, normal, radius, angular_variance)| {
                LightField::disk(direction, normal, radius, angular_variance).into()
            },
        )
    })
}

/// An exactly parallel beam, such as sunlight or a laser.
///
/// @param count number of fields; with 0 nothing is done.
/// @param directions, direction_stride of propagation, normalised by the library: any length but 0.
/// @param radii, radius_stride of the beam [m] >= 0: infinity for a uniform one.
/// @param out, out_stride the light fields.
/// @note Thesis 5.3.1.
/// @kinds <f:ddd <f:p >field
/// @single covbeam_light_field_collimated
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_light_fields_collimated(
    count: usize,
    directions: *const f32,
    direction_stride: usize,
    radii: *const f32,
    radius_stride: usize,
    out: *mut covbeam_light_field,
    out_stride: usize,
) -> covbeam_status {
    run(|| {
        inputs!(count, directions: [f32; 3], direction_stride);
        inputs!(count, radii, radius_stride);
        outputs!(count, out, out_stride);
        write(
            out,
            |i| Ok((direction(directions.get(i))?, not_negative(radii.get(i))?)),
            |(direction, radius)| LightField::collimated(direction, radius).into(),
        )
    })
}

/// A light field without correlations, from its four variances. A Gaussian of standard deviation w has 1/(4
/// pi^2 w^2).
///
/// @param count number of fields; with 0 nothing is done.
/// @param directions, direction_stride of propagation, normalised by the library: any length but 0.
/// @param x_axes, x_axis_stride its part across the direction is the x axis of the variances; some axis if
///     it has none.
/// @param spatial_variances, spatial_variance_stride along x and y [cycles^2/m^2], each >= 0: 0 is uniform,
///     infinity a point or a line.
/// @param angular_variances, angular_variance_stride along x and y [cycles^2/rad^2], each >= 0: 0 is
///     isotropic, infinity parallel.
/// @param out, out_stride the light fields.
/// @note Thesis Eq 5.12.
/// @kinds <f:ddd <f:fff <f:pp <f:pp >field
/// @single covbeam_light_field_gaussian
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_light_fields_gaussian(
    count: usize,
    directions: *const f32,
    direction_stride: usize,
    x_axes: *const f32,
    x_axis_stride: usize,
    spatial_variances: *const f32,
    spatial_variance_stride: usize,
    angular_variances: *const f32,
    angular_variance_stride: usize,
    out: *mut covbeam_light_field,
    out_stride: usize,
) -> covbeam_status {
    run(|| {
        inputs!(count, directions: [f32; 3], direction_stride);
        inputs!(count, x_axes: [f32; 3], x_axis_stride);
        inputs!(count, spatial_variances: [f32; 2], spatial_variance_stride);
        inputs!(count, angular_variances: [f32; 2], angular_variance_stride);
        outputs!(count, out, out_stride);
        write(
            out,
            |i| {
                Ok((
                    direction(directions.get(i))?,
                    vector(x_axes.get(i))?,
                    not_negative_each(spatial_variances.get(i))?,
                    not_negative_each(angular_variances.get(i))?,
                ))
            },
            |(direction, x_axis, spatial_variance, angular_variance)| {
                LightField::gaussian(direction, x_axis, spatial_variance, angular_variance).into()
            },
        )
    })
}
