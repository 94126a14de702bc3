//! Guards over the sources themselves: nothing public in the core without a test that names it.

use std::{fs, path::Path};

/// A public function: the type that it belongs to, empty for a free one, and its name.
#[derive(Debug, PartialEq)]
struct Function {
    owner: String,
    name: String,
}

fn identifier(text: &str) -> &str {
    let end = text.find(|c: char| !(c.is_alphanumeric() || c == '_')).unwrap_or(text.len());
    &text[..end]
}

/// The part of a source file before its unit tests, and the unit tests.
fn split(source: &str) -> (&str, &str) {
    source.split_at(source.find("#[cfg(test)]").unwrap_or(source.len()))
}

/// Public functions, by line: `impl` blocks of rustfmt's layout start and end in the first column.
fn public_functions(source: &str) -> Vec<Function> {
    let mut functions = Vec::new();
    let mut owner = String::new();
    for line in split(source).0.lines() {
        if let Some(header) = line.strip_prefix("impl") {
            // `impl<'a> Type<'a> {` and `impl Type {`; an `impl Trait for Type` has no `pub fn`.
            let header = match header.strip_prefix('<') {
                Some(generic) => generic.split_once('>').map_or("", |(_, rest)| rest),
                None => header,
            };
            owner = identifier(header.trim_start()).to_owned();
        }
        if line == "}" || line.starts_with("impl") && line.ends_with("{}") {
            owner.clear();
        }
        let line = line.trim_start();
        let rest = ["pub fn ", "pub const fn "].iter().find_map(|start| line.strip_prefix(start));
        if let Some(rest) = rest {
            functions.push(Function { owner: owner.clone(), name: identifier(rest).to_owned() });
        }
    }
    functions
}

/// The code inside the ``` blocks of doc comments.
fn doctests(source: &str) -> String {
    let mut code = String::new();
    let mut inside = false;
    for line in source.lines() {
        let Some(doc) = line.trim_start().strip_prefix("///").or(line.trim_start().strip_prefix("//!"))
        else {
            inside = false;
            continue;
        };
        if doc.trim_start().starts_with("```") {
            inside = !inside;
        } else if inside {
            code.push_str(doc);
            code.push('\n');
        }
    }
    code
}

/// Whether `text` calls the function, as `Type::name`, `.name(` beside the type's own name, or `name(` for a free one.
fn mentions(text: &str, function: &Function) -> bool {
    let Function { owner, name } = function;
    let part_of_word = |c: char| c.is_alphanumeric() || c == '_';
    let found = |pattern: &str| {
        text.match_indices(pattern).any(|(start, _)| {
            let (before, after) = (&text[..start], &text[start + pattern.len()..]);
            let inside_word = before.ends_with(part_of_word) || after.starts_with(part_of_word);
            !(inside_word || owner.is_empty() && before.ends_with('.'))
        })
    };
    if owner.is_empty() {
        found(name) && text.contains(&format!("{name}("))
    } else {
        found(&format!("{owner}::{name}")) || (found(owner) && text.contains(&format!(".{name}(")))
    }
}

/// All Rust sources below a folder: their paths in it, and texts.
fn rust_files(folder: &Path) -> Vec<(String, String)> {
    files_below(folder, folder)
}

fn files_below(root: &Path, folder: &Path) -> Vec<(String, String)> {
    let mut files = Vec::new();
    for entry in fs::read_dir(folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display())) {
        let path = entry.unwrap().path();
        if path.is_dir() {
            files.extend(files_below(root, &path));
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            let name = path.strip_prefix(root).unwrap().to_string_lossy().into_owned();
            files.push((name, fs::read_to_string(&path).unwrap()));
        }
    }
    files.sort();
    files
}

#[test]
fn every_public_function_of_the_core_is_named_in_a_test() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let sources = rust_files(&root.join("../core/src"));
    let mut tests: Vec<String> = rust_files(&root.join("tests"))
        .into_iter()
        // That its name is listed says nothing about what a function returns.
        .filter(|(file, _)| file != "house/guards.rs")
        .map(|(_, text)| text)
        .collect();
    for (_, source) in &sources {
        tests.push(split(source).1.to_owned());
        tests.push(doctests(source));
    }
    let mut count = 0;
    let mut missing = Vec::new();
    for (file, source) in &sources {
        for function in public_functions(source) {
            count += 1;
            if !tests.iter().any(|text| mentions(text, &function)) {
                missing.push(format!("{file}: {}::{}", function.owner, function.name));
            }
        }
    }
    assert!(count > 30, "only {count} public functions found: has the sources' layout changed?");
    assert!(missing.is_empty(), "public functions that no test names:\n{}", missing.join("\n"));
}

#[test]
fn the_scan_finds_functions_and_tells_a_mention_from_a_lookalike() {
    let source = "\
impl<'a> Lens<'a> {
    /// ```
    /// Lens::focus(2.0);
    /// ```
    pub fn focus(&self) {}
    pub const fn power() {}
    fn hidden() {}
}

pub fn bend() {}
#[cfg(test)]
mod tests { pub fn helper() {} }
";
    let function = |owner: &str, name: &str| Function { owner: owner.into(), name: name.into() };
    assert_eq!(
        public_functions(source),
        [function("Lens", "focus"), function("Lens", "power"), function("", "bend")]
    );
    assert!(mentions(&doctests(source), &function("Lens", "focus")));
    assert!(!mentions(&doctests(source), &function("Lens", "power")));
    assert!(mentions("let lens: Lens = x; lens.power()", &function("Lens", "power")));
    assert!(!mentions("let lens: Other = x; lens.power()", &function("Lens", "power")));
    assert!(!mentions("Lens::powerful()", &function("Lens", "power")));
    assert!(!mentions("OtherLens::power()", &function("Lens", "power")));
    assert!(mentions("let x = bend(1);", &function("", "bend")));
    assert!(!mentions("unbend(1); tree.bend(1); bending(2)", &function("", "bend")));
}
