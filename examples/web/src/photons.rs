//! Photon paths: each straight piece in the fog is a beam, and with light fields a deposit in the grid.

use crate::ball::{Ball, Place, Ray};
use crate::scene::Scene;
use covbeam::{
    Beam, Column, CovarianceGrid, Curvature, EMISSION_DIMENSIONS, Edge, LightField, Segment, Vec3,
    path_number,
};
use libm::log1pf;

/// Events of a path at most. One in a million that scatter, by their albedo, would want more.
const EVENTS: u32 = 96;

/// Numbers of one path's decisions.
struct Chance {
    seed: u32,
    path: u32,
    next: u32,
}

impl Chance {
    fn number(&mut self) -> f32 {
        self.next += 1;
        path_number(self.seed, PHOTONS, self.path, self.next - 1)
    }
}

/// Sequences of numbers: of photons, of places in pixels, and from here on of shadow rays, one a pass.
const PHOTONS: u32 = 0;
const PIXELS: u32 = 1;
const MARCHES: u32 = 2;

/// Two numbers for the eye rays of a pass.
pub(crate) fn pixel_numbers(seed: u32, pass: u32) -> [f32; 2] {
    [0, 1].map(|dimension| path_number(seed, PIXELS, pass, dimension))
}

/// Number of a shadow ray; those of one eye ray are independent.
pub(crate) fn march_number(seed: u32, [pass, eye_ray]: [u32; 2], shadow_ray: u32) -> f32 {
    path_number(seed, MARCHES.wrapping_add(pass), eye_ray, EMISSION_DIMENSIONS + shadow_ray)
}

struct Path {
    ray: Ray,
    power: Vec3,
    /// None for plain beams, which need none.
    field: Option<LightField>,
    /// Not yet scattered by the fog.
    unscattered: bool,
    /// Nor at the ball.
    straight: bool,
}

/// Traces the photons of a pass, counted from 1. Their beams are appended, and if there is a grid, their light
/// fields deposited; the paths are the same with and without.
pub(crate) fn trace(
    scene: &Scene,
    pass: u32,
    count: u32,
    beams: &mut Vec<Beam>,
    mut grid: Option<CovarianceGrid>,
) {
    for photon in 0..count {
        let path = (pass - 1).wrapping_mul(count).wrapping_add(photon);
        let mut chance = Chance { seed: scene.seed, path, next: 0 };
        let (direction, power) = scene.emit([chance.number(), chance.number()], count);
        if power == Vec3::ZERO {
            continue;
        }
        let field = grid.is_some().then(|| scene.emitted_field(direction));
        let ray = Ray::in_fog(scene.lamp(), direction);
        let mut path = Path { ray, power, field, unscattered: true, straight: true };
        for _ in 0..EVENTS {
            if !follow(scene, &mut path, &mut chance, beams, grid.as_mut()) {
                break;
            }
        }
    }
}

/// Follows a path to its next event. False where it ends.
fn follow(
    scene: &Scene,
    path: &mut Path,
    chance: &mut Chance,
    beams: &mut Vec<Beam>,
    grid: Option<&mut CovarianceGrid>,
) -> bool {
    let distance = scene.ball.distance(&path.ray);
    if path.ray.place == Place::Inside {
        if let Some(field) = &mut path.field {
            field.travel(distance);
        }
        meet_ball(scene, path, distance, chance);
        return true;
    }
    // A beam runs to the next surface, or until nothing is left of it: not to the next collision.
    let length = distance.min(scene.fog.opaque_column());
    // With a grid, straight light comes from shadow rays.
    if grid.is_none() || !path.straight {
        beams.push(beam(path, distance, length));
    }
    let flight = -log1pf(-chance.number()) / scene.fog.mean_extinction();
    if let Some(grid) = grid {
        deposit(scene, path, length, flight.min(distance), grid);
    }
    if flight < distance {
        scatter(scene, path, flight, chance)
    } else {
        meet_ball(scene, path, distance, chance);
        true
    }
}

fn beam(path: &Path, distance: f32, length: f32) -> Beam {
    let hit = path.ray.origin + length * path.ray.direction;
    Beam {
        origin: path.ray.origin,
        direction: path.ray.direction,
        length,
        power: path.power,
        start_normal: path.ray.normal,
        end_normal: if length == distance { hit.normalize() } else { Vec3::ZERO },
    }
}

/// Leaves the light field of a beam in the grid, and moves it on by the photon's flight.
fn deposit(scene: &Scene, path: &mut Path, length: f32, flight: f32, grid: &mut CovarianceGrid) {
    let Some(field) = &mut path.field else { return };
    let edge = silhouette(&scene.ball, &path.ray, length);
    let segment = Segment {
        origin: path.ray.origin,
        length,
        power: path.power.element_sum() / 3.0,
        unscattered: path.unscattered,
        field: *field,
        edges: edge.as_slice(),
        column: Column::Uniform,
    };
    grid.deposit(&scene.fog, &segment);
    *field = segment.field_at(&scene.fog, flight);
}

/// The ball's silhouette, which cuts the light that passes it or falls onto it; farther away than a quarter of
/// its depth it does not matter.
fn silhouette(ball: &Ball, ray: &Ray, length: f32) -> Option<Edge> {
    let depth = -ray.origin.dot(ray.direction);
    let towards = ray.origin + depth * ray.direction;
    let distance = (towards.length() - ball.radius).abs();
    let is_beside = ray.place == Place::Fog && depth > 0.0 && distance < 0.25 * depth;
    (is_beside && towards != Vec3::ZERO).then_some(Edge { depth: depth.min(length), distance, towards })
}

fn scatter(scene: &Scene, path: &mut Path, flight: f32, chance: &mut Chance) -> bool {
    let (survival, power) = scene.survival(path.power);
    if chance.number() >= survival {
        return false;
    }
    let direction = scene.fog.phase.sample(path.ray.direction, [chance.number(), chance.number()]);
    path.ray = Ray::in_fog(path.ray.origin + flight * path.ray.direction, direction);
    path.power = power;
    (path.unscattered, path.straight) = (false, false);
    if let Some(field) = &mut path.field {
        field.scatter(direction, scene.fog.phase.angular_variance());
    }
    true
}

/// Reflects or refracts a path, by the Fresnel reflectance.
fn meet_ball(scene: &Scene, path: &mut Path, distance: f32, chance: &mut Chance) {
    let split = scene.ball.split(&path.ray, distance);
    path.straight = false;
    let reflects = chance.number() < split.reflectance;
    path.ray = if reflects { split.reflected } else { split.refracted };
    let bend = 1.0 / scene.ball.radius;
    let curvature = Curvature { along: bend, across: bend, ..Curvature::default() };
    if let Some(field) = &mut path.field {
        if reflects {
            field.reflect(path.ray.normal, &curvature);
        } else {
            field.refract(path.ray.normal, &curvature, split.eta);
        }
    }
}
