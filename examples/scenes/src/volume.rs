//! Densities on a grid of voxels, and writing them in Mitsuba's grid volume format.

/// Densities with values 0..=255 for 0 to 1.
#[derive(Clone, Debug, PartialEq)]
pub struct ByteVolume {
    /// Voxels along x, y and z.
    pub cells: [usize; 3],
    /// Lower corner of the box.
    pub min: [f32; 3],
    /// Upper corner of the box.
    pub max: [f32; 3],
    /// Densities at the voxels' centres, x first, then y, then z.
    pub values: Vec<u8>,
}

impl ByteVolume {
    /// The file, little-endian: `VOL`, version 3 (u8), encoding 3 = u8 (i32), voxels along x, y, z (i32), channels 1
    /// (i32), the box (6 f32: lower corner, upper corner), the densities.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = b"VOL\x03".to_vec();
        let [nx, ny, nz] = self.cells.map(|n| n as i32);
        for number in [3, nx, ny, nz, 1] {
            bytes.extend(number.to_le_bytes());
        }
        for number in self.min.iter().chain(&self.max) {
            bytes.extend(number.to_le_bytes());
        }
        bytes.extend(&self.values);
        bytes
    }
}
