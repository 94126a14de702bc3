//! The operators, on strided arrays of light fields.

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

/// Reflection by a smooth mirror. A ray that grazes it to below 1e-12 is left as it was.
///
/// @param count number of fields; with 0 nothing is done.
/// @param fields, field_stride the light fields, changed in place.
/// @param normals, normal_stride at the hit, any length, either side.
/// @param curvatures, curvature_stride of the surface on the side of the normal; may be NULL: a plane.
/// @note Coddington's equations.
/// @kinds =field <f:ddd <curvature?
/// @single covbeam_light_field_reflect
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

/// Refraction through a smooth surface.
///
/// @param count number of fields; with 0 nothing is done.
/// @param fields, field_stride the light fields, changed in place.
/// @param normals, normal_stride at the hit, any length, either side.
/// @param curvatures, curvature_stride of the surface on the side of the normal; may be NULL: a plane.
/// @param etas, eta_stride refractive index on the incoming side over that on the other, > 0.
/// @param passed, passed_stride 1 if light passes; 0 on total reflection (and exactly grazing light), which
///     leaves the field as it was.
/// @note Coddington's equations.
/// @kinds =field <f:ddd <curvature? <f:+ >flag
/// @single covbeam_light_field_refract
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
        // SAFETY: by the caller's promise.
        let out =
            unsafe { Outputs::<[f32; 3]>::new(variances_out.cast(), out_stride, count, "variances_out") }?;
        write(out, |i| light_field(fields.get(i)), |field| field.slice())
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
        // SAFETY: by the caller's promise.
        let out = unsafe { Outputs::<f32>::new(variance_out, out_stride, count, "variance_out") }?;
        write(
            out,
            |i| Ok((light_field(fields.get(i))?, finite_not_negative(extinctions.get(i))?)),
            |(field, extinction)| field.variance_along_ray(extinction),
        )
    })
}
