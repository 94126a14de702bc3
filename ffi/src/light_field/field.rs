//! Light fields as the host keeps them.

use crate::check::{finite_each, unit};
use crate::memory::{Element, Outputs, field};
use crate::status::Failure;
use covbeam_core::LightField;

/// Square root of the covariance of a local light field's spectrum. Made by covbeam_light_field_point and its
/// kin; the numbers are the host's to copy, store and send, not to write.
///
/// Error of what it says of the fluence, relative to the largest entry of its covariance: one rounding of the
/// ten numbers per operator; below 1e-6 after tens of events and 1e-5 after 1000, but near a focus, where it
/// is as large as what the rounding of the inputs changes. Long ways of strongly bent light lose more: of 1000
/// random chains of up to 1000 events, with ways of 1e-3 to 1e3 m and curvatures of 0.01 to 100 per m, half are
/// within 1e-7, 99 % within 7e-6, all within 2e-4. Where curvature times distance is beyond 1e7, 24 bits hold
/// only one axis of the light.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct covbeam_light_field {
    /// Lower-triangular L with covariance L L^T, rows (u, v, x, y), packed row by row [uu, vu, vv, xu, xv, xx,
    /// yu, yv, yx, yy]: u, v in cycles/rad, x, y in cycles/m.
    pub root: [f32; 10],
    /// The frame's x axis: unit, across direction; y = direction x x_axis.
    pub x_axis: [f32; 3],
    /// Direction of propagation, unit.
    pub direction: [f32; 3],
}

impl From<covbeam_light_field> for LightField {
    fn from(field: covbeam_light_field) -> Self {
        Self { root: field.root, x_axis: field.x_axis.into(), direction: field.direction.into() }
    }
}

impl From<LightField> for covbeam_light_field {
    fn from(field: LightField) -> Self {
        Self { root: field.root, x_axis: field.x_axis.into(), direction: field.direction.into() }
    }
}

/// A light field as only the library writes them, up to the rounding of its frame.
pub(crate) fn light_field(e: Element<covbeam_light_field>) -> Result<LightField, Failure> {
    finite_each(field!(e, root))?;
    let x = unit(field!(e, x_axis))?;
    let z = unit(field!(e, direction))?;
    // Rounded axes are across each other to 1e-7.
    if x.dot(z).abs() <= 1e-4 {
        Ok(e.value.into())
    } else {
        Err(field!(e, x_axis).is(format_args!("{x} is not across direction {z}")))
    }
}

/// Checks every field and every argument, then changes the fields.
pub(super) fn update<A>(
    mut fields: Outputs<covbeam_light_field>,
    arguments: impl Fn(usize) -> Result<A, Failure>,
    mut apply: impl FnMut(usize, &mut LightField, A),
) -> Result<(), Failure> {
    for i in 0..fields.count() {
        light_field(fields.get(i))?;
        arguments(i)?;
    }
    for i in 0..fields.count() {
        let mut field = light_field(fields.get(i))?;
        apply(i, &mut field, arguments(i)?);
        fields.set(i, field.into());
    }
    Ok(())
}
