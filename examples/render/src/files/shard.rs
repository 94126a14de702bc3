//! Some passes of a picture in a file: exact sums, that other passes can be added to with the same bits in any order and grouping.

pub use covbeam_session::film::passes::{PassRange, Passes};

use crate::files::output::{OutputError, RenderInfo, replace_file};
use crate::files::stored::{Kind, Reason, Records, StoredError, open, write_header, write_record};
use covbeam_session::film::{Film, FilmLayout};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

const KIND: Kind =
    Kind { magic: b"covshard", format: 2, name: "shard", writers: "`covbeam render` or `covbeam merge`" };

/// What all passes of a picture have in common: those of another origin are not added to them.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Origin {
    /// Version of the program.
    pub version: String,
    /// What its functions of mathematics give: see [`covbeam_session::work::arithmetic::arithmetic`].
    pub arithmetic: String,
    /// Name of the scene.
    pub scene: String,
    /// Of the scene file and of all files that it names: see [`covbeam_session::scene::scene_file::parse_with_fingerprint`].
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
    /// What is written into a picture of so many passes.
    pub fn info(&self, passes: u32) -> RenderInfo {
        let Self { method, photons, seed, scene, .. } = self;
        RenderInfo { method: method.clone(), passes, photons: *photons, seed: *seed, scene: scene.clone() }
    }

    /// What is different in `other`, in words; None: nothing.
    pub fn difference(&self, other: &Self) -> Option<String> {
        let size = |origin: &Self| format!("{} x {} pixels", origin.width, origin.height);
        let samples = |origin: &Self| origin.samples.map_or("none".to_owned(), |samples| samples.to_string());
        let yes = |flag: bool| if flag { "yes" } else { "no" }.to_owned();
        let all = [
            ("version", self.version.clone(), other.version.clone()),
            ("arithmetic (libm)", self.arithmetic.clone(), other.arithmetic.clone()),
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

/// Writes the sums of some passes: the whole file or nothing of it. The same sums give the same bytes.
///
/// # Errors
/// As [`replace_file`].
pub fn write_shard(path: &Path, origin: &Origin, passes: &Passes, film: &Film) -> Result<(), OutputError> {
    let header = Header { origin: origin.clone(), passes: passes.clone(), film: film.layout() };
    replace_file(path, |file| {
        let crc = write_header(file, &KIND, &header)?;
        let mut place = 0;
        film.store(|record| {
            place += 1;
            write_record(file, crc, place - 1, record)
        })
    })
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
    pub fn open(path: &Path) -> Result<Self, StoredError> {
        let (header, records) = open_sound(path).map_err(|reason| StoredError::new(path, reason))?;
        Ok(Self { path: path.to_owned(), header, crc: records.header })
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

    /// The refusal of a shard that is not what was asked for.
    pub fn stranger(&self, why: String) -> StoredError {
        StoredError::new(&self.path, Reason::Stranger(why))
    }

    /// A film without passes that its sums can be added to.
    pub fn film(&self) -> Film {
        Film::of_layout(&self.header.film)
    }

    /// Adds its sums to a film.
    ///
    /// # Errors
    /// A file that cannot be read, is damaged, has changed, or holds sums of another kind of film. The film is of no use then.
    pub fn add_to(&self, film: &mut Film) -> Result<(), StoredError> {
        self.add_records(film).map_err(|reason| StoredError::new(&self.path, reason))
    }

    fn add_records(&self, film: &mut Film) -> Result<(), Reason> {
        let (_, mut records) = open_sound(&self.path)?;
        if records.header != self.crc {
            return Err(Reason::Changed);
        }
        let Header { passes, film: layout, .. } = &self.header;
        let most = layout.most_bytes();
        film.add_stored(layout, [passes.count(), passes.odd_count()], || records.next(most))?;
        records.end()
    }
}

fn open_sound(path: &Path) -> Result<(Header, Records), Reason> {
    let (header, records) = open::<Header>(path, &KIND)?;
    let Header { origin, passes, film } = &header;
    let sound = passes.are_sound()
        && passes.count() > 0
        && film.is_sound()
        && film.is_of(origin.width, origin.height);
    if sound { Ok((header, records)) } else { Err(Reason::Damaged("its header's numbers")) }
}
