//! Photon beams, eye rays, and where they cross.

use crate::math::sqrt;
use glam::Vec3;

/// Lines whose directions differ by less than this sine have no crossing: in single precision it is noise.
///
/// No bound of the gather: [`gather_pair`](crate::gather_pair) needs no crossing below
/// [`ALONG_SINE`].
pub const PARALLEL_SINE: f32 = 1e-5;

/// The sine S of the angle below which a pair is gathered along the eye ray.
///
/// The wider the angles, the more pairs cost as much as eight; with .05 they are one in several thousand of
/// an isotropic field. From here on a crossing, twenty times as long as the kernel is wide, is short beside
/// what is seen.
pub const ALONG_SINE: f32 = 0.05;

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

/// Whether a pair whose directions have a cross product of this squared length is gathered along the ray.
#[inline(always)]
pub(crate) fn is_along(sin2: f32) -> bool {
    sin2 < ALONG_SINE * ALONG_SINE
}

/// Number of beams that [`BeamBlock`] tests together.
pub const BLOCK: usize = 8;

/// Eight sub-beams side by side, so that one eye ray is tested against all of them at once.
///
/// The test is a filter: it may let a few pairs pass that [`gather_pair`](crate::gather_pair) then refuses,
/// never the other way round.
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
    // A direction of 0 would look like one along every ray.
    pub const EMPTY: Self = Self {
        origin: [[0.0; BLOCK]; 3],
        direction: [[f32::NAN; BLOCK]; 3],
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
        let mut nearly_parallel = [false; BLOCK];
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
            nearly_parallel[k] = is_along(sin2);
        }
        if nearly_parallel.iter().any(|&is| is) {
            for k in 0..BLOCK {
                if nearly_parallel[k] {
                    hit[k] = u32::from(self.runs_along(k, ray, wide)) << k;
                }
            }
        }
        hit.iter().fold(0, |mask, bit| mask | bit)
    }

    /// Whether the sub-beam in a slot, which runs nearly along the ray, may come within `wide` of it.
    // Eight-wide twin: beam_map/eight.rs.
    fn runs_along(&self, slot: usize, ray: &EyeRay, wide: f32) -> bool {
        let [origin, direction] =
            [&self.origin, &self.direction].map(|v| Vec3::new(v[0][slot], v[1][slot], v[2][slot]));
        let (from, to) = (self.from[slot], self.to[slot]);
        let middle = origin + 0.5 * (from + to) * direction - ray.origin;
        let half = 0.5 * (to - from) + wide;
        // Rounding of the two products.
        let room = 1e-6 * (middle.x.abs() + middle.y.abs() + middle.z.abs() + half);
        let apart = wide + half * sqrt(ray.direction.cross(direction).length_squared()) + room;
        let along = middle.dot(ray.direction);
        middle.cross(ray.direction).length_squared() <= apart * apart
            && along >= -half - room
            && along <= ray.length + half + room
    }
}
