//! Kernels, their radii, and how both shrink over the passes.

use crate::check::{finite, not_negative, positive, unit, vector};
use crate::grid::{Grid, covbeam_grid, resolved};
use crate::handle::{View, optional};
use crate::memory::{Element, Slot, inputs, outputs, read_options};
use crate::status::{Failure, covbeam_status, run};
use covbeam_core::{Kernel, KernelShape, Schedule, error_bound, progressive_radius};

/// Shape of the blur kernel K_r(d), whose integral over [-r, r] is 1. With q = d / r:
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum covbeam_kernel_shape {
    /// 1 / (2r).
    COVBEAM_KERNEL_BOX = 0,
    /// 3 (1 - q^2) / (4r).
    COVBEAM_KERNEL_EPANECHNIKOV = 1,
    /// 15 (1 - q^2)^2 / (16r).
    COVBEAM_KERNEL_BIWEIGHT = 2,
}

/// How wide the pairs of one pass are gathered: within max(min_radius, min(max_radius, what the spectrum
/// allows)).
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct covbeam_kernel {
    /// sizeof(covbeam_kernel).
    pub struct_size: u32,
    /// A value of covbeam_kernel_shape.
    pub shape: u32,
    /// The radius where the grid has no data, and the smallest one [m] > 0.
    pub min_radius: f32,
    /// The largest radius [m], finite and >= min_radius.
    pub max_radius: f32,
    /// Accepted relative bias of a pair > 0; without a grid it has no effect.
    pub error: f32,
}

/// How the kernel shrinks over the passes of a picture.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct covbeam_schedule {
    /// sizeof(covbeam_schedule).
    pub struct_size: u32,
    /// A value of covbeam_kernel_shape.
    pub shape: u32,
    /// Progressive radius of pass 1 [m] > 0.
    pub radius: f32,
    /// In (0, 1]: the progressive radius falls as pass^(alpha - 1); 1 keeps it.
    pub alpha: f32,
    /// Largest radius that a spectrum may ask for [m] > 0.
    pub max_radius: f32,
    /// Accepted relative bias of a pair in pass 1, > 0; it falls as pass^(-2/5).
    pub error: f32,
}

fn shape(e: Element<u32>) -> Result<KernelShape, Failure> {
    use covbeam_kernel_shape::*;
    match e.value {
        k if k == COVBEAM_KERNEL_BOX as u32 => Ok(KernelShape::Box),
        k if k == COVBEAM_KERNEL_EPANECHNIKOV as u32 => Ok(KernelShape::Epanechnikov),
        k if k == COVBEAM_KERNEL_BIWEIGHT as u32 => Ok(KernelShape::Biweight),
        unknown => Err(e.is(format_args!("{unknown} is no covbeam_kernel_shape"))),
    }
}

/// The kernel of a gather, and the spectra that it looks up unless `grid` is NULL.
///
/// # Safety
/// Both are NULL or what they say, and the grid lives unchanged while the result does.
pub(crate) unsafe fn read<'a>(
    kernel: *const covbeam_kernel,
    grid: *const covbeam_grid,
) -> Result<View<'a, Kernel<'a>, Grid>, Failure> {
    // SAFETY: by this function's contract.
    let options = unsafe { read_options(kernel, size_of::<covbeam_kernel>(), "kernel") }?;
    let shape = shape(Element::single(options.shape, "kernel.shape"))?;
    let min_radius = positive(Element::single(options.min_radius, "kernel.min_radius"))?;
    let largest = Element::single(options.max_radius, "kernel.max_radius");
    let max_radius = positive(largest)?;
    if max_radius < min_radius {
        return Err(largest.is(format_args!("{max_radius} is less than min_radius, {min_radius}")));
    }
    let error = positive(Element::single(options.error, "kernel.error"))?;
    // SAFETY: by this function's contract.
    let object = unsafe { optional(grid, "grid") }?;
    let grid = object.as_ref().map(|grid| resolved(grid.object())).transpose()?;
    Ok(View { value: Kernel { shape, min_radius, max_radius, error, grid }, object })
}

fn alpha(e: Element<f32>) -> Result<f32, Failure> {
    if e.value > 0.0 && e.value <= 1.0 {
        Ok(e.value)
    } else {
        Err(e.is(format_args!("{} is not in (0, 1]", e.value)))
    }
}

/// Counted from 1.
fn pass(value: u32) -> Result<u32, Failure> {
    let e = Element::single(value, "pass");
    if value >= 1 { Ok(value) } else { Err(e.is(format_args!("passes are counted from 1"))) }
}

/// The kernel of a pass: what a host calls when it begins one.
///
/// @param schedule how the kernel shrinks.
/// @param pass counted from 1. Passes may run in any order.
/// @param kernel set its struct_size before; the rest is written: min_radius =
///     covbeam_progressive_radius(radius, alpha, pass), max_radius = the larger of max_radius and min_radius,
///     error = covbeam_error_bound(error, pass).
/// @note COVBEAM_INVALID_VALUE too if the radius or the error of the pass falls below the smallest float.
/// @kinds <schedule #pass =kernel
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_schedule_kernel(
    schedule: *const covbeam_schedule,
    pass: u32,
    kernel: *mut covbeam_kernel,
) -> covbeam_status {
    run(|| {
        let out = Slot::new(kernel, "kernel")?;
        // SAFETY: by the caller's promise. It says how much of it the host knows: all that is written.
        let before = unsafe { read_options(kernel.cast_const(), size_of::<covbeam_kernel>(), "kernel") }?;
        // SAFETY: by the caller's promise.
        let schedule = unsafe { read_options(schedule, size_of::<covbeam_schedule>(), "schedule") }?;
        let pass = self::pass(pass)?;
        let of = Schedule {
            shape: shape(Element::single(schedule.shape, "schedule.shape"))?,
            radius: positive(Element::single(schedule.radius, "schedule.radius"))?,
            alpha: alpha(Element::single(schedule.alpha, "schedule.alpha"))?,
            max_radius: positive(Element::single(schedule.max_radius, "schedule.max_radius"))?,
            error: positive(Element::single(schedule.error, "schedule.error"))?,
        };
        let Kernel { min_radius, max_radius, error, .. } = of.kernel(pass, None);
        out.set(covbeam_kernel {
            struct_size: before.struct_size,
            shape: schedule.shape,
            min_radius: positive(Element::single(min_radius, "schedule.radius, in this pass"))?,
            max_radius,
            error: positive(Element::single(error, "schedule.error, in this pass"))?,
        });
        Ok(())
    })
}

/// The progressive radius of a pass: r_1 = radius, r_(i+1) = r_i (i + alpha) / (i + 1).
///
/// @param radius of pass 1 [m] > 0.
/// @param alpha in (0, 1]; 1 keeps the radius.
/// @param pass i, counted from 1.
/// @param result [m].
/// @note A few ns a pass up to pass 4096, and no more from there on. Jarosz et al. 2011.
/// @kinds $m $l #pass >f:+
/// @extra
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_progressive_radius(
    radius: f32,
    alpha: f32,
    pass: u32,
    result: *mut f32,
) -> covbeam_status {
    run(|| {
        let result = Slot::new(result, "result")?;
        let radius = positive(Element::single(radius, "radius"))?;
        let alpha = self::alpha(Element::single(alpha, "alpha"))?;
        result.set(progressive_radius(radius, alpha, self::pass(pass)?));
        Ok(())
    })
}

/// The bound on the relative bias in a pass: error x pass^(-2/5), so that the bias of the mean over passes goes
/// to 0.
///
/// @param error in pass 1, > 0.
/// @param pass counted from 1.
/// @param result the bound in that pass.
/// @kinds $+ #pass >f:+
/// @extra
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_error_bound(error: f32, pass: u32, result: *mut f32) -> covbeam_status {
    run(|| {
        let result = Slot::new(result, "result")?;
        let error = positive(Element::single(error, "error"))?;
        result.set(error_bound(error, self::pass(pass)?));
        Ok(())
    })
}

/// A kernel's value K_r(d).
///
/// @param shape a value of covbeam_kernel_shape.
/// @param distance d [m], of either sign.
/// @param radius r [m] > 0.
/// @param value [1/m]: 0 where the distance is r or more.
/// @kinds #shape $f $+ >f:p
/// @extra
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_kernel_evaluate(
    shape: u32,
    distance: f32,
    radius: f32,
    value: *mut f32,
) -> covbeam_status {
    run(|| {
        let value = Slot::new(value, "value")?;
        let kernel = self::shape(Element::single(shape, "shape"))?;
        let distance = finite(Element::single(distance, "distance"))?;
        let radius = positive(Element::single(radius, "radius"))?;
        value.set(kernel.evaluate(distance, radius));
        Ok(())
    })
}

/// Second moment of a kernel of radius 1; that of radius r is r^2 times it.
///
/// @param shape a value of covbeam_kernel_shape.
/// @param moment of the kernel.
/// @kinds #shape >f:+
/// @extra
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_kernel_second_moment(shape: u32, moment: *mut f32) -> covbeam_status {
    run(|| {
        let moment = Slot::new(moment, "moment")?;
        moment.set(self::shape(Element::single(shape, "shape"))?.second_moment());
        Ok(())
    })
}

/// The radius at which the kernel costs a relative bias: sqrt(error / (2 pi^2 second_moment variance)).
///
/// @param shape a value of covbeam_kernel_shape.
/// @param error the relative bias > 0.
/// @param variance of the fluence's spectrum along the kernel's axis [cycles^2/m^2] >= 0; infinity gives 0.
/// @param radius [m]: infinite for a variance of 0.
/// @note Thesis 5.3.4.
/// @kinds #shape $+ $p >f:p
/// @extra
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_kernel_radius_from_error(
    shape: u32,
    error: f32,
    variance: f32,
    radius: *mut f32,
) -> covbeam_status {
    run(|| {
        let radius = Slot::new(radius, "radius")?;
        let kernel = self::shape(Element::single(shape, "shape"))?;
        let error = positive(Element::single(error, "error"))?;
        let variance = not_negative(Element::single(variance, "variance"))?;
        radius.set(kernel.radius_from_error(error, variance));
        Ok(())
    })
}

/// The kernel radius of a pair of beam and eye ray.
///
/// @param kernel the kernel of the pass.
/// @param grid where the spectrum is looked up, resolved; NULL gives the progressive radius.
/// @param count number of pairs; with 0 nothing is done.
/// @param positions, position_stride the closest point on the eye ray [m].
/// @param axes, axis_stride of the kernel, unit, across ray and beam: that of the covbeam_crossing.
/// @param radii, radius_stride [m] in [min_radius, max_radius].
/// @param sigmas, sigma_stride deviation of the spectrum along the axis [cycles/m]; 0 where the grid has no
///     data.
/// @note Thesis 5.3.4.
/// @kinds <kernel @grid.resolved? <f:fff <f:uuu >f:+ >f:q
/// @single covbeam_kernel_radius_at
/// @extra
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_kernel_radius_at_many(
    kernel: *const covbeam_kernel,
    grid: *const covbeam_grid,
    count: usize,
    positions: *const f32,
    position_stride: usize,
    axes: *const f32,
    axis_stride: usize,
    radii: *mut f32,
    radius_stride: usize,
    sigmas: *mut f32,
    sigma_stride: usize,
) -> covbeam_status {
    run(|| {
        // SAFETY: by the caller's promise.
        let kernel = unsafe { read(kernel, grid) }?;
        inputs!(count, positions: [f32; 3], position_stride);
        inputs!(count, axes: [f32; 3], axis_stride);
        outputs!(count, radii, radius_stride);
        outputs!(count, sigmas, sigma_stride);
        let arguments = |i| Ok((vector(positions.get(i))?, unit(axes.get(i))?));
        for i in 0..count {
            arguments(i)?;
        }
        for i in 0..count {
            let (position, axis) = arguments(i)?;
            let (radius, sigma) = kernel.radius_at(position, axis);
            radii.set(i, radius);
            sigmas.set(i, sigma);
        }
        Ok(())
    })
}

#[cfg(test)]
#[allow(clippy::undocumented_unsafe_blocks, reason = "every argument is a local, or refused")]
mod tests {
    use super::*;
    use crate::grid::{covbeam_grid_free, covbeam_grid_new};
    use crate::hostile::{Rule::*, UNTOUCHED, refuses};
    use crate::status::covbeam_status::*;
    use crate::types::covbeam_grid_layout;
    use core::ptr;

    const SIZE: u32 = size_of::<covbeam_kernel>() as u32;
    const BLANK: covbeam_kernel = covbeam_kernel {
        struct_size: SIZE,
        shape: 9,
        min_radius: UNTOUCHED,
        max_radius: UNTOUCHED,
        error: UNTOUCHED,
    };

    fn schedule() -> covbeam_schedule {
        let struct_size = size_of::<covbeam_schedule>() as u32;
        covbeam_schedule { struct_size, shape: 1, radius: 0.1, alpha: 0.5, max_radius: 0.2, error: 0.02 }
    }

    #[test]
    fn a_bad_argument_is_refused_and_nothing_is_written() {
        let numbers = [(0.5, Positive), (0.5, Alpha), (0.5, Positive), (0.5, Positive)];
        refuses(2, &numbers, |bad, n| {
            let schedule =
                covbeam_schedule { radius: n[0], alpha: n[1], max_radius: n[2], error: n[3], ..schedule() };
            let mut out = BLANK;
            let status = unsafe { covbeam_schedule_kernel(bad.at(0, &schedule), 1, bad.at_mut(1, &mut out)) };
            (status, out != BLANK)
        });
        refuses(1, &[(0.5, Positive), (0.5, Alpha)], |bad, n| {
            let mut out = UNTOUCHED;
            let status = unsafe { covbeam_progressive_radius(n[0], n[1], 3, bad.at_mut(0, &mut out)) };
            (status, out != UNTOUCHED)
        });
        refuses(1, &[(0.5, Positive)], |bad, n| {
            let mut out = UNTOUCHED;
            let status = unsafe { covbeam_error_bound(n[0], 3, bad.at_mut(0, &mut out)) };
            (status, out != UNTOUCHED)
        });
        refuses(1, &[(0.5, Finite), (0.75, Positive)], |bad, n| {
            let mut out = UNTOUCHED;
            let status = unsafe { covbeam_kernel_evaluate(2, n[0], n[1], bad.at_mut(0, &mut out)) };
            (status, out != UNTOUCHED)
        });
        refuses(1, &[], |bad, _| {
            let mut out = UNTOUCHED;
            (unsafe { covbeam_kernel_second_moment(2, bad.at_mut(0, &mut out)) }, out != UNTOUCHED)
        });
        refuses(1, &[(0.5, Positive), (0.75, NotNegative)], |bad, n| {
            let mut out = UNTOUCHED;
            let status = unsafe { covbeam_kernel_radius_from_error(2, n[0], n[1], bad.at_mut(0, &mut out)) };
            (status, out != UNTOUCHED)
        });
        // Position, axis, kernel. A max_radius below the progressive radius is refused; so is a radius above the max_radius.
        let numbers = [
            (0.2, Finite),
            (0.3, Finite),
            (0.4, Finite),
            (0.0, Across),
            (1.0, Along),
            (0.0, Across),
            (0.75, From(0.75)),
            (0.5, Positive),
        ];
        refuses(5, &numbers, |bad, n| {
            let kernel =
                covbeam_kernel { shape: 0, min_radius: 0.75, max_radius: n[6], error: n[7], ..BLANK };
            let (mut radius, mut sigma) = (UNTOUCHED, UNTOUCHED);
            let status = unsafe {
                covbeam_kernel_radius_at_many(
                    bad.at(0, &kernel),
                    ptr::null(),
                    1,
                    bad.at(1, n.as_ptr()),
                    0,
                    bad.at(2, n[3..].as_ptr()),
                    0,
                    bad.at_mut(3, &mut radius),
                    0,
                    bad.at_mut(4, &mut sigma),
                    0,
                )
            };
            (status, (radius, sigma) != (UNTOUCHED, UNTOUCHED))
        });
        for min_radius in [f32::NAN, f32::INFINITY, 0.0, -1.0, 2.5] {
            let kernel = covbeam_kernel { shape: 0, min_radius, max_radius: 2.0, error: 0.1, ..BLANK };
            let refused = unsafe { read(&kernel, ptr::null()) }.map(|_| ()).map_err(|failure| failure.0);
            assert_eq!(refused, Err(COVBEAM_INVALID_VALUE), "{min_radius}");
        }
    }

    #[test]
    fn an_unknown_shape_and_a_pass_0_are_refused() {
        let mut out = UNTOUCHED;
        let mut kernel = BLANK;
        let bad_shape = covbeam_schedule { shape: 3, ..schedule() };
        let statuses = unsafe {
            [
                covbeam_kernel_evaluate(3, 0.0, 1.0, &mut out),
                covbeam_kernel_second_moment(u32::MAX, &mut out),
                covbeam_kernel_radius_from_error(3, 0.1, 1.0, &mut out),
                covbeam_progressive_radius(1.0, 0.5, 0, &mut out),
                covbeam_error_bound(1.0, 0, &mut out),
                covbeam_schedule_kernel(&schedule(), 0, &mut kernel),
                covbeam_schedule_kernel(&bad_shape, 1, &mut kernel),
            ]
        };
        assert_eq!(statuses, [COVBEAM_INVALID_VALUE; 7]);
        assert_eq!((out, kernel), (UNTOUCHED, BLANK));
    }

    #[test]
    fn a_radius_that_shrinks_to_nothing_is_refused() {
        let tiny = covbeam_schedule { radius: 1e-45, ..schedule() };
        let mut kernel = BLANK;
        assert_eq!(unsafe { covbeam_schedule_kernel(&tiny, 1000, &mut kernel) }, COVBEAM_INVALID_VALUE);
        assert_eq!(kernel, BLANK);
    }

    #[test]
    fn a_struct_of_another_size_is_known_by_what_it_says() {
        #[repr(C)]
        struct Later {
            now: covbeam_schedule,
            option: u32,
        }
        let later = |size: usize, option| Later {
            now: covbeam_schedule { struct_size: size as u32, ..schedule() },
            option,
        };
        let full = size_of::<Later>();
        for (later, expected) in [
            (later(full, 0), COVBEAM_OK),
            (later(full, 1), COVBEAM_INVALID_VALUE),
            (later(0, 0), COVBEAM_INVALID_VALUE),
            (later(size_of::<covbeam_schedule>() - 1, 0), COVBEAM_INVALID_VALUE),
            (later(5000, 0), COVBEAM_INVALID_VALUE),
        ] {
            let mut kernel = BLANK;
            let status = unsafe { covbeam_schedule_kernel((&raw const later).cast(), 1, &mut kernel) };
            assert_eq!((status, kernel != BLANK), (expected, expected == COVBEAM_OK));
        }
        for struct_size in [0, SIZE - 1, 5000] {
            let before = covbeam_kernel { struct_size, ..BLANK };
            let mut kernel = before;
            assert_eq!(
                unsafe { covbeam_schedule_kernel(&schedule(), 1, &mut kernel) },
                COVBEAM_INVALID_VALUE
            );
            assert_eq!(kernel, before);
        }
    }

    #[test]
    fn a_schedule_makes_the_kernel_of_its_parts() {
        let mut kernel = BLANK;
        let (mut radius, mut error) = (UNTOUCHED, UNTOUCHED);
        let statuses = unsafe {
            [
                covbeam_schedule_kernel(&schedule(), 7, &mut kernel),
                covbeam_progressive_radius(0.1, 0.5, 7, &mut radius),
                covbeam_error_bound(0.02, 7, &mut error),
            ]
        };
        assert_eq!(statuses, [COVBEAM_OK; 3]);
        let expected = covbeam_kernel { shape: 1, min_radius: radius, max_radius: 0.2, error, ..BLANK };
        assert_eq!(kernel, expected);
        // A progressive radius that is larger than the largest wanted one is the max_radius itself.
        let wide = covbeam_schedule { max_radius: 0.01, ..schedule() };
        assert_eq!(unsafe { covbeam_schedule_kernel(&wide, 7, &mut kernel) }, COVBEAM_OK);
        assert_eq!(kernel, covbeam_kernel { max_radius: radius, ..expected });
    }

    #[test]
    fn a_grid_that_is_not_resolved_comes_too_early() {
        let layout = covbeam_grid_layout { min: [0.0; 3], max: [1.0; 3], cells: [2; 3] };
        let mut grid = ptr::null_mut();
        assert_eq!(unsafe { covbeam_grid_new(&layout, &mut grid) }, COVBEAM_OK);
        let kernel = covbeam_kernel { shape: 1, min_radius: 0.1, max_radius: 0.2, error: 0.1, ..BLANK };
        let (position, axis) = ([0.5; 3], [1.0, 0.0, 0.0]);
        let (mut radius, mut sigma) = (UNTOUCHED, UNTOUCHED);
        let status = unsafe {
            covbeam_kernel_radius_at_many(
                &kernel,
                grid,
                1,
                position.as_ptr(),
                0,
                axis.as_ptr(),
                0,
                &mut radius,
                0,
                &mut sigma,
                0,
            )
        };
        assert_eq!((status, radius, sigma), (COVBEAM_WRONG_ORDER, UNTOUCHED, UNTOUCHED));
        let message = unsafe { core::ffi::CStr::from_ptr(crate::status::covbeam_last_error()) };
        assert!(message.to_str().unwrap().contains("covbeam_grid_resolve"));
        unsafe { covbeam_grid_free(grid) };
    }
}
