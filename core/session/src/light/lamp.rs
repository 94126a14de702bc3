//! Lamps as Blender has them: points and balls that shine all around, into a cone, or by a pattern.

use super::directions::{across, cap_direction, cone_direction, even_direction};
use super::pattern::Pattern;
use super::rays::{EmittedPhoton, LEAST_EXPECTED, expected};
use super::seen::sphere;
use super::spot::Cone;
use super::stretch::in_cone;
use crate::random::PathSampler;
use covbeam::{EVEN_LAMP, LightField};
use glam::{DVec3, Vec3};
use std::f32::consts::{FRAC_1_SQRT_2, PI};
use std::f64::consts::TAU;
use std::sync::Arc;

/// A lamp. In each direction it shines as a disk across it, evenly: it sends the same radiance I/(πR²) along all lines of a direction that
/// meet the ball around its middle. Lamps differ in where along such a line, at b from the middle, the light begins:
///
/// - A ball: at its surface. At a distance d > R the fluence is 2πL (1 - √(1 - R²/d²)). Inside, fog sees the radiance all around, 4πL: light
///   that starts at the far side and ends at the near one. Inside of a lamp with a cone it comes from all sides, too, but from beyond the middle
///   only, 2πL.
/// - A soft one: all points see a disk of radius R around the middle that faces them. A place that lies s past the middle of a line sees it at an
///   angle of tangent b/s to the middle, which is less than R/d where s > b²/√(R² - b²): there the light begins, for some lines inside of the
///   ball and for others far outside. The fluence is 2πL (1 - d/√(d² + R²)). What dims it starts in the plane through the middle, across the
///   line.
///
/// Its pattern has no say in where places of the lamp lie: each has that of its middle.
#[derive(Clone, Debug, PartialEq)]
pub struct Lamp {
    /// Middle.
    pub position: Vec3,
    /// On the axis, where neither cone nor pattern dims it \[W/sr\].
    pub intensity: Vec3,
    /// >= 0; 0 is a point.
    pub radius: f32,
    /// Whether all points see a disk that faces them, and no ball.
    pub soft: bool,
    /// None: all around.
    pub cone: Option<Cone>,
    /// How the intensity differs with direction besides; None: not at all.
    pub pattern: Option<Arc<Pattern>>,
    /// How many photons light the inside of a ball, in those that as much light would have that leaves it: in (0, 1].
    /// [`Lamp::glow`] says what is about right.
    pub glow: f32,
}

impl Lamp {
    /// What [`Lamp::glow`] is about right where fog reaches so far: the mean length of the ball's lines inside, over how far other light goes.
    ///
    /// - `radius`, `fog` > 0, `has_cone`: of the lamp.
    pub fn glow_of(radius: f32, has_cone: bool, fog: f32) -> f32 {
        let length = if has_cone { 2.0 } else { 4.0 } / 3.0 * radius;
        (length / fog.max(f32::MIN_POSITIVE)).clamp(1e-6, 1.0)
    }

    /// Whether its inside glows.
    fn is_ball(&self) -> bool {
        self.radius > 0.0 && !self.soft
    }

    pub(super) fn has_size(&self) -> bool {
        self.radius > 0.0
    }

    /// Of all lines on the axis [W/(m² sr)].
    fn radiance(&self) -> Vec3 {
        self.intensity / (PI * self.radius * self.radius)
    }

    /// Factor of the pattern on the light of a direction.
    fn patterned(&self, direction: Vec3) -> Vec3 {
        self.pattern.as_ref().map_or(Vec3::ONE, |pattern| pattern.factor(direction))
    }

    /// Factor on the light that leaves along a direction.
    fn factor(&self, direction: Vec3) -> Vec3 {
        self.cone.map_or(1.0, |cone| cone.falloff(direction)) * self.patterned(direction)
    }

    /// Flux into a steradian of what leaves, the mean of where it shines in full.
    pub(super) fn mean_intensity(&self) -> Vec3 {
        self.intensity * self.pattern.as_ref().map_or(Vec3::ONE, |pattern| pattern.total() / (4.0 * PI))
    }

    /// Flux of what leaves; a cone counts in full.
    fn leaving(&self) -> Vec3 {
        let angle = self.cone.map_or(4.0 * PI, |cone| cone.solid_angle());
        self.intensity * self.pattern.as_ref().map_or(Vec3::splat(angle), |pattern| pattern.total())
    }

    /// Flux of the lines inside, in so far as photons are spent on it.
    fn glowing(&self) -> Vec3 {
        if !self.is_ball() {
            return Vec3::ZERO;
        }
        let all = self.pattern.as_ref().map_or(Vec3::splat(4.0 * PI), |pattern| pattern.total());
        self.glow * self.intensity * all
    }

    pub(super) fn flux(&self) -> Vec3 {
        self.leaving() + self.glowing()
    }

    pub(super) fn bounds(&self) -> (Vec3, Vec3) {
        (self.position - self.radius, self.position + self.radius)
    }

    /// As [`super::Light::may_have_sent`].
    pub(super) fn may_have_sent(&self, origin: Vec3, direction: Vec3) -> bool {
        let offset = origin - self.position;
        if self.radius == 0.0 {
            return offset == Vec3::ZERO;
        }
        let along = offset.dot(direction);
        let aside2 = (offset - along * direction).length_squared() / (self.radius * self.radius);
        if !self.soft {
            return offset.length() <= 1.001 * self.radius;
        }
        // As in `emit_at`, which is coarse at the rim.
        let height = (1.0 - aside2).max(0.0).sqrt();
        aside2 <= 1.001 && (along / self.radius * height - aside2).abs() < 1e-2
    }

    /// A direction in which light leaves, and the light over its probability density.
    fn leave(&self, place: [f32; 2]) -> (Vec3, Vec3) {
        match (&self.pattern, self.cone) {
            (Some(pattern), cone) => {
                let drawn = pattern.draw(place);
                let direction = drawn.direction.as_vec3().normalize();
                let falloff = cone.map_or(1.0, |cone| cone.falloff(direction));
                (direction, self.intensity * drawn.weight * falloff)
            }
            (None, Some(cone)) => {
                let direction = cone_direction(cone.axis, cone.height(), place);
                (direction, self.leaving() * cone.falloff(direction))
            }
            (None, None) => (even_direction(place), self.leaving()),
        }
    }

    /// The same of the inside of a ball.
    fn cross(&self, place: [f32; 2]) -> (Vec3, Vec3) {
        match &self.pattern {
            Some(pattern) => {
                let drawn = pattern.draw(place);
                (drawn.direction.as_vec3().normalize(), self.intensity * drawn.weight)
            }
            None => (even_direction(place), 4.0 * PI * self.intensity),
        }
    }

    /// As [`super::Light::emit_at`].
    pub(super) fn emit_at(&self, place: [f32; 2], sampler: &mut PathSampler) -> EmittedPhoton {
        let Self { position, radius, .. } = *self;
        if radius == 0.0 {
            let (direction, power) = self.leave(place);
            return EmittedPhoton::new(position, direction, power, Vec3::ZERO);
        }
        // The choice between inside and outside takes its share of a number, which is then uniform again.
        let [u, d] = sampler.uniform_pair();
        let (inside, outside) = (self.glowing().element_sum(), self.leaving().element_sum());
        let share = inside / (inside + outside);
        let is_inside = u < share;
        let (c, share) =
            if is_inside { (u / share, share) } else { ((u - share) / (1.0 - share), 1.0 - share) };
        let (direction, power) = if is_inside { self.cross(place) } else { self.leave(place) };
        let across = across(direction, [c.min(1.0), d]);
        let aside2 = across.length_squared().min(1.0 - 0.5 * f32::EPSILON);
        // Half of the chord.
        let height = (1.0 - aside2).sqrt();
        let photon = |from_middle: f32, normal| {
            let origin = position + radius * (across + from_middle * direction);
            EmittedPhoton::new(origin, direction, power / share, normal)
        };
        if is_inside {
            let begin = if self.cone.is_some() { 0.0 } else { -height };
            EmittedPhoton { until: radius * (height - begin), ..photon(begin, Vec3::ZERO) }
        } else if self.soft {
            EmittedPhoton { dark: radius * aside2 / height, ..photon(0.0, Vec3::ZERO) }
        } else {
            photon(height, (across + height * direction).normalize())
        }
    }

    /// As [`super::Light::light_field`]: a disk across the ray, which a ball is from all sides.
    pub(super) fn light_field(&self, direction: Vec3) -> LightField {
        let patterned = self.pattern.as_ref().map_or(0.0, |pattern| pattern.angular_variance(direction));
        match self.cone {
            None => LightField::disk(direction, direction, self.radius, patterned.max(EVEN_LAMP)),
            Some(cone) => {
                let (axis, variances) = cone.angular_variance(direction);
                let width = PI * self.radius;
                let angular = variances.map(|variance| variance.max(patterned));
                LightField::gaussian(direction, axis, [1.0 / (width * width); 2], angular)
            }
        }
    }

    /// Radiance that comes along a unit direction to a place, from the middle, and how far back that light begins. None: it does not.
    fn along(&self, offset: DVec3, direction: DVec3) -> Option<(Vec3, f64)> {
        let radius = f64::from(self.radius);
        let (past, way) = (offset.dot(direction), direction.as_vec3());
        let aside2 = (offset - past * direction).length_squared();
        let height = (radius * radius - aside2).max(0.0).sqrt();
        let radiance = self.radiance();
        if !(height > 0.0) {
            None
        } else if self.soft {
            (past * height > aside2).then(|| (radiance * self.factor(way), past))
        } else if offset.length_squared() <= radius * radius {
            let begin = if self.cone.is_some() { 0.0 } else { -height };
            (past > begin).then(|| (radiance * self.patterned(way), past - begin))
        } else {
            (past > 0.0).then(|| (radiance * self.factor(way), past - height))
        }
    }

    /// As [`super::Light::flux_density`].
    pub(super) fn flux_density(&self, point: Vec3, xi: [f32; 2]) -> (Vec3, Vec3) {
        let Self { position, radius, .. } = *self;
        let offset = point.as_dvec3() - position.as_dvec3();
        let distance = offset.length();
        let axis = offset.try_normalize();
        if radius == 0.0 {
            let Some(axis) = axis else { return (Vec3::ZERO, position) };
            return (self.intensity * self.factor(axis.as_vec3()) / (distance * distance) as f32, position);
        }
        let size = f64::from(radius);
        if !self.soft && distance > size {
            let (solid_angle, from) = sphere::sample(position, radius, point, xi);
            let direction = (point.as_dvec3() - from.as_dvec3()).normalize().as_vec3();
            return (self.radiance() * self.factor(direction) * solid_angle, from);
        }
        // The cone in which it shines on the point, and of what is inside of a ball all around or half of that.
        let height = match (self.soft, self.cone) {
            (true, _) => {
                let far = libm::hypot(distance, size);
                size / far * (size / (far + distance))
            }
            (false, None) => 2.0,
            (false, Some(_)) => 1.0,
        };
        let direction = cap_direction(axis.unwrap_or(DVec3::Y), height, xi);
        let past = offset.dot(direction);
        let from_middle = |back: f64| (point.as_dvec3() - back * direction).as_vec3();
        let way = direction.as_vec3().normalize();
        let solid_angle = (TAU * height) as f32;
        if self.soft {
            return (self.radiance() * self.factor(way) * solid_angle, from_middle(past));
        }
        let half = (size * size - (offset - past * direction).length_squared()).max(0.0).sqrt();
        let begin = if self.cone.is_some() { 0.0 } else { -half };
        (self.radiance() * self.patterned(way) * solid_angle, from_middle(past - begin))
    }

    /// As [`super::Light::expected`]: the mean of some points, and a little of what it would be without cone and pattern.
    pub(super) fn expected(&self, point: Vec3) -> (Vec3, Vec3) {
        let exact = self.radius == 0.0 && self.pattern.is_none();
        if exact || (self.cone.is_none() && self.pattern.is_none()) {
            return self.flux_density(point, [0.0; 2]);
        }
        let found = expected(self.has_size(), |xi| self.flux_density(point, xi).0);
        let all = self.pattern.as_ref().map_or(Vec3::ONE, |pattern| pattern.total() / (4.0 * PI));
        let even =
            self.intensity * all / point.distance_squared(self.position).max(self.radius * self.radius);
        (found + LEAST_EXPECTED * even, self.position)
    }

    /// As [`super::Light::lit_stretch`].
    pub(super) fn lit_stretch(&self, origin: DVec3, direction: DVec3, ends: [f32; 2]) -> Option<(f32, f32)> {
        // Half of space and more is no cone that a ray could be cut by.
        let Some(cone) = self.cone.filter(|cone| cone.cosine > 0.0) else {
            return (ends[0] < ends[1]).then_some((ends[0], ends[1]));
        };
        // All places that light of the ball reaches lie in a cone that touches the ball.
        let (axis, cosine) = (cone.axis.as_dvec3(), f64::from(cone.cosine));
        let behind = f64::from(self.radius) / (1.0 - cosine * cosine).sqrt();
        in_cone(origin - (self.position.as_dvec3() - behind * axis), direction, axis, cosine, ends)
    }

    /// As [`super::Light::met`].
    pub(super) fn met(&self, origin: DVec3, direction: DVec3) -> Option<(f64, Vec3)> {
        let is_there = self.radius > 0.0;
        let found = is_there.then(|| self.along(origin - self.position.as_dvec3(), -direction)).flatten();
        found.map(|(radiance, back)| (back, radiance))
    }

    /// As the second of [`super::Light::middle`]: right in the middle and far away, for a disk and the inside of a ball.
    pub(super) fn softening(&self) -> f32 {
        if self.soft { FRAC_1_SQRT_2 * self.radius } else { 0.5 * self.radius }
    }
}
