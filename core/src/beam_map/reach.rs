//! The kernel radii of eight pairs side by side, looked up in the grid of fluence spectra.

use super::lanes::{LANES, bits};
use super::wide::{Floats, Wide, load};
use crate::{FluenceGrid, KernelRadius};
use fearless_simd::{Select, Simd, SimdBase, SimdFloat, SimdMask, f32x8};
use glam::Vec4;

/// [`KernelRadius::at`] in the lanes of `mask`, bit for bit: radius, and σ along the kernel's axis.
#[inline(always)]
pub(super) fn reach<S: Simd>(
    simd: S,
    radius: &KernelRadius,
    grid: &FluenceGrid,
    position: Wide<S>,
    axis: Wide<S>,
    mask: u32,
) -> (f32x8<S>, f32x8<S>) {
    let (zero, one) = (f32x8::splat(simd, 0.0), f32x8::splat(simd, 1.0));
    let progressive = f32x8::splat(simd, radius.progressive);
    let centres = &grid.centres;
    let layout = &centres.layout;
    let (min, max) = (Wide::splat(simd, layout.min), Wide::splat(simd, layout.max));
    let contained = position.x.simd_ge(min.x)
        & position.y.simd_ge(min.y)
        & position.z.simd_ge(min.z)
        & position.x.simd_le(max.x)
        & position.y.simd_le(max.y)
        & position.z.simd_le(max.z);
    let mask = mask & contained.to_bitmask() as u32;
    if mask == 0 {
        return (progressive, zero);
    }
    let [scale, last] = [centres.scale, centres.last];
    let (bx, hx) = cell(simd, (position.x - min.x) * scale.x - 0.5, last.x);
    let (by, hy) = cell(simd, (position.y - min.y) * scale.y - 0.5, last.y);
    let (bz, hz) = cell(simd, (position.z - min.z) * scale.z - 0.5, last.z);
    let (lx, ly, lz) = (one - hx, one - hy, one - hz);
    let [ll, hl, lh, hh] = [ly * lz, hy * lz, ly * hz, hy * hz];
    let shares = [lx * ll, hx * ll, lx * hl, hx * hl, lx * lh, hx * lh, lx * hh, hx * hh];

    let mut bases = [0; LANES];
    let (bx, by, bz): (Floats, Floats, Floats) = (bx.into(), by.into(), bz.into());
    let mut weights = [[0.0; LANES]; 8];
    let [dx, dy, dz] = centres.strides;
    for lane in bits(mask) {
        let base =
            bx[lane] as u32 as usize * dx + by[lane] as u32 as usize * dy + bz[lane] as u32 as usize * dz;
        bases[lane] = base;
        for (weights, corner) in weights.iter_mut().zip(centres.corners) {
            weights[lane] = grid.cells[base + corner].weight;
        }
    }

    let mut factors = [[0.0; LANES]; 8];
    let (mut flux, mut share_sum, mut inverse) = (zero, zero, zero);
    for corner in 0..8 {
        let (weight, share) = (load(simd, &weights[corner]), shares[corner]);
        let lit = weight.simd_gt(zero);
        let factor = share * lit.select(weight, zero);
        factors[corner] = factor.into();
        flux += factor;
        share_sum += lit.select(share, zero);
        inverse += lit.select(share / weight, zero);
    }

    let mut sums = [[0.0; LANES]; 6];
    for lane in bits(mask) {
        let (mut first, mut second) = (Vec4::ZERO, Vec4::ZERO);
        for (factors, corner) in factors.iter().zip(centres.corners) {
            let cell = &grid.cells[bases[lane] + corner];
            let (s, factor) = (&cell.spectrum, factors[lane]);
            first += Vec4::new(s.xx, s.yy, s.zz, s.xy) * factor;
            // The weight only fills the register.
            second += Vec4::new(s.xy, s.xz, s.yz, cell.weight) * factor;
        }
        let [xx, yy, zz, xy] = first.to_array();
        let [_, xz, yz, _] = second.to_array();
        for (sum, value) in sums.iter_mut().zip([xx, yy, zz, xy, xz, yz]) {
            sum[lane] = value;
        }
    }

    let [xx, yy, zz] =
        [load(simd, &sums[0]) / flux, load(simd, &sums[1]) / flux, load(simd, &sums[2]) / flux];
    let [xy, xz, yz] =
        [load(simd, &sums[3]) / flux, load(simd, &sums[4]) / flux, load(simd, &sums[5]) / flux];
    let Wide { x, y, z } = axis;
    let along = x * x * xx + y * y * yy + z * z * zz + 2.0 * (x * y * xy + x * z * xz + y * z * yz);
    let along = along.simd_gt(zero).select(along, zero);
    let dimmest = share_sum / inverse;
    let dimmest = dimmest.simd_lt(flux).select(dimmest, flux);
    let variance = along * (flux / dimmest);
    let wanted = (f32x8::splat(simd, radius.kernel.error_over_moment(radius.error)) / variance).sqrt();
    let ceiling = f32x8::splat(simd, radius.ceiling);
    let wanted = wanted.simd_lt(ceiling).select(wanted, ceiling);
    let wanted = wanted.simd_gt(progressive).select(wanted, progressive);
    let lit = flux.simd_gt(zero);
    (lit.select(wanted, progressive), lit.select(variance.sqrt(), zero))
}

/// Of one coordinate in voxels: the lower of the two around it, and the share of the upper one.
#[inline(always)]
fn cell<S: Simd>(simd: S, at: f32x8<S>, last: f32) -> (f32x8<S>, f32x8<S>) {
    let zero = f32x8::splat(simd, 0.0);
    let at = at.max(zero).min(f32x8::splat(simd, last));
    // The last centre is reached with weight 1 from the voxel before it.
    let low = at.min(f32x8::splat(simd, last - 1.0)).max(zero).floor();
    (low, at - low)
}
