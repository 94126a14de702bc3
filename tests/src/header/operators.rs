//! The operators of light fields elsewhere: their forwarding in `covbeam.hpp`, and how the client of
//! `tests/vectors.txt` in C++ and the program without std call them.

use super::Headers;
use super::c::Function;
use super::kinds::parameters;
use std::fmt::Write;

/// What is made stands in `covbeam.hpp` between these, of the members and of the functions for many.
const FROM: &str = "// Made by `cargo run -p covbeam-tests --bin header`:\n";
const TO: &str = "// As far as it is made.";

/// A function that changes a field, and returns nothing else.
struct Operator<'a> {
    name: &'a str,
    single: &'a str,
    arrays: &'a str,
    /// After the field.
    arguments: Vec<Argument<'a>>,
}

struct Argument<'a> {
    one: &'a str,
    many: &'a str,
    of: Of,
}

/// What an element of an argument is.
enum Of {
    Floats(usize),
    /// May be left out.
    Curvature,
}

/// Those whose arguments are numbers, vectors and curvatures.
fn operators(headers: &Headers) -> Result<Vec<Operator<'_>>, String> {
    let mut all = Vec::new();
    for function in &headers.functions {
        all.extend(operator(function)?);
    }
    Ok(all)
}

fn operator(function: &Function) -> Result<Option<Operator<'_>>, String> {
    let Some(name) = function.name.strip_prefix("covbeam_light_fields_") else { return Ok(None) };
    let Some(single) = &function.single else { return Ok(None) };
    let (mut changes, mut many, mut arguments) = (false, "", Vec::new());
    let mut of = None;
    for (parameter, kind) in parameters(function)? {
        match kind {
            "n" => {}
            "=field" => changes = true,
            "<curvature?" => (many, of) = (&parameter.name, Some(Of::Curvature)),
            "s" => {
                let one = parameter.name.trim_end_matches("_stride");
                arguments.extend(of.take().map(|of| Argument { one, many, of }));
            }
            _ => match kind.strip_prefix("<f:") {
                Some(rules) => (many, of) = (&parameter.name, Some(Of::Floats(rules.len()))),
                None => return Ok(None),
            },
        }
    }
    let operator = Operator { name, single, arrays: &function.name, arguments };
    Ok(Some(operator).filter(|_| changes))
}

/// `covbeam.hpp` with what is made of it made anew.
pub(super) fn forwarding(hpp: &str, headers: &Headers) -> Result<String, String> {
    let operators = operators(headers)?;
    let mut parts = hpp.split_inclusive(FROM);
    let mut text = parts.next().unwrap_or_default().to_owned();
    for (part, make) in parts.zip([member as fn(&Operator) -> String, plural]) {
        let (_, rest) = part.split_once(TO).ok_or("covbeam.hpp: no end of what is made")?;
        let indent = text.lines().last().map_or(0, |line| line.len() - line.trim_start().len());
        text.extend(operators.iter().map(make));
        write!(text, "{:indent$}{TO}{rest}", "").unwrap();
    }
    Ok(text)
}

/// What a parameter of a member is called: not like a field of the struct.
fn beside_fields(name: &str) -> String {
    let fields = ["root", "x_axis", "direction"];
    if fields.contains(&name) { format!("new_{name}") } else { name.to_owned() }
}

/// The member for one field.
fn member(operator: &Operator) -> String {
    let Operator { name, single, arguments, .. } = operator;
    let parameters: Vec<String> = arguments
        .iter()
        .map(|Argument { one, of, .. }| match (of, beside_fields(one)) {
            (Of::Floats(1), name) => format!("float {name}"),
            (Of::Floats(_), name) => format!("const float* {name}"),
            (Of::Curvature, name) => format!("const covbeam_curvature* {name} = nullptr"),
        })
        .collect();
    let given: String =
        arguments.iter().map(|argument| format!(", {}", beside_fields(argument.one))).collect();
    format!("    void {name}({}) {{\n        check({single}(this{given}));\n    }}\n", parameters.join(", "))
}

/// The function for many.
fn plural(operator: &Operator) -> String {
    let Operator { name, arrays, arguments, .. } = operator;
    let parameters: String = arguments
        .iter()
        .map(|Argument { many, of, .. }| match of {
            Of::Floats(1) => format!(", Floats {many}"),
            Of::Floats(3) => format!(", Vectors {many}"),
            Of::Floats(count) => format!(", Strided<const float, {count}> {many}"),
            Of::Curvature => format!(", Curvatures {many} = Curvatures()"),
        })
        .collect();
    let given: String = arguments.iter().map(|argument| format!(", {}", argument.many)).collect();
    format!(
        "inline void {name}(Fields fields{parameters}) {{\n    detail::each({arrays}, fields{given});\n}}\n"
    )
}

/// `vectors/operators.hpp`: the calls of the client.
pub(super) fn replay(headers: &Headers) -> Result<String, String> {
    let mut text =
        "// Made from the headers by `cargo run -p covbeam-tests --bin header`; do not edit.\n".to_owned();
    for Operator { name, arguments, .. } in operators(headers)? {
        let (mut taken, mut given, mut rows, mut word) = (String::new(), Vec::new(), String::new(), 16);
        for (i, argument) in arguments.iter().enumerate() {
            let (take, give, row, words) = match argument.of {
                Of::Floats(1) => ("f()".to_owned(), format!("a{i}"), format!("f({word})"), 1),
                Of::Floats(count) => {
                    let row = if count == 3 {
                        format!("v({word})")
                    } else {
                        format!("get<float, {count}>({word})")
                    };
                    (format!("take<std::array<float, {count}>>()"), format!("a{i}.data()"), row, count)
                }
                Of::Curvature => {
                    let kind = "covbeam_curvature";
                    (format!("take<{kind}>()"), format!("&a{i}"), format!("get<{kind}>({word})"), 6)
                }
            };
            write!(taken, "const auto a{i} = in.{take}; ").unwrap();
            given.push(give);
            write!(rows, ", r.{row}").unwrap();
            word += words;
        }
        writeln!(
            text,
            "changes(\"light_field_{name}\", [](Field& f, In& in) {{ {taken}f.{name}({}); }},\n        \
             [](Rows& r) {{ many::{name}(r.fields(){rows}); }});",
            given.join(", ")
        )
        .unwrap();
    }
    Ok(text)
}

/// `bare-metal/src/operators.rs`: the calls of the core.
pub(super) fn bare_metal(headers: &Headers) -> Result<String, String> {
    let mut text = include_str!("operators.txt").to_owned();
    for Operator { name, arguments, .. } in operators(headers)? {
        let taken: Vec<&str> = arguments
            .iter()
            .map(|argument| match argument.of {
                Of::Floats(1) => "i.float()?",
                Of::Floats(3) => "i.vector()?",
                Of::Floats(_) => "&i.floats()?",
                Of::Curvature => "&i.curvature()?",
            })
            .collect();
        writeln!(text, "        b\"light_field_{name}\" => field.{name}({}),", taken.join(", ")).unwrap();
    }
    Ok(text + "        _ => return None,\n    }\n    Some(())\n}\n")
}
