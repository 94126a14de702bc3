//! Photon beams.

use crate::check::{finite_not_negative, unit, unit_or_zero, vector};
use crate::memory::{Element, field};
use crate::status::Failure;
use covbeam_core::Beam;

/// A photon beam: a straight piece of a photon's path through a medium. It runs on to the next surface,
/// whatever the photon's free flight was; the gather multiplies by the transmittance ("long beams").
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct covbeam_beam {
    /// Where it starts [m].
    pub origin: [f32; 3],
    /// Direction of propagation, unit.
    pub direction: [f32; 3],
    /// Length [m] to the next surface, finite and >= 0; where there is none, covbeam_medium_reach is far
    /// enough.
    pub length: f32,
    /// Flux at the origin per channel [W], already divided by the number of light paths of the pass.
    pub power: [f32; 3],
    /// Unit normal of the surface on which it starts, towards the medium; 0 if it starts in the open.
    pub start_normal: [f32; 3],
    /// Unit normal of the surface on which it ends, towards the medium; 0 if it ends in the open.
    pub end_normal: [f32; 3],
}

fn beam_length(e: Element<f32>) -> Result<f32, Failure> {
    if e.value == f32::INFINITY {
        return Err(e.is(format_args!("inf; end it where nothing is left to see, at covbeam_medium_reach")));
    }
    finite_not_negative(e)
}

pub(crate) fn beam(e: Element<covbeam_beam>) -> Result<Beam, Failure> {
    Ok(Beam {
        origin: vector(field!(e, origin))?,
        direction: unit(field!(e, direction))?,
        length: beam_length(field!(e, length))?,
        power: vector(field!(e, power))?,
        start_normal: unit_or_zero(field!(e, start_normal))?,
        end_normal: unit_or_zero(field!(e, end_normal))?,
    })
}
