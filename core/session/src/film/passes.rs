//! Which passes: sets of half-open ranges.

use std::fmt;
use std::str::FromStr;

/// Passes `start..end`, the first pass of a picture being 0; `start < end`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(from = "[u32; 2]", into = "[u32; 2]")
)]
pub struct PassRange {
    /// The first.
    pub start: u32,
    /// One past the last.
    pub end: u32,
}

impl PassRange {
    /// Their number.
    pub fn count(self) -> u32 {
        self.end - self.start
    }
}

impl From<[u32; 2]> for PassRange {
    fn from([start, end]: [u32; 2]) -> Self {
        Self { start, end }
    }
}

impl From<PassRange> for [u32; 2] {
    fn from(range: PassRange) -> Self {
        [range.start, range.end]
    }
}

impl fmt::Display for PassRange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}..{}", self.start, self.end)
    }
}

impl FromStr for PassRange {
    type Err = String;

    /// `A..B`
    fn from_str(text: &str) -> Result<Self, String> {
        let expected = || {
            format!("expected A..B, passes A to B - 1 of those that count from 0, as in 0..8; not '{text}'")
        };
        let (start, end) = text.split_once("..").ok_or_else(expected)?;
        let number = |text: &str| text.parse::<u32>().map_err(|_| expected());
        let range = Self { start: number(start)?, end: number(end)? };
        if range.start < range.end { Ok(range) } else { Err(format!("{range} holds no pass")) }
    }
}

/// Some passes of a picture, each at most once.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(transparent))]
pub struct Passes {
    /// In order, with gaps between them.
    ranges: Vec<PassRange>,
}

impl Passes {
    /// The ranges, in order, with gaps between them.
    pub fn ranges(&self) -> &[PassRange] {
        &self.ranges
    }

    /// Their number.
    pub fn count(&self) -> u32 {
        self.ranges.iter().map(|range| range.count()).sum()
    }

    /// How many of them have an odd number where passes count from 1.
    pub fn odd_count(&self) -> u32 {
        self.ranges.iter().map(|range| range.end.div_ceil(2) - range.start.div_ceil(2)).sum()
    }

    /// Whether they are what [`Passes::add`] makes: a file may hold anything.
    pub fn are_sound(&self) -> bool {
        let full = self.ranges.iter().all(|range| range.start < range.end);
        full && self.ranges.is_sorted_by(|before, after| before.end < after.start)
    }

    /// The first passes that both have.
    pub fn overlap(&self, other: &Self) -> Option<PassRange> {
        let pairs = self.ranges.iter().flat_map(|a| other.ranges.iter().map(move |b| (a, b)));
        let common = pairs.map(|(a, b)| PassRange { start: a.start.max(b.start), end: a.end.min(b.end) });
        common.filter(|range| range.start < range.end).min()
    }

    /// Those of `all` that are missing.
    pub fn gaps(&self, all: PassRange) -> Vec<PassRange> {
        let mut gaps = Vec::new();
        let mut start = all.start;
        for range in &self.ranges {
            if range.start.min(all.end) > start {
                gaps.push(PassRange { start, end: range.start.min(all.end) });
            }
            start = start.max(range.end);
        }
        if start < all.end {
            gaps.push(PassRange { start, end: all.end });
        }
        gaps
    }

    /// Adds passes of which it has none.
    pub fn add(&mut self, other: &Self) {
        self.ranges.extend(&other.ranges);
        self.ranges.sort_unstable();
        self.ranges.dedup_by(|after, before| {
            let touch = before.end == after.start;
            if touch {
                before.end = after.end;
            }
            touch
        });
    }
}

impl From<PassRange> for Passes {
    fn from(range: PassRange) -> Self {
        Self { ranges: vec![range] }
    }
}

/// Of ranges that a file holds: see [`Passes::are_sound`].
impl From<Vec<PassRange>> for Passes {
    fn from(ranges: Vec<PassRange>) -> Self {
        Self { ranges }
    }
}

impl fmt::Display for Passes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ranges: Vec<String> = self.ranges.iter().map(ToString::to_string).collect();
        write!(f, "{}", ranges.join(", "))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::collections::BTreeSet;

    fn range(start: u32, end: u32) -> PassRange {
        PassRange { start, end }
    }

    #[test]
    fn a_range_is_typed_as_it_is_shown() {
        assert_eq!("0..8".parse(), Ok(range(0, 8)));
        assert_eq!(range(3, 4).to_string(), "3..4");
        for text in ["8", "8..8", "9..8", "..8", "0..", "-1..3", "0..99999999999", "a..b", ""] {
            assert!(text.parse::<PassRange>().is_err(), "{text}");
        }
    }

    fn some() -> impl Strategy<Value = BTreeSet<u32>> {
        prop::collection::btree_set(0..40_u32, 1..30)
    }

    fn passes(set: &BTreeSet<u32>) -> Passes {
        let mut passes = Passes::default();
        set.iter().for_each(|pass| passes.add(&range(*pass, pass + 1).into()));
        passes
    }

    fn numbers(ranges: &[PassRange]) -> BTreeSet<u32> {
        ranges.iter().flat_map(|range| range.start..range.end).collect()
    }

    proptest! {
        #[test]
        fn they_behave_as_sets(a in some(), b in some(), start in 0..20_u32, length in 1..40_u32) {
            let (left, right) = (passes(&a), passes(&b));
            prop_assert!(left.are_sound());
            prop_assert_eq!(numbers(left.ranges()), a.clone());
            prop_assert_eq!(left.count() as usize, a.len());
            prop_assert_eq!(left.odd_count() as usize, a.iter().filter(|pass| (*pass + 1) % 2 == 1).count());
            let common: BTreeSet<u32> = a.intersection(&b).copied().collect();
            prop_assert_eq!(left.overlap(&right).map(|range| range.start), common.first().copied());
            let all = range(start, start + length);
            let missing: BTreeSet<u32> = (all.start..all.end).filter(|pass| !a.contains(pass)).collect();
            prop_assert_eq!(numbers(&left.gaps(all)), missing);

            let mut both = passes(&a.difference(&b).copied().collect());
            both.add(&right);
            prop_assert!(both.are_sound());
            prop_assert_eq!(numbers(both.ranges()), a.union(&b).copied().collect());
        }
    }
}
