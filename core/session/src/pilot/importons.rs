//! Paths from the camera: what they cross matters to the picture.

use super::instant::{Instant, Poll};
use super::look::Pixel;
use crate::eye::starts::EyeStart;
use crate::light::cosine_direction;
use crate::random::Random;
use crate::scene::geometry::divide;
use crate::scene::media;
use crate::scene::optics::{Boundary, Interior, facing_normal, reflect};
use crate::scene::{Material, Scene};
use crate::surface::encounter::{Encounter, Lobe};
use covbeam::{GridLayout, ImportanceGrid, Knot, Medium};
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
                let mut random = Random::new([0, (chunk * CHUNK + index) as u32, 0, KEY]);
                let Instant { scene, fogs } = instants[instant];
                // In turns: what light is worth is a mean of what it is worth in the channels.
                let channel = index % 3;
                Walker { instant, scene, fogs, channel }.follow(start, weight, &mut random, &mut out);
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
    depth: u32,
    /// How often light that comes along it the other way is scattered and reflected before the place that the camera sees.
    bounces: u32,
}

impl Walker<'_> {
    fn follow(&self, start: EyeStart, weight: f32, random: &mut Random, out: &mut Vec<Deposit>) {
        let EyeStart { origin, direction, interior, .. } = start;
        let first = Importon { origin, direction, weight, interior, specular: true, depth: 0, bounces: 0 };
        let mut waiting = vec![first];
        let mut knots = Vec::new();
        while let Some(mut importon) = waiting.pop() {
            if importon.depth < LONGEST && self.scene.allows(importon.bounces) {
                importon.depth += 1;
                self.step(importon, random, &mut waiting, &mut knots, out);
            }
        }
    }

    fn step(
        &self,
        mut importon: Importon,
        random: &mut Random,
        waiting: &mut Vec<Importon>,
        knots: &mut Vec<Knot>,
        out: &mut Vec<Deposit>,
    ) {
        let hit = self.scene.intersect(importon.origin, importon.direction, f32::INFINITY);
        let reach = hit.map_or(f32::INFINITY, |hit| hit.distance);
        let Importon { origin, direction, weight, .. } = importon;
        let (medium, channel) = (importon.interior.medium(self.scene), self.channel);
        let flight =
            Flight { instant: self.instant, medium, origin, direction, length: reach, weight, channel };
        out.push(if importon.specular { Deposit::EyeRay(flight) } else { Deposit::Path(flight) });
        if let Some(medium) = medium {
            let fog = &self.fogs[medium as usize];
            let column = media::column(fog, origin, direction, reach, knots);
            let extinction = fog.extinction()[channel];
            let left = fog.transmittance(column.at(reach))[channel];
            let (collides, u) = (1.0 - left, random.uniform());
            // The first collision is forced, and the path goes on without it too; after that it is one or the other.
            if collides > 0.0 && (importon.specular || u < collides) {
                let u = if importon.specular { u * collides } else { u };
                let distance = column.distance_at(-(-u).ln_1p() / extinction);
                let share = if importon.specular { collides } else { 1.0 };
                let direction = fog.phase.sample(direction, [random.uniform(), random.uniform()]);
                let weight = weight * share * fog.scattering[channel] / extinction;
                if distance < reach {
                    let origin = origin + distance * importon.direction;
                    let bounces = importon.bounces + 1;
                    let way = Importon { origin, direction, weight, specular: false, bounces, ..importon };
                    waiting.push(way);
                }
                if !importon.specular {
                    return;
                }
            }
            if importon.specular {
                importon.weight *= left;
            }
        }
        let Some(hit) = hit else { return };
        match *self.scene.material(&hit) {
            Material::Black => return,
            Material::Clear => {
                importon.interior = importon.interior.through(self.scene, &hit, importon.direction)
            }
            Material::Lambert { .. } if importon.specular && !self.scene.shows_surfaces() => return,
            Material::Lambert { albedo } => {
                if importon.specular {
                    let weight = importon.weight * albedo[channel] * FRAC_1_PI;
                    out.push(Deposit::Surface { position: hit.position, weight });
                }
                if random.uniform() >= albedo[channel] {
                    return;
                }
                let normal = facing_normal(&hit, importon.direction);
                importon.direction = cosine_direction(normal, [random.uniform(), random.uniform()]);
                importon.specular = false;
                importon.bounces += 1;
            }
            Material::Lobes(ref lobes) => {
                let mut pair = || [random.uniform(), random.uniform()];
                let (facet, xi) = (pair(), pair());
                let met =
                    Encounter::new(self.scene, &hit, importon.direction, &importon.interior, lobes, facet);
                let diffuse = (lobes.diffuse + lobes.translucent)[channel];
                if importon.specular && diffuse > 0.0 && self.scene.shows_surfaces() {
                    let weight = importon.weight * diffuse * FRAC_1_PI;
                    out.push(Deposit::Surface { position: hit.position, weight });
                }
                let Some(way) = met.draw(Vec3::AXES[channel], random.uniform(), xi) else { return };
                let is_diffuse = way.lobe.is_diffuse();
                if importon.specular && is_diffuse && !self.scene.shows_surfaces() {
                    return;
                }
                importon.weight *= way.factor[channel];
                importon.direction = way.direction;
                importon.interior = way.interior;
                importon.specular &= !is_diffuse;
                importon.bounces += u32::from(!importon.specular && way.lobe != Lobe::Transparent);
            }
            Material::Mirror { reflectance } => {
                if random.uniform() >= reflectance[channel] {
                    return;
                }
                importon.direction = reflect(importon.direction, facing_normal(&hit, importon.direction));
                importon.bounces += u32::from(!importon.specular);
            }
            Material::Dielectric { .. } => {
                let boundary = Boundary::new(self.scene, &hit, importon.direction, &importon.interior);
                let through = random.uniform() >= boundary.reflectance;
                importon.bounces += u32::from(!importon.specular && !boundary.is_matched());
                importon.direction = match boundary.refracted.filter(|_| through) {
                    Some(refracted) => {
                        importon.interior = boundary.beyond;
                        refracted
                    }
                    None => boundary.reflected,
                };
            }
        }
        importon.origin = hit.leave(importon.direction);
        waiting.push(importon);
    }
}
