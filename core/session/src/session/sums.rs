//! Sums of passes as bytes: exact, so that those of many machines add up to the same bits in any order.
//!
//! `covsums2`, the length of a header and its CRC-32, the header (version and arithmetic, identity, passes, layout of the film), and the film's
//! records, each with its length and its CRC-32. All numbers are little-endian.

use crate::film::passes::{PassRange, Passes};
use crate::film::{Film, FilmLayout, Unfit};
use crate::work::arithmetic::arithmetic;
use crate::work::failure::{Failure, Result};
use std::convert::Infallible;

const MAGIC: &[u8; 8] = b"covsums2";

/// Of what pictures are made from: a hash of all that a host has given, or any 32 bytes that it tells its scenes apart by.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Identity(pub [u8; 32]);

/// Sums whose header has been read.
pub(super) struct Stored<'a> {
    pub(super) passes: Passes,
    layout: FilmLayout,
    records: Reader<'a>,
}

/// What passes must have in common to be added: what they are of, how many light paths each has, and whether those are plain.
pub(super) type Origin = (Identity, u32, bool);

/// The bytes of some passes.
pub(super) fn save((identity, photons, plain): &Origin, passes: &Passes, film: &Film) -> Vec<u8> {
    let mut header = Vec::new();
    put(&mut header, build());
    header.extend(identity.0);
    put(&mut header, *photons);
    put(&mut header, (*plain).into());
    put(&mut header, passes.ranges().len() as u32);
    for range in passes.ranges() {
        put(&mut header, range.start);
        put(&mut header, range.end);
    }
    film.layout().to_words().into_iter().for_each(|word| put(&mut header, word));
    let mut bytes = MAGIC.to_vec();
    put_record(&mut bytes, &header);
    let done: std::result::Result<(), Infallible> = film.store(|record| {
        put_record(&mut bytes, record);
        Ok(())
    });
    match done {
        Ok(()) => bytes,
        Err(never) => match never {},
    }
}

/// Reads what bytes hold.
///
/// # Errors
/// They are no sums, damaged, or of another picture than that of `identity`.
pub(super) fn open<'a>(bytes: &'a [u8], (identity, photons, plain): &Origin) -> Result<Stored<'a>> {
    let Some(rest) = bytes.strip_prefix(MAGIC) else {
        return Err(Failure::Data(
            "sums: these bytes are none; give those that a session of this version has saved".into(),
        ));
    };
    let mut records = Reader { bytes: rest };
    let mut header = Reader { bytes: records.record()? };
    if header.word()? != build() {
        let message =
            "sums: of another version of covbeam, or of a build with another libm; merge those of one build";
        return Err(Failure::Data(message.into()));
    }
    let same = header.take(identity.0.len())? == identity.0;
    if !(header.word()? == *photons && header.word()? == u32::from(*plain) && same) {
        let message = "sums: of another scene, or of other settings; merge those of the same picture";
        return Err(Failure::Data(message.into()));
    }
    let ranges = (0..header.word()?).map(|_| Ok(PassRange { start: header.word()?, end: header.word()? }));
    let passes = Passes::from(ranges.collect::<Result<Vec<_>>>()?);
    if !passes.are_sound() {
        return Err(damaged());
    }
    let words = header.bytes.as_chunks::<4>();
    let words: Vec<u32> = words.0.iter().map(|word| u32::from_le_bytes(*word)).collect();
    let layout = FilmLayout::from_words(&words).filter(FilmLayout::is_sound).ok_or_else(damaged)?;
    if passes.count() == 0 {
        return Err(damaged());
    }
    Ok(Stored { passes, layout, records })
}

impl Stored<'_> {
    /// Adds them to a film, which is of no use after an error.
    pub(super) fn add_to(mut self, film: &mut Film) -> Result<Passes> {
        let counts = [self.passes.count(), self.passes.odd_count()];
        film.add_stored(&self.layout, counts, || self.records.record().map(<[u8]>::to_vec))?;
        if self.records.bytes.is_empty() { Ok(self.passes) } else { Err(damaged()) }
    }
}

impl From<Unfit> for Failure {
    fn from(unfit: Unfit) -> Self {
        match unfit {
            Unfit::Layout => {
                Self::Data("sums: of another kind of picture; merge those of the same settings".into())
            }
            Unfit::Bytes => damaged(),
        }
    }
}

/// Of what makes the bits of passes.
fn build() -> u32 {
    let mut crc = crc32fast::Hasher::new();
    crc.update(env!("CARGO_PKG_VERSION").as_bytes());
    crc.update(&arithmetic().to_le_bytes());
    crc.finalize()
}

fn damaged() -> Failure {
    Failure::Data("sums: damaged; save them again".into())
}

fn put(bytes: &mut Vec<u8>, number: u32) {
    bytes.extend(number.to_le_bytes());
}

fn put_record(bytes: &mut Vec<u8>, record: &[u8]) {
    put(bytes, record.len() as u32);
    put(bytes, crc32fast::hash(record));
    bytes.extend(record);
}

/// Bytes from the next one on.
struct Reader<'a> {
    bytes: &'a [u8],
}

impl<'a> Reader<'a> {
    fn take(&mut self, count: usize) -> Result<&'a [u8]> {
        let (taken, rest) = self.bytes.split_at_checked(count).ok_or_else(damaged)?;
        self.bytes = rest;
        Ok(taken)
    }

    fn word(&mut self) -> Result<u32> {
        let bytes = self.take(4)?;
        Ok(u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]))
    }

    fn record(&mut self) -> Result<&'a [u8]> {
        let (length, crc) = (self.word()?, self.word()?);
        let record = self.take(length as usize)?;
        if crc32fast::hash(record) == crc { Ok(record) } else { Err(damaged()) }
    }
}
