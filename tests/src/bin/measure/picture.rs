//! What making a picture of the passes costs, over its size.

use crate::Outcome;
use crate::rendering::name;
use covbeam_render::scene_file;
use covbeam_session::film::Film;
use covbeam_session::pass::Renderer;
use covbeam_session::settings::{Method, Settings};
use cpu_time::ProcessTime;
use std::path::Path;

/// Square pictures of these sides, after `passes` passes.
pub(crate) fn run(path: &Path, sides: &[u32], passes: u32) -> Outcome<()> {
    println!(
        "{}: a picture after {passes} passes with planned eye rays\n\n\
         | pixels | a pass, CPU-s | eye rays a pass | the picture, CPU-s | µs a pixel |\n|---|---|---|---|---|",
        name(path)
    );
    for side in sides {
        let mut scene = scene_file::load(path)?;
        (scene.camera.width, scene.camera.height) = (*side, *side);
        let settings = Settings { planned: true, ..Settings::of_scene(Method::Thesis, &scene, 1) };
        let mut renderer = Renderer::new(&scene, settings);
        let mut film = Film::of_scene(&scene);
        let mut rays = 0;
        let start = ProcessTime::now();
        for pass in 1..=passes {
            let (image, _) = renderer.pass(pass, &|| false).expect("never cancelled");
            rays += image.sparse.as_ref().map_or(0, |sparse| sparse.fog.len());
            film.add(&image)?;
        }
        let rendered = start.elapsed().as_secs_f64();
        let start = ProcessTime::now();
        let picture = film.picture();
        let seconds = start.elapsed().as_secs_f64();
        let pixels = picture.radiance.len();
        println!(
            "| {side} x {side} | {:.2} | {} | {seconds:.2} | {:.2} |",
            rendered / f64::from(passes),
            rays / passes as usize,
            1e6 * seconds / pixels as f64
        );
    }
    Ok(())
}
