//! A cheap look at a candidate: is there anything to see?

use covbeam_render::compare::luminance;
use covbeam_render::film::Film;
use covbeam_render::pass::{Method, Renderer};
use covbeam_render::scene::Scene;
use std::f64::consts::PI;

/// Pixels across and down.
const SIDE: u32 = 24;
const PASSES: u32 = 4;
const PHOTONS: u32 = 1500;

/// Least mean radiance, in that of a white wall over which all the light of the lamps is spread and which is as wide as the scene is.
const DARKEST: f64 = 2e-4;
/// Least share of the picture that is bright, as a number of pixels of equal brightness: (Σ L)² / Σ L².
const BRIGHT_SHARE: f64 = 0.03;
/// Share of the pixels that get some light.
const LIT_SHARE: f64 = 0.5;

/// Whether the picture is more than black with a dot in it.
pub(super) fn shows_something(scene: &Scene) -> bool {
    let mut scene = scene.clone();
    (scene.camera.width, scene.camera.height) = (SIDE, SIDE);
    scene.settings.radius *= 4.0;
    let mut renderer = Renderer::new(&scene, Method::Ppb, PHOTONS, 1);
    let mut film = Film::new(SIDE, SIDE);
    for pass in 1..=PASSES {
        let (image, _) = renderer.pass(pass, &|| false).expect("never cancelled");
        film.add(&image).expect("finite");
    }
    let radiance: Vec<f64> =
        film.picture().radiance.iter().map(|value| f64::from(luminance(*value))).collect();
    let (count, sum) = (radiance.len() as f64, radiance.iter().sum::<f64>());
    let squares: f64 = radiance.iter().map(|value| value * value).sum();
    let lit = radiance.iter().filter(|value| **value > 0.0).count() as f64;
    let flux: f64 = scene.lights.iter().map(|light| f64::from(luminance(light.flux()))).sum();
    let across = f64::from((scene.grid.max - scene.grid.min).length());
    let wall = flux / (PI * across * across);
    sum > DARKEST * wall * count && sum * sum > BRIGHT_SHARE * count * squares && lit > LIT_SHARE * count
}
