//! Whether two renders are of the same scene: a hash of all that its files say.

use crate::scene_file::fields::{SceneError, Source};

/// What a picture is not another one for, or what is told apart by name: they may change between two renders of a scene.
const TOLD_ELSEWHERE: [&str; 3] = ["passes", "photons", "seed"];

/// BLAKE3 of a scene's values, whatever their layout and comments, and of its files' hashes: 64 hexadecimal digits.
///
/// # Errors
/// No TOML.
pub(crate) fn fingerprint(source: Source<'_>, files: &[blake3::Hash]) -> Result<String, SceneError> {
    let mut scene: toml::Table =
        toml::from_str(source.text).map_err(|error| source.syntax(error.span(), error.message()))?;
    if let Some(render) = scene.get_mut("render").and_then(toml::Value::as_table_mut) {
        TOLD_ELSEWHERE.iter().for_each(|field| drop(render.remove(*field)));
        if render.is_empty() {
            scene.remove("render");
        }
    }
    let mut hasher = blake3::Hasher::new();
    let values = scene.to_string();
    hasher.update(&(values.len() as u64).to_le_bytes());
    hasher.update(values.as_bytes());
    for file in files {
        hasher.update(file.as_bytes());
    }
    Ok(hasher.finalize().to_hex().to_string())
}
