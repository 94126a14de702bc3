//! Surfaces at one place: which of them decides what a ray does there, and which it crosses.
//!
//! People put fog on the floor and glass on glass: faces in one plane, which a ray meets at one distance but for rounding. All of them count
//! at once, so that neither their order in a file nor that of a hierarchy matters.

use crate::object::geometry::Shading;
use crate::scene::nesting::winner;
use crate::scene::{Material, Scene};
use covbeam_geometry::hit::Hit;
use covbeam_geometry::shape::{Shape, describe, line_through};
use glam::Vec3;
use smallvec::SmallVec;

/// Surfaces are at one place if they are no farther apart, along the normal of either, than so many of the larger of their
/// [`Hit::offset`]s, each four times what rounding can have moved it by. A ray that leaves one starts within half of that of it.
const APART: f64 = 2.0;

/// And along the ray no farther than so many times that: a ray along a surface meets others where these are.
const ALONG: f64 = 256.0;

/// Surfaces of which one is met.
pub(crate) type Faces = SmallVec<[Hit; 2]>;

/// How far from a hit, along the ray, a surface of no larger offset may be that is at its place \[m\].
fn window(hit: &Hit) -> f64 {
    ALONG * APART * f64::from(hit.offset)
}

/// Surfaces farther than this from a hit, along the ray, are not at its place \[m\].
pub(crate) fn reach(hit: &Hit) -> f64 {
    4.0 * window(hit)
}

impl Scene {
    /// Of the surfaces where a ray along `direction` meets `hit` the one that decides: one that is more than a bound or glass; else the
    /// dielectric that wins where all of them overlap; else `hit`.
    pub(crate) fn deciding(&self, hit: Hit, direction: Vec3, shading: Shading) -> Hit {
        if self.weight(&hit) == SOLID {
            return hit;
        }
        let others = self.faces_at(&hit, direction, shading);
        let mut decides = Hit { is_alone: others.is_empty(), ..hit };
        for other in others {
            if self.decides_before(&other, &decides) {
                decides = Hit { distance: hit.distance, ..other };
            }
        }
        decides
    }

    /// The surfaces that a ray along `direction` crosses together with `hit`, but for objects that it enters and leaves there.
    pub(crate) fn coincident(&self, hit: &Hit, direction: Vec3) -> Faces {
        if hit.is_alone { Faces::new() } else { self.faces_at(hit, direction, Shading::Flat) }
    }

    /// Whether of two surfaces at one place the first counts before the other.
    fn decides_before(&self, one: &Hit, other: &Hit) -> bool {
        let [first, second] = [one, other].map(|hit| self.weight(hit));
        if first != second {
            return first > second;
        }
        let [one, other] = [one.object, other.object];
        let is_shape = |object: u32| (object as usize) < self.objects.len();
        if !is_shape(one) || !is_shape(other) || self.objects[one as usize].material.index().is_none() {
            return one > other;
        }
        let mut members = [one, other];
        members.sort_by_key(|&object| (self.objects[object as usize].priority, object));
        winner(&self.objects, &members) == Some(one)
    }

    /// 2: it is more than a bound or glass; 1: glass.
    fn weight(&self, hit: &Hit) -> u32 {
        match self.material(hit) {
            Material::Clear => 0,
            Material::Dielectric { .. } => 1,
            Material::Black | Material::Lambert { .. } | Material::Mirror { .. } | Material::Lobes(_) => {
                SOLID
            }
        }
    }

    fn faces_at(&self, hit: &Hit, direction: Vec3, shading: Shading) -> Faces {
        let (place, along) = (hit.position.as_dvec3(), direction.as_dvec3());
        let mut faces = Faces::new();
        // Where the line through the place meets what was hit: at 0 but for rounding, which all surfaces there share.
        let roots = |shape: &Shape| line_through(shape, place, along).map_or([f64::NAN; 2], <[f64; 2]>::from);
        let own = self.objects.get(hit.object as usize).map_or([f64::NAN; 2], |object| roots(&object.shape));
        let nearer = |a: f64, b: f64| if b.abs() < a.abs() { b } else { a };
        let own = own.into_iter().filter(|root| root.is_finite()).reduce(nearer).unwrap_or(0.0);
        let window = window(hit);
        let is_there = |face: &Hit, gap: f64| {
            let bound = APART * f64::from(face.offset.max(hit.offset));
            let cosine = f64::from(face.geometric_normal.dot(direction).abs());
            gap.abs() * cosine <= bound && gap.abs() <= ALONG * bound
        };
        for (object, number) in self.objects.iter().zip(0u32..).filter(|(_, number)| *number != hit.object) {
            if let Shape::Mesh(mesh) = &object.shape {
                let start = place - window * along;
                if let Some(found) = mesh.intersect(start, direction, 2.0 * window) {
                    let face =
                        describe(&object.shape, number, start + found.distance * along, 0.0, Some(found));
                    faces.extend(is_there(&face, found.distance - window).then_some(face));
                }
                continue;
            }
            let [near, far] = roots(&object.shape);
            let count = faces.len();
            for root in [Some(near), Some(far).filter(|far| *far != near)].into_iter().flatten() {
                let gap = root - own;
                // False where there is none.
                if gap.abs() <= reach(hit) {
                    let face = describe(&object.shape, number, place + root * along, 0.0, None);
                    faces.extend(is_there(&face, gap).then_some(face));
                }
            }
            // A corner so thin that it is left where it is entered.
            if faces.len() == count + 2 {
                faces.truncate(count);
            }
        }
        if let Some(placed) = &self.placed {
            let start = place - window * along;
            let met = placed.surfaces().all_unless((start, along), 2.0 * window, shading, |_, _| false);
            for (distance, face) in met.into_iter().flatten() {
                let face = Hit { object: self.objects.len() as u32 + face.object, ..face };
                if face.object != hit.object && is_there(&face, distance - window) {
                    faces.push(face);
                }
            }
        }
        faces
    }
}

/// What is more than a bound or glass.
const SOLID: u32 = 2;
