//! Looks through the middle of pixels: the first fog, the first surface, lamps, and how much light there is.

use crate::camera::Camera;
use crate::eye::shown::{Fill, Pixels, SmallLamps};
use crate::eye::sight::{FirstFog, Sight};
use crate::eye::starts::EyeStarts;
use crate::eye::straight_irradiance;
use crate::lamps::{LampTree, MOST_ASKED};
use crate::scene::optics::{Interior, facing_normal};
use crate::scene::{Rays, Scene};
use covbeam::Medium;
use covbeam_geometry::hit::Hit;
use glam::Vec3;
use std::f32::consts::PI;

/// Of many lamps only those with such a share of a place's light have borders of shadows that are looked for: without one the others hardly
/// change it, and the noise of choosing among them would pass for borders.
const LEAST_SHARE: f32 = 0.125;

/// What is first behind a pixel.
pub(super) struct Look {
    pub(super) fog: Option<FirstFog>,
    /// Of the first surface, as [`Camera::depth_along`] counts it; infinite where there is none.
    pub(super) depth: f32,
    /// Of the fog's start; infinite where there is none.
    pub(super) start: f32,
    pub(super) is_black: bool,
    /// Straight light on the surface, up to a factor, and that of lamps before it.
    pub(super) lit: f32,
    /// What lamps fill of the pixel.
    pub(super) lamps: Fill,
}

impl Look {
    /// - `[x, y]`: the pixel.
    pub(super) fn new(
        scene: &Scene,
        fogs: &[Medium],
        lamps: &LampTree,
        small: &SmallLamps,
        starts: &EyeStarts,
        [x, y]: [u32; 2],
    ) -> Self {
        let (camera, start) = (&scene.camera, &starts.middle(x, y));
        let Sight { fog, glows, end, surface } = Sight::new(scene, start);
        let lamps_seen = Pixels { scene, small, starts }.fill([x, y]);
        let depth = |distance: f32| camera.near + distance * camera.depth_along(start.direction);
        let shown = scene.shown.undimmed(scene, small, start, end, surface.as_ref().map(|(hit, _)| hit));
        let is_black = !glows
            && shown == Vec3::ZERO
            && lamps_seen != Fill::Uneven
            && surface.as_ref().is_none_or(|(hit, _)| !scene.shows(&scene.material_at(hit)));
        let surface = surface.filter(|_| scene.shows_surfaces());
        let of_surface =
            surface.map_or(0.0, |(hit, interior)| lit(scene, fogs, lamps, interior, start.direction, &hit));
        let lit = of_surface + PI * shown.element_sum();
        let begins = fog.map_or(f32::INFINITY, |fog| depth(fog.from));
        Self { fog, depth: depth(end), start: begins, is_black, lit, lamps: lamps_seen }
    }
}

/// What is first behind all pixels.
pub(super) struct Looks<'a> {
    pub(super) camera: &'a Camera,
    pub(super) fogs: &'a [Medium<'a>],
    /// Row by row.
    pub(super) all: Vec<Look>,
}

impl Looks<'_> {
    pub(super) fn at(&self, x: u32, y: u32) -> &Look {
        &self.all[(y * self.camera.width + x) as usize]
    }

    /// The numbers of a pixel and of the eight around it.
    pub(super) fn around(&self, x: u32, y: u32) -> impl Iterator<Item = usize> {
        let Camera { width, height, .. } = *self.camera;
        let near = |at: u32, end: u32| at.saturating_sub(1)..=(at + 1).min(end - 1);
        near(y, height).flat_map(move |y| near(x, width).map(move |x| (y * width + x) as usize))
    }
}

/// Straight light on a surface, seen from where the ray to it starts, up to a factor.
fn lit(
    scene: &Scene,
    fogs: &[Medium],
    lamps: &LampTree,
    interior: Interior,
    direction: Vec3,
    hit: &Hit,
) -> f32 {
    let albedo = scene.material_at(hit).diffuse();
    if albedo == Vec3::ZERO {
        return 0.0;
    }
    let normal = facing_normal(hit, direction);
    let start = hit.leave(normal);
    let mut asked = lamps.on_surface(hit.position, normal, 0.5);
    if lamps.is_drawn_on_surfaces() {
        asked.retain(|(_, stands_for)| *stands_for <= 1.0 / (LEAST_SHARE * MOST_ASKED as f32));
    }
    asked.retain(|(lamp, _)| scene.falls_on(*lamp, hit, Rays::DIFFUSE));
    let sum = straight_irradiance(scene, fogs, interior, start, &asked, |light| {
        let (density, from) = light.flux_density(start, [0.0; 2]);
        (density * (from - start).normalize_or_zero().dot(normal).max(0.0), from)
    });
    (albedo * sum).element_sum()
}
