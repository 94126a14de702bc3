//! A fleet of scenes that nobody tuned: made from a seed, each with what every picture of it must show.
//!
//! A scene is written as the text that `covbeam render` reads, so that each one can be looked at.

pub mod agreement;
pub mod blocks;
mod draw;
pub mod errors;
mod grid;
mod meshes;
mod objects;
mod pilot;
pub mod rings;
pub mod runs;
pub mod snapped;
mod text;

use covbeam_render::scene_file;
use covbeam_session::scene::MAX_IMAGE_SIDE;
use covbeam_session::scene::Scene;
use std::error::Error;
use std::path::{Path, PathBuf};

/// Candidates that are drawn for a scene before giving up. About one in five is refused.
const ATTEMPTS: u64 = 64;

const SMOKE: &[u8] =
    include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/../examples/scenes/volumes/smoke.vol"));

/// A scene of the fleet, and where it was written.
pub struct Member {
    /// As it was read back.
    pub scene: Scene,
    /// The scene file.
    pub path: PathBuf,
}

/// Makes scene `number` of the fleet of `seed` as `FOLDER/NNN.toml`, and the meshes and volumes it needs beside it. Its picture is
/// `width` pixels across; everything else depends on `seed` and `number` alone.
///
/// Candidates whose picture would be nearly black are passed over, always the same ones.
///
/// # Errors
/// Files that cannot be written; no candidate that gives a picture.
pub fn member(seed: u32, number: u32, width: u32, folder: &Path) -> Result<Member, Box<dyn Error>> {
    assert!((1..=MAX_IMAGE_SIDE).contains(&width), "a picture's width");
    std::fs::create_dir_all(folder.join("meshes"))?;
    std::fs::create_dir_all(folder.join("volumes"))?;
    for mesh in meshes::ALL {
        std::fs::write(folder.join(mesh.file), (mesh.text)())?;
    }
    std::fs::write(folder.join("volumes/smoke.vol"), SMOKE)?;
    for attempt in 0..ATTEMPTS {
        let text = draw::scene([u64::from(seed), u64::from(number), attempt], width);
        let name = format!("scene {number} of seed {seed}");
        let scene = scene_file::parse(&text, &name, folder)?;
        if pilot::shows_something(&scene) {
            let path = folder.join(format!("{number:03}.toml"));
            std::fs::write(&path, text)?;
            return Ok(Member { scene, path });
        }
    }
    Err(format!("no candidate for scene {number} of seed {seed} gives a picture").into())
}
