//! What a smooth surface does to a ray: reflection, refraction, Fresnel, and which media a ray is in.

use crate::scene::nesting::winner;
use crate::scene::{MediumId, Object, Scene};
use covbeam::Curvature;
use covbeam_geometry::hit::Hit;
use glam::Vec3;

/// What a ray is inside of: of a scene's shapes the set of closed dielectric ones; of placed objects the volumes of fog, and whether it is in
/// glass, in which fog goes on. A set, so that surfaces at one place may be crossed in any order, and more than once.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Interior {
    /// Ascending by priority, then by number; 0 behind the last of them.
    objects: [u32; Interior::DEEPEST],
    depth: usize,
    /// A set of volumes.
    pub(crate) fogs: u64,
    /// Whether it is inside of placed glass.
    pub(crate) glass: bool,
}

impl Interior {
    /// Shapes that may overlap at one place: of more, those of the lowest priority and number are left out.
    pub const DEEPEST: usize = 12;

    /// What a ray that starts at `point` is inside of; on a surface of a shape it is outside of that.
    pub fn at(scene: &Scene, point: Vec3) -> Self {
        let mut interior = Self::of_shapes(scene, point);
        if let Some(placed) = &scene.placed {
            (interior.fogs, interior.glass) = placed.insides_at(point);
        }
        interior
    }

    /// The same, of shapes alone.
    pub(crate) fn of_shapes(scene: &Scene, point: Vec3) -> Self {
        let mut interior = Self::default();
        scene.containing(point).for_each(|object| interior.enter(scene, object));
        interior
    }

    /// What a ray that starts at `to` is inside of, from what places at `from` are inside of: across all that is between the two, as
    /// where some of a lamp sticks out of fog. Costs nothing where nothing has an inside.
    pub fn moved(self, scene: &Scene, from: Vec3, to: Vec3) -> Self {
        let mut moved = Self::of_shapes(scene, to);
        if let Some(placed) = &scene.placed {
            (moved.fogs, moved.glass) = placed.insides_moved((self.fogs, self.glass), from, to);
        }
        moved
    }

    /// The shapes that hold the ray.
    fn shapes(&self) -> &[u32] {
        &self.objects[..self.depth]
    }

    /// The one of them that fills its place.
    fn shape<'a>(&self, scene: &'a Scene) -> Option<&'a Object> {
        let object = match self.shapes() {
            [] => return None,
            [object] => *object,
            shapes => winner(&scene.objects, shapes)?,
        };
        Some(&scene.objects[object as usize])
    }

    /// Steps into a shape; does nothing if the ray is inside of it.
    pub fn enter(&mut self, scene: &Scene, object: u32) {
        if self.shapes().contains(&object) {
            return;
        }
        let key = |object: u32| (scene.objects[object as usize].priority, object);
        let place = self.shapes().iter().filter(|other| key(**other) < key(object)).count();
        if self.depth < Self::DEEPEST {
            self.objects.copy_within(place..self.depth, place + 1);
            self.objects[place] = object;
            self.depth += 1;
        } else if place > 0 {
            self.objects.copy_within(1..place, 0);
            self.objects[place - 1] = object;
        }
    }

    /// Steps out of a shape; does nothing if the ray is not inside.
    pub fn leave(&mut self, object: u32) {
        if let Some(place) = self.shapes().iter().position(|&o| o == object) {
            self.objects.copy_within(place + 1..self.depth, place);
            self.depth -= 1;
            self.objects[self.depth] = 0;
        }
    }

    /// The region here, a medium and on which side of glass; None = nothing scatters or absorbs.
    pub fn medium(&self, scene: &Scene) -> Option<u32> {
        self.fog(scene).map(|medium| scene.region(medium, self.glass))
    }

    /// The medium here.
    pub(crate) fn fog(&self, scene: &Scene) -> Option<MediumId> {
        match (self.shape(scene), &scene.placed) {
            (Some(object), _) => object.inside,
            (None, Some(placed)) => placed.fogs().medium(self.fogs).or(scene.outside),
            (None, None) => scene.outside,
        }
    }

    /// The index of refraction here.
    pub fn index(&self, scene: &Scene) -> f32 {
        self.shape(scene).and_then(|object| object.material.index()).unwrap_or(1.0)
    }

    /// What a ray along `direction` is inside of once it has gone through what it hits, straight on or diffusely, and through all other
    /// surfaces at that place.
    pub(crate) fn through(&self, scene: &Scene, hit: &Hit, direction: Vec3) -> Self {
        self.across(scene, hit, direction, false)
    }

    /// The same, once it has gone through a boundary of glass.
    pub(crate) fn beyond(&self, scene: &Scene, hit: &Hit, direction: Vec3) -> Self {
        self.across(scene, hit, direction, true)
    }

    fn across(&self, scene: &Scene, hit: &Hit, direction: Vec3, glass: bool) -> Self {
        let mut beyond = *self;
        let others = scene.coincident(hit, direction);
        let is_front = |face: &Hit| face.geometric_normal.dot(direction) < 0.0;
        // What is entered counts: two things that touch may be of one volume, or both of glass.
        for front in [false, true] {
            if is_front(hit) == front {
                beyond.cross(scene, hit, front, glass);
            }
            let faces = others.iter().filter(|face| is_front(face) == front);
            faces.for_each(|face| beyond.cross(scene, face, front, true));
        }
        beyond
    }

    /// Crosses one surface.
    ///
    /// - `glass`: whether a ray that goes through placed glass is inside of it then.
    fn cross(&mut self, scene: &Scene, hit: &Hit, is_front: bool, glass: bool) {
        if let Some((placed, object)) = scene.placed_hit(hit) {
            let volumes = placed.volumes_of(object);
            self.fogs = if is_front { self.fogs | volumes } else { self.fogs & !volumes };
            if glass && placed.objects()[object as usize].is_closed && scene.material(hit).has_inside() {
                self.glass = is_front;
            }
        } else if scene.material(hit).index().is_none() {
            // No more than a surface.
        } else if is_front {
            self.enter(scene, hit.object);
        } else {
            self.leave(hit.object);
        }
    }

    /// Index on the side that a ray along `direction` comes from over that on the other, at what it hits; `beyond` is what it is inside of
    /// there. Placed glass has an index over that of what its front faces, wherever it is; of several surfaces at one place, the product.
    pub(crate) fn eta(&self, scene: &Scene, hit: &Hit, direction: Vec3, beyond: &Self) -> f32 {
        if scene.placed_hit(hit).is_none() {
            return self.index(scene) / beyond.index(scene);
        }
        let of_face = |face: &Hit| {
            let index = scene.material(face).index().unwrap_or(1.0);
            if face.geometric_normal.dot(direction) < 0.0 { 1.0 / index } else { index }
        };
        let others = scene.coincident(hit, direction);
        let placed = others.iter().filter(|other| scene.placed_hit(other).is_some());
        placed.map(of_face).fold(of_face(hit), |product, eta| product * eta)
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

/// A direction, mirrored back where a shading normal has sent it to the wrong side of the true surface.
///
/// - `geometric`: the triangle's normal, towards the right side, unit.
pub fn to_side(direction: Vec3, geometric: Vec3) -> Vec3 {
    if direction.dot(geometric) < 0.0 { reflect(direction, geometric) } else { direction }
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
        let reflected = to_side(reflect(direction, normal), geometric);
        let (reflectance, refracted) = refract(direction, normal, eta);
        let refracted = refracted.map(|direction| to_side(direction, -geometric));
        Self { normal, reflectance, eta, reflected, refracted, beyond }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Material;
    use crate::scene::made::{Made, camera, point, sphere};

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
    fn shapes_are_a_set_of_which_those_of_the_highest_priority_stay() {
        let camera = camera([0.0, 0.0, 9.0], [0.0; 3], 40.0, [8, 8]);
        let made = Made::new(camera).light(point([0.0, 0.0, 4.0], 1.0));
        let ball = |made: Made, _| made.object(sphere([0.0; 3], 1.0), Material::Black);
        let mut scene = (0..30).fold(made, ball).scene();
        scene.objects.iter_mut().zip(0..).for_each(|(object, number)| object.priority = number / 2);
        let mut interior = Interior::default();
        for object in [7, 3, 6, 7] {
            interior.enter(&scene, object);
        }
        interior.leave(5);
        assert_eq!(interior.shapes(), [3, 6, 7]);
        interior.leave(7);
        assert_eq!(interior, {
            let mut other = Interior::default();
            [6, 3].into_iter().for_each(|object| other.enter(&scene, object));
            other
        });
        // Of more than there is room for, those that win stay.
        (0..30).rev().for_each(|object| interior.enter(&scene, object));
        assert_eq!(interior.shapes(), (18..30).collect::<Vec<u32>>());
        interior.enter(&scene, 2);
        assert_eq!(interior.shapes(), (18..30).collect::<Vec<u32>>());
    }
}
