//! What a smooth surface does to a ray: reflection, refraction, Fresnel, and which media a ray is in.

use crate::geometry::MOST_BOUNDS;
use crate::light::EmittedPhoton;
use crate::scene::{Light, MediumId, Object, Placed, Scene};
use covbeam::Curvature;
use covbeam_geometry::hit::Hit;
use glam::Vec3;

/// What a ray is inside of: of a scene's shapes the closed dielectric ones, innermost last; of placed objects the volumes of fog, and whether
/// it is in glass, in which fog goes on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Interior {
    objects: [u32; Interior::DEEPEST],
    depth: usize,
    /// A set of volumes.
    pub(crate) fogs: u64,
    /// Whether it is inside of placed glass.
    pub(crate) glass: bool,
}

impl Interior {
    /// Objects nested deeper than this are treated as if entering them changed nothing.
    pub const DEEPEST: usize = 8;

    /// What a ray that starts at `point` is inside of.
    pub fn at(scene: &Scene, point: Vec3) -> Self {
        let mut interior = Self::default();
        for object in scene.containing(point) {
            interior.enter(object);
        }
        if let Some(placed) = &scene.placed {
            (interior.fogs, interior.glass) = placed.insides_at(point);
        }
        interior
    }

    /// What a light's place is inside of. Light from infinitely far away starts ahead of all that is placed.
    pub(crate) fn of_light(scene: &Scene, light: &Light) -> Self {
        let interior = Self::at(scene, light.position());
        if light.is_far() { Self { fogs: 0, glass: false, ..interior } } else { interior }
    }

    /// Where a photon of a light starts whose place is inside of this, and what it is inside of there; None: the light is not there.
    pub(crate) fn start_of(
        self,
        scene: &Scene,
        light: &Light,
        emitted: &EmittedPhoton,
    ) -> Option<(Vec3, Self)> {
        if let Light::Glow(fog) = light {
            let interior = Self::at(scene, emitted.origin);
            return fog.is_in(scene, &interior).then(|| (scene.beside(emitted.origin), interior));
        }
        if light.is_far() {
            return Some((emitted.origin, self));
        }
        // What leaves no surface starts on the side of bounds that it is taken to be on.
        let origin = if emitted.normal == Vec3::ZERO { scene.beside(emitted.origin) } else { emitted.origin };
        let may_reach_through_bounds = scene.placed.as_ref().is_some_and(Placed::has_insides)
            || matches!(light, Light::Lamp(_) | Light::Area(_) | Light::Mesh(_));
        Some((
            origin,
            if may_reach_through_bounds { self.moved(scene, light.position(), origin) } else { self },
        ))
    }

    /// What a ray that starts at `to` is inside of, from what places at `from` are inside of: across all that is between the two, as
    /// where some of a lamp sticks out of fog. Costs nothing where nothing has an inside.
    pub fn moved(mut self, scene: &Scene, from: Vec3, to: Vec3) -> Self {
        if let Some(placed) = &scene.placed {
            (self.fogs, self.glass) = placed.insides_moved((self.fogs, self.glass), from, to);
        }
        let is_filled = |object: &Object| object.material.index().is_some();
        if !scene.objects.iter().any(is_filled) {
            return self;
        }
        let mut start = from;
        for _ in 0..MOST_BOUNDS {
            let Some(direction) = (to - start).try_normalize() else { break };
            let Some(hit) = scene.intersect(start, direction, (to - start).length()) else { break };
            if scene.objects.get(hit.object as usize).is_some_and(is_filled) {
                self = self.beyond(scene, &hit, direction);
            }
            start = hit.leave(direction);
        }
        self
    }

    /// Steps into an object.
    pub fn enter(&mut self, object: u32) {
        if self.depth < Self::DEEPEST {
            self.objects[self.depth] = object;
            self.depth += 1;
        }
    }

    /// Steps out of an object; does nothing if the ray was not inside.
    pub fn leave(&mut self, object: u32) {
        if let Some(place) = self.objects[..self.depth].iter().rposition(|&o| o == object) {
            self.objects.copy_within(place + 1..self.depth, place);
            self.depth -= 1;
        }
    }

    /// The region here, a medium and on which side of glass; None = nothing scatters or absorbs.
    pub fn medium(&self, scene: &Scene) -> Option<u32> {
        self.fog(scene).map(|medium| scene.region(medium, self.glass))
    }

    /// The medium here.
    pub(crate) fn fog(&self, scene: &Scene) -> Option<MediumId> {
        match (self.objects[..self.depth].last(), &scene.placed) {
            (Some(&object), _) => scene.objects[object as usize].inside,
            (None, Some(placed)) => placed.fogs().medium(self.fogs).or(scene.outside),
            (None, None) => scene.outside,
        }
    }

    /// The index of refraction here.
    pub fn index(&self, scene: &Scene) -> f32 {
        let innermost = self.objects[..self.depth].last();
        innermost.and_then(|&object| scene.objects[object as usize].material.index()).unwrap_or(1.0)
    }

    /// What a ray along `direction` is inside of once it has gone through what it hits: straight on, or diffusely.
    pub(crate) fn through(&self, scene: &Scene, hit: &Hit, direction: Vec3) -> Self {
        let is_front = hit.geometric_normal.dot(direction) < 0.0;
        let mut beyond = *self;
        if let Some((placed, object)) = scene.placed_hit(hit) {
            let volumes = placed.volumes_of(object);
            beyond.fogs = if is_front { self.fogs | volumes } else { self.fogs & !volumes };
        } else if scene.material(hit).index().is_none() {
            // No more than a surface.
        } else if is_front {
            beyond.enter(hit.object);
        } else {
            beyond.leave(hit.object);
        }
        beyond
    }

    /// The same, once it has gone through a boundary of glass.
    pub(crate) fn beyond(&self, scene: &Scene, hit: &Hit, direction: Vec3) -> Self {
        let mut beyond = self.through(scene, hit, direction);
        if let Some((placed, object)) = scene.placed_hit(hit)
            && placed.objects()[object as usize].is_closed
        {
            beyond.glass = hit.geometric_normal.dot(direction) < 0.0;
        }
        beyond
    }

    /// Index on the side that a ray along `direction` comes from over that on the other, at what it hits; `beyond` is what it is inside of
    /// there. Placed glass has an index over that of what its front faces, wherever it is.
    pub(crate) fn eta(&self, scene: &Scene, hit: &Hit, direction: Vec3, beyond: &Self) -> f32 {
        if scene.placed_hit(hit).is_none() {
            return self.index(scene) / beyond.index(scene);
        }
        let index = scene.material(hit).index().unwrap_or(1.0);
        if hit.geometric_normal.dot(direction) < 0.0 { 1.0 / index } else { index }
    }
}

/// A ray at a dielectric boundary.
#[derive(Clone, Copy, Debug)]
pub struct Boundary {
    /// Shading normal, turned against the incoming direction.
    pub normal: Vec3,
    /// Share of the flux that is reflected, 0..=1.
    pub reflectance: f32,
    /// Index on the incoming side / index on the far side.
    pub eta: f32,
    /// Direction of the reflected ray.
    pub reflected: Vec3,
    /// Direction of the refracted ray; None = total internal reflection.
    pub refracted: Option<Vec3>,
    /// What the ray is inside of once it has gone through.
    pub beyond: Interior,
}

/// Fresnel reflectance of unpolarised light at a smooth dielectric.
pub fn fresnel(cos_i: f32, cos_t: f32, eta: f32) -> f32 {
    let s = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
    let p = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
    0.5 * (s * s + p * p)
}

/// At a smooth dielectric, the share of unpolarised light that is reflected, and where the rest goes; None = total internal reflection.
///
/// - `normal`: unit, against `direction`; `eta`: index on the incoming side / index on the far side.
pub(crate) fn refract(direction: Vec3, normal: Vec3, eta: f32) -> (f32, Option<Vec3>) {
    let cos_i = (-direction.dot(normal)).clamp(0.0, 1.0);
    let cos2_t = 1.0 - eta * eta * (1.0 - cos_i * cos_i);
    if cos2_t <= 0.0 {
        return (1.0, None);
    }
    let cos_t = cos2_t.sqrt();
    let refracted = (eta * direction + (eta * cos_i - cos_t) * normal).normalize();
    (fresnel(cos_i, cos_t, eta), Some(refracted))
}

/// Mirror direction.
pub fn reflect(direction: Vec3, normal: Vec3) -> Vec3 {
    (direction - 2.0 * direction.dot(normal) * normal).normalize()
}

/// The shading normal turned against `direction`; the geometric one where smoothing would turn the surface's side.
pub fn facing_normal(hit: &Hit, direction: Vec3) -> Vec3 {
    let against = if hit.geometric_normal.dot(direction) > 0.0 { -1.0 } else { 1.0 };
    let normal = against * hit.normal;
    if normal.dot(direction) < 0.0 { normal } else { against * hit.geometric_normal }
}

/// The hit's curvature as seen with `normal`: convex becomes concave on the other side. (The axis normal x tangent
/// turns round as well, so the off-diagonal entry keeps its sign.)
pub fn curvature_towards(hit: &Hit, normal: Vec3) -> Curvature {
    let curvature = hit.curvature;
    if hit.normal.dot(normal) >= 0.0 {
        return curvature;
    }
    Curvature { along: -curvature.along, across: -curvature.across, ..curvature }
}

impl Boundary {
    /// Whether the index is the same on both sides: light goes on as if nothing were there but another medium.
    pub fn is_matched(&self) -> bool {
        self.eta == 1.0
    }

    /// What happens to a ray along `direction` that is inside of `interior` and hits a dielectric.
    pub fn new(scene: &Scene, hit: &Hit, direction: Vec3, interior: &Interior) -> Self {
        let normal = facing_normal(hit, direction);
        let beyond = interior.beyond(scene, hit, direction);
        let eta = interior.eta(scene, hit, direction, &beyond);
        let geometric =
            hit.geometric_normal * if hit.geometric_normal.dot(direction) > 0.0 { -1.0 } else { 1.0 };
        // A shading normal may send the ray to the wrong side of the true surface: mirror it back there.
        let on_side = |d: Vec3, side: f32| {
            let wrong = side * d.dot(geometric);
            if wrong < 0.0 { reflect(d, geometric) } else { d }
        };
        let reflected = on_side(reflect(direction, normal), 1.0);
        let (reflectance, refracted) = refract(direction, normal, eta);
        let refracted = refracted.map(|direction| on_side(direction, -1.0));
        Self { normal, reflectance, eta, reflected, refracted, beyond }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fresnel_matches_the_textbook_values_of_glass() {
        // Normal incidence: ((n-1)/(n+1))² = 0.04 for n = 1.5.
        assert!((fresnel(1.0, 1.0, 1.0 / 1.5) - 0.04).abs() < 1e-6);
        // Grazing incidence reflects everything.
        assert!((fresnel(0.0, 0.745_356, 1.0 / 1.5) - 1.0).abs() < 1e-6);
        // 45° into n = 1.5: R_s = 0.09201, R_p = R_s² = 0.00847 (a property of 45°), mean 0.05024.
        let cos_i = std::f32::consts::FRAC_1_SQRT_2;
        let cos_t = (1.0 - 0.5 / 2.25f32).sqrt();
        assert!((fresnel(cos_i, cos_t, 1.0 / 1.5) - 0.050_24).abs() < 1e-5);
    }

    #[test]
    fn leaving_an_object_that_was_never_entered_changes_nothing() {
        let mut interior = Interior::default();
        interior.enter(3);
        interior.leave(5);
        assert_eq!(interior.objects[..interior.depth], [3]);
        interior.enter(7);
        interior.leave(3);
        assert_eq!(interior.objects[..interior.depth], [7]);
    }
}
