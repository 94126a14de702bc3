//! Where the picture needs photons: a pilot finds the importance of light in the voxels, and from it how each lamp emits.
//!
//! The pilot is a function of the scene alone: a coarse picture; paths from the camera that carry the inverse of its brightness; rays from
//! each lamp that ask what the light in a direction is worth; and a few guided paths that find out how much of the picture's noise is theirs.

mod branches;
mod importons;
mod lamps;
mod look;

pub(crate) use branches::share_of_branches;

use crate::optics::Interior;
use crate::scene::{Material, Scene};
use covbeam::{
    Column, EmissionGuide, GridLayout, Importance, ImportanceCell, ImportanceGrid, ImportanceSums, Medium,
};
use covbeam_geometry::hit::Hit;
use glam::Vec3;

const FITS: &str = "as many cells as the layout has";

/// What light is worth in a scene's picture, and how its lamps emit.
pub(crate) struct Guidance {
    layout: GridLayout,
    cells: Vec<ImportanceCell>,
    lamps: lamps::Lamps,
}

impl Guidance {
    /// None where no light reaches the camera, and where all that does comes straight from lamps.
    ///
    /// - `fogs`: the scene's media. Cost: 50 to 90 core-milliseconds in the scenes of the repository.
    pub(crate) fn new(scene: &Scene, fogs: &[Medium]) -> Option<Self> {
        let pixels = look::pixels(scene, fogs)?;
        let layout = scene.grid;
        let mut sums = vec![ImportanceSums::default(); layout.cell_count()];
        let mut grid = ImportanceGrid::new(layout, &mut sums).expect("the scene's grid was validated");
        importons::walk(scene, fogs, &pixels, &mut grid);
        let mut cells = vec![ImportanceCell::default(); layout.cell_count()];
        grid.resolve(&mut cells).expect(FITS);
        let importance = Importance::new(layout, &cells).expect(FITS);
        let lamps = lamps::Lamps::new(scene, fogs, &importance)?;
        Some(Self { layout, cells, lamps })
    }

    /// Power x importance of all light, its straight part left out.
    pub(crate) fn total(&self) -> f32 {
        self.lamps.total
    }

    /// Makes power x importance of all paths larger by a factor, and so their branches fewer.
    pub(crate) fn coarsen(&mut self, factor: f32) {
        self.lamps.total *= factor;
    }

    /// Cumulative shares of the light paths that start from each lamp.
    pub(crate) fn lamps(&self) -> &[f32] {
        &self.lamps.cumulative
    }

    /// How a lamp's emission is warped.
    pub(crate) fn emission(&self, lamp: usize) -> EmissionGuide<'_> {
        self.lamps.guide(lamp)
    }

    /// The importance in the voxels.
    pub(crate) fn importance(&self) -> Importance<'_> {
        Importance::new(self.layout, &self.cells).expect(FITS)
    }

    /// What a watt is worth that starts along a ray.
    pub(crate) fn of_ray(
        &self,
        scene: &Scene,
        fogs: &[Medium],
        origin: Vec3,
        direction: Vec3,
        interior: &Interior,
    ) -> f32 {
        let hit = scene.intersect(origin, direction, f32::INFINITY);
        let reach = hit.map_or(f32::INFINITY, |hit| hit.distance);
        let importance = self.importance();
        let [mut worth, mut left] = [0.0, 1.0];
        if let Some(id) = interior.medium(scene) {
            let found = importance.of_segment(&fogs[id as usize], origin, direction, reach);
            (worth, left) = (found.beam + found.scattered, found.transmittance);
        }
        worth + left * hit.map_or(0.0, |hit| of_arrival(scene, &importance, &hit))
    }
}

/// What a watt that arrives on a surface is worth. What mirrors and glass make of it is not known here.
fn of_arrival(scene: &Scene, importance: &Importance, hit: &Hit) -> f32 {
    let here = importance.at(hit.position);
    match scene.objects[hit.object as usize].material {
        Material::Black => 0.0,
        Material::Lambert { albedo } => of_diffuse(albedo, &here, false),
        Material::Lobes(lobes) => {
            let sharp = mean((lobes.most() - lobes.diffuse - lobes.translucent).max(Vec3::ZERO));
            of_diffuse(lobes.diffuse + lobes.translucent, &here, false) + sharp * here.scattered
        }
        Material::Mirror { .. } | Material::Dielectric { .. } => here.scattered,
    }
}

/// What a watt is worth that arrives on a surface and leaves it diffusely. Straight light on surfaces is looked up by shadow rays.
fn of_diffuse(albedo: Vec3, here: &ImportanceCell, is_straight: bool) -> f32 {
    let is_seen = !is_straight && albedo != Vec3::ZERO;
    mean(albedo) * here.scattered + if is_seen { here.surface } else { 0.0 }
}

/// Of the channels.
pub(crate) fn mean(color: Vec3) -> f32 {
    color.element_sum() / 3.0
}

/// What is left of the mean channel's light on the way to a surface; in a tabulated column, to 5e-4.
fn left(fog: &Medium, column: &Column, reach: f32) -> f32 {
    (-fog.mean_extinction() * column.at(reach)).exp()
}
