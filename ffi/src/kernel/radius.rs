//! The radius of a kernel, from the bias that it may cause.

use super::options::{covbeam_kernel, read_kernel};
use super::shape::shape;
use crate::arrays::each;
use crate::check::{not_negative, positive, unit, vector};
use crate::grid::handle::covbeam_grid;
use crate::memory::{Element, Slot, inputs, outputs};
use crate::status::{covbeam_status, run};

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
        let kernel = unsafe { read_kernel(kernel, grid) }?;
        inputs!(count, positions: [f32; 3], position_stride);
        inputs!(count, axes: [f32; 3], axis_stride);
        outputs!(count, radii, radius_stride);
        outputs!(count, sigmas, sigma_stride);
        each(
            count,
            |i| Ok((vector(positions.get(i))?, unit(axes.get(i))?)),
            |i, (position, axis)| {
                let (radius, sigma) = kernel.radius_at(position, axis);
                radii.set(i, radius);
                sigmas.set(i, sigma);
            },
        )
    })
}
