//! What a number or a vector from the host must be.

use crate::memory::Element;
use crate::status::Failure;
use glam::Vec3;

/// How far the squared length of a unit vector may be from 1: a thousand roundings, a fifth of a pixel in ten
/// thousand.
const UNIT: f32 = 1e-4;

pub(crate) fn finite(e: Element<f32>) -> Result<f32, Failure> {
    if e.value.is_finite() { Ok(e.value) } else { Err(e.is(format_args!("{} is not finite", e.value))) }
}

/// Zero and infinity are fine.
pub(crate) fn not_negative(e: Element<f32>) -> Result<f32, Failure> {
    if e.value >= 0.0 { Ok(e.value) } else { Err(e.is(format_args!("{} is not >= 0", e.value))) }
}

pub(crate) fn finite_not_negative(e: Element<f32>) -> Result<f32, Failure> {
    not_negative(e)?;
    finite(e)
}

/// Finite too.
pub(crate) fn positive(e: Element<f32>) -> Result<f32, Failure> {
    if e.value > 0.0 && e.value.is_finite() {
        Ok(e.value)
    } else {
        Err(e.is(format_args!("{} is not > 0 and finite", e.value)))
    }
}

pub(crate) fn positive_or_infinite(e: Element<f32>) -> Result<f32, Failure> {
    if e.value > 0.0 { Ok(e.value) } else { Err(e.is(format_args!("{} is not > 0", e.value))) }
}

/// A uniform random number.
pub(crate) fn random(e: Element<f32>) -> Result<f32, Failure> {
    if (0.0..1.0).contains(&e.value) {
        Ok(e.value)
    } else {
        Err(e.is(format_args!("{} is not in [0, 1)", e.value)))
    }
}

/// Two of them.
pub(crate) fn random_pair(e: Element<[f32; 2]>) -> Result<[f32; 2], Failure> {
    for value in e.value {
        random(e.part(|_| value))?;
    }
    Ok(e.value)
}

/// The cosine between two unit vectors, up to their rounding.
pub(crate) fn cosine(e: Element<f32>) -> Result<f32, Failure> {
    if e.value.abs() <= 1.0 + UNIT {
        Ok(e.value)
    } else {
        Err(e.is(format_args!("{} is not in [-1, 1]", e.value)))
    }
}

/// A point, or any vector.
pub(crate) fn vector(e: Element<[f32; 3]>) -> Result<Vec3, Failure> {
    let vector = Vec3::from_array(e.value);
    if vector.is_finite() { Ok(vector) } else { Err(e.is(format_args!("{:?} is not finite", e.value))) }
}

/// A vector of any length but 0.
pub(crate) fn direction(e: Element<[f32; 3]>) -> Result<Vec3, Failure> {
    let vector = vector(e)?;
    if vector == Vec3::ZERO { Err(e.is(format_args!("has no direction: it is 0"))) } else { Ok(vector) }
}

pub(crate) fn unit(e: Element<[f32; 3]>) -> Result<Vec3, Failure> {
    let vector = Vec3::from_array(e.value);
    if (vector.length_squared() - 1.0).abs() <= UNIT {
        Ok(vector)
    } else {
        Err(e.is(format_args!("{:?} does not have length 1", e.value)))
    }
}

/// A unit vector, or 0 for none.
pub(crate) fn unit_or_zero(e: Element<[f32; 3]>) -> Result<Vec3, Failure> {
    if e.value == [0.0; 3] { Ok(Vec3::ZERO) } else { unit(e) }
}

pub(crate) fn not_negative_each<const N: usize>(e: Element<[f32; N]>) -> Result<[f32; N], Failure> {
    for value in e.value {
        not_negative(e.part(|_| value))?;
    }
    Ok(e.value)
}

pub(crate) fn finite_each<const N: usize>(e: Element<[f32; N]>) -> Result<[f32; N], Failure> {
    for value in e.value {
        finite(e.part(|_| value))?;
    }
    Ok(e.value)
}
