//! A film's sums as numbers in a file: band by band, so that neither writing them nor adding them to another film needs a second one.

use super::{Film, FogLayer};
use crate::film::planes::{MOST_BYTES, NoRun, RUN, put, take};
use crate::kind::{Kind, Split};
use crate::plan::LayerFilters;
use covbeam::{FilmFilterNode, FilmLattice, FilmSums};
use rayon::prelude::*;
use std::array::from_fn;
use std::sync::Arc;

/// Pixels that are written together.
const BAND: usize = 256 * RUN;

/// Ways to split light into layers, in the order of their numbers.
const SPLITS: [Split; 3] = [Split::TOGETHER, Split::STRAIGHT_APART, Split::EACH];

/// Bands that are encoded or decoded at a time.
const BANDS_AT_A_TIME: usize = 32;

/// What the sums are of: all that has a size, or that they mean nothing without.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct FilmLayout {
    width: u32,
    height: u32,
    /// Bits of the typical radiance that the film's unit comes from.
    typical: u32,
    /// Whether there are sums over pairs.
    gather: bool,
    /// How the kinds of light are split into layers, where they are kept apart.
    kinds: Option<Split>,
    /// Of the latest pass, for each layer of fog: its light, and the number of the pass.
    fog: Vec<(Option<Kind>, u32)>,
}

/// Why stored sums cannot be added.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unfit {
    /// They are of another kind of film.
    Layout,
    /// Their bytes are not those of sums.
    Bytes,
}

impl From<NoRun> for Unfit {
    fn from(_: NoRun) -> Self {
        Self::Bytes
    }
}

impl FilmLayout {
    fn pixels(&self) -> usize {
        self.width as usize * self.height as usize
    }

    /// Whether the film has this size.
    pub fn is_of(&self, width: u32, height: u32) -> bool {
        (self.width, self.height) == (width, height)
    }

    /// Most bytes of a record.
    pub fn most_bytes(&self) -> usize {
        let fog = self.fog.len() * (6 + 1 + 1 + 1);
        let planes = 6 + fog + if self.gather { 4 } else { 0 } + if self.kinds.is_some() { 18 } else { 0 };
        let nodes = FilmLattice::new(self.width, self.height).map_or(0, |lattice| 24 * lattice.node_count());
        (planes * MOST_BYTES * BAND.min(self.pixels()).div_ceil(RUN)).max(nodes)
    }

    /// Whether a film can be like this: a file may say anything.
    pub fn is_sound(&self) -> bool {
        let side = 1..=crate::scene::MAX_IMAGE_SIDE;
        let typical = f32::from_bits(self.typical);
        side.contains(&self.width)
            && side.contains(&self.height)
            && (typical.is_finite() && typical >= 0.0)
            && self.kinds.is_none_or(|kinds| SPLITS.contains(&kinds))
            && self.fog.len() <= self.kinds.map_or(1, Split::count)
            && self.fog.iter().all(|(_, pass)| *pass > 0)
    }

    /// As numbers, for [`FilmLayout::from_words`].
    pub fn to_words(&self) -> Vec<u32> {
        let split =
            |split: Split| SPLITS.iter().position(|known| *known == split).map_or(0, |at| at as u32 + 1);
        let kind = |kind: Option<Kind>| kind.map_or(0, |kind| kind as u32 + 1);
        let head = [self.width, self.height, self.typical, self.gather.into(), self.kinds.map_or(0, split)];
        let fog = self.fog.iter().flat_map(|&(light, pass)| [kind(light), pass]);
        head.into_iter().chain(fog).collect()
    }

    /// What [`FilmLayout::to_words`] has made; None: no such numbers.
    pub fn from_words(words: &[u32]) -> Option<Self> {
        let (&[width, height, typical, gather, split], fog) = words.split_first_chunk()?;
        let (fog, []) = fog.as_chunks::<2>() else { return None };
        let at = |number: u32| (number as usize).checked_sub(1);
        let kinds = match at(split) {
            Some(split) => Some(*SPLITS.get(split)?),
            None => None,
        };
        let layer = |&[light, pass]: &[u32; 2]| match at(light) {
            Some(kind) => Some((Some(*Kind::ALL.get(kind)?), pass)),
            None => Some((None, pass)),
        };
        let fog = fog.iter().map(layer).collect::<Option<_>>()?;
        (gather <= 1).then_some(Self { width, height, typical, gather: gather == 1, kinds, fog })
    }

    /// Whether sums of both can be added.
    fn fits(&self, other: &Self) -> bool {
        let kinds = |layout: &Self| layout.fog.iter().map(|(kind, _)| *kind).collect::<Vec<_>>();
        kinds(self) == kinds(other)
            && Self { fog: Vec::new(), ..self.clone() } == Self { fog: Vec::new(), ..other.clone() }
    }
}

/// The sums of some pixels, to be added to.
struct Band<'a> {
    own: &'a mut [FilmSums],
    fog: Vec<FogBand<'a>>,
    gather: &'a mut [[i64; 4]],
    kinds: &'a mut [[FilmSums; 3]],
}

struct FogBand<'a> {
    sums: &'a mut [FilmSums],
    density: &'a mut [u64],
    /// What the stored sums' latest pass had.
    latest_density: &'a mut [f32],
    latest_regions: &'a mut [u32],
}

/// The filters of the latest pass that stored sums hold.
struct Latest {
    density: Vec<f32>,
    regions: Vec<u32>,
}

impl Film {
    /// What its sums are of.
    pub fn layout(&self) -> FilmLayout {
        FilmLayout {
            width: self.width,
            height: self.height,
            typical: self.typical.to_bits(),
            gather: !self.gather.is_empty(),
            kinds: self.split,
            fog: self.fog.iter().map(|layer| (layer.latest.kind, layer.latest.pass)).collect(),
        }
    }

    /// A film without passes that such sums can be added to.
    pub fn of_layout(layout: &FilmLayout) -> Self {
        let mut film = Self::of_radiance(layout.width, layout.height, f32::from_bits(layout.typical));
        film.split = layout.kinds;
        film
    }

    /// Calls `write` with each of the records that hold the sums, in order.
    pub fn store<E>(&self, mut write: impl FnMut(&[u8]) -> Result<(), E>) -> Result<(), E> {
        let bands = self.pixels().div_ceil(BAND);
        for first in (0..bands).step_by(BANDS_AT_A_TIME) {
            let some = first..(first + BANDS_AT_A_TIME).min(bands);
            let records: Vec<Vec<u8>> = some.into_par_iter().map(|band| self.band(band)).collect();
            records.iter().try_for_each(|record| write(record))?;
        }
        for layer in &self.fog {
            let words = layer.latest.nodes.iter().flat_map(FilmFilterNode::to_words);
            write(&words.flat_map(u32::to_le_bytes).collect::<Vec<u8>>())?;
        }
        Ok(())
    }

    fn band(&self, band: usize) -> Vec<u8> {
        let mut out = Vec::new();
        for start in (band * BAND..((band + 1) * BAND).min(self.pixels())).step_by(RUN) {
            let run = start..(start + RUN).min(self.pixels());
            put_planes(&self.own[run.clone()], FilmSums::to_words, &mut out);
            for FogLayer { sums, density, latest } in &self.fog {
                put_planes(&sums[run.clone()], FilmSums::to_words, &mut out);
                put_planes(&density[run.clone()], |density| [*density], &mut out);
                put_planes(&latest.density[run.clone()], |density| [density.to_bits().into()], &mut out);
                put_planes(&latest.regions[run.clone()], |region| [(*region).into()], &mut out);
            }
            if !self.gather.is_empty() {
                put_planes(&self.gather[run.clone()], |sums| sums.map(|sum| sum as u64), &mut out);
            }
            if !self.kinds.is_empty() {
                for kind in 0..3 {
                    put_planes(&self.kinds[run.clone()], |kinds| kinds[kind].to_words(), &mut out);
                }
            }
        }
        out
    }

    /// Adds stored sums of `passes` passes, `odd_passes` of them with odd numbers. `read` answers with the next record.
    /// After an error the film is of no use.
    pub fn add_stored<E: From<Unfit>>(
        &mut self,
        layout: &FilmLayout,
        [passes, odd_passes]: [u32; 2],
        mut read: impl FnMut() -> Result<Vec<u8>, E>,
    ) -> Result<(), E> {
        self.make_room(layout)?;
        let empty = || Latest { density: vec![0.0; self.pixels()], regions: vec![0; self.pixels()] };
        let mut latest: Vec<Latest> = layout.fog.iter().map(|_| empty()).collect();
        let mut bands = self.bands(&mut latest);
        for some in bands.chunks_mut(BANDS_AT_A_TIME) {
            let records = some.iter().map(|_| read()).collect::<Result<Vec<_>, E>>()?;
            let added = some.par_iter_mut().zip(&records).try_for_each(|(band, record)| band.add(record));
            added?;
        }
        let lattice = FilmLattice::new(self.width, self.height).map_err(|_| Unfit::Layout)?;
        for ((layer, &(kind, pass)), latest) in self.fog.iter_mut().zip(&layout.fog).zip(latest) {
            let record = read()?;
            let (nodes, rest) = record.as_chunks::<24>();
            if nodes.len() != lattice.node_count() || !rest.is_empty() {
                return Err(Unfit::Bytes.into());
            }
            if layer.latest.pass >= pass {
                continue;
            }
            let word =
                |node: &[u8; 24], place: usize| u32::from_le_bytes(from_fn(|byte| node[4 * place + byte]));
            let nodes =
                nodes.iter().map(|node| FilmFilterNode::from_words(from_fn(|place| word(node, place))));
            let (regions, density) = (Arc::new(latest.regions), Arc::new(latest.density));
            layer.latest =
                LayerFilters { kind, pass, lattice, regions, nodes: Arc::new(nodes.collect()), density };
        }
        self.passes += passes;
        self.odd_passes += odd_passes;
        Ok(())
    }

    /// Makes the sums as many as the stored ones are.
    fn make_room(&mut self, layout: &FilmLayout) -> Result<(), Unfit> {
        let pixels = self.pixels();
        if self.passes > 0 {
            return if self.layout().fits(layout) { Ok(()) } else { Err(Unfit::Layout) };
        }
        let bare = FilmLayout { gather: false, fog: Vec::new(), ..layout.clone() };
        if self.layout() != bare {
            return Err(Unfit::Layout);
        }
        self.own.resize(pixels, FilmSums::default());
        self.gather.resize(if layout.gather { pixels } else { 0 }, [0; 4]);
        self.kinds.resize(if layout.kinds.is_some() { pixels } else { 0 }, Default::default());
        let lattice = FilmLattice::new(self.width, self.height).map_err(|_| Unfit::Layout)?;
        self.fog = layout
            .fog
            .iter()
            .map(|(kind, _)| {
                // Before any pass.
                let (regions, nodes, density) = Default::default();
                let latest = LayerFilters { kind: *kind, pass: 0, lattice, regions, nodes, density };
                FogLayer { sums: vec![FilmSums::default(); pixels], density: vec![0; pixels], latest }
            })
            .collect();
        Ok(())
    }

    fn bands<'a>(&'a mut self, latest: &'a mut [Latest]) -> Vec<Band<'a>> {
        let count = self.pixels().div_ceil(BAND);
        let mut own = self.own.chunks_mut(BAND);
        let (mut gather, mut kinds) = (self.gather.chunks_mut(BAND), self.kinds.chunks_mut(BAND));
        let fog = self.fog.iter_mut().zip(latest);
        let mut fog: Vec<_> = fog
            .map(|(layer, latest)| {
                let sums = layer.sums.chunks_mut(BAND).zip(layer.density.chunks_mut(BAND));
                sums.zip(latest.density.chunks_mut(BAND).zip(latest.regions.chunks_mut(BAND)))
            })
            .collect();
        let band = |_| Band {
            own: own.next().unwrap_or_default(),
            gather: gather.next().unwrap_or_default(),
            kinds: kinds.next().unwrap_or_default(),
            fog: fog
                .iter_mut()
                .filter_map(Iterator::next)
                .map(|((sums, density), (latest_density, latest_regions))| FogBand {
                    sums,
                    density,
                    latest_density,
                    latest_regions,
                })
                .collect(),
        };
        (0..count).map(band).collect()
    }
}

impl Band<'_> {
    /// Adds a record's sums, which must fill it.
    fn add(&mut self, mut record: &[u8]) -> Result<(), Unfit> {
        let bytes = &mut record;
        for start in (0..self.own.len()).step_by(RUN) {
            let run = start..(start + RUN).min(self.own.len());
            add_sums(bytes, &mut self.own[run.clone()], |sums| sums)?;
            for FogBand { sums, density, latest_density, latest_regions } in &mut self.fog {
                add_sums(bytes, &mut sums[run.clone()], |sums| sums)?;
                take_planes(bytes, &mut density[run.clone()], |sum, [density]| {
                    *sum = sum.saturating_add(density);
                    Some(())
                })?;
                take_planes(bytes, &mut latest_density[run.clone()], |latest, [bits]| {
                    *latest = f32::from_bits(u32::try_from(bits).ok()?);
                    (*latest >= 0.0 && latest.is_finite()).then_some(())
                })?;
                take_planes(bytes, &mut latest_regions[run.clone()], |latest, [region]| {
                    *latest = u32::try_from(region).ok()?;
                    Some(())
                })?;
            }
            if !self.gather.is_empty() {
                take_planes(bytes, &mut self.gather[run.clone()], |sums, words: [u64; 4]| {
                    for (sum, word) in sums.iter_mut().zip(words) {
                        *sum = sum.saturating_add(i64::try_from(word).ok()?);
                    }
                    Some(())
                })?;
            }
            if !self.kinds.is_empty() {
                for kind in 0..3 {
                    add_sums(bytes, &mut self.kinds[run.clone()], |kinds| &mut kinds[kind])?;
                }
            }
        }
        if record.is_empty() { Ok(()) } else { Err(Unfit::Bytes) }
    }
}

/// Writes N numbers of each of at most [`RUN`] values: first those of the first kind, and so on.
fn put_planes<T, const N: usize>(values: &[T], words: impl Fn(&T) -> [u64; N], out: &mut Vec<u8>) {
    let mut planes = [[0; RUN]; N];
    for (place, value) in values.iter().enumerate() {
        for (plane, word) in planes.iter_mut().zip(words(value)) {
            plane[place] = word;
        }
    }
    planes.iter().for_each(|plane| put(plane, out));
}

/// Reads N numbers for each of at most [`RUN`] values; `add` answers None to those that no value has.
fn take_planes<T, const N: usize>(
    bytes: &mut &[u8],
    values: &mut [T],
    add: impl Fn(&mut T, [u64; N]) -> Option<()>,
) -> Result<(), Unfit> {
    let mut planes = [[0; RUN]; N];
    for plane in &mut planes {
        *plane = take(bytes)?;
        if plane[values.len()..].iter().any(|word| *word != 0) {
            return Err(Unfit::Bytes);
        }
    }
    for (place, value) in values.iter_mut().enumerate() {
        add(value, from_fn(|plane| planes[plane][place])).ok_or(Unfit::Bytes)?;
    }
    Ok(())
}

fn add_sums<T>(
    bytes: &mut &[u8],
    values: &mut [T],
    sums: impl Fn(&mut T) -> &mut FilmSums,
) -> Result<(), Unfit> {
    take_planes(bytes, values, |value, words| {
        sums(value).merge(&FilmSums::from_words(words)?);
        Some(())
    })
}
