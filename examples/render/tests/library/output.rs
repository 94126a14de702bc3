//! Picture files: what is written is read back, and a failure leaves nothing half-written.

use covbeam_render::files::output::{
    OutputError, RenderInfo, check_writable, read_picture, replace_file, write_exr,
};
use covbeam_session::film::{Layers, Picture};
use glam::Vec3;
use std::fs;
use std::io::{self, Write};
use std::path::Path;

fn picture() -> Picture {
    let radiance =
        (0..48).map(|i| Vec3::new(i as f32 * 0.1, 1e-20 * i as f32, 1e20 / (i + 1) as f32)).collect();
    let layer = |scale: f32| (0..48).map(|i| scale * (i as f32).sqrt()).collect();
    let layers = Layers { radius: layer(0.01), sigma: layer(3.0), samples: layer(100.0) };
    Picture {
        width: 8,
        height: 6,
        radiance,
        error: None,
        layers: Some(layers),
        maps: None,
        kinds: Vec::new(),
    }
}

fn info() -> RenderInfo {
    RenderInfo { method: "ppb".into(), passes: 3, photons: 10, seed: 1, scene: "test".into() }
}

fn entries(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> =
        fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn an_exr_reads_back_bit_for_bit() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    write_exr(&path, &picture(), &info()).unwrap();
    assert_eq!(read_picture(&path).unwrap(), picture());
    assert_eq!(entries(folder.path()), ["a.exr"]);
}

#[test]
fn a_write_that_fails_half_way_keeps_the_old_file_and_leaves_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    fs::write(&path, "old").unwrap();
    let error = replace_file(&path, |file| {
        file.write_all(&[7; 5000])?;
        Err(io::ErrorKind::StorageFull.into())
    })
    .unwrap_err();
    let message = error.to_string();
    assert!(message.contains("a.exr") && message.contains("free some space"), "{message}");
    assert_eq!(fs::read(&path).unwrap(), b"old");
    assert_eq!(entries(folder.path()), ["a.exr"]);
}

#[test]
fn a_failed_first_write_leaves_no_file_at_all() {
    let folder = tempfile::tempdir().unwrap();
    let failed = replace_file(&folder.path().join("a.exr"), |_| Err(io::ErrorKind::Other.into()));
    assert!(failed.is_err());
    assert!(entries(folder.path()).is_empty());
}

/// The system's own "no space left on device", through the same writer.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_reported_with_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let error =
        replace_file(&path, |_| fs::OpenOptions::new().write(true).open("/dev/full")?.write_all(b"x"))
            .unwrap_err()
            .to_string();
    assert!(error.contains("a.exr") && error.contains("free some space"), "{error}");
    assert!(entries(folder.path()).is_empty());
}

#[test]
fn a_written_file_replaces_the_old_one() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a");
    fs::write(&path, "something much longer").unwrap();
    replace_file(&path, |file| file.write_all(b"new")).unwrap();
    assert_eq!(fs::read(&path).unwrap(), b"new");
}

#[test]
fn checking_a_path_changes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let (old, new) = (folder.path().join("old"), folder.path().join("new"));
    fs::write(&old, "old").unwrap();
    check_writable(&old).unwrap();
    check_writable(&new).unwrap();
    assert_eq!(fs::read(&old).unwrap(), b"old");
    assert_eq!(entries(folder.path()), ["old"]);
}

#[test]
fn a_missing_folder_a_file_as_folder_and_a_folder_as_file_are_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let missing = folder.path().join("missing/a.exr");
    let error = check_writable(&missing).unwrap_err();
    assert!(matches!(error, OutputError::NoFolder { .. }));
    assert!(
        error.to_string().contains("missing/a.exr") && error.to_string().contains("create it"),
        "{error}"
    );

    let file = folder.path().join("file");
    fs::write(&file, "").unwrap();
    assert!(matches!(check_writable(&file.join("a.exr")), Err(OutputError::NoFolder { .. })));
    assert!(matches!(check_writable(folder.path()), Err(OutputError::NotAFile(_))));
}

#[cfg(unix)]
#[test]
fn a_picture_is_as_readable_as_any_new_file() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().unwrap();
    let (plain, written) = (folder.path().join("plain"), folder.path().join("written"));
    fs::write(&plain, "").unwrap();
    replace_file(&written, |_| Ok(())).unwrap();
    let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode();
    assert_eq!(mode(&written), mode(&plain));
}

#[test]
fn a_picture_that_cannot_be_read_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let missing = read_picture(&folder.path().join("missing.exr")).unwrap_err().to_string();
    assert!(missing.contains("missing.exr"), "{missing}");
    let text = folder.path().join("text.exr");
    fs::write(&text, "this is no picture").unwrap();
    let error = read_picture(&text).unwrap_err().to_string();
    assert!(error.contains("text.exr") && error.contains("expected an OpenEXR picture"), "{error}");
}
