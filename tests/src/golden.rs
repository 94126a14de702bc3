//! Four small pictures, by the hash of their bits: what nobody meant to change shows here.
//!
//! The bits depend on no processor, no system and no number of threads: angles and exponentials are libm's.

use crate::header::repository;
use crate::session_picture::session_picture;
use crate::vectors::fnv;
use covbeam_render::scene_file;
use covbeam_session::film::Film;
use covbeam_session::pass::Renderer;
use covbeam_session::settings::{Method, Settings};
use std::error::Error;

/// Glass and a caustic, density in closed form with edges, density in voxels.
const SCENES: [&str; 3] = ["glass-ball", "shaft", "smoke"];
const WIDTH: u32 = 48;
const PASSES: u32 = 3;
const PHOTONS: u32 = 2000;

/// What `tests/golden.txt` must contain: a line for each picture.
///
/// # Errors
/// A scene that cannot be read.
pub fn text() -> Result<String, Box<dyn Error>> {
    let mut text = format!(
        "# FNV-1a of the radiance of {WIDTH} pixels square, {PASSES} passes of {PHOTONS} light paths. Made by:\n\
         # cargo run -p covbeam-tests --bin golden -- --write\n"
    );
    for name in SCENES {
        let mut scene = scene_file::load(&repository().join(format!("examples/scenes/{name}.toml")))?;
        (scene.camera.width, scene.camera.height) = (WIDTH, WIDTH);
        let mut renderer = Renderer::new(&scene, Settings::of(Method::Covbeam, PHOTONS, 1));
        let mut film = Film::of_scene(&scene);
        for pass in 1..=PASSES {
            film.add(&renderer.pass(pass, &|| false).expect("never cancelled").0)?;
        }
        let picture = film.picture();
        let channels = picture.radiance.iter().flat_map(|radiance| radiance.to_array());
        let bits = channels.flat_map(|channel| channel.to_bits().to_le_bytes());
        text += &format!("{name} {:016x}\n", fnv(&bits.collect::<Vec<u8>>()));
    }
    // Clients of the C library on other systems make it, too (tests/clients/cross.sh).
    let (head, body) = session_picture(&repository().join("tests/scenes/session.toml"), 16)?;
    text += &format!("README.md's fog.pfm {:016x}\n", fnv(&[head.as_bytes(), &body[..]].concat()));
    Ok(text)
}
