//! Eye rays side by side, and what all of them miss.

use super::pieces::Piece;
use super::tree::Node;
use crate::EyeRay;
use glam::{Vec3, Vec3A};

/// A packet whose rays spread more than this (chord between unit directions) is gathered ray by ray.
const WIDEST_PACKET: f32 = 0.5;

/// A cone-like hull of some eye rays: the point at distance t of each lies within `spread + slope t` of the point
/// `origin + t axis`.
pub(super) struct Packet {
    origin: Vec3,
    axis: Vec3,
    tangents: [Vec3; 2],
    inverse_axis: Vec3A,
    length: f32,
    spread: f32,
    slope: f32,
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
        if !(slope <= WIDEST_PACKET && spread.is_finite()) {
            return None;
        }
        let tangents = axis.any_orthonormal_pair();
        // Rounding of origins far from the world's origin and of the axis.
        let scale = origin.abs().max_element();
        Some(Self {
            origin,
            axis,
            tangents: [tangents.0, tangents.1],
            inverse_axis: Vec3A::from(axis.to_array().map(|a| if a.abs() < 1e-20 { 1e20 } else { 1.0 / a })),
            length,
            spread: spread + 4.0 * f32::EPSILON * scale,
            slope: slope + 4.0 * f32::EPSILON,
        })
    }

    /// Half-width of the hull where the axial coordinate is `depth` or less.
    ///
    /// The point at distance t of a ray has an axial coordinate of at least `t (1 - slope²/2) - spread`.
    fn width(&self, depth: f32) -> f32 {
        let farthest = (depth + self.spread).max(0.0) / (1.0 - 0.5 * self.slope * self.slope);
        self.spread + self.slope * farthest.min(self.length)
    }

    #[inline]
    pub(super) fn touches_box(&self, node: &Node) -> bool {
        let origin = Vec3A::from(self.origin);
        let axis = Vec3A::from(self.axis);
        let (low, high) = (node.low(), node.high());
        let half = 0.5 * (high - low);
        let center = 0.5 * (high + low) - origin;
        let (along, extent) = (center.dot(axis), half.dot(axis.abs()));
        let depth = along + extent;
        let width = self.width(depth);
        let grown = half + Vec3A::splat(width);
        // Slabs of the grown box against the axis.
        let near = (center - grown) * self.inverse_axis;
        let far = (center + grown) * self.inverse_axis;
        let enter = near.min(far).max_element();
        let leave = near.max(far).min_element();
        enter.max(-width) <= leave.min(self.length + width)
    }

    #[inline]
    pub(super) fn touches_piece(&self, piece: &Piece, radius: f32) -> bool {
        let (a, b) = (piece.start - self.origin, piece.end - self.origin);
        let (depth_a, depth_b) = (a.dot(self.axis), b.dot(self.axis));
        let [e, f] = self.tangents;
        let (ax, ay) = (a.dot(e), a.dot(f));
        let (ux, uy) = (b.dot(e) - ax, b.dot(f) - ay);
        let length2 = ux * ux + uy * uy;
        let s = if length2 > 0.0 { (-(ax * ux + ay * uy) / length2).clamp(0.0, 1.0) } else { 0.0 };
        let (x, y) = (ax + s * ux, ay + s * uy);
        let (nearest, farthest) = (depth_a.min(depth_b) - radius, depth_a.max(depth_b) + radius);
        let width = self.width(farthest) + radius;
        x * x + y * y <= width * width && farthest >= -self.spread && nearest <= self.length + self.spread
    }
}
