//! Where the picture needs light paths: importance in voxels, and what follows from it for a path.

use crate::arrays::write;
use crate::check::{finite_not_negative, random, vector};
use crate::grid::sound;
use crate::handle::{Opaque, free, handle_to, run_on, shared};
use crate::heap::reserved;
use crate::medium::{self, covbeam_medium};
use crate::memory::{Element, Slot, inputs, outputs, read};
use crate::status::{Failure, covbeam_status, covbeam_status::*, fail, run};
use crate::types::{covbeam_eye_ray, covbeam_grid_layout, eye_ray};
use covbeam_core::{
    EyeRay, GridLayout, Importance, ImportanceCell, ImportanceGrid, ImportanceSums, SegmentImportance,
    weight_window,
};

/// Where the picture needs photons. Importance is the share of the picture's light, relative to its brightness,
/// that a watt brings about. It collects what the camera sees (covbeam_importance_add_eye_rays, _add_paths,
/// _add_surfaces), is resolved once, before the first pass, and is looked up from then on by what traces the
/// light. Only probabilities follow from it: a wrong importance costs noise and never makes a picture wrong.
///
/// Several threads: as for covbeam_grid, one for each *share of the paths*, merged in order.
pub struct covbeam_importance(());

impl Opaque for covbeam_importance {
    type Object = Voxels;
    const TAG: u64 = u64::from_le_bytes(*b"cb-impor");
    const NAME: &'static str = "covbeam_importance";
}

/// What a `covbeam_importance` is.
pub(crate) struct Voxels {
    layout: GridLayout,
    sums: Vec<ImportanceSums>,
    /// Empty before the first resolve.
    cells: Vec<ImportanceCell>,
}

impl Voxels {
    fn collecting(&mut self) -> ImportanceGrid<'_> {
        ImportanceGrid::new(self.layout, &mut self.sums).expect("the layout was checked when it was made")
    }

    fn resolved(&self) -> Result<Importance<'_>, Failure> {
        Importance::new(self.layout, &self.cells).map_err(|_| {
            let message =
                format_args!("importance: nothing to look up yet; call covbeam_importance_resolve first");
            fail(COVBEAM_WRONG_ORDER, message)
        })
    }
}

/// Checks every argument, then adds them.
fn add<A>(
    importance: &mut Voxels,
    count: usize,
    arguments: impl Fn(usize) -> Result<A, Failure>,
    add: impl Fn(&mut ImportanceGrid, A),
) -> Result<(), Failure> {
    for i in 0..count {
        arguments(i)?;
    }
    let mut grid = importance.collecting();
    for i in 0..count {
        add(&mut grid, arguments(i)?);
    }
    Ok(())
}

/// Importance around a point.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct covbeam_importance_cell {
    /// Of a watt of beam on each metre, with the medium's density [1/(W m)].
    pub beam: f32,
    /// Of a watt that is scattered there, by the medium or by a diffuse surface, into no direction more than
    /// others [1/W].
    pub scattered: f32,
    /// Of a watt that arrives on surfaces there [1/W], but for what they scatter.
    pub surface: f32,
}

/// What a watt that flies along a segment is worth.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct covbeam_segment_importance {
    /// As a beam, of a watt at the segment's start [1/W].
    pub beam: f32,
    /// Of what the medium scatters from a watt on its way [1/W].
    pub scattered: f32,
    /// What is left of a watt where it leaves the voxels, or at its end if that is before.
    pub transmittance: f32,
}

/// Makes an empty importance: 24 bytes a voxel, and 12 more from the first covbeam_importance_resolve on.
///
/// @param layout box and resolution: of the lit fog, and coarse. Importance is smooth.
/// @param out the handle.
/// @kinds <layout +importance
/// @extra
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_importance_new(
    layout: *const covbeam_grid_layout,
    out: *mut *mut covbeam_importance,
) -> covbeam_status {
    run(|| {
        let out = Slot::new(out, "out")?;
        // SAFETY: by the caller's promise.
        let layout = GridLayout::from(unsafe { read(layout, "layout") }?);
        let count = sound(layout)?;
        let mut sums = reserved(count)?;
        sums.resize(count, ImportanceSums::default());
        out.set(handle_to(Voxels { layout, sums, cells: Vec::new() })?);
        Ok(())
    })
}

/// Frees an importance.
///
/// @param importance NULL is ignored.
/// @kinds !importance
/// @extra
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_importance_free(importance: *mut covbeam_importance) -> covbeam_status {
    // SAFETY: by the caller's promise.
    unsafe { free(importance, "importance") }
}

/// Adds pieces of eye rays: beams that cross them are seen.
///
/// @param importance what is added to.
/// @param medium what the pieces run through; the means of the channels count.
/// @param count number of pieces; with 0 nothing is done.
/// @param rays, ray_stride the pieces.
/// @param weights, weight_stride of the ray at the piece's origin, finite and >= 0. At the camera it is
///     1/(N L), for N pixels and the luminance L that this one has about: pixels count by their relative
///     errors. Where L is next to nothing, bound it.
/// @note Costs what covbeam_importance_of_segments does.
/// @kinds !importance <medium <ray <f:q
/// @extra
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_importance_add_eye_rays(
    importance: *mut covbeam_importance,
    medium: *const covbeam_medium,
    count: usize,
    rays: *const covbeam_eye_ray,
    ray_stride: usize,
    weights: *const f32,
    weight_stride: usize,
) -> covbeam_status {
    let body = |importance: &mut Voxels| {
        inputs!(count, rays, ray_stride);
        inputs!(count, weights, weight_stride);
        // SAFETY: by the caller's promise.
        let medium = unsafe { medium::read(medium, "medium") }?;
        let piece = |i: usize| Ok((eye_ray(rays.get(i))?, finite_not_negative(weights.get(i))?));
        add(importance, count, piece, |grid, (EyeRay { origin, direction, length }, weight)| {
            grid.add_eye_ray(&medium, origin, direction, length, weight);
        })
    };
    // SAFETY: by the caller's promise.
    unsafe { run_on(importance, "importance", body) }
}

/// Adds segments that paths from the camera fly after they were scattered, by the medium or by a diffuse
/// surface: light that is scattered on them goes on to where the camera sees it.
///
/// @param importance what is added to.
/// @param medium what the segments run through; the means of the channels count.
/// @param count number of segments; with 0 nothing is done.
/// @param paths, path_stride the segments, away from the camera.
/// @param weights, weight_stride of the path at the segment's origin, finite and >= 0: that at the camera, times
///     what scattering has left of it, over the probability that the path goes there.
/// @note Costs what covbeam_importance_of_segments does.
/// @kinds !importance <medium <ray <f:q
/// @extra
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_importance_add_paths(
    importance: *mut covbeam_importance,
    medium: *const covbeam_medium,
    count: usize,
    paths: *const covbeam_eye_ray,
    path_stride: usize,
    weights: *const f32,
    weight_stride: usize,
) -> covbeam_status {
    let body = |importance: &mut Voxels| {
        inputs!(count, paths, path_stride);
        inputs!(count, weights, weight_stride);
        // SAFETY: by the caller's promise.
        let medium = unsafe { medium::read(medium, "medium") }?;
        let piece = |i: usize| Ok((eye_ray(paths.get(i))?, finite_not_negative(weights.get(i))?));
        add(importance, count, piece, |grid, (EyeRay { origin, direction, length }, weight)| {
            grid.add_path(&medium, origin, direction, length, weight);
        })
    };
    // SAFETY: by the caller's promise.
    unsafe { run_on(importance, "importance", body) }
}

/// Adds places on diffuse surfaces that paths from the camera see. One outside the box adds nothing.
///
/// @param importance what is added to.
/// @param count number of places; with 0 nothing is done.
/// @param positions, position_stride the places [m].
/// @param weights, weight_stride of the path there times albedo/pi, finite and >= 0.
/// @kinds !importance <f:fff <f:q
/// @extra
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_importance_add_surfaces(
    importance: *mut covbeam_importance,
    count: usize,
    positions: *const f32,
    position_stride: usize,
    weights: *const f32,
    weight_stride: usize,
) -> covbeam_status {
    let body = |importance: &mut Voxels| {
        inputs!(count, positions: [f32; 3], position_stride);
        inputs!(count, weights, weight_stride);
        let place = |i: usize| Ok((vector(positions.get(i))?, finite_not_negative(weights.get(i))?));
        add(importance, count, place, |grid, (position, weight)| grid.add_surface(position, weight))
    };
    // SAFETY: by the caller's promise.
    unsafe { run_on(importance, "importance", body) }
}

/// Adds what others of the same layout have collected, in their order.
///
/// @param importance what is added to.
/// @param others array of other_count handles, none of them `importance`; they stay as they are.
/// @param other_count number of handles; with 0 nothing is done.
/// @kinds !importance <importances k
/// @extra
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_importance_merge(
    importance: *mut covbeam_importance,
    others: *const *const covbeam_importance,
    other_count: usize,
) -> covbeam_status {
    let itself = importance.cast_const();
    let merge = |importance: &mut Voxels| {
        inputs!(other_count, others, size_of::<*const covbeam_importance>());
        let other = |i: usize| {
            let handle = others.get(i).value;
            if handle == itself {
                return Err(fail(
                    COVBEAM_INVALID_ARRAY,
                    format_args!("others[{i}]: is the importance itself"),
                ));
            }
            // SAFETY: by the caller's promise.
            unsafe { shared(handle, "others") }
        };
        for i in 0..other_count {
            if other(i)?.layout != importance.layout {
                return Err(fail(
                    COVBEAM_MISMATCH,
                    format_args!("others[{i}]: has another layout than the importance"),
                ));
            }
        }
        let mut sum = importance.collecting();
        for i in 0..other_count {
            sum.merge(&other(i)?.sums).expect("the layouts are equal");
        }
        Ok(())
    };
    // SAFETY: by the caller's promise.
    unsafe { run_on(importance, "importance", merge) }
}

/// Computes the importance of every voxel, smoothed over its neighbours, for look-ups; they see the state of this
/// call until the next one. Where there is any, it is at least a thousandth of its mean everywhere.
///
/// @param importance what is resolved.
/// @kinds !importance
/// @extra
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_importance_resolve(importance: *mut covbeam_importance) -> covbeam_status {
    let resolve = |importance: &mut Voxels| {
        let count = importance.sums.len();
        if importance.cells.is_empty() {
            importance.cells = reserved(count)?;
            importance.cells.resize(count, ImportanceCell::default());
        }
        let grid = ImportanceGrid::new(importance.layout, &mut importance.sums);
        let grid = grid.expect("the layout was checked when it was made");
        grid.resolve(&mut importance.cells).expect("as many cells as sums");
        Ok(())
    };
    // SAFETY: by the caller's promise.
    unsafe { run_on(importance, "importance", resolve) }
}

/// The importance around points: of light that is scattered there, or arrives on a surface.
///
/// @param importance one that has been resolved.
/// @param count number of points; with 0 nothing is done.
/// @param positions, position_stride the points [m]; outside the box that of the nearest voxel.
/// @param cells, cell_stride receive it.
/// @kinds @importance.resolved <f:fff >worth
/// @extra
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_importance_at(
    importance: *const covbeam_importance,
    count: usize,
    positions: *const f32,
    position_stride: usize,
    cells: *mut covbeam_importance_cell,
    cell_stride: usize,
) -> covbeam_status {
    run(|| {
        // SAFETY: by the caller's promise.
        let importance = unsafe { shared(importance, "importance") }?;
        let importance = importance.resolved()?;
        inputs!(count, positions: [f32; 3], position_stride);
        outputs!(count, cells, cell_stride);
        write(
            cells,
            |i| vector(positions.get(i)),
            |position| {
                let ImportanceCell { beam, scattered, surface } = importance.at(position);
                covbeam_importance_cell { beam, scattered, surface }
            },
        )
    })
}

/// What a watt that flies along segments of light paths is worth: to weigh directions in which a path may go on,
/// and collisions on its way. Nothing outside the box.
///
/// @param importance one that has been resolved.
/// @param medium what the segments run through; the means of the channels count.
/// @param count number of segments; with 0 nothing is done.
/// @param segments, segment_stride the segments, each to the next surface, with the direction of the light.
/// @param worths, worth_stride receive it. On a surface behind, worth there is transmittance times what
///     covbeam_importance_at says: surface, and albedo times scattered.
/// @note About 5 ns a voxel on the way.
/// @kinds @importance.resolved <medium <ray >worth
/// @extra
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_importance_of_segments(
    importance: *const covbeam_importance,
    medium: *const covbeam_medium,
    count: usize,
    segments: *const covbeam_eye_ray,
    segment_stride: usize,
    worths: *mut covbeam_segment_importance,
    worth_stride: usize,
) -> covbeam_status {
    run(|| {
        // SAFETY: by the caller's promise.
        let importance = unsafe { shared(importance, "importance") }?;
        let importance = importance.resolved()?;
        // SAFETY: by the caller's promise.
        let medium = unsafe { medium::read(medium, "medium") }?;
        inputs!(count, segments, segment_stride);
        outputs!(count, worths, worth_stride);
        write(
            worths,
            |i| eye_ray(segments.get(i)),
            |EyeRay { origin, direction, length }| {
                let worth = importance.of_segment(&medium, origin, direction, length);
                let SegmentImportance { beam, scattered, transmittance } = worth;
                covbeam_segment_importance { beam, scattered, transmittance }
            },
        )
    })
}

/// Splits and ends light paths: of some candidates, such as directions in which a path may go on or the paths
/// of a wave, which do, and by what their power is multiplied. The mean of each factor over u is 1, so that
/// nothing is added to the light or lost; of all together as many go on as are expected, up to one.
///
/// @param count number of candidates; with 0 nothing is done.
/// @param factors, factor_stride in: of each candidate, how many of it should go on: its power times its
///     importance, over what power times importance is to be; finite and >= 0, and above 0 unless it carries no
///     light. Out: the factor of its power, 0 where it ends. It goes on once, also where it could more often.
/// @param u uniform in [0, 1), a new one for each call.
/// @note Booth and Hendricks 1984; systematic resampling, Baker 1987.
/// @kinds =f:q $r
/// @extra
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_weight_window(
    count: usize,
    factors: *mut f32,
    factor_stride: usize,
    u: f32,
) -> covbeam_status {
    run(|| {
        outputs!(count, factors, factor_stride);
        let u = random(Element::single(u, "u"))?;
        let mut expected = reserved(count)?;
        for i in 0..count {
            expected.push(finite_not_negative(factors.get(i))?);
        }
        weight_window(&mut expected, u);
        for (i, factor) in expected.into_iter().enumerate() {
            factors.set(i, factor);
        }
        Ok(())
    })
}

#[cfg(test)]
#[allow(clippy::undocumented_unsafe_blocks, reason = "every argument is a local, or refused")]
mod tests {
    use super::*;
    use crate::hostile::{Rule::*, UNTOUCHED, padded, refuses, values};
    use crate::medium::samples::{fog, haze};
    use core::ptr;
    use glam::Vec3;

    const LAYOUT: covbeam_grid_layout =
        covbeam_grid_layout { min: [-1.0; 3], max: [1.0; 3], cells: [4, 3, 2] };

    fn made(layout: &covbeam_grid_layout) -> *mut covbeam_importance {
        let mut importance = ptr::null_mut();
        assert_eq!(unsafe { covbeam_importance_new(layout, &mut importance) }, COVBEAM_OK);
        importance
    }

    fn ray(origin: [f32; 3], direction: [f32; 3], length: f32) -> covbeam_eye_ray {
        covbeam_eye_ray { origin, direction, length }
    }

    /// What look-ups see at a place, once resolved.
    fn seen(importance: *mut covbeam_importance) -> covbeam_importance_cell {
        let mut cell = covbeam_importance_cell { beam: UNTOUCHED, scattered: UNTOUCHED, surface: UNTOUCHED };
        unsafe {
            assert_eq!(covbeam_importance_resolve(importance), COVBEAM_OK);
            assert_eq!(covbeam_importance_at(importance, 1, [0.1; 3].as_ptr(), 0, &mut cell, 0), COVBEAM_OK);
        }
        cell
    }

    #[test]
    fn a_bad_argument_is_refused_and_nothing_changes() {
        let numbers = [
            (-2.0, Finite),
            (0.1, Finite),
            (0.2, Finite),
            (1.0, Along),
            (0.0, Across),
            (0.0, Across),
            (5.0, NotNegative),
            (0.75, FiniteNotNegative),
        ];
        for add in [covbeam_importance_add_eye_rays, covbeam_importance_add_paths] {
            refuses(4, &numbers, |bad, n| {
                let (importance, fog) = (made(&LAYOUT), fog());
                let piece = ray([n[0], n[1], n[2]], [n[3], n[4], n[5]], n[6]);
                let status = unsafe {
                    let (to, medium) = (bad.at_mut(0, importance), bad.at(1, &fog));
                    add(to, medium, 1, bad.at(2, &piece), 0, bad.at(3, &n[7]), 0)
                };
                let none = covbeam_importance_cell { beam: 0.0, scattered: 0.0, surface: 0.0 };
                // Good arguments may add nothing: a weight of 0.
                let changed = seen(importance) != none || status == COVBEAM_OK;
                unsafe { covbeam_importance_free(importance) };
                (status, changed)
            });
        }
        let place = [(0.1, Finite), (0.2, Finite), (0.3, Finite), (0.75, FiniteNotNegative)];
        refuses(3, &place, |bad, n| {
            let importance = made(&LAYOUT);
            let (to, at, weight) = (bad.at_mut(0, importance), bad.at(1, n.as_ptr()), bad.at(2, &n[3]));
            let status = unsafe { covbeam_importance_add_surfaces(to, 1, at, 0, weight, 0) };
            let changed = seen(importance).surface != 0.0 || status == COVBEAM_OK;
            unsafe { covbeam_importance_free(importance) };
            (status, changed)
        });
        refuses(4, &numbers[..7], |bad, n| {
            let (importance, fog) = (made(&LAYOUT), fog());
            let segment = ray([n[0], n[1], n[2]], [n[3], n[4], n[5]], n[6]);
            let untouched = covbeam_segment_importance {
                beam: UNTOUCHED,
                scattered: UNTOUCHED,
                transmittance: UNTOUCHED,
            };
            let mut worth = untouched;
            let status = unsafe {
                assert_eq!(covbeam_importance_resolve(importance), COVBEAM_OK);
                let (from, medium) = (bad.at(0, importance), bad.at(1, &fog));
                let (segment, to) = (bad.at(2, &segment), bad.at_mut(3, &mut worth));
                covbeam_importance_of_segments(from, medium, 1, segment, 0, to, 0)
            };
            unsafe { covbeam_importance_free(importance) };
            (status, worth != untouched)
        });
        refuses(1, &[(0.75, FiniteNotNegative), (0.5, FiniteNotNegative), (0.25, Random)], |bad, n| {
            // A third, that nothing is asked of, shows that the call has written.
            let given = [n[0], n[1], 0.25];
            let mut factors = given;
            let status = unsafe { covbeam_weight_window(3, bad.at_mut(0, factors.as_mut_ptr()), 4, n[2]) };
            // NaN is not itself.
            (status, factors.map(f32::to_bits) != given.map(f32::to_bits))
        });
    }

    #[test]
    fn calls_out_of_order_and_what_does_not_fit_are_refused() {
        let importance = made(&LAYOUT);
        let other = made(&covbeam_grid_layout { cells: [4, 3, 3], ..LAYOUT });
        let mut cell = covbeam_importance_cell { beam: UNTOUCHED, scattered: UNTOUCHED, surface: UNTOUCHED };
        unsafe {
            let status = covbeam_importance_at(importance, 1, [0.0; 3].as_ptr(), 0, &mut cell, 0);
            assert_eq!((status, cell.beam), (COVBEAM_WRONG_ORDER, UNTOUCHED));
            let merge = |one: *const covbeam_importance| covbeam_importance_merge(importance, &one, 1);
            assert_eq!(merge(other), COVBEAM_MISMATCH);
            assert_eq!(merge(importance), COVBEAM_INVALID_ARRAY);
            assert_eq!(merge(ptr::null()), COVBEAM_NULL_POINTER);
            covbeam_importance_free(other);
            covbeam_importance_free(importance);
            covbeam_importance_free(ptr::null_mut());
        }
        for cells in [[0, 1, 1], [1 << 24, 2, 1]] {
            let (layout, mut out) = (covbeam_grid_layout { cells, ..LAYOUT }, ptr::null_mut());
            assert_eq!(unsafe { covbeam_importance_new(&layout, &mut out) }, COVBEAM_INVALID_VALUE);
            assert!(out.is_null());
        }
    }

    #[test]
    fn many_are_the_bits_of_the_core() {
        let rays = padded(&[
            ray([-3.0, 0.1, 0.2], [1.0, 0.0, 0.0], f32::INFINITY),
            ray([0.1, 0.2, 0.3], [0.0, 0.6, -0.8], 0.7),
            ray([5.0, 5.0, 5.0], [0.0, 0.0, 1.0], 1.0),
        ]);
        let (weights, points) =
            (padded(&[0.5, 2.0, 1.0]), padded(&[[0.1, 0.2, 0.3], [9.0, 0.0, 0.0], [-0.9; 3]]));
        for c_medium in [fog(), haze()] {
            let (first, second) = (made(&LAYOUT), made(&LAYOUT));
            let none = covbeam_importance_cell { beam: UNTOUCHED, scattered: UNTOUCHED, surface: UNTOUCHED };
            let nothing = covbeam_segment_importance {
                beam: UNTOUCHED,
                scattered: UNTOUCHED,
                transmittance: UNTOUCHED,
            };
            let (mut cells, mut worths) = (padded(&[none; 3]), padded(&[nothing; 3]));
            let statuses = unsafe {
                let (ray, ray_step) = (&raw const rays[0].value, size_of_val(&rays[0]));
                let (weight, step) = (&raw const weights[0].value, size_of_val(&weights[0]));
                let (point, point_step) = (points[0].value.as_ptr(), size_of_val(&points[0]));
                let (cell, cell_step) = (&raw mut cells[0].value, size_of_val(&cells[0]));
                let (worth, worth_step) = (&raw mut worths[0].value, size_of_val(&worths[0]));
                let medium = &raw const c_medium;
                [
                    covbeam_importance_add_eye_rays(first, medium, 3, ray, ray_step, weight, step),
                    covbeam_importance_add_paths(second, medium, 3, ray, ray_step, weight, step),
                    covbeam_importance_add_surfaces(second, 3, point, point_step, weight, step),
                    covbeam_importance_merge(first, [second.cast_const()].as_ptr(), 1),
                    covbeam_importance_resolve(first),
                    covbeam_importance_at(first, 3, point, point_step, cell, cell_step),
                    covbeam_importance_of_segments(first, medium, 3, ray, ray_step, worth, worth_step),
                ]
            };
            assert_eq!(statuses, [COVBEAM_OK; 7]);
            unsafe {
                covbeam_importance_free(first);
                covbeam_importance_free(second);
            }
            let Ok(medium) = (unsafe { medium::read(&c_medium, "medium") }) else { panic!("a sound medium") };
            let mut sums = [ImportanceSums::default(); 24];
            let mut grid = ImportanceGrid::new(LAYOUT.into(), &mut sums).unwrap();
            let pieces = values(&rays).into_iter().zip(values(&weights)).zip(values(&points));
            for ((covbeam_eye_ray { origin, direction, length }, weight), point) in pieces {
                grid.add_eye_ray(&medium, origin.into(), direction.into(), length, weight);
                grid.add_path(&medium, origin.into(), direction.into(), length, weight);
                grid.add_surface(point.into(), weight);
            }
            let mut core = [ImportanceCell::default(); 24];
            grid.resolve(&mut core).unwrap();
            let importance = Importance::new(LAYOUT.into(), &core).unwrap();
            for (cell, point) in values(&cells).into_iter().zip(values(&points)) {
                let ImportanceCell { beam, scattered, surface } = importance.at(Vec3::from(point));
                assert_eq!(cell, covbeam_importance_cell { beam, scattered, surface });
            }
            for (worth, segment) in values(&worths).into_iter().zip(values(&rays)) {
                let covbeam_eye_ray { origin, direction, length } = segment;
                let found = importance.of_segment(&medium, origin.into(), direction.into(), length);
                let SegmentImportance { beam, scattered, transmittance } = found;
                assert_eq!(worth, covbeam_segment_importance { beam, scattered, transmittance });
            }
            assert!(values(&worths)[1].beam > 0.0);
        }
        let mut factors = padded(&[0.5, 0.25, 2.0, 0.25]);
        let (first, stride) = (&raw mut factors[0].value, size_of_val(&factors[0]));
        assert_eq!(unsafe { covbeam_weight_window(4, first, stride, 0.4) }, COVBEAM_OK);
        assert_eq!(values(&factors), [0.0, 4.0, 1.0, 0.0]);
    }
}
