//! Inline functions for one element, from the functions on arrays.

use super::c::{Function, Parameter};

/// Longest line.
const WIDTH: usize = 110;

/// The inline function that calls `function` for one element, after an empty line; nothing if it has none.
///
/// An array and its stride, `directions` and `direction_stride`, become one pointer, `direction`, or a number by value.
pub(super) fn single(function: &Function) -> String {
    let Some((name, values)) = &function.single else { return String::new() };
    let mut parameters = Vec::new();
    let mut arguments = Vec::new();
    let mut of = function.parameters.iter().peekable();
    while let Some(Parameter { kind, name }) = of.next() {
        if name == "count" {
            arguments.push("1".to_owned());
            continue;
        }
        let stride = of.next_if(|next| next.name.ends_with("_stride"));
        let name = stride.map_or(name.as_str(), |next| next.name.trim_end_matches("_stride"));
        if values.iter().any(|value| value == name) {
            let number = kind.trim_start_matches("const ").trim_end_matches(" *");
            parameters.push(format!("{number} {name}"));
            arguments.push(format!("&{name}"));
        } else {
            let space = if kind.ends_with('*') { "" } else { " " };
            parameters.push(format!("{kind}{space}{name}"));
            arguments.push(name.to_owned());
        }
        if stride.is_some() {
            arguments.push("0".to_owned());
        }
    }
    let head = wrapped(&format!("static inline {} {name}(", function.returns), &parameters, ")");
    let call = wrapped(&format!("    return {}(", function.name), &arguments, ");");
    format!("\n\n{head}\n{{\n{call}\n}}")
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
