//! The schedule of kernels: how they shrink over the passes.

use super::options::covbeam_kernel;
use super::shape::shape;
use crate::check::positive;
use crate::memory::{Element, Slot, read_options};
use crate::status::{Failure, covbeam_status, run};
use covbeam_core::{Kernel, Schedule, error_bound, progressive_radius};

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
