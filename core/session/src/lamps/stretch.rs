//! Stretches of eye rays that lamps are drawn for.

use glam::Vec3;

/// This share of light is taken to be left where fog seems to let nothing through: fog may end on the way, and other places of a ray than the one
/// that stands for it may be lit.
const DIMMED: f32 = 0.05;

/// Places of a stretch at which it is known how much light is left, and steps between them.
const KNOTS: usize = 17;

/// A stretch of an eye ray.
pub(crate) struct Stretch {
    pub(super) origin: Vec3,
    pub(super) direction: Vec3,
    pub(super) from: f32,
    pub(super) to: f32,
    /// Share of light that is left on its way from a place to the origin, or taken to be.
    left: [f32; KNOTS],
    /// Places to a metre.
    knots: f32,
}

impl Stretch {
    /// - `reach`: nothing changes farther along a stretch.
    /// - `left`: share of light that is left on its way from a place to the origin, by the distance of that.
    pub(crate) fn new(
        [origin, direction]: [Vec3; 2],
        [from, to]: [f32; 2],
        reach: f32,
        left: impl Fn(f32) -> f32,
    ) -> Self {
        let step = (to - from).min(reach).max(f32::MIN_POSITIVE) / (KNOTS - 1) as f32;
        let at = |knot: usize| DIMMED + (1.0 - DIMMED) * left(from + knot as f32 * step);
        Self { origin, direction, from, to, left: std::array::from_fn(at), knots: step.recip().min(f32::MAX) }
    }

    pub(super) fn left(&self, distance: f32) -> f32 {
        let place = ((distance - self.from) * self.knots).clamp(0.0, (KNOTS - 1) as f32);
        let knot = (place as usize).min(KNOTS - 2);
        let share = place - knot as f32;
        (1.0 - share) * self.left[knot] + share * self.left[knot + 1]
    }

    /// Of what lamps far away send to a metre, as many metres.
    pub(super) fn length(&self) -> f32 {
        let ends = 0.5 * (self.left[0] + self.left[KNOTS - 1]);
        (self.left.iter().sum::<f32>() - ends) / self.knots
    }
}
