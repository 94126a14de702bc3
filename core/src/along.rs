//! Pairs of an eye ray and a beam that run nearly along each other: a kernel on both axes across them.
//!
//! A pair that crosses weighs K(gap)/sin θ, which has no bound where θ falls to 0, and collimated light seen
//! along its direction (a sun, a laser) is there as a whole. So below [`ALONG_SINE`] the kernel acts on both
//! axes across the beam, and the eye ray passes through it with m(t) = m₀ + t sin θ:
//!
//! `∫ σ_s p(θ) T_eye(t) T_beam(s(t)) K_r(gap) c(m(t)/ω)/ω dt` over the stretch where both lie side by side,
//!
//! with c the profile on \[-1, 1\] that makes the kernel round: the kernel in the plane whose projection is
//! K, so that a rotation of both axes, which for θ = 0 nothing tells, changes nothing. Its half-width is
//! ω = (1 - sin² θ/S²) √(r² - gap²), S = [`ALONG_SINE`]: round for θ = 0, and for θ = S so narrow that the
//! integral is K(gap)/sin θ at the crossing. Nothing jumps at S, and from there on nothing has changed.
//!
//! The profiles c are arcs of cos φ (m = ω sin φ), so that in φ the integral is smooth up to its ends, and
//! eight places of Gauss and Legendre are enough.
//!
//! Source: the blur in two dimensions is that of Jarosz et al. 2011, Eq 29, integrated along the eye ray; the
//! profiles are the kernels' inverse Abel transforms.

use crate::beam::{ALONG_SINE, BLOCK, Beam, EyeRay};
use crate::kernel::{Kernel, KernelShape};
use crate::math::sqrt;
use core::f32::consts::{FRAC_1_PI, FRAC_2_PI};
use glam::Vec3;
use libm::{asinf, cosf, sinf};

/// Places on the eye ray at which a pair along it is gathered.
pub const PLACES: usize = BLOCK;

/// Gauss and Legendre's eight points on \[0, 1\], and their weights.
const EVEN: [[f32; PLACES]; 2] = [
    [0.019855072, 0.10166676, 0.2372338, 0.40828268, 0.5917173, 0.7627662, 0.89833324, 0.9801449],
    [0.05061427, 0.11119052, 0.15685332, 0.18134189, 0.18134189, 0.15685332, 0.11119052, 0.05061427],
];

/// The same in the square root, dense at 0: for light that fades from there.
///
/// Error of the integral of exp(-a x): 1e-3 up to a = 30, 1 % at 100, and a fifth at 400.
const DENSE: [[f32; PLACES]; 2] = [
    [0.00039422387, 0.01033613, 0.056279874, 0.16669475, 0.3501294, 0.5818123, 0.8070026, 0.9606841],
    [0.0020099, 0.02260876, 0.07442182, 0.1480775, 0.21460628, 0.23928483, 0.19977227, 0.09921864],
];

/// A pair along the eye ray: its places, in the order of the ray.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Along {
    pub(crate) ray_distance: [f32; PLACES],
    pub(crate) beam_distance: [f32; PLACES],
    /// What the product at each place is multiplied by, as a crossing's K(gap)/sin θ \[1/m\].
    pub(crate) kernel: [f32; PLACES],
    pub(crate) radius: f32,
    pub(crate) sigma: f32,
}

/// The part `[from, to]` of the beam with the eye ray: the pair's places, if its middle lies beside it.
///
/// For a pair that [`is_along`](crate::beam::is_along); only such finds None where rounding would decide.
// Called for few pairs: inlined, its registers slow all others down.
#[inline(never)]
pub(crate) fn along(ray: &EyeRay, beam: &Beam, from: f32, to: f32, kernel: &Kernel) -> Option<Along> {
    let frame = Frame::new(ray, beam);
    // Rays and beams that are none: NaN in any number, directions of length 0.
    if !(frame.cosine.abs() > 0.5 && ray.length >= 0.0 && beam.length > 0.0 && frame.gap < kernel.max_radius)
    {
        return None;
    }
    let widest = frame.width(kernel.max_radius);
    let both = frame.side_by_side(ray, beam, widest)?;
    // The middle of what the widest kernel sees: where the radius is looked up, and which part of the beam
    // the pair belongs to. For θ = ALONG_SINE that is the crossing.
    let seen = frame.through(both, frame.share * widest)?;
    let (t, m) = (seen.middle(), frame.across + seen.middle() * frame.sine);
    let s = frame.beam_distance(t);
    let beyond = (-s).max(s - beam.length).max(0.0);
    let first = if from > 0.0 { from } else { f32::NEG_INFINITY };
    let inside = s >= first && (if to < beam.length { s < to } else { s.is_finite() });
    // What lies beyond a slanted end counts within the capsule around the beam.
    if !(inside && (beyond == 0.0 || m * m + beyond * beyond < widest * widest)) {
        return None;
    }
    let axes = [frame.axis, frame.second * frame.share];
    let (radius, sigma) = kernel.radius_across(ray.origin + t * ray.direction, axes);
    if !(frame.gap < radius) {
        return None;
    }
    let width = frame.share * frame.width(radius);
    frame.places(&frame.through(both, width)?, width, kernel.shape, radius, sigma)
}

/// Where an eye ray lies beside a beam's line, on two axes across that.
struct Frame {
    /// Between the directions.
    cosine: f32,
    sine: f32,
    /// 1 - sin² θ/S², > 0.
    share: f32,
    /// The common perpendicular.
    axis: Vec3,
    /// Across both the beam and `axis`: the way that the eye ray drifts; for parallel ones any.
    second: Vec3,
    /// On `axis`.
    gap: f32,
    /// On `second`, of the ray's origin.
    across: f32,
    /// Along the beam, of the ray's origin.
    start: f32,
}

impl Frame {
    /// Of directions of nearly one length, whose difference has no rounding.
    fn new(ray: &EyeRay, beam: &Beam) -> Self {
        let cosine = ray.direction.dot(beam.direction);
        let forward = beam.direction * 1.0f32.copysign(cosine);
        let difference = ray.direction - forward;
        let drift = difference - forward * difference.dot(forward);
        let sin2 = drift.length_squared();
        // Below 1e-19 they are parallel to all digits.
        let (sine, second) = if sin2 >= f32::MIN_POSITIVE {
            (sqrt(sin2), drift / sqrt(sin2))
        } else {
            (0.0, forward.any_orthonormal_vector())
        };
        let axis = forward.cross(second);
        let offset = ray.origin - beam.origin;
        let start = offset.dot(beam.direction);
        let offset = offset - beam.direction * start;
        let crossed = ray.direction.cross(beam.direction).length_squared();
        let share = 1.0 - crossed / (ALONG_SINE * ALONG_SINE);
        let (gap, across) = (offset.dot(axis).abs(), offset.dot(second));
        Self { cosine, sine, share, axis, second, gap, across, start }
    }

    /// Half of how wide a disk of this radius is at the gap.
    fn width(&self, radius: f32) -> f32 {
        sqrt((radius - self.gap) * (radius + self.gap))
    }

    fn beam_distance(&self, ray_distance: f32) -> f32 {
        self.start + ray_distance * self.cosine
    }

    /// The stretch of the eye ray beside the beam. A surface at the beam's end cuts the *eye ray*: no light
    /// is lost beside it, as in [`crate::gather_pair`].
    fn side_by_side(&self, ray: &EyeRay, beam: &Beam, width: f32) -> Option<Stretch> {
        let first = self.cut(ray, beam, beam.origin, beam.start_normal, width);
        let last = beam.length + self.cut(ray, beam, beam.end(), -beam.end_normal, width);
        let [a, b] = [first, last].map(|s| (s - self.start) / self.cosine);
        let from = a.min(b).max(0.0);
        let to = a.max(b).min(ray.length);
        (first < last && from < to).then_some(Stretch {
            from,
            to,
            entered: -1.0,
            left: 1.0,
            length: to - from,
        })
    }

    /// How far along the beam from its end at `end` the eye ray goes through the end's surface, up to
    /// `width`; 0 without one, or if the two do not go through it the same way.
    ///
    /// - `normal`: on the side that the beam goes to.
    fn cut(&self, ray: &EyeRay, beam: &Beam, end: Vec3, normal: Vec3, width: f32) -> f32 {
        let offset = ray.origin - end;
        let through = ray.direction.dot(normal) * self.cosine;
        if !(through > 0.0) {
            return 0.0;
        }
        let back = self.cosine * self.cosine * offset.dot(normal) / through;
        (offset.dot(beam.direction) - back).max(-width).min(width)
    }

    /// What of a stretch lies in a kernel of half-width `width` on the second axis.
    fn through(&self, Stretch { from, to, .. }: Stretch, width: f32) -> Option<Stretch> {
        let [low, high] = [from, to].map(|t| self.across + t * self.sine);
        if !(low < width && high > -width) {
            return None;
        }
        // Divided by a sine > 0: of parallel ones both ends are inside.
        let (from, entered) =
            if low >= -width { (from, low / width) } else { (from + (-width - low) / self.sine, -1.0) };
        let (to, left) =
            if high <= width { (to, high / width) } else { (to - (high - width) / self.sine, 1.0) };
        // Without the rounding of the two distances where it is known.
        let length = if entered == -1.0 && left == 1.0 { 2.0 * width / self.sine } else { to - from };
        (length > 0.0).then_some(Stretch { from, to, entered, left, length })
    }

    /// The integral over a stretch that lies in the kernel: see the module.
    fn places(
        &self,
        stretch: &Stretch,
        width: f32,
        shape: KernelShape,
        radius: f32,
        sigma: f32,
    ) -> Option<Along> {
        let Stretch { from, to, entered, left, length } = *stretch;
        // With entered = sin φ₀ and left = sin φ₁: the arc φ₁ - φ₀ over left - entered, which has a limit.
        let [first, last] = [entered, left].map(|q| sqrt((1.0 - q) * (1.0 + q)));
        let lean = if first + last > 0.0 { (entered + left) / (first + last) } else { 0.0 };
        let slope = sqrt(1.0 + lean * lean);
        let half_chord = (0.5 * (left - entered) * slope).min(1.0);
        let per_chord = if half_chord > 0.0 { asinf(half_chord) / half_chord } else { 1.0 };
        let (arc, ratio) = ((left - entered) * slope * per_chord, slope * per_chord);

        // Beams that go with the eye ray fade from where both start, others as much as the eye ray gains.
        let [points, weights] = if self.cosine > 0.0 { DENSE } else { EVEN };
        let scale = shape.evaluate(self.gap, radius) * ratio * length / width;
        let mut along = Along { ray_distance: points, beam_distance: points, kernel: weights, radius, sigma };
        for i in 0..PLACES {
            let half = 0.5 * points[i] * arc;
            let (sine, cosine) = (sinf(half), cosf(half));
            // The mean of cos φ up to this place, and cos φ there.
            let sinc = if half > 0.0 { sine / half } else { 1.0 };
            let mean = sinc * (first * cosine - entered * sine);
            let here = first * (1.0 - 2.0 * sine * sine) - entered * (2.0 * sine * cosine);
            let t = (from + length * (points[i] * ratio * mean)).max(from).min(to);
            along.ray_distance[i] = t;
            along.beam_distance[i] = self.beam_distance(t);
            along.kernel[i] = scale * weights[i] * arch(shape, here);
        }
        along.kernel.iter().all(|kernel| kernel.is_finite()).then_some(along)
    }
}

/// The profile c on the second axis, times dm/dφ = ω cos φ.
fn arch(shape: KernelShape, cosine: f32) -> f32 {
    let square = cosine * cosine;
    match shape {
        KernelShape::Box => FRAC_1_PI,
        KernelShape::Epanechnikov => FRAC_2_PI * square,
        KernelShape::Biweight => 4.0 / 3.0 * FRAC_2_PI * square * square,
    }
}

/// A part of an eye ray, and where it lies on the second axis, in half-widths of the kernel.
#[derive(Clone, Copy)]
struct Stretch {
    from: f32,
    to: f32,
    entered: f32,
    left: f32,
    length: f32,
}

impl Stretch {
    fn middle(&self) -> f32 {
        0.5 * (self.from + self.to)
    }
}
