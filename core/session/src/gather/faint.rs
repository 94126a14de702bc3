//! Pieces of eye paths that the camera hardly sees: a gather costs them as much as any other. Some of those that lie side by side are gathered
//! first, and say how many of the others it takes for what they add to be smooth: of a bright thing that dark glass reflects, all of them.

use crate::eye::segment::EyeSegment;
use crate::random::Random;

/// A piece is faint if less than this of it reaches the camera.
const FAINT: f32 = 0.1;

/// Pieces that are judged together, at most.
const RUN: usize = 64;

/// Of each run one in so many is gathered first.
const EVERY: usize = 8;

/// Relative variance that those left out may add to a pixel in a pass.
const MOST_VARIANCE: f32 = 3e-3;

/// Of those that seem to add nothing, this share is gathered.
const LEAST: f32 = 0.1;

/// Purpose of random numbers.
const KEY: u32 = 0xfa17;

/// Whether the camera hardly sees a piece that lies behind the first surface.
pub(crate) fn is_faint(segment: &EyeSegment) -> bool {
    !segment.is_first() && segment.throughput.max_element() < FAINT
}

/// Faint pieces of a tile, those of one path side by side, a few of them first.
pub(crate) struct Runs<'s> {
    faint: &'s [EyeSegment],
    seed: [u32; 3],
}

/// Some pieces side by side.
struct Run<'s> {
    pieces: &'s [EyeSegment],
    /// Which of each [`EVERY`] is gathered first.
    turn: usize,
    random: Random,
}

impl<'s> Runs<'s> {
    /// - `seed`: of the render, number of the pass, and a pixel of the tile.
    pub(crate) fn new(faint: &'s [EyeSegment], seed: [u32; 3]) -> Self {
        Self { faint, seed }
    }

    fn runs(&self) -> impl Iterator<Item = Run<'s>> + use<'s> {
        let [seed, pass, tile] = self.seed;
        let alike = self.faint.chunk_by(|a, b| a.path() == b.path());
        alike.flat_map(|group| group.chunks(RUN)).enumerate().map(move |(number, pieces)| {
            let mut random = Random::new([seed, pass, tile, KEY ^ (number as u32) << 16]);
            let turn = (random.uniform() * EVERY.min(pieces.len()) as f32) as usize;
            Run { pieces, turn, random }
        })
    }

    /// Those to gather first, at least one of each run.
    pub(crate) fn first(&self, out: &mut Vec<EyeSegment>) {
        out.clear();
        self.runs().for_each(|run| out.extend(run.pieces.iter().skip(run.turn).step_by(EVERY)));
    }

    /// Those of the others to gather, which stand for all of them.
    ///
    /// - `found`: luminance that the camera sees of each of the first; `brightness`: luminance of all that the pixel of a piece shows.
    pub(crate) fn others(
        &self,
        found: &[f32],
        brightness: impl Fn(&EyeSegment) -> f32,
        out: &mut Vec<EyeSegment>,
    ) {
        out.clear();
        let mut found = found.iter();
        for Run { pieces, turn, mut random } in self.runs() {
            let count = (pieces.len() - turn).div_ceil(EVERY);
            let squares: f32 = found.by_ref().take(count).map(|light| light * light).sum();
            let bright = pieces.iter().map(&brightness).sum::<f32>() / pieces.len() as f32;
            let variance = if squares > 0.0 { squares / count as f32 / (bright * bright) } else { 0.0 };
            let chance = (variance / MOST_VARIANCE).clamp(LEAST, 1.0);
            let others = pieces.iter().enumerate().filter(|(place, _)| place % EVERY != turn);
            for (_, piece) in others {
                if random.uniform() < chance {
                    out.push(EyeSegment { throughput: piece.throughput / chance, ..*piece });
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::optics::Interior;
    use covbeam::EyeRay;
    use glam::Vec3;

    /// Pieces behind three surfaces, each in a pixel of its own.
    fn pieces(count: u32) -> Vec<EyeSegment> {
        let piece = |pixel| EyeSegment {
            ray: EyeRay::default(),
            medium: 0,
            throughput: Vec3::splat(0.01),
            pixel,
            interior: Interior::default(),
            signature: 2 + u64::from(pixel * 3 / count),
        };
        (0..count).map(piece).collect()
    }

    /// What a pass sees of pieces with so much light: [sum over the pixels, pieces that were gathered].
    fn seen(pieces: &[EyeSegment], light: impl Fn(u32) -> f32, brightness: f32, pass: u32) -> [f32; 2] {
        let runs = Runs::new(pieces, [1, pass, 0]);
        let [mut first, mut others] = [Vec::new(), Vec::new()];
        runs.first(&mut first);
        let found = |piece: &EyeSegment| piece.throughput.x * light(piece.pixel);
        let of_first: Vec<f32> = first.iter().map(found).collect();
        runs.others(&of_first, |_| brightness, &mut others);
        [first.iter().chain(&others).map(found).sum(), (first.len() + others.len()) as f32]
    }

    /// A few bright pieces among dark ones: whether the first have met one decides how many of the others are gathered, and biases nothing.
    #[test]
    fn the_mean_is_that_of_all_pieces() {
        let pieces = pieces(300);
        let light = |pixel: u32| if pixel % 37 == 5 { 100.0 } else { 1.0 };
        let truth: f32 = pieces.iter().map(|piece| 0.01 * light(piece.pixel)).sum();
        const PASSES: u32 = 20_000;
        let sums: Vec<f64> =
            (0..PASSES).map(|pass| f64::from(seen(&pieces, light, 0.5, pass)[0] / truth)).collect();
        let mean = sums.iter().sum::<f64>() / f64::from(PASSES);
        let variance = sums.iter().map(|sum| (sum - mean) * (sum - mean)).sum::<f64>() / f64::from(PASSES);
        let error = (variance / f64::from(PASSES)).sqrt();
        println!("{mean} +- {error}");
        assert!((mean - 1.0).abs() < 4.0 * error && error < 0.01, "{mean} +- {error}");
    }

    /// A bright thing that dark glass reflects is gathered whole; where all is dark, or what is reflected is lost in the light of the pixel, an
    /// eighth and a tenth of the rest: .2125.
    #[test]
    fn as_many_are_gathered_as_it_takes() {
        let pieces = pieces(3 * 64);
        let share = |light: f32, brightness: f32| {
            let of_pass = |pass| seen(&pieces, |_| light, brightness, pass)[1] / pieces.len() as f32;
            (0..100).map(of_pass).sum::<f32>() / 100.0
        };
        assert_eq!(share(100.0, 1.0), 1.0);
        // Of 100 passes' 17,000 draws.
        for share in [share(0.0, 0.0), share(0.0, 1.0), share(1.0, 1.0)] {
            assert!((share - 0.2125).abs() < 0.01, "{share}");
        }
    }
}
