//! A few scenes whose lengths are quarters, as people's are: the default method must be as bright as brute-force path tracing, which has no
//! beams, no grid and rules of its own for what is where. `measure fleet --grid` looks at each block of hundreds of them.

use covbeam_session::color::luminance;
use covbeam_session::film::Picture;
use covbeam_session::scene::Scene;
use covbeam_tests::fleet::runs::{Estimator, pictures};
use covbeam_tests::fleet::snapped::{Snapped, snapped};
use covbeam_tests::statistics::{Sample, sidak, welch};

/// Pixels across: quarters of a picture are looked at.
const WIDTH: u32 = 16;

/// Runs of each, passes of the default in a run, and paths a pixel of brute force.
const RUNS: u32 = 8;
const PASSES: u32 = 4;
const PATHS: u32 = 256;

/// Kernels blur, and what they blur across a quarter's border is lost to it or gained: a few percent in a first pass of a picture of 16 pixels.
const BLUR: f64 = 0.04;

/// Mean luminance of each quarter, over runs.
fn quarters(runs: &[Picture]) -> [Sample; 4] {
    let half = WIDTH / 2;
    [0, 1, 2, 3].map(|quarter| {
        let of_run = |run: &Picture| {
            let pixels = run.radiance.iter().zip(0..);
            let inside =
                pixels.filter(|(_, at)| (at % WIDTH / half, at / WIDTH / half) == (quarter % 2, quarter / 2));
            inside.map(|(value, _)| f64::from(luminance(*value))).sum::<f64>()
        };
        Sample::of(&runs.iter().map(of_run).collect::<Vec<_>>())
    })
}

/// Quarters of the default and of brute force that differ by more than blur and chance, of those that are not dark.
fn differing(of: &Snapped, expected: [Sample; 4], scene: &Scene, level: f64) -> usize {
    let found = quarters(&pictures(scene, Estimator::Default, 100..100 + RUNS, PASSES).expect("finite"));
    let brightest = expected.iter().map(|quarter| quarter.mean).fold(0.0, f64::max);
    let mut wrong = 0;
    for (found, expected) in found.into_iter().zip(expected) {
        if expected.mean < 0.02 * brightest {
            continue;
        }
        let (low, high) = ((1.0 - BLUR) * expected.mean, (1.0 + BLUR) * expected.mean);
        let p = welch(found, Sample { mean: found.mean.clamp(low, high), ..expected });
        println!(
            "{}: {:.4} ± {:.4} of ± {:.4}, p {p:.1e}",
            of.path.display(),
            found.mean / expected.mean,
            found.error / expected.mean,
            expected.error / expected.mean
        );
        wrong += usize::from(p < level);
    }
    wrong
}

/// Of the first of a seed those that brute force finds all light of and that have few lamps.
const NUMBERS: [u32; 6] = [1, 3, 5, 6, 7, 8];

#[test]
fn snapped_scenes_are_as_bright_as_brute_force_has_them() {
    let folder = tempfile::tempdir().expect("a temporary directory");
    // One of a thousand such tests fails by chance.
    let level = sidak(0.001, 4 * NUMBERS.len());
    let (mut asked, mut tried, mut told) = (0, 0, 0);
    for number in NUMBERS {
        let of = snapped(1, number, WIDTH, folder.path()).expect("a scene");
        let Some(brute_force) = &of.brute_force else {
            continue;
        };
        asked += 1;
        let expected = quarters(&(0..RUNS).map(|seed| brute_force.picture(seed, PATHS)).collect::<Vec<_>>());
        assert_eq!(differing(&of, expected, &of.scene, level), 0, "scene {number}");
        // And it must see fog that scatters twice as much: in half of the scenes, whatever it would see in the others then.
        if 2 * told < NUMBERS.len() {
            let mut thick = of.scene.clone();
            thick.media.iter_mut().for_each(|medium| medium.medium.scattering *= 2.0);
            told += usize::from(differing(&of, expected, &thick, level) > 0);
            tried += 1;
        }
    }
    assert!(asked >= 4 && 2 * told >= asked, "{told} of {tried} are told from thicker fog, of {asked}");
}
