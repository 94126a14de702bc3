//! The glass ball around the origin: intersection, Fresnel reflectance, refraction.

use covbeam::Vec3;

/// Where a ray starts. On the ball it must be stored: the distance to the ball is rounding noise there.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Place {
    Fog,
    Outside,
    Inside,
}

/// The head of a photon's or an eye ray's path.
#[derive(Clone, Copy)]
pub(crate) struct Ray {
    pub(crate) origin: Vec3,
    pub(crate) direction: Vec3,
    /// The ball's outward normal if the ray starts there, else 0.
    pub(crate) normal: Vec3,
    pub(crate) place: Place,
}

impl Ray {
    pub(crate) fn in_fog(origin: Vec3, direction: Vec3) -> Self {
        Self { origin, direction, normal: Vec3::ZERO, place: Place::Fog }
    }
}

#[derive(Clone, Copy)]
pub(crate) struct Ball {
    pub(crate) radius: f32,
    /// Refractive index, that of the fog being 1.
    pub(crate) index: f32,
}

/// Both ways on from a point of the ball.
pub(crate) struct Split {
    /// Fresnel reflectance.
    pub(crate) reflectance: f32,
    /// Index on this side over that on the other one.
    pub(crate) eta: f32,
    pub(crate) reflected: Ray,
    pub(crate) refracted: Ray,
}

impl Ball {
    /// Distance along a ray to the ball, or infinity.
    pub(crate) fn distance(&self, ray: &Ray) -> f32 {
        let middle = -ray.origin.dot(ray.direction);
        let aside = ray.origin + middle * ray.direction;
        let half = (self.radius * self.radius - aside.length_squared()).max(0.0).sqrt();
        match ray.place {
            Place::Inside => middle + half,
            Place::Fog if half > 0.0 && middle > half => middle - half,
            Place::Fog | Place::Outside => f32::INFINITY,
        }
    }

    /// Reflects and refracts a ray that meets the ball at `distance`.
    pub(crate) fn split(&self, ray: &Ray, distance: f32) -> Split {
        let normal = (ray.origin + distance * ray.direction).normalize();
        let inside = ray.place == Place::Inside;
        let eta = if inside { self.index } else { 1.0 / self.index };
        let along = normal.dot(ray.direction);
        let cos_i = along.abs().min(1.0);
        let cos_t = (1.0 - eta * eta * (1.0 - cos_i * cos_i)).max(0.0).sqrt();
        let turn = if inside { cos_t - eta * cos_i } else { eta * cos_i - cos_t };
        let s = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
        let p = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
        let leave = |direction: Vec3, inside: bool| Ray {
            origin: self.radius * normal,
            direction: direction.normalize(),
            normal,
            place: if inside { Place::Inside } else { Place::Outside },
        };
        Split {
            reflectance: if cos_t > 0.0 { 0.5 * (s * s + p * p) } else { 1.0 },
            eta,
            reflected: leave(ray.direction - 2.0 * along * normal, inside),
            refracted: leave(eta * ray.direction + turn * normal, !inside),
        }
    }
}
