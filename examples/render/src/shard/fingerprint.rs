//! Whether two renders are of the same scene: a hash of all that its files say.

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};

/// Why there is no fingerprint.
#[derive(Debug, thiserror::Error)]
pub enum FingerprintError {
    /// The text is no TOML.
    #[error("the scene has no fingerprint: {0}")]
    Syntax(#[from] toml::de::Error),
    /// A mesh or a volume cannot be read.
    #[error("'{path}': cannot be read: {source}")]
    File {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
}

/// What a picture is not another one for, or what is told apart by name: they may change between two renders of a scene.
const TOLD_ELSEWHERE: [&str; 3] = ["passes", "photons", "seed"];

/// BLAKE3 of a scene's values, whatever their layout and comments, and of the bytes of the files that it names, which are looked up in
/// `base_dir`: 64 hexadecimal digits.
///
/// # Errors
/// No TOML, or a file that cannot be read.
pub fn fingerprint(text: &str, base_dir: &Path) -> Result<String, FingerprintError> {
    let mut scene: toml::Table = text.parse()?;
    if let Some(render) = scene.get_mut("render").and_then(toml::Value::as_table_mut) {
        TOLD_ELSEWHERE.iter().for_each(|field| drop(render.remove(*field)));
        if render.is_empty() {
            scene.remove("render");
        }
    }
    let mut hasher = blake3::Hasher::new();
    let values = scene.to_string();
    hasher.update(&(values.len() as u64).to_le_bytes());
    hasher.update(values.as_bytes());
    hash_files(&toml::Value::Table(scene), base_dir, &mut hasher)?;
    Ok(hasher.finalize().to_hex().to_string())
}

/// Adds the files that are named by fields `file`, in the order of the fields.
fn hash_files(
    value: &toml::Value,
    base_dir: &Path,
    hasher: &mut blake3::Hasher,
) -> Result<(), FingerprintError> {
    match value {
        toml::Value::Array(values) => values.iter().try_for_each(|value| hash_files(value, base_dir, hasher)),
        toml::Value::Table(fields) => fields.iter().try_for_each(|(name, value)| match value {
            toml::Value::String(file) if name == "file" => hash_file(&base_dir.join(file), hasher),
            other => hash_files(other, base_dir, hasher),
        }),
        _ => Ok(()),
    }
}

fn hash_file(path: &Path, hasher: &mut blake3::Hasher) -> Result<(), FingerprintError> {
    let mut own = blake3::Hasher::new();
    let read = File::open(path).and_then(|file| own.update_reader(file).map(drop));
    read.map_err(|source| FingerprintError::File { path: path.to_owned(), source })?;
    hasher.update(own.finalize().as_bytes());
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_changes_with_every_value_and_every_file_but_not_with_what_is_no_value() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("a.obj"), "one").unwrap();
        let of = |text: &str| fingerprint(text, folder.path()).unwrap();
        let text = "[camera]\nwidth = 4\n[[object]]\nfile = \"a.obj\"\n[render]\nalpha = 0.5\nseed = 1\n";
        let first = of(text);
        assert_eq!(first.len(), 64);
        let laid_out = "# A scene.\n[render]\nseed = 2\npasses = 9\nalpha = 5e-1\n[camera]\nwidth = 0x4\n[[object]]\nfile = 'a.obj'\n";
        assert_eq!(of(laid_out), first);
        for (from, to) in [("width = 4", "width = 5"), ("alpha = 0.5", "alpha = 0.6"), ("camera", "camera2")]
        {
            assert_ne!(of(&text.replace(from, to)), first, "{to}");
        }
        std::fs::write(folder.path().join("a.obj"), "two").unwrap();
        assert_ne!(of(text), first);
        let missing = fingerprint("file = 'b.obj'", folder.path()).unwrap_err().to_string();
        assert!(missing.contains("b.obj"), "{missing}");
    }
}
