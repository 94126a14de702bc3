//! Beams cut into sub-beams, in the order of their Morton codes, in which neighbours in the list are
//! neighbours in space.

use super::cancel::{Poll, STRETCH, Stop};
use super::room::{grow, release, with_room};
use crate::beam::Beam;
use glam::Vec3;
use std::vec::Vec;

/// Sub-beams that an average beam is cut into: a long beam's box is mostly empty. Three sub-beams ask for a
/// quarter more memory, and a pass for 2 to 8 % more processor cycles.
pub(super) const SUB_BEAMS_PER_BEAM: usize = 2;

/// What radii are multiplied by where the question is what may be met: more than rounding takes away.
pub(super) const ROOM: f32 = 1.001;

/// Bits of a Morton code for each axis.
const CODE_BITS: u32 = 21;

/// The part `[from, to]` of a beam, with the beam's line.
#[derive(Clone, Copy, Debug)]
pub(super) struct SubBeam {
    pub(super) origin: Vec3,
    pub(super) from: f32,
    pub(super) direction: Vec3,
    pub(super) to: f32,
    pub(super) beam: u32,
}

impl SubBeam {
    /// Its two ends.
    #[inline]
    pub(super) fn ends(&self) -> [Vec3; 2] {
        [self.from, self.to].map(|distance| self.origin + distance * self.direction)
    }
}

/// One sub-beam among many: which part of which beam, and its place on Morton's curve, which fills space.
#[derive(Clone, Copy)]
pub(super) struct MortonCode {
    code: u64,
    beam: u32,
    part: u32,
}

/// Whether a beam can contribute.
fn counts(beam: &Beam) -> bool {
    beam.length > 0.0
        && beam.length.is_finite()
        && beam.origin.is_finite()
        && beam.direction.is_finite()
        && beam.power.is_finite()
        && beam.end().is_finite()
}

/// How the beams of a map are cut: into the fewest equal parts that are no longer than `longest` \[m\].
pub(super) struct Cut {
    longest: f32,
}

impl Cut {
    fn parts(&self, beam: &Beam) -> u32 {
        libm::ceilf(beam.length / self.longest).max(1.0) as u32
    }

    /// The sub-beam that a code stands for.
    #[inline]
    pub(super) fn sub_beam(&self, beams: &[Beam], code: &MortonCode) -> SubBeam {
        self.part(&beams[code.beam as usize], code.beam, code.part)
    }

    #[inline]
    fn part(&self, beam: &Beam, index: u32, part: u32) -> SubBeam {
        let count = self.parts(beam);
        let at = |i: u32| if i == count { beam.length } else { beam.length * (i as f32 / count as f32) };
        SubBeam {
            origin: beam.origin,
            from: at(part),
            direction: beam.direction,
            to: at(part + 1),
            beam: index,
        }
    }
}

/// All sub-beams of the beams that can contribute, ordered by code, and how they were cut.
pub(super) fn morton_codes(beams: &[Beam], poll: &mut Poll) -> Result<(Cut, Vec<MortonCode>), Stop> {
    let (mut count, mut total) = (0_usize, 0.0);
    let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    for stretch in beams.chunks(STRETCH) {
        poll.spend(stretch.len(), 10)?;
        for beam in stretch.iter().filter(|beam| counts(beam)) {
            count += 1;
            total += f64::from(beam.length);
            low = low.min(beam.origin).min(beam.end());
            high = high.max(beam.origin).max(beam.end());
        }
    }
    let average = total / (SUB_BEAMS_PER_BEAM * count.max(1)) as f64;
    // Lengths that small divide by nothing smaller: no beam has more parts than all are allowed together.
    let cut = Cut { longest: (average as f32).max(f32::MIN_POSITIVE) };
    // In f64: the extent of finite points may be infinite in f32.
    let scale = [0, 1, 2].map(|axis| {
        let extent = f64::from(high[axis]) - f64::from(low[axis]);
        if extent > 0.0 { f64::from((1 << CODE_BITS) - 1) / extent } else { 0.0 }
    });
    let mut codes = with_room((SUB_BEAMS_PER_BEAM + 1) * count)?;
    for (index, beam) in (0..).zip(beams).filter(|(_, beam)| counts(beam)) {
        let parts = cut.parts(beam);
        grow(&mut codes, parts as usize)?;
        for part in 0..parts {
            poll.spend(1, 20)?;
            let [start, end] = cut.part(beam, index, part).ends();
            let [x, y, z] = [0, 1, 2].map(|axis| {
                let middle = 0.5 * (f64::from(start[axis]) + f64::from(end[axis]));
                spread(((middle - f64::from(low[axis])) * scale[axis]) as u32)
            });
            codes.push(MortonCode { code: x | y << 1 | z << 2, beam: index, part });
        }
    }
    Ok((cut, sorted(codes, poll)?))
}

/// The low 21 bits of `x`, two zeros after each.
fn spread(x: u32) -> u64 {
    let mut x = u64::from(x) & ((1 << CODE_BITS) - 1);
    for (shift, mask) in [
        (32, 0x001f_0000_0000_ffff),
        (16, 0x001f_0000_ff00_00ff),
        (8, 0x100f_00f0_0f00_f00f),
        (4, 0x10c3_0c30_c30c_30c3),
        (2, 0x1249_2492_4924_9249),
    ] {
        x = (x | x << shift) & mask;
    }
    x
}

/// Stable radix sort by code, a byte at a time from the lowest.
fn sorted(mut codes: Vec<MortonCode>, poll: &mut Poll) -> Result<Vec<MortonCode>, Stop> {
    const DIGITS: usize = 8;
    let mut counts = [[0_u32; 256]; DIGITS];
    for stretch in codes.chunks(STRETCH) {
        poll.spend(stretch.len(), DIGITS)?;
        for code in stretch {
            for (counts, digit) in counts.iter_mut().zip(code.code.to_le_bytes()) {
                counts[usize::from(digit)] += 1;
            }
        }
    }
    let mut other = with_room(codes.len())?;
    for stretch in codes.chunks(STRETCH) {
        poll.spend(stretch.len(), 4)?;
        other.extend_from_slice(stretch);
    }
    for (digit, counts) in counts.iter().enumerate() {
        if counts.iter().any(|&count| count as usize == codes.len()) {
            continue; // The same for all.
        }
        let mut next = [0_u32; 256];
        for i in 1..256 {
            next[i] = next[i - 1] + counts[i - 1];
        }
        for stretch in codes.chunks(STRETCH) {
            poll.spend(stretch.len(), 16)?;
            for code in stretch {
                let slot = &mut next[usize::from(code.code.to_le_bytes()[digit])];
                other[*slot as usize] = *code;
                *slot += 1;
            }
        }
        std::mem::swap(&mut codes, &mut other);
    }
    release(other, poll)?;
    Ok(codes)
}
