//! A plume of smoke that rises from a warm vent and curls.

use crate::fluid::Fluid;
use crate::volume::ByteVolume;

/// Voxels of smoke.vol.
pub const CELLS: [usize; 3] = [48, 96, 48];
/// Steps until the plume's head is below the upper end of smoke.vol.
pub const STEPS: u32 = 135;
/// Edge of a voxel \[m\].
const VOXEL: f32 = 0.04;

/// The plume after `steps` steps on a grid of `cells`: centred on x = z = 0, standing on y = 0, densities relative to
/// the largest. The outermost voxels are empty, so that the trilinear density ends without a step.
///
/// # Panics
/// If `cells` holds less than 16 along an axis, or no smoke has entered after `steps`.
pub fn plume(cells: [usize; 3], steps: u32) -> ByteVolume {
    assert!(cells.iter().all(|n| *n >= 16), "a plume needs at least 16 cells along each axis");
    let mut fluid = Fluid::new(cells, 0.04, 0.16);
    for step in 0..steps {
        feed(&mut fluid, step);
        fluid.step();
    }
    let [nx, ny, nz] = cells;
    let mut density = fluid.density;
    for z in 0..nz {
        for y in 0..ny {
            for x in 0..nx {
                let border = [(x, nx), (y, ny), (z, nz)].iter().any(|(i, n)| *i == 0 || i + 1 == *n);
                if border {
                    let i = density.index(x, y, z);
                    density.values[i] = 0.0;
                }
            }
        }
    }
    let largest = density.values.iter().fold(0.0_f32, |largest, v| largest.max(*v));
    assert!(largest > 0.0, "there is no smoke");
    let half = [nx as f32 * VOXEL / 2.0, nz as f32 * VOXEL / 2.0];
    ByteVolume {
        cells,
        min: [-half[0], 0.0, -half[1]],
        max: [half[0], ny as f32 * VOXEL, half[1]],
        // A conversion to u8 rounds down.
        values: density.values.iter().map(|v| (v / largest * 255.0 + 0.5) as u8).collect(),
    }
}

/// The vent: a disk near the floor that keeps filling with warm smoke and sways, so that the plume does not stay a
/// symmetric column.
fn feed(fluid: &mut Fluid, step: u32) {
    let [nx, _, nz] = fluid.cells;
    let time = step as f32;
    let radius = 0.15 * nx as f32;
    let center = [
        nx as f32 / 2.0 + 0.03 * nx as f32 * libm::sinf(0.21 * time),
        nz as f32 / 2.0 + 0.03 * nx as f32 * libm::sinf(0.17 * time + 1.0),
    ];
    // Puffs, three quarters of the strength apart.
    let strength = 1.0 + 0.6 * libm::sinf(0.35 * time);
    for z in 0..nz {
        for x in 0..nx {
            let (dx, dz) = (x as f32 + 0.5 - center[0], z as f32 + 0.5 - center[1]);
            let inside = 1.0 - (dx * dx + dz * dz) / (radius * radius);
            if inside <= 0.0 {
                continue;
            }
            for y in 2..5 {
                let i = fluid.density.index(x, y, z);
                fluid.density.values[i] = fluid.density.values[i].max(inside.sqrt());
                fluid.heat.values[i] = fluid.heat.values[i].max(strength * inside.sqrt());
            }
        }
    }
}
