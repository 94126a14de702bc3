//! Checks of numbers; each error names the field.

use crate::scene::visibility::{Heed, Rays, SETS};
use crate::work::failure::{Failure, Result, invalid};
use covbeam_geometry::MAX_COORDINATE;
use glam::{DVec3, Vec3};
use std::fmt::{Debug, Display};
use std::ops::RangeInclusive;

/// How far the length of a unit vector may be from 1, and the cosine of a right angle from 0.
const UNIT: f64 = 1e-3;

/// Largest radiometric value: single precision holds its products with what a scene has.
pub(super) const BRIGHTEST: f64 = 1e30;

/// Number of the last set that an object or a medium may be in.
const LAST_SET: f64 = SETS as f64 - 1.0;

/// Something whose fields are read, such as a light: it is named where one of them is wrong.
pub(super) struct Fields<'a> {
    list: &'a str,
    index: Option<usize>,
}

impl<'a> Fields<'a> {
    pub(super) fn of(list: &'a str, index: usize) -> Self {
        Self { list, index: Some(index) }
    }

    pub(super) fn alone(name: &'a str) -> Self {
        Self { list: name, index: None }
    }

    /// That a field has a value which it may not have.
    pub(super) fn wrong(&self, name: &str, value: impl Debug, wanted: impl Display) -> Failure {
        let Self { list, index } = self;
        match index {
            Some(index) => invalid!("{list}[{index}].{name}: {value:?}; give {wanted}"),
            None => invalid!("{list}.{name}: {value:?}; give {wanted}"),
        }
    }

    pub(super) fn number(&self, name: &str, value: f64, range: RangeInclusive<f64>) -> Result<f32> {
        // False for NaN.
        if !range.contains(&value) {
            let wanted = format!("a number from {} to {}", range.start(), range.end());
            return Err(self.wrong(name, value, wanted));
        }
        Ok(value as f32)
    }

    /// A length of the scene \[m\], > 0.
    pub(super) fn length(&self, name: &str, value: f64) -> Result<f32> {
        let most = f64::from(MAX_COORDINATE);
        self.number(name, value, most.recip()..=most)
    }

    pub(super) fn point(&self, name: &str, value: [f64; 3]) -> Result<DVec3> {
        let within = |x: &f64| x.abs() <= f64::from(MAX_COORDINATE);
        if !value.iter().all(within) {
            return Err(self.wrong(name, value, "finite coordinates up to 1e9"));
        }
        Ok(DVec3::from(value))
    }

    pub(super) fn direction(&self, name: &str, value: [f64; 3]) -> Result<DVec3> {
        let vector = DVec3::from(value);
        if !((vector.length() - 1.0).abs() <= UNIT) {
            return Err(self.wrong(name, value, "a vector of length 1"));
        }
        Ok(vector.normalize())
    }

    /// A set of kinds of rays.
    pub(super) fn rays(&self, name: &str, bits: u32) -> Result<Rays> {
        let wanted = format_args!("a sum of the bits up to {}", Rays::SHADOW.bits());
        Rays::from_bits(bits).ok_or_else(|| self.wrong(name, bits, wanted))
    }

    /// What lamps and rays do not heed something.
    pub(super) fn heed(&self, hidden_from: u32, light_set: u32, shadow_set: u32) -> Result<Heed> {
        let set = |name, set: u32| self.number(name, set.into(), 0.0..=LAST_SET).map(|set| set as u8);
        Ok(Heed {
            hidden: self.rays("hidden_from", hidden_from)?,
            light_set: set("light_set", light_set)?,
            shadow_set: set("shadow_set", shadow_set)?,
        })
    }

    /// Three unit vectors at right angles.
    pub(super) fn axes(&self, names: [&str; 3], values: [[f64; 3]; 3]) -> Result<[DVec3; 3]> {
        let mut axes = [DVec3::ZERO; 3];
        for (axis, (name, value)) in axes.iter_mut().zip(names.into_iter().zip(values)) {
            *axis = self.direction(name, value)?;
        }
        let [a, b, c] = axes;
        if a.dot(b).abs().max(b.dot(c).abs()).max(c.dot(a).abs()) > UNIT {
            return Err(self.wrong(names[0], values, "three vectors at right angles"));
        }
        Ok(axes)
    }

    /// Three numbers >= 0, up to `most`.
    pub(super) fn color(&self, name: &str, value: [f64; 3], most: f64) -> Result<Vec3> {
        if !value.iter().all(|value| (0.0..=most).contains(value)) {
            return Err(self.wrong(name, value, format_args!("numbers from 0 to {most:e}")));
        }
        Ok(DVec3::from(value).as_vec3())
    }
}
