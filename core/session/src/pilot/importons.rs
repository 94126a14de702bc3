//! Paths from the camera: what they cross matters to the picture.

use super::instant::{Instant, Poll};
use super::look::Pixel;
use crate::eye::starts::EyeStart;
use crate::light::cosine_direction;
use crate::material::Lobes;
use crate::random::Random;
use crate::scene::geometry::divide;
use crate::scene::media;
use crate::scene::optics::{Boundary, Interior, facing_normal, reflect};
use crate::scene::{Material, Rays, Scene};
use crate::surface::encounter::{Encounter, Lobe, Met};
use covbeam::{GridLayout, ImportanceGrid, Knot, Medium};
use covbeam_geometry::hit::Hit;
use glam::Vec3;
use rayon::prelude::*;
use std::f32::consts::FRAC_1_PI;

/// Paths.
const PATHS: u32 = 16_384;

/// Paths that one task follows.
const CHUNK: usize = 256;

/// Most events of a path.
const LONGEST: u32 = 32;

/// Purpose of random numbers.
const KEY: u32 = 0x1339;

/// What a path leaves in the grid.
enum Deposit {
    EyeRay(Flight),
    Path(Flight),
    Surface { position: Vec3, weight: f32 },
}

impl Deposit {
    fn surface(&self) -> Option<(Vec3, f64)> {
        match *self {
            Self::Surface { position, weight } => Some((position, f64::from(weight))),
            _ => None,
        }
    }
}

/// A segment in a medium.
struct Flight {
    instant: usize,
    /// None: vacuum.
    medium: Option<u32>,
    origin: Vec3,
    direction: Vec3,
    length: f32,
    weight: f32,
    channel: usize,
}

/// Share of the paths that start from all pixels alike. The others start in proportion to the pixels' weights: without the first, dark pixels
/// that see no medium and no light leave none to those that do.
const EVEN: f64 = 0.5;

/// Voxels of their grid.
const CELLS: u32 = 24 * 24 * 24;

/// Share of what is seen on surfaces that the grid's box may leave out at each end of an axis: floors go on to the horizon.
const LEFT_OUT: f64 = 0.005;

/// What paths from all pixels cross and find.
pub(super) struct Found(Vec<Vec<Deposit>>);

/// Follows paths from all pixels.
pub(super) fn walk(instants: &[Instant], pixels: &[Pixel], cancelled: Poll) -> Found {
    let total: f64 = pixels.iter().map(|pixel| f64::from(pixel.weight)).sum();
    let mut starts = Vec::new();
    let mut sum = 0.0;
    for pixel in pixels {
        let weight = f64::from(pixel.weight);
        let share = (1.0 - EVEN) * weight / total + EVEN / pixels.len() as f64;
        let paths = f64::from(PATHS) * share;
        sum += paths;
        while starts.len() as f64 + 0.5 < sum {
            starts.push((pixel, (weight / paths) as f32));
        }
    }
    let chunks = starts
        .par_chunks(CHUNK)
        .enumerate()
        .map(|(chunk, starts)| {
            let mut out = Vec::new();
            for (index, &(&Pixel { instant, start, .. }, weight)) in starts.iter().enumerate() {
                if cancelled() {
                    break;
                }
                let random = Random::new([0, (chunk * CHUNK + index) as u32, 0, KEY]);
                let Instant { scene, fogs } = instants[instant];
                // In turns: what light is worth is a mean of what it is worth in the channels.
                let channel = index % 3;
                Walker { instant, scene, fogs, channel }.follow(start, weight, random, &mut out);
            }
            out
        })
        .collect();
    Found(chunks)
}

impl Found {
    /// That of a grid that holds a box and the surfaces that the camera sees. What light is worth on a floor around a ball of fog is not
    /// what it is worth at the ball's border.
    pub(super) fn layout(&self, mut min: Vec3, mut max: Vec3) -> GridLayout {
        let mut seen: Vec<(Vec3, f64)> = self.all().filter_map(Deposit::surface).collect();
        let total: f64 = seen.iter().map(|(_, weight)| weight).sum();
        for axis in 0..3 {
            seen.sort_by(|(a, _), (b, _)| a[axis].total_cmp(&b[axis]));
            let mut sum = 0.0;
            for &(position, weight) in &seen {
                let before = sum;
                sum += weight;
                if sum >= LEFT_OUT * total && before <= (1.0 - LEFT_OUT) * total {
                    min[axis] = min[axis].min(position[axis]);
                    max[axis] = max[axis].max(position[axis]);
                }
            }
        }
        GridLayout { min, max, cells: divide(max - min, CELLS) }
    }

    /// Adds what was found to a grid.
    pub(super) fn add_to(&self, grid: &mut ImportanceGrid, instants: &[Instant]) {
        let medium = |flight: &Flight| {
            flight.medium.map_or(Medium::default(), |id| {
                let fog = instants[flight.instant].fogs[id as usize];
                let [scattering, absorption] =
                    [fog.scattering, fog.absorption].map(|all| Vec3::splat(all[flight.channel]));
                Medium { scattering, absorption, ..fog }
            })
        };
        for deposit in self.all() {
            match deposit {
                Deposit::EyeRay(at) => {
                    grid.add_eye_ray(&medium(at), at.origin, at.direction, at.length, at.weight)
                }
                Deposit::Path(at) => {
                    grid.add_path(&medium(at), at.origin, at.direction, at.length, at.weight)
                }
                Deposit::Surface { position, weight } => grid.add_surface(*position, *weight),
            }
        }
    }

    fn all(&self) -> impl Iterator<Item = &Deposit> {
        self.0.iter().flatten()
    }
}

struct Walker<'a> {
    instant: usize,
    scene: &'a Scene,
    fogs: &'a [Medium<'a>],
    /// Whose light they carry.
    channel: usize,
}

#[derive(Clone)]
struct Importon {
    origin: Vec3,
    direction: Vec3,
    weight: f32,
    interior: Interior,
    /// Whether it has met mirrors and glass only.
    specular: bool,
    /// The kind of ray that it goes along.
    ray: Rays,
    depth: u32,
    /// How often light that comes along it the other way is scattered and reflected before the place that the camera sees.
    bounces: u32,
}

/// A path, what it has left in the grid, and memory.
struct Walk<'w> {
    random: Random,
    out: &'w mut Vec<Deposit>,
    /// Still to be followed.
    waiting: Vec<Importon>,
    knots: Vec<Knot>,
}

impl Walk<'_> {
    fn pair(&mut self) -> [f32; 2] {
        [self.random.uniform(), self.random.uniform()]
    }
}

impl Walker<'_> {
    fn follow(&self, start: EyeStart, weight: f32, random: Random, out: &mut Vec<Deposit>) {
        let EyeStart { origin, direction, interior, .. } = start;
        let first = Importon {
            origin,
            direction,
            weight,
            interior,
            specular: true,
            ray: Rays::CAMERA,
            depth: 0,
            bounces: 0,
        };
        let mut walk = Walk { random, out, waiting: vec![first], knots: Vec::new() };
        while let Some(mut importon) = walk.waiting.pop() {
            if importon.depth < LONGEST && self.scene.allows(importon.bounces) {
                importon.depth += 1;
                self.step(importon, &mut walk);
            }
        }
    }

    /// Follows a path to the next event, a collision or a surface, and what goes on from there waits.
    fn step(&self, mut importon: Importon, walk: &mut Walk) {
        let hit = self.scene.intersect(importon.origin, importon.direction, f32::INFINITY);
        let length = hit.map_or(f32::INFINITY, |hit| hit.distance);
        let Importon { origin, direction, weight, .. } = importon;
        let (medium, channel) = (importon.interior.medium(self.scene), self.channel);
        let flight = Flight { instant: self.instant, medium, origin, direction, length, weight, channel };
        walk.out.push(if importon.specular { Deposit::EyeRay(flight) } else { Deposit::Path(flight) });
        if let Some(medium) = medium
            && !self.fly(&mut importon, &self.fogs[medium as usize], length, walk)
        {
            return;
        }
        if let Some(hit) = hit
            && self.meet(&mut importon, &hit, walk)
        {
            importon.origin = hit.leave(importon.direction);
            walk.waiting.push(importon);
        }
    }

    /// Crosses fog up to a surface at a distance of `reach`; false: it has collided, and does not go on. The first collision is forced, and
    /// the path goes on without it too; after that it is one or the other.
    fn fly(&self, importon: &mut Importon, fog: &Medium, reach: f32, walk: &mut Walk) -> bool {
        let Importon { origin, direction, weight, .. } = *importon;
        let channel = self.channel;
        let column = media::column(fog, origin, direction, reach, &mut walk.knots);
        let extinction = fog.extinction()[channel];
        let left = fog.transmittance(column.at(reach))[channel];
        let (collides, u) = (1.0 - left, walk.random.uniform());
        if collides > 0.0 && (importon.specular || u < collides) {
            let u = if importon.specular { u * collides } else { u };
            let distance = column.distance_at(-libm::log1pf(-u) / extinction);
            let share = if importon.specular { collides } else { 1.0 };
            let xi = walk.pair();
            let weight = weight * share * fog.scattering[channel] / extinction;
            if distance < reach {
                let origin = origin + distance * direction;
                let direction = fog.sample_direction(direction, xi);
                let bounces = importon.bounces + 1;
                let (specular, ray) = (false, Rays::VOLUME);
                let way = Importon { origin, direction, weight, specular, ray, bounces, ..*importon };
                walk.waiting.push(way);
            }
            if !importon.specular {
                return false;
            }
        }
        if importon.specular {
            importon.weight *= left;
        }
        true
    }

    /// Meets a surface, where the camera may see it; whether the path goes on, along a direction of its own.
    fn meet(&self, importon: &mut Importon, hit: &Hit, walk: &mut Walk) -> bool {
        let channel = self.channel;
        if self.scene.object_of(hit).heed.hidden.has(importon.ray) {
            importon.interior = importon.interior.beyond(self.scene, hit, importon.direction);
            return true;
        }
        match *self.scene.material_at(hit) {
            Material::Black => return false,
            Material::Clear => {
                importon.interior = importon.interior.through(self.scene, hit, importon.direction)
            }
            Material::Lambert { .. } if importon.specular && !self.scene.shows_surfaces() => return false,
            Material::Lambert { albedo } => {
                self.see(importon, hit, albedo, walk);
                if walk.random.uniform() >= albedo[channel] {
                    return false;
                }
                let normal = facing_normal(hit, importon.direction);
                importon.direction = cosine_direction(normal, walk.pair());
                (importon.specular, importon.ray) = (false, Rays::DIFFUSE);
                importon.bounces += 1;
            }
            Material::Lobes(ref lobes) => return self.meet_lobes(importon, hit, lobes, walk),
            Material::Mirror { reflectance } => {
                if walk.random.uniform() >= reflectance[channel] {
                    return false;
                }
                importon.direction = reflect(importon.direction, facing_normal(hit, importon.direction));
                importon.ray = Rays::GLOSSY;
                importon.bounces += u32::from(!importon.specular);
            }
            Material::Dielectric { .. } => {
                let boundary = Boundary::new(self.scene, hit, importon.direction, &importon.interior);
                let through = walk.random.uniform() >= boundary.reflectance;
                importon.bounces += u32::from(!importon.specular && !boundary.is_matched());
                importon.direction = match boundary.refracted.filter(|_| through) {
                    Some(refracted) => {
                        (importon.interior, importon.ray) = (boundary.beyond, Rays::TRANSMISSION);
                        refracted
                    }
                    None => {
                        importon.ray = Rays::GLOSSY;
                        boundary.reflected
                    }
                };
            }
        }
        true
    }

    /// The same of a surface of lobes.
    fn meet_lobes(&self, importon: &mut Importon, hit: &Hit, lobes: &Lobes, walk: &mut Walk) -> bool {
        let channel = self.channel;
        let (facet, xi) = (walk.pair(), walk.pair());
        let met = Encounter::new(
            self.scene,
            hit,
            (Met::ByEyePath, importon.direction),
            &importon.interior,
            lobes,
            facet,
        );
        let diffuse = lobes.diffuse + lobes.translucent;
        if diffuse[channel] > 0.0 && self.scene.shows_surfaces() {
            self.see(importon, hit, diffuse, walk);
        }
        let Some(way) = met.draw(Vec3::AXES[channel], walk.random.uniform(), xi) else { return false };
        let is_diffuse = way.lobe.is_diffuse();
        if importon.specular && is_diffuse && !self.scene.shows_surfaces() {
            return false;
        }
        importon.weight *= way.factor[channel];
        importon.direction = way.direction;
        importon.interior = way.interior;
        importon.ray = way.lobe.sent_on(importon.ray);
        importon.specular &= !is_diffuse;
        importon.bounces += u32::from(!importon.specular && way.lobe != Lobe::Transparent);
        true
    }

    /// Leaves what a path is worth on a diffuse surface that the camera sees.
    fn see(&self, importon: &Importon, hit: &Hit, albedo: Vec3, walk: &mut Walk) {
        if importon.specular {
            let weight = importon.weight * albedo[self.channel] * FRAC_1_PI;
            walk.out.push(Deposit::Surface { position: hit.position, weight });
        }
    }
}
