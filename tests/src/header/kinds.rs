//! What the parameters of functions are, for the programs that call them without knowing them.
//!
//! A line `@kinds` of a function's comment has a kind for each parameter but for counts of arrays, strides,
//! callbacks and their user pointers, which have theirs by name and type:
//!
//! - `n` count of the arrays after it; `s` stride of the array before; `k` number of elements of the packed
//!   array before
//! - `$R` a float under rule R; `#shape`, `#pass`, `#extent` (of a picture), `#row` (its first), `#any` an
//!   integer
//! - `@KIND` a handle that is looked at, `!KIND` one that is changed, `+KIND` place for a new one; `.STATE`
//!   it must be in
//! - `<TYPE` read, `>TYPE` written, `=TYPE` both; TYPE a struct of `tests/clients/hostile/types.c`, or
//!   `f:RULES` floats
//! - `?` may be NULL
//!
//! The rules are those of `types.c`.

use super::c::{Function, Parameter};

/// The parameters of a function, each with its kind.
pub(super) fn parameters(function: &Function) -> Result<Vec<(&Parameter, &str)>, String> {
    let mut given = function.kinds.iter();
    let mut all = Vec::new();
    for parameter in &function.parameters {
        let kind = match (parameter.kind.as_str(), parameter.name.as_str()) {
            ("size_t", "count") => "n",
            ("size_t", stride) if stride.ends_with("_stride") => "s",
            ("covbeam_poll", _) => "poll",
            ("covbeam_shade", _) => "shade",
            ("covbeam_probe", _) => "probe",
            (_, "user") => "user",
            _ => given.next().ok_or(format!("{}: no kind for {}", function.name, parameter.name))?,
        };
        all.push((parameter, kind));
    }
    match given.next() {
        Some(kind) => Err(format!("{}: the kind {kind} is too many", function.name)),
        None => Ok(all),
    }
}

/// Whether an element of an input array is one number.
pub(super) fn is_number(kind: &str) -> bool {
    kind == "<word" || kind.strip_prefix("<f:").is_some_and(|rules| rules.len() == 1)
}
