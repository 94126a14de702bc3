//! Files of sums and spectra: a header of JSON and binary records, each guarded by a CRC-32.
//!
//! A file holds the eight letters of its kind, the number of its format, the length and the CRC-32 of the header, the header, and the records:
//! each with its length and its CRC-32, which begins with the header's and the record's place. All numbers are little-endian.

use covbeam_session::film::Unfit;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// Most bytes of a header: that of a thousand pieces has some ten thousand.
const MOST_HEADER: u32 = 1 << 24;

/// A kind of file.
pub(crate) struct Kind {
    pub(crate) magic: &'static [u8; 8],
    pub(crate) format: u32,
    /// As messages call it.
    pub(crate) name: &'static str,
    /// The commands that write it.
    pub(crate) writers: &'static str,
}

/// Why a stored file is refused.
#[derive(Debug, thiserror::Error)]
#[error("'{path}': {reason}")]
pub struct StoredError {
    path: PathBuf,
    reason: Reason,
}

impl StoredError {
    pub(crate) fn new(path: &Path, reason: Reason) -> Self {
        Self { path: path.to_owned(), reason }
    }

    /// Whether the file was a good one once.
    pub fn is_damaged(&self) -> bool {
        matches!(self.reason, Reason::Damaged(_))
    }

    /// Whether the file is a good one, but not of this render.
    pub fn is_stranger(&self) -> bool {
        matches!(self.reason, Reason::Stranger(_))
    }
}

#[derive(Debug, thiserror::Error)]
pub(crate) enum Reason {
    #[error("cannot be read: {0}")]
    Io(#[from] io::Error),
    #[error("is no regular file; expected one that {0} wrote")]
    NotAFile(&'static str),
    #[error("is no {0}; expected a file that {1} wrote")]
    NoneSuch(&'static str, &'static str),
    #[error(
        "has format {found}, and this program reads format {known}; use the version of covbeam that wrote it"
    )]
    Format { found: u32, known: u32 },
    #[error("is damaged ({0}) and has to be made again")]
    Damaged(&'static str),
    #[error("{0}")]
    Stranger(String),
    #[error("has changed since its header was read; begin again when nothing writes it")]
    Changed,
    #[error("its sums are of another kind of film; render its passes again with this version of covbeam")]
    Misfit,
}

impl From<Unfit> for Reason {
    fn from(unfit: Unfit) -> Self {
        match unfit {
            Unfit::Layout => Self::Misfit,
            Unfit::Bytes => Self::Damaged("a record holds no numbers"),
        }
    }
}

/// Writes a header; returns its CRC.
pub(crate) fn write_header(file: &mut dyn Write, kind: &Kind, header: &impl Serialize) -> io::Result<u32> {
    let header = serde_json::to_vec(header)?;
    let crc = crc32fast::hash(&header);
    file.write_all(kind.magic)?;
    for number in [kind.format, header.len() as u32, crc] {
        file.write_all(&number.to_le_bytes())?;
    }
    file.write_all(&header)?;
    Ok(crc)
}

/// Writes the record of a place after the header with this CRC.
pub(crate) fn write_record(file: &mut dyn Write, header: u32, place: u32, record: &[u8]) -> io::Result<()> {
    file.write_all(&(record.len() as u32).to_le_bytes())?;
    file.write_all(&record_crc(header, place, record).to_le_bytes())?;
    file.write_all(record)
}

/// Of a record: also tells another file's, or another place's.
fn record_crc(header: u32, place: u32, record: &[u8]) -> u32 {
    let mut hasher = crc32fast::Hasher::new_with_initial(header);
    hasher.update(&place.to_le_bytes());
    hasher.update(record);
    hasher.finalize()
}

/// A file after its header.
pub(crate) struct Records {
    file: BufReader<File>,
    pub(crate) header: u32,
    place: u32,
}

/// Opens a file and reads its header.
pub(crate) fn open<H: DeserializeOwned>(path: &Path, kind: &Kind) -> Result<(H, Records), Reason> {
    // A device or a pipe may never end, or begin.
    if !std::fs::metadata(path)?.is_file() {
        return Err(Reason::NotAFile(kind.writers));
    }
    let mut file = BufReader::new(File::open(path)?);
    let mut magic = [0; 8];
    let none_such = || Reason::NoneSuch(kind.name, kind.writers);
    match file.read_exact(&mut magic) {
        Err(error) if error.kind() != io::ErrorKind::UnexpectedEof => return Err(error.into()),
        read => read.map_err(|_| none_such())?,
    }
    if magic != *kind.magic {
        return Err(none_such());
    }
    let found = read_number(&mut file)?;
    if found != kind.format {
        return Err(Reason::Format { found, known: kind.format });
    }
    let (length, crc) = (read_number(&mut file)?, read_number(&mut file)?);
    if length > MOST_HEADER {
        return Err(Reason::Damaged("its header is too long"));
    }
    let bytes = read_bytes(&mut file, length)?;
    if crc32fast::hash(&bytes) != crc {
        return Err(Reason::Damaged("its header"));
    }
    let header = serde_json::from_slice(&bytes).map_err(|_| Reason::Damaged("its header's fields"))?;
    Ok((header, Records { file, header: crc, place: 0 }))
}

impl Records {
    /// The next one, of at most so many bytes.
    pub(crate) fn next(&mut self, most: usize) -> Result<Vec<u8>, Reason> {
        let (length, crc) = (read_number(&mut self.file)?, read_number(&mut self.file)?);
        if length as usize > most {
            return Err(Reason::Damaged("a record is too long"));
        }
        let record = read_bytes(&mut self.file, length)?;
        let right = record_crc(self.header, self.place, &record) == crc;
        self.place += 1;
        if right { Ok(record) } else { Err(Reason::Damaged("a record")) }
    }

    /// Goes past records of these lengths.
    pub(crate) fn skip(&mut self, lengths: &[u32]) -> Result<(), Reason> {
        let bytes: u64 = lengths.iter().map(|length| 8 + u64::from(*length)).sum();
        self.file.seek(SeekFrom::Current(i64::try_from(bytes).unwrap_or(i64::MAX)))?;
        self.place += lengths.len() as u32;
        Ok(())
    }

    /// Whether all was read.
    pub(crate) fn end(mut self) -> Result<(), Reason> {
        match self.file.read(&mut [0])? {
            0 => Ok(()),
            _ => Err(Reason::Damaged("it goes on after its end")),
        }
    }
}

fn read_number(file: &mut impl Read) -> Result<u32, Reason> {
    let mut bytes = [0; 4];
    file.read_exact(&mut bytes).map_err(|error| match error.kind() {
        io::ErrorKind::UnexpectedEof => Reason::Damaged("it is cut off"),
        _ => error.into(),
    })?;
    Ok(u32::from_le_bytes(bytes))
}

fn read_bytes(file: &mut impl Read, length: u32) -> Result<Vec<u8>, Reason> {
    let mut bytes = Vec::new();
    let read = file.take(length.into()).read_to_end(&mut bytes)?;
    if read == length as usize { Ok(bytes) } else { Err(Reason::Damaged("it is cut off")) }
}
