//! Reads density volumes: Mitsuba's grid volume format, version 3 (`.vol`). (The one reader of OpenVDB in
//! Rust panics on hostile bytes and reserves memory that the file only claims.)
//!
//! | bytes | type | what |
//! |---|---|---|
//! | 0..3 | | the letters `VOL` |
//! | 3 | u8 | version, 3 |
//! | 4..8 | i32 | how densities are written: 1 = f32, 3 = u8, where 255 means density 1 |
//! | 8..20 | 3 i32 | voxels along x, y and z |
//! | 20..24 | i32 | channels, 1 |
//! | 24..48 | 6 f32 | the box: xmin, ymin, zmin, xmax, ymax, zmax |
//! | 48.. | | the densities, x fastest, then y, then z; nothing after them |
//!
//! All numbers are little-endian. Densities are at the centres of voxels, as in Mitsuba 3. From Python:
//!
//! ```python
//! import struct, numpy
//! density = numpy.zeros((nz, ny, nx), "<f4")
//! with open("smoke.vol", "wb") as file:
//!     file.write(b"VOL\3" + struct.pack("<5i6f", 1, nx, ny, nz, 1, *box_min, *box_max) + density.tobytes())
//! ```
//!
//! OpenVDB files are not read: vdb-rs 0.6, the reader that Rust has, panics or allocates what a damaged file
//! asks for. OpenVDB's own Python module turns one into numbers: `grid.copyToArray(array)` fills
//! `array[x, y, z]`, so the `density` above is `array.transpose()`.

use std::fmt;
use std::fs::File;
use std::io::Read;
use std::path::Path;

use covbeam::GridLayout;
use covbeam_geometry::MAX_COORDINATE;
use glam::Vec3;

/// Most voxels of a volume: 64 MiB of densities.
pub const MAX_VOXELS: u32 = 1 << 24;
/// Largest density, and largest density x extinction coefficient.
pub const MAX_DENSITY: f32 = 1e9;

const HEADER_BYTES: usize = 48;
/// Densities are decoded through a buffer of this many bytes, a multiple of every encoding's size.
const CHUNK_BYTES: usize = 1 << 16;

/// Relative densities on a grid of voxels. Cloning copies them.
#[derive(Clone, PartialEq)]
pub struct Volume {
    /// Box and resolution; voxels at least 1e-9 wide, coordinates within ±1e9, at most [`MAX_VOXELS`].
    pub layout: GridLayout,
    /// Densities at the voxels' centres, each in 0..=[`MAX_DENSITY`], x first, then y, then z. All of them may be 0,
    /// as in the first frame of a simulation.
    pub values: Vec<f32>,
}

impl fmt::Debug for Volume {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let GridLayout { min, max, cells: [x, y, z] } = self.layout;
        write!(f, "Volume {{ {x} x {y} x {z} voxels, {min}..{max} }}")
    }
}

/// Why a volume was refused.
#[derive(Debug, thiserror::Error)]
pub enum VolumeError {
    /// The file could not be read, or became shorter meanwhile.
    #[error("cannot be read: {0}")]
    Unreadable(#[from] std::io::Error),
    /// A directory, a device or a pipe.
    #[error("is not a regular file")]
    NotAFile,
    /// Too short for a header.
    #[error(
        "has {0} bytes, expected at least the {HEADER_BYTES} of the header of a .vol file: write the file again"
    )]
    NoHeader(u64),
    /// Another format.
    #[error(
        "starts with {}, expected \"VOL\": only Mitsuba's .vol files are read, so convert OpenVDB and others",
        .0.escape_ascii()
    )]
    NotAVolume([u8; 3]),
    /// Another version of the format.
    #[error("has version {0} of the .vol format, expected version 3: export it with Mitsuba 3")]
    Version(u8),
    /// Densities in another form.
    #[error("has encoding {0}, expected 1 (float32) or 3 (uint8): export the densities as float32")]
    Encoding(i32),
    /// A colour or a vector per voxel.
    #[error("has {0} channels, expected 1: export the density alone; colour comes from the medium")]
    Channels(i32),
    /// No voxels, or a negative number of them.
    #[error("has {} x {} x {} voxels, expected at least 1 along each axis: export it again", .0[0], .0[1], .0[2])]
    Resolution([i32; 3]),
    /// More than [`MAX_VOXELS`].
    #[error(
        "has {} x {} x {} voxels, expected at most {MAX_VOXELS} together: export it at a lower resolution",
        .0[0], .0[1], .0[2]
    )]
    TooLarge([i32; 3]),
    /// Cut off, or with something after the last voxel.
    #[error("has {found} bytes, expected {expected} for {} x {} x {} voxels: the file is {}",
        cells[0], cells[1], cells[2],
        if found < expected { "cut off, copy or export it again" } else { "too long, export it again" }
    )]
    Length {
        /// The file's length.
        found: u64,
        /// Header and voxels together.
        expected: u64,
        /// Voxels along x, y, z.
        cells: [u32; 3],
    },
    /// Empty, not finite, too large or too small.
    #[error(
        "has the box {min} to {max}, expected coordinates within ±1e9 and voxels at least 1e-9 wide: give `min` \
         and `max` beside `file`"
    )]
    Box {
        /// Lower corner.
        min: Vec3,
        /// Upper corner.
        max: Vec3,
    },
    /// A density that is negative, NaN, infinite or above [`MAX_DENSITY`].
    #[error(
        "has density {found} in voxel [{}, {}, {}] (number {index}), expected 0..=1e9: clamp the densities or scale \
         them down before the export",
        voxel[0], voxel[1], voxel[2]
    )]
    Density {
        /// What the file says.
        found: f32,
        /// Where along x, y and z, counted from 0.
        voxel: [u32; 3],
        /// Where in the file's list of densities, counted from 0.
        index: usize,
    },
}

impl Volume {
    /// Reads a `.vol` file.
    ///
    /// - `corners`: lower and upper corner of the box instead of the file's own.
    ///
    /// Guarantee: resolution, box and the file's length are checked before densities are read, so memory is at most
    /// 4 bytes a voxel that the file holds, and never above 65 MiB.
    ///
    /// Errors: every file gives a volume or a [`VolumeError`]; test `any_bytes_are_a_volume_or_an_error`.
    pub fn load(path: &Path, corners: Option<(Vec3, Vec3)>) -> Result<Self, VolumeError> {
        // A device or a pipe may never end.
        if !std::fs::metadata(path)?.is_file() {
            return Err(VolumeError::NotAFile);
        }
        let file = File::open(path)?;
        let length = file.metadata()?.len();
        Self::read(file, length, corners)
    }

    /// Reads the bytes of a `.vol` file; parameters, guarantee and errors as in [`Volume::load`].
    pub fn parse(bytes: &[u8], corners: Option<(Vec3, Vec3)>) -> Result<Self, VolumeError> {
        Self::read(bytes, bytes.len() as u64, corners)
    }

    /// Reads a source that is `length` bytes long.
    fn read(mut source: impl Read, length: u64, corners: Option<(Vec3, Vec3)>) -> Result<Self, VolumeError> {
        let mut header = [0; HEADER_BYTES];
        let available = length.min(HEADER_BYTES as u64) as usize;
        source.read_exact(&mut header[..available])?;
        let (layout, encoding) = read_header(&header, length, corners)?;

        let count = layout.cell_count();
        let mut values = Vec::with_capacity(count);
        let mut chunk = vec![0; CHUNK_BYTES.min(count * encoding.bytes())];
        while values.len() < count {
            let wanted = chunk.len().min((count - values.len()) * encoding.bytes());
            source.read_exact(&mut chunk[..wanted])?;
            encoding.decode(&chunk[..wanted], &mut values);
        }
        // False for NaN.
        let sound = |value: &f32| (0.0..=MAX_DENSITY).contains(value);
        if let Some(index) = values.iter().position(|value| !sound(value)) {
            let [x, y, _] = layout.cells.map(|cells| cells as usize);
            let voxel = [index % x, index / x % y, index / x / y].map(|place| place as u32);
            return Err(VolumeError::Density { found: values[index], voxel, index });
        }
        Ok(Self { layout, values })
    }

    /// The largest density.
    pub fn largest(&self) -> f32 {
        self.values.iter().copied().fold(0.0, f32::max)
    }
}

/// How a density is written.
#[derive(Clone, Copy)]
enum Encoding {
    Float32,
    Uint8,
}

impl Encoding {
    fn bytes(self) -> usize {
        match self {
            Self::Float32 => 4,
            Self::Uint8 => 1,
        }
    }

    fn decode(self, bytes: &[u8], values: &mut Vec<f32>) {
        match self {
            Self::Float32 => {
                values.extend(bytes.chunks_exact(4).map(|four| f32::from_le_bytes(word(four, 0))))
            }
            Self::Uint8 => values.extend(bytes.iter().map(|&byte| f32::from(byte) / 255.0)),
        }
    }
}

/// Checks everything that the header says, against the length of the whole file too.
fn read_header(
    header: &[u8; HEADER_BYTES],
    length: u64,
    corners: Option<(Vec3, Vec3)>,
) -> Result<(GridLayout, Encoding), VolumeError> {
    let magic = [header[0], header[1], header[2]];
    if length >= 3 && magic != *b"VOL" {
        return Err(VolumeError::NotAVolume(magic));
    }
    if length < HEADER_BYTES as u64 {
        return Err(VolumeError::NoHeader(length));
    }
    if header[3] != 3 {
        return Err(VolumeError::Version(header[3]));
    }
    let integer = |at| i32::from_le_bytes(word(header, at));
    let encoding = match integer(4) {
        1 => Encoding::Float32,
        3 => Encoding::Uint8,
        other => return Err(VolumeError::Encoding(other)),
    };
    if integer(20) != 1 {
        return Err(VolumeError::Channels(integer(20)));
    }
    let resolution = [integer(8), integer(12), integer(16)];
    let cells = resolution.map(|cells| u32::try_from(cells).unwrap_or(0));
    // Three factors of up to 2^31 do not fit in u64.
    let count: u128 = cells.iter().map(|&cells| u128::from(cells)).product();
    if count == 0 {
        return Err(VolumeError::Resolution(resolution));
    }
    if count > u128::from(MAX_VOXELS) {
        return Err(VolumeError::TooLarge(resolution));
    }
    let expected = HEADER_BYTES as u64 + count as u64 * encoding.bytes() as u64;
    if length != expected {
        return Err(VolumeError::Length { found: length, expected, cells });
    }

    let corner = |at| {
        let coordinate = |at| f32::from_le_bytes(word(header, at));
        Vec3::new(coordinate(at), coordinate(at + 4), coordinate(at + 8))
    };
    let (min, max) = corners.unwrap_or((corner(24), corner(36)));
    let voxel = (max.as_dvec3() - min.as_dvec3()) / glam::UVec3::from(cells).as_dvec3();
    let within = |corner: Vec3| corner.to_array().iter().all(|x| x.abs() <= MAX_COORDINATE);
    // False for NaN.
    let wide = |width: &f64| *width >= f64::from(1.0 / MAX_COORDINATE);
    if !(within(min) && within(max) && voxel.to_array().iter().all(wide)) {
        return Err(VolumeError::Box { min, max });
    }
    Ok((GridLayout { min, max, cells }, encoding))
}

/// Four bytes from `at`, which lies at least four before the end.
fn word(bytes: &[u8], at: usize) -> [u8; 4] {
    [bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]]
}
