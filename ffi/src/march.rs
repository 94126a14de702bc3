//! Where shadow rays go along an eye ray, for light scattered once.

use crate::check::{finite, random, unit, vector};
use crate::handle::{Opaque, free, handle_to, run_on, shared};
use crate::heap::{grow, reserved};
use crate::memory::{Element, Inputs, Outputs, Slot, field, inputs, outputs, read};
use crate::status::{Failure, covbeam_status, covbeam_status::*, fail, run};
use crate::types::*;
use core::slice;
use covbeam_core::{March, MarchCell, MarchKnot, MarchSample};

/// The table along one eye ray, and the memory that placing shadow rays needs: one a thread, for one ray after
/// the other. For each ray: covbeam_march_lay and the host's radiances make the knots; covbeam_march_update;
/// covbeam_march_place, and the shadow rays of the round; covbeam_march_refine, and those of a second one.
pub struct covbeam_march(());

impl Opaque for covbeam_march {
    type Object = Table;
    const TAG: u64 = u64::from_le_bytes(*b"cb-march");
    const NAME: &'static str = "covbeam_march";
}

/// What a `covbeam_march` is.
#[derive(Default)]
pub(crate) struct Table {
    knots: Vec<MarchKnot>,
    cells: Vec<MarchCell>,
    /// A view of the two above; None before the first update and while they change.
    view: Option<March<'static>>,
    /// Of one call.
    first: Vec<MarchSample>,
    jitters: Vec<f32>,
    samples: Vec<MarchSample>,
}

impl Table {
    fn view(&self) -> Result<&March<'static>, Failure> {
        let message = format_args!("march: no table yet; call covbeam_march_update first");
        self.view.as_ref().ok_or_else(|| fail(COVBEAM_WRONG_ORDER, message))
    }

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

/// Two knots or more.
fn enough(count: usize) -> Result<(), Failure> {
    if count >= 2 {
        Ok(())
    } else {
        Err(fail(COVBEAM_SHORT_BUFFER, format_args!("count: {count}, but a table needs two knots or more")))
    }
}

/// Lays knots along a stretch of a ray, at equal steps of the angle at which a light sees it. Each is dark, and
/// nothing is known: the host writes its radiance, deviation and visibility.
///
/// @param origin of the ray [m].
/// @param direction of the ray, unit.
/// @param from where the stretch begins [m], finite.
/// @param to where it ends [m] >= from; infinity stands for where the light sees the rest under 1/1000 rad.
/// @param light its position, or centre [m]. On the ray itself, the steps are equal in distance.
/// @param count number of knots >= 2; 97 serve well.
/// @param knots, knot_stride receive them, from near to far.
/// @note Kulla and Fajardo 2012. About 5 ns a knot.
/// @kinds <f:fff <f:uuu $f $N <f:fff >place
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_march_lay(
    origin: *const f32,
    direction: *const f32,
    from: f32,
    to: f32,
    light: *const f32,
    count: usize,
    knots: *mut covbeam_march_knot,
    knot_stride: usize,
) -> covbeam_status {
    run(|| {
        // SAFETY: by the caller's promise.
        let origin = vector(Element::single(unsafe { read(origin.cast(), "origin") }?, "origin"))?;
        // SAFETY: by the caller's promise.
        let direction = unit(Element::single(unsafe { read(direction.cast(), "direction") }?, "direction"))?;
        let from = finite(Element::single(from, "from"))?;
        let end = Element::single(to, "to");
        if !(to >= from) {
            return Err(end.is(format_args!("{to} is not >= from, {from}")));
        }
        // SAFETY: by the caller's promise.
        let light = vector(Element::single(unsafe { read(light.cast(), "light") }?, "light"))?;
        enough(count)?;
        outputs!(count, knots, knot_stride);
        let mut laid = reserved(count)?;
        laid.resize(count, MarchKnot::default());
        MarchKnot::lay(origin, direction, from, to, light, &mut laid).map_err(|_| {
            end.is(format_args!("the stretch or the light lies farther than a float can tell"))
        })?;
        for (i, knot) in laid.into_iter().enumerate() {
            knots.set(i, knot.into());
        }
        Ok(())
    })
}

/// Makes the memory of a thread's marches.
///
/// @param out the handle.
/// @kinds +march
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_march_new(out: *mut *mut covbeam_march) -> covbeam_status {
    run(|| {
        let out = Slot::new(out, "out")?;
        out.set(handle_to(Table::default())?);
        Ok(())
    })
}

/// Frees a thread's memory.
///
/// @param march NULL is fine.
/// @kinds !march
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_march_free(march: *mut covbeam_march) -> covbeam_status {
    // SAFETY: by the caller's promise.
    unsafe { free(march, "march") }
}

/// Takes the table of the next eye ray, in place of the one before.
///
/// @param march the thread's memory.
/// @param count number of knots >= 2.
/// @param knots, knot_stride by distance, which are finite and do not fall; copied. Between them the radiance is
///     taken as linear, and where two neighbours are dark no shadow ray is placed: lay them where light is, such
///     as inside a spot's cone.
/// @note 25 ns a knot.
/// @kinds !march <place
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_march_update(
    march: *mut covbeam_march,
    count: usize,
    knots: *const covbeam_march_knot,
    knot_stride: usize,
) -> covbeam_status {
    let update = |table: &mut Table| {
        enough(count)?;
        inputs!(count, knots, knot_stride);
        let mut before = f32::MIN;
        for i in 0..count {
            let knot = knots.get(i);
            let distance = finite(field!(knot, distance))?;
            if distance < before {
                return Err(
                    field!(knot, distance).is(format_args!("{distance} is below that before, {before}"))
                );
            }
            before = distance;
        }
        let (mut taken, mut cells) = (reserved(count)?, reserved(count)?);
        taken.extend((0..count).map(|i| MarchKnot::from(knots.get(i).value)));
        cells.resize(count, MarchCell::default());
        table.view = None;
        (table.knots, table.cells) = (taken, cells);
        // SAFETY: the memory of the vectors stays where it is, and is not written, until the next `update` has taken the
        // view away; the view is not handed out, and goes with the table.
        let (knots, cells) = unsafe {
            (
                slice::from_raw_parts(table.knots.as_ptr(), count),
                slice::from_raw_parts_mut(table.cells.as_mut_ptr(), count),
            )
        };
        table.view = Some(March::new(knots, cells).expect("ordered, and as many of both"));
        Ok(())
    };
    // SAFETY: by the caller's promise.
    unsafe { run_on(march, "march", update) }
}

/// What the table says before any shadow ray is traced.
///
/// @param march a march that has a table.
/// @param expected receives it.
/// @kinds @march.resolved >f:qq
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_march_get_expected(
    march: *const covbeam_march,
    expected: *mut covbeam_march_expected,
) -> covbeam_status {
    run(|| {
        let expected = Slot::new(expected, "expected")?;
        // SAFETY: by the caller's promise.
        let march = unsafe { shared(march, "march") }?;
        let march = march.view()?;
        expected.set(covbeam_march_expected {
            radiance: march.expected_radiance(),
            error: march.expected_error(),
        });
        Ok(())
    })
}

/// How many of a ray's shadow rays should be spent on a first round.
///
/// @param march a march that has a table.
/// @param rays shadow rays in all.
/// @param first receives their number; 0 = all in one round, because the expected changes are too many to be
///     found one by one. For a light with an extent one round is better whatever this says: two shadow rays to
///     different points of it differ without a border between them.
/// @kinds @march.resolved #any >size
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_march_get_first_round(
    march: *const covbeam_march,
    rays: usize,
    first: *mut usize,
) -> covbeam_status {
    run(|| {
        let first = Slot::new(first, "first")?;
        // SAFETY: by the caller's promise.
        first.set(unsafe { shared(march, "march") }?.view()?.first_round(rays));
        Ok(())
    })
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

#[cfg(test)]
#[allow(clippy::undocumented_unsafe_blocks, reason = "every argument is a local, or refused")]
mod tests {
    use super::*;
    use crate::hostile::{Rule, Rule::*, UNTOUCHED, padded, refuses, values};
    use core::ptr;

    const NO_KNOT: covbeam_march_knot = covbeam_march_knot {
        distance: UNTOUCHED,
        radiance: UNTOUCHED,
        deviation: UNTOUCHED,
        visibility: UNTOUCHED,
    };
    const NO_SAMPLE: covbeam_march_sample = covbeam_march_sample {
        distance: UNTOUCHED,
        weight: UNTOUCHED,
        visibility: UNTOUCHED,
        reserved: 9,
        mass: -7.25,
    };

    fn empty() -> *mut covbeam_march {
        let mut march = ptr::null_mut();
        assert_eq!(unsafe { covbeam_march_new(&mut march) }, COVBEAM_OK);
        march
    }

    /// As much light everywhere on 4 m of ray, all of which is expected to arrive.
    fn even() -> *mut covbeam_march {
        let knots = [1.0, 2.0, 5.0].map(|distance| covbeam_march_knot {
            distance,
            radiance: 0.5,
            visibility: 1.0,
            ..NO_KNOT
        });
        let march = empty();
        assert_eq!(unsafe { covbeam_march_update(march, 3, knots.as_ptr(), 16) }, COVBEAM_OK);
        march
    }

    #[test]
    fn a_bad_argument_is_refused_and_nothing_is_written() {
        refuses(4, &[(0.0, Across), (0.0, Across), (1.0, Along)], |bad, n| {
            let (origin, light, mut knots) = ([0.1, 0.2, 0.3], [0.4, 0.5, 0.6], [NO_KNOT; 5]);
            let (origin, direction) = (bad.at(0, origin.as_ptr()), bad.at(1, n.as_ptr()));
            let (light, to) = (bad.at(2, light.as_ptr()), bad.at_mut(3, knots.as_mut_ptr()));
            let status = unsafe { covbeam_march_lay(origin, direction, 0.5, 3.0, light, 5, to, 16) };
            (status, knots != [NO_KNOT; 5])
        });
        refuses(1, &[], |bad, _| {
            let mut out = ptr::null_mut();
            let status = unsafe { covbeam_march_new(bad.at_mut(0, &mut out)) };
            let changed = !out.is_null();
            unsafe { covbeam_march_free(out) };
            (status, changed)
        });
        // Of a knot only the distance must be a number: it may not fall, and the next lies at 2e30.
        let numbers: [(f32, Rule); 2] = [(-2.0, Finite), (2e30, From(-2.0))];
        refuses(2, &numbers, |bad, n| {
            let march = even();
            let knot = |distance| covbeam_march_knot { distance, radiance: f32::NAN, ..NO_KNOT };
            let knots = [knot(-2e30), knot(n[0]), knot(n[1])];
            let from = bad.at(1, knots.as_ptr());
            let status = unsafe { covbeam_march_update(bad.at_mut(0, march), 3, from, 16) };
            let changed = expected(march) != 2.0;
            unsafe { covbeam_march_free(march) };
            (status, changed)
        });
        let march = even();
        refuses(2, &[], |bad, _| {
            let none = covbeam_march_expected { radiance: UNTOUCHED, error: 0.0 };
            let mut out = none;
            let to = bad.at_mut(1, &mut out);
            (unsafe { covbeam_march_get_expected(bad.at(0, march), to) }, out != none)
        });
        refuses(2, &[], |bad, _| {
            let mut out = 77;
            let to = bad.at_mut(1, &mut out);
            (unsafe { covbeam_march_get_first_round(bad.at(0, march), 50, to) }, out != 77)
        });
        refuses(3, &[(0.5, Random), (0.25, Random)], |bad, n| {
            let mut out = [NO_SAMPLE; 2];
            let (jitters, to) = (bad.at(1, n.as_ptr()), bad.at_mut(2, out.as_mut_ptr()));
            let status = unsafe { covbeam_march_place(bad.at_mut(0, march), 2, jitters, 4, to, 24) };
            (status, out != [NO_SAMPLE; 2])
        });
        let numbers: [(f32, Rule); 4] =
            [(0.5, Random), (2.0, Finite), (1.0, FiniteNotNegative), (0.5, FiniteNotNegative)];
        refuses(4, &numbers, |bad, n| {
            let first = covbeam_march_sample {
                distance: n[1],
                weight: n[2],
                visibility: 0.5,
                reserved: 0,
                mass: f64::from(n[3]),
            };
            let mut out = [NO_SAMPLE; 2];
            let (firsts, jitter) = (bad.at(1, &first), bad.at(2, n.as_ptr()));
            let to = bad.at_mut(3, out.as_mut_ptr());
            let status =
                unsafe { covbeam_march_refine(bad.at_mut(0, march), 1, firsts, 0, 2, jitter, 0, to, 24) };
            (status, out != [NO_SAMPLE; 2])
        });
        unsafe { covbeam_march_free(march) };
    }

    fn expected(march: *mut covbeam_march) -> f32 {
        let mut out = covbeam_march_expected { radiance: 0.0, error: 0.0 };
        assert_eq!(unsafe { covbeam_march_get_expected(march, &mut out) }, COVBEAM_OK);
        out.radiance
    }

    #[test]
    fn a_stretch_that_is_none_and_a_light_beyond_numbers_are_refused() {
        let mut knots = [NO_KNOT; 2];
        let lay = |from, to, light: f32, count, knots: &mut [covbeam_march_knot; 2]| {
            let (origin, direction, light) = ([0.0; 3], [0.0, 0.0, 1.0], [light, 0.0, 0.0]);
            let (o, d, l) = (origin.as_ptr(), direction.as_ptr(), light.as_ptr());
            unsafe { covbeam_march_lay(o, d, from, to, l, count, knots.as_mut_ptr(), 16) }
        };
        for (from, to, light) in [
            (f32::NAN, 1.0, 1.0),
            (f32::NEG_INFINITY, 1.0, 1.0),
            (1.0, 0.5, 1.0),
            (1.0, f32::NAN, 1.0),
            (0.0, 1.0, f32::NAN),
            (0.0, 1.0, 3e38),
        ] {
            assert_eq!(lay(from, to, light, 2, &mut knots), COVBEAM_INVALID_VALUE, "{from} {to} {light}");
        }
        for count in [0, 1] {
            assert_eq!(lay(0.0, 1.0, 1.0, count, &mut knots), COVBEAM_SHORT_BUFFER);
        }
        assert_eq!(knots, [NO_KNOT; 2]);
        assert_eq!(lay(-1.0, f32::INFINITY, 1.0, 2, &mut knots), COVBEAM_OK);
        assert_eq!(knots[0].distance, -1.0);
        assert!(knots[1].distance >= 1000.0 && knots[1].radiance == 0.0 && knots[1].visibility.is_nan());
    }

    #[test]
    fn a_march_without_a_table_comes_too_early() {
        let march = empty();
        let mut expected = covbeam_march_expected { radiance: UNTOUCHED, error: 0.0 };
        let (mut first, mut out) = (77, NO_SAMPLE);
        let statuses = unsafe {
            [
                covbeam_march_get_expected(march, &mut expected),
                covbeam_march_get_first_round(march, 9, &mut first),
                covbeam_march_place(march, 1, &0.5, 0, &mut out, 0),
                covbeam_march_refine(march, 0, ptr::null(), 0, 1, &0.5, 0, &mut out, 0),
            ]
        };
        assert_eq!(statuses, [COVBEAM_WRONG_ORDER; 4]);
        assert_eq!((expected.radiance, first, out), (UNTOUCHED, 77, NO_SAMPLE));
        unsafe { covbeam_march_free(march) };
    }

    #[test]
    fn two_rounds_find_a_shadow_and_measure_it() {
        // Even light on 8 m of which the last 5.3 lie in shadow: 2.7 x 0.5. Laid from far away, knots are even.
        let (origin, direction, light) = ([0.0; 3], [0.0, 0.0, 1.0], [1e4, 0.0, 0.0]);
        let mut knots = padded(&[NO_KNOT; 33]);
        let stride = size_of_val(&knots[0]);
        let march = empty();
        let mut first = padded(&[NO_SAMPLE; 8]);
        let mut second = padded(&[NO_SAMPLE; 24]);
        let sample_stride = size_of_val(&first[0]);
        unsafe {
            let (o, d, l) = (origin.as_ptr(), direction.as_ptr(), light.as_ptr());
            let to = &raw mut knots[0].value;
            assert_eq!(covbeam_march_lay(o, d, 0.0, 8.0, l, 33, to, stride), COVBEAM_OK);
            for knot in &mut knots {
                knot.value.radiance = 0.5;
            }
            assert_eq!(covbeam_march_update(march, 33, &knots[0].value, stride), COVBEAM_OK);
            // Half of it is expected to arrive, where nothing is known.
            assert!((expected(march) - 2.0).abs() < 1e-6);
            let to = &raw mut first[0].value;
            assert_eq!(covbeam_march_place(march, 8, &0.5, 0, to, sample_stride), COVBEAM_OK);
            for sample in &mut first {
                sample.value.visibility = if sample.value.distance < 2.7 { 1.0 } else { 0.0 };
            }
            let (from, to) = (&raw const first[0].value, &raw mut second[0].value);
            let status = covbeam_march_refine(march, 8, from, sample_stride, 24, &0.5, 0, to, sample_stride);
            assert_eq!(status, COVBEAM_OK);
        }
        let seen = |round: &[covbeam_march_sample]| -> f32 {
            round.iter().filter(|s| s.distance < 2.7).map(|s| 0.5 * s.weight).sum()
        };
        // Half a stratum, 0.5 m x 0.5, is what one round can be off by; the second has strata of a fifth at the border.
        assert!((seen(&values(&first)) - 1.35).abs() <= 0.25);
        assert!((seen(&values(&second)) - 1.35).abs() <= 0.05, "{}", seen(&values(&second)));
        assert!(values(&second).iter().all(|s| s.reserved == 0 && s.visibility == 0.0));
        unsafe { covbeam_march_free(march) };
    }

    #[test]
    fn a_second_round_after_none_is_a_first_one() {
        let (march, jitters) = (even(), [0.1, 0.9, 0.4]);
        let (mut one, mut two) = ([NO_SAMPLE; 3], [NO_SAMPLE; 3]);
        let statuses = unsafe {
            [
                covbeam_march_place(march, 3, jitters.as_ptr(), 4, one.as_mut_ptr(), 24),
                covbeam_march_refine(march, 0, ptr::null(), 0, 3, jitters.as_ptr(), 4, two.as_mut_ptr(), 24),
            ]
        };
        assert_eq!((statuses, one), ([COVBEAM_OK; 2], two));
        assert_ne!(one, [NO_SAMPLE; 3]);
        unsafe { covbeam_march_free(march) };
    }
}
