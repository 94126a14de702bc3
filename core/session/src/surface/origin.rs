//! Origins of rays: lamps and cameras, which may lie exactly on surfaces, and what is around them.
//!
//! A lamp hangs in the ceiling, a camera stands on a face of fog: what they are inside of is decided by where they shine or look.

use crate::camera::{Camera, Projection};
use crate::light::EmittedPhoton;
use crate::object::placed::{Placed, cleared, hair};
use crate::scene::optics::Interior;
use crate::scene::{Light, Scene};
use glam::Vec3;

/// Surfaces through one place whose normals differ: those of a corner.
const MOST_FACES: usize = 3;

/// A place that rays start from.
#[derive(Clone, Copy)]
pub(crate) struct Origin {
    point: Vec3,
    /// Of the place, or of one beside it if it lies on a surface.
    interior: Interior,
    faces: Faces,
}

/// Normals of the surfaces that a place lies on, but for the rounding of its coordinates.
#[derive(Clone, Copy, Default)]
struct Faces {
    normals: [Vec3; MOST_FACES],
    count: usize,
}

impl Faces {
    /// Those through `point`.
    fn at(scene: &Scene, point: Vec3) -> Self {
        let mut faces = Self::default();
        // Along the edges of a cube around the place: at an edge of a shape each of its faces crosses some.
        let half = 4.0 * hair(point) as f32;
        let reach = 2.0 * f64::from(half);
        if scene.placed.is_none() && !scene.objects.iter().any(|object| object.shape.is_near(point, reach)) {
            return faces;
        }
        let sides = [-half, half];
        for (axis, along) in [Vec3::X, Vec3::Y, Vec3::Z].into_iter().enumerate() {
            for (one, other) in sides.into_iter().flat_map(|one| sides.map(|other| (one, other))) {
                let mut start = point;
                start[axis] -= half;
                start[(axis + 1) % 3] += one;
                start[(axis + 2) % 3] += other;
                if scene.meets(start.as_dvec3(), along.as_dvec3(), 2.0 * f64::from(half)) {
                    faces.add_all(scene, start, along, 2.0 * half);
                }
            }
        }
        faces
    }

    /// What is met first, and all that is there.
    fn add_all(&mut self, scene: &Scene, start: Vec3, along: Vec3, length: f32) {
        let Some(hit) = scene.intersect_flat(start, along, length) else { return };
        self.add(hit.geometric_normal);
        scene.coincident(&hit, along).iter().for_each(|face| self.add(face.geometric_normal));
    }

    fn add(&mut self, normal: Vec3) {
        let is_known = self.normals[..self.count].iter().any(|known| known.dot(normal).abs() > 0.999);
        if !is_known && self.count < MOST_FACES {
            self.normals[self.count] = normal;
            self.count += 1;
        }
    }

    fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// `point`, moved off the surfaces to the sides that `direction` points to.
    fn off(&self, point: Vec3, direction: Vec3) -> Vec3 {
        let away = |normal: &Vec3| {
            let side = normal.dot(direction);
            if side == 0.0 { Vec3::ZERO } else { 2.0 * side.signum() * *normal }
        };
        let moved: Vec3 = self.normals[..self.count].iter().map(away).sum();
        (point.as_dvec3() + hair(point) * moved.as_dvec3()).as_vec3()
    }
}

impl Scene {
    /// The first light that is a point exactly where all eye rays start, in a medium that scatters: there the picture would be infinitely bright.
    pub fn lamp_at_camera(&self) -> Option<usize> {
        let Camera { position, near, .. } = self.camera;
        let medium = Interior::at(self, position).medium(self).map(|medium| &self.media[medium as usize]);
        let scatters = medium.is_some_and(|medium| medium.medium.scattering != Vec3::ZERO);
        let is_there = |light: &Light| !light.has_size() && light.position() == position;
        let one_start =
            self.camera.lens.is_none() && self.camera.projection != Projection::Orthographic && near == 0.0;
        (scatters && one_start).then(|| self.lights.iter().position(is_there)).flatten()
    }
}

impl Origin {
    /// A place in a scene.
    pub(crate) fn new(scene: &Scene, point: Vec3) -> Self {
        Self { point, interior: Interior::at(scene, point), faces: Faces::at(scene, point) }
    }

    /// A light's place. Light from infinitely far away starts ahead of all that is placed.
    pub(crate) fn of_light(scene: &Scene, light: &Light) -> Self {
        let point = light.position();
        if light.is_far() {
            return Self { point, interior: Interior::of_shapes(scene, point), faces: Faces::default() };
        }
        Self::new(scene, point)
    }

    /// What the place is inside of; on a surface, what a place just beside it is.
    pub(crate) fn interior(&self) -> Interior {
        self.interior
    }

    /// Where a ray along `direction` starts that starts here, and what it is inside of.
    pub(crate) fn towards(&self, scene: &Scene, direction: Vec3) -> (Vec3, Interior) {
        if self.faces.is_empty() {
            return (self.point, self.interior);
        }
        let start = self.faces.off(self.point, direction);
        let mut interior = Interior::of_shapes(scene, start);
        if let Some(placed) = &scene.placed {
            (interior.fogs, interior.glass) = placed.insides_off(start);
        }
        (start, interior)
    }

    /// The same, for a ray that starts at another place nearby, as in a lens.
    pub(crate) fn beside(&self, scene: &Scene, point: Vec3, direction: Vec3) -> (Vec3, Interior) {
        if point == self.point {
            return self.towards(scene, direction);
        }
        let start = Faces::at(scene, point).off(point, direction);
        (start, self.interior.moved(scene, self.point, start))
    }

    /// Where a photon of a light starts whose place this is, and what it is inside of there; None: the light is not there.
    pub(crate) fn of_photon(
        &self,
        scene: &Scene,
        light: &Light,
        emitted: &EmittedPhoton,
    ) -> Option<(Vec3, Interior)> {
        let has_insides = scene.placed.as_ref().is_some_and(Placed::has_insides);
        let clear = |place: Vec3| if has_insides { cleared(place) } else { place };
        if let Light::Glow(fog) = light {
            let interior = Interior::at(scene, emitted.origin);
            return (interior.fog(scene) == Some(fog.medium())).then(|| (clear(emitted.origin), interior));
        }
        if light.is_far() {
            return Some((emitted.origin, self.interior));
        }
        if emitted.origin == self.point || !self.faces.is_empty() {
            return Some(self.beside(scene, emitted.origin, emitted.direction));
        }
        // What leaves no surface starts on the side of bounds that it is taken to be on.
        let origin = if emitted.normal == Vec3::ZERO { clear(emitted.origin) } else { emitted.origin };
        Some((origin, self.interior.moved(scene, self.point, origin)))
    }
}
