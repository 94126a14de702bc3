//! Where the variance of a picture comes from: which kind of light, and where in the picture.

use super::methods::Compared;
use covbeam_session::color::luminance;
use covbeam_session::eye::sight::Sight;
use covbeam_session::eye::starts::EyeStarts;
use covbeam_session::film::{Film, FilmError, Picture};
use covbeam_session::kind::Split;
use covbeam_session::pass::Renderer;
use covbeam_session::plan::FirstSurfaces;
use covbeam_session::scene::Scene;
use covbeam_session::settings::{Layers, Settings};
use serde::Serialize;

/// First of the seeds, which no run of a method has.
const FIRST_SEED: u32 = 9001;

/// Places in a picture, in the order of [`KindShare::places`].
pub const PLACES: [&str; 3] = ["at edges", "in glass and mirrors", "elsewhere"];

/// The variance of pictures of one scene, and what it consists of.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ErrorBudget {
    /// Passes of each picture.
    pub passes: u32,
    /// Mean over the pixels of the luminance's variance over its squared mean, as relMSE has it.
    pub variance: f64,
    /// Of it, the share of fog before the first surface, of all kinds of light.
    pub fog: f64,
    /// Shares by kind of light. Kinds share eye rays and light paths: their sum is near 1, not 1.
    pub kinds: Vec<KindShare>,
}

/// Of one kind of light.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct KindShare {
    /// Its name.
    pub kind: &'static str,
    /// Share of the variance in pixels that a silhouette or the border of a shadow crosses, in those whose first surface is a mirror or
    /// glass, and in others.
    pub places: [f64; 3],
}

/// Renders pictures of a scene by a method, with each kind of light in a layer of its own, and compares them. None: cancelled.
///
/// - `passes` of each of `pictures` >= 2 pictures.
///
/// # Errors
/// A pass that the film refuses.
pub fn error_budget(
    scene: &Scene,
    method: &Compared,
    passes: u32,
    pictures: u32,
    cancelled: &(dyn Fn() -> bool + Sync),
) -> Result<Option<ErrorBudget>, FilmError> {
    let mut found = Vec::new();
    for seed in FIRST_SEED..FIRST_SEED + pictures {
        let settings = Settings { layers: Layers::EachKind, ..method.settings(scene, seed) };
        let mut renderer = Renderer::new(scene, settings);
        let mut film = Film::of_scene(scene);
        film.keep_kinds(Split::of_each_kind(scene));
        for pass in 1..=passes {
            let Some((image, _)) = renderer.pass(pass, cancelled) else { return Ok(None) };
            film.add(&image)?;
        }
        found.push(film.picture());
    }
    Ok(Some(shares(scene, passes, &found)))
}

fn shares(scene: &Scene, passes: u32, pictures: &[Picture]) -> ErrorBudget {
    let light = |picture: &Picture, pixel: usize| f64::from(luminance(picture.radiance[pixel]));
    let pixels = pictures[0].radiance.len();
    let mean = |pixel: usize| pictures.iter().map(|p| light(p, pixel)).sum::<f64>() / pictures.len() as f64;
    let means: Vec<f64> = (0..pixels).map(mean).collect();
    let floor = means.iter().sum::<f64>() / pixels as f64 * 0.01;
    let places = places(scene);
    // Of what `part` finds in each picture, by place.
    let variance = |part: &dyn Fn(&Picture, usize) -> f64| {
        let mut sums = [0.0; 3];
        for pixel in 0..pixels {
            let values: Vec<f64> = pictures.iter().map(|picture| part(picture, pixel)).collect();
            let middle = values.iter().sum::<f64>() / values.len() as f64;
            let square = values.iter().map(|value| (value - middle).powi(2)).sum::<f64>();
            let variance = square / (values.len() - 1) as f64;
            // A picture without light has none, and no variance either.
            sums[places[pixel]] += variance / (means[pixel].powi(2) + floor * floor).max(f64::MIN_POSITIVE);
        }
        sums.map(|sum| sum / pixels as f64)
    };
    let all: f64 = variance(&light).iter().sum();
    let share = |part: f64| if all > 0.0 { part / all } else { 0.0 };
    let fog = |picture: &Picture, pixel: usize| {
        picture.maps.as_ref().map_or(0.0, |maps| f64::from(luminance(maps.volume[pixel])))
    };
    let kinds = pictures[0].kinds.iter().enumerate().map(|(row, (kind, _))| {
        let of_kind = |picture: &Picture, pixel: usize| f64::from(luminance(picture.kinds[row].1[pixel]));
        KindShare { kind: kind.name(), places: variance(&of_kind).map(share) }
    });
    ErrorBudget { passes, variance: all, fog: share(variance(&fog).iter().sum()), kinds: kinds.collect() }
}

/// Of each pixel, its place among [`PLACES`].
fn places(scene: &Scene) -> Vec<usize> {
    let surfaces = FirstSurfaces::new(scene, &|| false).expect("never cancelled");
    let starts = EyeStarts::new(scene);
    let camera = &scene.camera;
    let place = |pixel: u32| {
        let (x, y) = (pixel % camera.width, pixel / camera.width);
        let seen = Sight::new(scene, &starts.middle(x, y)).surface;
        let material = seen.map(|(hit, _)| *scene.material(&hit));
        match material {
            _ if surfaces.has_edge(x, y) => 0,
            Some(material) if material.bends_light() => 1,
            _ => 2,
        }
    };
    (0..camera.width * camera.height).map(place).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene_file;
    use covbeam_session::kind::Kind;
    use glam::Vec3;

    fn ball() -> Scene {
        let text = include_str!("../../commands/render/default_scene.toml");
        let mut scene = scene_file::parse(text, "glass-ball.toml", ".".as_ref()).unwrap();
        scene.camera.set_width(48);
        scene.settings.photons = 500;
        scene
    }

    /// Two pictures that differ by known amounts.
    #[test]
    fn shares_are_those_of_what_differs() {
        let scene = ball();
        let pixels = (scene.camera.width * scene.camera.height) as usize;
        let picture = |straight: f32, scattered: f32| Picture {
            width: scene.camera.width,
            height: scene.camera.height,
            radiance: vec![Vec3::splat(10.0 + straight + scattered); pixels],
            kinds: vec![
                (Kind::Straight, vec![Vec3::splat(5.0 + straight); pixels]),
                (Kind::Scattered, vec![Vec3::splat(5.0 + scattered); pixels]),
            ],
            ..Picture::default()
        };
        // Straight light strays by 3, scattered by 1, as two of four pictures do and two do not: independent of each other.
        let pictures = [picture(3.0, 1.0), picture(3.0, -1.0), picture(-3.0, 1.0), picture(-3.0, -1.0)];
        let found = shares(&scene, 7, &pictures);
        // Means of squares 10 over n, variance x 4/3; over 10² + 0.1².
        assert!((found.variance - 40.0 / 3.0 / 100.01).abs() < 1e-6, "{found:?}");
        let sums: Vec<f64> = found.kinds.iter().map(|kind| kind.places.iter().sum()).collect();
        assert!((sums[0] - 0.9).abs() < 1e-6 && (sums[1] - 0.1).abs() < 1e-6, "{found:?}");
        assert_eq!((found.fog, found.passes), (0.0, 7));
        // The ball is in the picture, and so is its silhouette; half of the pixels see neither.
        let [edges, glass, elsewhere] = found.kinds[0].places;
        assert!(edges > 0.02 && glass > 0.02 && elsewhere > 0.5, "{found:?}");
    }

    #[test]
    fn kinds_of_a_scene_have_nearly_all_of_its_variance() {
        let method = Compared::named("covbeam").unwrap();
        let found = error_budget(&ball(), method, 2, 4, &|| false).unwrap().unwrap();
        let sum: f64 = found.kinds.iter().flat_map(|kind| kind.places).sum();
        assert_eq!(found.kinds.len(), 3);
        assert!(found.variance > 0.0 && (0.5..1.5).contains(&sum) && found.fog < 1.5, "{found:?}");
        assert_eq!(error_budget(&ball(), method, 2, 4, &|| true), Ok(None));
    }
}
