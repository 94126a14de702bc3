//! Picture files: EXR with layers, a PNG preview, and writing that never leaves half a file.

use crate::files::exr_format;
pub use crate::files::exr_format::RenderInfo;
use crate::files::maps::Bitmap;
use crate::files::preview::preview;
use covbeam_session::film::Picture;
use covbeam_session::scene::MAX_IMAGE_SIDE;
use std::fs::File;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// Why a file cannot be written or read.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    /// The folder is missing.
    #[error("cannot write '{path}': the folder '{folder}' does not exist; create it or choose another --out")]
    NoFolder {
        /// The file.
        path: PathBuf,
        /// Its folder.
        folder: PathBuf,
    },
    /// Something that cannot be replaced by a file.
    #[error("cannot write '{0}': it exists and is not a regular file; choose another --out")]
    NotAFile(PathBuf),
    /// Somebody else wrote it.
    #[error(
        "'{0}' was written by another render meanwhile, and this one ends, so that no work is lost; wait for the other, or choose another --out"
    )]
    Taken(PathBuf),
    /// The operating system refused.
    #[error("cannot write '{path}': {source}; {remedy}")]
    Write {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
        /// What to do.
        remedy: &'static str,
    },
    /// The picture cannot be encoded.
    #[error("cannot encode '{path}': {message}")]
    Encode {
        /// The file.
        path: PathBuf,
        /// Why.
        message: String,
    },
    /// The picture cannot be read.
    #[error("cannot read '{path}': {message}")]
    Read {
        /// The file.
        path: PathBuf,
        /// Why, and what was expected.
        message: String,
    },
}

/// Checks that `path` can be written, by creating and removing a temporary file beside it.
/// Call it before hours of rendering. A file that is already there stays as it is.
///
/// # Errors
/// The folder is missing or read-only, or `path` is a folder or a device, or longer than names may be.
pub fn check_writable(path: &Path) -> Result<(), OutputError> {
    create_beside(path).map(drop)
}

/// Writes `path` through a temporary file in the same folder that is renamed once it is complete and on the disk:
/// whatever fails, `path` holds either what it held before or all of the new content, and nothing else is left.
///
/// # Errors
/// As [`check_writable`], and whatever `write` or the disk reports (full, quota, removed).
pub fn replace_file(
    path: &Path,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), OutputError> {
    replace_with(path, |file| write(file).map_err(|source| write_error(path, source)))
}

fn replace_with(
    path: &Path,
    write: impl FnOnce(&mut File) -> Result<(), OutputError>,
) -> Result<(), OutputError> {
    let mut file = create_beside(path)?;
    write(file.as_file_mut())?;
    file.as_file().sync_all().map_err(|source| write_error(path, source))?;
    file.persist(path).map_err(|refused| write_error(path, refused.error))?;
    Ok(())
}

fn create_beside(path: &Path) -> Result<NamedTempFile, OutputError> {
    // The folder of a bare file name is "", which means the current one.
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if !folder.is_dir() {
        return Err(OutputError::NoFolder { path: path.to_owned(), folder: folder.to_owned() });
    }
    match std::fs::metadata(path) {
        // A device such as /dev/null must not be renamed over.
        Ok(there) if !there.is_file() => return Err(OutputError::NotAFile(path.to_owned())),
        // A name that is too long is found out by asking for it: the temporary file's is not.
        Err(error) if error.kind() == io::ErrorKind::InvalidFilename => return Err(write_error(path, error)),
        _ => {}
    }
    let mut builder = tempfile::Builder::new();
    builder.prefix(".covbeam-");
    #[cfg(unix)]
    {
        // A picture is no secret: readable as the user's umask says, not for the owner only.
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    builder.tempfile_in(folder).map_err(|source| write_error(path, source))
}

fn write_error(path: &Path, source: io::Error) -> OutputError {
    let remedy = match source.kind() {
        io::ErrorKind::PermissionDenied | io::ErrorKind::ReadOnlyFilesystem => {
            "choose a folder that you may write to, with --out"
        }
        io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded | io::ErrorKind::FileTooLarge => {
            "free some space or choose another disk with --out"
        }
        io::ErrorKind::InvalidFilename => "choose a shorter name with --out",
        _ => "check the folder or choose another with --out",
    };
    OutputError::Write { path: path.to_owned(), source, remedy }
}

/// Writes the picture as EXR: channels R, G, B (linear, Rec. 709 primaries, radiance in W/(m² sr)) and, where the
/// picture has layers, `radius.Y`, `sigma.Y`, `samples.Y`; where its eye rays were planned, `volume.R`, `volume.G`, `volume.B`,
/// `filter.xx`, `filter.xy`, `filter.yy` \[pixels²\] and `density.Y` \[eye rays a pixel and pass\], these four after the layer's kind of light and a dash
/// where there are several, as in `straight-filter.xx`; where the film keeps the kinds of light apart, `straight.R` to `scattered.B`, whose sum
/// is the picture. All f32, bit for bit, ZIP-compressed. The same picture and `info` give the same bytes.
///
/// # Errors
/// As [`replace_file`].
pub fn write_exr(path: &Path, picture: &Picture, info: &RenderInfo) -> Result<(), OutputError> {
    replace_with(path, |file| {
        exr_format::encode(picture, info, file).map_err(|error| match error {
            exr::error::Error::Io(source) => write_error(path, source),
            other => OutputError::Encode { path: path.to_owned(), message: other.to_string() },
        })
    })
}

/// Reads the picture of an EXR, of covbeam or of another renderer: channels R, G, B or, if there is no R, Y (grey);
/// 16-bit, 32-bit float or integer; the layers of [`write_exr`] where they are.
///
/// # Errors
/// No such file, no EXR, no such channels, or a picture that is cropped (its data window is not its display window):
/// the message says which, and what was expected.
pub fn read_picture(path: &Path) -> Result<Picture, OutputError> {
    read_picture_up_to(path, u64::from(MAX_IMAGE_SIDE).pow(2))
}

/// The same of a picture of so many pixels at most.
pub(crate) fn read_picture_up_to(path: &Path, most: u64) -> Result<Picture, OutputError> {
    std::fs::read(path)
        .map_err(|error| error.to_string())
        .and_then(|bytes| exr_format::decode(&bytes, most))
        .map_err(|message| OutputError::Read { path: path.to_owned(), message })
}

/// Writes the preview of a picture as PNG (see [`preview()`]).
///
/// # Errors
/// As [`replace_file`].
pub fn write_png(path: &Path, picture: &Picture) -> Result<(), OutputError> {
    let bytes = preview(picture);
    write_bitmap(path, &Bitmap { width: picture.width, height: picture.height, bytes })
}

/// Writes a bitmap as PNG.
///
/// # Errors
/// As [`replace_file`].
pub fn write_bitmap(path: &Path, bitmap: &Bitmap) -> Result<(), OutputError> {
    let bytes = encode_png(bitmap)
        .map_err(|error| OutputError::Encode { path: path.to_owned(), message: error.to_string() })?;
    replace_file(path, |file| file.write_all(&bytes))
}

/// A bitmap as the bytes of a PNG.
///
/// # Errors
/// What the encoder says: no pixels, or not as many as width x height.
pub fn encode_png(bitmap: &Bitmap) -> Result<Vec<u8>, png::EncodingError> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, bitmap.width, bitmap.height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    encoder.write_header().and_then(|mut writer| writer.write_image_data(&bitmap.bytes))?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    fn picture(width: u32, radiance: Vec<Vec3>) -> Picture {
        Picture { width, height: radiance.len() as u32 / width, radiance, ..Picture::default() }
    }

    #[test]
    fn a_png_decodes_to_the_preview() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        let ramp = picture(3, (0..6).map(|i| Vec3::new(i as f32, 1.0, 0.5)).collect());
        write_png(&path, &ramp).unwrap();
        let file = std::io::BufReader::new(std::fs::File::open(&path).unwrap());
        let mut reader = png::Decoder::new(file).read_info().unwrap();
        let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut bytes).unwrap();
        assert_eq!((info.width, info.height, info.color_type), (3, 2, png::ColorType::Rgb));
        assert_eq!(bytes, preview(&ramp));
    }

    #[test]
    fn a_device_is_not_replaced_by_a_file() {
        let error = replace_file(Path::new("/dev/full"), |file| file.write_all(b"x")).unwrap_err();
        assert!(matches!(error, OutputError::NotAFile(_)), "{error}");
    }
}
