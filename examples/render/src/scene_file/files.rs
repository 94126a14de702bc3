//! Files that a scene names: where they are, and a hash of all of them.

use std::cell::RefCell;
use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};

use crate::scene_file::fields::{Field, SceneError};

/// The files beside a scene, and what was in those that it named so far. Readers get paths from here alone, so that no file of a scene is
/// left out of its fingerprint.
pub(crate) struct SceneFiles<'a> {
    folder: &'a Path,
    /// By the order in which they were named.
    named: RefCell<Vec<(PathBuf, io::Result<blake3::Hash>)>>,
}

impl<'a> SceneFiles<'a> {
    /// Paths are relative to the folder.
    pub(crate) fn beside(folder: &'a Path) -> Self {
        Self { folder, named: RefCell::default() }
    }

    /// The file that a field names; `kind`: of what, such as "an OBJ file".
    pub(crate) fn path(&self, field: &Field<'_>, kind: &str) -> Result<PathBuf, SceneError> {
        let name = field.text(&format!("the path of {kind} in quotes, relative to the scene file"))?;
        let path = self.folder.join(name);
        self.named.borrow_mut().push((path.clone(), hash(&path)));
        Ok(path)
    }

    /// What was in them, in the order in which they were named; a file that could not be hashed, and why.
    pub(crate) fn hashes(self) -> Result<Vec<blake3::Hash>, (PathBuf, io::Error)> {
        let named = self.named.into_inner().into_iter();
        named.map(|(path, hash)| hash.map_err(|error| (path, error))).collect()
    }
}

/// Of a regular file: a device or a pipe may never end.
fn hash(path: &Path) -> io::Result<blake3::Hash> {
    if !std::fs::metadata(path)?.is_file() {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, "not a regular file"));
    }
    let mut hasher = blake3::Hasher::new();
    hasher.update_reader(File::open(path)?)?;
    Ok(hasher.finalize())
}
