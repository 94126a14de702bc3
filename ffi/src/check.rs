//! What a number or a vector from the host must be.

use crate::memory::Element;
use crate::status::Failure;
use glam::Vec3;

/// How far the squared length of a unit vector may be from 1: a thousand roundings, a fifth of a pixel in ten
/// thousand.
const UNIT: f32 = 1e-4;

#[inline(always)]
pub(crate) fn finite(e: Element<f32>) -> Result<f32, Failure> {
    if e.value.is_finite() { Ok(e.value) } else { Err(e.is(format_args!("{} is not finite", e.value))) }
}

/// Zero and infinity are fine.
#[inline(always)]
pub(crate) fn not_negative(e: Element<f32>) -> Result<f32, Failure> {
    if e.value >= 0.0 { Ok(e.value) } else { Err(e.is(format_args!("{} is not >= 0", e.value))) }
}

pub(crate) fn finite_not_negative(e: Element<f32>) -> Result<f32, Failure> {
    not_negative(e)?;
    finite(e)
}

/// Finite too.
#[inline(always)]
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

/// A uniform random number, below 1.
pub(crate) fn random(e: Element<f32>) -> Result<f32, Failure> {
    /// What 1 counts as: a host's generator that rounds a double to a float makes it now and then.
    const LARGEST: f32 = 1.0 - f32::EPSILON / 2.0;
    if (0.0..=1.0).contains(&e.value) {
        Ok(e.value.min(LARGEST))
    } else {
        Err(e.is(format_args!("{} is not in [0, 1): a uniform random number", e.value)))
    }
}

/// Two of them.
pub(crate) fn random_pair(e: Element<[f32; 2]>) -> Result<[f32; 2], Failure> {
    let [a, b] = e.value;
    Ok([random(e.part(|_| a))?, random(e.part(|_| b))?])
}

/// The cosine between two unit vectors, up to their rounding.
pub(crate) fn cosine(e: Element<f32>) -> Result<f32, Failure> {
    if e.value.abs() <= 1.0 + UNIT {
        Ok(e.value)
    } else {
        Err(e.is(format_args!("{} is not in [-1, 1]: the cosine between unit vectors", e.value)))
    }
}

/// A point, or any vector.
#[inline(always)]
pub(crate) fn vector(e: Element<[f32; 3]>) -> Result<Vec3, Failure> {
    let vector = Vec3::from_array(e.value);
    if vector.is_finite() { Ok(vector) } else { Err(e.is(format_args!("{:?} is not finite", e.value))) }
}

/// A vector of any length but 0.
pub(crate) fn direction(e: Element<[f32; 3]>) -> Result<Vec3, Failure> {
    let vector = vector(e)?;
    if vector == Vec3::ZERO { Err(e.is(format_args!("has no direction: it is 0"))) } else { Ok(vector) }
}

#[inline(always)]
pub(crate) fn unit(e: Element<[f32; 3]>) -> Result<Vec3, Failure> {
    let vector = Vec3::from_array(e.value);
    if (vector.length_squared() - 1.0).abs() <= UNIT {
        Ok(vector)
    } else {
        Err(e.is(format_args!("{:?} does not have length 1; normalise it", e.value)))
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_random_number_of_one_is_the_largest_below() {
        let checked = |value: f32| random(Element::single(value, "u")).ok();
        // What a double just below 1 becomes.
        let largest = 1.0_f32.next_down();
        assert_eq!(checked(0.999_999_99_f64 as f32), Some(largest));
        assert_eq!([0.0, 0.5, largest].map(checked), [Some(0.0), Some(0.5), Some(largest)]);
        assert_eq!([-1e-9, 1.0_f32.next_up(), f32::NAN].map(checked), [None; 3]);
        assert_eq!(random_pair(Element::single([1.0, 1.0], "u")).ok(), Some([largest; 2]));
    }
}
