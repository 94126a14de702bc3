//! Scenes whose lengths are quarters ([`super::grid`]), and the default method held against what shares nothing with it: brute-force path
//! tracing, light tracing, and itself in the same scene with everything a hair apart.
//!
//! What a kernel blurs falls with its radius; what is wrong does not. So a suspect fails where the default differs from fresh runs of an
//! oracle, and with half the radius differs again. (That plain beams agree says nothing here: they have the same rules for what is where.)

use super::blocks::{SUSPECT, compare};
use super::rings::rings;
use super::runs::{Estimator, light_tracing_sees_all, mean, pictures};
use super::{agreement::RUNS, grid};
use crate::brute_force::BruteForce;
use covbeam_render::scene_file;
use covbeam_session::color::luminance;
use covbeam_session::film::{FilmError, Picture};
use covbeam_session::paths::{PhotonRecord, PhotonTracer, Record};
use covbeam_session::random::Emission;
use covbeam_session::scene::Scene;
use cpu_time::ProcessTime;
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use std::error::Error;
use std::fmt;
use std::path::{Path, PathBuf};

/// Candidates that are drawn for a scene before giving up.
const ATTEMPTS: u64 = 64;

/// Pixels across, and paths a pixel, of a first look.
const LOOK: (u32, u32) = (16, 16);
/// Least correlation of two looks, and least share of the picture that is bright, as in the pilot of the fleet.
const REPEATED: f64 = 0.3;
const BRIGHT_SHARE: f64 = 0.03;

/// A scene of the snapped fleet.
pub struct Snapped {
    /// As the renderer reads it.
    pub scene: Scene,
    /// The same, a hair apart.
    pub apart: Scene,
    /// The oracle, where it finds all light.
    pub brute_force: Option<BruteForce>,
    /// The scene file; that of the scene a hair apart has `-apart` behind its number.
    pub path: PathBuf,
}

/// Makes scene `number` of the snapped fleet of `seed` as `FOLDER/NNN.toml`, and `FOLDER/NNN-apart.toml`.
///
/// Candidates whose picture would be black, or a dot, are passed over.
///
/// # Errors
/// Files that cannot be written; scenes that are not understood; no candidate that gives a picture.
pub fn snapped(seed: u32, number: u32, width: u32, folder: &Path) -> Result<Snapped, Box<dyn Error>> {
    std::fs::create_dir_all(folder)?;
    for attempt in 0..ATTEMPTS {
        let key = [u64::from(seed), u64::from(number), attempt];
        let [text, apart] = [false, true].map(|is_apart| grid::scene(key, width, is_apart));
        let brute_force = BruteForce::parse(&text)?;
        if brute_force.is_all_found() && !shows_something(&text)? {
            continue;
        }
        let read = |text: &str, ending: &str| -> Result<(Scene, PathBuf), Box<dyn Error>> {
            let path = folder.join(format!("{number:03}{ending}.toml"));
            std::fs::write(&path, text)?;
            Ok((scene_file::parse(text, &path.display().to_string(), folder)?, path))
        };
        let (scene, path) = read(&text, "")?;
        let (apart, _) = read(&apart, "-apart")?;
        let brute_force = brute_force.is_all_found().then_some(brute_force);
        return Ok(Snapped { scene, apart, brute_force, path });
    }
    Err(format!("no candidate for scene {number} of seed {seed} gives a picture").into())
}

fn shows_something(text: &str) -> Result<bool, String> {
    let mut scene = BruteForce::parse(text)?;
    scene.set_size([LOOK.0; 2]);
    let [first, second] = [1, 2].map(|seed| -> Vec<f64> {
        scene.picture(seed, LOOK.1).radiance.iter().map(|value| f64::from(luminance(*value))).collect()
    });
    let product = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
    let (sum, count) = (first.iter().sum::<f64>(), first.len() as f64);
    let repeated = product(&first, &second) / (product(&first, &first) * product(&second, &second)).sqrt();
    Ok(repeated > REPEATED && sum * sum > BRIGHT_SHARE * count * product(&first, &first))
}

/// What the default is held against.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Oracle {
    /// Brute-force path tracing.
    BruteForce,
    /// Light tracing.
    Light,
    /// The default in the scene a hair apart.
    Apart,
}

impl Oracle {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::BruteForce, Self::Light, Self::Apart];
}

impl fmt::Display for Oracle {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::BruteForce => "brute force",
            Self::Light => "light tracing",
            Self::Apart => "a hair apart",
        })
    }
}

/// A block or ring that the first runs made suspect.
#[derive(Clone, Copy, Debug)]
pub struct Doubt {
    /// Blocks row by row, and then the rings.
    pub region: usize,
    /// What it differs from.
    pub against: Oracle,
    /// p-values of fresh runs of the default, and of it with half the radius.
    pub p: [f64; 2],
    /// Brightness over the oracle's, of both.
    pub ratio: [f64; 2],
}

impl Doubt {
    /// Whether the default is wrong there.
    pub fn fails(&self, level: f64) -> bool {
        self.p.iter().all(|p| *p < level)
    }
}

/// Part of the picture's brightness, in the channel that has most, by which no run of the default may stray in any from the median of its runs:
/// where the mean is right, as that of rare runs with all of what others lack is. Means of whole pictures of sound runs are within some 10 %; where
/// few passes fit they differ by more, and by this many times what is usual among them one of a thousand does.
const STRAY: f64 = 0.5;
const UNUSUAL: f64 = 5.0;

/// A light path weighs at most so many times what it started with, in any channel, as `photon/weight.rs` of the renderer states, with rounding.
const HEAVIEST: f32 = 24.1;

/// Paths that are weighed.
const WEIGHED: u32 = 5_000;

/// What was found.
pub struct Findings {
    /// Blocks and rings that the first runs made suspect, of fresh runs.
    pub doubts: Vec<Doubt>,
    /// The oracles that could be asked.
    pub asked: Vec<Oracle>,
    /// Of [`RUNS`] pictures of the default, those that stray by more than half in a channel.
    pub strays: usize,
    /// Largest weight of a light path in any channel, over what it started with and by what of it can come to where there is anything.
    pub heaviest: f32,
}

impl Findings {
    /// Whether the default is wrong, or may be once in many pictures.
    pub fn fails(&self, level: f64) -> bool {
        self.strays > 0 || self.is_too_heavy() || self.doubts.iter().any(|doubt| doubt.fails(level))
    }

    /// Whether a light path weighs more than any may.
    pub fn is_too_heavy(&self) -> bool {
        self.heaviest > HEAVIEST
    }
}

fn heaviest(scene: &Scene) -> f32 {
    let mut scene = scene.clone();
    // What weights are bounded for.
    scene.settings.bounces = Some(1_000);
    let outside = scene.outside.map_or(Vec3::ZERO, |medium| {
        let fog = &scene.media[medium as usize].medium;
        fog.scattering + fog.absorption
    });
    let camera = scene.camera.position;
    let corners = scene.objects.iter().map(|object| object.shape.bounds());
    let corners = corners.chain(scene.lights.iter().map(|lamp| (lamp.position(), lamp.position())));
    let (min, max) = corners.fold((camera, camera), |(min, max), (low, high)| (min.min(low), max.max(high)));
    let tracer = PhotonTracer::new(&scene, 0, Emission::LowDiscrepancy);
    let of_path = |index: u32| {
        let mut record = PhotonRecord::default();
        tracer.trace(0, index, WEIGHED, Record::Beams, &mut record);
        let start = DVec3::from(record.energy.emitted).as_vec3();
        let weight = |place: Vec3, power: Vec3| {
            let arrives = (-outside * place.distance(place.clamp(min, max))).exp();
            let weight = Vec3::select(start.cmpgt(Vec3::ZERO), power * arrives / start, Vec3::ZERO);
            weight.max_element()
        };
        let beams = record.beams.iter().map(|path| weight(path.beam.origin, path.beam.power));
        let surface = record.surface.iter().map(|photon| weight(photon.position, photon.power));
        beams.chain(surface).fold(0.0, f32::max)
    };
    (0..WEIGHED).into_par_iter().map(of_path).reduce(|| 0.0, f32::max)
}

fn strays(pictures: &[Picture]) -> usize {
    let middle = |numbers: &[f64]| {
        let mut sorted = numbers.to_vec();
        sorted.sort_by(f64::total_cmp);
        sorted[sorted.len() / 2]
    };
    let of_channel = |channel: usize| -> (f64, Vec<f64>) {
        let mean =
            |picture: &Picture| picture.radiance.iter().map(|value| f64::from(value[channel])).sum::<f64>();
        let means: Vec<f64> = pictures.iter().map(mean).collect();
        let median = middle(&means);
        (median, means.iter().map(|mean| (mean - median).abs()).collect())
    };
    let channels = [0, 1, 2].map(of_channel);
    let brightest = channels.iter().map(|channel| channel.0).fold(0.0, f64::max);
    let strays = |run: &usize| {
        channels.iter().any(|(_, off)| off[*run] > STRAY * brightest && off[*run] > UNUSUAL * middle(off))
    };
    (0..pictures.len()).filter(strays).count()
}

/// How much is done.
#[derive(Clone, Copy, Debug)]
pub struct Effort {
    /// CPU-seconds of all runs of an oracle, about.
    pub seconds: f64,
    /// Most passes, and paths a pixel, of a run: what the time of a run, which is never twice the same, does not decide where they are few.
    pub most: u32,
}

/// Holds the default against all oracles that can be asked.
///
/// # Errors
/// A pass that is not finite.
pub fn examine(of: &Snapped, effort: Effort) -> Result<Findings, FilmError> {
    let narrow = |scene: &Scene| {
        let mut scene = scene.clone();
        scene.settings.schedule.radius *= 0.5;
        // The bias goes with the square of the radius.
        scene.settings.schedule.error *= 0.25;
        scene
    };
    let narrowed = narrow(&of.scene);
    // Step 0 suspects, step 1 judges, by four times as much: of few passes a block may have all of its light in one run of many. Seeds of a method and
    // step never meet those of another.
    let efforts = [effort, Effort { seconds: 4.0 * effort.seconds, most: effort.most.saturating_mul(4) }];
    let few = passes(&of.scene, Estimator::Default, efforts[0])?;
    let many = few.saturating_mul(4);
    let default = |scene: &Scene, first: u32, step: u32| {
        pictures(scene, Estimator::Default, first..first + RUNS, if step == 0 { few } else { many })
    };
    let runs_of = |oracle: Oracle, step: u32| -> Result<Option<Vec<Picture>>, FilmError> {
        Ok(match oracle {
            Oracle::BruteForce => of
                .brute_force
                .as_ref()
                .map(|scene| traced(scene, 2_000 + RUNS * step, efforts[step as usize])),
            Oracle::Light if light_tracing_sees_all(&of.scene) && of.scene.camera.is_pinhole() => {
                let passes = self::passes(&of.scene, Estimator::Light, efforts[step as usize])?;
                let first = 3_000 + RUNS * step;
                Some(pictures(&of.scene, Estimator::Light, first..first + RUNS, passes)?)
            }
            Oracle::Light => None,
            Oracle::Apart => Some(default(&of.apart, 4_000 + RUNS * step, step)?),
        })
    };
    let tested = default(&of.scene, 1_000, 0)?;
    let (mut doubts, mut asked, mut fresh) = (Vec::new(), Vec::new(), None);
    for oracle in Oracle::ALL {
        let Some(others) = runs_of(oracle, 0)? else { continue };
        asked.push(oracle);
        let rings = rings(&mean(&others));
        let suspects: Vec<usize> = compare(&tested, &others, &rings)
            .iter()
            .enumerate()
            .filter_map(|(region, verdict)| (verdict.p < SUSPECT).then_some(region))
            .collect();
        if suspects.is_empty() {
            continue;
        }
        if fresh.is_none() {
            fresh = Some([default(&of.scene, 1_000 + RUNS, 1)?, default(&narrowed, 5_000, 1)?]);
        }
        let [wide, narrow] = fresh.as_ref().expect("made above");
        let others = runs_of(oracle, 1)?.expect("was there before");
        let wide = compare(wide, &others, &rings);
        // Both of a scene and of the same a hair apart are blurred alike.
        let narrow = if oracle == Oracle::Apart { wide.clone() } else { compare(narrow, &others, &rings) };
        doubts.extend(suspects.into_iter().map(|region| {
            let both = [wide[region], narrow[region]];
            Doubt {
                region,
                against: oracle,
                p: both.map(|verdict| verdict.p),
                ratio: both.map(|verdict| verdict.ratio),
            }
        }));
    }
    Ok(Findings { doubts, asked, strays: strays(&tested), heaviest: heaviest(&of.scene) })
}

fn traced(scene: &BruteForce, first: u32, effort: Effort) -> Vec<Picture> {
    let start = ProcessTime::now();
    scene.picture(0, 2);
    let a_path = 0.5 * start.elapsed().as_secs_f64();
    let paths = power_of_two(effort.seconds / (f64::from(RUNS) * a_path)).min(effort.most);
    (first..first + RUNS).map(|seed| scene.picture(seed, paths)).collect()
}

fn passes(scene: &Scene, estimator: Estimator, effort: Effort) -> Result<u32, FilmError> {
    let start = ProcessTime::now();
    // With what comes before the first pass.
    pictures(scene, estimator, 0..1, 2)?;
    let a_pass = 0.5 * start.elapsed().as_secs_f64();
    Ok(power_of_two(effort.seconds / (f64::from(RUNS) * a_pass)).clamp(2, effort.most.max(2)))
}

fn power_of_two(number: f64) -> u32 {
    2_f64.powf(number.log2().round().clamp(0.0, 12.0)) as u32
}
