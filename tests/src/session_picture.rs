//! The picture that a session makes of a scene with its default settings, by the reference renderer.

use covbeam_render::scene_file;
use covbeam_session::film::Film;
use covbeam_session::pass::Renderer;
use covbeam_session::render::{Goal, render};
use covbeam_session::settings::{Method, Settings};
use std::convert::Infallible;
use std::error::Error;
use std::path::Path;
use std::time::Instant;

/// Head and body of a PFM file: covbeam's method with seed 0.
///
/// # Errors
/// A scene that cannot be read, or that has more light than single precision holds.
pub fn session_picture(scene: &Path, passes: u32) -> Result<(String, Vec<u8>), Box<dyn Error>> {
    let scene = scene_file::load(scene)?;
    let mut renderer = Renderer::new(&scene, Settings::of_scene(Method::Covbeam, &scene, 0));
    let mut film = Film::of_scene(&scene);
    let pass = |index, cancelled: &(dyn Fn() -> bool + Sync)| renderer.pass(index, cancelled);
    let goal = Goal { passes: Some(passes), ..Goal::default() };
    render(&mut film, &goal, Instant::now(), &|| false, pass, |_, _| Ok::<_, Infallible>(None))?;
    // Rows come from the bottom.
    let radiance = film.picture().radiance;
    let rows = radiance.chunks(scene.camera.width as usize).rev().flatten();
    let body = rows.flat_map(|pixel| pixel.to_array()).flat_map(f32::to_le_bytes).collect();
    Ok((format!("PF\n{} {}\n-1\n", scene.camera.width, scene.camera.height), body))
}
