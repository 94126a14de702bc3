//! `hostile/calls.h`: how hostile hosts call each function.

use super::Headers;
use super::c::Function;
use std::fmt::Write;

/// The whole file.
///
/// - `kinds`: `hostile/kinds.txt`, a line a function: its name, and the kinds of its parameters but for counts of arrays,
///   strides and callbacks, which have theirs by name and type.
pub(super) fn calls(headers: &Headers, kinds: &str) -> Result<String, String> {
    let mut text = "/* Made from kinds.txt and the headers by `cargo run -p covbeam-tests --bin header`; do not edit. */\n".to_owned();
    let mut lines: Vec<(&str, &str)> = kinds
        .lines()
        .filter(|line| !line.is_empty() && !line.starts_with('#'))
        .map(|line| line.split_once(' ').unwrap_or((line, "")))
        .collect();
    for function in &headers.functions {
        let name = &function.name;
        if function.returns != "covbeam_status" && function.returns != "void" {
            writeln!(text, "OTHER({name})").unwrap();
            continue;
        }
        let at = lines.iter().position(|(of, _)| of == name).ok_or(format!("kinds.txt: no {name}"))?;
        let (_, of) = lines.swap_remove(at);
        text += &call(function, of)?;
    }
    match lines.first() {
        Some((name, _)) => Err(format!("kinds.txt: there is no {name}")),
        None => Ok(text),
    }
}

fn call(function: &Function, kinds: &str) -> Result<String, String> {
    let mut kinds = kinds.split_whitespace();
    let (mut described, mut arguments) = (Vec::new(), Vec::new());
    for (i, parameter) in function.parameters.iter().enumerate() {
        let name = parameter.name.as_str();
        let kind = match (parameter.kind.as_str(), name) {
            ("size_t", "count") => "n",
            ("size_t", stride) if stride.ends_with("_stride") => "s",
            ("covbeam_poll", _) => "poll",
            ("covbeam_shade", _) => "shade",
            ("covbeam_probe", _) => "probe",
            (_, "user") => "user",
            _ => kinds.next().ok_or(format!("kinds.txt: {}: none for {name}", function.name))?,
        };
        described.push(format!("{name} {kind}"));
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
    if let Some(kind) = kinds.next() {
        return Err(format!("kinds.txt: {}: {kind} is too many", function.name));
    }
    let how = if function.returns == "void" { "FREE" } else { "CALL" };
    let (described, arguments) = (described.join("; "), arguments.join(", "));
    Ok(format!("{how}({}, \"{described}\", {arguments})\n", function.name))
}
