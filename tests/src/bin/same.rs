//! Whether a host's picture has the bits of the reference renderer's: `same SCENE.toml PASSES PICTURE.pfm`.
//!
//! The scene is rendered by covbeam's method with seed 0, as a session does with its default settings.

use covbeam_render::scene_file;
use covbeam_session::film::Film;
use covbeam_session::pass::Renderer;
use covbeam_session::render::{Goal, render};
use covbeam_session::settings::{Method, Settings};
use std::convert::Infallible;
use std::error::Error;
use std::path::Path;
use std::time::Instant;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [scene, passes, picture] = &arguments[..] else {
        return Err("usage: same SCENE.toml PASSES PICTURE.pfm".into());
    };
    let scene = scene_file::load(Path::new(scene))?;
    let mut renderer = Renderer::new(&scene, Settings::of_scene(Method::Covbeam, &scene, 0));
    let mut film = Film::of_scene(&scene);
    let pass = |index, cancelled: &(dyn Fn() -> bool + Sync)| renderer.pass(index, cancelled);
    let goal = Goal { passes: Some(passes.parse()?), ..Goal::default() };
    render(&mut film, &goal, Instant::now(), &|| false, pass, |_, _| Ok::<_, Infallible>(None))?;
    // Rows come from the bottom.
    let rows = film
        .picture()
        .radiance
        .chunks(scene.camera.width as usize)
        .rev()
        .flatten()
        .copied()
        .collect::<Vec<_>>();
    let ours: Vec<u8> = rows.iter().flat_map(|pixel| pixel.to_array()).flat_map(f32::to_le_bytes).collect();
    let file = std::fs::read(picture)?;
    let head = format!("PF\n{} {}\n-1\n", scene.camera.width, scene.camera.height);
    let theirs = file.strip_prefix(head.as_bytes()).ok_or("not a picture of this size")?;
    let differing = ours.chunks(12).zip(theirs.chunks(12)).filter(|(a, b)| a != b).count();
    if ours.len() != theirs.len() || differing > 0 {
        return Err(format!("{differing} of {} pixels differ", rows.len()).into());
    }
    println!("same: {} pixels of {passes} passes, bit for bit", rows.len());
    Ok(())
}
