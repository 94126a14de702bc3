//! Densities given in voxels: a handle, because beam maps keep them.

use crate::handle::{Opaque, free, handle_to};
use crate::heap::{Owner, reserved};
use crate::memory::{Slot, inputs, read};
use crate::status::{Failure, covbeam_status, covbeam_status::*, fail, refusal, run};
use crate::voxels::covbeam_grid_layout;
use covbeam_core::{Density, DensityGrid, GridLayout};

/// A relative density given at the centres of voxels, copied from the host. Nothing changes it: any number of
/// threads and beam maps may use it at once.
pub struct covbeam_density(());

impl Opaque for covbeam_density {
    type Object = Owner<Volume>;
    const TAG: u64 = u64::from_le_bytes(*b"cb-densi");
    const NAME: &'static str = "covbeam_density";
}

/// A checked density with the values that it looks at.
pub(crate) struct Volume {
    // Before the values: dropped first.
    grid: DensityGrid<'static>,
    _values: Vec<f32>,
}

impl Volume {
    fn new(layout: GridLayout, values: Vec<f32>) -> Result<Self, Failure> {
        // SAFETY: the values neither move nor change, nor are they freed before `grid`, which is private and leaves
        // this struct only with the lifetime of a borrow of it.
        let forever: &'static [f32] = unsafe { core::slice::from_raw_parts(values.as_ptr(), values.len()) };
        let grid = DensityGrid::new(layout, forever).map_err(|error| refusal("values", error))?;
        Ok(Self { grid, _values: values })
    }

    pub(crate) fn density(&self) -> Density<'_> {
        Density::Grid(self.grid)
    }
}

/// Makes a density from voxels: trilinear between their centres, held over the half voxel at the border of the
/// box, 0 outside.
///
/// @param layout box and resolution.
/// @param values, value_stride, value_count one a voxel, each finite and >= 0, x first, then y, then z.
/// @param out the handle.
/// @note Copies the values: 4 bytes a voxel.
/// @kinds <layout <f:q k +density
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_density_new(
    layout: *const covbeam_grid_layout,
    values: *const f32,
    value_stride: usize,
    value_count: usize,
    out: *mut *mut covbeam_density,
) -> covbeam_status {
    run(|| {
        let out = Slot::new(out, "out")?;
        // SAFETY: by the caller's promise.
        let layout = GridLayout::from(unsafe { read(layout, "layout") }?);
        inputs!(value_count, values, value_stride);
        if value_count != layout.cell_count() {
            let message =
                format_args!("value_count: {value_count}, but the layout has {}", layout.cell_count());
            return Err(fail(COVBEAM_SHORT_BUFFER, message));
        }
        let mut copy = reserved(value_count)?;
        copy.extend((0..value_count).map(|i| values.get(i).value));
        out.set(handle_to(Owner::new(Volume::new(layout, copy)?)?)?);
        Ok(())
    })
}

/// Frees a density. Beam maps that were made with it keep what they need.
///
/// @param density NULL is fine.
/// @kinds !density
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_density_free(density: *mut covbeam_density) -> covbeam_status {
    // SAFETY: by the caller's promise.
    unsafe { free(density, "density") }
}
