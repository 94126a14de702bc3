//! Whether guided light paths are worth more than plain ones: a trial of both.
//!
//! Guided paths are to bring about as much of the picture each as any other. In thick fog light is scattered dozens of times on its way to the
//! camera, and as many random decisions to split a path or to end it leave few trees that arrive, with thousands of branches: plain paths are
//! more alike there, and cost a tenth.

use super::{Guidance, mean};
use crate::kind::Kind;
use crate::photon::{PhotonTracer, Record};
use crate::random::Emission;
use crate::record::PhotonRecord;
use crate::scene::Scene;
use crate::straight::is_left_to_beams;
use covbeam::Medium;

/// Plain paths.
const PATHS: u32 = 2048;

/// Sequence of plain paths.
const SEQUENCE: u32 = 0x7e57;

/// Whether what guided paths bring about is more evenly theirs than that of plain ones.
///
/// - `worth`: of guided paths, their [`worth`]. Cost: of 2048 plain paths.
pub(super) fn pays(guidance: &Guidance, scene: &Scene, fogs: &[Medium], guided: &[f32]) -> bool {
    let tracer = PhotonTracer::new(scene, 0, Emission::LowDiscrepancy);
    let plain = (0..PATHS).map(|index| {
        let mut record = PhotonRecord::default();
        tracer.trace(SEQUENCE, index, PATHS, Record::Beams, &mut record);
        worth(guidance, scene, fogs, &record, [0, 0])
    });
    evenness(guided) >= evenness(&plain.collect::<Vec<f32>>())
}

/// How much of the picture's light, relative to its brightness, the paths of a record bring about that are not straight from lamps.
///
/// - `from`: the first beam and surface photon that count.
pub(super) fn worth(
    guidance: &Guidance,
    scene: &Scene,
    fogs: &[Medium],
    record: &PhotonRecord,
    from: [usize; 2],
) -> f32 {
    let importance = guidance.importance();
    let of_beams = record.beams[from[0]..].iter().map(|path| {
        if path.kind == Kind::Straight && !is_left_to_beams(scene, path.medium) {
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
    use super::super::Spread;
    use super::*;
    use crate::media;
    use std::path::Path;

    /// None but one that brings all, all of them the same, and numbers w = u² with the density 1/(2√w): Σ√w = n/2 and Σw = n/3.
    #[test]
    fn evenness_is_the_share_of_paths_that_count() {
        let squares: Vec<f32> = (0..1000).map(|i| ((i as f32 + 0.5) / 1000.0).powi(2)).collect();
        assert_eq!([evenness(&[]), evenness(&[0.0; 4]), evenness(&[0.0, 4.0, 0.0, 0.0])], [0.0, 0.0, 0.25]);
        assert!((evenness(&[3.0; 9]) - 1.0).abs() < 1e-12);
        assert!((evenness(&squares) - 0.75).abs() < 1e-5);
    }

    /// A room of fog that absorbs nothing, and a lamp five metres from the camera.
    #[test]
    fn guided_paths_pay_in_thin_fog_and_not_where_light_is_scattered_dozens_of_times() {
        let pays = [0.1, 0.3, 1.0, 1.5].map(|scattering| {
            let text = format!(
                "outside_medium = \"fog\"\n\
                 [camera]\nposition = [0, 0.5, -5]\nlook_at = [0, 0, 0]\nvertical_fov = 35\nwidth = 16\nheight = 16\n\
                 [[medium]]\nname = \"fog\"\nscattering = {scattering}\nabsorption = 0.0\n\
                 [[object]]\nshape = \"box\"\nmin = [-4, -4, -6]\nmax = [4, 4, 4]\nmaterial = \"black\"\n\
                 [[light]]\nkind = \"point\"\nposition = [0.5, 2.5, 0]\nintensity = 25\n"
            );
            let scene = Scene::parse(&text, "room", Path::new("")).expect("a valid scene");
            let fogs = media::all(&scene);
            let mut tracer = PhotonTracer::new(&scene, 0, Emission::LowDiscrepancy);
            tracer.guide(Guidance::new(&scene, &fogs).expect("light"));
            Spread::of(&tracer, &fogs).is_some()
        });
        assert_eq!(pays, [true, true, false, false]);
    }
}
