//! Lights: how photons leave them and what they send straight to a surface.

mod aim;
mod area;
mod cells;
mod directions;
pub mod falloff;
mod glow;
pub mod kinds;
mod lamp;
mod mesh;
mod own;
mod pattern;
mod rays;
mod seen;
mod shine;
pub mod shown;
mod sky;
mod spot;
mod stretch;
mod sun;

pub use aim::Ball;
pub(crate) use aim::HEIGHTS;
pub use area::Area;
pub use directions::cosine_direction;
pub use glow::GlowingFog;
pub use kinds::{Light, OwnLight};
pub use lamp::Lamp;
pub use mesh::ShiningMesh;
pub use pattern::Pattern;
pub use rays::EmittedPhoton;
pub(crate) use rays::Meetings;
pub(crate) use shine::Shine;
pub use sky::Sky;
pub use spot::Cone;
pub use sun::Sun;

use crate::random::{PathSampler, Random};
use covbeam::{EVEN_LAMP, LightField};
use covbeam_geometry::shape::{Shape, intersect_rectangle, intersect_sphere};
use directions::{across, cone_direction, even_direction};
use glam::{DVec3, Vec3};
use seen::patch::{FRAC_1_SQRT_PI, diffuse_field, equal_radius, front};
use seen::{disk, patch, sphere};
pub(crate) use spot::cap_height;
use spot::{angle_from, spot_angular_variance, spot_falloff};
use std::f32::consts::{FRAC_1_SQRT_2, PI, TAU};
use stretch::{before, in_cone, outside_sphere};

impl Light {
    /// Total flux \[W\] per channel, for choosing between lights (a spot counts its full cone).
    pub fn flux(&self) -> Vec3 {
        match *self {
            Light::Point { intensity, .. } => 4.0 * PI * intensity,
            Light::Spot { intensity, outer_angle, .. } => TAU * cap_height(outer_angle) * intensity,
            Light::Disk { radius, radiance, .. } => PI * PI * radius * radius * radiance,
            Light::Rectangle { edge_u, edge_v, radiance, .. } => {
                PI * edge_u.cross(edge_v).length() * radiance
            }
            Light::Sphere { radius, radiance, .. } => 4.0 * PI * PI * radius * radius * radiance,
            Light::Sun(sun) => sun.flux(),
            Light::Lamp(ref lamp) => lamp.flux(),
            Light::Area(area) => area.flux(),
            Light::Mesh(ref mesh) => mesh.flux(),
            Light::Sky(ref sky) => sky.flux(),
            Light::Glow(ref fog) => fog.flux(),
            Light::Own(ref own) => own.described.flux(),
        }
    }

    /// A point of the light, or ahead of it; which media it lies in is found from here.
    pub fn position(&self) -> Vec3 {
        match *self {
            Light::Point { position, .. } | Light::Spot { position, .. } => position,
            Light::Disk { center, normal, radius, .. } => center + 1e-4 * radius * normal,
            Light::Rectangle { corner, edge_u, edge_v, .. } => {
                corner + 0.5 * (edge_u + edge_v) + 1e-4 * equal_radius(edge_u, edge_v) * front(edge_u, edge_v)
            }
            Light::Sphere { center, .. } => center,
            Light::Sun(sun) => sun.position(),
            Light::Lamp(ref lamp) => lamp.position,
            Light::Area(area) => area.position(),
            Light::Mesh(ref mesh) => mesh.position(),
            Light::Sky(ref sky) => sky.position(),
            Light::Glow(ref fog) => fog.position(),
            Light::Own(ref own) => own.described.position(),
        }
    }

    /// Whether its light comes straight from it, for shadow rays to look for; else it counts as scattered, and photons bring all of it.
    pub(crate) fn is_straight(&self) -> bool {
        !matches!(self, Light::Glow(_))
    }

    /// Whether its light comes from infinitely far away.
    pub(crate) fn is_far(&self) -> bool {
        match self {
            Light::Own(own) => own.described.is_far(),
            light => matches!(light, Light::Sun(_) | Light::Sky(_)),
        }
    }

    /// A box that a scene's own must hold: of what is infinitely far away, what it shines on.
    pub(crate) fn bounds(&self) -> (Vec3, Vec3) {
        match self {
            Light::Sun(sun) => sun.bounds(),
            Light::Lamp(lamp) => lamp.bounds(),
            Light::Area(area) => area.bounds(),
            Light::Mesh(mesh) => mesh.bounds(),
            Light::Sky(sky) => sky.bounds(),
            Light::Glow(fog) => fog.bounds(),
            Light::Own(own) => own.described.bounds(),
            _ => (self.position(), self.position()),
        }
    }

    /// Whether a photon that has met nothing yet may start there.
    pub fn may_have_sent(&self, origin: Vec3, direction: Vec3) -> bool {
        match *self {
            Light::Point { position, .. } | Light::Spot { position, .. } => origin == position,
            Light::Disk { center, radius, .. } | Light::Sphere { center, radius, .. } => {
                origin.distance(center) <= 1.001 * radius
            }
            Light::Rectangle { edge_u, edge_v, .. } => {
                origin.distance(self.position()) <= 0.501 * (edge_u.length() + edge_v.length())
            }
            Light::Sun(sun) => sun.may_have_sent(direction),
            Light::Lamp(ref lamp) => lamp.may_have_sent(origin, direction),
            Light::Area(area) => area.may_have_sent(origin),
            Light::Mesh(ref mesh) => mesh.may_have_sent(origin),
            Light::Sky(ref sky) => sky.may_have_sent(origin),
            // Its light counts as scattered.
            Light::Glow(_) => false,
            Light::Own(ref own) => own.described.may_have_sent(origin, direction),
        }
    }

    /// Draws a photon.
    pub fn emit(&self, sampler: &mut PathSampler) -> EmittedPhoton {
        let place = sampler.uniform_pair();
        self.emit_at(place, sampler)
    }

    /// The photon of a place in the unit square, whose second number is an angle around the light's axis. It says where the photon goes;
    /// from which point of a light that has a size `sampler` draws. Of a sun it is the other way round; of a mesh it says where the photon goes
    /// from its triangle.
    pub fn emit_at(&self, [a, b]: [f32; 2], sampler: &mut PathSampler) -> EmittedPhoton {
        match *self {
            Light::Point { position, intensity } => {
                let direction = even_direction([a, b]);
                EmittedPhoton::new(position, direction, 4.0 * PI * intensity, Vec3::ZERO)
            }
            Light::Spot { position, direction: axis, intensity, inner_angle, outer_angle } => {
                let height = cap_height(outer_angle);
                let direction = cone_direction(axis, height, [a, b]);
                let falloff = spot_falloff(axis, direction, inner_angle, outer_angle);
                let power = falloff * TAU * height * intensity;
                EmittedPhoton::new(position, direction, power, Vec3::ZERO)
            }
            Light::Disk { center, normal, radius, .. } => {
                let [c, d] = sampler.uniform_pair();
                let (e, f) = normal.any_orthonormal_pair();
                let (sin_psi, cos_psi) = libm::sincosf(TAU * d);
                let rho = radius * c.sqrt();
                let origin = center + rho * (cos_psi * e + sin_psi * f) + 1e-5 * radius * normal;
                let direction = cosine_direction(normal, [a, b]);
                EmittedPhoton::new(origin, direction, self.flux(), normal)
            }
            Light::Rectangle { corner, edge_u, edge_v, .. } => {
                let [c, d] = sampler.uniform_pair();
                let normal = front(edge_u, edge_v);
                let lift = 1e-5 * equal_radius(edge_u, edge_v) * normal;
                let direction = cosine_direction(normal, [a, b]);
                let origin = corner + c * edge_u + d * edge_v + lift;
                EmittedPhoton::new(origin, direction, self.flux(), normal)
            }
            Light::Sphere { center, radius, .. } => {
                // In each direction it shines as a disk across it, evenly: the cosine foreshortens its surface.
                let direction = even_direction([a, b]);
                let [c, d] = sampler.uniform_pair();
                let across = across(direction, [c, d]);
                let normal = (across + (1.0 - c).max(0.0).sqrt() * direction).normalize();
                let origin = center + (1.0 + 1e-5) * radius * normal;
                EmittedPhoton::new(origin, direction, self.flux(), normal)
            }
            Light::Sun(sun) => sun.emit_at([a, b], sampler),
            Light::Lamp(ref lamp) => lamp.emit_at([a, b], sampler),
            Light::Area(area) => area.emit_at([a, b], sampler),
            Light::Mesh(ref mesh) => mesh.emit_at([a, b], sampler),
            Light::Sky(ref sky) => sky.emit_at([a, b], sampler),
            Light::Glow(ref fog) => fog.emit_at([a, b], sampler),
            Light::Own(ref own) => own.emit_at([a, b], sampler),
        }
    }

    /// The light field around a photon that [`Light::emit`] drew.
    pub fn light_field(&self, photon: &EmittedPhoton) -> LightField {
        match *self {
            Light::Point { .. } => LightField::point(photon.direction, EVEN_LAMP),
            Light::Spot { direction: axis, inner_angle, outer_angle, .. } => {
                let theta = angle_from(axis, photon.direction);
                let variance = spot_angular_variance(theta, inner_angle, outer_angle);
                LightField::gaussian(photon.direction, axis, [f32::INFINITY; 2], variance)
            }
            Light::Disk { normal, radius, .. } => diffuse_field(photon.direction, normal, radius),
            Light::Rectangle { edge_u, edge_v, .. } => {
                // Of a disk as wide as its shorter side: along the other one it is smoother.
                let radius = FRAC_1_SQRT_PI * edge_u.length().min(edge_v.length());
                diffuse_field(photon.direction, front(edge_u, edge_v), radius)
            }
            // It looks the same from all sides: a disk across the ray.
            Light::Sphere { radius, .. } => {
                LightField::disk(photon.direction, photon.direction, radius, EVEN_LAMP)
            }
            Light::Sun(sun) => sun.light_field(photon.direction),
            Light::Lamp(ref lamp) => lamp.light_field(photon.direction),
            Light::Area(area) => area.light_field(photon.direction),
            Light::Mesh(ref mesh) => mesh.light_field(photon.direction, photon.normal),
            Light::Sky(ref sky) => sky.light_field(photon.direction),
            Light::Glow(ref fog) => fog.light_field(photon.direction),
            Light::Own(ref own) => own.light_field(photon),
        }
    }

    /// Light that arrives straight from this light on a small ball at `point`, over the ball's cross section \[W/m²\], without the
    /// medium's transmittance; and where it comes from. `xi`, uniform in [0, 1), chooses the point that stands for the whole of a light that
    /// has a size, by solid angle; (0, 0) is the middle of what is seen of it, about.
    pub fn flux_density(&self, point: Vec3, xi: [f32; 2]) -> (Vec3, Vec3) {
        match *self {
            Light::Point { position, intensity } => {
                (intensity / (position - point).length_squared(), position)
            }
            Light::Spot { position, direction: axis, intensity, inner_angle, outer_angle } => {
                let offset = point - position;
                let d2 = offset.length_squared();
                let falloff = spot_falloff(axis, offset, inner_angle, outer_angle);
                (intensity * (falloff / d2), position)
            }
            Light::Disk { center, normal, radius, radiance } => {
                let (solid_angle, position) = disk::sample(center, normal, radius, point, xi);
                (radiance * solid_angle, position)
            }
            Light::Rectangle { corner, edge_u, edge_v, radiance } => {
                let (solid_angle, position) = patch::sample(corner, edge_u, edge_v, point, xi);
                (radiance * solid_angle, position)
            }
            Light::Sphere { center, radius, radiance } => {
                let (solid_angle, position) = sphere::sample(center, radius, point, xi);
                (radiance * solid_angle, position)
            }
            Light::Sun(sun) => sun.flux_density(point, xi),
            Light::Lamp(ref lamp) => lamp.flux_density(point, xi),
            Light::Area(area) => area.flux_density(point, xi),
            Light::Mesh(ref mesh) => mesh.flux_density(point, xi),
            Light::Sky(ref sky) => sky.flux_density(point, xi),
            Light::Glow(ref fog) => (Vec3::ZERO, fog.position()),
            Light::Own(ref own) => own.flux_density(point, xi),
        }
    }

    /// About the mean of [`Light::flux_density`] over all points of the light, and a point in the middle of what is seen of it. Above zero
    /// wherever on [`Light::lit_stretch`] any point of the light sends something, but for places that a pattern leaves dark.
    pub(crate) fn expected(&self, point: Vec3) -> (Vec3, Vec3) {
        match *self {
            Light::Lamp(ref lamp) => lamp.expected(point),
            Light::Area(area) => area.expected(point),
            Light::Mesh(ref mesh) => mesh.expected(point),
            Light::Own(ref own) => own.expected(point),
            // All their points send the same, about.
            _ => self.flux_density(point, [0.0; 2]),
        }
    }

    /// The part of a ray's stretch `from..to` that the light shines on if nothing is in its way; None = no part.
    pub fn lit_stretch(&self, origin: Vec3, direction: Vec3, from: f32, to: f32) -> Option<(f32, f32)> {
        let (o, d) = (origin.as_dvec3(), direction.as_dvec3());
        match *self {
            Light::Point { .. } => (from < to).then_some((from, to)),
            Light::Spot { position, direction: axis, outer_angle, .. } => {
                let (m, axis) = (o - position.as_dvec3(), axis.as_dvec3());
                in_cone(m, d, axis, libm::cos(f64::from(outer_angle)), [from, to])
            }
            Light::Disk { center, normal, .. } => {
                before(o - center.as_dvec3(), d, normal.as_dvec3(), [from, to])
            }
            Light::Rectangle { corner, edge_u, edge_v, .. } => {
                before(o - corner.as_dvec3(), d, edge_u.as_dvec3().cross(edge_v.as_dvec3()), [from, to])
            }
            Light::Sphere { center, radius, .. } => {
                outside_sphere(o - center.as_dvec3(), d, f64::from(radius), [from, to])
            }
            Light::Sun(sun) => sun.lit_stretch(o, d, [from, to]),
            Light::Lamp(ref lamp) => lamp.lit_stretch(o, d, [from, to]),
            Light::Area(area) => area.lit_stretch(o, d, [from, to]),
            Light::Mesh(_) | Light::Sky(_) => (from < to).then_some((from, to)),
            Light::Glow(_) => None,
            Light::Own(ref own) => own.described.lit_stretch(origin, direction, from, to),
        }
    }

    /// Where a ray meets the light's shining side, at distances above the first of `ends` and up to the second, and the radiance that it sees
    /// there; what is infinitely far away where that is infinite. Nothing meets a point, or a sun without an angle. Of a mesh all triangles
    /// count, since none hides another from shadow rays.
    pub(crate) fn met(&self, origin: Vec3, direction: Vec3, ends: [f64; 2], found: &mut Meetings) {
        let (o, d) = (origin.as_dvec3(), direction.as_dvec3());
        let met = match *self {
            Light::Point { .. } | Light::Spot { .. } | Light::Glow(_) => None,
            Light::Disk { center, normal, radius, radiance } => {
                let slope = d.dot(normal.as_dvec3());
                let distance = (center.as_dvec3() - o).dot(normal.as_dvec3()) / slope;
                let aside = (o + distance * d).distance(center.as_dvec3());
                (slope < 0.0 && aside < f64::from(radius)).then_some((distance, radiance))
            }
            Light::Rectangle { corner, edge_u, edge_v, radiance } => {
                let edges = (edge_u.as_dvec3(), edge_v.as_dvec3());
                let is_front = d.dot(edges.0.cross(edges.1)) < 0.0;
                let distance = intersect_rectangle(corner.as_dvec3(), edges, o, d);
                distance.filter(|_| is_front).map(|distance| (distance, radiance))
            }
            Light::Sphere { center, radius, radiance } => {
                let met = intersect_sphere(center.as_dvec3(), f64::from(radius), o, d);
                met.map(|(near, _)| (near, radiance))
            }
            Light::Sun(sun) => Some((f64::INFINITY, sun.seen_along(direction))),
            Light::Lamp(ref lamp) => lamp.met(o, d),
            Light::Area(area) => area.met(o, d),
            Light::Mesh(ref mesh) => return mesh.met(o, d, ends, found),
            Light::Sky(ref sky) => Some((f64::INFINITY, sky.seen_along(direction))),
            Light::Own(ref own) => return own.described.met(origin, direction, ends, found),
        };
        let is_there = |(distance, radiance): &(f64, Vec3)| {
            *distance > ends[0] && *distance <= ends[1] && *radiance != Vec3::ZERO
        };
        found.extend(met.filter(is_there));
    }

    /// The largest radiance that a ray may see of it, if it can be seen: it has a surface, or is a sky or a sun with an angle.
    pub fn brightest(&self) -> Option<Vec3> {
        match *self {
            Light::Disk { radiance, .. }
            | Light::Rectangle { radiance, .. }
            | Light::Sphere { radiance, .. } => Some(radiance),
            Light::Area(area) => Some(area.brightest()),
            Light::Mesh(ref mesh) => Some(mesh.radiance()),
            Light::Sky(ref sky) => Some(sky.brightest()),
            Light::Sun(sun) => (sun.angle > 0.0).then(|| sun.radiance()),
            Light::Point { .. } | Light::Spot { .. } | Light::Lamp(_) | Light::Glow(_) => None,
            Light::Own(ref own) => own.described.brightest(),
        }
    }

    /// Box around a light with a surface.
    pub(crate) fn extent(&self) -> Option<(DVec3, DVec3)> {
        let wide = |(min, max): (Vec3, Vec3)| (min.as_dvec3(), max.as_dvec3());
        match *self {
            Light::Disk { center, normal, radius, .. } => {
                let normal = normal.as_dvec3();
                let half = f64::from(radius) * (1.0 - normal * normal).max(DVec3::ZERO).sqrt();
                Some((center.as_dvec3() - half, center.as_dvec3() + half))
            }
            Light::Rectangle { corner, edge_u, edge_v, .. } => {
                Some(wide(Shape::Rectangle { corner, edge_u, edge_v }.bounds()))
            }
            Light::Sphere { center, radius, .. } => Some(wide(Shape::Sphere { center, radius }.bounds())),
            Light::Area(area) => Some(wide(area.bounds())),
            Light::Mesh(ref mesh) => Some(wide(mesh.bounds())),
            Light::Own(ref own) => own.described.extent(),
            _ => None,
        }
    }

    /// Irradiance that arrives straight from this light at a surface point, without the medium's transmittance:
    /// (irradiance, point of the light that it came from). One random point of a light that has a size stands for the whole.
    pub fn irradiance(&self, point: Vec3, normal: Vec3, random: &mut Random) -> (Vec3, Vec3) {
        match *self {
            Light::Point { position, intensity } => {
                let offset = position - point;
                let d2 = offset.length_squared();
                (intensity * (offset.dot(normal) / (d2 * d2.sqrt())).max(0.0), position)
            }
            Light::Spot { position, direction: axis, intensity, inner_angle, outer_angle } => {
                let offset = position - point;
                let d2 = offset.length_squared();
                let d = d2.sqrt();
                let falloff = spot_falloff(axis, -offset, inner_angle, outer_angle);
                (intensity * falloff * (offset.dot(normal) / (d2 * d)).max(0.0), position)
            }
            _ => {
                let (density, from) = self.flux_density(point, [random.uniform(), random.uniform()]);
                (density * (from - point).normalize_or_zero().dot(normal).max(0.0), from)
            }
        }
    }

    /// Where light falls off from, and the length h for which it arrives about as 1/(s² + h²), s being the distance from there. For a disk seen
    /// along its axis that is right at s = 0 and far away, and within 17 % between; of a sun and a sky it is the same all over the scene, about.
    pub(crate) fn middle(&self) -> (Vec3, f32) {
        let softening = match *self {
            Light::Point { .. } | Light::Spot { .. } => 0.0,
            Light::Disk { radius, .. } | Light::Sphere { radius, .. } => FRAC_1_SQRT_2 * radius,
            Light::Rectangle { edge_u, edge_v, .. } => FRAC_1_SQRT_2 * equal_radius(edge_u, edge_v),
            Light::Sun(sun) => return sun.middle(),
            Light::Lamp(ref lamp) => lamp.softening(),
            Light::Area(area) => area.softening(),
            Light::Mesh(ref mesh) => return mesh.middle(),
            Light::Sky(ref sky) => return sky.middle(),
            Light::Glow(ref fog) => fog.softening(),
            Light::Own(ref own) => return own.described.middle(),
        };
        (self.position(), softening)
    }

    /// Largest angle between the axis of a light that is a point and the directions in which it shines, in (0, π] \[rad\]; None: it is no point.
    pub(crate) fn half_angle_of_point(&self) -> Option<f32> {
        let angle = match *self {
            Light::Spot { outer_angle, .. } => outer_angle,
            Light::Lamp(Lamp { cone: Some(cone), .. }) => libm::acosf(cone.cosine.clamp(-1.0, 1.0)),
            Light::Own(ref own) => return own.described.half_angle_of_point(),
            _ => PI,
        };
        (!self.has_size()).then_some(angle)
    }

    /// Whether it is more than a point, so that shadows have soft borders.
    pub(crate) fn has_size(&self) -> bool {
        match self {
            Light::Point { .. } | Light::Spot { .. } => false,
            Light::Lamp(lamp) => lamp.has_size(),
            Light::Own(own) => own.described.has_size(),
            _ => true,
        }
    }
}

#[cfg(test)]
mod tests;
