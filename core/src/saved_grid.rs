//! The accumulating grid as bytes, to keep it between sessions or to send it.
//!
//! # Format
//!
//! Little endian, the same bytes on every machine; 56 bytes of header and 56 a voxel.
//!
//! | byte | what |
//! |---|---|
//! | 0..8 | `covbeamG` in ASCII |
//! | 8..12 | version, u32: 1 |
//! | 12..24 | lower corner x, y, z \[m\], f32 each |
//! | 24..36 | upper corner x, y, z \[m\], f32 each |
//! | 36..48 | voxels along x, y, z, u32 each |
//! | 48..56 | checksum, u64: FNV-1a of all other bytes, in their order |
//! | 56 + 56 i .. | voxel i, x first, then y, then z: Σ w·(xx, yy, zz, xy, xz, yz) and Σ w, f64 each |
//!
//! Why a checksum: with one bit of a mantissa turned over, a sum is still a sum that deposits could have
//! made. FNV-1a (Fowler, Noll and Vo) needs no tables; each of its steps is invertible, so a single damaged
//! byte never goes unseen. It is no protection against forgery: that is what the checks of the values are
//! for.

use libm::sqrt;

use crate::grid::{CovarianceGrid, GridCell};
use crate::voxels::{GridError, GridLayout};
use glam::Vec3;

/// Magic and version.
const START: [u8; 12] = *b"covbeamG\x01\0\0\0";

/// Bytes of the header up to the checksum, and with it.
const CHECKED: usize = 48;
const HEADER: usize = CHECKED + 8;

/// Bytes of a voxel.
const VOXEL: usize = 7 * 8;

/// Relative error allowed to a voxel's sums. The six numbers of a deposit are rounded to f32 at most three
/// times each, 4e-7 between a covariance and its variances, and n additions in f64 lose at most n/2⁵³, 1e-6
/// in 10¹⁰ deposits. Ten times that does no harm: a variance along an axis is never read below 0.
const ROUNDING: f64 = 1e-5;

/// Absolute error allowed to a deposit's mean variance: below f32's range, where a variance of 1e-60 is 0
/// while its covariance with one of 1 is still 1e-30. A deposit is rounded to multiples of 2⁻¹⁴⁹ at most
/// three times, the variances down and the covariance up.
const UNDERFLOW: f64 = 4.0 * f32::from_bits(1) as f64;

impl GridLayout {
    /// Number of bytes that [`GridLayout::save`] writes for a grid of this layout: 56 + 56 a voxel
    /// (saturating at the largest `usize`).
    pub fn saved_size(&self) -> usize {
        self.cell_count().saturating_mul(VOXEL).saturating_add(HEADER)
    }

    /// The layout of a saved grid, so that cells can be had for it before it is loaded.
    ///
    /// - `bytes`: all that [`GridLayout::save`] wrote.
    ///
    /// Guarantee: the layout is sound, and `bytes` has its [`GridLayout::saved_size`]: who allocates for it
    /// needs no more than the bytes do. The checksum is left to [`CovarianceGrid::load`]: the cost does not
    /// depend on the length.
    ///
    /// Errors: `Format` for anything that does not start as a saved grid of version 1 does, `Layout` for a
    /// layout that [`CovarianceGrid::new`] would refuse, `Length` for bytes that are missing or too many.
    pub fn of_saved(bytes: &[u8]) -> Result<GridLayout, GridError> {
        let (header, _) = bytes.split_first_chunk::<HEADER>().ok_or(GridError::Format)?;
        let (start, rest) = header.split_at(START.len());
        if start != START {
            return Err(GridError::Format);
        }
        let corner =
            |at: usize| Vec3::from_array([0, 1, 2].map(|axis| f32::from_le_bytes(number(rest, at + axis))));
        let cells = [6, 7, 8].map(|at| u32::from_le_bytes(number(rest, at)));
        let layout = GridLayout { min: corner(0), max: corner(3), cells };
        layout.scale()?;
        if bytes.len() == layout.saved_size() { Ok(layout) } else { Err(GridError::Length) }
    }

    /// Writes the layout and all cells as bytes, for [`CovarianceGrid::load`] on this or another machine.
    ///
    /// - `cells`: those of the grid, as many as the layout has.
    /// - `out`: [`GridLayout::saved_size`] bytes.
    ///
    /// Guarantee: what is written can be loaded, and gives the cells back bit for bit. Grids with equal bits
    /// give equal bytes. Cost: 0.1 µs a voxel.
    ///
    /// Errors, with nothing written: `Layout` if it is not sound; `Length` for `cells` or an `out` of another
    /// length; `Value` where the sums of a voxel are none that deposits of covariances add up to, as
    /// [`CovarianceGrid::load`] would refuse them.
    ///
    /// ```
    /// use covbeam::{CovarianceGrid, FluenceSpectrum, GridCell, GridLayout, Vec3};
    /// let layout = GridLayout { min: Vec3::ZERO, max: Vec3::ONE, cells: [1, 1, 2] };
    /// let mut cells = [GridCell::default(); 2];
    /// let mut grid = CovarianceGrid::new(layout, &mut cells)?;
    /// grid.deposit_spectrum(Vec3::splat(0.2), &FluenceSpectrum { xx: 4.0, ..FluenceSpectrum::default() }, 0.5);
    /// let mut bytes = [0; 56 + 56 * 2];
    /// assert_eq!(bytes.len(), layout.saved_size());
    /// layout.save(&cells, &mut bytes)?;
    ///
    /// let mut others = [GridCell::default(); 2];
    /// assert_eq!(GridLayout::of_saved(&bytes)?, layout);
    /// CovarianceGrid::new(layout, &mut others)?.load(&bytes)?;
    /// assert_eq!(others, cells);
    /// # Ok::<(), covbeam::GridError>(())
    /// ```
    pub fn save(&self, cells: &[GridCell], out: &mut [u8]) -> Result<(), GridError> {
        self.scale()?;
        if cells.len() != self.cell_count() || out.len() != self.saved_size() {
            return Err(GridError::Length);
        }
        if !cells.iter().all(is_possible) {
            return Err(GridError::Value);
        }
        let (header, body) = out.split_at_mut(HEADER);
        header[..CHECKED].copy_from_slice(&header_of(self));
        for (bytes, cell) in body.chunks_exact_mut(VOXEL).zip(cells) {
            let numbers = cell.sum.into_iter().chain([cell.weight]);
            for (bytes, number) in bytes.chunks_exact_mut(8).zip(numbers) {
                bytes.copy_from_slice(&number.to_le_bytes());
            }
        }
        let sum = checksum(&header[..CHECKED], body);
        header[CHECKED..].copy_from_slice(&sum.to_le_bytes());
        Ok(())
    }
}

impl CovarianceGrid<'_> {
    /// Replaces the cells by those of a saved grid.
    ///
    /// - `bytes`: all that [`GridLayout::save`] wrote, from a grid whose layout equals this one's bit for
    ///   bit.
    ///
    /// Guarantee: bytes of any content are safe. Depositing goes on as if the grid had never been saved.
    /// Cost: 0.1 µs a voxel.
    ///
    /// Errors, with no cell changed: those of [`GridLayout::of_saved`]; `Damaged` if the checksum differs;
    /// `OtherLayout` if the layout does; `Value` where a voxel cannot come from deposits of covariances: a
    /// number not finite, a weight below 0, a variance below 0 or with a mean beyond f32 (so that without
    /// weight all is 0), a covariance beyond the root of its two variances' product by more than rounding.
    pub fn load(&mut self, bytes: &[u8]) -> Result<(), GridError> {
        GridLayout::of_saved(bytes)?;
        let (header, body) = bytes.split_at(HEADER);
        let (header, sum) = header.split_at(CHECKED);
        if sum != checksum(header, body).to_le_bytes() {
            return Err(GridError::Damaged);
        }
        if header != header_of(&self.layout) {
            return Err(GridError::OtherLayout);
        }
        let voxels = body.chunks_exact(VOXEL).map(cell_of);
        if !voxels.clone().all(|cell| is_possible(&cell)) {
            return Err(GridError::Value);
        }
        for (cell, saved) in self.cells.iter_mut().zip(voxels) {
            *cell = saved;
        }
        Ok(())
    }
}

/// The header up to the checksum.
fn header_of(layout: &GridLayout) -> [u8; CHECKED] {
    let mut header = [0; CHECKED];
    let (start, rest) = header.split_at_mut(START.len());
    start.copy_from_slice(&START);
    let corners = layout.min.to_array().into_iter().chain(layout.max.to_array());
    let words = corners.map(f32::to_bits).chain(layout.cells);
    for (bytes, word) in rest.chunks_exact_mut(4).zip(words) {
        bytes.copy_from_slice(&word.to_le_bytes());
    }
    header
}

/// The bytes of the number at `index` of those that stand one behind the other.
fn number<const SIZE: usize>(bytes: &[u8], index: usize) -> [u8; SIZE] {
    core::array::from_fn(|byte| bytes[index * SIZE + byte])
}

fn cell_of(voxel: &[u8]) -> GridCell {
    let at = |index: usize| f64::from_le_bytes(number(voxel, index));
    GridCell { sum: [0, 1, 2, 3, 4, 5].map(at), weight: at(6) }
}

/// Whether deposits of covariances can add up to these sums. By Cauchy and Schwarz a sum of covariances obeys
/// the bound that each of them does.
fn is_possible(cell: &GridCell) -> bool {
    let GridCell { sum: [xx, yy, zz, xy, xz, yz], weight } = *cell;
    let largest = f64::from(f32::MAX) * weight * (1.0 + ROUNDING);
    let variances = [xx, yy, zz];
    // Roots before the product, which may leave f64's range.
    let [x, y, z] = variances.map(|variance| sqrt(variance + UNDERFLOW * weight));
    let bounded = |covariance: f64, product: f64| covariance.abs() <= product * (1.0 + ROUNDING);
    cell.sum.iter().all(|sum| sum.is_finite())
        && weight.is_finite()
        // A weight below 0 leaves no room for a variance.
        && variances.iter().all(|variance| (0.0..=largest).contains(variance))
        && bounded(xy, x * y)
        && bounded(xz, x * z)
        && bounded(yz, y * z)
}

/// FNV-1a of 64 bits over both slices.
fn checksum(header: &[u8], body: &[u8]) -> u64 {
    header
        .iter()
        .chain(body)
        .fold(0xCBF2_9CE4_8422_2325, |sum, &byte| (sum ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01B3))
}
