//! Pairs of an eye ray and a beam, for hosts with a hierarchy of their own.

use crate::check::{not_negative, positive};
use crate::column::{column, covbeam_column};
use crate::grid::covbeam_grid;
use crate::kernel::{self, covbeam_kernel};
use crate::medium::{self, covbeam_medium};
use crate::memory::{Element, Inputs, Slot, inputs, outputs, read};
use crate::status::{Failure, covbeam_status, covbeam_status::*, fail, run};
use crate::types::{
    beam, covbeam_beam, covbeam_crossing, covbeam_eye_ray, covbeam_gathered, eye_ray, gathered,
};
use core::ptr;
use covbeam_core::{BLOCK, BeamBlock, Column, Density, EyeRay, Gathered, PLACES, cross, gather_pair};
use glam::Vec3;

unsafe fn read_ray(pointer: *const covbeam_eye_ray) -> Result<EyeRay, Failure> {
    // SAFETY: by the caller's promise.
    eye_ray(Element::single(unsafe { read(pointer, "ray") }?, "ray"))
}

/// Closest approach of an eye ray's line and a beam's line.
///
/// @param ray the eye ray; its length does not matter.
/// @param count number of beams; with 0 nothing is done.
/// @param beams, beam_stride the beam; its length does not matter.
/// @param crossings, crossing_stride the closest approach; untouched if they are nearly parallel.
/// @param crosses, cross_stride 1, or 0 if the sine of the angle between them is below 1e-5: the crossing
///     would be rounding. (covbeam_gather_pair needs none below .05.)
/// @kinds <ray <beam >crossing >flag
/// @single covbeam_cross
/// @extra
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_cross_many(
    ray: *const covbeam_eye_ray,
    count: usize,
    beams: *const covbeam_beam,
    beam_stride: usize,
    crossings: *mut covbeam_crossing,
    crossing_stride: usize,
    crosses: *mut u8,
    cross_stride: usize,
) -> covbeam_status {
    run(|| {
        // SAFETY: by the caller's promise.
        let ray = unsafe { read_ray(ray) }?;
        inputs!(count, beams, beam_stride);
        outputs!(count, crossings, crossing_stride);
        outputs!(count, crosses, cross_stride);
        for i in 0..count {
            beam(beams.get(i))?;
        }
        for i in 0..count {
            let crossing = cross(&ray, &beam(beams.get(i))?);
            crosses.set(i, u8::from(crossing.is_some()));
            if let Some(crossing) = crossing {
                crossings.set(i, crossing.into());
            }
        }
        Ok(())
    })
}

/// Without the host's column: that of a closed form.
fn closed_form(
    density: &Density,
    origin: Vec3,
    direction: Vec3,
    name: &str,
) -> Result<Column<'static>, Failure> {
    if let Density::Grid(_) = density {
        let message =
            format_args!("{name}: NULL, but voxels have no closed form; make one by covbeam_medium_column");
        return Err(fail(COVBEAM_NULL_POINTER, message));
    }
    Ok(density.column(origin, direction, &[]))
}

/// Gathers one beam, and adds it to what the eye ray has gathered: scattering x phase function x transmittance
/// along both x flux of the beam x kernel(gap) / sin(angle), if the gap is less than the kernel's radius,
/// looked up on the eye ray. Where that sine is below .05 it is the integral along the eye ray of a kernel on
/// both axes across the beam, finite down to parallel pairs, from eight places.
///
/// @param ray the eye ray.
/// @param count number of beams; with 0 nothing is done.
/// @param beams, beam_stride the beam, in the same medium.
/// @param froms, from_stride, tos, to_stride part of the beam that counts [m] >= 0, [from, to): 0 and the
///     beam's length, or more, for all of it. Cutting a beam into adjoining parts changes nothing.
/// @param medium that both lie in.
/// @param ray_column along the ray; NULL takes the closed form (voxels have none: COVBEAM_NULL_POINTER).
/// @param beam_columns, beam_column_stride along the beams; NULL likewise, for all of them.
/// @param kernel the kernel of the pass.
/// @param grid as in covbeam_kernel_radius_at.
/// @param gathered in and out, one for all beams, added in their order: finite numbers, all 0 to begin with.
///     Its pairs need room for eight a beam.
/// @param accepted, accepted_stride 1 if the pair counts, else 0.
/// @note Thesis 5.3.4. A beam that starts or ends on a surface is cut by its tangent plane. The order of the
///     columns' knots is not checked.
/// @kinds <ray <beam <f:p <f:p <medium <column? <column? <kernel @grid.resolved? =gathered >flag
/// @single covbeam_gather_pair
/// @extra
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_gather_pairs(
    ray: *const covbeam_eye_ray,
    count: usize,
    beams: *const covbeam_beam,
    beam_stride: usize,
    froms: *const f32,
    from_stride: usize,
    tos: *const f32,
    to_stride: usize,
    medium: *const covbeam_medium,
    ray_column: *const covbeam_column,
    beam_columns: *const covbeam_column,
    beam_column_stride: usize,
    kernel: *const covbeam_kernel,
    grid: *const covbeam_grid,
    gathered: *mut covbeam_gathered,
    accepted: *mut u8,
    accepted_stride: usize,
) -> covbeam_status {
    run(|| {
        // SAFETY: by the caller's promise.
        let ray = unsafe { read_ray(ray) }?;
        inputs!(count, beams, beam_stride);
        inputs!(count, froms, from_stride);
        inputs!(count, tos, to_stride);
        // SAFETY: by the caller's promise.
        let medium = unsafe { medium::read(medium, "medium") }?;
        // SAFETY: by the caller's promise.
        let kernel = unsafe { kernel::read(kernel, grid) }?;
        // SAFETY: by the caller's promise.
        let mut sum: Gathered =
            self::gathered(Element::single(unsafe { read(gathered, "gathered") }?, "gathered"))?;
        let most = count.checked_mul(PLACES).and_then(|most| u32::try_from(most).ok());
        if most.and_then(|most| sum.pairs.checked_add(most)).is_none() {
            let message =
                format_args!("gathered: {} pairs, no room to count {count} x {PLACES} more", sum.pairs);
            return Err(fail(COVBEAM_INVALID_VALUE, message));
        }
        let out = Slot::new(gathered, "gathered")?;
        outputs!(count, accepted, accepted_stride);
        let ray_column = if ray_column.is_null() {
            closed_form(&medium.density, ray.origin, ray.direction, "ray_column")?
        } else {
            // SAFETY: by the caller's promise.
            unsafe { column(Element::single(read(ray_column, "ray_column")?, "ray_column")) }?
        };
        let given = !beam_columns.is_null();
        let none = covbeam_column::from(Column::Uniform);
        let (first, stride) =
            if given { (beam_columns, beam_column_stride) } else { (ptr::from_ref(&none), 0) };
        // SAFETY: by the caller's promise, or the one above.
        let beam_columns = unsafe { Inputs::new(first, stride, count, "beam_columns") }?;
        let arguments = |i| {
            let beam = beam(beams.get(i))?;
            let along = if given {
                // SAFETY: by the caller's promise.
                unsafe { column(beam_columns.get(i)) }?
            } else {
                closed_form(&medium.density, beam.origin, beam.direction, "beam_columns")?
            };
            Ok((beam, not_negative(froms.get(i))?, not_negative(tos.get(i))?, along))
        };
        for i in 0..count {
            arguments(i)?;
        }
        for i in 0..count {
            let (beam, from, to, along) = arguments(i)?;
            let columns = [ray_column, along];
            let found = gather_pair(&ray, &beam, [from, to], &medium, &columns, &kernel, &mut sum);
            accepted.set(i, u8::from(found));
        }
        out.set(sum.into());
        Ok(())
    })
}

/// Which of many beams an eye ray may be paired with: eight at a time, without looking at grid or surfaces.
/// Errs towards accepting: covbeam_gather_pair refuses every beam that it
/// refuses.
///
/// @param ray the eye ray.
/// @param count number of beams; with 0 nothing is done.
/// @param beams, beam_stride the beams, each as a whole.
/// @param max_radius largest kernel radius [m] > 0: that of the covbeam_kernel.
/// @param masks, mask_stride 1 for a beam that may come within the max_radius, else 0.
/// @kinds <ray <beam $+ >flag
/// @extra
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_filter_beams(
    ray: *const covbeam_eye_ray,
    count: usize,
    beams: *const covbeam_beam,
    beam_stride: usize,
    max_radius: f32,
    masks: *mut u8,
    mask_stride: usize,
) -> covbeam_status {
    run(|| {
        // SAFETY: by the caller's promise.
        let ray = unsafe { read_ray(ray) }?;
        inputs!(count, beams, beam_stride);
        let max_radius = positive(Element::single(max_radius, "max_radius"))?;
        outputs!(count, masks, mask_stride);
        for i in 0..count {
            beam(beams.get(i))?;
        }
        let mut block = BeamBlock::EMPTY;
        for first in (0..count).step_by(BLOCK) {
            let filled = BLOCK.min(count - first);
            for slot in 0..filled {
                let beam = beam(beams.get(first + slot))?;
                block.set(slot, &beam, 0.0, beam.length);
            }
            block.clear_from(filled);
            let hit = block.test(&ray, max_radius);
            for slot in 0..filled {
                masks.set(first + slot, (hit >> slot & 1) as u8);
            }
        }
        Ok(())
    })
}

#[cfg(test)]
#[allow(clippy::undocumented_unsafe_blocks, reason = "every argument is a local, or refused")]
mod tests {
    use super::*;
    use crate::column::{covbeam_medium_column, covbeam_medium_tabulate};
    use crate::hostile::{Rule, Rule::*, UNTOUCHED, padded, refuses, values};
    use crate::medium::samples::{Smoke, fog, haze, smoke};
    use crate::types::covbeam_knot;

    const Z: [f32; 3] = [0.0, 0.0, 1.0];

    fn ray_of(n: &[f32]) -> covbeam_eye_ray {
        covbeam_eye_ray { origin: [n[0], n[1], n[2]], direction: [n[3], n[4], n[5]], length: n[6] }
    }

    fn beam_of(n: &[f32]) -> covbeam_beam {
        let three = |i: usize| [n[i], n[i + 1], n[i + 2]];
        covbeam_beam {
            origin: three(0),
            direction: three(3),
            length: n[6],
            power: three(7),
            start_normal: three(10),
            end_normal: three(13),
        }
    }

    /// Along z, through the middle of the unit cube.
    const RAY: [(f32, Rule); 7] = [
        (0.4, Finite),
        (0.5, Finite),
        (-1.0, Finite),
        (0.0, Across),
        (0.0, Across),
        (1.0, Along),
        (3.0, NotNegative),
    ];

    /// Along x, past it.
    const BEAM: [(f32, Rule); 16] = [
        (-1.0, Finite),
        (0.55, Finite),
        (0.4, Finite),
        (1.0, Along),
        (0.0, Across),
        (0.0, Across),
        (3.0, FiniteNotNegative),
        (1.0, Finite),
        (2.0, Finite),
        (3.0, Finite),
        (1.0, Along0),
        (0.0, Across),
        (0.0, Across),
        // None, or a unit vector.
        (0.0, Along0),
        (0.0, Along0),
        (0.0, Along0),
    ];

    fn plain(numbers: &[(f32, Rule)]) -> Vec<f32> {
        numbers.iter().map(|(value, _)| *value).collect()
    }

    fn ray() -> covbeam_eye_ray {
        ray_of(&plain(&RAY))
    }

    /// Beams at many heights and slants: some near the ray, some far, one along it.
    fn beams() -> Vec<covbeam_beam> {
        let good = beam_of(&plain(&BEAM));
        (0..19)
            .map(|i| {
                let i = i as f32;
                let (sine, cosine) = (0.1 * i - 0.9).sin_cos();
                let origin = [-1.0, 0.3 + 0.02 * i, 0.1 * i - 0.5];
                let direction = if i == 7.0 { Z } else { [cosine, 0.0, sine] };
                covbeam_beam { origin, direction, start_normal: [0.0; 3], ..good }
            })
            .collect()
    }

    fn kernel() -> covbeam_kernel {
        let struct_size = size_of::<covbeam_kernel>() as u32;
        covbeam_kernel { struct_size, shape: 1, min_radius: 0.1, max_radius: 0.1, error: 0.1 }
    }

    const NOTHING: covbeam_gathered =
        covbeam_gathered { radiance: [0.0; 3], pairs: 0, weight: 0.0, radius: 0.0, sigma: 0.0 };

    /// The column from an origin through the smoke; its knots are never freed.
    fn column_in(smoke: &Smoke, origin: [f32; 3], direction: [f32; 3]) -> covbeam_column {
        let (o, d) = (origin.as_ptr(), direction.as_ptr());
        let knots = Box::leak(Box::new([covbeam_knot { distance: 0.0, column: 0.0 }; 400]));
        let (mut count, mut column) = (0, covbeam_column::from(Column::Uniform));
        let statuses = unsafe {
            [
                covbeam_medium_tabulate(&smoke.medium, o, d, 9.0, knots.as_mut_ptr(), 400, &mut count),
                covbeam_medium_column(&smoke.medium, o, d, knots.as_ptr(), count, &mut column),
            ]
        };
        assert_eq!(statuses, [COVBEAM_OK; 2]);
        column
    }

    #[test]
    fn a_bad_argument_of_a_crossing_is_refused_and_nothing_is_written() {
        let none = covbeam_crossing {
            ray_distance: UNTOUCHED,
            beam_distance: UNTOUCHED,
            gap: UNTOUCHED,
            sin_theta: UNTOUCHED,
            axis: [UNTOUCHED; 3],
        };
        refuses(4, &[&RAY[..], &BEAM[..]].concat(), |bad, n| {
            let (ray, beam) = (ray_of(n), beam_of(&n[7..]));
            let (mut crossing, mut crosses) = (none, 77);
            let status = unsafe {
                let to = bad.at_mut(2, &mut crossing);
                covbeam_cross_many(
                    bad.at(0, &ray),
                    1,
                    bad.at(1, &beam),
                    0,
                    to,
                    0,
                    bad.at_mut(3, &mut crosses),
                    0,
                )
            };
            (status, crosses != 77 || crossing.gap.to_bits() != UNTOUCHED.to_bits())
        });
        let along = covbeam_beam { direction: Z, ..beams()[0] };
        let (mut crossing, mut crosses) = (none, 77);
        let status = unsafe { covbeam_cross_many(&ray(), 1, &along, 0, &mut crossing, 0, &mut crosses, 0) };
        assert_eq!((status, crossing, crosses), (COVBEAM_OK, none, 0));
    }

    #[test]
    fn a_bad_argument_of_a_pair_is_refused_and_nothing_is_written() {
        let smoke = smoke();
        let rest = [
            (0.0, NotNegative),
            (3.0, NotNegative),
            (0.5, Finite),
            (0.5, Finite),
            (0.5, Finite),
            (0.5, Finite),
            (0.5, Finite),
            (0.5, Finite),
        ];
        let numbers = [&RAY[..], &BEAM[..], &rest[..]].concat();
        let ray_column = column_in(&smoke, ray().origin, Z);
        let beam_column = column_in(&smoke, [-1.0, 0.55, 0.4], [1.0, 0.0, 0.0]);
        // The columns may be NULL in the first two media, but not misaligned.
        for (medium, pointers) in [(fog(), 6), (haze(), 6), (smoke.medium, 8)] {
            refuses(pointers, &numbers, |bad, n| {
                let (ray, beam, kernel) = (ray_of(n), beam_of(&n[7..]), kernel());
                let before = covbeam_gathered {
                    radiance: [n[25], n[26], n[27]],
                    pairs: 1,
                    weight: n[28],
                    radius: n[29],
                    sigma: n[30],
                };
                let (mut gathered, mut accepted) = (before, 77);
                let status = unsafe {
                    covbeam_gather_pairs(
                        bad.at(0, &ray),
                        1,
                        bad.at(1, &beam),
                        0,
                        &n[23],
                        0,
                        &n[24],
                        0,
                        bad.at(2, &medium),
                        bad.at(6, &ray_column),
                        bad.at(7, &beam_column),
                        0,
                        bad.at(3, &kernel),
                        ptr::null(),
                        bad.at_mut(4, &mut gathered),
                        bad.at_mut(5, &mut accepted),
                        0,
                    )
                };
                (status, accepted != 77 || gathered.pairs != 1)
            });
        }
        let mut full = covbeam_gathered { pairs: u32::MAX, ..NOTHING };
        let mut accepted = 77;
        let status = unsafe {
            let none = ptr::null();
            let (ray, beam) = (ray(), beam_of(&plain(&BEAM)));
            covbeam_gather_pairs(
                &ray,
                1,
                &beam,
                0,
                &0.0,
                0,
                &3.0,
                0,
                &fog(),
                none,
                none,
                0,
                &kernel(),
                ptr::null(),
                &mut full,
                &mut accepted,
                0,
            )
        };
        assert_eq!((status, full.pairs, accepted), (COVBEAM_INVALID_VALUE, u32::MAX, 77));
    }

    #[test]
    fn a_bad_argument_of_the_filter_is_refused_and_nothing_is_written() {
        refuses(3, &[&RAY[..], &BEAM[..], &[(0.1, Positive)]].concat(), |bad, n| {
            let (ray, beam, mut mask) = (ray_of(n), beam_of(&n[7..]), 77);
            let to = bad.at_mut(2, &mut mask);
            let status =
                unsafe { covbeam_filter_beams(bad.at(0, &ray), 1, bad.at(1, &beam), 0, n[23], to, 0) };
            (status, mask != 77)
        });
    }

    #[test]
    fn many_are_the_same_bits_as_one_each_and_the_filter_keeps_all_that_count() {
        let smoke = smoke();
        let beams = padded(&beams());
        let stride = size_of_val(&beams[0]);
        let count = beams.len();
        let none = ptr::null::<covbeam_column>();
        let ray_column = column_in(&smoke, ray().origin, Z);
        let beam_columns: Vec<_> =
            values(&beams).iter().map(|beam| column_in(&smoke, beam.origin, beam.direction)).collect();
        let mut masks = padded(&vec![77_u8; count]);
        let status = unsafe {
            covbeam_filter_beams(&ray(), count, &beams[0].value, stride, 0.1, &mut masks[0].value, 16)
        };
        assert_eq!(status, COVBEAM_OK);
        for medium in [fog(), haze(), smoke.medium] {
            let voxels = medium.density == smoke.medium.density;
            let mut all = NOTHING;
            let mut accepted = vec![77_u8; count];
            let (r, b) = if voxels { (&raw const ray_column, beam_columns.as_ptr()) } else { (none, none) };
            let status = unsafe {
                covbeam_gather_pairs(
                    &ray(),
                    count,
                    &beams[0].value,
                    stride,
                    &0.0,
                    0,
                    &f32::INFINITY,
                    0,
                    &medium,
                    r,
                    b,
                    size_of::<covbeam_column>(),
                    &kernel(),
                    ptr::null(),
                    &mut all,
                    accepted.as_mut_ptr(),
                    1,
                )
            };
            assert_eq!(status, COVBEAM_OK);
            let mut sum = NOTHING;
            for (i, beam) in values(&beams).iter().enumerate() {
                let mut one = 77;
                let status = unsafe {
                    let along = if voxels { &raw const beam_columns[i] } else { none };
                    let (ray, kernel) = (ray(), kernel());
                    covbeam_gather_pairs(
                        &ray,
                        1,
                        beam,
                        0,
                        &0.0,
                        0,
                        &f32::INFINITY,
                        0,
                        &medium,
                        r,
                        along,
                        0,
                        &kernel,
                        ptr::null(),
                        &mut sum,
                        &mut one,
                        0,
                    )
                };
                assert_eq!((status, one), (COVBEAM_OK, accepted[i]));
                assert!(one == 0 || values(&masks)[i] == 1, "the filter loses beam {i}");
            }
            assert_eq!(sum, all);
            assert!(all.pairs > 0 && all.radiance[0] > 0.0);
        }
        let passed = values(&masks).iter().filter(|mask| **mask == 1).count();
        assert!(passed > 0 && passed < count, "{passed} of {count}");
    }

    #[test]
    fn many_crossings_are_the_same_bits_as_one_each() {
        let beams = beams();
        let none = covbeam_crossing {
            ray_distance: UNTOUCHED,
            beam_distance: UNTOUCHED,
            gap: UNTOUCHED,
            sin_theta: UNTOUCHED,
            axis: [UNTOUCHED; 3],
        };
        let mut crossings = padded(&vec![none; beams.len()]);
        let mut crosses = vec![77_u8; beams.len()];
        let stride = size_of_val(&crossings[0]);
        let status = unsafe {
            let (from, size) = (beams.as_ptr(), size_of::<covbeam_beam>());
            let to = &raw mut crossings[0].value;
            covbeam_cross_many(&ray(), beams.len(), from, size, to, stride, crosses.as_mut_ptr(), 1)
        };
        assert_eq!(status, COVBEAM_OK);
        for (i, found) in values(&crossings).into_iter().enumerate() {
            let (mut one, mut flag) = (none, 77);
            let status = unsafe { covbeam_cross_many(&ray(), 1, &beams[i], 0, &mut one, 0, &mut flag, 0) };
            assert_eq!((status, one, flag), (COVBEAM_OK, found, crosses[i]));
        }
        assert_eq!((crosses[7], crosses[0]), (0, 1));
    }

    #[test]
    fn voxels_without_columns_are_refused_with_the_remedy() {
        let smoke = smoke();
        let (mut gathered, mut accepted) = (NOTHING, 77);
        let column = column_in(&smoke, ray().origin, Z);
        let (r, none) = (&raw const column, ptr::null());
        for (ray_column, beam_column) in [(none, r), (r, none), (none, none)] {
            let status = unsafe {
                let (ray, beam, kernel) = (ray(), beam_of(&plain(&BEAM)), kernel());
                covbeam_gather_pairs(
                    &ray,
                    1,
                    &beam,
                    0,
                    &0.0,
                    0,
                    &3.0,
                    0,
                    &smoke.medium,
                    ray_column,
                    beam_column,
                    0,
                    &kernel,
                    ptr::null(),
                    &mut gathered,
                    &mut accepted,
                    0,
                )
            };
            assert_eq!((status, gathered, accepted), (COVBEAM_NULL_POINTER, NOTHING, 77));
            let message = unsafe { core::ffi::CStr::from_ptr(crate::status::covbeam_last_error()) };
            assert!(message.to_str().unwrap().contains("covbeam_medium_column"));
        }
    }
}
