//! Light paths: from a light through media and surfaces until they are absorbed or escape.

use crate::edges::{Edge, find_edges};
use crate::geometry::Hit;
use crate::light::{EmittedPhoton, cosine_direction};
use crate::optics::{Boundary, Interior, curvature_towards, facing_normal, reflect};
use crate::random::{Emission, PathSampler};
use crate::scene::{Material, Scene};
use crate::surface::SurfacePhoton;
use covbeam::{Beam, LightField, Medium};
use glam::Vec3;
use std::time::{Duration, Instant};

/// A beam ends where so little is left of it that single precision loses it beside the rest: e^-17 = 4e-8.
const OPAQUE_DEPTH: f32 = 17.0;

/// What a light field leaves along one straight piece of its path.
#[derive(Clone, Copy, Debug)]
pub struct Deposit {
    /// Start of the piece.
    pub origin: Vec3,
    /// Its length.
    pub length: f32,
    /// The light field at `origin`.
    pub field: LightField,
    /// Flux at `origin` (mean of the channels).
    pub power: f32,
    /// Extinction (mean of the channels).
    pub extinction: f32,
}

/// A contribution of a path vertex to one pixel.
#[derive(Clone, Copy, Debug)]
pub struct Splat {
    /// Row-major index.
    pub pixel: u32,
    /// Radiance.
    pub radiance: Vec3,
}

/// Where the power of some light paths went, per channel \[W\]; `emitted` = the sum of the others.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Energy {
    /// Left the lights.
    pub emitted: [f64; 3],
    /// Absorbed by media.
    pub medium: [f64; 3],
    /// Absorbed by surfaces.
    pub surfaces: [f64; 3],
    /// Left the scene.
    pub escaped: [f64; 3],
    /// Taken minus given back by random decisions: zero on average.
    pub roulette: [f64; 3],
}

fn add(sum: &mut [f64; 3], power: Vec3) {
    for (sum, power) in sum.iter_mut().zip(power.to_array()) {
        *sum += f64::from(power);
    }
}

/// What light paths leave behind.
#[derive(Clone, Debug, Default)]
pub struct PhotonRecord {
    /// Beams, with the index of their medium.
    pub beams: Vec<(u32, Beam)>,
    /// Photons on diffuse surfaces, without those that came straight from a light.
    pub surface: Vec<SurfacePhoton>,
    /// Pieces of light fields for the covariance grid.
    pub deposits: Vec<Deposit>,
    /// Connections with the camera.
    pub splats: Vec<Splat>,
    /// Balance.
    pub energy: Energy,
    /// Time spent on light fields and probes.
    pub field_time: Duration,
}

impl PhotonRecord {
    /// Appends another record.
    pub fn append(&mut self, mut other: Self) {
        self.beams.append(&mut other.beams);
        self.surface.append(&mut other.surface);
        self.deposits.append(&mut other.deposits);
        self.splats.append(&mut other.splats);
        let pairs = [
            (&mut self.energy.emitted, other.energy.emitted),
            (&mut self.energy.medium, other.energy.medium),
            (&mut self.energy.surfaces, other.energy.surfaces),
            (&mut self.energy.escaped, other.energy.escaped),
            (&mut self.energy.roulette, other.energy.roulette),
        ];
        for (sum, add) in pairs {
            for (sum, add) in sum.iter_mut().zip(add) {
                *sum += add;
            }
        }
        self.field_time += other.field_time;
    }
}

/// What to record of a path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Record {
    /// Beams and surface photons.
    Beams,
    /// The same, and the light field's deposits.
    BeamsAndField,
    /// Deposits only: the path's beams were recorded before.
    Field,
    /// Connections with the camera.
    Connections,
}

/// Traces light paths of a scene.
pub struct PhotonTracer<'a> {
    scene: &'a Scene,
    /// Cumulative share of the flux and what each light is inside of.
    lights: Vec<(f32, Interior)>,
    camera: Interior,
    seed: u32,
    emission: Emission,
}

/// The moving photon.
struct Photon {
    origin: Vec3,
    direction: Vec3,
    power: Vec3,
    interior: Interior,
    /// Normal of the surface that it left, towards the side it is on; zero in the open.
    normal: Vec3,
    direct: bool,
    specular: bool,
    field: Option<LightField>,
}

impl<'a> PhotonTracer<'a> {
    /// Prepares `scene`.
    pub fn new(scene: &'a Scene, seed: u32, emission: Emission) -> Self {
        let flux = scene.lights.iter().map(|light| f64::from(light.flux().element_sum()));
        let total: f64 = flux.clone().sum();
        let mut cumulative = 0.0;
        let lights = scene
            .lights
            .iter()
            .zip(flux)
            .map(|(light, flux)| {
                cumulative += flux / total;
                (cumulative as f32, Interior::at(scene, light.position()))
            })
            .collect();
        let camera = Interior::at(scene, scene.camera.position);
        Self { scene, lights, camera, seed, emission }
    }

    /// Traces light path `index` of `sequence`; its power is divided by `paths`.
    pub fn trace(&self, sequence: u32, index: u32, paths: u32, record: Record, out: &mut PhotonRecord) {
        let mut sampler = PathSampler::new(self.emission, self.seed, sequence, index);
        let (light, share) = self.choose_light(&mut sampler);
        let emitted = self.scene.lights[light].emit(&mut sampler);
        let mut photon = Photon {
            origin: emitted.origin,
            direction: emitted.direction,
            power: emitted.power / (share * paths as f32),
            interior: self.lights[light].1,
            normal: emitted.normal,
            direct: true,
            specular: true,
            field: self.start_field(light, &emitted, record),
        };
        add(&mut out.energy.emitted, photon.power);
        if photon.power.max_element() > 0.0 {
            while self.step(&mut photon, &mut sampler, record, out) {}
        }
    }

    /// The light that a path starts from, with its probability.
    fn choose_light(&self, sampler: &mut PathSampler) -> (usize, f32) {
        if self.lights.len() == 1 {
            return (0, 1.0);
        }
        let u = sampler.uniform();
        let index =
            self.lights.partition_point(|&(cumulative, _)| cumulative <= u).min(self.lights.len() - 1);
        let before = if index == 0 { 0.0 } else { self.lights[index - 1].0 };
        (index, self.lights[index].0 - before)
    }

    fn start_field(&self, light: usize, emitted: &EmittedPhoton, record: Record) -> Option<LightField> {
        matches!(record, Record::BeamsAndField | Record::Field)
            .then(|| self.scene.lights[light].light_field(emitted))
    }

    /// One segment and the event at its end. False = the path has ended.
    fn step(
        &self,
        photon: &mut Photon,
        sampler: &mut PathSampler,
        record: Record,
        out: &mut PhotonRecord,
    ) -> bool {
        let scene = self.scene;
        let hit = scene.intersect(photon.origin, photon.direction, f32::INFINITY);
        let reach = hit.map_or(f32::INFINITY, |hit| hit.distance);
        let medium_id = photon.interior.medium(scene);
        let medium = medium_id.map(|id| &scene.media[id as usize]);
        if let Some((id, medium)) = medium_id.zip(medium)
            && matches!(record, Record::Beams | Record::BeamsAndField)
        {
            out.beams.extend(beam_of(photon, hit.as_ref(), medium).map(|beam| (id, beam)));
        }
        if let Some(medium) = medium
            && record == Record::Connections
        {
            self.connect_segment(photon, reach, medium, sampler, out);
        }
        let edges = photon.field.map(|field| {
            let start = Instant::now();
            let edges = find_edges(scene, photon.origin, photon.direction, hit.as_ref());
            if let Some(medium) = medium {
                deposit(photon, field, &edges, reach, medium, out);
            }
            out.field_time += start.elapsed();
            edges
        });
        let flight = medium.map_or(f32::INFINITY, |medium| free_flight(photon.power, medium, sampler));
        let distance = flight.min(reach);
        if let (Some(field), Some(edges)) = (&mut photon.field, edges) {
            let start = Instant::now();
            travel(field, &edges, distance);
            out.field_time += start.elapsed();
        }
        match (medium, hit) {
            (Some(medium), _) if flight < reach => self.scatter(photon, flight, medium, sampler, out),
            (medium, Some(hit)) => {
                if let Some(medium) = medium {
                    let before = photon.power;
                    photon.power *= passage_weight(photon.power, medium, reach);
                    add(&mut out.energy.roulette, before - photon.power);
                }
                self.interact(photon, &hit, sampler, record, out)
            }
            (_, None) => {
                add(&mut out.energy.escaped, photon.power);
                false
            }
        }
    }

    fn scatter(
        &self,
        photon: &mut Photon,
        distance: f32,
        medium: &Medium,
        sampler: &mut PathSampler,
        out: &mut PhotonRecord,
    ) -> bool {
        let before = photon.power;
        let collided = before * collision_weight(before, medium, distance);
        let scattered =
            collided * (medium.scattering / medium.extinction().max(Vec3::splat(f32::MIN_POSITIVE)));
        add(&mut out.energy.roulette, before - collided);
        add(&mut out.energy.medium, collided - scattered);
        photon.origin += distance * photon.direction;
        let [u, v] = sampler.uniform_pair();
        let Some(u) = roulette(photon, before, scattered, u, out) else { return false };
        let direction = medium.phase.sample(photon.direction, [u, v]);
        if let Some(field) = &mut photon.field {
            field.scatter(direction, medium.phase.angular_variance());
        }
        photon.direction = direction;
        photon.normal = Vec3::ZERO;
        photon.direct = false;
        photon.specular = false;
        true
    }

    fn interact(
        &self,
        photon: &mut Photon,
        hit: &Hit,
        sampler: &mut PathSampler,
        record: Record,
        out: &mut PhotonRecord,
    ) -> bool {
        match self.scene.objects[hit.object as usize].material {
            Material::Black => {
                add(&mut out.energy.surfaces, photon.power);
                return false;
            }
            Material::Lambert { albedo } => {
                let normal = facing_normal(hit, photon.direction);
                if matches!(record, Record::Beams | Record::BeamsAndField) && !photon.direct {
                    out.surface.push(SurfacePhoton {
                        position: hit.position,
                        normal,
                        power: photon.power,
                        caustic: photon.specular,
                    });
                }
                let before = photon.power;
                let reflected = before * albedo;
                add(&mut out.energy.surfaces, before - reflected);
                if record == Record::Connections {
                    let factor = reflected * std::f32::consts::FRAC_1_PI;
                    self.connect(hit.leave(normal), out, |to_camera| factor * to_camera.dot(normal).max(0.0));
                }
                let [u, v] = sampler.uniform_pair();
                let Some(u) = roulette(photon, before, reflected, u, out) else { return false };
                let direction = cosine_direction(normal, [u, v]);
                if let Some(field) = &mut photon.field {
                    field.diffuse(normal, direction);
                }
                photon.direction = direction;
                photon.normal = normal;
                photon.specular = false;
            }
            Material::Mirror { reflectance } => {
                let normal = facing_normal(hit, photon.direction);
                let before = photon.power;
                let reflected = before * reflectance;
                add(&mut out.energy.surfaces, before - reflected);
                let u = sampler.uniform();
                if roulette(photon, before, reflected, u, out).is_none() {
                    return false;
                }
                if let Some(field) = &mut photon.field {
                    field.reflect(normal, &curvature_towards(hit, normal));
                }
                photon.direction = reflect(photon.direction, normal);
                photon.normal = normal;
            }
            Material::Dielectric { .. } => {
                let boundary = Boundary::new(self.scene, hit, photon.direction, &photon.interior);
                let curvature = curvature_towards(hit, boundary.normal);
                let through =
                    (sampler.uniform() >= boundary.reflectance).then_some(boundary.refracted).flatten();
                photon.normal = boundary.normal;
                photon.direction = match through {
                    Some(refracted) => {
                        if let Some(field) = &mut photon.field {
                            field.refract(boundary.normal, &curvature, boundary.eta);
                        }
                        photon.interior = boundary.beyond;
                        photon.normal = -boundary.normal;
                        refracted
                    }
                    None => {
                        if let Some(field) = &mut photon.field {
                            field.reflect(boundary.normal, &curvature);
                        }
                        boundary.reflected
                    }
                };
            }
        }
        photon.direct = false;
        photon.origin = hit.leave(photon.direction);
        true
    }

    /// Connects one point of a segment with the pinhole.
    ///
    /// The point is drawn in proportion to 1/d² (equi-angular sampling, C. Kulla and M. Fajardo 2012), d its distance
    /// from the camera. Connecting the path's own vertices would be unbiased as well, but with infinite variance: a
    /// mean of them leaves out the light that scatters nearer to the camera than the nearest vertex.
    fn connect_segment(
        &self,
        photon: &Photon,
        reach: f32,
        medium: &Medium,
        sampler: &mut PathSampler,
        out: &mut PhotonRecord,
    ) {
        let u = sampler.uniform();
        let direction = photon.direction;
        let offset = self.scene.camera.position - photon.origin;
        let foot = offset.dot(direction);
        let distance = (offset - foot * direction).length();
        if !(distance > 0.0) {
            return;
        }
        let (from, to) = ((-foot / distance).atan(), ((reach - foot) / distance).atan());
        let s = (foot + distance * (from + u * (to - from)).tan()).clamp(0.0, reach);
        let density = distance / ((to - from) * (distance * distance + (s - foot) * (s - foot)));
        if !(s.is_finite() && density > 0.0) {
            return;
        }
        let scattered = photon.power * medium.transmittance(s) * medium.scattering / density;
        self.connect(photon.origin + s * direction, out, |to_camera| {
            scattered * medium.phase.evaluate(direction.dot(to_camera))
        });
    }

    /// Connects a vertex with the pinhole; `flux` gives the flux per steradian towards the camera.
    fn connect(&self, vertex: Vec3, out: &mut PhotonRecord, flux: impl FnOnce(Vec3) -> Vec3) {
        let camera = &self.scene.camera;
        let Some((x, y, importance)) = camera.project(vertex) else { return };
        let offset = camera.position - vertex;
        let distance2 = offset.length_squared();
        let distance = distance2.sqrt();
        if self.scene.occluded(vertex, camera.position) {
            return;
        }
        let medium = self.camera.medium(self.scene).map(|id| &self.scene.media[id as usize]);
        let transmittance = medium.map_or(Vec3::ONE, |medium| medium.transmittance(distance));
        let radiance = flux(offset / distance) * transmittance * (importance / distance2);
        out.splats.push(Splat { pixel: y as u32 * camera.width + x as u32, radiance });
    }
}

/// The beam along a photon's segment: to the next surface, or until nothing is left.
fn beam_of(photon: &Photon, hit: Option<&Hit>, medium: &Medium) -> Option<Beam> {
    let opaque = OPAQUE_DEPTH / medium.extinction().min_element();
    let reach = hit.map_or(f32::INFINITY, |hit| hit.distance);
    let length = reach.min(opaque);
    let end_normal = match hit {
        Some(hit) if reach <= opaque => {
            let against = if hit.geometric_normal.dot(photon.direction) > 0.0 { -1.0 } else { 1.0 };
            against * hit.geometric_normal
        }
        _ => Vec3::ZERO,
    };
    (length.is_finite() && medium.scattering.max_element() > 0.0).then_some(Beam {
        origin: photon.origin,
        direction: photon.direction,
        length,
        power: photon.power,
        start_normal: photon.normal,
        end_normal,
    })
}

/// Moves a light field on by `distance` past the edges on the way.
fn travel(field: &mut LightField, edges: &[Edge], distance: f32) {
    let mut at = 0.0;
    for edge in edges.iter().filter(|edge| edge.depth <= distance) {
        field.travel(edge.depth - at);
        field.occlude(edge.towards, edge.distance);
        at = edge.depth;
    }
    field.travel(distance - at);
}

/// Records what the field leaves along the whole segment, cut at the edges.
fn deposit(
    photon: &Photon,
    mut field: LightField,
    edges: &[Edge],
    reach: f32,
    medium: &Medium,
    out: &mut PhotonRecord,
) {
    let extinction = medium.extinction().element_sum() / 3.0;
    let power = photon.power.element_sum() / 3.0;
    let length = reach.min(OPAQUE_DEPTH / extinction);
    let mut at = 0.0;
    let cuts = edges.iter().map(|edge| (edge.depth, Some(edge))).chain([(length, None)]);
    for (depth, edge) in cuts {
        let depth = depth.min(length);
        out.deposits.push(Deposit {
            origin: photon.origin + at * photon.direction,
            length: depth - at,
            field,
            power: power * (-extinction * at).exp(),
            extinction,
        });
        field.travel(depth - at);
        if let Some(edge) = edge {
            field.occlude(edge.towards, edge.distance);
        }
        at = depth;
    }
}

/// Distance to the next collision: one channel, chosen by its power, decides for all three.
fn free_flight(power: Vec3, medium: &Medium, sampler: &mut PathSampler) -> f32 {
    let u = sampler.uniform();
    let extinction = medium.extinction();
    let grey = extinction.x == extinction.y && extinction.y == extinction.z;
    let (extinction, u) = if grey {
        (extinction.x, u)
    } else {
        let share = power / power.element_sum();
        let mut at = u;
        let mut channel = 0;
        while channel < 2 && at >= share[channel] {
            at -= share[channel];
            channel += 1;
        }
        (extinction[channel], (at / share[channel]).clamp(0.0, 1.0 - f32::EPSILON))
    };
    if extinction > 0.0 { -(-u).ln_1p() / extinction } else { f32::INFINITY }
}

/// σ_t T(s) / pdf(s) per channel.
fn collision_weight(power: Vec3, medium: &Medium, distance: f32) -> Vec3 {
    let density = medium.extinction() * medium.transmittance(distance);
    density / (density.dot(power) / power.element_sum())
}

/// T(s) / P(no collision before s) per channel.
fn passage_weight(power: Vec3, medium: &Medium, distance: f32) -> Vec3 {
    let transmittance = medium.transmittance(distance);
    transmittance / (transmittance.dot(power) / power.element_sum())
}

/// Keeps the photon with probability `after / before` and its power unchanged on average. Returns `u` made uniform
/// again, None if the path ends.
fn roulette(photon: &mut Photon, before: Vec3, after: Vec3, u: f32, out: &mut PhotonRecord) -> Option<f32> {
    let survival = (after.max_element() / before.max_element()).min(1.0);
    if !(u < survival) {
        add(&mut out.energy.roulette, after);
        return None;
    }
    photon.power = after / survival;
    add(&mut out.energy.roulette, after - photon.power);
    Some(u / survival)
}
