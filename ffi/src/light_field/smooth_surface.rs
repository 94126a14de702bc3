//! Smooth surfaces: reflection and refraction with curvature.

use super::field::{covbeam_light_field, update};
use crate::check::{direction, finite, positive, vector};
use crate::memory::{Element, Inputs, field, inputs, outputs};
use crate::status::{Failure, covbeam_status, run};
use covbeam_core::Curvature;

/// Curvature of a surface at a hit [1/m], positive where it is convex on the side of the normal; all 0 is a
/// plane.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct covbeam_curvature {
    /// First axis of the tensor, in the surface, any length; 0 if along equals across.
    pub tangent: [f32; 3],
    /// Normal curvature along tangent.
    pub along: f32,
    /// Normal curvature along normal x tangent.
    pub across: f32,
    /// The off-diagonal entry.
    pub twist: f32,
}

impl From<covbeam_curvature> for Curvature {
    fn from(c: covbeam_curvature) -> Self {
        Self { tangent: c.tangent.into(), along: c.along, across: c.across, twist: c.twist }
    }
}

pub(crate) fn curvature(e: Element<covbeam_curvature>) -> Result<Curvature, Failure> {
    vector(field!(e, tangent))?;
    for bend in [field!(e, along), field!(e, across), field!(e, twist)] {
        finite(bend)?;
    }
    Ok(e.value.into())
}

/// The curvature of one hit; where the host gives none, of a plane.
fn curvature_at(curvatures: &Option<Inputs<covbeam_curvature>>, index: usize) -> Result<Curvature, Failure> {
    let given = curvatures.as_ref().map(|curvatures| curvature(curvatures.get(index)));
    given.unwrap_or(Ok(Curvature::default()))
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
        // SAFETY: by the caller's promise.
        let curvatures = unsafe { Inputs::optional(curvatures, curvature_stride, count, "curvatures") }?;
        update(
            fields,
            |i| Ok((direction(normals.get(i))?, curvature_at(&curvatures, i)?)),
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
        // SAFETY: by the caller's promise.
        let curvatures = unsafe { Inputs::optional(curvatures, curvature_stride, count, "curvatures") }?;
        inputs!(count, etas, eta_stride);
        outputs!(count, passed, passed_stride);
        update(
            fields,
            |i| Ok((direction(normals.get(i))?, curvature_at(&curvatures, i)?, positive(etas.get(i))?)),
            |i, field, (normal, curvature, eta)| {
                passed.set(i, u8::from(field.refract(normal, &curvature, eta)))
            },
        )
    })
}
