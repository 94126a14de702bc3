//! Inline functions for one element, from the functions on arrays.

use super::c::{Function, Parameter};
use super::kinds::{is_number, parameters};

/// Longest line.
const WIDTH: usize = 110;

/// The inline function that calls `function` for one element, after an empty line; nothing if it has none.
///
/// An array and its stride, `directions` and `direction_stride`, become one pointer, `direction`, or a number
/// by value.
pub(super) fn single(function: &Function) -> Result<String, String> {
    let Some(name) = &function.single else { return Ok(String::new()) };
    let mut declared = Vec::new();
    let mut given = Vec::new();
    let all = parameters(function)?;
    let mut of = all.into_iter().peekable();
    while let Some((Parameter { kind, name }, what)) = of.next() {
        if what == "n" {
            given.push("1".to_owned());
            continue;
        }
        let stride = of.next_if(|(_, next)| *next == "s");
        let name = stride.map_or(name.as_str(), |(next, _)| next.name.trim_end_matches("_stride"));
        if stride.is_some() && is_number(what) {
            let number = kind.trim_start_matches("const ").trim_end_matches(" *");
            declared.push(format!("{number} {name}"));
            given.push(format!("&{name}"));
        } else {
            let space = if kind.ends_with('*') { "" } else { " " };
            declared.push(format!("{kind}{space}{name}"));
            given.push(name.to_owned());
        }
        if stride.is_some() {
            given.push("0".to_owned());
        }
    }
    let head = wrapped(&format!("static inline {} {name}(", function.returns), &declared, ")");
    let call = wrapped(&format!("    return {}(", function.name), &given, ");");
    Ok(format!("\n\n{head}\n{{\n{call}\n}}"))
}

/// A list, broken before what does not fit into a line.
fn wrapped(start: &str, list: &[String], end: &str) -> String {
    let (mut text, mut column) = (start.to_owned(), start.len());
    for (i, entry) in list.iter().enumerate() {
        let after = if i + 1 < list.len() { "," } else { end };
        if i > 0 && column + 1 + entry.len() + after.len() > WIDTH {
            text += &format!("\n{:1$}", "", start.len());
            column = start.len();
        } else if i > 0 {
            text += " ";
            column += 1;
        }
        text += entry;
        text += after;
        column += entry.len() + after.len();
    }
    text
}
