//! Which voxels are all fog, and between which of them a surface stands.

use super::walk::{center_of, index_of, voxel_at, voxel_of, voxel_size};
use covbeam::GridLayout;
use covbeam_session::random::Random;
use covbeam_session::scene::optics::Interior;
use covbeam_session::scene::{MediumDensity, Scene, SceneMedium, Shape};
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// Rays along a side of a voxel's face, to find surfaces in it.
const RAYS: u32 = 4;

/// Points along an edge of a voxel, to measure how much of it is medium.
const POINTS: u32 = 6;

/// What counts as on a voxel's face rather than inside, in voxels: surfaces often lie exactly there.
const SHIFT: f64 = 0.01;

/// What stands in the voxels of a grid.
pub(super) struct Surroundings {
    /// Share of each voxel that is filled with a medium and can be reached by light.
    pub(super) medium: Vec<f32>,
    /// Per voxel and axis: a bit for each of `RAYS`² parallel rays, set if it meets a surface inside the voxel.
    inside: Vec<[u16; 3]>,
    /// The same for surfaces on the voxel's lower face.
    below: Vec<[u16; 3]>,
}

impl Surroundings {
    pub(super) fn of(scene: &Scene, layout: &GridLayout) -> Self {
        let solids = solids(scene);
        let along = |index: usize, from: f64, to: f64| {
            let voxel = voxel_of(layout, index);
            std::array::from_fn(|axis| rays_met(scene, layout, voxel, axis, [from, to]))
        };
        let all = 0..layout.cell_count();
        let inside: Vec<[u16; 3]> =
            all.clone().into_par_iter().map(|index| along(index, SHIFT, 1.0 - SHIFT)).collect();
        let below = all.clone().into_par_iter().map(|index| along(index, -SHIFT, SHIFT)).collect();
        let volumes = scene.media.iter().any(|medium| matches!(medium.density, MediumDensity::Grid(_)));
        let share = |index: usize| {
            let cut = inside[index] != [0; 3] || volumes;
            medium_share(scene, &solids, layout, voxel_of(layout, index), cut)
        };
        let medium = all.into_par_iter().map(share).collect();
        Self { medium, inside, below }
    }

    /// Share of the parallel rays along `axis` that meet a surface inside these neighbours or between them; they are in
    /// rising order.
    pub(super) fn cut(&self, voxels: &[usize], axis: usize) -> f64 {
        let inside = voxels.iter().map(|voxel| self.inside[*voxel][axis]);
        let between = voxels[1..].iter().map(|voxel| self.below[*voxel][axis]);
        let met = inside.chain(between).fold(0, |met, rays| met | rays);
        f64::from(met.count_ones()) / f64::from(RAYS * RAYS)
    }
}

/// Which rays along `axis` meet a surface between two places, in voxels from the lower face of `voxel`.
fn rays_met(scene: &Scene, layout: &GridLayout, voxel: [u32; 3], axis: usize, [from, to]: [f64; 2]) -> u16 {
    let size = voxel_size(layout);
    let low = center_of(layout, voxel) - 0.5 * size;
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    let mut met = 0;
    for ray in 0..RAYS * RAYS {
        let mut start = low;
        start[u] += size[u] * (f64::from(ray % RAYS) + 0.5) / f64::from(RAYS);
        start[v] += size[v] * (f64::from(ray / RAYS) + 0.5) / f64::from(RAYS);
        let mut end = start;
        start[axis] += size[axis] * from;
        end[axis] += size[axis] * to;
        met |= u16::from(scene.occluded(start.as_vec3(), end.as_vec3())) << ray;
    }
    met
}

fn medium_share(scene: &Scene, solids: &[Solid], layout: &GridLayout, voxel: [u32; 3], cut: bool) -> f32 {
    let center = center_of(layout, voxel);
    let filled = |point: DVec3| {
        let point = point.as_vec3();
        let medium = Interior::at(scene, point).medium(scene);
        let scatters = |id: u32| {
            let SceneMedium { medium, density, .. } = scene.medium_of(id);
            // Beams end where a volume ends, so the fluence is known inside only.
            let within = match density {
                MediumDensity::Grid(volume) => voxel_at(&volume.layout, point).is_some(),
                MediumDensity::Uniform | MediumDensity::Exponential(_) => true,
            };
            within && medium.scattering.max_element() > 0.0
        };
        medium.is_some_and(scatters) && solids.iter().all(|solid| solid.lets_light_to(point))
    };
    if !cut {
        return if filled(center) { 1.0 } else { 0.0 };
    }
    let size = voxel_size(layout);
    let mut random = Random::new([index_of(layout, voxel) as u32, 0, 0, 0xf111]);
    let mut jittered = |i: u32| (f64::from(i) + f64::from(random.uniform())) / f64::from(POINTS) - 0.5;
    let mut inside = 0;
    for i in 0..POINTS.pow(3) {
        let cell = [i % POINTS, i / POINTS % POINTS, i / POINTS / POINTS];
        let offset = DVec3::from(cell.map(&mut jittered));
        inside += u32::from(filled(center + offset * size));
    }
    inside as f32 / POINTS.pow(3) as f32
}

/// A closed opaque object: no light passes from its inside to its outside.
struct Solid<'a> {
    shape: &'a Shape,
    /// Whether a light is inside, and whether one is outside.
    lit: [bool; 2],
}

fn solids(scene: &Scene) -> Vec<Solid<'_>> {
    scene
        .objects
        .iter()
        .filter(|object| object.shape.is_closed() && object.material.index().is_none())
        .map(|object| {
            let mut lit = [false; 2];
            for light in &scene.lights {
                lit[usize::from(!object.shape.contains(light.position()))] = true;
            }
            Solid { shape: &object.shape, lit }
        })
        .collect()
}

impl Solid<'_> {
    /// Whether this solid does not stand between `point` and all lights.
    fn lets_light_to(&self, point: Vec3) -> bool {
        self.lit[usize::from(!self.shape.contains(point))]
    }
}
