//! `hostile/calls.h`: how hostile hosts call each function.

use super::Headers;
use super::c::Function;
use super::kinds::parameters;
use std::fmt::Write;

/// The whole file.
pub(super) fn calls(headers: &Headers) -> Result<String, String> {
    let mut text =
        "/* Made from the headers by `cargo run -p covbeam-tests --bin header`; do not edit. */\n".to_owned();
    for function in &headers.functions {
        match function.returns.as_str() {
            "covbeam_status" => text += &call("CALL", function)?,
            "void" => text += &call("FREE", function)?,
            _ => writeln!(text, "OTHER({})", function.name).unwrap(),
        }
    }
    Ok(text)
}

fn call(how: &str, function: &Function) -> Result<String, String> {
    let (mut described, mut arguments) = (Vec::new(), Vec::new());
    for (i, (parameter, kind)) in parameters(function)?.into_iter().enumerate() {
        described.push(format!("{} {kind}", parameter.name));
        let argument = match parameter.kind.as_str() {
            "size_t" => "SIZE",
            "float" => "NUMBER",
            "uint32_t" => "WORD",
            "covbeam_poll" => "POLL",
            "covbeam_shade" => "SHADE",
            "covbeam_probe" => "PROBE",
            _ => "POINTER",
        };
        arguments.push(format!("{argument}({i})"));
    }
    let (described, arguments) = (described.join("; "), arguments.join(", "));
    Ok(format!("{how}({}, \"{described}\", {arguments})\n", function.name))
}
