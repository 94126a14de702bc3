//! What the passes add up to at one pixel, with the same bits in whatever order they come.
//!
//! Whole numbers of 64 bits, in a unit of the picture's: sums in f64 depend on their order, and 128 bits in
//! one unit for all pictures take 208 bytes a pixel.

use super::{FilmSample, luminance};
use glam::Vec3;

/// Units of the sums in a radiance that is typical of the picture.
const UNITS: f64 = (1_u64 << 32) as f64;

/// In which unit radiance is added up: the sums are whole numbers, so that their order does not count.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FilmUnit {
    units: f64,
}

impl FilmUnit {
    /// 2⁻³² of the largest power of two below a radiance that is typical of the picture, give or take a
    /// factor of a thousand.
    ///
    /// Sums stop at 2³¹ times that radiance.
    ///
    /// - `typical` \[W/(m² sr)\]: anything that is not finite and above 0 counts as 1.
    pub fn new(typical: f32) -> Self {
        let typical = if typical > f32::MIN_POSITIVE && typical < f32::INFINITY { typical } else { 1.0 };
        Self { units: UNITS / f64::from(f32::from_bits(typical.to_bits() & 0x7f80_0000)) }
    }

    /// A radiance in whole units, rounded once; it stops at the largest number.
    pub fn whole(&self, value: f32) -> i64 {
        // The product is exact (a power of two, far from f64's limits); `as` stops at i64's limits.
        libm::rint(f64::from(value) * self.units) as i64
    }

    fn value(&self, sum: i64) -> f64 {
        sum as f64 / self.units
    }
}

/// Sums over the eye rays of one pixel (40 bytes). All zero = none yet.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FilmSums {
    radiance: [i64; 3],
    first: i64,
    rays: u32,
    first_rays: u32,
}

impl FilmSums {
    /// Adds an eye ray.
    ///
    /// - `radiance`: what it saw, finite and not negative; anything else counts as 0.
    /// - `odd`: whether its pass' number is odd. The two halves of the passes tell the error.
    pub fn add(&mut self, unit: &FilmUnit, radiance: Vec3, odd: bool) {
        for (sum, value) in self.radiance.iter_mut().zip(radiance.to_array()) {
            *sum = sum.saturating_add(unit.whole(value.max(0.0)));
        }
        self.rays = self.rays.saturating_add(1);
        if odd {
            self.first = self.first.saturating_add(unit.whole(luminance(radiance).max(0.0)));
            self.first_rays = self.first_rays.saturating_add(1);
        }
    }

    /// Number of eye rays so far.
    pub fn rays(&self) -> u32 {
        self.rays
    }

    /// Adds the sums of other eye rays of this pixel, in the same unit: the bits do not depend on how rays
    /// were grouped, nor on the order of groups.
    pub fn merge(&mut self, other: &Self) {
        // No term is negative, so that sums which stop at the largest number are as free of order.
        for (sum, more) in self.radiance.iter_mut().zip(other.radiance) {
            *sum = sum.saturating_add(more);
        }
        self.first = self.first.saturating_add(other.first);
        self.rays = self.rays.saturating_add(other.rays);
        self.first_rays = self.first_rays.saturating_add(other.first_rays);
    }

    /// The sums as whole numbers that a file can hold: red, green, blue, luminance of the odd passes (in the
    /// film's unit), eye rays, eye rays of the odd passes.
    pub fn to_words(&self) -> [u64; 6] {
        let [red, green, blue] = self.radiance.map(|sum| sum as u64);
        [red, green, blue, self.first as u64, self.rays.into(), self.first_rays.into()]
    }

    /// What [`FilmSums::to_words`] was called on; None for numbers that no sums have.
    pub fn from_words([red, green, blue, first, rays, first_rays]: [u64; 6]) -> Option<Self> {
        let sum = |word| i64::try_from(word).ok();
        let count = |word| u32::try_from(word).ok();
        let (rays, first_rays) = (count(rays)?, count(first_rays)?);
        (first_rays <= rays).then_some(())?;
        Some(Self { radiance: [sum(red)?, sum(green)?, sum(blue)?], first: sum(first)?, rays, first_rays })
    }

    /// The sums over an expected number of eye rays: what a [`super::Reconstruction`] takes.
    ///
    /// - `expected` > 0: Σ density of all passes; not each ray over its own pass' density: one from an
    ///   early pass, when the grid knew little and wanted few, would outweigh hundreds of later ones (the
    ///   balance heuristic).
    pub fn sample(&self, unit: &FilmUnit, expected: f64) -> FilmSample {
        if !(expected > 0.0) {
            return FilmSample::default();
        }
        let share = |value: f64| (value / expected) as f32;
        let [red, green, blue] = self.radiance.map(|sum| share(unit.value(sum)));
        FilmSample {
            radiance: Vec3::new(red, green, blue),
            weight: share(f64::from(self.rays)),
            first: share(unit.value(self.first)),
            first_weight: share(f64::from(self.first_rays)),
        }
    }
}
