//! Whether guided light paths are worth more than plain ones: a trial of both.
//!
//! Guided paths are to bring about as much of the picture each as any other. In thick fog light is scattered dozens of times on its way to the
//! camera, and as many random decisions to split a path or to end it leave few trees that arrive, with thousands of branches: plain paths are
//! more alike there, and cost a tenth.

use super::instant::Poll;
use crate::color::mean;
use crate::kind::Kind;
use crate::paths::guidance::Guidance;
use crate::paths::record::{PathBeam, PhotonRecord};
use crate::paths::{PhotonTracer, Record};
use crate::random::Emission;
use crate::scene::Scene;
use covbeam::Medium;

/// Plain paths.
const PATHS: u32 = 2048;

/// Sequence of plain paths.
const SEQUENCE: u32 = 0x7e57;

/// Guided paths that are less even than plain ones, but at least by this share as even, are worth it if they are the more even for each beam:
/// where nothing ends plain paths, as between walls of glass, these have ten times the beams, and a pass takes ten times as long.
const HALF: f64 = 0.5;

/// Plain paths that leave fewer beams than this, of those that leave any, are not scattered dozens of times: guided ones are worth more, and more
/// evenly than two thousand of them show. Error x CPU time of guided paths over that of plain ones (and beams of a plain path): lit through a window
/// .07 (2); around one corner .07 (3) and .23 (5), around two .02 (3) and .7 (5); a ball of milk .44 (6); hazy rooms with white walls .25 (6); thick
/// fog .4 (8), 3 (13) and 4 (56); between mirrors 1.6 (5) and 25 (25).
const FEW: f64 = 8.0;

/// Whether guided paths are worth more than plain ones.
///
/// - `guided`: the [`worth`] of each, and `beams`: what all of them leave in maps. Cost: of 2048 plain paths.
pub(super) fn pays(
    guidance: &Guidance,
    scene: &Scene,
    fogs: &[Medium],
    guided: &[f32],
    beams: usize,
    cancelled: Poll,
) -> bool {
    let tracer = PhotonTracer::new(scene, 0, Emission::LowDiscrepancy);
    let (mut beams_of_plain, mut leave_any) = (0, 0);
    let plain = (0..PATHS).take_while(|_| !cancelled()).map(|index| {
        let mut record = PhotonRecord::default();
        tracer.trace(SEQUENCE, index, PATHS, Record::Beams, &mut record);
        let left = record.beams.iter().filter(|path| is_gathered(path)).count();
        beams_of_plain += left;
        leave_any += u32::from(left > 0);
        worth(guidance, fogs, &record, [0, 0])
    });
    let [of_guided, of_plain] = [evenness(guided), evenness(&plain.collect::<Vec<f32>>())];
    let beams = [beams as f64 / guided.len() as f64, beams_of_plain as f64 / f64::from(PATHS)];
    f64::from(leave_any) * FEW > beams_of_plain as f64 || is_better([of_guided, of_plain], beams)
}

/// By evenness and beams a path, of guided paths and plain ones.
fn is_better([guided, plain]: [f64; 2], [of_guided, of_plain]: [f64; 2]) -> bool {
    guided >= plain || guided >= HALF * plain && guided * of_plain >= plain * of_guided
}

/// How much of the picture's light, relative to its brightness, the paths of a record bring about that are not straight from lamps.
///
/// - `from`: the first beam and surface photon that count.
pub(super) fn worth(guidance: &Guidance, fogs: &[Medium], record: &PhotonRecord, from: [usize; 2]) -> f32 {
    let importance = guidance.importance();
    let of_beams = record.beams[from[0]..].iter().map(|path| {
        if !is_gathered(path) {
            return 0.0;
        }
        let beam = &path.beam;
        let fog = &fogs[path.medium as usize];
        mean(beam.power) * importance.of_segment(fog, beam.origin, beam.direction, beam.length).beam
    });
    let of_surfaces = record.surface[from[1]..]
        .iter()
        .map(|photon| mean(photon.power) * importance.at(photon.position).surface);
    of_beams.chain(of_surfaces).sum()
}

/// Whether it becomes part of a map.
pub(super) fn is_gathered(path: &PathBeam) -> bool {
    path.kind != Kind::Straight
}

/// The share of paths that would bring about all there is, each the same: 1 where all do, k/n where k of n bring all of it; 0 without any.
///
/// (Σ √w)² / (n Σ w), for what each brings is far from any normal distribution: a variance would be that of the few largest.
fn evenness(worth: &[f32]) -> f64 {
    let sum: f64 = worth.iter().map(|worth| f64::from(*worth)).sum();
    let roots: f64 = worth.iter().map(|worth| f64::from(*worth).sqrt()).sum();
    if sum > 0.0 { roots * roots / (sum * worth.len() as f64) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pilot::Spread;
    use crate::pilot::of_still;
    use crate::scene::made::{Made, camera, cuboid, lambert, point, spot};
    use crate::scene::{Material, media};

    /// None but one that brings all, all of them the same, and numbers w = u² with the density 1/(2√w): Σ√w = n/2 and Σw = n/3.
    #[test]
    fn evenness_is_the_share_of_paths_that_count() {
        let squares: Vec<f32> = (0..1000).map(|i| ((i as f32 + 0.5) / 1000.0).powi(2)).collect();
        assert_eq!([evenness(&[]), evenness(&[0.0; 4]), evenness(&[0.0, 4.0, 0.0, 0.0])], [0.0, 0.0, 0.25]);
        assert!((evenness(&[3.0; 9]) - 1.0).abs() < 1e-12);
        assert!((evenness(&squares) - 0.75).abs() < 1e-5);
    }

    /// A shaft, a bottle, thick fog, and two where fewer beams, and where as many, are no reason.
    #[test]
    fn guided_paths_are_better_where_they_are_more_even_or_nearly_so_with_fewer_beams() {
        let cases = [
            ([0.65, 0.18], [2.3, 1.4], true),
            ([0.49, 0.64], [9.3, 83.0], true),
            ([0.006, 0.041], [6.0, 24.0], false),
            ([0.008, 0.052], [6.0, 84.0], false),
            ([0.2, 0.3], [5.0, 5.0], false),
        ];
        for (evenness, beams, expected) in cases {
            assert_eq!(is_better(evenness, beams), expected, "{evenness:?} {beams:?}");
        }
    }

    /// A closed shed with one window, lit from outside: with plain paths it has thirty times the error after as many passes.
    #[test]
    fn guided_paths_pay_in_a_room_lit_through_a_window_whatever_the_seed() {
        let wall = |low, high| (cuboid(low, high), lambert(0.5));
        let walls = [
            wall([-8.0, -0.2, -8.0], [8.0, 0.0, 8.0]),
            wall([-2.2, 3.0, -2.2], [2.2, 3.2, 2.2]),
            wall([-2.2, 0.0, -2.2], [-2.0, 3.0, 2.2]),
            wall([-2.0, 0.0, 2.0], [2.0, 3.0, 2.2]),
            wall([-2.0, 0.0, -2.2], [2.0, 3.0, -2.0]),
            // Around the window.
            wall([2.0, 0.0, -2.2], [2.2, 1.0, 2.2]),
            wall([2.0, 2.0, -2.2], [2.2, 3.0, 2.2]),
            wall([2.0, 1.0, -2.2], [2.2, 2.0, -0.5]),
            wall([2.0, 1.0, 0.5], [2.2, 2.0, 2.2]),
        ];
        let shed = Made::new(camera([-1.8, 1.5, -1.8], [1.0, 1.2, 1.5], 70.0, [128, 96]))
            .fog(0.08, 0.005)
            .in_fog()
            .object(cuboid([-8.0, -1.0, -8.0], [8.0, 12.0, 8.0]), Material::Black)
            .light(spot([7.0, 9.0, 0.0], [0.0, 1.5, 0.0], 3000.0, [20.0, 22.0]));
        let scene =
            walls.into_iter().fold(shed, |made, (shape, material)| made.object(shape, material)).scene();
        let fogs = media::all(&scene);
        for seed in 1..=12 {
            let mut tracer = PhotonTracer::new(&scene, seed, Emission::LowDiscrepancy);
            tracer.guide(of_still(&scene, &fogs).expect("light"));
            assert!(Spread::of(&tracer, &fogs, &|| false).is_some(), "seed {seed}");
        }
    }

    /// A room of fog that absorbs nothing, and a lamp five metres from the camera.
    #[test]
    fn guided_paths_pay_in_thin_fog_and_not_where_light_is_scattered_dozens_of_times() {
        let pays = [0.1, 0.3, 1.0, 1.5].map(|scattering| {
            let scene = Made::new(camera([0.0, 0.5, -5.0], [0.0; 3], 35.0, [16, 16]))
                .fog(scattering, 0.0)
                .in_fog()
                .object(cuboid([-4.0, -4.0, -6.0], [4.0; 3]), Material::Black)
                .light(point([0.5, 2.5, 0.0], 25.0))
                .scene();
            let fogs = media::all(&scene);
            let mut tracer = PhotonTracer::new(&scene, 0, Emission::LowDiscrepancy);
            tracer.guide(of_still(&scene, &fogs).expect("light"));
            Spread::of(&tracer, &fogs, &|| false).is_some()
        });
        assert_eq!(pays, [true, true, false, false]);
    }
}
