//! Declarations in C, as cbindgen writes them.

use super::inline::single;

/// A declaration with the comment before it.
pub(super) struct Item {
    /// As it stands in the header, without what only the makers of headers read.
    comment: String,
    code: String,
    /// Whether it belongs into the second header.
    pub(super) extra: bool,
    pub(super) function: Option<Function>,
}

/// A function that the library exports.
pub struct Function {
    /// The text of its comment, line by line.
    pub doc: Vec<String>,
    /// What it returns.
    pub returns: String,
    /// Its name.
    pub name: String,
    /// What it takes.
    pub parameters: Vec<Parameter>,
    /// The inline function that calls it for one element.
    pub single: Option<String>,
    /// What its parameters are: see `parameters`.
    pub kinds: Vec<String>,
}

/// A parameter of a function.
pub struct Parameter {
    /// With all stars.
    pub kind: String,
    /// Its name.
    pub name: String,
}

impl Item {
    pub(super) fn text(&self) -> Result<String, String> {
        let inline = self.function.as_ref().map_or(Ok(String::new()), single)?;
        Ok([&self.comment, &self.code, &inline].map(String::as_str).concat())
    }
}

/// Takes a part of a header apart, at its empty lines.
pub(super) fn items(text: &str) -> Result<Vec<Item>, String> {
    text.trim_end().split("\n\n").map(item).collect()
}

fn item(text: &str) -> Result<Item, String> {
    let (comment, code) = match text.split_once("*/\n") {
        Some((comment, code)) if text.starts_with("/**\n") => (comment, code),
        _ => ("", text),
    };
    let mut doc: Vec<String> = Vec::new();
    let (mut extra, mut single, mut kinds) = (false, None, Vec::new());
    for line in comment.lines().skip(1) {
        let line = line.trim_start().trim_start_matches('*').strip_prefix(' ').unwrap_or_default();
        if line == "@extra" {
            extra = true;
        } else if let Some(name) = line.strip_prefix("@single ") {
            single = Some(name.to_owned());
        } else if let Some(all) = line.strip_prefix("@kinds ") {
            kinds = all.split(' ').map(str::to_owned).collect();
        } else {
            doc.push(line.to_owned());
        }
    }
    while doc.last().is_some_and(String::is_empty) {
        doc.pop();
    }
    let mut lines = String::new();
    for line in &doc {
        lines += format!(" * {line}").trim_end();
        lines += "\n";
    }
    let comment = if doc.is_empty() { String::new() } else { format!("/**\n{lines} */\n") };
    let mut function = function(code)?;
    if let Some(function) = &mut function {
        (function.doc, function.single, function.kinds) = (doc, single, kinds);
    }
    Ok(Item { comment, code: code.to_owned(), extra, function })
}

/// A function, if the code is a declaration of one.
fn function(code: &str) -> Result<Option<Function>, String> {
    let one_line = code.split_whitespace().collect::<Vec<_>>().join(" ");
    let Some(inside) = one_line.strip_suffix(");").filter(|_| !one_line.starts_with("typedef")) else {
        return Ok(None);
    };
    let (head, inside) = inside.split_once('(').ok_or(format!("no parameters: {code}"))?;
    let (returns, name) = typed(head)?;
    let parameters = inside
        .split(", ")
        .filter(|parameter| *parameter != "void")
        .map(|parameter| typed(parameter).map(|(kind, name)| Parameter { kind, name }))
        .collect::<Result<_, _>>()?;
    let (doc, kinds) = (Vec::new(), Vec::new());
    Ok(Some(Function { doc, returns, name, parameters, single: None, kinds }))
}

/// A type and the name that it is given.
pub(super) fn typed(text: &str) -> Result<(String, String), String> {
    let at = text.rfind([' ', '*']).ok_or(format!("no type: {text}"))?;
    Ok((text[..=at].trim_end().to_owned(), text[at + 1..].to_owned()))
}
