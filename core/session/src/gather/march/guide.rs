//! The guide of shadow rays: what is known about the light that comes straight from the lights before any of them.

use crate::gather::first_hits::FirstHits;
use crate::scene::Scene;
use covbeam::{FluenceGrid, MarchKnot};
use glam::Vec3;

/// Rays from each light that tell where its light is to be expected.
const FEWEST_FIRST_HITS: usize = 1024;
const MOST_FIRST_HITS: usize = 1 << 18;

/// What is known about the light that comes straight from the lights before any shadow ray.
pub(crate) struct Guide<'a> {
    grid: FluenceGrid<'a>,
    /// By light.
    first_hits: Vec<FirstHits>,
}

impl<'a> Guide<'a> {
    /// With an eighth of the shadow rays that `samples` a pixel are. None: it was `cancelled`.
    pub(crate) fn new(
        scene: &Scene,
        grid: FluenceGrid<'a>,
        samples: u32,
        key: [u32; 2],
        cancelled: &dyn Fn() -> bool,
    ) -> Option<Self> {
        let pixels = scene.camera.width as usize * scene.camera.height as usize;
        let rays = (pixels * samples as usize / 8).clamp(FEWEST_FIRST_HITS, MOST_FIRST_HITS);
        let lights = scene.lights.iter().zip(0..);
        let first_hits = lights.map(|(light, index)| {
            (!cancelled()).then(|| FirstHits::new(scene, light, rays, [key[0] ^ index << 16, key[1]]))
        });
        Some(Self { grid, first_hits: first_hits.collect::<Option<_>>()? })
    }

    /// Writes down what is known of a light at a place of an eye ray.
    pub(super) fn tell(&self, light: usize, place: Vec3, direction: Vec3, knot: &mut MarchKnot) {
        knot.visibility = self.first_hits[light].visibility(place);
        if let Some(spectrum) = self.grid.look_up(place) {
            knot.deviation = spectrum.variance_along(direction).sqrt();
        }
    }

    /// The rays that it took.
    pub(super) fn rays(&self) -> u64 {
        self.first_hits.iter().map(FirstHits::rays).sum()
    }
}
