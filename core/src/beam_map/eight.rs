//! The gather of [`crate::gather_pair`], eight pairs side by side and bit for bit: each function names the
//! one that defines it.

use super::simd::{Floats, LANES, Vec3x8, Vectors, bits, exp, load, max, min};
use super::sub_beams::{ROOM, SubBeam};
use crate::along::{Along, along};
use crate::beam::{ALONG_SINE, Beam, BeamBlock, EyeRay};
use crate::grid::FluenceGrid;
use crate::kernel::{Kernel, KernelShape};
use crate::medium::{Medium, PhaseFunction, PhaseKind};
use crate::pair::{Gathered, inside};
use crate::voxels::{GridLayout, Trilinear};
use fearless_simd::{Select, Simd, SimdBase, SimdFloat, SimdMask, f32x8, mask32x8};
use glam::{Vec3, Vec4};

/// Puts the lines of up to [`LANES`] sub-beams into an empty block.
#[inline(always)]
pub(super) fn fill(lines: &mut BeamBlock, sub_beams: &[SubBeam]) {
    for (lane, sub_beam) in sub_beams.iter().enumerate().take(LANES) {
        lines.set_line(lane, sub_beam.origin, sub_beam.direction, sub_beam.from, sub_beam.to);
    }
}

/// Up to eight sub-beams side by side, with all that pairs need of the beams.
#[derive(Clone, Copy, Debug)]
pub(super) struct Block {
    lines: BeamBlock,
    length: Floats,
    pub(super) power: Vectors,
    pub(super) beams: [u32; LANES],
}

impl Block {
    /// Of none.
    pub(super) const EMPTY: Self =
        Self { lines: BeamBlock::EMPTY, length: [0.0; LANES], power: [[0.0; LANES]; 3], beams: [0; LANES] };

    /// Puts up to [`LANES`] sub-beams in.
    #[inline(always)]
    pub(super) fn fill(&mut self, beams: &[Beam], sub_beams: &[SubBeam]) {
        fill(&mut self.lines, sub_beams);
        for (lane, sub_beam) in sub_beams.iter().enumerate().take(LANES) {
            let beam = &beams[sub_beam.beam as usize];
            self.length[lane] = beam.length;
            set(&mut self.power, lane, beam.power);
            self.beams[lane] = sub_beam.beam;
        }
    }

    /// Directions of the beams.
    #[inline(always)]
    pub(super) fn directions<S: Simd>(&self, simd: S) -> Vec3x8<S> {
        Vec3x8::load(simd, &self.lines.direction)
    }

    /// The places of the pair in a lane, which runs along the ray.
    pub(super) fn along(&self, lane: usize, ray: &EyeRay, beams: &[Beam], kernel: &Kernel) -> Option<Along> {
        let beam = &beams[self.beams[lane] as usize];
        along(ray, beam, self.lines.from[lane], self.lines.to[lane], kernel)
    }

    /// The sub-beam of a lane in all lanes.
    pub(super) fn repeated(&self, lane: usize) -> Self {
        let mut block = Self::EMPTY;
        let [origin, direction] =
            [&self.lines.origin, &self.lines.direction].map(|vectors| vector(vectors, lane));
        let (from, to) = (self.lines.from[lane], self.lines.to[lane]);
        for place in 0..LANES {
            block.lines.set_line(place, origin, direction, from, to);
            block.length[place] = self.length[lane];
            set(&mut block.power, place, vector(&self.power, lane));
            block.beams[place] = self.beams[lane];
        }
        block
    }
}

/// The pairs of one eye ray and a block; what is in lanes that are not accepted means nothing.
pub(super) struct Pairs<'a, S: Simd> {
    /// Which lanes hold a pair that is accepted, a bit each.
    pub(super) accepted: u32,
    pub(super) block: &'a Block,
    /// As in [`super::Contact`].
    pub(super) position: Vec3x8<S>,
    pub(super) ray_distance: f32x8<S>,
    pub(super) beam_distance: f32x8<S>,
    pub(super) cos_theta: f32x8<S>,
    pub(super) kernel: f32x8<S>,
    pub(super) radius: f32x8<S>,
    pub(super) sigma: f32x8<S>,
}

#[inline(always)]
pub(super) fn vector(vectors: &Vectors, lane: usize) -> Vec3 {
    Vec3::new(vectors[0][lane], vectors[1][lane], vectors[2][lane])
}

#[inline(always)]
fn set(vectors: &mut Vectors, lane: usize, vector: Vec3) {
    for (axis, value) in vectors.iter_mut().zip(vector.to_array()) {
        axis[lane] = value;
    }
}

/// An eye ray in all lanes.
#[derive(Clone, Copy)]
pub(super) struct Ray<S: Simd> {
    origin: Vec3x8<S>,
    direction: Vec3x8<S>,
    length: f32,
}

impl<S: Simd> Ray<S> {
    #[inline(always)]
    pub(super) fn new(simd: S, ray: &EyeRay) -> Self {
        let EyeRay { origin, direction, length } = *ray;
        Self { origin: Vec3x8::splat(simd, origin), direction: Vec3x8::splat(simd, direction), length }
    }
}

impl<'a, S: Simd> Pairs<'a, S> {
    /// The pairs of a block that cross `ray`; None if all pass each other farther away than kernels reach.
    /// The arithmetic of [`crate::pair::meet`], and its bits.
    #[inline(always)]
    pub(super) fn new(
        simd: S,
        ray: &Ray<S>,
        block: &'a Block,
        lines: &Lines<S>,
        beams: &[Beam],
        kernel: &Kernel,
    ) -> Option<Self> {
        let found = Crossings::new(simd, ray, &block.lines, lines, kernel.max_radius)?;
        let Crossings { near, position, ray_distance, beam_distance, gap, .. } = found;
        let zero = f32x8::splat(simd, 0.0);
        let (radius, sigma) = match &kernel.grid {
            None => (f32x8::splat(simd, kernel.min_radius), zero),
            Some(grid) => {
                let axis = found.normal * found.inverse_sin;
                radii(simd, kernel, grid, position, axis, near.to_bitmask() as u32)
            }
        };

        // Most pairs lie farther from both ends of their beam than the kernel reaches. A sub-beam's cut is no
        // end.
        let (from, to) = (load(simd, &block.lines.from), load(simd, &block.lines.to));
        let length = load(simd, &block.length);
        let within = gap.simd_lt(radius)
            & (beam_distance.simd_ge(from) | !from.simd_gt(zero))
            & (beam_distance.simd_lt(to) | !to.simd_lt(length));
        let away = beam_distance.simd_ge(radius) & beam_distance.simd_le(length - radius);
        let mut accepted = (near & within & away).to_bitmask() as u32;
        let at_an_end = (near & within & !away).to_bitmask() as u32;
        if at_an_end != 0 {
            let (points, lines) = (position.store(), &block.lines);
            let [distances, gaps, radii]: [Floats; 3] = [beam_distance.into(), gap.into(), radius.into()];
            for lane in bits(at_an_end) {
                let beam = &beams[block.beams[lane] as usize];
                let (from, to, point) = (lines.from[lane], lines.to[lane], vector(&points, lane));
                let inside = inside(beam, from, to, point, distances[lane], gaps[lane], radii[lane]);
                accepted |= u32::from(inside) << lane;
            }
        }
        Some(Self {
            accepted,
            block,
            position,
            ray_distance,
            beam_distance,
            cos_theta: found.cos_theta,
            kernel: evaluate(simd, kernel.shape, gap, radius) / found.sin_theta,
            radius,
            sigma,
        })
    }

    /// The places of a pair along the ray, each in a lane.
    ///
    /// - `block`: [`Block::repeated`].
    #[inline(always)]
    pub(super) fn along(simd: S, ray: &Ray<S>, block: &'a Block, along: &Along) -> Self {
        let ray_distance = load(simd, &along.ray_distance);
        Self {
            accepted: (1 << LANES) - 1,
            block,
            position: ray.origin + ray.direction * ray_distance,
            ray_distance,
            beam_distance: load(simd, &along.beam_distance),
            cos_theta: -Vec3x8::load(simd, &block.lines.direction).dot(ray.direction),
            kernel: load(simd, &along.kernel),
            radius: f32x8::splat(simd, along.radius),
            sigma: f32x8::splat(simd, along.sigma),
        }
    }
}

/// What eight pairs of an eye ray and a sub-beam are told apart by.
pub(super) struct Lines<S: Simd> {
    direction: Vec3x8<S>,
    offset: Vec3x8<S>,
    /// The common perpendicular, times the sine.
    normal: Vec3x8<S>,
    /// sin² θ.
    sin2: f32x8<S>,
}

impl<S: Simd> Lines<S> {
    #[inline(always)]
    pub(super) fn new(simd: S, ray: &Ray<S>, block: &Block) -> Self {
        let direction = Vec3x8::load(simd, &block.lines.direction);
        let normal = ray.direction.cross(direction);
        let offset = Vec3x8::load(simd, &block.lines.origin) - ray.origin;
        Self { direction, offset, normal, sin2: normal.dot(normal) }
    }

    /// Lanes in which the two run along each other: [`crate::beam::is_along`].
    #[inline(always)]
    fn are_along(&self, simd: S) -> mask32x8<S> {
        self.sin2.simd_lt(f32x8::splat(simd, ALONG_SINE * ALONG_SINE))
    }

    /// A bit for each of these that may come within `radius`; lanes without a sub-beam have none.
    #[inline(always)]
    pub(super) fn along(&self, simd: S, ray: &Ray<S>, block: &Block, radius: f32) -> u32 {
        let are_along = self.are_along(simd);
        if are_along.to_bitmask() == 0 {
            return 0;
        }
        // As `BeamBlock::runs_along`.
        let (from, to) = (load(simd, &block.lines.from), load(simd, &block.lines.to));
        let middle = self.offset + self.direction * ((from + to) * 0.5);
        let wide = radius * ROOM;
        let half = (to - from) * 0.5 + wide;
        let room = (middle.x.abs() + middle.y.abs() + middle.z.abs() + half) * 1e-6;
        let apart = half * self.sin2.sqrt() + wide + room;
        let across = middle.cross(ray.direction);
        let along = middle.dot(ray.direction);
        let close = are_along
            & across.dot(across).simd_le(apart * apart)
            & (along + half + room).simd_ge(f32x8::splat(simd, 0.0))
            & along.simd_le(half + room + ray.length);
        close.to_bitmask() as u32
    }
}

/// [`crate::cross`] of one eye ray and eight sub-beams.
struct Crossings<S: Simd> {
    /// Lanes that pass each other within the largest radius, in the ray's stretch.
    near: mask32x8<S>,
    /// The common perpendicular, times `sin_theta`.
    normal: Vec3x8<S>,
    sin_theta: f32x8<S>,
    inverse_sin: f32x8<S>,
    cos_theta: f32x8<S>,
    position: Vec3x8<S>,
    ray_distance: f32x8<S>,
    beam_distance: f32x8<S>,
    gap: f32x8<S>,
}

impl<S: Simd> Crossings<S> {
    #[inline(always)]
    fn new(simd: S, ray: &Ray<S>, block: &BeamBlock, lines: &Lines<S>, max_radius: f32) -> Option<Self> {
        let (from, to) = (load(simd, &block.from), load(simd, &block.to));
        let Lines { direction, offset, normal, sin2 } = *lines;
        let triple = offset.dot(normal);
        let along_ray = offset.cross(direction).dot(normal);
        let along_beam = offset.cross(ray.direction).dot(normal);

        // As `BeamBlock::test`: without a division, and wider than what is asked exactly below by more than
        // rounding.
        let wide = max_radius * ROOM;
        let near = (triple * triple).simd_le(sin2 * (wide * wide));
        let on_ray = along_ray.simd_ge(sin2 * -wide) & along_ray.simd_le(sin2 * (ray.length + wide));
        let on_beam = along_beam.simd_ge((from - wide) * sin2) & along_beam.simd_le((to + wide) * sin2);
        let candidates = near & on_ray & on_beam & !lines.are_along(simd);
        if candidates.to_bitmask() == 0 {
            return None;
        }

        let inverse = 1.0 / sin2;
        let sin_theta = sin2.sqrt();
        let inverse_sin = 1.0 / sin_theta;
        let ray_distance = along_ray * inverse;
        let gap = triple.abs() * inverse_sin;
        let near = candidates
            & ray_distance.simd_ge(f32x8::splat(simd, 0.0))
            & ray_distance.simd_le(f32x8::splat(simd, ray.length))
            & gap.simd_lt(f32x8::splat(simd, max_radius));
        Some(Self {
            near,
            normal,
            sin_theta,
            inverse_sin,
            cos_theta: -direction.dot(ray.direction),
            position: ray.origin + ray.direction * ray_distance,
            ray_distance,
            beam_distance: along_beam * inverse,
            gap,
        })
    }
}

/// [`KernelShape::evaluate`] where |distance| < radius, bit for bit.
#[inline(always)]
fn evaluate<S: Simd>(simd: S, shape: KernelShape, distance: f32x8<S>, radius: f32x8<S>) -> f32x8<S> {
    let q = distance / radius;
    let bump = 1.0 - q * q;
    let height = match shape {
        KernelShape::Box => f32x8::splat(simd, 0.5),
        KernelShape::Epanechnikov => bump * 0.75,
        KernelShape::Biweight => bump * 0.9375 * bump,
    };
    height / radius
}

/// [`Kernel::radius_at`] in the lanes of `mask`, bit for bit: radius, and σ along the kernel's axis.
#[inline(always)]
fn radii<S: Simd>(
    simd: S,
    kernel: &Kernel,
    grid: &FluenceGrid,
    position: Vec3x8<S>,
    axis: Vec3x8<S>,
    mask: u32,
) -> (f32x8<S>, f32x8<S>) {
    let zero = f32x8::splat(simd, 0.0);
    let min_radius = f32x8::splat(simd, kernel.min_radius);
    let mask = mask & contained(simd, &grid.voxels.layout, position);
    if mask == 0 {
        return (min_radius, zero);
    }
    let (bases, shares) = around(simd, &grid.voxels, position, mask);
    let mut factors = [[0.0; LANES]; 8];
    let (mut flux, mut share_sum, mut inverse) = (zero, zero, zero);
    for (corner, step) in grid.voxels.corners.into_iter().enumerate() {
        let mut weights = [0.0; LANES];
        for lane in bits(mask) {
            weights[lane] = grid.cells[bases[lane] + step].weight;
        }
        let (weight, share) = (load(simd, &weights), shares[corner]);
        let lit = weight.simd_gt(zero);
        let factor = share * lit.select(weight, zero);
        factors[corner] = factor.into();
        flux += factor;
        share_sum += lit.select(share, zero);
        inverse += lit.select(share / weight, zero);
    }

    let sums = spectra(grid, &bases, &factors, mask);
    let [xx, yy, zz] =
        [load(simd, &sums[0]) / flux, load(simd, &sums[1]) / flux, load(simd, &sums[2]) / flux];
    let [xy, xz, yz] =
        [load(simd, &sums[3]) / flux, load(simd, &sums[4]) / flux, load(simd, &sums[5]) / flux];
    let Vec3x8 { x, y, z } = axis;
    let along = x * x * xx + y * y * yy + z * z * zz + 2.0 * (x * y * xy + x * z * xz + y * z * yz);
    let along = max(along, zero);
    let dimmest = min(share_sum / inverse, flux);
    let variance = along * (flux / dimmest);
    let wanted = (f32x8::splat(simd, kernel.shape.error_over_moment(kernel.error)) / variance).sqrt();
    let wanted = max(min(wanted, f32x8::splat(simd, kernel.max_radius)), min_radius);
    let lit = flux.simd_gt(zero);
    (lit.select(wanted, min_radius), lit.select(variance.sqrt(), zero))
}

/// [`GridLayout::contains`], a bit a lane.
#[inline(always)]
fn contained<S: Simd>(simd: S, layout: &GridLayout, position: Vec3x8<S>) -> u32 {
    let (min, max) = (Vec3x8::splat(simd, layout.min), Vec3x8::splat(simd, layout.max));
    let contained = position.x.simd_ge(min.x)
        & position.y.simd_ge(min.y)
        & position.z.simd_ge(min.z)
        & position.x.simd_le(max.x)
        & position.y.simd_le(max.y)
        & position.z.simd_le(max.z);
    contained.to_bitmask() as u32
}

/// [`Trilinear::around`] in the lanes of `mask`: the lowest of the eight voxels, and the shares of all eight.
#[inline(always)]
fn around<S: Simd>(
    simd: S,
    voxels: &Trilinear,
    position: Vec3x8<S>,
    mask: u32,
) -> ([usize; LANES], [f32x8<S>; 8]) {
    let (min, scale, last) = (voxels.layout.min, voxels.scale, voxels.last);
    let (bx, hx) = cell(simd, (position.x - min.x) * scale.x - 0.5, last.x);
    let (by, hy) = cell(simd, (position.y - min.y) * scale.y - 0.5, last.y);
    let (bz, hz) = cell(simd, (position.z - min.z) * scale.z - 0.5, last.z);
    let one = f32x8::splat(simd, 1.0);
    let (lx, ly, lz) = (one - hx, one - hy, one - hz);
    let [ll, hl, lh, hh] = [ly * lz, hy * lz, ly * hz, hy * hz];
    let shares = [lx * ll, hx * ll, lx * hl, hx * hl, lx * lh, hx * lh, lx * hh, hx * hh];
    let mut bases = [0; LANES];
    let (bx, by, bz): (Floats, Floats, Floats) = (bx.into(), by.into(), bz.into());
    let [dx, dy, dz] = voxels.strides;
    for lane in bits(mask) {
        bases[lane] =
            bx[lane] as u32 as usize * dx + by[lane] as u32 as usize * dy + bz[lane] as u32 as usize * dz;
    }
    (bases, shares)
}

/// The sums of the eight spectra around each lane's point, times `factors`: xx, yy, zz, xy, xz, yz.
#[inline(always)]
fn spectra(grid: &FluenceGrid, bases: &[usize; LANES], factors: &[Floats; 8], mask: u32) -> [Floats; 6] {
    let mut sums = [[0.0; LANES]; 6];
    for lane in bits(mask) {
        let (mut first, mut second) = (Vec4::ZERO, Vec4::ZERO);
        for (factors, corner) in factors.iter().zip(grid.voxels.corners) {
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
    sums
}

/// Of one coordinate in voxels: the lower of the two around it, and the share of the upper one.
#[inline(always)]
fn cell<S: Simd>(simd: S, at: f32x8<S>, last: f32) -> (f32x8<S>, f32x8<S>) {
    let zero = f32x8::splat(simd, 0.0);
    let at = min(max(at, zero), f32x8::splat(simd, last));
    // The last centre is reached with weight 1 from the voxel before it.
    let low = max(min(at, f32x8::splat(simd, last - 1.0)), zero).floor();
    (low, at - low)
}

/// [`Medium::phases`], bit for bit.
#[inline(always)]
pub(super) fn phases<S: Simd>(simd: S, medium: &Medium, cos_theta: f32x8<S>) -> [f32x8<S>; 3] {
    if medium.more.is_empty() {
        return [phase(simd, &medium.phase, cos_theta); 3];
    }
    let cosines: Floats = cos_theta.into();
    let mut values = [[0.0; LANES]; 3];
    for (lane, cosine) in cosines.into_iter().enumerate() {
        let found = medium.phases(cosine);
        for (channel, values) in values.iter_mut().enumerate() {
            values[lane] = found[channel];
        }
    }
    values.map(|values| load(simd, &values))
}

/// [`PhaseFunction::evaluate`], bit for bit.
#[inline(always)]
fn phase<S: Simd>(simd: S, phase: &PhaseFunction, cos_theta: f32x8<S>) -> f32x8<S> {
    if phase.kind == PhaseKind::Isotropic {
        return f32x8::splat(simd, phase.evaluate(0.0));
    }
    let mut values: Floats = cos_theta.into();
    for value in &mut values {
        *value = phase.evaluate(*value);
    }
    load(simd, &values)
}

/// [`Medium::transmittance`] by channel, bit for bit.
#[inline(always)]
pub(super) fn transmittance<S: Simd>(simd: S, medium: &Medium, column: f32x8<S>) -> [f32x8<S>; 3] {
    let extinction = medium.extinction();
    let red = attenuation(simd, extinction.x, column);
    if extinction.y == extinction.x && extinction.z == extinction.x {
        return [red; 3];
    }
    [red, attenuation(simd, extinction.y, column), attenuation(simd, extinction.z, column)]
}

#[inline(always)]
fn attenuation<S: Simd>(simd: S, extinction: f32, column: f32x8<S>) -> f32x8<S> {
    // 0 · ∞ would be NaN.
    if extinction == 0.0 { f32x8::splat(simd, 1.0) } else { exp(simd, column * -extinction) }
}

impl Gathered {
    /// [`Gathered::add`] of those of eight pairs that `mask` has a bit for, in their order.
    #[inline(always)]
    pub(super) fn add_lanes<S: Simd>(
        &mut self,
        mask: u32,
        [red, green, blue]: [f32x8<S>; 3],
        radius: f32x8<S>,
        sigma: f32x8<S>,
    ) {
        let [red, green, blue, radius, sigma]: [Floats; 5] =
            [red.into(), green.into(), blue.into(), radius.into(), sigma.into()];
        for lane in bits(mask) {
            self.add(Vec3::new(red[lane], green[lane], blue[lane]), radius[lane], sigma[lane]);
        }
    }
}
