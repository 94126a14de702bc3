//! Kernels of tests and measurements.

use covbeam::{Kernel, KernelShape};

/// One that is as wide everywhere, without spectra.
pub fn plain(radius: f32) -> Kernel<'static> {
    Kernel {
        shape: KernelShape::Epanechnikov,
        min_radius: radius,
        max_radius: radius,
        error: 0.01,
        grid: None,
    }
}
