//! What the parameters of functions are, for the programs that call them without knowing them: `hostile/kinds.txt`.

use super::c::{Function, Parameter};
use std::collections::BTreeMap;

/// The kinds of the parameters of each function that have none by name and type.
pub(super) struct Kinds<'a>(BTreeMap<&'a str, Vec<&'a str>>);

impl<'a> Kinds<'a> {
    /// A line a function: its name, and its kinds.
    pub(super) fn read(text: &'a str) -> Self {
        let lines = text.lines().filter(|line| !line.is_empty() && !line.starts_with('#'));
        Self(
            lines
                .map(|line| {
                    let mut words = line.split(' ');
                    (words.next().unwrap_or_default(), words.collect())
                })
                .collect(),
        )
    }

    /// Whether all of them are of functions that there are.
    pub(super) fn check(&self, functions: &[Function]) -> Result<(), String> {
        match self.0.keys().find(|name| functions.iter().all(|function| function.name != **name)) {
            Some(name) => Err(format!("kinds.txt: there is no {name}")),
            None => Ok(()),
        }
    }
}

/// The parameters of a function, each with its kind.
pub(super) fn parameters<'a>(
    function: &'a Function,
    kinds: &Kinds<'a>,
) -> Result<Vec<(&'a Parameter, &'a str)>, String> {
    let name = &function.name;
    let mut given = kinds.0.get(name.as_str()).ok_or(format!("kinds.txt: no {name}"))?.iter();
    let mut all = Vec::new();
    for parameter in &function.parameters {
        let kind = match (parameter.kind.as_str(), parameter.name.as_str()) {
            ("size_t", "count") => "n",
            ("size_t", stride) if stride.ends_with("_stride") => "s",
            ("covbeam_poll", _) => "poll",
            ("covbeam_shade", _) => "shade",
            ("covbeam_probe", _) => "probe",
            (_, "user") => "user",
            _ => given.next().ok_or(format!("kinds.txt: {name}: none for {}", parameter.name))?,
        };
        all.push((parameter, kind));
    }
    match given.next() {
        Some(kind) => Err(format!("kinds.txt: {name}: {kind} is too many")),
        None => Ok(all),
    }
}
