//! One eye ray against eight pieces of beams side by side.

use super::packet::ROOM;
use super::pieces::Piece;
use super::reach::reach;
use super::wide::{Floats, Vectors, Wide, load};
use crate::beam::{Beam, BeamBlock, EyeRay, PARALLEL_SINE, inside};
use crate::{BLOCK, Kernel, KernelRadius};
use fearless_simd::{Simd, SimdBase, SimdFloat, SimdMask, f32x8};
use glam::Vec3;

/// Pairs that are worked on side by side.
pub(super) const LANES: usize = BLOCK;

/// Puts the lines of up to [`LANES`] pieces into an empty block.
#[inline(always)]
pub(super) fn fill(lines: &mut BeamBlock, pieces: &[Piece]) {
    for (lane, piece) in pieces.iter().enumerate().take(LANES) {
        lines.set_line(lane, piece.origin, piece.direction, piece.from, piece.to);
    }
}

/// Up to eight pieces side by side, with all that pairs need of the beams.
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

    /// Puts up to [`LANES`] pieces in.
    #[inline(always)]
    pub(super) fn fill(&mut self, beams: &[Beam], pieces: &[Piece]) {
        fill(&mut self.lines, pieces);
        for (lane, piece) in pieces.iter().enumerate().take(LANES) {
            let beam = &beams[piece.beam as usize];
            self.length[lane] = beam.length;
            set(&mut self.power, lane, beam.power);
            self.beams[lane] = piece.beam;
        }
    }
}

/// The pairs of one eye ray and a block; what is in lanes that are not accepted means nothing.
pub(super) struct Lanes<'a, S: Simd> {
    /// Which lanes hold a pair that is accepted, a bit each.
    pub(super) accepted: u32,
    pub(super) block: &'a Block,
    /// As in [`super::Contact`].
    pub(super) position: Wide<S>,
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
    origin: Wide<S>,
    direction: Wide<S>,
    length: f32,
}

impl<S: Simd> Ray<S> {
    #[inline(always)]
    pub(super) fn new(simd: S, ray: &EyeRay) -> Self {
        let EyeRay { origin, direction, length } = *ray;
        Self { origin: Wide::splat(simd, origin), direction: Wide::splat(simd, direction), length }
    }
}

impl<'a, S: Simd> Lanes<'a, S> {
    /// The pairs of a block against `ray`; None if all pass each other farther away than kernels reach. The arithmetic of
    /// [`crate::beam::meet`], and its bits.
    #[inline(always)]
    pub(super) fn new(
        simd: S,
        ray: &Ray<S>,
        block: &'a Block,
        beams: &[Beam],
        radius: &KernelRadius,
    ) -> Option<Self> {
        let lines = &block.lines;
        let direction = Wide::load(simd, &lines.direction);
        let (from, to) = (load(simd, &lines.from), load(simd, &lines.to));
        let normal = ray.direction.cross(direction);
        let sin2 = normal.dot(normal);
        let offset = Wide::load(simd, &lines.origin) - ray.origin;
        let triple = offset.dot(normal);
        let along_ray = offset.cross(direction).dot(normal);
        let along_beam = offset.cross(ray.direction).dot(normal);

        // As `BeamBlock::test`: without a division, and wider than what is asked exactly below by more than rounding.
        let wide = radius.ceiling * ROOM;
        let near = (triple * triple).simd_le(sin2 * (wide * wide));
        let on_ray = along_ray.simd_ge(sin2 * -wide) & along_ray.simd_le(sin2 * (ray.length + wide));
        let on_beam = along_beam.simd_ge((from - wide) * sin2) & along_beam.simd_le((to + wide) * sin2);
        let candidates = near & on_ray & on_beam;
        if candidates.to_bitmask() == 0 {
            return None;
        }

        let inverse = 1.0 / sin2;
        let sin_theta = sin2.sqrt();
        let inverse_sin = 1.0 / sin_theta;
        let ray_distance = along_ray * inverse;
        let beam_distance = along_beam * inverse;
        let gap = triple.abs() * inverse_sin;
        let position = ray.origin + ray.direction * ray_distance;
        let zero = f32x8::splat(simd, 0.0);
        let near = candidates
            & sin2.simd_ge(f32x8::splat(simd, PARALLEL_SINE * PARALLEL_SINE))
            & ray_distance.simd_ge(zero)
            & ray_distance.simd_le(f32x8::splat(simd, ray.length))
            & gap.simd_lt(f32x8::splat(simd, radius.ceiling));

        let (reach, sigma) = match &radius.grid {
            None => (f32x8::splat(simd, radius.progressive), zero),
            Some(grid) => {
                let near = near.to_bitmask() as u32;
                reach(simd, radius, grid, position, normal * inverse_sin, near)
            }
        };

        // Most pairs lie farther from both ends of their beam than the kernel reaches. A piece's cut is no end.
        let length = load(simd, &block.length);
        let within = gap.simd_lt(reach)
            & (beam_distance.simd_ge(from) | !from.simd_gt(zero))
            & (beam_distance.simd_lt(to) | !to.simd_lt(length));
        let away = beam_distance.simd_ge(reach) & beam_distance.simd_le(length - reach);
        let mut accepted = (near & within & away).to_bitmask() as u32;
        let at_an_end = (near & within & !away).to_bitmask() as u32;
        if at_an_end != 0 {
            let (positions, distances): (_, Floats) = (position.store(), beam_distance.into());
            let (gaps, radii): (Floats, Floats) = (gap.into(), reach.into());
            for lane in bits(at_an_end) {
                let beam = &beams[block.beams[lane] as usize];
                let (from, to, point) = (lines.from[lane], lines.to[lane], vector(&positions, lane));
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
            cos_theta: -direction.dot(ray.direction),
            kernel: kernel(simd, radius.kernel, gap, reach) / sin_theta,
            radius: reach,
            sigma,
        })
    }
}

/// [`Kernel::evaluate`] where |distance| < radius, bit for bit.
#[inline(always)]
fn kernel<S: Simd>(simd: S, kernel: Kernel, distance: f32x8<S>, radius: f32x8<S>) -> f32x8<S> {
    let q = distance / radius;
    let bump = 1.0 - q * q;
    let shape = match kernel {
        Kernel::Box => f32x8::splat(simd, 0.5),
        Kernel::Epanechnikov => bump * 0.75,
        Kernel::Biweight => bump * 0.9375 * bump,
    };
    shape / radius
}

/// The places of the bits that are set, lowest first.
#[inline(always)]
pub(super) fn bits(mut mask: u32) -> impl Iterator<Item = usize> {
    core::iter::from_fn(move || {
        let place = mask.trailing_zeros() as usize;
        let found = mask != 0;
        mask &= mask.wrapping_sub(1);
        found.then_some(place)
    })
}
