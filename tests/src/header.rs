//! The C header, generated from the sources of the C ABI.

use std::path::{Path, PathBuf};

/// The sources that C sees something of, in the order of the manual. (`lib.rs` would bring all of them once more.)
const SOURCES: [&str; 23] = [
    "version.rs",
    "status.rs",
    "types.rs",
    "light_field.rs",
    "light_fields.rs",
    "phase.rs",
    "medium.rs",
    "density.rs",
    "medium_points.rs",
    "medium_rays.rs",
    "column.rs",
    "spectrum.rs",
    "emission.rs",
    "edges.rs",
    "segment.rs",
    "grid.rs",
    "kernel.rs",
    "beam_map.rs",
    "pair.rs",
    "image.rs",
    "film.rs",
    "march.rs",
    "importance.rs",
];

/// The folder of the repository.
pub fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// What `include/covbeam.h` must contain, made from `ffi/src` as `ffi/cbindgen.toml` says.
///
/// # Errors
/// What cbindgen could not read.
pub fn generate() -> Result<String, String> {
    let ffi = repository().join("ffi");
    let config = cbindgen::Config::from_file(ffi.join("cbindgen.toml"))?;
    // The sources alone: without the crate's metadata cbindgen needs neither cargo nor a network.
    let builder = SOURCES.iter().fold(cbindgen::Builder::new().with_config(config), |builder, file| {
        builder.with_src(ffi.join("src").join(file))
    });
    let bindings = builder.generate().map_err(|error| error.to_string())?;
    let mut text = Vec::new();
    bindings.write(&mut text);
    String::from_utf8(text).map_err(|error| error.to_string())
}
