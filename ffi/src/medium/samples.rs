//! Media of all three kinds and a ray, for tests.

use super::options::{covbeam_density_kind::*, covbeam_medium};
use super::phase::covbeam_phase;
use super::voxel_density::{covbeam_density, covbeam_density_free, covbeam_density_new};
use crate::hostile::{Rule, Rule::*};
use crate::status::covbeam_status::*;
use crate::voxels::covbeam_grid_layout;
use core::ptr;

/// Homogeneous, a colour of its own in each channel.
pub(crate) fn fog() -> covbeam_medium {
    covbeam_medium {
        struct_size: size_of::<covbeam_medium>() as u32,
        scattering: [0.2, 0.3, 0.4],
        absorption: [0.0, 0.1, 0.2],
        phase: covbeam_phase { kind: 1, asymmetry: 0.5 },
        density: COVBEAM_DENSITY_UNIFORM as u32,
        origin: [0.0; 3],
        up: [0.0; 3],
        scale_height: 0.0,
        voxels: ptr::null(),
    }
}

/// Thinner with height, which is along y.
pub(crate) fn haze() -> covbeam_medium {
    covbeam_medium {
        density: COVBEAM_DENSITY_EXPONENTIAL as u32,
        up: [0.0, 2.0, 0.0],
        scale_height: 2.0,
        ..fog()
    }
}

/// Two voxels a side in the unit cube.
pub(crate) struct Smoke {
    pub(crate) medium: covbeam_medium,
    voxels: *mut covbeam_density,
}

impl Drop for Smoke {
    fn drop(&mut self) {
        // SAFETY: made below, once.
        assert_eq!(unsafe { covbeam_density_free(self.voxels) }, COVBEAM_OK);
    }
}

pub(crate) fn smoke() -> Smoke {
    let layout = covbeam_grid_layout { min: [0.0; 3], max: [1.0; 3], cells: [2; 3] };
    let values: [f32; 8] = [1.0, 3.0, 0.5, 2.0, 4.0, 0.0, 1.5, 2.5];
    let mut voxels = ptr::null_mut();
    // SAFETY: all arguments are locals.
    let status = unsafe { covbeam_density_new(&layout, values.as_ptr(), 4, 8, &mut voxels) };
    assert_eq!(status, COVBEAM_OK);
    let medium = covbeam_medium { density: COVBEAM_DENSITY_VOXELS as u32, voxels, ..fog() };
    Smoke { medium, voxels }
}

/// Origin, then direction.
pub(crate) const RAY: [(f32, Rule); 6] =
    [(0.2, Finite), (0.3, Finite), (-1.0, Finite), (0.0, Across), (0.0, Across), (1.0, Along)];
