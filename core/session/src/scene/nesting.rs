//! Nested dielectrics: which of those that overlap fills a place.
//!
//! By priority, as in OpenPBR and the renderers of the field; of equal priority what lies inside of another one, but for a hundredth of its size,
//! counts before that, and of two that only overlap the later one. (Schmidt and Budge 2002, *Simple nested dielectrics in ray traced images*.)

use crate::object::Object;
use covbeam_geometry::shape::Shape;
use glam::Vec3;

/// Places on a sphere that are looked at, along each of its angles.
const STEPS: usize = 8;

/// What lies inside is drawn in towards its middle by this part of its size: what stands on a floor together with its fog, and is lower than that by
/// a hair, is inside of it all the same.
const DRAWN_IN: f32 = 0.01;

/// Notes of each closed dielectric which others lie inside of it. Two as large as each other do not.
pub fn nest(objects: &mut [Object]) {
    let filled: Vec<usize> = (0..objects.len()).filter(|&i| objects[i].material.index().is_some()).collect();
    for &outer in &filled {
        let holds = |outer: usize, inner: usize| contains(&objects[outer].shape, &objects[inner].shape);
        let is_inner = |&&inner: &&usize| inner != outer && holds(outer, inner) && !holds(inner, outer);
        let inner: Vec<u32> = filled.iter().filter(is_inner).map(|&inner| inner as u32).collect();
        objects[outer].inner = inner;
    }
}

/// Of closed dielectrics that overlap the one that fills the place where all of them are: the same from whatever side it is seen.
///
/// - `members`: ascending by priority, then by number.
pub(crate) fn winner(objects: &[Object], members: &[u32]) -> Option<u32> {
    let priority = |&object: &u32| objects[object as usize].priority;
    let highest = priority(members.last()?);
    let first = members.partition_point(|object| priority(object) < highest);
    let holds = |outer: u32, inner: &u32| objects[outer as usize].inner.binary_search(inner).is_ok();
    let rivals = &members[first..];
    rivals.iter().rev().copied().find(|&object| !rivals.iter().any(|other| holds(object, other)))
}

/// Whether a closed shape holds all of another one, drawn in.
fn contains(outer: &Shape, inner: &Shape) -> bool {
    let ((min, max), (low, high)) = (outer.bounds(), inner.bounds());
    let middle = 0.5 * (low + high);
    let drawn = |place: Vec3, share: f32| middle + share * (place - middle);
    let [low, high] = [low, high].map(|corner| drawn(corner, 1.0 - DRAWN_IN));
    // The rounding of coordinates.
    let near = 4.0 * f32::EPSILON * min.abs().max(max.abs()).max_element();
    if !(low.cmpge(min - near).all() && high.cmple(max + near).all()) {
        return false;
    }
    match outer {
        Shape::Box { .. } => true,
        Shape::Rectangle { .. } => false,
        Shape::Sphere { center, radius } => match inner {
            Shape::Sphere { center: other, radius: small } => {
                (center.as_dvec3() - other.as_dvec3()).length() + f64::from((1.0 - DRAWN_IN) * *small)
                    <= f64::from(*radius + near)
            }
            inner => {
                let far = |place: Vec3| (drawn(place, 1.0 - DRAWN_IN) - *center).length() > *radius + near;
                !places_on(inner).into_iter().any(far)
            }
        },
        Shape::Mesh(_) => {
            let sticks_out = |place: Vec3| !outer.contains(drawn(place, 1.0 - DRAWN_IN));
            let reaches_in = |place: Vec3| inner.contains(drawn(place, 1.0 + DRAWN_IN));
            !places_on(inner).into_iter().any(sticks_out) && !places_on(outer).into_iter().any(reaches_in)
        }
    }
}

/// Places on a shape that tell whether another one holds it: corners, and what lies between them on a sphere.
fn places_on(shape: &Shape) -> Vec<Vec3> {
    match shape {
        Shape::Mesh(mesh) => mesh.placed_corners().into_iter().flatten().collect(),
        Shape::Sphere { center, radius } => {
            let place = |i: usize| {
                let (ring, step) = (i / (2 * STEPS), i % (2 * STEPS));
                let theta = std::f32::consts::PI * ring as f32 / STEPS as f32;
                let ((sine, cosine), phi) =
                    (libm::sincosf(theta), std::f32::consts::PI * step as f32 / STEPS as f32);
                *center + *radius * Vec3::new(sine * libm::cosf(phi), cosine, sine * libm::sinf(phi))
            };
            (0..2 * STEPS * (STEPS + 1)).map(place).collect()
        }
        shape => {
            let (min, max) = shape.bounds();
            let choose = |bit: usize, low: f32, high: f32| if bit & 1 == 0 { low } else { high };
            let corner = |i: usize| {
                Vec3::new(choose(i, min.x, max.x), choose(i >> 1, min.y, max.y), choose(i >> 2, min.z, max.z))
            };
            (0..8).map(corner).collect()
        }
    }
}
