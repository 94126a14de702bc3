//! How large the things are that a picture is about: what light from infinitely far away is aimed at.

use super::lights::{Light, Lit};
use super::volumes::Volume;
use crate::camera::{Camera, Projection};
use crate::light::HEIGHTS;
use crate::object::Object;
use crate::scene::Ball;
use covbeam_geometry::MAX_COORDINATE;
use covbeam_geometry::shape::unite;
use glam::{DVec3, Vec3};

/// The world's fog is looked at as far as this optical depth from camera and lights.
const DEPTH: f64 = 4.0;

/// Lower and upper corner.
type Bounds = (DVec3, DVec3);

/// All geometry; None: there is none.
pub(super) fn bounds(placed: Option<(Vec3, Vec3)>, shapes: &[Object]) -> Option<Bounds> {
    doubled(shapes.iter().map(|object| object.shape.bounds()).chain(placed).reduce(unite))
}

fn doubled(bounds: Option<(Vec3, Vec3)>) -> Option<Bounds> {
    bounds.map(|(min, max)| (min.as_dvec3(), max.as_dvec3()))
}

/// The shapes that a volume fills; None: none.
fn filled(shapes: &[Object], volume: usize) -> Option<Bounds> {
    let filled = shapes.iter().filter(|object| object.inside.is_some_and(|id| id as usize == volume));
    doubled(filled.map(|object| object.shape.bounds()).reduce(unite))
}

/// Of volumes, of which one may be the world's, lights, geometry and camera. Numbers that are wrong give balls that mean nothing.
pub(super) fn lit(
    volumes: &[Volume],
    world: i32,
    lights: &[Light],
    (bounds, shapes): (Option<Bounds>, &[Object]),
    camera: &Camera,
) -> Lit {
    let world = usize::try_from(world).ok();
    let boxes = volumes.iter().enumerate().map(|(index, volume)| match Some(index) == world {
        true => raised(volume, world_box(lights, volume.extinction(), bounds, camera)),
        false => filled(shapes, index).unwrap_or_else(|| volume.bounds()),
    });
    let unite = |(a, b): (DVec3, DVec3), (c, d): (DVec3, DVec3)| (a.min(c), b.max(d));
    let place = camera.position.as_dvec3();
    let media = boxes.reduce(unite).unwrap_or((place - 1.0, place + 1.0));
    let all = bounds.map_or(media, |bounds| unite(media, bounds));
    Lit { media: ball(media), scene: ball(all) }
}

fn ball((min, max): (DVec3, DVec3)) -> Ball {
    let ball = Ball::around(min.as_vec3(), max.as_vec3());
    Ball { radius: ball.radius.max(1.0 / MAX_COORDINATE), ..ball }
}

/// A box of fog, and what of it thins above.
fn raised(volume: &Volume, (min, max): Bounds) -> Bounds {
    let up = f64::from(HEIGHTS) * volume.fields.scale_height * DVec3::from(volume.fields.up);
    (min.min(min + up), max.max(max + up))
}

/// Where the world's fog matters: what camera, lights and geometry fill.
fn world_box(lights: &[Light], extinction: f64, bounds: Option<Bounds>, camera: &Camera) -> (DVec3, DVec3) {
    // Parallel rays start all over a plane.
    let is_plane = camera.projection == Projection::Orthographic;
    let corners = is_plane.then(|| camera.corners().map(|corner| corner.as_dvec3()));
    let lights = lights.iter().flat_map(|light| {
        let corners = light.triangles.iter().flatten().map(|corner| DVec3::from(corner.map(f64::from)));
        let is_somewhere = !light.fields.is_mesh() && !light.fields.is_far();
        corners.chain(is_somewhere.then(|| DVec3::from(light.fields.position)))
    });
    let position = camera.position.as_dvec3();
    let starts = corners.into_iter().flatten();
    let (mut min, mut max) =
        starts.fold((position, position), |(min, max), place| (min.min(place), max.max(place)));
    let mut count = 1;
    for place in lights {
        (min, max, count) = (min.min(place), max.max(place), count + 1);
    }
    let size = (max - min).length().max(1e-6);
    if let Some((bottom, top)) = bounds {
        // Geometry farther away than twice the camera from the lights is background.
        let seen = if extinction > 0.0 { DEPTH / extinction } else { size };
        let reach = if count > 1 { seen.min(2.0 * size) } else { seen };
        let near = |corner: DVec3| corner.max(min - reach).min(max + reach);
        (min, max) = (min.min(near(bottom)), max.max(near(top)));
    }
    // With nothing around, the camera looks into fog as far as it sees.
    let diagonal = (max - min).length();
    let alone = if extinction > 0.0 { extinction.recip() } else { 1.0 };
    let margin = if diagonal > 1e-6 { 0.1 * diagonal } else { alone };
    let limit = DVec3::splat(f64::from(MAX_COORDINATE));
    ((min - margin).max(-limit), (max + margin).min(limit))
}
