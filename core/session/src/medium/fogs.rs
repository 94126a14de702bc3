//! Which medium fills a place inside of placed objects: sets of volumes, which may add up.

use crate::medium::MediumId;
use glam::Vec3;

/// Volumes whose insides are told apart.
pub const MOST_VOLUMES: usize = 64;

/// Fog that fills some objects.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FogVolume {
    /// What fills them.
    pub medium: MediumId,
    /// Lower corner of a box around them \[scene unit\].
    pub min: Vec3,
    /// Upper corner.
    pub max: Vec3,
}

impl FogVolume {
    fn size(&self) -> f64 {
        (self.max - self.min).as_dvec3().element_product()
    }
}

/// Fog of several volumes, where all of them and no others are.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FogSum {
    /// Indices of the volumes.
    pub parts: Vec<usize>,
    /// What is there.
    pub medium: MediumId,
}

/// Why volumes were refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FogError {
    /// More than [`MOST_VOLUMES`].
    #[error("{0} volumes: at most {MOST_VOLUMES} can be rendered; join those that touch each other")]
    TooMany(usize),
    /// A sum of a volume that is not there.
    #[error("sum {sum} has the part {part}, and there are {volumes} volumes")]
    Part {
        /// Which sum.
        sum: usize,
        /// The part.
        part: usize,
        /// How many there are.
        volumes: usize,
    },
}

/// Which medium fills a place: that of the smallest of all volumes that it is in, or of exactly their sum if there is one.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AddedFogs {
    volumes: Vec<FogVolume>,
    /// Of each volume: the smaller, the lower.
    bits: Vec<u64>,
    /// By bit.
    media: Vec<MediumId>,
    /// Sets of volumes, ascending, and the media of their sums.
    sums: Vec<(u64, MediumId)>,
}

impl AddedFogs {
    /// - `volumes`: of two that are as large the later one counts; `sums`: of two of the same volumes, too.
    ///
    /// # Errors
    /// Too many volumes, or a sum of some that are not there.
    pub fn new(volumes: Vec<FogVolume>, sums: &[FogSum]) -> Result<Self, FogError> {
        let count = volumes.len();
        if count > MOST_VOLUMES {
            return Err(FogError::TooMany(count));
        }
        let mut order: Vec<usize> = (0..count).rev().collect();
        order.sort_by(|&a, &b| volumes[a].size().total_cmp(&volumes[b].size()));
        let mut bits = vec![0; count];
        order.iter().enumerate().for_each(|(bit, &volume)| bits[volume] = 1 << bit);
        let media = order.iter().map(|&volume| volumes[volume].medium).collect();
        let mut sets = std::collections::BTreeMap::new();
        for (sum, FogSum { parts, medium }) in sums.iter().enumerate() {
            if let Some(&part) = parts.iter().find(|part| **part >= count) {
                return Err(FogError::Part { sum, part, volumes: count });
            }
            sets.insert(parts.iter().fold(0, |set, &part| set | bits[part]), *medium);
        }
        Ok(Self { volumes, bits, media, sums: sets.into_iter().collect() })
    }

    /// As they were given.
    pub fn volumes(&self) -> &[FogVolume] {
        &self.volumes
    }

    /// The set that a volume alone is.
    pub(crate) fn set_of(&self, volume: u8) -> u64 {
        self.bits[usize::from(volume)]
    }

    /// What fills places that are inside of a set of volumes; None: inside of none.
    pub(crate) fn medium(&self, set: u64) -> Option<MediumId> {
        if set == 0 {
            return None;
        }
        let sum = self.sums.binary_search_by_key(&set, |&(set, _)| set);
        Some(sum.map_or_else(|_| self.media[set.trailing_zeros() as usize], |place| self.sums[place].1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn volume(medium: MediumId, half: f32) -> FogVolume {
        FogVolume { medium, min: Vec3::splat(-half), max: Vec3::splat(half) }
    }

    fn media(fogs: &AddedFogs, sets: &[&[u8]]) -> Vec<Option<MediumId>> {
        let set = |volumes: &&[u8]| volumes.iter().fold(0, |set, &volume| set | fogs.set_of(volume));
        sets.iter().map(|volumes| fogs.medium(set(volumes))).collect()
    }

    #[test]
    fn the_smallest_volume_around_a_place_counts_and_of_two_alike_the_later() {
        let volumes = vec![volume(5, 1.0), volume(6, 2.0), volume(7, 1.0), volume(8, 0.5)];
        let fogs = AddedFogs::new(volumes, &[]).expect("few");
        let found = media(&fogs, &[&[], &[0], &[1], &[0, 1], &[0, 1, 2], &[0, 1, 2, 3]]);
        assert_eq!(found, [None, Some(5), Some(6), Some(5), Some(7), Some(8)]);
    }

    #[test]
    fn a_sum_counts_where_its_parts_are_and_no_others() {
        let volumes = vec![volume(0, 1.0), volume(1, 2.0), volume(2, 3.0)];
        let sums = [FogSum { parts: vec![1, 0], medium: 9 }, FogSum { parts: vec![0, 1, 2], medium: 10 }];
        let fogs = AddedFogs::new(volumes, &sums).expect("few");
        let found = media(&fogs, &[&[0], &[0, 1], &[0, 2], &[1, 2], &[2, 1, 0]]);
        assert_eq!(found, [Some(0), Some(9), Some(0), Some(1), Some(10)]);
    }

    #[test]
    fn too_many_volumes_and_parts_that_are_not_there_are_refused_with_a_remedy() {
        let some = |count| (0..count).map(|medium| volume(medium, 1.0 + medium as f32)).collect();
        let fogs = AddedFogs::new(some(64), &[]).expect("as many as there may be");
        assert_eq!(media(&fogs, &[&[63], &[63, 62], &[0]]), [Some(63), Some(62), Some(0)]);
        let error = AddedFogs::new(some(65), &[]).expect_err("one too many").to_string();
        assert!(error.contains("65 volumes") && error.contains("64") && error.contains("join"), "{error}");
        let sums = [FogSum { parts: vec![0, 2], medium: 0 }];
        let error = AddedFogs::new(some(2), &sums).expect_err("no third").to_string();
        assert_eq!(error, "sum 0 has the part 2, and there are 2 volumes");
    }
}
