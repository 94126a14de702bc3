//! Rounds of shadow rays.

use super::handle::{Table, covbeam_march};
use crate::check::{finite, finite_not_negative, random};
use crate::handle::run_on;
use crate::heap::grow;
use crate::memory::{Element, Inputs, Outputs, field, inputs, outputs};
use crate::status::{Failure, covbeam_status};
use covbeam_core::MarchSample;

/// A place for a shadow ray.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct covbeam_march_sample {
    /// From the ray's origin [m].
    pub distance: f32,
    /// The sum over a round of weight x radiance x visibility, at distance, is the estimate of the light
    /// scattered to the eye [m]. 0 = no shadow ray is needed.
    pub weight: f32,
    /// What the shadow ray found, in [0, 1], written by the host; read from the first round by
    /// covbeam_march_refine.
    pub visibility: f32,
    /// 0.
    pub reserved: u32,
    /// The table's expected light up to distance [W/(m^2 sr)], by which covbeam_march_refine finds the first
    /// round.
    pub mass: f64,
}

impl From<MarchSample> for covbeam_march_sample {
    fn from(sample: MarchSample) -> Self {
        let MarchSample { distance, weight, visibility, mass } = sample;
        Self { distance, weight, visibility, reserved: 0, mass }
    }
}

/// A sample of a first round, with what its shadow ray found; NaN is nothing.
fn march_sample(e: Element<covbeam_march_sample>) -> Result<MarchSample, Failure> {
    let covbeam_march_sample { distance, weight, visibility, mass, .. } = e.value;
    finite(field!(e, distance))?;
    finite_not_negative(field!(e, weight))?;
    if !(visibility.is_nan() || (0.0..=1.0).contains(&visibility)) {
        return Err(field!(e, visibility).is(format_args!("{visibility} is not in [0, 1]")));
    }
    if !(mass >= 0.0 && mass.is_finite()) {
        return Err(field!(e, mass).is(format_args!("{mass} is not of covbeam_march_place")));
    }
    Ok(MarchSample { distance, weight, visibility, mass })
}

impl Table {
    /// Places a round after the `first` one, which may be empty.
    fn place(
        &mut self,
        jitters: &Inputs<f32>,
        mut out: Outputs<covbeam_march_sample>,
    ) -> Result<(), Failure> {
        self.view()?;
        let count = out.count();
        self.jitters.clear();
        self.samples.clear();
        grow(&mut self.jitters, count)?;
        grow(&mut self.samples, count)?;
        for i in 0..count {
            self.jitters.push(random(jitters.get(i))?);
        }
        self.samples.resize(count, MarchSample::default());
        let Self { view, first, jitters, samples, .. } = self;
        let march = view.as_ref().expect("looked at above");
        march.refine(first, jitters, samples);
        for (i, sample) in samples.iter().enumerate() {
            out.set(i, (*sample).into());
        }
        Ok(())
    }
}

/// Places a round of shadow rays from the table alone. The sum of weight x radiance x visibility over the round
/// is an unbiased estimate, whatever the table says, as long as it hides no light between two dark knots.
///
/// @param march a march that has a table.
/// @param count number of shadow rays; with 0 nothing is done.
/// @param jitters, jitter_stride uniform numbers in [0, 1), independent of each other.
/// @param samples, sample_stride receive the places, from near to far, with a visibility of 0; without light on
///     the ray, with a weight of 0 at the first knot.
/// @note Thesis 5.3.3; for light that is known without a shadow ray, the density that is best for strata. About
///     1 us for 30.
/// @kinds !march.resolved <f:r >aim
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_march_place(
    march: *mut covbeam_march,
    count: usize,
    jitters: *const f32,
    jitter_stride: usize,
    samples: *mut covbeam_march_sample,
    sample_stride: usize,
) -> covbeam_status {
    let place = |table: &mut Table| {
        inputs!(count, jitters, jitter_stride);
        outputs!(count, samples, sample_stride);
        table.first.clear();
        table.place(&jitters, samples)
    };
    // SAFETY: by the caller's promise.
    unsafe { run_on(march, "march", place) }
}

/// Places a second round of shadow rays, dense where the first one saw changes. The estimate is the sum over
/// the second round alone, and unbiased likewise.
///
/// @param march the march, with the table that the first round was placed with.
/// @param first_count number of shadow rays of the first round.
/// @param firsts, first_stride what covbeam_march_place wrote, with the visibilities found, each in [0, 1]. A
///     NaN, and a weight of 0, say nothing.
/// @param count number of shadow rays of the second round; with 0 nothing is done.
/// @param jitters, jitter_stride as for covbeam_march_place, independent of the first round.
/// @param samples, sample_stride as there.
/// @note About 3 us for 10 and 20.
/// @kinds !march.resolved n <aim <f:r >aim
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_march_refine(
    march: *mut covbeam_march,
    first_count: usize,
    firsts: *const covbeam_march_sample,
    first_stride: usize,
    count: usize,
    jitters: *const f32,
    jitter_stride: usize,
    samples: *mut covbeam_march_sample,
    sample_stride: usize,
) -> covbeam_status {
    let refine = |table: &mut Table| {
        inputs!(first_count, firsts, first_stride);
        inputs!(count, jitters, jitter_stride);
        outputs!(count, samples, sample_stride);
        table.first.clear();
        grow(&mut table.first, first_count)?;
        for i in 0..first_count {
            table.first.push(march_sample(firsts.get(i))?);
        }
        table.place(&jitters, samples)
    };
    // SAFETY: by the caller's promise.
    unsafe { run_on(march, "march", refine) }
}
