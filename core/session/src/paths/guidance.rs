//! What light is worth in a picture, by voxel, and how lamps emit for it: what a pilot has found (`pilot.rs`).

use crate::color::mean;
use crate::scene::geometry::MOST_BOUNDS;
use crate::scene::optics::Interior;
use crate::scene::passage::clear;
use crate::scene::{Material, Rays, Scene};
use covbeam::{EmissionGuide, GridLayout, Importance, ImportanceCell, Medium};
use covbeam_geometry::hit::Hit;
use glam::Vec3;
use std::sync::Arc;

/// Segments of a ray between boundaries that do not bend it: those of fog in a vacuum.
const MOST_SEGMENTS: u32 = 4;

const FITS: &str = "as many cells as the layout has";

/// What light is worth in a scene's picture, and how its lamps emit.
pub(crate) struct Guidance {
    layout: GridLayout,
    cells: Arc<[ImportanceCell]>,
    lamps: LampEmission,
    /// On power x importance of all paths: one over the share of their branches that is left.
    factor: f32,
}

impl Guidance {
    /// From the importance in the voxels of a layout.
    pub(crate) fn new(layout: GridLayout, cells: Arc<[ImportanceCell]>, lamps: LampEmission) -> Self {
        Self { layout, cells, lamps, factor: 1.0 }
    }

    /// Power x importance of all light, its straight part left out.
    pub(crate) fn total(&self) -> f32 {
        self.lamps.total * self.factor
    }

    /// Makes power x importance of all paths larger by a factor, and so their branches fewer.
    pub(crate) fn coarsen(&mut self, factor: f32) {
        self.lamps.total *= factor;
    }

    /// Leaves paths this share of their branches, about, whatever share it was before.
    pub(crate) fn leave(&mut self, share: f32) {
        self.factor = 1.0 / share;
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
}

/// What a watt is worth that starts along a ray, having bounced so often.
pub(crate) fn of_ray(
    scene: &Scene,
    fogs: &[Medium],
    importance: &Importance,
    (origin, direction): (Vec3, Vec3),
    interior: &Interior,
    bounces: u32,
) -> f32 {
    let (mut origin, mut interior) = (origin, *interior);
    let [mut worth, mut left] = [0.0, 1.0];
    let may_bounce = scene.allows(bounces + 1);
    for segment in 1..=MOST_BOUNDS {
        let hit = scene.intersect_flat(origin, direction, f32::INFINITY);
        let reach = hit.map_or(f32::INFINITY, |hit| hit.distance);
        if let Some(id) = interior.medium(scene) {
            let found = importance.of_segment(&fogs[id as usize], origin, direction, reach);
            worth += left * (found.beam + if may_bounce { found.scattered } else { 0.0 });
            left *= found.transmittance;
        }
        let Some(hit) = hit else { break };
        let most = if scene.material(&hit).is_clear() { MOST_BOUNDS } else { MOST_SEGMENTS };
        let beyond = (segment < most).then(|| clear(scene, &hit, direction, &interior, Rays::NONE)).flatten();
        let Some(beyond) = beyond else {
            worth += left * of_arrival(scene, importance, &hit, may_bounce);
            break;
        };
        (origin, interior) = (hit.leave(direction), beyond);
    }
    worth
}

/// How each lamp emits.
pub(crate) struct LampEmission {
    /// Power x importance of all light.
    pub(crate) total: f32,
    /// Cumulative share of the paths.
    pub(crate) cumulative: Vec<f32>,
    /// Cells of a guide across.
    pub(crate) across: usize,
    /// One a lamp.
    pub(crate) guides: Vec<f32>,
}

impl LampEmission {
    fn guide(&self, lamp: usize) -> EmissionGuide<'_> {
        let size = EmissionGuide::size(self.across);
        EmissionGuide::new(self.across, &self.guides[lamp * size..(lamp + 1) * size]).expect("as filled")
    }
}

/// What a watt that arrives on a surface is worth. What mirrors and glass make of it is not known here.
fn of_arrival(scene: &Scene, importance: &Importance, hit: &Hit, may_bounce: bool) -> f32 {
    let here = importance.at(hit.position);
    let beyond = if may_bounce { here.scattered } else { 0.0 };
    match *scene.material_at(hit) {
        Material::Black => 0.0,
        Material::Clear => beyond,
        Material::Lambert { albedo } => of_diffuse(albedo, &here, false, may_bounce),
        Material::Lobes(lobes) => {
            let sharp = mean((lobes.most() - lobes.diffuse - lobes.translucent).max(Vec3::ZERO));
            of_diffuse(lobes.diffuse + lobes.translucent, &here, false, may_bounce) + sharp * beyond
        }
        Material::Mirror { .. } | Material::Dielectric { .. } => beyond,
    }
}

/// What a watt is worth that arrives on a surface and leaves it diffusely. Straight light on surfaces is looked up by shadow rays.
pub(crate) fn of_diffuse(albedo: Vec3, here: &ImportanceCell, is_straight: bool, may_bounce: bool) -> f32 {
    let is_seen = !is_straight && albedo != Vec3::ZERO;
    let reflected = if may_bounce { mean(albedo) * here.scattered } else { 0.0 };
    reflected + if is_seen { here.surface } else { 0.0 }
}
