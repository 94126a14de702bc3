//! A call on an array: everything is checked before anything is written, since a host would not look at a
//! status an element.

use crate::memory::Outputs;
use crate::status::Failure;
use crate::types::{covbeam_light_field, light_field};
use covbeam_core::LightField;

/// Checks every argument, then writes the results.
pub(crate) fn write<A, T: Copy>(
    mut out: Outputs<T>,
    arguments: impl Fn(usize) -> Result<A, Failure>,
    result: impl Fn(A) -> T,
) -> Result<(), Failure> {
    for i in 0..out.count() {
        arguments(i)?;
    }
    for i in 0..out.count() {
        out.set(i, result(arguments(i)?));
    }
    Ok(())
}

/// Checks every field and every argument, then changes the fields.
pub(crate) fn update<A>(
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
