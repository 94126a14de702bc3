//! A cheap look at a candidate: is there anything to see?

use covbeam_session::color::luminance;
use covbeam_session::film::Film;
use covbeam_session::pass::Renderer;
use covbeam_session::scene::{Material, Scene};
use covbeam_session::settings::{Method, Settings};
use std::f64::consts::PI;

/// Pixels across and down.
const SIDE: u32 = 24;
const PASSES: u32 = 3;
const PHOTONS: u32 = 1500;

/// Least mean radiance, in that of a white wall over which all the light of the lamps is spread and which is as wide as the scene is.
const DARKEST: f64 = 2e-4;
/// Least share of the picture that is bright, as a number of pixels of equal brightness: (Σ L)² / Σ L².
const BRIGHT_SHARE: f64 = 0.03;
/// Least correlation of two pictures with different seeds: below, five CPU-seconds would show noise alone.
const REPEATED: f64 = 0.4;
/// Share of the light that is still there with black surfaces: the fog's, but for what surfaces give to it.
const FOG_SHARE: f64 = 0.15;

/// Whether the picture is more than black with a dot in it, and whether there is fog to be seen.
pub(super) fn shows_something(scene: &Scene) -> bool {
    let mut scene = scene.clone();
    (scene.camera.width, scene.camera.height) = (SIDE, SIDE);
    scene.settings.schedule.radius *= 4.0;
    let (first, second) = (picture(&scene, 1), picture(&scene, 2));
    let (count, sum) = (first.len() as f64, first.iter().sum::<f64>());
    let product = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
    let squares = product(&first, &first);
    let flux: f64 = scene.lights.iter().map(|light| f64::from(luminance(light.flux()))).sum();
    let across = f64::from((scene.grid.max - scene.grid.min).length());
    let wall = flux / (PI * across * across);
    let repeated = product(&first, &second) / (squares * product(&second, &second)).sqrt();
    let seen =
        sum > DARKEST * wall * count && sum * sum > BRIGHT_SHARE * count * squares && repeated > REPEATED;
    seen && fog_share(scene, sum) > FOG_SHARE
}

fn fog_share(mut scene: Scene, whole: f64) -> f64 {
    for object in &mut scene.objects {
        if matches!(object.material, Material::Lambert { .. }) {
            object.material = Material::Black;
        }
    }
    picture(&scene, 3).iter().sum::<f64>() / whole
}

fn picture(scene: &Scene, seed: u32) -> Vec<f64> {
    let mut renderer = Renderer::new(scene, Settings::of(Method::Plain, PHOTONS, seed));
    let mut film = Film::new(SIDE, SIDE);
    for pass in 1..=PASSES {
        let (image, _) = renderer.pass(pass, &|| false).expect("never cancelled");
        film.add(&image).expect("finite");
    }
    film.picture().radiance.iter().map(|value| f64::from(luminance(*value))).collect()
}
