//! Guides of a lamp's emission: the warp of a path's first numbers to where light is worth more.

use crate::arrays::each;
use crate::check::{finite_not_negative, random_pair};
use crate::heap::reserved;
use crate::memory::{array, inputs, outputs};
use crate::status::{Failure, covbeam_status, covbeam_status::*, fail, run};
use covbeam_core::EmissionGuide;

/// Refuses another count than a guide of `side` x `side` cells has.
fn fits(name: &str, given: usize, side: u32, columns: u64) -> Result<(), Failure> {
    if side == 0 {
        return Err(fail(COVBEAM_INVALID_VALUE, format_args!("side: 0 is not >= 1")));
    }
    if u64::from(side) * columns != given as u64 {
        let message = format_args!("{name}: {given}, but it takes {side} x {columns}");
        return Err(fail(COVBEAM_SHORT_BUFFER, message));
    }
    Ok(())
}

/// Writes a guide of a lamp's emission: a warp of the unit square in which the place and direction of its light
/// are drawn, that sends more paths where they are worth more. What is stratified in the square stays so.
///
/// @param side the guide has side x side cells of the square, >= 1.
/// @param weights, weight_count what light that leaves through each cell is worth, such as the mean of
///     covbeam_importance_of_segments over some of its rays; side x side numbers, the second coordinate of the
///     square running fastest, finite and >= 0. Their scale does not matter.
/// @param even share of the paths that go everywhere alike, in (0, 1], and at least 1e-37 a cell: no more than
///     1/even times its own power has any path, however wrong the weights are. Where all weights are 0, all do.
/// @param guide, guide_count receives the guide: side x (side + 1) numbers.
/// @kinds #side <f:q k $L >f:t k
/// @extra
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_emission_guide_fill(
    side: u32,
    weights: *const f32,
    weight_count: usize,
    even: f32,
    guide: *mut f32,
    guide_count: usize,
) -> covbeam_status {
    run(|| {
        fits("weight_count", weight_count, side, side.into())?;
        fits("guide_count", guide_count, side, u64::from(side) + 1)?;
        inputs!(weight_count, weights, size_of::<f32>());
        outputs!(guide_count, guide, size_of::<f32>());
        let (mut worths, mut numbers) = (reserved(weight_count)?, reserved(guide_count)?);
        for i in 0..weight_count {
            worths.push(finite_not_negative(weights.get(i))?);
        }
        numbers.resize(guide_count, 0.0);
        // Of what is checked above, only this is left.
        EmissionGuide::fill(side as usize, &worths, even, &mut numbers).map_err(|_| {
            let message = format_args!("even: {even} is not in (0, 1], or less than 1e-37 a cell");
            fail(COVBEAM_INVALID_VALUE, message)
        })?;
        for (i, number) in numbers.into_iter().enumerate() {
            guide.set(i, number);
        }
        Ok(())
    })
}

/// The guide in the host's memory, if it is one: shares that add up in each of its lines.
unsafe fn read_guide<'a>(side: u32, guide: *const f32, count: usize) -> Result<EmissionGuide<'a>, Failure> {
    fits("guide_count", count, side, u64::from(side) + 1)?;
    // SAFETY: by the caller's promise.
    let numbers = unsafe { array(guide, count, "guide") }?;
    let side = side as usize;
    for (line, shares) in numbers.chunks(side).enumerate() {
        let mut before = 0.0;
        for (i, &share) in shares.iter().enumerate() {
            let rises = share >= before && if i + 1 < side { share <= 1.0 } else { share == 1.0 };
            if !rises {
                let message = format_args!(
                    "guide[{}]: {share} is not what covbeam_emission_guide_fill writes",
                    line * side + i
                );
                return Err(fail(COVBEAM_INVALID_VALUE, message));
            }
            before = share;
        }
    }
    Ok(EmissionGuide::new(side, numbers).expect("as many numbers as a guide has"))
}

/// Where points of the unit square go, and how dense they are there.
///
/// @param side as it was for covbeam_emission_guide_fill.
/// @param guide, guide_count what it has written: all of it is looked at once a call.
/// @param count number of points; with 0 nothing is done.
/// @param points, point_stride pairs of numbers in [0, 1), such as covbeam_path_numbers of dimensions 0 and 1.
/// @param places, place_stride receive where they go: pairs of numbers in [0, 1), with which the lamp's place and
///     direction are drawn.
/// @param densities, density_stride receive the density of points there, whose mean over the square is 1, and
///     which is at least `even`: divide the path's power by it.
/// @kinds #side <f:E k <f:rr >f:rr >f:+
/// @extra
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_emission_guide_warp(
    side: u32,
    guide: *const f32,
    guide_count: usize,
    count: usize,
    points: *const f32,
    point_stride: usize,
    places: *mut f32,
    place_stride: usize,
    densities: *mut f32,
    density_stride: usize,
) -> covbeam_status {
    run(|| {
        // SAFETY: by the caller's promise.
        let guide = unsafe { read_guide(side, guide, guide_count) }?;
        inputs!(count, points: [f32; 2], point_stride);
        outputs!(count, places: [f32; 2], place_stride);
        outputs!(count, densities, density_stride);
        each(
            count,
            |i| random_pair(points.get(i)),
            |i, point| {
                let (place, density) = guide.warp(point);
                places.set(i, place);
                densities.set(i, density);
            },
        )
    })
}

#[cfg(test)]
#[allow(clippy::undocumented_unsafe_blocks, reason = "every argument is a local, or refused")]
mod tests {
    use super::*;
    use crate::hostile::{Rule::*, UNTOUCHED, padded, refuses, values};

    #[test]
    fn a_bad_argument_of_a_guide_is_refused_and_nothing_is_written() {
        let numbers = [
            (1.0, FiniteNotNegative),
            (0.5, FiniteNotNegative),
            (0.0, FiniteNotNegative),
            (3.0, FiniteNotNegative),
        ];
        refuses(2, &numbers, |bad, weights| {
            let mut guide = [UNTOUCHED; 6];
            let (from, to) = (bad.at(0, weights.as_ptr()), bad.at_mut(1, guide.as_mut_ptr()));
            let status = unsafe { covbeam_emission_guide_fill(2, from, 4, 0.25, to, 6) };
            (status, guide != [UNTOUCHED; 6])
        });
        let fill = |side, weights, even, numbers| {
            let mut guide = [UNTOUCHED; 6];
            let to = guide.as_mut_ptr();
            let status =
                unsafe { covbeam_emission_guide_fill(side, [1.0; 4].as_ptr(), weights, even, to, numbers) };
            assert_eq!(status == COVBEAM_OK, guide != [UNTOUCHED; 6]);
            status
        };
        assert_eq!(fill(2, 4, 1.0, 6), COVBEAM_OK);
        assert_eq!(fill(0, 0, 1.0, 0), COVBEAM_INVALID_VALUE);
        for (weights, numbers) in [(3, 6), (4, 5), (usize::MAX, 6), (4, usize::MAX)] {
            assert_eq!(fill(2, weights, 1.0, numbers), COVBEAM_SHORT_BUFFER);
        }
        assert_eq!(fill(u32::MAX, 4, 1.0, 6), COVBEAM_SHORT_BUFFER);
        for even in [0.0, -0.5, 1.5, f32::NAN, f32::INFINITY, 1e-45] {
            assert_eq!(fill(2, 4, even, 6), COVBEAM_INVALID_VALUE, "{even}");
        }
        let guide = [0.5, 1.0, 0.25, 1.0, 0.5, 1.0];
        refuses(4, &[(0.25, Random), (0.75, Random)], |bad, point| {
            let (mut place, mut density) = ([UNTOUCHED; 2], UNTOUCHED);
            let (from, point) = (bad.at(0, guide.as_ptr()), bad.at(1, point.as_ptr()));
            let (to, dense) = (bad.at_mut(2, place.as_mut_ptr()), bad.at_mut(3, &mut density));
            let status = unsafe { covbeam_emission_guide_warp(2, from, 6, 1, point, 0, to, 0, dense, 0) };
            (status, place != [UNTOUCHED; 2] || density != UNTOUCHED)
        });
        for (index, share) in [(0, f32::NAN), (0, -0.5), (1, 0.75), (2, 1.5), (3, f32::INFINITY), (5, 0.25)] {
            let (mut wrong, mut place, mut density) = (guide, [UNTOUCHED; 2], UNTOUCHED);
            wrong[index] = share;
            let status = unsafe {
                let to = place.as_mut_ptr();
                covbeam_emission_guide_warp(
                    2,
                    wrong.as_ptr(),
                    6,
                    1,
                    [0.5; 2].as_ptr(),
                    0,
                    to,
                    0,
                    &mut density,
                    0,
                )
            };
            assert_eq!(
                (status, place, density),
                (COVBEAM_INVALID_VALUE, [UNTOUCHED; 2], UNTOUCHED),
                "{index}"
            );
        }
    }

    #[test]
    fn a_guide_is_that_of_the_core() {
        let weights = [0.0, 1.0, 7.0, 0.5, 0.0, 0.0, 0.0, 2.0, 3.0];
        let (mut core, mut guide) = ([0.0; 12], [UNTOUCHED; 12]);
        let expected = EmissionGuide::fill(3, &weights, 0.1, &mut core).unwrap();
        let points = padded(&[[0.0, 0.0], [0.3, 0.9], [0.999, 0.5]]);
        let (mut places, mut densities) = (padded(&[[UNTOUCHED; 2]; 3]), padded(&[UNTOUCHED; 3]));
        let statuses = unsafe {
            let filled = covbeam_emission_guide_fill(3, weights.as_ptr(), 9, 0.1, guide.as_mut_ptr(), 12);
            let (from, step) = (points[0].value.as_ptr(), size_of_val(&points[0]));
            let (to, stride) = (places[0].value.as_mut_ptr(), size_of_val(&places[0]));
            let (dense, beside) = (&raw mut densities[0].value, size_of_val(&densities[0]));
            let warped =
                covbeam_emission_guide_warp(3, guide.as_ptr(), 12, 3, from, step, to, stride, dense, beside);
            [filled, warped]
        };
        assert_eq!(statuses, [COVBEAM_OK; 2]);
        for ((place, density), point) in
            values(&places).into_iter().zip(values(&densities)).zip(values(&points))
        {
            assert_eq!((place, density), expected.warp(point));
        }
        assert_eq!(guide, core);
    }
}
