//! What a kernel module or a console would link: covbeam behind three C functions, with nothing under it but
//! `core`.
//!
//! The panic handler below clashes with std's own, so this crate links only if no dependency pulls std in.
#![no_std]
#![deny(missing_docs)]

mod importance;
mod operators;
mod vectors;
mod words;

use core::{ptr, slice};

use covbeam::{
    Beam, Column, CovarianceGrid, EyeRay, FluenceCell, FluenceGrid, Gathered, GridCell, GridLayout, Kernel,
    KernelShape, LightField, Medium, Vec3, gather_pair,
};

unsafe extern "C" {
    /// Ends the program; the C side has it.
    safe fn covbeam_bare_metal_panicked() -> !;
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    covbeam_bare_metal_panicked()
}

/// The grid that the C program provides cells for.
const LAYOUT: GridLayout = GridLayout { min: Vec3::splat(-1.0), max: Vec3::splat(7.0), cells: [4, 4, 4] };

/// The results that the C program checks.
#[repr(C)]
#[derive(Default)]
pub struct Results {
    /// Slice of the occluded light along the occluder's axis \[cycles²/m²\].
    pub occluded: f32,
    /// Fluence spectrum looked up along the same axis, at the middle of the only voxel with data.
    pub looked_up: f32,
    /// Radius that the grid asks for there \[m\].
    pub radius: f32,
    /// Radiance gathered from one pair of beam and eye ray.
    pub radiance: f32,
}

/// Number of cells that [`covbeam_bare_metal`] wants.
#[unsafe(no_mangle)]
pub extern "C" fn covbeam_bare_metal_cells() -> usize {
    LAYOUT.cell_count()
}

/// A lamp with `angular_variance`, an edge after `before`, a deposit after another `behind`, a look-up and
/// the gather of one pair. 0 = done.
///
/// # Safety
///
/// `sums` and `means` are zeroed arrays of `count` cells (56 and 28 bytes each), `results` is one struct; all
/// are aligned and not shared.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_bare_metal(
    angular_variance: f32,
    before: f32,
    edge: f32,
    behind: f32,
    sums: *mut GridCell,
    means: *mut FluenceCell,
    count: usize,
    results: *mut Results,
) -> i32 {
    // SAFETY: the caller's contract; all-zero bytes are valid cells.
    let (sums, means) =
        unsafe { (slice::from_raw_parts_mut(sums, count), slice::from_raw_parts_mut(means, count)) };
    match chain(angular_variance, before, edge, behind, sums, means) {
        Some(found) => {
            // SAFETY: the caller's contract.
            unsafe { ptr::write(results, found) };
            0
        }
        None => 1,
    }
}

/// Replays `tests/vectors.txt`, as this program was built with it.
#[unsafe(no_mangle)]
pub extern "C" fn covbeam_bare_metal_vectors() -> vectors::Replay {
    vectors::replay(include_bytes!("../../vectors.txt"))
}

fn chain(
    angular_variance: f32,
    before: f32,
    edge: f32,
    behind: f32,
    sums: &mut [GridCell],
    means: &mut [FluenceCell],
) -> Option<Results> {
    let mut light = LightField::point(Vec3::Z, angular_variance);
    light.travel(before);
    light.occlude(Vec3::X, edge);
    light.travel(behind);
    let fluence = light.fluence();

    let mut grid = CovarianceGrid::new(LAYOUT, sums).ok()?;
    // The voxel from (-1, -1, 3) to (1, 1, 5).
    let middle = Vec3::new(0.0, 0.0, 4.0);
    grid.deposit_spectrum(middle, &fluence, 2.0);
    grid.resolve(means).ok()?;
    let grid = FluenceGrid::new(LAYOUT, means).ok()?;
    let found = grid.look_up(middle)?;

    let kernel = Kernel {
        shape: KernelShape::Epanechnikov,
        min_radius: 0.01,
        max_radius: 1.0,
        error: 0.05,
        grid: Some(grid),
    };
    let medium = Medium { scattering: Vec3::splat(0.5), ..Medium::default() };
    let beam = Beam {
        origin: Vec3::ZERO,
        direction: Vec3::Z,
        length: 10.0,
        power: Vec3::ONE,
        start_normal: Vec3::ZERO,
        end_normal: Vec3::ZERO,
    };
    // Straight across the beam, past it by nothing: K(0) = 3/(4r).
    let ray = EyeRay { origin: Vec3::new(0.0, -1.0, 4.0), direction: Vec3::Y, length: 5.0 };
    let mut gathered = Gathered::default();
    if !gather_pair(&ray, &beam, [0.0, beam.length], &medium, &[Column::Uniform; 2], &kernel, &mut gathered) {
        return None;
    }
    Some(Results {
        occluded: fluence.variance_along(Vec3::X),
        looked_up: found.variance_along(Vec3::X),
        radius: kernel.radius_at(middle, Vec3::X).0,
        radiance: gathered.radiance.y,
    })
}
