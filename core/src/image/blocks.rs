//! Blocks of pixels: four times as large on each level, up to one over all of a picture.

use super::FilmSample;

/// Levels of blocks above the pixels.
pub(super) const LEVELS: usize = 16;

/// A block of pixels: scratch memory of a [`super::Reconstruction`].
#[derive(Clone, Copy, Debug, Default)]
pub struct FilmNode {
    /// Of up to two regions in it; region 0, of silhouettes, is none.
    parts: [Part; 2],
    /// [`bit`]s of the regions in it.
    regions: u32,
    /// Whether it holds more regions, of which it knows the bits only.
    more: bool,
}

/// The pixels of one region in a block.
#[derive(Clone, Copy, Debug, Default)]
struct Part {
    region: u32,
    sample: FilmSample,
}

/// What a block has of a region, or of all.
pub(super) enum Within<'a> {
    Nothing,
    /// All that it has of it; `shared`: it has other pixels too.
    All {
        sample: &'a FilmSample,
        shared: bool,
    },
    /// What it is made of knows.
    Below,
}

/// What a block of many regions remembers of one; silhouettes have a bit of their own.
fn bit(region: u32) -> u32 {
    if region == 0 { 1 } else { 2 << (region % 31) }
}

impl FilmNode {
    /// One whose sample is not sound has no rays.
    pub(super) fn add_pixel(&mut self, sample: &FilmSample, region: u32) {
        self.regions |= bit(region);
        if region != 0 {
            let seen = if sample.is_sound() { *sample } else { FilmSample::default() };
            self.add_part(region, &seen);
        }
    }

    pub(super) fn add(&mut self, other: &Self) {
        self.regions |= other.regions;
        self.more |= other.more;
        for Part { region, sample } in &other.parts {
            if *region != 0 {
                self.add_part(*region, sample);
            }
        }
    }

    fn add_part(&mut self, region: u32, sample: &FilmSample) {
        for own in &mut self.parts {
            if own.region == region || own.region == 0 {
                own.region = region;
                own.sample.add(1.0, sample);
                return;
            }
        }
        self.more = true;
    }

    /// - `among`: a region other than 0; None: all.
    pub(super) fn within(&self, among: Option<u32>) -> Within<'_> {
        let [Part { region, sample }, second] = &self.parts;
        let shared = self.more || second.region != 0 || self.regions != bit(*region);
        match among {
            None if shared || *region == 0 => Within::Below,
            None => Within::All { sample, shared },
            Some(wanted) if self.more => match self.regions & bit(wanted) {
                0 => Within::Nothing,
                _ => Within::Below,
            },
            Some(wanted) => match self.parts.iter().find(|part| part.region == wanted) {
                Some(Part { sample, .. }) => Within::All { sample, shared },
                None => Within::Nothing,
            },
        }
    }
}

/// The levels of blocks over a picture, up to one block: a block is made of up to four of the level below,
/// and the pixels are level 0.
#[derive(Clone, Copy, Debug)]
pub(super) struct Levels {
    pub(super) top: usize,
    /// How many blocks across and down.
    pub(super) size: [(u32, u32); LEVELS + 1],
    /// The number of each level's first block, among the pixels or among the blocks.
    pub(super) first: [usize; LEVELS + 1],
    /// How many blocks there are, on all levels above the pixels.
    pub(super) nodes: usize,
}

impl Levels {
    /// Of a picture that is not too large.
    pub(super) fn new(width: u32, height: u32) -> Self {
        let mut levels =
            Self { top: 0, size: [(width, height); LEVELS + 1], first: [0; LEVELS + 1], nodes: 0 };
        let (mut across, mut down) = (width, height);
        while across.max(down) > 1 && across.min(down) > 0 {
            (across, down) = (across.div_ceil(2), down.div_ceil(2));
            levels.top += 1;
            levels.size[levels.top] = (across, down);
            levels.first[levels.top] = levels.nodes;
            levels.nodes += across as usize * down as usize;
        }
        levels
    }

    pub(super) fn index(&self, level: usize, x: u32, y: u32) -> usize {
        self.first[level] + y as usize * self.size[level].0 as usize + x as usize
    }

    /// What a block is made of.
    pub(super) fn children(&self, level: usize, x: u32, y: u32) -> impl Iterator<Item = (u32, u32)> + use<> {
        let (across, down) = self.size[level - 1];
        let corners = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(dx, dy)| (2 * x + dx, 2 * y + dy));
        corners.into_iter().filter(move |(x, y)| *x < across && *y < down)
    }
}
