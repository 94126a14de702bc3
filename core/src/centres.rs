//! Trilinear interpolation between the centres of voxels, held over the half voxel at the border of the box.

use crate::{GridError, GridLayout};
use glam::Vec3;

/// Where the centres of a layout's voxels are, ready for look-ups.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Centres {
    pub(crate) layout: GridLayout,
    /// Voxels per metre.
    pub(crate) scale: Vec3,
    /// Index of the last voxel on each axis.
    pub(crate) last: Vec3,
    /// Steps to the next voxel on each axis; 0 where there is but one.
    pub(crate) strides: [usize; 3],
    /// Steps from the lowest of the eight voxels around a point to each of them: x first, then y, then z.
    pub(crate) corners: [usize; 8],
}

impl Centres {
    /// Of a layout with this number of values, one a voxel.
    pub(crate) fn new(layout: GridLayout, values: usize) -> Result<Self, GridError> {
        let scale = layout.scale()?;
        if values != layout.cell_count() {
            return Err(GridError::Length);
        }
        let [nx, ny, nz] = layout.cells.map(|n| n as usize);
        let stride = |count: usize, stride: usize| if count > 1 { stride } else { 0 };
        let strides @ [dx, dy, dz] = [stride(nx, 1), stride(ny, nx), stride(nz, nx * ny)];
        let corners = [0, dx, dy, dx + dy, dz, dx + dz, dy + dz, dx + dy + dz];
        Ok(Self { layout, scale, last: layout.resolution() - 1.0, strides, corners })
    }

    /// Index of the lowest of the eight voxels around a point, and the share of the next one on each axis, in \[0, 1\].
    /// None outside the box and for NaN.
    #[inline(always)]
    pub(crate) fn around(&self, position: Vec3) -> Option<(usize, Vec3)> {
        if !self.layout.contains(position) {
            return None;
        }
        let at = ((position - self.layout.min) * self.scale - 0.5).clamp(Vec3::ZERO, self.last);
        // The last centre is reached with weight 1 from the voxel before it.
        let corner = at.min(self.last - 1.0).max(Vec3::ZERO);
        let [x, y, z] = [corner.x as u32, corner.y as u32, corner.z as u32];
        let high = at - Vec3::new(x as f32, y as f32, z as f32);
        let [dx, dy, dz] = self.strides;
        Some((x as usize * dx + y as usize * dy + z as usize * dz, high))
    }
}
