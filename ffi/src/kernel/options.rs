//! Kernels, by value.

use super::shape::shape;
use crate::check::positive;
use crate::grid::handle::{Grid, covbeam_grid};
use crate::grid::look_up::resolved;
use crate::handle::{View, optional};
use crate::memory::{Element, read_options};
use crate::status::Failure;
use covbeam_core::Kernel;

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

/// The kernel of a gather, and the spectra that it looks up unless `grid` is NULL.
///
/// # Safety
/// Both are NULL or what they say, and the grid lives unchanged while the result does.
pub(crate) unsafe fn read_kernel<'a>(
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
