//! Media, by value.

use super::phase::{covbeam_phase, phase};
use super::voxel_density::{Volume, covbeam_density};
use crate::check::{direction, finite_not_negative, positive, vector};
use crate::handle::{View, shared};
use crate::heap::{Owner, reserve};
use crate::memory::{Element, field, read_options};
use crate::status::Failure;
use core::mem::offset_of;
use covbeam_core::{Column, Density, ExponentialDensity, Knot, Medium};
use glam::Vec3;

/// How the density of a medium varies in space.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum covbeam_density_kind {
    /// 1 everywhere: a homogeneous medium.
    COVBEAM_DENSITY_UNIFORM = 0,
    /// exp(-height / scale_height).
    COVBEAM_DENSITY_EXPONENTIAL = 1,
    /// A covbeam_density.
    COVBEAM_DENSITY_VOXELS = 2,
}

/// A medium. Coefficients hold where the relative density is 1.
///
/// covbeam_medium fog = { sizeof fog, { 0.2f, 0.2f, 0.2f } }; is homogeneous and isotropic.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct covbeam_medium {
    /// sizeof(covbeam_medium).
    pub struct_size: u32,
    /// Scattering coefficient per channel [1/m], each finite and >= 0.
    pub scattering: [f32; 3],
    /// Absorption coefficient per channel [1/m], each finite and >= 0; all coefficients add up to a finite
    /// number.
    pub absorption: [f32; 3],
    /// How scattered light is spread.
    pub phase: covbeam_phase,
    /// A value of covbeam_density_kind; the fields below are read as it needs them.
    pub density: u32,
    /// Exponential: a point where the density is 1 [m].
    pub origin: [f32; 3],
    /// Exponential: direction in which the density falls, any length but 0.
    pub up: [f32; 3],
    /// Exponential: height over which it falls by the factor e [m] > 0.
    pub scale_height: f32,
    /// Voxels: the densities.
    pub voxels: *const covbeam_density,
}

/// The direction of a vector of any length but 0, whose square may be beyond what a float can be.
fn normalized(vector: Vec3) -> Vec3 {
    (vector / vector.abs().max_element()).normalize()
}

/// A medium as core takes it.
///
/// # Safety
/// `pointer` is NULL or readable, and its density alive while the result is.
pub(crate) unsafe fn read_medium<'a>(
    pointer: *const covbeam_medium,
    name: &'a str,
) -> Result<View<'a, Medium<'a>, Owner<Volume>>, Failure> {
    // SAFETY: by this function's contract.
    let options = unsafe { read_options(pointer, offset_of!(covbeam_medium, density), name) }?;
    let whole = Element::single(options, name);
    for coefficients in [field!(whole, scattering), field!(whole, absorption)] {
        for coefficient in coefficients.value {
            finite_not_negative(coefficients.part(|_| coefficient))?;
        }
    }
    let mut medium = Medium {
        scattering: options.scattering.into(),
        absorption: options.absorption.into(),
        phase: phase(field!(whole, phase))?,
        more: &[],
        density: Density::Uniform,
    };
    if !medium.extinction().element_sum().is_finite() {
        return Err(whole.is(format_args!("scattering and absorption add up to more than a float can be")));
    }
    let mut voxels = None;
    medium.density = match options.density {
        d if d == covbeam_density_kind::COVBEAM_DENSITY_UNIFORM as u32 => Density::Uniform,
        d if d == covbeam_density_kind::COVBEAM_DENSITY_EXPONENTIAL as u32 => {
            Density::Exponential(ExponentialDensity {
                origin: vector(field!(whole, origin))?,
                up: normalized(direction(field!(whole, up))?),
                scale_height: positive(field!(whole, scale_height))?,
            })
        }
        d if d == covbeam_density_kind::COVBEAM_DENSITY_VOXELS as u32 => {
            // SAFETY: by this function's contract.
            let volume = unsafe { shared(options.voxels, "voxels of the medium") }?;
            let density = volume.object().density();
            voxels = Some(volume);
            density
        }
        unknown => {
            return Err(field!(whole, density).is(format_args!("{unknown} is no covbeam_density_kind")));
        }
    };
    Ok(View { value: medium, object: voxels })
}

/// Memory for the table of the column along any ray; none unless the density is in voxels.
pub(crate) fn reserve_table(medium: &Medium, knots: &mut Vec<Knot>) -> Result<(), Failure> {
    knots.clear();
    reserve(knots, medium.density.most_knots())
}

/// The column along a ray, as a gather wants it, its table in the memory of `reserve_table`.
pub(crate) fn tabulated<'k>(
    medium: &Medium,
    origin: Vec3,
    direction: Vec3,
    length: f32,
    knots: &'k mut Vec<Knot>,
) -> Column<'k> {
    knots.clear();
    medium.tabulate(origin, direction, length, &mut |knot| knots.push(knot));
    medium.density.column(origin, direction, knots)
}

#[cfg(test)]
#[allow(clippy::undocumented_unsafe_blocks, reason = "every argument is a local, or refused")]
mod tests {
    use super::*;
    use crate::medium::samples::{fog, haze};
    use crate::status::{covbeam_status, covbeam_status::*};

    /// The density one metre up, if the medium is taken.
    fn density_above(medium: &covbeam_medium) -> Result<f32, covbeam_status> {
        // SAFETY: a medium without voxels, which outlives the view.
        let view = unsafe { read_medium(medium, "medium") };
        view.map(|view| view.value.density.at(Vec3::Y)).map_err(|failure| failure.0)
    }

    #[test]
    fn up_may_have_any_length_but_0() {
        for length in [1e-45, 1e-30, 1.0, 1e30, f32::MAX] {
            let medium = covbeam_medium { up: [0.0, length, 0.0], scale_height: 1.0, ..haze() };
            assert_eq!(density_above(&medium), Ok((-1.0f32).exp()), "{length}");
        }
    }

    #[test]
    fn coefficients_that_add_up_to_infinity_are_refused() {
        let most = covbeam_medium { scattering: [f32::MAX, 0.0, 0.0], absorption: [0.0; 3], ..fog() };
        assert_eq!(density_above(&most), Ok(1.0));
        let more = covbeam_medium { absorption: [f32::MAX, 0.0, 0.0], ..most };
        assert_eq!(density_above(&more), Err(COVBEAM_INVALID_VALUE));
    }
}
