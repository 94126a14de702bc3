//! Eye rays side by side, and what all of them miss.

use super::bvh::WideNode;
use super::simd::{Vec3x8, load, max, min};
use super::sub_beams::ROOM;
use crate::beam::{BeamBlock, EyeRay};
use fearless_simd::{Simd, SimdBase, SimdMask, f32x8};
use glam::Vec3;

/// Eye rays that share a walk through the hierarchy. One at a time, 72 tests a ray remain however thin the
/// beams are; in packets that are not halved, rays that glass has spread all test what any of them might
/// meet.
pub(super) const PACKET: usize = 256;

/// A packet whose rays spread more than this (chord between unit directions) is halved before it walks.
const WIDEST_PACKET: f32 = 0.5;

/// A cone-like hull of some eye rays: the point at distance t of each lies within `spread + slope t` of the
/// point `origin + t axis`.
pub(super) struct Packet {
    origin: Vec3,
    axis: Vec3,
    tangents: [Vec3; 2],
    inverse_axis: Vec3,
    length: f32,
    spread: f32,
    slope: f32,
    /// The most distance along a ray per axial coordinate.
    stretch: f32,
}

impl Packet {
    /// None if the rays have no common direction (or one is NaN).
    pub(super) fn new(rays: &[EyeRay]) -> Option<Self> {
        let count = rays.len() as f32;
        let origin = rays.iter().map(|ray| ray.origin).sum::<Vec3>() / count;
        let axis = rays.iter().map(|ray| ray.direction).sum::<Vec3>().try_normalize()?;
        let spread = rays.iter().map(|ray| ray.origin.distance(origin)).fold(0.0, f32::max);
        let slope = rays.iter().map(|ray| ray.direction.distance(axis)).fold(0.0, f32::max);
        let length = rays.iter().map(|ray| ray.length).fold(0.0, f32::max);
        // The folds pass over NaN, the mean does not.
        if !(slope <= WIDEST_PACKET && spread.is_finite() && origin.is_finite()) {
            return None;
        }
        let tangents = axis.any_orthonormal_pair();
        // Rounding of origins far from the world's origin and of the axis.
        let scale = origin.abs().max_element();
        let slope = slope + 4.0 * f32::EPSILON;
        Some(Self {
            origin,
            axis,
            tangents: [tangents.0, tangents.1],
            inverse_axis: Vec3::from(axis.to_array().map(|a| if a.abs() < 1e-20 { 1e20 } else { 1.0 / a })),
            length,
            spread: spread + 4.0 * f32::EPSILON * scale,
            slope,
            stretch: 1.000_001 / (1.0 - 0.5 * slope * slope),
        })
    }

    /// Half-width of the hull where the axial coordinate is `depth` or less.
    ///
    /// The point at distance t of a ray has an axial coordinate of at least `t (1 - slope²/2) - spread`.
    #[inline(always)]
    fn widths<S: Simd>(&self, simd: S, depth: f32x8<S>) -> f32x8<S> {
        let farthest = max(depth + self.spread, f32x8::splat(simd, 0.0)) * self.stretch;
        min(farthest, f32x8::splat(simd, self.length)) * self.slope + self.spread
    }

    /// A bit for each of eight boxes that some ray may touch, once they have lost `excess` \[m\] on all
    /// sides.
    #[inline(always)]
    pub(super) fn touches_boxes<S: Simd>(&self, simd: S, node: &WideNode, excess: f32) -> u32 {
        let (low, high) = (Vec3x8::load(simd, &node.low), Vec3x8::load(simd, &node.high));
        let two = f32x8::splat(simd, 0.5);
        let half = (high - low) * two;
        let center = (high + low) * two - Vec3x8::splat(simd, self.origin);
        let along = center.dot(Vec3x8::splat(simd, self.axis));
        let extent = half.dot(Vec3x8::splat(simd, self.axis.abs()));
        let width = self.widths(simd, along + extent);
        let growth = width - excess;
        let grown = half + Vec3x8 { x: growth, y: growth, z: growth };
        // Slabs of the grown box against the axis.
        let inverse = Vec3x8::splat(simd, self.inverse_axis);
        let (a, b) = ((center - grown) * inverse, (center + grown) * inverse);
        let enter = max(max(min(a.x, b.x), min(a.y, b.y)), min(a.z, b.z));
        let leave = min(min(max(a.x, b.x), max(a.y, b.y)), max(a.z, b.z));
        let touched = max(enter, -width).simd_le(min(leave, width + self.length));
        touched.to_bitmask() as u32 & node.lanes
    }

    /// A bit for each of eight sub-beams that may come within `radius` of a ray.
    #[inline(always)]
    pub(super) fn touches<S: Simd>(&self, simd: S, lines: &BeamBlock, radius: f32) -> u32 {
        let (e, f) = (Vec3x8::splat(simd, self.tangents[0]), Vec3x8::splat(simd, self.tangents[1]));
        let axis = Vec3x8::splat(simd, self.axis);
        let radius = radius * ROOM;
        let offset = Vec3x8::load(simd, &lines.origin) - Vec3x8::splat(simd, self.origin);
        let direction = Vec3x8::load(simd, &lines.direction);
        let (from, to) = (load(simd, &lines.from), load(simd, &lines.to));
        let (ox, oy, depth) = (offset.dot(e), offset.dot(f), offset.dot(axis));
        let (dx, dy, slope) = (direction.dot(e), direction.dot(f), direction.dot(axis));
        // The point of the sub-beam that is closest to the axis; of one along the axis, any.
        let length2 = max(dx * dx + dy * dy, f32x8::splat(simd, f32::MIN_POSITIVE));
        let closest = min(max(-(ox * dx + oy * dy) / length2, from), to);
        let (x, y) = (ox + closest * dx, oy + closest * dy);
        let (a, b) = (depth + from * slope, depth + to * slope);
        let (nearest, farthest) = (min(a, b) - radius, max(a, b) + radius);
        let width = self.widths(simd, farthest) + radius;
        let near = (x * x + y * y).simd_le(width * width);
        let along = farthest.simd_ge(f32x8::splat(simd, -self.spread))
            & nearest.simd_le(f32x8::splat(simd, self.length + self.spread));
        (near & along).to_bitmask() as u32
    }
}
