//! Media that objects hold.

use super::options::{covbeam_medium, read_medium};
use super::voxel_density::Volume;
use crate::handle::View;
use crate::heap::Owner;
use crate::status::Failure;
use covbeam_core::{Density, ExponentialDensity, Medium};

/// A medium that an object holds.
pub(crate) struct KeptMedium {
    coefficients: Medium<'static>,
    density: KeptDensity,
}

enum KeptDensity {
    Uniform,
    Exponential(ExponentialDensity),
    Voxels(Owner<Volume>),
}

impl KeptMedium {
    /// A copy that lives as long as it is kept.
    ///
    /// # Safety
    /// `pointer` is NULL or readable, and its density alive during the call.
    pub(crate) unsafe fn read(pointer: *const covbeam_medium, name: &str) -> Result<Self, Failure> {
        // SAFETY: by this function's contract.
        let View { value: medium, object: voxels } = unsafe { read_medium(pointer, name) }?;
        let density = match (voxels, medium.density) {
            (Some(volume), _) => KeptDensity::Voxels((*volume).clone()),
            (None, Density::Exponential(exponential)) => KeptDensity::Exponential(exponential),
            (None, _) => KeptDensity::Uniform,
        };
        let Medium { scattering, absorption, phase, .. } = medium;
        Ok(Self {
            coefficients: Medium { scattering, absorption, phase, more: &[], density: Density::Uniform },
            density,
        })
    }

    /// As core takes it.
    pub(crate) fn view(&self) -> Medium<'_> {
        let density = match &self.density {
            KeptDensity::Uniform => Density::Uniform,
            KeptDensity::Exponential(exponential) => Density::Exponential(*exponential),
            KeptDensity::Voxels(volume) => volume.density(),
        };
        Medium { density, ..self.coefficients }
    }
}
