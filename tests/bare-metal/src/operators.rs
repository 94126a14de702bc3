//! The operators of light fields. Made from the headers by `cargo run -p covbeam-tests --bin header`; do not edit.

use crate::words::Words;
use covbeam::LightField;

/// Applies the operator of a line.
pub fn apply(name: &[u8], field: &mut LightField, i: &mut Words) -> Option<()> {
    match name {
        b"light_field_travel" => field.travel(i.float()?),
        b"light_field_rotate" => field.rotate(i.vector()?),
        b"light_field_reflect" => field.reflect(i.vector()?, &i.curvature()?),
        b"light_field_occlude" => field.occlude(i.vector()?, i.float()?),
        b"light_field_attenuate" => field.attenuate(i.vector()?, &i.floats()?),
        b"light_field_narrow" => field.narrow(i.vector()?, i.float()?),
        b"light_field_scatter" => field.scatter(i.vector()?, i.float()?),
        b"light_field_diffuse" => field.diffuse(i.vector()?, i.vector()?),
        _ => return None,
    }
    Some(())
}
