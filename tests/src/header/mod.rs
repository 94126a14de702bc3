//! What is made from the sources of the C ABI: the C headers, and tables for the programs in other languages.

mod c;
mod hostile;
mod inline;
mod kinds;
mod layout;
mod operators;
mod python;
mod replay;

pub use c::Function;

use c::{Item, items};
use std::fs;
use std::path::{Path, PathBuf};

/// The sources that C sees something of, in the order of the manual. (`lib.rs` and `mod.rs` would bring those
/// that they declare once more.)
const SOURCES: [&str; 63] = [
    "version.rs",
    "status.rs",
    "voxels.rs",
    "light_path/edge.rs",
    "light_field/field.rs",
    "light_field/sources.rs",
    "light_field/travel.rs",
    "light_field/smooth_surface.rs",
    "light_field/losses.rs",
    "light_field/scatter.rs",
    "light_field/fluence.rs",
    "medium/phase.rs",
    "medium/options.rs",
    "medium/voxel_density.rs",
    "medium/density.rs",
    "medium/flight.rs",
    "medium/transmittance.rs",
    "medium/reach.rs",
    "medium/knots.rs",
    "medium/column.rs",
    "spectrum.rs",
    "light_path/path_numbers.rs",
    "light_path/emission_guide.rs",
    "light_path/find_edges.rs",
    "light_path/segment.rs",
    "grid/cells.rs",
    "grid/handle.rs",
    "grid/deposit.rs",
    "grid/merge.rs",
    "grid/look_up.rs",
    "grid/contents.rs",
    "grid/saved.rs",
    "kernel/options.rs",
    "kernel/schedule.rs",
    "kernel/shape.rs",
    "kernel/radius.rs",
    "beam.rs",
    "eye_ray.rs",
    "beam_map/handle.rs",
    "beam_map/scratch.rs",
    "beam_map/gather.rs",
    "beam_map/shaded.rs",
    "pair/cross.rs",
    "pair/gather.rs",
    "pair/filter.rs",
    "image/spectrum.rs",
    "image/filter.rs",
    "image/mask.rs",
    "film/regions.rs",
    "film/handle.rs",
    "film/plan.rs",
    "film/rays.rs",
    "film/picture.rs",
    "film/error.rs",
    "march/knots.rs",
    "march/handle.rs",
    "march/expected.rs",
    "march/rounds.rs",
    "importance/handle.rs",
    "importance/add.rs",
    "importance/merge.rs",
    "importance/look_up.rs",
    "importance/weight_window.rs",
];

/// Those of sessions, the same.
const SESSION_SOURCES: [&str; 9] = [
    "session/fields.rs",
    "session/description.rs",
    "session/geometry.rs",
    "session/scene.rs",
    "session/host/fields.rs",
    "session/host.rs",
    "session/settings.rs",
    "session/render.rs",
    "session/picture.rs",
];

/// Enumerations whose values are fields of theirs, as numbers.
const SESSION_ENUMS: [&str; 7] = [
    "covbeam_asks",
    "covbeam_shape_kind",
    "covbeam_light_kind",
    "covbeam_projection",
    "covbeam_method",
    "covbeam_end",
    "covbeam_layer",
];

/// The folder of the repository.
pub fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// The headers.
pub struct Headers {
    /// `covbeam.h`: what hosts that gather beams call.
    pub main: String,
    /// `covbeam_extra.h`: the rest.
    pub extra: String,
    /// What the library exports, but for sessions.
    pub functions: Vec<Function>,
    /// `covbeam_session.h`: sessions.
    pub session: String,
    /// What the library exports for sessions.
    pub session_functions: Vec<Function>,
}

/// How cbindgen makes headers of `ffi/src`.
fn config() -> Result<cbindgen::Config, String> {
    cbindgen::Config::from_file(repository().join("ffi/cbindgen.toml"))
}

/// What cbindgen makes of some sources.
fn declarations(config: cbindgen::Config, sources: &[&str]) -> Result<String, String> {
    let ffi = repository().join("ffi");
    // The sources alone: without the crate's metadata cbindgen needs neither cargo nor a network.
    let builder = sources.iter().fold(cbindgen::Builder::new().with_config(config), |builder, file| {
        builder.with_src(ffi.join("src").join(file))
    });
    let bindings = builder.generate().map_err(|error| error.to_string())?;
    let mut text = Vec::new();
    bindings.write(&mut text);
    String::from_utf8(text).map_err(|error| error.to_string())
}

const OPEN: &str = "#ifdef __cplusplus\nextern \"C\" {\n#endif // __cplusplus\n\n";
const CLOSE: &str = "#ifdef __cplusplus\n}  // extern \"C\"\n#endif  // __cplusplus\n";

/// Makes the headers. A declaration whose comment has `@extra` goes into the second one; a function whose
/// comment has `@single NAME` is followed by the inline function of that name, which calls it for one
/// element; `@kinds` is described in `kinds`.
///
/// # Errors
/// What cbindgen could not read, or this cannot.
pub fn headers() -> Result<Headers, String> {
    let text = declarations(config()?, &SOURCES)?;
    let (types, rest) = text.split_once(OPEN).ok_or("no functions")?;
    let (functions, end) = rest.split_once(CLOSE).ok_or("no end of the functions")?;
    let (types, calls) = (items(types)?, items(functions)?);
    let main = [&write(&types, false)?, "\n", OPEN, &write(&calls, false)?, "\n", CLOSE, end].concat();
    let extra = [
        include_str!("extra.h"),
        &write(&types, true)?,
        "\n",
        OPEN,
        &write(&calls, true)?,
        "\n",
        CLOSE,
        "\n#endif  /* COVBEAM_EXTRA_H */\n",
    ]
    .concat();
    let functions = calls.into_iter().filter_map(|item| item.function).collect();
    let (session, session_functions) = session()?;
    Ok(Headers { main, extra, functions, session, session_functions })
}

/// The items that belong into the first or the second header.
fn write(all: &[Item], extra: bool) -> Result<String, String> {
    let of = all.iter().filter(|item| item.extra == extra).map(Item::text);
    Ok(of.collect::<Result<Vec<_>, _>>()?.join("\n\n") + "\n")
}

/// The header of sessions, and their functions.
fn session() -> Result<(String, Vec<Function>), String> {
    let mut config = config()?;
    (config.header, config.include_guard, config.sys_includes) = (None, None, Vec::new());
    config.export.include = SESSION_ENUMS.map(str::to_owned).to_vec();
    let text = declarations(config, &SESSION_SOURCES)?;
    let (types, rest) = text.split_once(OPEN).ok_or("no functions of sessions")?;
    let (functions, _) = rest.split_once(CLOSE).ok_or("no end of the functions of sessions")?;
    let (types, calls) = (items(types.trim_start())?, items(functions)?);
    let header = [
        include_str!("session.h"),
        &write(&types, false)?,
        "\n",
        OPEN,
        &write(&calls, false)?,
        "\n",
        CLOSE,
        "\n#endif  /* COVBEAM_SESSION_H */\n",
    ];
    Ok((header.concat(), calls.into_iter().filter_map(|item| item.function).collect()))
}

/// All files that are made, from the root of the repository, and what they must contain.
///
/// # Errors
/// What could not be read.
pub fn files() -> Result<Vec<(&'static str, String)>, String> {
    let read =
        |path: &str| fs::read_to_string(repository().join(path)).map_err(|error| format!("{path}: {error}"));
    let headers = headers()?;
    Ok(vec![
        ("ffi/python/src/covbeam/_abi.py", python::abi(&headers)?),
        ("ffi/python/src/covbeam/_session_abi.py", python::session_abi(&headers)?),
        ("tests/clients/hostile/calls.h", hostile::calls(&headers)?),
        ("tests/clients/vectors/plain.h", replay::plain(&headers)?),
        ("tests/clients/vectors/operators.hpp", operators::replay(&headers)?),
        ("include/covbeam.hpp", operators::forwarding(&read("include/covbeam.hpp")?, &headers)?),
        ("tests/bare-metal/src/operators.rs", operators::bare_metal(&headers)?),
        ("tests/clients/layout.h", layout::assertions(&read("ffi/src/layout.rs")?)),
        ("include/covbeam.h", headers.main),
        ("include/covbeam_session.h", headers.session),
        ("include/covbeam_extra.h", headers.extra),
    ])
}
