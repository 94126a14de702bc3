//! Some passes of a picture in a file: exact sums, that other passes can be added to with the same bits in any order and grouping.
//!
//! A file holds `covshard`, the number of its format, the length and the CRC-32 of a header, the header as JSON, and the film's records: each
//! with its length and its CRC-32, which begins with the header's and the record's place. All numbers are little-endian.

mod fingerprint;
mod passes;
pub(crate) mod planes;

pub use fingerprint::{FingerprintError, fingerprint};
pub use passes::{PassRange, Passes};

use crate::film::{Film, FilmLayout, Unfit};
use crate::output::{OutputError, replace_file};
use serde::{Deserialize, Serialize};
use std::fs::File;
use std::io::{self, BufReader, Read};
use std::path::{Path, PathBuf};

const MAGIC: &[u8; 8] = b"covshard";
const FORMAT: u32 = 1;
/// Most bytes of a header: that of a thousand pieces has some ten thousand.
const MOST_HEADER: u32 = 1 << 24;

/// What all passes of a picture have in common: those of another origin are not added to them.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Origin {
    /// Version of the program.
    pub version: String,
    /// Name of the scene.
    pub scene: String,
    /// [`fingerprint`] of the scene file and of the meshes and volumes that it names.
    pub fingerprint: String,
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// How the picture is made.
    pub method: String,
    /// Light paths a pass.
    pub photons: u32,
    /// Seed.
    pub seed: u32,
    /// Whether each pass has an eye ray through every pixel.
    pub every_pixel: bool,
    /// Shadow rays a pixel, of the method `march`.
    pub samples: Option<u32>,
    /// Whether the kinds of light are kept apart.
    pub light_passes: bool,
}

impl Origin {
    /// What is different in `other`, in words; None: nothing.
    pub fn difference(&self, other: &Self) -> Option<String> {
        let size = |origin: &Self| format!("{} x {} pixels", origin.width, origin.height);
        let samples = |origin: &Self| origin.samples.map_or("none".to_owned(), |samples| samples.to_string());
        let yes = |flag: bool| if flag { "yes" } else { "no" }.to_owned();
        let all = [
            ("version", self.version.clone(), other.version.clone()),
            ("scene", self.scene.clone(), other.scene.clone()),
            ("picture", size(self), size(other)),
            ("method", self.method.clone(), other.method.clone()),
            ("light paths a pass", self.photons.to_string(), other.photons.to_string()),
            ("seed", self.seed.to_string(), other.seed.to_string()),
            ("--every-pixel", yes(self.every_pixel), yes(other.every_pixel)),
            ("--samples", samples(self), samples(other)),
            ("--light-passes", yes(self.light_passes), yes(other.light_passes)),
            ("fingerprint of the scene's files", self.fingerprint.clone(), other.fingerprint.clone()),
        ];
        let different = all.into_iter().filter(|(_, own, other)| own != other);
        let words: Vec<String> =
            different.map(|(what, own, other)| format!("{what} {own}, not {other}")).collect();
        (!words.is_empty()).then(|| words.join("; "))
    }
}

#[derive(Serialize, Deserialize)]
struct Header {
    origin: Origin,
    passes: Passes,
    film: FilmLayout,
}

/// Why a shard is refused.
#[derive(Debug, thiserror::Error)]
#[error("'{path}': {reason}")]
pub struct ShardError {
    path: PathBuf,
    reason: Reason,
}

impl ShardError {
    /// Whether the file was a shard once.
    pub fn is_damaged(&self) -> bool {
        matches!(self.reason, Reason::Damaged(_))
    }
}

#[derive(Debug, thiserror::Error)]
enum Reason {
    #[error("cannot be read: {0}")]
    Io(#[from] io::Error),
    #[error("is no shard; expected a file that `covbeam render` or `covbeam merge` wrote")]
    NoShard,
    #[error(
        "has format {0}, and this program reads format {FORMAT}; use the version of covbeam that wrote it"
    )]
    Format(u32),
    #[error("is damaged ({0}); render its passes again")]
    Damaged(&'static str),
    #[error("has changed since its header was read; begin again when nothing writes it")]
    Changed,
    #[error("its sums are of another kind of film; render its passes again with this version of covbeam")]
    Misfit,
}

impl From<Unfit> for Reason {
    fn from(unfit: Unfit) -> Self {
        match unfit {
            Unfit::Layout => Self::Misfit,
            Unfit::Bytes => Self::Damaged("a record holds no sums"),
        }
    }
}

/// Writes the sums of some passes: the whole file or nothing of it. The same sums give the same bytes.
///
/// # Errors
/// As [`replace_file`].
pub fn write_shard(path: &Path, origin: &Origin, passes: &Passes, film: &Film) -> Result<(), OutputError> {
    let header = Header { origin: origin.clone(), passes: passes.clone(), film: film.layout() };
    replace_file(path, |file| {
        let header = serde_json::to_vec(&header)?;
        let crc = crc32fast::hash(&header);
        file.write_all(MAGIC)?;
        for number in [FORMAT, header.len() as u32, crc] {
            file.write_all(&number.to_le_bytes())?;
        }
        file.write_all(&header)?;
        let mut place = 0;
        film.store(|record| {
            file.write_all(&(record.len() as u32).to_le_bytes())?;
            file.write_all(&record_crc(crc, place, record).to_le_bytes())?;
            place += 1;
            file.write_all(record)
        })
    })
}

/// Of a record: also tells another shard's, or another place's.
fn record_crc(header: u32, place: u32, record: &[u8]) -> u32 {
    let mut hasher = crc32fast::Hasher::new_with_initial(header);
    hasher.update(&place.to_le_bytes());
    hasher.update(record);
    hasher.finalize()
}

/// A shard whose header was read. Its file is closed: there may be more shards than files that may be open.
pub struct Shard {
    path: PathBuf,
    header: Header,
    crc: u32,
}

impl Shard {
    /// Reads what it holds; its sums are read by [`Shard::add_to`].
    ///
    /// # Errors
    /// A file that cannot be read, is no shard, or is damaged.
    pub fn open(path: &Path) -> Result<Self, ShardError> {
        let read = open(path).and_then(|mut file| read_header(&mut file));
        let (header, crc) = read.map_err(|reason| ShardError { path: path.to_owned(), reason })?;
        Ok(Self { path: path.to_owned(), header, crc })
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// What its passes are of.
    pub fn origin(&self) -> &Origin {
        &self.header.origin
    }

    /// Its passes.
    pub fn passes(&self) -> &Passes {
        &self.header.passes
    }

    /// A film without passes that its sums can be added to.
    pub fn film(&self) -> Film {
        Film::of_layout(&self.header.film)
    }

    /// Adds its sums to a film.
    ///
    /// # Errors
    /// A file that cannot be read, is damaged, has changed, or holds sums of another kind of film. The film is of no use then.
    pub fn add_to(&self, film: &mut Film) -> Result<(), ShardError> {
        self.add_records(film).map_err(|reason| ShardError { path: self.path.clone(), reason })
    }

    fn add_records(&self, film: &mut Film) -> Result<(), Reason> {
        let mut file = open(&self.path)?;
        if read_header(&mut file)?.1 != self.crc {
            return Err(Reason::Changed);
        }
        let Header { passes, film: layout, .. } = &self.header;
        let (mut place, most) = (0, layout.most_bytes());
        film.add_stored(layout, [passes.count(), passes.odd_count()], || {
            let record = read_record(&mut file, most, self.crc, place)?;
            place += 1;
            Ok::<_, Reason>(record)
        })?;
        match file.read(&mut [0])? {
            0 => Ok(()),
            _ => Err(Reason::Damaged("it goes on after its end")),
        }
    }
}

fn open(path: &Path) -> Result<BufReader<File>, Reason> {
    Ok(BufReader::new(File::open(path)?))
}

fn read_header(file: &mut impl Read) -> Result<(Header, u32), Reason> {
    let mut magic = [0; 8];
    match file.read_exact(&mut magic) {
        Err(error) if error.kind() != io::ErrorKind::UnexpectedEof => return Err(error.into()),
        read => read.map_err(|_| Reason::NoShard)?,
    }
    if magic != *MAGIC {
        return Err(Reason::NoShard);
    }
    let format = read_number(file)?;
    if format != FORMAT {
        return Err(Reason::Format(format));
    }
    let (length, crc) = (read_number(file)?, read_number(file)?);
    if length > MOST_HEADER {
        return Err(Reason::Damaged("its header is too long"));
    }
    let bytes = read_bytes(file, length)?;
    if crc32fast::hash(&bytes) != crc {
        return Err(Reason::Damaged("its header"));
    }
    let header: Header =
        serde_json::from_slice(&bytes).map_err(|_| Reason::Damaged("its header's fields"))?;
    let Header { origin, passes, film } = &header;
    let sound = passes.are_sound()
        && passes.count() > 0
        && film.is_sound()
        && film.is_of(origin.width, origin.height);
    if sound { Ok((header, crc)) } else { Err(Reason::Damaged("its header's numbers")) }
}

fn read_record(file: &mut impl Read, most: usize, header: u32, place: u32) -> Result<Vec<u8>, Reason> {
    let (length, crc) = (read_number(file)?, read_number(file)?);
    if length as usize > most {
        return Err(Reason::Damaged("a record is too long"));
    }
    let record = read_bytes(file, length)?;
    if record_crc(header, place, &record) == crc { Ok(record) } else { Err(Reason::Damaged("a record")) }
}

fn read_number(file: &mut impl Read) -> Result<u32, Reason> {
    let mut bytes = [0; 4];
    file.read_exact(&mut bytes).map_err(cut)?;
    Ok(u32::from_le_bytes(bytes))
}

fn read_bytes(file: &mut impl Read, length: u32) -> Result<Vec<u8>, Reason> {
    let mut bytes = Vec::new();
    let read = file.take(length.into()).read_to_end(&mut bytes)?;
    if read == length as usize { Ok(bytes) } else { Err(Reason::Damaged("it is cut off")) }
}

fn cut(error: io::Error) -> Reason {
    if error.kind() == io::ErrorKind::UnexpectedEof { Reason::Damaged("it is cut off") } else { error.into() }
}
