//! How lamps emit: in proportion to what light in a direction is worth.

use super::instant::Poll;
use crate::color::mean;
use crate::light::cosine_direction;
use crate::paths::guidance::{LampEmission, of_diffuse, of_ray};
use crate::random::{Emission, PathSampler, Random, spread};
use crate::scene::geometry::MOST_BOUNDS;
use crate::scene::media;
use crate::scene::optics::{Boundary, Interior, facing_normal, reflect};
use crate::scene::{Light, Material, Scene};
use crate::surface::encounter::{Encounter, Lobe, Met};
use crate::surface::origin::Origin;
use covbeam::{EmissionGuide, Importance, Knot, Medium};
use covbeam_geometry::hit::Hit;
use glam::Vec3;
use rayon::prelude::*;
use smallvec::{SmallVec, smallvec};

/// Cells across the square in which a lamp's emission is drawn: as many as all lamps together may have, and as one may.
const CELLS: f32 = 2048.0;
const MOST_ACROSS: f32 = 24.0;

/// Rays through each cell across and down.
const RAYS_ACROSS: u32 = 2;

/// Directions that a ray's light is looked at in where a surface scatters it. Light on the outside of a wall shares the voxels of what is lit
/// within. Error after 8 passes by voxels alone, by rays alone and by the mean of both: in a hall 1, .55 and .67; under leaves 1, 2.9 and 1.0; of
/// cards 1, 2.5 and .96; among posts 1, 1.04 and .90.
const BOUNCES: usize = 4;

/// Mirrors and glass in a row that a ray follows.
const LONGEST: u32 = 16;

/// Of what glass reflects and what goes through both are followed if either has more than this share of the ray's power.
const LEAST_SHARE: f32 = 0.01;

/// Share of the light paths that go where their power goes, whatever that is worth: no path has more than five times the power that all
/// would have if they shared it evenly.
const EVEN: f32 = 0.2;

/// Shares of a cell and of those beside it in its worth: its rays may have missed a hole that theirs found.
const BLUR: [(isize, isize, f32); 5] = [(0, 0, 0.6), (-1, 0, 0.1), (1, 0, 0.1), (0, -1, 0.1), (0, 1, 0.1)];

/// Purpose of random numbers, and sequence of emission.
const KEY: u32 = 0x1a3b;

/// How each lamp emits; None if no light is worth anything.
pub(super) fn emission(
    scene: &Scene,
    fogs: &[Medium],
    importance: &Importance,
    cancelled: Poll,
) -> Option<LampEmission> {
    let across = (CELLS / scene.lights.len() as f32).sqrt().clamp(1.0, MOST_ACROSS) as usize;
    let cells = across * across;
    let worth: Vec<f32> = (0..scene.lights.len() * cells)
        .into_par_iter()
        .map_init(Vec::new, |knots, number| {
            if cancelled() {
                return 0.0;
            }
            let lamp = Lamp::new(scene, fogs, importance, number / cells);
            lamp.of_cell(number % cells, across, number as u32, knots)
        })
        .collect();
    let of_lamps: Vec<f32> =
        worth.chunks(cells).map(|worth| worth.iter().sum::<f32>() / cells as f32).collect();
    let total: f32 = of_lamps.iter().sum();
    if !(total > 0.0 && total.is_finite()) {
        return None;
    }
    let flux: f32 = scene.lights.iter().map(|light| mean(light.flux())).sum();
    let mut sum = 0.0;
    let shares = scene.lights.iter().zip(&of_lamps).map(|(light, worth)| {
        sum += EVEN * mean(light.flux()) / flux + (1.0 - EVEN) * worth / total;
        sum
    });
    let mut cumulative: Vec<f32> = shares.collect();
    cumulative.iter_mut().for_each(|end| *end /= sum);
    let size = EmissionGuide::size(across);
    let mut guides = vec![0.0; size * scene.lights.len()];
    for (guide, worth) in guides.chunks_mut(size).zip(worth.chunks(cells)) {
        EmissionGuide::fill(across, &blurred(worth, across), EVEN, guide).expect("finite weights");
    }
    Some(LampEmission { total, cumulative, across, guides })
}

fn blurred(worth: &[f32], across: usize) -> Vec<f32> {
    let at = |row: usize, column: usize, (dr, dc, share): (isize, isize, f32)| {
        let row = row.saturating_add_signed(dr).min(across - 1);
        // The second number is an angle.
        let column = (column as isize + dc).rem_euclid(across as isize) as usize;
        share * worth[row * across + column]
    };
    let cell = |cell: usize| BLUR.iter().map(|&step| at(cell / across, cell % across, step)).sum();
    (0..worth.len()).map(cell).collect()
}

/// A lamp and what is around it.
struct Lamp<'a> {
    scene: &'a Scene,
    fogs: &'a [Medium<'a>],
    importance: &'a Importance<'a>,
    light: &'a Light,
    number: usize,
    origin: Origin,
}

impl<'a> Lamp<'a> {
    fn new(scene: &'a Scene, fogs: &'a [Medium<'a>], importance: &'a Importance<'a>, lamp: usize) -> Self {
        let light = &scene.lights[lamp];
        Self { scene, fogs, importance, light, number: lamp, origin: Origin::of_light(scene, light) }
    }

    /// Mean over a cell of what the lamp's light would be worth if all of it left like that.
    fn of_cell(&self, cell: usize, across: usize, number: u32, knots: &mut Vec<Knot>) -> f32 {
        let rays = RAYS_ACROSS * RAYS_ACROSS;
        let mut sum = 0.0;
        for ray in 0..rays {
            let mut random = Random::new([0, number, ray, KEY]);
            let mut place = |cell: usize, ray: u32| {
                (cell as f32 + (ray as f32 + random.uniform()) / RAYS_ACROSS as f32) / across as f32
            };
            let place = [place(cell / across, ray / RAYS_ACROSS), place(cell % across, ray % RAYS_ACROSS)];
            sum += self.of_place(place, number * rays + ray, &mut random, knots);
        }
        sum / rays as f32
    }

    /// Of the light of one direction, up to where it is scattered; as a straight beam it is worth nothing where
    /// shadow rays look after that.
    fn of_place(&self, place: [f32; 2], index: u32, random: &mut Random, knots: &mut Vec<Knot>) -> f32 {
        let Some(start) = self.emit(place, index) else { return 0.0 };
        let all = start.power;
        let mut waiting: SmallVec<[Ray; 8]> = smallvec![start];
        let mut worth = 0.0;
        while let Some(mut ray) = waiting.pop() {
            let hit = self.scene.intersect(ray.origin, ray.direction, f32::INFINITY);
            let reach = hit.map_or(f32::INFINITY, |hit| hit.distance);
            if let Some(id) = ray.interior.medium(self.scene) {
                worth += self.fly(&mut ray, id, reach, knots);
            }
            let Some(hit) = hit.filter(|hit| hit.distance < ray.until) else { continue };
            if hit.distance >= ray.dark {
                worth += self.of_surface(&ray, &hit, random);
            }
            waiting.extend(self.ways(ray, &hit, all, random).into_iter().flatten());
        }
        worth
    }

    /// A ray that starts at a place of the lamp's emission.
    fn emit(&self, place: [f32; 2], index: u32) -> Option<Ray> {
        let mut sampler = PathSampler::new(Emission::Independent, 0, KEY, index);
        let emitted = self.light.emit_at(place, &mut sampler);
        let (origin, interior) = self.origin.of_photon(self.scene, self.light, &emitted)?;
        Some(Ray {
            origin,
            direction: emitted.direction,
            interior,
            power: mean(emitted.power),
            is_straight: self.light.is_straight(),
            dark: emitted.dark,
            until: emitted.until,
            met: 0,
            bounds: 0,
            bounces: 0,
        })
    }

    /// Crosses fog up to a surface at a distance of `reach`: what the ray's light is worth there, and the ray has what is left of it.
    fn fly(&self, ray: &mut Ray, id: u32, reach: f32, knots: &mut Vec<Knot>) -> f32 {
        let fog = &self.fogs[id as usize];
        let end = reach.min(ray.until);
        let dark = ray.dark.min(end);
        let from = ray.origin + dark * ray.direction;
        let found = self.importance.of_segment(fog, from, ray.direction, end - dark);
        let lights = self.scene.links_of(self.number).lights_medium(self.scene.medium_of(id).heed.light_set);
        let scattered = if self.scene.allows(ray.bounces + 1) { found.scattered } else { 0.0 };
        let all = ray.power * (scattered + if ray.is_straight { 0.0 } else { found.beam });
        let worth = if ray.is_straight && !lights { 0.0 } else { all };
        let column = media::column(fog, ray.origin, ray.direction, reach, knots);
        ray.power *= fog.mean_transmittance(column.at(reach));
        worth
    }

    /// Of a ray's light that arrives on a surface, what is worth anything where it is scattered diffusely.
    fn of_surface(&self, ray: &Ray, hit: &Hit, random: &mut Random) -> f32 {
        let [diffuse, translucent] = match *self.scene.material_at(hit) {
            Material::Lambert { albedo } => [albedo, Vec3::ZERO],
            Material::Lobes(ref lobes) => [lobes.diffuse, lobes.translucent],
            _ => return 0.0,
        };
        let here = self.importance.at(hit.position);
        let seen = of_diffuse(diffuse + translucent, &here, ray.is_straight, false);
        if !self.scene.allows(ray.bounces + 1) || here.scattered == 0.0 {
            return ray.power * seen;
        }
        let normal = facing_normal(hit, ray.direction);
        let bounced = [(normal, diffuse), (-normal, translucent)].map(|(side, albedo)| {
            let shift = [random.uniform(), random.uniform()];
            // Most surfaces send nothing to one side: no rays are asked there.
            let is_any = albedo != Vec3::ZERO;
            if is_any { mean(albedo) * self.of_bounce(ray, hit, side, shift, here.scattered) } else { 0.0 }
        });
        ray.power * (seen + bounced.iter().sum::<f32>())
    }

    /// What a watt is worth that a surface scatters to one side: the mean of what its voxel says, which knows no sides of a wall, and of what a
    /// few rays say, which may miss what matters.
    fn of_bounce(&self, ray: &Ray, hit: &Hit, side: Vec3, shift: [f32; 2], here: f32) -> f32 {
        let of = |index| {
            let direction = cosine_direction(side, spread(shift, index));
            let start = (hit.leave(direction), direction);
            of_ray(self.scene, self.fogs, self.importance, start, &ray.interior, ray.bounces + 1)
        };
        0.5 * (here + (0..BOUNCES).map(of).sum::<f32>() / BOUNCES as f32)
    }

    /// Straight light that goes on past a surface which casts no shadow of it, or another one than it looks like; None: it does what light does.
    fn pass(&self, ray: &Ray, hit: &Hit) -> Option<Ray> {
        let material = self.scene.material_at(hit);
        let share = self.scene.object_of(hit).lets_by(&self.scene.links_of(self.number), &material);
        let interior = ray.interior.beyond(self.scene, hit, ray.direction);
        let by = Ray { power: ray.power * mean(share), interior, bounds: ray.bounds + 1, ..ray.clone() };
        (ray.is_straight && share != material.transparent()).then_some(by)
    }

    /// The ways on from a surface that keep directions apart.
    ///
    /// - `all`: the power that the ray's lamp sent.
    fn ways(&self, mut ray: Ray, hit: &Hit, all: f32, random: &mut Random) -> [Option<Ray>; 2] {
        if let Some(by) = self.pass(&ray, hit) {
            return [by.go_on(self.scene, hit, true), None];
        }
        let is_lit = hit.distance >= ray.dark;
        let mut goes_straight = false;
        let material = self.scene.material_at(hit);
        match *material {
            Material::Clear => ray.bounds += 1,
            _ => ray.met += 1,
        }
        match *material {
            Material::Clear => {
                goes_straight = true;
                ray.interior = ray.interior.through(self.scene, hit, ray.direction);
            }
            Material::Lobes(ref lobes) => {
                let mut pair = || [random.uniform(), random.uniform()];
                let (facet, xi) = (pair(), pair());
                let met = Encounter::new(
                    self.scene,
                    hit,
                    (Met::ByLight, ray.direction),
                    &ray.interior,
                    lobes,
                    facet,
                );
                let way = met.draw(Vec3::ONE, random.uniform(), xi);
                let Some(way) = way.filter(|way| !way.lobe.is_diffuse()) else { return [None, None] };
                goes_straight = way.lobe == Lobe::Transparent;
                ray.power *= mean(way.factor);
                (ray.direction, ray.interior) = (way.direction, way.interior);
            }
            Material::Mirror { reflectance } if is_lit => {
                ray.power *= mean(reflectance);
                ray.direction = reflect(ray.direction, facing_normal(hit, ray.direction));
            }
            Material::Black | Material::Lambert { .. } | Material::Mirror { .. } => return [None, None],
            Material::Dielectric { .. } => return self.split(ray, hit, all, random),
        }
        [ray.go_on(self.scene, hit, goes_straight), None]
    }

    /// The ways on from a boundary of glass: both, or one at random.
    fn split(&self, ray: Ray, hit: &Hit, all: f32, random: &mut Random) -> [Option<Ray>; 2] {
        let boundary = Boundary::new(self.scene, hit, ray.direction, &ray.interior);
        let [back, through] = [boundary.reflectance, 1.0 - boundary.reflectance];
        let reflected = Ray { direction: boundary.reflected, ..ray.clone() };
        let refracted =
            boundary.refracted.map(|direction| Ray { direction, interior: boundary.beyond, ..ray.clone() });
        // A mean of few rays would miss most of what is reflected.
        let ways = if back.min(through) * ray.power > LEAST_SHARE * all {
            let reflected = Ray { power: back * ray.power, ..reflected };
            [Some(reflected), refracted.map(|way| Ray { power: through * ray.power, ..way })]
        } else {
            [Some(refracted.filter(|_| random.uniform() < through).unwrap_or(reflected)), None]
        };
        ways.map(|way| way?.go_on(self.scene, hit, boundary.is_matched()))
    }
}

/// On its way from a lamp.
#[derive(Clone)]
struct Ray {
    origin: Vec3,
    direction: Vec3,
    interior: Interior,
    power: f32,
    is_straight: bool,
    /// How far from here its light begins, and ends.
    dark: f32,
    until: f32,
    /// Surfaces that are more than bounds of fog, and those that are not.
    met: u32,
    bounds: u32,
    /// How often its light has been reflected and refracted.
    bounces: u32,
}

impl Ray {
    /// From a surface, which may be as if nothing were there. None: there is no light of it yet, or it has met enough.
    fn go_on(mut self, scene: &Scene, hit: &Hit, is_straight: bool) -> Option<Self> {
        if !is_straight && hit.distance < self.dark {
            return None;
        }
        self.is_straight &= is_straight;
        self.bounces += u32::from(!is_straight);
        (self.dark, self.until) = match is_straight {
            true => ((self.dark - hit.distance).max(0.0), self.until - hit.distance),
            false => (0.0, f32::INFINITY),
        };
        self.origin = hit.leave(self.direction);
        let goes_on = self.met < LONGEST && self.bounds < MOST_BOUNDS && scene.allows(self.bounces);
        goes_on.then_some(self)
    }
}
