//! The methods that a report compares: one table.

use crate::pass::{Method as Gather, Renderer};
use crate::radius::RadiusRule;
use crate::scene::Scene;

/// A method as the report knows it.
#[derive(Clone, Copy, Debug)]
pub struct Method {
    /// Name, on the command line, in plots and in files.
    pub name: &'static str,
    /// What it is, for a reader.
    pub about: &'static str,
    /// Its colour everywhere, sRGB, of the palette of Okabe and Ito, which all eyes can tell apart.
    pub color: [u8; 3],
    make: for<'a> fn(&'a Scene, u32) -> Renderer<'a>,
}

impl Method {
    /// A renderer of `scene` with the scene's light paths a pass.
    pub fn renderer<'a>(&self, scene: &'a Scene, seed: u32) -> Renderer<'a> {
        (self.make)(scene, seed)
    }

    /// The method of a name.
    pub fn named(name: &str) -> Option<&'static Self> {
        METHODS.iter().find(|method| method.name == name)
    }
}

/// All methods. The first one is what the others are compared with.
pub const METHODS: &[Method] = &[
    Method {
        name: "plain",
        about: "plain progressive photon beams: one radius for all beams, an eye ray through every pixel in each pass",
        color: [213, 94, 0],
        make: |scene, seed| Renderer::new(scene, Gather::Ppb, scene.settings.photons, seed),
    },
    Method {
        name: "thesis",
        about: "beams as wide as the covariance of the light allows, an eye ray through every pixel in each pass",
        color: [0, 158, 115],
        make: |scene, seed| Renderer::new(scene, Gather::Adaptive, scene.settings.photons, seed),
    },
    Method {
        name: "covbeam",
        about: "what covbeam render does: straight light by shadow rays, light paths where the picture needs them, few eye rays where the \
                covariance says that the picture is smooth, and filters between them",
        color: [0, 114, 178],
        make: |scene, seed| {
            let mut renderer = Renderer::new(scene, Gather::Adaptive, scene.settings.guided_photons, seed);
            renderer.light_by_kind();
            renderer.plan_eye_rays();
            renderer
        },
    },
    Method {
        name: "least-error",
        about: "as thesis, but kernels as wide as the sum of squared bias and variance is least",
        color: [230, 159, 0],
        make: |scene, seed| widened_by(RadiusRule::LeastError, scene, seed),
    },
    Method {
        name: "density",
        about: "as thesis, but kernels as wide as the beams around are sparse, without any covariance",
        color: [204, 121, 167],
        make: |scene, seed| widened_by(RadiusRule::BeamDensity, scene, seed),
    },
];

fn widened_by(rule: RadiusRule, scene: &Scene, seed: u32) -> Renderer<'_> {
    let mut renderer = Renderer::new(scene, Gather::Adaptive, scene.settings.photons, seed);
    renderer.widen_by(rule);
    renderer
}
