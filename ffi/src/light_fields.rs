//! The operators on strided arrays of light fields. One field is an array of one (`light_field.rs`): the checks and the
//! calls of the core stand here, once.

use crate::arrays::{update, write};
use crate::check::{
    direction, finite, finite_each, finite_not_negative, not_negative, not_negative_each, positive,
    positive_or_infinite, vector,
};
use crate::medium::{self, covbeam_medium};
use crate::memory::{Inputs, Outputs, inputs, outputs};
use crate::status::{covbeam_status, run};
use crate::types::{covbeam_curvature, covbeam_light_field, covbeam_spectrum, curvature, light_field};
use core::ptr;
use covbeam_core::LightField;

/// covbeam_light_field_point for `count` light fields.
///
/// @param count number of fields; with 0 nothing is done.
/// @param directions, direction_stride as direction there; a stride of 0 gives all fields the same.
/// @param angular_variances, angular_variance_stride as angular_variance there; a stride of 0 gives all fields
///     the same.
/// @param out, out_stride the light fields.
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

/// covbeam_light_field_disk for `count` light fields.
///
/// @param count number of fields; with 0 nothing is done.
/// @param directions, direction_stride as direction there; a stride of 0 gives all fields the same.
/// @param normals, normal_stride as normal there; a stride of 0 gives all fields the same.
/// @param radii, radius_stride as radius there; a stride of 0 gives all fields the same.
/// @param angular_variances, angular_variance_stride as angular_variance there; a stride of 0 gives all fields
///     the same.
/// @param out, out_stride the light fields.
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

/// covbeam_light_field_collimated for `count` light fields.
///
/// @param count number of fields; with 0 nothing is done.
/// @param directions, direction_stride as direction there; a stride of 0 gives all fields the same.
/// @param radii, radius_stride as radius there; a stride of 0 gives all fields the same.
/// @param out, out_stride the light fields.
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

/// covbeam_light_field_gaussian for `count` light fields.
///
/// @param count number of fields; with 0 nothing is done.
/// @param directions, direction_stride as direction there; a stride of 0 gives all fields the same.
/// @param x_axes, x_axis_stride as x_axis there; a stride of 0 gives all fields the same.
/// @param spatial_variances, spatial_variance_stride as spatial_variance there; a stride of 0 gives all fields
///     the same.
/// @param angular_variances, angular_variance_stride as angular_variance there; a stride of 0 gives all fields
///     the same.
/// @param out, out_stride the light fields.
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

/// covbeam_light_field_travel for `count` light fields.
///
/// @param count number of fields; with 0 nothing is done.
/// @param fields, field_stride array of light fields, changed in place.
/// @param distances, distance_stride as distance there; a stride of 0 gives all fields the same.
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

/// covbeam_light_field_carry for `count` light fields in one medium.
///
/// @param count number of fields; with 0 nothing is done.
/// @param fields, field_stride array of light fields, changed in place.
/// @param medium as medium there.
/// @param origins, origin_stride as origin there; a stride of 0 gives all fields the same.
/// @param distances, distance_stride as distance there; a stride of 0 gives all fields the same.
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
        let medium = unsafe { medium::read(medium, "medium") }?;
        inputs!(count, origins: [f32; 3], origin_stride);
        inputs!(count, distances, distance_stride);
        update(
            fields,
            |i| Ok((vector(origins.get(i))?, finite_not_negative(distances.get(i))?)),
            |_, field, (origin, distance)| field.travel_through(&medium, origin, distance),
        )
    })
}

/// covbeam_light_field_rotate for `count` light fields.
///
/// @param count number of fields; with 0 nothing is done.
/// @param fields, field_stride array of light fields, changed in place.
/// @param x_axes, x_axis_stride as x_axis there; a stride of 0 gives all fields the same.
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

/// covbeam_light_field_reflect for `count` light fields.
///
/// @param count number of fields; with 0 nothing is done.
/// @param fields, field_stride array of light fields, changed in place.
/// @param normals, normal_stride as normal there; a stride of 0 gives all fields the same.
/// @param curvatures, curvature_stride as curvature there; a stride of 0 gives all fields the same.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_light_fields_reflect(
    count: usize,
    fields: *mut covbeam_light_field,
    field_stride: usize,
    normals: *const f32,
    normal_stride: usize,
    curvatures: *const covbeam_curvature,
    curvature_stride: usize,
) -> covbeam_status {
    run(|| {
        outputs!(count, fields, field_stride);
        inputs!(count, normals: [f32; 3], normal_stride);
        let all_planes = curvatures.is_null();
        let plane = covbeam_curvature { tangent: [0.0; 3], along: 0.0, across: 0.0, twist: 0.0 };
        let (first, stride) =
            if all_planes { (ptr::from_ref(&plane), 0) } else { (curvatures, curvature_stride) };
        // SAFETY: by the caller's promise, or the plane above.
        let curvatures = unsafe { Inputs::new(first, stride, count, "curvatures") }?;
        update(
            fields,
            |i| Ok((direction(normals.get(i))?, curvature(curvatures.get(i))?)),
            |_, field, (normal, curvature)| field.reflect(normal, &curvature),
        )
    })
}

/// covbeam_light_field_refract for `count` light fields.
///
/// @param count number of fields; with 0 nothing is done.
/// @param fields, field_stride array of light fields, changed in place.
/// @param normals, normal_stride as normal there; a stride of 0 gives all fields the same.
/// @param curvatures, curvature_stride as curvature there; a stride of 0 gives all fields the same.
/// @param etas, eta_stride as eta there; a stride of 0 gives all fields the same.
/// @param passed, passed_stride as passed there.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_light_fields_refract(
    count: usize,
    fields: *mut covbeam_light_field,
    field_stride: usize,
    normals: *const f32,
    normal_stride: usize,
    curvatures: *const covbeam_curvature,
    curvature_stride: usize,
    etas: *const f32,
    eta_stride: usize,
    passed: *mut u8,
    passed_stride: usize,
) -> covbeam_status {
    run(|| {
        outputs!(count, fields, field_stride);
        inputs!(count, normals: [f32; 3], normal_stride);
        let all_planes = curvatures.is_null();
        let plane = covbeam_curvature { tangent: [0.0; 3], along: 0.0, across: 0.0, twist: 0.0 };
        let (first, stride) =
            if all_planes { (ptr::from_ref(&plane), 0) } else { (curvatures, curvature_stride) };
        // SAFETY: by the caller's promise, or the plane above.
        let curvatures = unsafe { Inputs::new(first, stride, count, "curvatures") }?;
        inputs!(count, etas, eta_stride);
        outputs!(count, passed, passed_stride);
        update(
            fields,
            |i| Ok((direction(normals.get(i))?, curvature(curvatures.get(i))?, positive(etas.get(i))?)),
            |i, field, (normal, curvature, eta)| {
                passed.set(i, u8::from(field.refract(normal, &curvature, eta)))
            },
        )
    })
}

/// covbeam_light_field_occlude for `count` light fields.
///
/// @param count number of fields; with 0 nothing is done.
/// @param fields, field_stride array of light fields, changed in place.
/// @param towards_edges, towards_edge_stride as towards_edge there; a stride of 0 gives all fields the same.
/// @param distances, distance_stride as distance there; a stride of 0 gives all fields the same.
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

/// covbeam_light_field_attenuate for `count` light fields.
///
/// @param count number of fields; with 0 nothing is done.
/// @param fields, field_stride array of light fields, changed in place.
/// @param gradients, gradient_stride as gradient there; a stride of 0 gives all fields the same.
/// @param hessians, hessian_stride as hessian there; a stride of 0 gives all fields the same.
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

/// covbeam_light_field_narrow for `count` light fields.
///
/// @param count number of fields; with 0 nothing is done.
/// @param fields, field_stride array of light fields, changed in place.
/// @param acrosses, across_stride as across there; a stride of 0 gives all fields the same.
/// @param angular_variances, angular_variance_stride as angular_variance there; a stride of 0 gives all fields
///     the same.
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

/// covbeam_light_field_scatter for `count` light fields.
///
/// @param count number of fields; with 0 nothing is done.
/// @param fields, field_stride array of light fields, changed in place.
/// @param directions, direction_stride as direction there; a stride of 0 gives all fields the same.
/// @param angular_variances, angular_variance_stride as angular_variance there; a stride of 0 gives all fields
///     the same.
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

/// covbeam_light_field_diffuse for `count` light fields.
///
/// @param count number of fields; with 0 nothing is done.
/// @param fields, field_stride array of light fields, changed in place.
/// @param normals, normal_stride as normal there; a stride of 0 gives all fields the same.
/// @param directions, direction_stride as direction there; a stride of 0 gives all fields the same.
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

/// covbeam_light_field_slice for `count` light fields.
///
/// @param count number of fields; with 0 nothing is done.
/// @param fields, field_stride array of light fields.
/// @param variances_out, out_stride as variances there.
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
        // SAFETY: by the caller's promise.
        let out =
            unsafe { Outputs::<[f32; 3]>::new(variances_out.cast(), out_stride, count, "variances_out") }?;
        write(out, |i| light_field(fields.get(i)), |field| field.slice())
    })
}

/// covbeam_light_field_fluence for `count` light fields.
///
/// @param count number of fields; with 0 nothing is done.
/// @param fields, field_stride array of light fields.
/// @param limits, limit_stride as limit there; a stride of 0 gives all fields the same.
/// @param spectrum_out, out_stride as spectrum there.
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
        // SAFETY: by the caller's promise.
        let out =
            unsafe { Outputs::<covbeam_spectrum>::new(spectrum_out, out_stride, count, "spectrum_out") }?;
        write(
            out,
            |i| Ok((light_field(fields.get(i))?, positive_or_infinite(limits.get(i))?)),
            |(field, limit)| field.fluence_within(limit).into(),
        )
    })
}

/// covbeam_light_field_variance_along_ray for `count` light fields.
///
/// @param count number of fields; with 0 nothing is done.
/// @param fields, field_stride array of light fields.
/// @param extinctions, extinction_stride as extinction there; a stride of 0 gives all fields the same.
/// @param variance_out, out_stride as variance there.
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
        // SAFETY: by the caller's promise.
        let out = unsafe { Outputs::<f32>::new(variance_out, out_stride, count, "variance_out") }?;
        write(
            out,
            |i| Ok((light_field(fields.get(i))?, finite_not_negative(extinctions.get(i))?)),
            |(field, extinction)| field.variance_along_ray(extinction),
        )
    })
}
