//! Runs of the methods: errors after 1, 2, 4, 8, … passes, and what these cost.

use super::methods::Compared;
use super::references::{Reference, RegionError};
use super::spend::{Budget, Watch, spend};
use covbeam_session::film::{Film, FilmError, Picture};
use covbeam_session::pass::{PassTimes, Renderer};
use covbeam_session::scene::Scene;
use cpu_time::ProcessTime;
use serde::Serialize;

/// A method's errors after some passes of a run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Point {
    /// Passes so far.
    pub passes: u32,
    /// CPU time of all threads so far, and of making the picture once; measuring errors is left out.
    pub cpu_seconds: f64,
    /// By region, in the order of the scene's regions.
    pub errors: Vec<RegionError>,
}

/// Core-seconds by part of a run, with the names of [`PassTimes`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Parts {
    /// Photon paths.
    pub trace: f64,
    /// Light fields and edge probes.
    pub light_fields: f64,
    /// Grid deposits and resolve.
    pub grid: f64,
    /// Hierarchies over beams and surface photons.
    pub build: f64,
    /// The spectrum of the picture.
    pub plan: f64,
    /// Eye rays, gather and shading.
    pub gather: f64,
    /// Accepted pairs of beam and eye ray.
    pub pairs: u64,
}

/// Names of the parts of a pass that take time, in the order of [`Parts::seconds`].
pub const PARTS: [&str; 6] = ["trace", "light fields", "grid", "build", "plan", "gather"];

impl Parts {
    /// In the order of [`PARTS`].
    pub fn seconds(&self) -> [f64; 6] {
        [self.trace, self.light_fields, self.grid, self.build, self.plan, self.gather]
    }

    /// Core-seconds of all parts.
    pub fn total(&self) -> f64 {
        self.seconds().iter().sum()
    }

    /// Of each part the lesser time.
    pub(super) fn least(&self, other: &Self) -> Self {
        Self {
            trace: self.trace.min(other.trace),
            light_fields: self.light_fields.min(other.light_fields),
            grid: self.grid.min(other.grid),
            build: self.build.min(other.build),
            plan: self.plan.min(other.plan),
            gather: self.gather.min(other.gather),
            pairs: self.pairs,
        }
    }

    /// The mean of `passes` passes, > 0.
    pub fn a_pass(&self, passes: u32) -> Self {
        let [trace, light_fields, grid, build, plan, gather] = self.seconds().map(|s| s / f64::from(passes));
        Self { trace, light_fields, grid, build, plan, gather, pairs: self.pairs / u64::from(passes) }
    }
}

impl From<PassTimes> for Parts {
    fn from(times: PassTimes) -> Self {
        let PassTimes { trace, light_fields, grid, build, plan, gather, pairs, .. } = times;
        Self { trace, light_fields, grid, build, plan, gather, pairs }
    }
}

/// One run of a method.
#[derive(Clone, Debug, Serialize)]
pub struct Run {
    /// The method's name.
    pub method: &'static str,
    /// Seed.
    pub seed: u32,
    /// With rising passes.
    pub points: Vec<Point>,
    /// Where the time of the passes went, by a clock: other programs on the same cores make it longer.
    pub parts: Parts,
    /// Largest resident set of the program during the run \[bytes\]; None where the system does not tell.
    pub peak_memory: Option<u64>,
    /// At the end.
    #[serde(skip)]
    pub picture: Picture,
}

/// Runs a method. None: cancelled.
///
/// # Errors
/// A pass that the film refuses.
pub(super) fn run(
    scene: &Scene,
    reference: &Reference,
    method: &Compared,
    seed: u32,
    budget: Budget,
    watch: &Watch,
) -> Result<Option<Run>, FilmError> {
    let memory = super::machine::PeakMemory::watch();
    let start = ProcessTime::now();
    let mut renderer = Renderer::new(scene, method.settings(scene, seed));
    let mut film = Film::of_scene(scene);
    let already = start.elapsed().as_secs_f64();
    let mut points = Vec::new();
    let mut last_picture = None;
    let spent = spend(&mut renderer, &mut film, budget, already, watch, |spent, film, is_last| {
        if is_last || spent.passes.is_power_of_two() {
            let start = ProcessTime::now();
            let picture = film.picture();
            let cpu_seconds = spent.cpu_seconds + start.elapsed().as_secs_f64();
            points.push(Point { passes: spent.passes, cpu_seconds, errors: reference.errors(&picture) });
            last_picture = Some(picture);
        }
    })?;
    let (Some(spent), Some(picture)) = (spent, last_picture) else { return Ok(None) };
    let peak_memory = memory.and_then(|memory| memory.bytes());
    Ok(Some(Run { method: method.name, seed, points, parts: spent.times.into(), peak_memory, picture }))
}
