//! `vectors/plain.h`: how the C client of `tests/vectors.txt` calls functions whose lines hold their
//! arguments word for word: on one element, and on all lines of a name at once.

use super::Headers;
use super::c::Function;
use super::kinds::{is_number, parameters};
use std::fmt::Write;

/// Families of functions whose lines are like that.
const FAMILIES: [&str; 5] = ["light_field_", "spectrum_", "image_", "phase_", "medium_"];

/// Of these: what is called by hand on one element, because the client asks more; and what is not plain.
const BY_HAND: [&str; 2] = ["medium_column_at", "medium_distance_at"];
const NOT_PLAIN: [&str; 1] = ["image_spectrum_along"];

/// A parameter of the function on one element.
struct Argument {
    /// `in`, `out`, both.
    direction: char,
    kind: String,
    name: String,
    value: bool,
}

/// The whole file.
pub(super) fn plain(headers: &Headers) -> Result<String, String> {
    let mut text =
        "/* Made from the headers by `cargo run -p covbeam-tests --bin header`; do not edit. */\n".to_owned();
    let (mut names, mut table) = (String::new(), String::new());
    for function in &headers.functions {
        let Some(single) = &function.single else { continue };
        let name = single.trim_start_matches("covbeam_");
        if !FAMILIES.iter().any(|family| name.starts_with(family)) || NOT_PLAIN.contains(&name) {
            continue;
        }
        let arguments = arguments(function)?;
        if !BY_HAND.contains(&name) {
            text += &one(single, &arguments)?;
            write!(names, " \\\n    CALL({name}),").unwrap();
        }
        text += &many(function, name, &arguments);
        table += &row(name, &arguments)?;
    }
    write!(text, "\n#define PLAIN_CALLS{}\n\n", names.trim_end_matches(',')).unwrap();
    writeln!(text, "#define PLAIN_PLURALS{}", table.trim_end_matches(',')).unwrap();
    Ok(text)
}

/// Arrays and what all elements share.
fn arguments(function: &Function) -> Result<Vec<Argument>, String> {
    let mut all: Vec<Argument> = Vec::new();
    for (parameter, kind) in parameters(function)? {
        match kind {
            "n" => {}
            "s" => {
                let last = all.last_mut().ok_or("a stride without an array")?;
                parameter.name.trim_end_matches("_stride").clone_into(&mut last.name);
            }
            _ => all.push(Argument {
                direction: kind.chars().next().unwrap_or_default(),
                kind: kind[1..].trim_end_matches('?').to_owned(),
                name: parameter.name.clone(),
                value: is_number(kind),
            }),
        }
    }
    Ok(all)
}

impl Argument {
    /// Words of an element in the file; 0: a byte.
    fn words(&self) -> Result<usize, String> {
        Ok(match self.kind.as_str() {
            "flag" => 0,
            "filter" => 3,
            "image" => 4,
            "curvature" | "spectrum" => 6,
            "derivatives" => 9,
            "field" | "medium" => 16,
            "phase" => 2,
            rules => rules.strip_prefix("f:").ok_or(format!("words of {rules}"))?.len(),
        })
    }

    fn shared(&self) -> bool {
        ["medium", "phase"].contains(&self.kind.as_str())
    }

    /// The variable that is an element.
    fn declaration(&self) -> String {
        let name = &self.name;
        match self.kind.as_str() {
            "flag" => format!("uint8_t {name} = 2"),
            "field" => format!("covbeam_light_field {name}"),
            "image" => format!("covbeam_image_spectrum {name}"),
            "filter" => format!("covbeam_image_filter {name}"),
            rules if rules.starts_with("f:") && rules.len() == 3 => format!("float {name}"),
            rules if rules.starts_with("f:") => format!("float {name}[{}]", rules.len() - 2),
            other => format!("covbeam_{other} {name}"),
        }
    }

    /// Its address.
    fn address(&self) -> String {
        if self.kind.starts_with("f:") && self.kind.len() > 3 {
            self.name.clone()
        } else {
            format!("&{}", self.name)
        }
    }
}

/// The call on one element.
fn one(single: &str, arguments: &[Argument]) -> Result<String, String> {
    let name = single.trim_start_matches("covbeam_");
    let mut text = format!("\nstatic void {name}(struct call *c)\n{{\n");
    for argument in arguments {
        writeln!(text, "    {};", argument.declaration()).unwrap();
    }
    for argument in arguments.iter().filter(|argument| argument.direction != '>') {
        match argument.kind.as_str() {
            "medium" => writeln!(text, "    {} = take_medium(c);", argument.name).unwrap(),
            _ => writeln!(text, "    take(c, {}, {});", argument.address(), argument.words()?).unwrap(),
        }
    }
    let given: Vec<String> =
        arguments.iter().map(|a| if a.value { a.name.clone() } else { a.address() }).collect();
    writeln!(text, "    must({single}({}));", given.join(", ")).unwrap();
    for argument in results(arguments) {
        match argument.kind.as_str() {
            "flag" => writeln!(text, "    give_flag(c, {});", argument.name).unwrap(),
            _ => writeln!(text, "    give(c, {}, {});", argument.address(), argument.words()?).unwrap(),
        }
    }
    Ok(text + "}\n")
}

/// In the order of the file: what a call returns, then what it changes.
fn results(arguments: &[Argument]) -> impl Iterator<Item = &Argument> {
    let of = |direction| arguments.iter().filter(move |argument| argument.direction == direction);
    of('>').chain(of('='))
}

/// The call on arrays.
fn many(function: &Function, name: &str, arguments: &[Argument]) -> String {
    let mut given: Vec<String> = Vec::new();
    let mut array = 0;
    for argument in arguments {
        if argument.shared() {
            given.push("common".to_owned());
        } else {
            given.push(format!("p[{array}], s[{array}]"));
            array += 1;
        }
    }
    // The count comes before the first array.
    let at = usize::from(arguments[0].shared());
    given.insert(at, "n".to_owned());
    let head =
        format!("static covbeam_status many_{name}(size_t n, const void *common, void **p, const size_t *s)");
    format!("\n{head}\n{{\n    (void)common;\n    return {}({});\n}}\n", function.name, given.join(", "))
}

/// The row of the table of plurals: see `plurals.c`.
fn row(name: &str, arguments: &[Argument]) -> Result<String, String> {
    let (mut common, mut word, mut arrays) = ("NONE, 0".to_owned(), 0, Vec::new());
    for argument in arguments {
        let words = argument.words()?;
        if argument.shared() {
            common = format!("{}, {word}", argument.kind.to_uppercase());
        } else {
            let out = match argument.direction {
                '<' => -1,
                _ => {
                    let before = results(arguments).take_while(|other| other.name != argument.name);
                    before
                        .map(|other| other.words().map(|words| words.max(1) as i32))
                        .sum::<Result<i32, _>>()?
                }
            };
            let place = if argument.direction == '>' { -1 } else { word as i32 };
            arrays.push(format!("{{ {place}, {out}, {words} }}"));
        }
        if argument.direction != '>' {
            word += words;
        }
    }
    let arrays = arrays.join(", ");
    Ok(format!(" \\\n    {{ \"{name}\", {common}, {{ {arrays} }}, many_{name} }},"))
}
