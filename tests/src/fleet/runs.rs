//! Independent runs of the methods that are held against each other.

use covbeam_session::film::{Film, FilmError, Picture};
use covbeam_session::pass::Renderer;
use covbeam_session::scene::Scene;
use covbeam_session::settings::{Method, Settings};
use glam::Vec3;
use rayon::prelude::*;
use std::ops::Range;

/// A way to make a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Estimator {
    /// Adaptive beams, few eye rays where the picture is smooth: what a render gets that asks for nothing else.
    Default,
    /// Adaptive beams, an eye ray through every pixel.
    EveryPixel,
    /// Plain beams at the scene's radius.
    Plain,
    /// Plain beams at half the radius: see [`narrow`].
    Reference,
    /// Light tracing.
    Light,
}

impl Estimator {
    /// Light paths a pass.
    pub fn photons(self, scene: &Scene) -> u32 {
        match self {
            Self::Default | Self::EveryPixel => scene.settings.guided_photons,
            Self::Plain | Self::Reference => scene.settings.photons,
            // A path costs a beam's gather less.
            Self::Light => 20 * scene.settings.photons,
        }
    }

    /// A renderer of this kind; for [`Estimator::Reference`] the scene must be the narrowed one.
    pub fn renderer(self, scene: &Scene, seed: u32) -> Renderer<'_> {
        let method = match self {
            Self::Default | Self::EveryPixel => Method::Covbeam,
            Self::Plain | Self::Reference => Method::Plain,
            Self::Light => Method::LightTrace,
        };
        let planned = self == Self::Default;
        Renderer::new(scene, Settings { planned, ..Settings::of(method, self.photons(scene), seed) })
    }
}

/// The scene with half of the kernels' radius: a quarter of the blur for twice the variance of a beam. Narrower kernels would need more time
/// than what is held against them has.
pub fn narrow(scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    scene.settings.schedule.radius *= 0.5;
    scene
}

/// Whether light tracing sees all of the picture: it misses what is seen through glass or in mirrors.
pub fn light_tracing_sees_all(scene: &Scene) -> bool {
    !scene.objects.iter().any(|object| object.material.bends_light())
}

/// Pictures of `passes` passes each, one a seed.
///
/// # Errors
/// A pass that is not finite.
pub fn pictures(
    scene: &Scene,
    estimator: Estimator,
    seeds: Range<u32>,
    passes: u32,
) -> Result<Vec<Picture>, FilmError> {
    let narrowed = (estimator == Estimator::Reference).then(|| narrow(scene));
    let scene = narrowed.as_ref().unwrap_or(scene);
    let picture = |seed| {
        let mut renderer = estimator.renderer(scene, seed);
        let mut film = Film::of_scene(scene);
        for pass in 1..=passes {
            let (image, _) = renderer.pass(pass, &|| false).expect("never cancelled");
            film.add(&image)?;
        }
        Ok(film.picture())
    };
    seeds.into_par_iter().map(picture).collect()
}

/// The mean of some pictures, at least one.
pub fn mean(pictures: &[Picture]) -> Picture {
    let share = 1.0 / pictures.len() as f32;
    let mut radiance = vec![Vec3::ZERO; pictures[0].radiance.len()];
    for picture in pictures {
        for (sum, value) in radiance.iter_mut().zip(&picture.radiance) {
            *sum += share * *value;
        }
    }
    Picture { width: pictures[0].width, height: pictures[0].height, radiance, ..Picture::default() }
}
