//! Eye rays, and what they gather.

use crate::check::{finite, finite_each, not_negative, unit, vector};
use crate::memory::{Element, field};
use crate::status::Failure;
use covbeam_core::{EyeRay, Gathered};
use glam::Vec3;

/// One straight piece of an eye path inside one medium.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct covbeam_eye_ray {
    /// Where it starts [m].
    pub origin: [f32; 3],
    /// Direction, unit, away from the eye.
    pub direction: [f32; 3],
    /// Length [m] >= 0 to the next surface; infinity allowed.
    pub length: f32,
}

#[inline(always)]
pub(crate) fn eye_ray(e: Element<covbeam_eye_ray>) -> Result<EyeRay, Failure> {
    Ok(EyeRay {
        origin: vector(field!(e, origin))?,
        direction: unit(field!(e, direction))?,
        length: not_negative(field!(e, length))?,
    })
}

pub(crate) unsafe fn read_ray(pointer: *const covbeam_eye_ray) -> Result<EyeRay, Failure> {
    // SAFETY: by the caller's promise.
    eye_ray(unsafe { Element::read(pointer, "ray") }?)
}

/// What an eye ray has gathered.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct covbeam_gathered {
    /// In-scattered radiance at the ray's origin [W/(m^2 sr)].
    pub radiance: [f32; 3],
    /// Accepted pairs of ray and beam; one of nearly one direction (sine below .05) counts as eight.
    pub pairs: u32,
    /// Sum over the pairs of their contribution (mean of the channels): the weight of the next two.
    pub weight: f32,
    /// Weighted sum of the kernel radii [m].
    pub radius: f32,
    /// Weighted sum of the light's bandwidth along the kernel's axis [cycles/m].
    pub sigma: f32,
}

impl From<Gathered> for covbeam_gathered {
    fn from(g: Gathered) -> Self {
        Self {
            radiance: g.radiance.into(),
            pairs: g.pairs,
            weight: g.weight,
            radius: g.radius,
            sigma: g.sigma,
        }
    }
}

impl From<covbeam_gathered> for Gathered {
    fn from(g: covbeam_gathered) -> Self {
        Self {
            radiance: Vec3::from(g.radiance),
            pairs: g.pairs,
            weight: g.weight,
            radius: g.radius,
            sigma: g.sigma,
        }
    }
}

/// What an eye ray has gathered so far.
pub(crate) fn gathered(e: Element<covbeam_gathered>) -> Result<Gathered, Failure> {
    finite_each(field!(e, radiance))?;
    for sum in [field!(e, weight), field!(e, radius), field!(e, sigma)] {
        finite(sum)?;
    }
    Ok(e.value.into())
}
