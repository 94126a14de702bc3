//! Blocks of pixels, and rings around the brightest part, that two estimators must agree on, all of them, with the chance of a false alarm
//! stated. A ring sees what no block does: a faint halo all around a cone.
//!
//! In two steps, each with runs of its own. The first *suspects* blocks: Welch's t-test, rejecting at [`SUSPECT`], where one in a thousand
//! sound blocks is suspected by chance. The second judges the suspects alone, from fresh runs with other seeds: Welch again, at the level
//! that Šidák's formula gives for the number of suspects of all scenes together. Whatever the first step was, the runs of the second are
//! independent of it, so that the chance to reject any sound block of any scene is at most that of the second step: the family-wise level
//! holds over all blocks, suspected or not.
//!
//! One step over all blocks would have to reject at p = 4e-7 for 200 scenes of 81 blocks, eight and a half standard errors with eight runs on either side,
//! at which neither power nor the tails of the distribution are what they should be: means of few bright events are skewed, and Student's
//! quantiles are only as good as the normal distribution is so far out. With some tens of suspects the level is some 1e-4.

use super::rings;
use crate::statistics::{Sample, welch};
use covbeam_session::color::luminance;
use covbeam_session::film::Picture;

/// Pixels across and down a block; less at the right and lower edge of a picture that is no multiple.
pub const SIDE: u32 = 8;

/// p-value below which the first runs make a block suspect.
pub const SUSPECT: f64 = 1e-3;

/// Part of a block's brightness by which two methods may differ: kernels of either blur the light, by a bias that the default bounds to
/// 1 % in the first pass and less later.
pub const BLUR: f64 = 0.01;

/// Mean luminance of each block, row by row.
pub fn means(picture: &Picture) -> Vec<f64> {
    let (across, down) = (picture.width.div_ceil(SIDE), picture.height.div_ceil(SIDE));
    let mut sums = vec![[0.0; 2]; (across * down) as usize];
    for (pixel, value) in (0..).zip(&picture.radiance) {
        let [sum, count] = &mut sums[block_of(picture.width, pixel)];
        *sum += f64::from(luminance(*value));
        *count += 1.0;
    }
    sums.iter().map(|[sum, count]| sum / count).collect()
}

/// The block of a pixel.
pub fn block_of(width: u32, pixel: u32) -> usize {
    let (x, y) = (pixel % width, pixel / width);
    (y / SIDE * width.div_ceil(SIDE) + x / SIDE) as usize
}

/// What the runs of two estimators say of a block.
#[derive(Clone, Copy, Debug)]
pub struct Verdict {
    /// Two-sided p-value that the means differ by no more than [`BLUR`] of the second.
    pub p: f64,
    /// First mean over the second.
    pub ratio: f64,
}

/// Compares the blocks, and after them the rings, of independent pictures, at least two of either kind.
///
/// - `of_pixels`: the ring of each pixel, as [`super::rings::rings`] finds them.
pub fn compare(tested: &[Picture], against: &[Picture], of_pixels: &[Option<usize>]) -> Vec<Verdict> {
    let [tested, against] = [tested, against].map(|pictures| {
        let of = |picture: &Picture| [means(picture), rings::sums(of_pixels, picture).to_vec()].concat();
        pictures.iter().map(of).collect::<Vec<Vec<f64>>>()
    });
    let sample = |runs: &[Vec<f64>], block: usize| {
        Sample::of(&runs.iter().map(|means| means[block]).collect::<Vec<f64>>())
    };
    (0..tested[0].len()).map(|block| judge(sample(&tested, block), sample(&against, block))).collect()
}

fn judge(tested: Sample, against: Sample) -> Verdict {
    let ratio = if tested.mean == against.mean { 1.0 } else { tested.mean / against.mean };
    let difference = tested.mean - against.mean;
    let allowed = BLUR * against.mean;
    if difference.abs() <= allowed {
        return Verdict { p: 1.0, ratio };
    }
    if tested.error == 0.0 && against.error == 0.0 {
        return Verdict { p: 0.0, ratio };
    }
    // At the edge of the hypothesis that is nearest to what was found.
    let nearest = Sample { mean: against.mean + allowed.copysign(difference), ..against };
    Verdict { p: welch(tested, nearest), ratio }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Stream;
    use glam::Vec3;

    fn picture(width: u32, height: u32, value: impl FnMut(u32) -> f32) -> Picture {
        let radiance = (0..width * height).map(value).map(Vec3::splat).collect();
        Picture { width, height, radiance, ..Picture::default() }
    }

    #[test]
    fn blocks_are_eight_by_eight_and_what_is_left_at_the_edges() {
        let means = means(&picture(20, 9, |pixel| (pixel % 20 / 8 + 10 * (pixel / 20 / 8)) as f32));
        for (mean, expected) in means.iter().zip([0.0, 1.0, 2.0, 10.0, 11.0, 12.0]) {
            assert!((mean - expected).abs() < 1e-6, "{means:?}");
        }
        assert_eq!(means.len(), 6);
    }

    /// Gaussian runs: the share of false suspects is the level, and a difference of 1 % is none.
    #[test]
    fn sound_blocks_are_suspected_as_often_as_stated_and_wrong_ones_always() {
        let mut stream = Stream::new(5);
        // A block of one pixel: the mean of twelve uniform numbers is nearly normal.
        let mut runs = |mean: f32| -> Vec<Picture> {
            (0..8)
                .map(|_| {
                    picture(8 * 200, 1, |_| {
                        let sum: f64 = (0..12).map(|_| stream.uniform() - 0.5).sum();
                        mean + 0.03 * sum as f32
                    })
                })
                .collect()
        };
        let suspects =
            |verdicts: Vec<Verdict>| verdicts.iter().filter(|verdict| verdict.p < 0.05).count() as f64;
        let share = suspects(compare(&runs(1.0), &runs(1.0), &[])) / 200.0;
        // The mean of eight pixels has error .011 a run; 1 % is allowed on top of 5 % of false alarms.
        assert!(share < 0.05, "{share}");
        let share = suspects(compare(&runs(1.01), &runs(1.0), &[])) / 200.0;
        // At the edge of the hypothesis one tail is left: 2.5 % expected, ± 1.1 %.
        assert!((0.0..0.07).contains(&share), "{share}");
        let share = suspects(compare(&runs(1.05), &runs(1.0), &[])) / 200.0;
        assert!(share > 0.99, "{share}");
    }

    /// No block of 8 x 8 pixels knows that it is 4 % too bright, all of the ring together does.
    #[test]
    fn a_faint_halo_shows_in_its_ring() {
        let mut stream = Stream::new(6);
        let rings: Vec<Option<usize>> =
            (0..64 * 64).map(|pixel| (pixel % 64 / 8 == 3).then_some(2)).collect();
        let mut runs = |halo: f32| -> Vec<Picture> {
            let noisy = |stream: &mut Stream| 0.5 + stream.uniform() as f32;
            (0..8)
                .map(|_| {
                    picture(64, 64, |pixel| {
                        let bright = if rings[pixel as usize].is_some() { halo } else { 1.0 };
                        bright * noisy(&mut stream)
                    })
                })
                .collect()
        };
        let found = compare(&runs(1.05), &runs(1.0), &rings);
        let (blocks, rings) = found.split_at(64);
        assert!(rings[2].p < 1e-4, "{:?}", rings[2]);
        assert!([0, 1, 3, 4, 5].iter().all(|ring| rings[*ring].p == 1.0), "{rings:?}");
        assert!(blocks.iter().all(|block| block.p > 1e-4), "{blocks:?}");
    }

    #[test]
    fn black_blocks_agree_and_light_that_is_always_there_and_never_does_not() {
        let black = [picture(8, 8, |_| 0.0), picture(8, 8, |_| 0.0)];
        let grey = [picture(8, 8, |_| 0.5), picture(8, 8, |_| 0.5)];
        assert_eq!(compare(&black, &black, &[])[0].p, 1.0);
        assert_eq!(compare(&grey, &black, &[])[0].p, 0.0);
    }
}
