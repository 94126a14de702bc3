//! Photon beams, eye rays, where they cross, and what one crossing contributes.

use crate::kernel::Kernel;
use crate::math::sqrt;
use crate::medium::{Column, Medium};
use glam::Vec3;

/// Pairs whose directions differ by less than this sine are skipped.
///
/// The contribution of a pair grows as 1/sin θ while such pairs grow rare as sin² θ, so skipping them loses a
/// fraction of about `2/π · PARALLEL_SINE` of the in-scattered light of an isotropic field (6e-6) and bounds
/// every contribution by 1e5 kernel heights. In single precision the crossing of such a pair is noise anyway.
pub const PARALLEL_SINE: f32 = 1e-5;

/// A photon beam: the straight segment of a photon's path through a medium.
///
/// It is *long*: it runs on to the next surface whatever the photon's free flight was, and the gather
/// multiplies by the transmittance (Jarosz et al. 2011, "long beams"). A short beam, which ends at the
/// collision, brings the noise of the free flight, and is no smooth function of the numbers that its path was
/// emitted with.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Beam {
    /// Where the beam starts \[m\].
    pub origin: Vec3,
    /// Unit direction of propagation.
    pub direction: Vec3,
    /// Length \[m\], finite; a beam whose length is not > 0 contributes nothing.
    pub length: f32,
    /// Flux at the origin per colour channel, already divided by the number of light paths \[W\].
    pub power: Vec3,
    /// Unit normal of the surface on which the beam starts, towards the medium; zero if it starts in the
    /// open.
    pub start_normal: Vec3,
    /// Unit normal of the surface on which the beam ends, towards the medium; zero if it ends in the open.
    pub end_normal: Vec3,
}

impl Beam {
    #[inline(always)]
    pub(crate) fn end(&self) -> Vec3 {
        self.origin + self.length * self.direction
    }
}

/// One straight segment of an eye path inside one medium.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EyeRay {
    /// Where the segment starts \[m\].
    pub origin: Vec3,
    /// Unit direction, away from the eye.
    pub direction: Vec3,
    /// Length \[m\] to the next surface; infinity allowed.
    pub length: f32,
}

/// Closest approach of an eye ray's line and a beam's line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// Distance along the eye ray of the point closest to the beam \[m\]; may lie outside the ray.
    pub ray_distance: f32,
    /// Distance along the beam of the point closest to the eye ray \[m\]; may lie outside the beam.
    pub beam_distance: f32,
    /// Distance between the two closest points \[m\], >= 0.
    pub gap: f32,
    /// Sine of the angle between the directions, in (0, 1].
    pub sin_theta: f32,
    /// Unit common perpendicular: the axis on which the 1D kernel acts.
    pub axis: Vec3,
}

/// Closest approach of two lines, or None when they are closer to parallel than [`PARALLEL_SINE`].
///
/// Works for square-on pairs, where the form that divides by the cosine fails.
// Eight-wide twin: beam_map/eight.rs.
#[inline]
pub fn cross(ray: &EyeRay, beam: &Beam) -> Option<Crossing> {
    let normal = ray.direction.cross(beam.direction);
    let sin2 = normal.length_squared();
    if !(sin2 >= PARALLEL_SINE * PARALLEL_SINE) {
        return None;
    }
    let offset = beam.origin - ray.origin;
    let inverse = 1.0 / sin2;
    let sin_theta = sqrt(sin2);
    let inverse_sin = 1.0 / sin_theta;
    Some(Crossing {
        ray_distance: offset.cross(beam.direction).dot(normal) * inverse,
        beam_distance: offset.cross(ray.direction).dot(normal) * inverse,
        gap: offset.dot(normal).abs() * inverse_sin,
        sin_theta,
        axis: normal * inverse_sin,
    })
}

/// What an eye ray has gathered so far. Start from `default()`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Gathered {
    /// In-scattered radiance at the ray's origin \[W/(m² sr)\].
    pub radiance: Vec3,
    /// Accepted pairs.
    pub pairs: u32,
    /// Sum over accepted pairs of their contribution (mean of the channels), the weight of the next two.
    pub weight: f32,
    /// Weighted sum of the kernel radii \[m\].
    pub radius: f32,
    /// Weighted sum of σ along the kernel's axis \[cycles/m\].
    pub sigma: f32,
}

impl Gathered {
    /// Adds the contribution of one pair, and returns whether it was a number.
    #[inline(always)]
    pub(crate) fn add(&mut self, radiance: Vec3, radius: f32, sigma: f32) -> bool {
        let weight = (radiance.x + radiance.y + radiance.z) * (1.0 / 3.0);
        if !weight.is_finite() {
            return false;
        }
        self.radiance += radiance;
        self.pairs += 1;
        self.weight += weight;
        self.radius += weight * radius;
        self.sigma += weight * sigma;
        true
    }
}

/// A beam within the kernel's reach of an eye ray: where, and how wide the kernel is.
pub(crate) struct Meeting {
    /// The point on the eye ray.
    pub(crate) point: Vec3,
    pub(crate) crossing: Crossing,
    pub(crate) radius: f32,
    pub(crate) sigma: f32,
}

/// The geometry of a pair: whether it is accepted, whatever the medium. See [`gather_pair`].
#[inline(always)]
pub(crate) fn meet(ray: &EyeRay, beam: &Beam, from: f32, to: f32, kernel: &Kernel) -> Option<Meeting> {
    let crossing = cross(ray, beam)?;
    let Crossing { ray_distance: t, beam_distance: s, gap, axis, .. } = crossing;
    if !(t >= 0.0 && t <= ray.length && gap < kernel.max_radius) {
        return None;
    }
    let point = ray.origin + t * ray.direction;
    let (r, sigma) = kernel.radius_at(point, axis);
    if !(gap < r) {
        return None;
    }
    inside(beam, from, to, point, s, gap, r).then_some(Meeting { point, crossing, radius: r, sigma })
}

/// Whether a point on an eye ray, `gap` from `beam` and beside its distance `s`, lies beside the part
/// `[from, to)` of the beam; at its ends: on the medium's side of the surface.
#[inline]
pub(crate) fn inside(beam: &Beam, from: f32, to: f32, point: Vec3, s: f32, gap: f32, r: f32) -> bool {
    // Within `slack` of its ends the kernel's cap lies inside the capsule of radius r around the beam.
    let slack = sqrt(r * r - gap * gap);
    let on_start = beam.start_normal != Vec3::ZERO;
    let on_end = beam.end_normal != Vec3::ZERO;
    let start = if on_start { -slack } else { 0.0 };
    let first = if from > 0.0 { from } else { start };
    let inside = if to < beam.length { s < to } else { s <= beam.length + if on_end { slack } else { 0.0 } };
    if !(s >= first && inside) {
        return false;
    }
    let before = on_start && s < slack && (point - beam.origin).dot(beam.start_normal) < 0.0;
    let behind = on_end && s > beam.length - slack && (point - beam.end()).dot(beam.end_normal) < 0.0;
    !before && !behind
}

/// The column along a beam up to `distance` \[m\]. Within the slack of a cut end that may be negative: as far
/// before the surface as the column says beyond it.
#[inline(always)]
pub(crate) fn along_beam(column: &Column, distance: f32) -> f32 {
    if distance < 0.0 { -column.at(-distance) } else { column.at(distance) }
}

/// σ_s p(θ) T_eye T_beam per channel \[1/(m sr)\]: what a pair scatters of the beam's power, but for the
/// kernel.
///
/// - `position`: on the eye ray.
/// - `cos_theta`: as [`crate::PhaseFunction::evaluate`] takes it.
/// - `column` \[m\]: along the beam and the eye ray together.
#[inline(always)]
pub(crate) fn product(medium: &Medium, position: Vec3, cos_theta: f32, column: f32) -> Vec3 {
    let scale = medium.density.at(position) * medium.phase.evaluate(cos_theta);
    medium.scattering * medium.transmittance(column) * scale
}

/// Gathers one beam whose crossing's `beam_distance` lies in `[from, to)`, and adds it to `gathered`. Returns
/// whether it was accepted.
///
/// Beam x ray estimator with a 1D kernel across the common perpendicular (thesis 5.3.4, Jarosz et al. 2011):
/// `L += σ_s p(θ) T_eye T_beam Φ K_r(d) / sin θ` if `d < r`, `r = max(r_i, r_σ)`, with r_σ looked up at the
/// closest point on the *eye ray*.
///
/// - `ray`, `beam`: see there; NaN anywhere makes the pair be skipped.
/// - `[from, to]`: part of the beam that counts \[m\]; `[0, beam.length]` for the whole beam. Cutting a beam
///   into adjoining parts changes nothing.
/// - `medium`: what both lie in; its density is taken at the point on the *eye ray*.
/// - `[ray_column, beam_column]`: the columns from the start of both, [`crate::Density::column`].
/// - `kernel`: its shape, and how wide it may be.
///
/// Differs from the thesis at surfaces: a beam that starts or ends on a surface is cut there by the surface's
/// tangent plane through the *eye's* point, not square to the beam; otherwise a kernel loses light next to
/// every wall.
#[inline]
pub fn gather_pair(
    ray: &EyeRay,
    beam: &Beam,
    [from, to]: [f32; 2],
    medium: &Medium,
    [ray_column, beam_column]: &[Column; 2],
    kernel: &Kernel,
    gathered: &mut Gathered,
) -> bool {
    let Some(meeting) = meet(ray, beam, from, to, kernel) else { return false };
    let Crossing { ray_distance: t, beam_distance: s, gap, sin_theta, .. } = meeting.crossing;
    let column = along_beam(beam_column, s) + ray_column.at(t);
    let cos_theta = -beam.direction.dot(ray.direction);
    let product = product(medium, meeting.point, cos_theta, column);
    let height = kernel.shape.evaluate(gap, meeting.radius) / sin_theta;
    gathered.add(product * beam.power * height, meeting.radius, meeting.sigma)
}

/// Number of beams that [`BeamBlock`] tests together.
pub const BLOCK: usize = 8;

/// Eight sub-beams side by side, so that one eye ray is tested against all of them at once.
///
/// The test is a filter: it may let a few pairs pass that [`gather_pair`] then refuses, never the other way
/// round.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub struct BeamBlock {
    pub(crate) origin: [[f32; BLOCK]; 3],
    pub(crate) direction: [[f32; BLOCK]; 3],
    pub(crate) from: [f32; BLOCK],
    pub(crate) to: [f32; BLOCK],
}

impl BeamBlock {
    /// A block of sub-beams that nothing hits.
    pub const EMPTY: Self = Self {
        origin: [[0.0; BLOCK]; 3],
        direction: [[0.0; BLOCK]; 3],
        from: [f32::INFINITY; BLOCK],
        to: [f32::NEG_INFINITY; BLOCK],
    };

    /// Fills slot `slot` (< [`BLOCK`]) with the part `[from, to]` of `beam`.
    #[inline]
    pub fn set(&mut self, slot: usize, beam: &Beam, from: f32, to: f32) {
        self.set_line(slot, beam.origin, beam.direction, from, to);
    }

    /// Fills a slot with a part of a line.
    #[inline(always)]
    pub(crate) fn set_line(&mut self, slot: usize, origin: Vec3, direction: Vec3, from: f32, to: f32) {
        for (axis, (o, d)) in origin.to_array().into_iter().zip(direction.to_array()).enumerate() {
            self.origin[axis][slot] = o;
            self.direction[axis][slot] = d;
        }
        self.from[slot] = from;
        self.to[slot] = to;
    }

    /// Empties the slots from `first` on.
    #[inline]
    pub fn clear_from(&mut self, first: usize) {
        for slot in first..BLOCK {
            self.from[slot] = f32::INFINITY;
            self.to[slot] = f32::NEG_INFINITY;
        }
    }

    /// A bit per slot whose sub-beam may come within `radius` \[m\] of `ray`.
    #[inline(always)]
    pub fn test(&self, ray: &EyeRay, radius: f32) -> u32 {
        // Rounding of a crossing near a bound must not make the filter refuse what the exact test accepts.
        let wide = radius * 1.001;
        let mut hit = [0u32; BLOCK];
        // An index over eight arrays side by side: what the compiler turns into vector code.
        #[allow(clippy::needless_range_loop)]
        for k in 0..BLOCK {
            let [origin, direction] =
                [&self.origin, &self.direction].map(|v| Vec3::new(v[0][k], v[1][k], v[2][k]));
            let normal = ray.direction.cross(direction);
            let sin2 = normal.length_squared();
            let offset = origin - ray.origin;
            let triple = offset.dot(normal);
            let t = offset.cross(direction).dot(normal);
            let s = offset.cross(ray.direction).dot(normal);
            let near = triple * triple <= wide * wide * sin2;
            let on_ray = (t >= -wide * sin2) & (t <= (ray.length + wide) * sin2);
            let on_beam = (s >= (self.from[k] - wide) * sin2) & (s <= (self.to[k] + wide) * sin2);
            hit[k] = u32::from(near & on_ray & on_beam) << k;
        }
        hit.iter().fold(0, |mask, bit| mask | bit)
    }
}
