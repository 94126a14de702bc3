//! A coarse picture.

use crate::compare::luminance;
use crate::eye::EyeTracer;
use crate::kind::Kind;
use crate::optics::Interior;
use crate::photon::{PhotonRecord, PhotonTracer, Record};
use crate::random::{Emission, Random};
use crate::scene::Scene;
use crate::straight::{Straight, is_left_to_beams};
use crate::surface::SurfaceMap;
use covbeam::{Beam, BeamMap, GatherScratch, Gathered, Kernel, Medium};
use glam::Vec3;
use rayon::prelude::*;

/// Eye rays across and down.
const LATTICE: u32 = 32;

/// Light paths.
const PATHS: u32 = 4096;

/// Kernels are as many times as wide as those of the first pass, and disks of surface photons as many times wider.
const WIDER: f32 = 2.0;
const DISKS: [f32; 2] = [20.0, 8.0];

/// A pixel's brightness is taken for at least this share of that of the nine around it: the coarse picture is noisy.
const LEAST_OF_NEIGHBOURS: f32 = 0.3;

/// And for at least this share of the picture's: what is darker is as good as black.
const LEAST_OF_PICTURE: f32 = 0.01;

/// Purpose of random numbers, and sequence of light paths.
const KEY: u32 = 0x100c;

/// An eye ray of the coarse picture.
pub(super) struct Pixel {
    pub(super) direction: Vec3,
    /// 1/(pixels x luminance).
    pub(super) weight: f32,
}

/// The coarse picture's eye rays; None if it is black.
pub(super) fn pixels(scene: &Scene, fogs: &[Medium]) -> Option<Vec<Pixel>> {
    let tracer = PhotonTracer::new(scene, 0, Emission::LowDiscrepancy);
    let mut record = PhotonRecord::default();
    (0..PATHS).for_each(|index| tracer.trace(KEY, index, PATHS, Record::Beams, &mut record));
    let radius = WIDER * scene.settings.schedule.radius;
    let mut beams: Vec<Vec<Beam>> = vec![Vec::new(); fogs.len()];
    for found in record.beams {
        if found.kind != Kind::Straight || is_left_to_beams(scene, found.medium) {
            beams[found.medium as usize].push(found.beam);
        }
    }
    let maps: Vec<BeamMap> =
        beams.into_iter().zip(fogs).map(|(beams, fog)| BeamMap::build(beams, radius, fog)).collect();
    let [diffuse, caustic] = DISKS.map(|factor| factor * scene.settings.schedule.radius);
    let surfaces = SurfaceMap::build(record.surface, diffuse, caustic);
    let interior = Interior::at(scene, scene.camera.position);
    let eye = EyeTracer { scene, fogs, interior, surfaces: &surfaces };
    let (min_radius, max_radius) = (radius, radius);
    let shape = scene.settings.schedule.shape;
    let kernel = Kernel { shape, min_radius, max_radius, error: 1.0, grid: None };
    let straight = Straight { scene, fogs, lamps: tracer.lamps(), seed: 0, pass: 1 };
    let seen: Vec<(Vec3, f32)> = (0..LATTICE * LATTICE)
        .into_par_iter()
        .map_init(Default::default, |(scratch, knots, segments), node| {
            let scratch: &mut GatherScratch = scratch;
            let mut random = Random::new([0, node, 0, KEY]);
            let mut at =
                |index: u32, count: u32| (index as f32 + random.uniform()) / LATTICE as f32 * count as f32;
            let camera = &scene.camera;
            let direction =
                camera.direction(at(node % LATTICE, camera.width), at(node / LATTICE, camera.height));
            let segments: &mut Vec<crate::eye::EyeSegment> = segments;
            segments.clear();
            let mut radiance: Vec3 = eye.trace(direction, node, &mut random, segments).iter().sum();
            for segment in segments.iter() {
                let mut gathered = [Gathered::default()];
                let medium = segment.medium as usize;
                let rays = [segment.ray];
                maps[medium]
                    .gather(&fogs[medium], &rays, &kernel, &mut gathered, scratch)
                    .expect("its map was built in it");
                let straight = straight.radiance(segment, node, 1.0, (0, 1), knots);
                radiance += segment.throughput * (gathered[0].radiance + straight);
            }
            (direction, luminance(radiance))
        })
        .collect();
    weigh(&seen)
}

fn weigh(seen: &[(Vec3, f32)]) -> Option<Vec<Pixel>> {
    let count = seen.len() as f32;
    let mean = seen.iter().map(|(_, luminance)| luminance).sum::<f32>() / count;
    if !(mean > 0.0 && mean.is_finite()) {
        return None;
    }
    let around = |node: u32| {
        let (x, y) = (node % LATTICE, node / LATTICE);
        let near = |at: u32| at.saturating_sub(1)..=(at + 1).min(LATTICE - 1);
        let nodes = near(y).flat_map(|y| near(x).map(move |x| (y * LATTICE + x) as usize));
        let (sum, count) = nodes.fold((0.0, 0.0), |(sum, count), node| (sum + seen[node].1, count + 1.0_f32));
        sum / count
    };
    let pixels = seen.iter().zip(0..).map(|(&(direction, luminance), node)| {
        let least = (LEAST_OF_NEIGHBOURS * around(node)).max(LEAST_OF_PICTURE * mean);
        Pixel { direction, weight: 1.0 / (count * luminance.max(least)) }
    });
    Some(pixels.collect())
}
