//! Adaptive sampling along an eye ray for light scattered once: where shadow rays are worth their cost.
//!
//! All of the integrand but the visibility of the light is known without a shadow ray. The host tabulates it
//! at knots along the ray, beside what the covariance grid says about them; [`March`] places the shadow rays,
//! in one round or in two.
//!
//! ```
//! use covbeam::{MARCH_KNOTS, March, MarchCell, MarchKnot, MarchSample, Vec3};
//! // An eye ray along z through thin fog, past a lamp 1 m aside at z = 3; behind z = 4 lies its shadow.
//! let (lamp, fog) = (Vec3::new(1.0, 0.0, 3.0), 0.01);
//! let radiance = |z: f32| fog / (4.0 * std::f32::consts::PI * (1.0 + (z - 3.0) * (z - 3.0)));
//! let mut knots = [MarchKnot::default(); MARCH_KNOTS];
//! MarchKnot::lay(Vec3::ZERO, Vec3::Z, 0.0, 8.0, lamp, &mut knots)?;
//! for knot in &mut knots {
//!     *knot = MarchKnot { radiance: radiance(knot.distance), ..*knot };
//! }
//! let mut cells = [MarchCell::default(); MARCH_KNOTS];
//! let march = March::new(&knots, &mut cells)?;
//! // A first round of 8 shadow rays finds the border between light and shadow, a second one of 24 measures with it.
//! let (mut first, mut second) = ([MarchSample::default(); 8], [MarchSample::default(); 24]);
//! march.place(&[0.5; 8], &mut first);
//! for sample in &mut first {
//!     sample.visibility = if sample.distance < 4.0 { 1.0 } else { 0.0 };
//! }
//! march.refine(&mut first, &[0.5; 24], &mut second);
//! let seen: f32 =
//!     second.iter().filter(|s| s.distance < 4.0).map(|s| s.weight * radiance(s.distance)).sum();
//! let exact = fog / (4.0 * std::f32::consts::PI) * (1f32.atan() + 3f32.atan());
//! assert!((seen / exact - 1.0).abs() < 1e-2, "{seen} {exact}"); // 24 equal strata would leave 2 % of the light in one
//! # Ok::<(), covbeam::MarchError>(())
//! ```

use core::fmt;

use glam::Vec3;
use libm::{atanf, pow, sqrt, tanf, tanh};

/// A number of knots that serves well: shadow borders are told apart down to a hundredth of the stretch.
pub const MARCH_KNOTS: usize = 97;

/// Share of the strata that follow the expected light alone, whatever is known about its changes: a change
/// that nothing announced never meets a stratum that is longer than 1/DEFENSIVE times the mean.
const DEFENSIVE: f64 = 0.1;

/// Where the expected visibility is below half of this, samples are as dense as if it were half of this:
/// light that was not expected gets no weight above 1/LEAST_EXPECTED times the mean.
const LEAST_EXPECTED: f64 = 0.1;

/// Changes that are expected along the whole table where nothing else is known, and in any case besides.
const UNKNOWN_CHANGES: f64 = 1.0;
const LEAST_CHANGES: f64 = 0.1;

/// A first round pays when there are this many rays for each expected change, and this many in all.
const RAYS_A_CHANGE: f64 = 16.0;
const LEAST_RAYS: usize = 12;

/// Share of the rays in the first round. It places the second one and is thrown away: to count it again
/// biases by up to 3 %, and a control variate made of it is negative at times, and noise in the dark.
const FIRST_ROUND: f64 = 0.3;

/// One knot of the table along an eye ray.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MarchKnot {
    /// From the ray's origin \[m\].
    pub distance: f32,
    /// Light that one metre of the ray scatters to the eye if nothing is in the lights' way, as one number
    /// such as its luminance \[W/(m³ sr)\] >= 0: T_eye σ_s p(θ) T_light I/d². NaN, infinity and negative
    /// numbers count as 0.
    pub radiance: f32,
    /// Standard deviation of the fluence spectrum along the ray, sqrt(dᵀΣd) \[cycles/m\] >= 0, from
    /// [`FluenceGrid::look_up`](crate::FluenceGrid::look_up); NaN, infinity and negative numbers: not known.
    pub deviation: f32,
    /// Share of the light that is expected to arrive, in \[0, 1\], such as that of a few rays from the light
    /// past this place; NaN and negative numbers: not known.
    pub visibility: f32,
}

impl Default for MarchKnot {
    /// Dark, and nothing known.
    fn default() -> Self {
        Self { distance: 0.0, radiance: 0.0, deviation: f32::NAN, visibility: f32::NAN }
    }
}

/// Memory of a [`March`], one a knot; what it holds before does not matter.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MarchCell {
    mass: f64,
    changes: f64,
    measure: f64,
}

/// A place for a shadow ray.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MarchSample {
    /// From the ray's origin \[m\].
    pub distance: f32,
    /// The sum over a round of `weight` x radiance x visibility, at `distance`, is the estimate of the light
    /// scattered to the eye \[m\]. 0 = no shadow ray is needed.
    pub weight: f32,
    /// What the shadow ray found, in \[0, 1\], written by the host; read from the first round by
    /// [`March::refine`].
    pub visibility: f32,
    /// The table's expected light up to `distance` \[W/(m² sr)\], which [`March::refine`] finds the first
    /// round by.
    pub mass: f64,
}

/// Why a table was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MarchError {
    /// Fewer than two knots, or not as many cells as knots.
    Length,
    /// A distance is not finite or below the one before, or the ray or its light is not finite.
    Distance,
}

impl fmt::Display for MarchError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            MarchError::Length => "a table along a ray needs two knots or more, and as many cells",
            MarchError::Distance => "a distance along the ray is not finite, or below the one before",
        })
    }
}

impl core::error::Error for MarchError {}

impl MarchKnot {
    /// Lays knots along a stretch of a ray, at equal steps of the angle at which a light sees it; all else is
    /// as in [`MarchKnot::default`].
    ///
    /// - `origin`, `direction`: of the ray; unit direction.
    /// - `from`, `to` \[m\]: the stretch, `from` <= `to`. Infinity stands for where the light sees the rest
    ///   under 1/1000 rad.
    /// - `light`: its position, or centre. On the ray itself, the steps are equal in distance.
    ///
    /// Cost: 5 ns a knot. Error: [`MarchError`], and nothing written, for fewer than two knots or a number
    /// that is not finite.
    ///
    /// Source: C. Kulla and M. Fajardo, *Importance Sampling Techniques for Path Tracing in Participating
    /// Media*, 2012.
    pub fn lay(
        origin: Vec3,
        direction: Vec3,
        from: f32,
        to: f32,
        light: Vec3,
        knots: &mut [Self],
    ) -> Result<(), MarchError> {
        let last = knots.len().checked_sub(1).filter(|&last| last > 0).ok_or(MarchError::Length)?;
        let offset = light - origin;
        let foot = offset.dot(direction);
        let height = (offset - foot * direction).length();
        let to = if to == f32::INFINITY { from.max(foot + 1000.0 * height.max(foot.abs())) } else { to };
        if !(from <= to && from.is_finite() && to.is_finite() && foot.is_finite() && height.is_finite()) {
            return Err(MarchError::Distance);
        }
        let angular = height > 1e-6 * (to - from);
        let angle = |distance: f32| atanf((distance - foot) / height);
        let (low, high) = if angular { (angle(from), angle(to)) } else { (0.0, 0.0) };
        let mut before = from;
        for (index, knot) in knots.iter_mut().enumerate() {
            let share = index as f32 / last as f32;
            let distance = if angular {
                foot + height * tanf(low + share * (high - low))
            } else {
                // In f64: the length of a stretch may be beyond what `f32` holds.
                (f64::from(from) + f64::from(share) * (f64::from(to) - f64::from(from))) as f32
            };
            // Rounding neither turns the order nor leaves the stretch; NaN, of an angle that overflowed,
            // stays where it is.
            before = if index == last { to } else { distance.max(before).min(to) };
            *knot = Self { distance: before, ..Self::default() };
        }
        Ok(())
    }
}

/// Where shadow rays should go along one eye ray.
///
/// The expected density of changes of the visibility along the ray is λ = 4v(1 - v) σ_t + |dv/dt|: σ_t is the
/// standard deviation of the fluence spectrum along it, v the expected visibility. Jittered strata that hold
/// the light m around a change leave a variance of m²/6, so that the best density of strata is (λ U²)^(1/3),
/// U being the light that is expected. A first round says between which places the visibility changes; for
/// changes at random, their expected number is λΔt coth(λΔt) between places that differ and λΔt tanh(λΔt)
/// between places that do not, and with it the second round's density is made. Inside its stratum a sample is
/// drawn in proportion to U.
///
/// Every round is an unbiased estimate of its own, whatever the table says, as long as no cell hides light
/// between two dark knots: every place with light has a density, by which its sample is divided. The first
/// round's rays are not used in the second round's estimate, which would bias it.
///
/// Source: thesis 5.3.3. Differs from it in the exponent (there the density is T σ_s L σ_t; but in strata the
/// error of a border falls with the square of the stratum), in the light that is known without a shadow ray,
/// and in the expected visibility.
#[derive(Debug)]
pub struct March<'a> {
    knots: &'a [MarchKnot],
    cells: &'a [MarchCell],
    radiance: f64,
    expected: f64,
}

impl<'a> March<'a> {
    /// Prepares a table.
    ///
    /// - `knots`: two or more, by distance. Between them the radiance is taken as linear, and where two
    ///   neighbours are dark no sample is placed: lay them where light is, such as inside a spot's cone.
    /// - `cells`: as many as knots.
    ///
    /// Cost: 25 ns a knot.
    pub fn new(knots: &'a [MarchKnot], cells: &'a mut [MarchCell]) -> Result<Self, MarchError> {
        if knots.len() < 2 || cells.len() != knots.len() {
            return Err(MarchError::Length);
        }
        let ordered =
            |pair: &[MarchKnot]| pair[0].distance <= pair[1].distance && pair[1].distance.is_finite();
        if !(knots[0].distance.is_finite() && knots.windows(2).all(ordered)) {
            return Err(MarchError::Distance);
        }
        let length = f64::from(knots[knots.len() - 1].distance) - f64::from(knots[0].distance);
        let mut sum = MarchCell::default();
        let (mut radiance, mut expected) = (0.0, 0.0);
        cells[0] = sum;
        for (pair, cell) in knots.windows(2).zip(&mut cells[1..]) {
            let step = f64::from(pair[1].distance) - f64::from(pair[0].distance);
            let mass = 0.5 * step * (pair[0].light() + pair[1].light());
            let rate = 0.5 * (pair[0].rate(length) + pair[1].rate(length));
            // Where it is dark, changes do not matter.
            let difference = (pair[0].expected_visibility() - pair[1].expected_visibility()).abs();
            let changes = if mass > 0.0 { step * rate + difference } else { 0.0 };
            sum.mass += mass;
            sum.changes += changes;
            sum.measure += cube_root(mass * mass * changes);
            radiance += 0.5 * step * (pair[0].unoccluded() + pair[1].unoccluded());
            expected += 0.5 * step * (pair[0].seen_light() + pair[1].seen_light());
            *cell = sum;
        }
        Ok(Self { knots, cells, radiance, expected })
    }

    /// The light that would be scattered to the eye without occluders \[W/(m² sr)\]: the integral of the
    /// table.
    pub fn radiance(&self) -> f32 {
        self.radiance as f32
    }

    /// The light that is expected to be scattered to the eye \[W/(m² sr)\]: with the knots' visibility, half
    /// where it is not known.
    pub fn expected_radiance(&self) -> f32 {
        self.expected as f32
    }

    /// The standard deviation that the estimate from one round is expected to have, times the number of its
    /// shadow rays \[W/(m² sr)\]. To spread rays over pixels, give to each in proportion to a power of it.
    pub fn expected_error(&self) -> f32 {
        let measure = self.total().measure;
        sqrt(measure * measure * measure / 6.0) as f32
    }

    /// How many of `rays` should be spent on a first round; 0 = all in one round, because the expected
    /// changes are too many to be found one by one. For a light with an extent one round is better whatever
    /// this says: two shadow rays to different points of it differ without a border between them.
    pub fn first_round(&self, rays: usize) -> usize {
        let worth = rays >= LEAST_RAYS && rays as f64 >= RAYS_A_CHANGE * self.total().changes;
        if worth { (FIRST_ROUND * rays as f64) as usize } else { 0 }
    }

    /// Places a round of samples from the table alone.
    ///
    /// - `jitter`: a uniform number in \[0, 1) a sample, independent of each other.
    /// - `samples`: as many as `jitter` (the shorter of both counts); written from near to far.
    ///
    /// A table without light gives samples of weight 0 at the first knot.
    ///
    /// Guarantee: unbiased (test `both_rounds_are_unbiased_and_a_wrong_weight_is_not`); no sample where two
    /// neighbouring knots are dark. Cost: 1 µs for 10 samples with 97 knots (bench `march`).
    pub fn place(&self, jitter: &[f32], samples: &mut [MarchSample]) {
        self.refine(&[], jitter, samples);
    }

    /// Places a second round of samples, dense where the first one saw changes.
    ///
    /// - `first`: what [`March::place`] wrote, with the visibilities found. A NaN, and a sample of weight 0,
    ///   say nothing.
    /// - `jitter`, `samples`: as in [`March::place`], independent of the first round.
    ///
    /// The estimate is the sum over `samples` alone.
    ///
    /// Guarantee: as [`March::place`]. Cost: 3 µs for 10 and 20 samples with 97 knots (bench `march`).
    pub fn refine(&self, first: &[MarchSample], jitter: &[f32], samples: &mut [MarchSample]) {
        // Strata of equal measure, and from each a sample in proportion to the table.
        let count = samples.len().min(jitter.len());
        let samples = &mut samples[..count];
        let total = self.total();
        let dark = MarchSample { distance: self.knots[0].distance, ..MarchSample::default() };
        samples.fill(dark);
        if !(total.mass > 0.0 && count > 0) {
            return;
        }
        let mut measure = 0.0;
        self.spans(first, |span| measure += span.measure);
        let (steep, flat) = ((1.0 - DEFENSIVE) / measure, DEFENSIVE / total.mass);
        let mut placed = 0;
        let (mut start, mut reached) = (0.0, 0.0);
        self.spans(first, |span| {
            let share = steep * span.measure + flat * (span.to - span.from);
            while placed + 1 < count && (placed + 1) as f64 <= (reached + share) * count as f64 {
                let part = ((placed + 1) as f64 / count as f64 - reached) / share;
                let end = span.from + part.clamp(0.0, 1.0) * (span.to - span.from);
                samples[placed] = self.draw(start, end, jitter[placed]).unwrap_or(dark);
                (start, placed) = (end, placed + 1);
            }
            reached += share;
        });
        // Rounding may have left more than one.
        for (sample, &jitter) in samples[placed..].iter_mut().zip(&jitter[placed..]) {
            *sample = self.draw(start, total.mass, jitter).unwrap_or(dark);
            start = total.mass;
        }
    }

    fn total(&self) -> MarchCell {
        self.cells[self.cells.len() - 1]
    }

    /// Visits the spans of the table between knots and samples, with their measures.
    fn spans(&self, first: &[MarchSample], mut visit: impl FnMut(&Span)) {
        let known = |sample: &&MarchSample| sample.weight > 0.0 && !sample.visibility.is_nan();
        let mut ends = first.iter().filter(known);
        let mut before: Option<&MarchSample> = None;
        let mut next = ends.next();
        let mut factor = self.factor(before, next);
        let mut from = 0.0;
        for pair in self.cells.windows(2) {
            let mass = pair[1].mass - pair[0].mass;
            if !(mass > 0.0) {
                continue;
            }
            let density = (pair[1].measure - pair[0].measure) / mass;
            while let Some(end) = next.filter(|end| end.mass < pair[1].mass) {
                let to = end.mass.max(from);
                visit(&Span { from, to, measure: factor * density * (to - from) });
                from = to;
                before = next;
                next = ends.next();
                factor = self.factor(before, next);
            }
            visit(&Span { from, to: pair[1].mass, measure: factor * density * (pair[1].mass - from) });
            from = pair[1].mass;
        }
    }

    /// By how much the measure between two samples of the first round grows with what they saw.
    fn factor(&self, before: Option<&MarchSample>, next: Option<&MarchSample>) -> f64 {
        let (Some(before), Some(next)) = (before, next) else { return 1.0 };
        let changes = (self.changes_before(next.mass) - self.changes_before(before.mass)).max(1e-6);
        let difference = f64::from((next.visibility - before.visibility).abs().min(1.0));
        let tangent = tanh(changes);
        cube_root((1.0 - difference) * tangent + difference / tangent)
    }

    /// The cell that holds light up to `mass` > 0.
    fn cell_of(&self, mass: f64) -> usize {
        self.cells.partition_point(|cell| cell.mass < mass).clamp(1, self.cells.len() - 1) - 1
    }

    fn changes_before(&self, mass: f64) -> f64 {
        let index = self.cell_of(mass);
        let (low, high) = (self.cells[index], self.cells[index + 1]);
        let share = (mass - low.mass) / (high.mass - low.mass).max(f64::MIN_POSITIVE);
        low.changes + share * (high.changes - low.changes)
    }

    /// A sample of the stratum between two masses; None if there is nothing in it.
    fn draw(&self, from: f64, to: f64, jitter: f32) -> Option<MarchSample> {
        // Above 0, so that a cell with light is found.
        let mass = from + f64::from(jitter.clamp(f32::EPSILON / 4.0, 1.0)) * (to - from);
        let index = self.cell_of(mass);
        let (a, b) = (self.knots[index], self.knots[index + 1]);
        let (low, high) = (a.light(), b.light());
        let step = f64::from(b.distance) - f64::from(a.distance);
        // The root of low y + (high - low) y²/2 = the mass inside the cell, without cancellation.
        let inside = ((mass - self.cells[index].mass) / step).max(0.0);
        let root = sqrt((low * low + 2.0 * (high - low) * inside).max(0.0));
        let y = (2.0 * inside / (low + root)).min(1.0);
        let light = low + y * (high - low);
        let weight = ((to - from) / light) as f32;
        let distance = (f64::from(a.distance) + y * step) as f32;
        (weight > 0.0 && weight.is_finite()).then_some(MarchSample {
            distance,
            weight,
            visibility: 0.0,
            mass,
        })
    }
}

/// A span of the table inside one cell and between two samples.
struct Span {
    from: f64,
    to: f64,
    measure: f64,
}

impl MarchKnot {
    fn unoccluded(&self) -> f64 {
        if self.radiance > 0.0 && self.radiance < f32::INFINITY { f64::from(self.radiance) } else { 0.0 }
    }

    /// What samples are drawn in proportion to. Half of the visibility is as good as all of it: where it is
    /// in doubt, all may arrive.
    fn light(&self) -> f64 {
        (2.0 * self.expected_visibility()).clamp(LEAST_EXPECTED, 1.0) * self.unoccluded()
    }

    fn seen_light(&self) -> f64 {
        self.expected_visibility() * self.unoccluded()
    }

    /// Expected changes of the visibility a metre.
    fn rate(&self, length: f64) -> f64 {
        let known = self.deviation >= 0.0 && self.deviation < f32::INFINITY;
        let rate = if known { f64::from(self.deviation) } else { UNKNOWN_CHANGES / length };
        let visibility = self.expected_visibility();
        4.0 * visibility * (1.0 - visibility) * rate + LEAST_CHANGES / length
    }

    fn expected_visibility(&self) -> f64 {
        if self.visibility >= 0.0 { f64::from(self.visibility.min(1.0)) } else { 0.5 }
    }
}

/// Of a number >= 0. (libm's `cbrt` asks which processor it runs on.)
fn cube_root(x: f64) -> f64 {
    pow(x, 1.0 / 3.0)
}
