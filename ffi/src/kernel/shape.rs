//! Shapes of kernels.

use crate::check::{finite, positive};
use crate::memory::{Element, Slot};
use crate::status::{Failure, covbeam_status, run};
use covbeam_core::KernelShape;

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

pub(super) fn shape(e: Element<u32>) -> Result<KernelShape, Failure> {
    use covbeam_kernel_shape::*;
    match e.value {
        k if k == COVBEAM_KERNEL_BOX as u32 => Ok(KernelShape::Box),
        k if k == COVBEAM_KERNEL_EPANECHNIKOV as u32 => Ok(KernelShape::Epanechnikov),
        k if k == COVBEAM_KERNEL_BIWEIGHT as u32 => Ok(KernelShape::Biweight),
        unknown => Err(e.is(format_args!("{unknown} is no covbeam_kernel_shape"))),
    }
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
