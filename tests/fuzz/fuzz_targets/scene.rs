//! Any bytes as a scene file: a scene or an error, and the error can be printed.
#![no_main]

use covbeam_render::scene_file;
use libfuzzer_sys::fuzz_target;
use std::path::Path;

fuzz_target!(|bytes: &[u8]| {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    match scene_file::parse(text, "fuzz.toml", Path::new("no/such/folder")) {
        Ok(scene) => assert!(!scene.lights.is_empty() && scene.camera.direction(0.0, 0.0).is_finite()),
        Err(error) => assert!(error.to_string().starts_with("fuzz.toml:")),
    }
});
