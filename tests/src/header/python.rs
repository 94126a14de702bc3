//! `_abi.py`: the ABI for ctypes.

use super::Headers;
use super::c::{Function, typed};
use std::fmt::Write;

/// The structs that Python passes one at a time; arrays are numpy's, of the layouts in `dtypes.py`.
const STRUCTS: [&str; 7] =
    ["grid_layout", "phase", "medium", "column", "kernel", "schedule", "march_expected"];

/// Structs of sessions, those that others have before these.
const SESSION_STRUCTS: [&str; 28] = [
    "material",
    "object",
    "shape",
    "phase_lobe",
    "volume",
    "light",
    "camera",
    "description",
    "mesh",
    "instance",
    "geometry_info",
    "surface_hit",
    "host_ray",
    "host_hit",
    "host_meeting",
    "host_way",
    "host_ways",
    "host_draw",
    "host_photon",
    "host_question",
    "host_arrival",
    "host_pixel",
    "host_eye_ray",
    "host",
    "bounce_limits",
    "session_settings",
    "goal",
    "session_info",
];

/// Types of functions in structs.
const FUNCTIONS: [&str; 8] = [
    "covbeam_host_cast",
    "covbeam_host_blocked",
    "covbeam_host_lobes",
    "covbeam_host_scatter",
    "covbeam_host_emit",
    "covbeam_host_illuminate",
    "covbeam_host_eye",
    "covbeam_spawn",
];

/// The whole file.
pub(super) fn abi(headers: &Headers) -> Result<String, String> {
    let mut text = include_str!("abi.py").to_owned();
    let all = headers.main.clone() + &headers.extra;
    let mark = "#define COVBEAM_ABI_VERSION ";
    let version = all.lines().find_map(|line| line.strip_prefix(mark)).ok_or("no ABI version")?;
    let structs = STRUCTS.iter().map(|name| class(&all, name)).collect::<Result<String, _>>()?;
    let mut results = String::new();
    let mut prototypes = String::new();
    for function in &headers.functions {
        let name = &function.name;
        match function.returns.as_str() {
            "covbeam_status" => {}
            "void" => writeln!(results, "    \"{name}\": None,").unwrap(),
            "uint32_t" => writeln!(results, "    \"{name}\": ctypes.c_uint32,").unwrap(),
            "const char *" => writeln!(results, "    \"{name}\": ctypes.c_char_p,").unwrap(),
            other => return Err(format!("{name} returns {other}")),
        }
        writeln!(prototypes, "    \"{name}\": \"{}\",", letters(function)?).unwrap();
    }
    for (mark, with) in [
        ("{version}", version),
        ("{structs}", &structs),
        ("{results}\n", &results),
        ("{prototypes}\n", &prototypes),
    ] {
        text = text.replace(mark, with);
    }
    Ok(text)
}

/// `_session_abi.py`: that of sessions.
pub(super) fn session_abi(headers: &Headers) -> Result<String, String> {
    let structs = SESSION_STRUCTS.iter().map(|name| class(&headers.session, name));
    let structs = structs.collect::<Result<String, _>>()?;
    let mut prototypes = String::new();
    for function in &headers.session_functions {
        writeln!(prototypes, "    \"{}\": \"{}\",", function.name, letters(function)?).unwrap();
    }
    let text = include_str!("session_abi.py");
    Ok(text.replace("{structs}", &structs).replace("{prototypes}\n", &prototypes))
}

/// A letter for each parameter.
fn letters(function: &Function) -> Result<String, String> {
    let letter = |kind: &str| match kind {
        "size_t" => Ok('z'),
        "float" => Ok('f'),
        "uint32_t" => Ok('u'),
        "int32_t" => Ok('i'),
        "covbeam_poll" | "covbeam_shade" | "covbeam_probe" => Ok('p'),
        pointer if pointer.ends_with('*') => Ok('p'),
        other => Err(format!("{}: {other}", function.name)),
    };
    function.parameters.iter().map(|parameter| letter(&parameter.kind)).collect()
}

/// A struct.
fn class(header: &str, name: &str) -> Result<String, String> {
    let start = format!("typedef struct covbeam_{name} {{\n");
    let (_, body) = header.split_once(&start).ok_or(format!("no struct {name}"))?;
    let (body, _) = body.split_once('}').ok_or(format!("no end of {name}"))?;
    let mut text = format!("\n\nclass {}(ctypes.Structure):\n    _fields_ = [\n", camel_case(name));
    for field in body.lines().filter_map(|line| line.trim().strip_suffix(';')) {
        let (declared, lengths) = field.split_once('[').unwrap_or((field, ""));
        // Of arrays of arrays the inner ones first.
        let lengths = lengths.split('[').rev().map(|length| length.trim_end_matches(']'));
        let length: String =
            lengths.filter(|length| !length.is_empty()).map(|length| format!(" * {length}")).collect();
        let (kind, field) = typed(declared)?;
        let kind = match kind.as_str() {
            "float" => "ctypes.c_float".to_owned(),
            "double" => "ctypes.c_double".to_owned(),
            "uint32_t" => "ctypes.c_uint32".to_owned(),
            "int32_t" => "ctypes.c_int32".to_owned(),
            "uint64_t" => "ctypes.c_uint64".to_owned(),
            "size_t" => "ctypes.c_size_t".to_owned(),
            function if FUNCTIONS.contains(&function) => "ctypes.c_void_p".to_owned(),
            pointer if pointer.ends_with('*') => "ctypes.c_void_p".to_owned(),
            other => camel_case(other.trim_start_matches("struct ").trim_start_matches("covbeam_")),
        };
        writeln!(text, "        (\"{field}\", {kind}{length}),").unwrap();
    }
    Ok(text + "    ]\n")
}

fn camel_case(name: &str) -> String {
    let capital = |word: &str| word[..1].to_uppercase() + &word[1..];
    name.split('_').map(capital).collect()
}
