//! Runs of some passes, and their errors against a reference.

use crate::{Outcome, Size};
use covbeam_render::scene_file;
use covbeam_render::study::compare::{Comparison, compare};
use covbeam_render::study::report::Reference;
use covbeam_session::film::{Film, Picture};
use covbeam_session::pass::{PassTimes, Renderer};
use covbeam_session::paths::operators::Operator;
use covbeam_session::random::Emission;
use covbeam_session::scene::Scene;
use covbeam_session::settings::{Method, Settings};
use covbeam_tests::regions::{Region, by_sharpness, is_ball, of_ball, whole};
use std::path::Path;

/// Some passes of a scene.
#[derive(Clone, Copy)]
pub(crate) struct Run<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) method: Method,
    pub(crate) emission: Emission,
    pub(crate) seed: u32,
    pub(crate) photons: u32,
    pub(crate) passes: u32,
    pub(crate) left_out: Option<Operator>,
}

impl<'a> Run<'a> {
    /// With the scene's photons, low-discrepancy emission and all operators.
    pub(crate) fn new(scene: &'a Scene, method: Method, seed: u32, passes: u32) -> Self {
        let (emission, photons) = (Emission::LowDiscrepancy, scene.settings.photons);
        Self { scene, method, emission, seed, photons, passes, left_out: None }
    }

    /// The picture and its core time.
    pub(crate) fn picture(&self) -> Outcome<(Picture, PassTimes)> {
        self.picture_telling(|_, _| ())
    }

    /// Like [`Run::picture`], and tells the passes and their core-seconds after each pass.
    pub(crate) fn picture_telling(&self, tell: impl Fn(u32, f64)) -> Outcome<(Picture, PassTimes)> {
        let Self { scene, method, emission, seed, photons, passes, left_out } = *self;
        let settings = Settings { emission, left_out, ..Settings::of(method, photons, seed) };
        let mut renderer = Renderer::new(scene, settings);
        let mut film = Film::of_scene(scene);
        let mut total = PassTimes::default();
        for index in 1..=passes {
            let (image, times) = renderer.pass(index, &|| false).expect("never cancelled");
            film.add(&image)?;
            total += times;
            tell(index, total.total());
        }
        Ok((film.picture(), total))
    }
}

/// The scene, with its pictures scaled to the width asked for.
pub(crate) fn load(path: &Path, size: Size) -> Outcome<Scene> {
    let mut scene = scene_file::load(path)?;
    if let Some(width) = size.width {
        scene.camera.set_width(width);
    }
    Ok(scene)
}

/// Like [`load`], and a reference, whose width the scene's pictures get if none is asked for.
pub(crate) fn load_both(path: &Path, reference: &Path, size: Size) -> Outcome<(Scene, Reference)> {
    let mut scene = scene_file::load(path)?;
    let reference = Reference::load(reference, &name(reference), &mut scene, size.width)?;
    Ok((scene, reference))
}

/// A file's name without its ending.
pub(crate) fn name(path: &Path) -> String {
    path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

/// The named regions of the ball scenes; in other scenes those read off the reference, or the whole picture.
pub(crate) fn regions(path: &Path, scene: &Scene, reference: Option<&Picture>) -> Vec<Region> {
    match reference {
        _ if is_ball(&name(path)) => of_ball(scene.camera.width).to_vec(),
        Some(reference) => by_sharpness(reference).to_vec(),
        None => vec![whole(scene.camera.width, scene.camera.height)],
    }
}

/// Compares a region with the same region of the reference.
pub(crate) fn in_region(picture: &Picture, reference: &Picture, region: &Region) -> Outcome<Comparison> {
    Ok(compare(picture, reference, |x, y| region.contains(x, y))?)
}

/// Heads of the columns of [`error_cells`].
pub(crate) fn error_heads(reference: &Reference) -> Vec<String> {
    let of = |measure: &'static str| {
        reference.regions.iter().map(move |region| format!("{measure} {}", region.name))
    };
    of("relMSE").chain(of("bias [%]")).collect()
}

/// relMSE and bias of a picture by region.
pub(crate) fn error_cells(reference: &Reference, picture: &Picture) -> Vec<String> {
    let errors = reference.errors(picture);
    let rel_mse = errors.iter().map(|error| format!("{:.2e}", error.rel_mse));
    rel_mse.chain(errors.iter().map(|error| format!("{:+.2}", 100.0 * error.bias))).collect()
}

/// Prints the head of a table.
pub(crate) fn print_heads(heads: &[String]) {
    println!("| {} |\n|{}", heads.join(" | "), "---|".repeat(heads.len()));
}
