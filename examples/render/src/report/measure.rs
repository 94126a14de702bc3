//! Runs of the methods: errors after 1, 2, 4, 8, … passes, and what these cost.

use super::methods::Method;
use super::references::{Reference, RegionError};
use crate::film::{Film, FilmError, Picture};
use crate::pass::{PassTimes, Renderer};
use crate::scene::Scene;
use cpu_time::ProcessTime;
use serde::Serialize;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// When a run ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Budget {
    /// When the next pass, as long as the last one, would bring the run above these CPU-seconds; at least one pass.
    CpuSeconds(f64),
    /// After so many passes, > 0.
    Passes(u32),
}

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

/// What a run has used up.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Spent {
    pub(super) passes: u32,
    pub(super) cpu_seconds: f64,
    times: PassTimes,
}

/// Where a report stands, for the user, and whether the user has had enough.
pub struct Watch<'a> {
    cancelled: &'a (dyn Fn() -> bool + Sync),
    show: &'a (dyn Fn(&str, f64) + Sync),
    /// CPU-seconds that all steps may take together.
    all: f64,
    state: Mutex<State>,
}

#[derive(Default)]
struct State {
    step: String,
    /// CPU-seconds expected of the steps before, and of this one.
    before: f64,
    expected: f64,
}

impl<'a> Watch<'a> {
    /// `cancelled` is asked a few hundred times a pass; `show` is told what is done, and which share of the whole is.
    pub fn new(
        all: f64,
        cancelled: &'a (dyn Fn() -> bool + Sync),
        show: &'a (dyn Fn(&str, f64) + Sync),
    ) -> Self {
        Self { cancelled, show, all, state: Mutex::default() }
    }

    /// Whether to stop.
    pub fn is_cancelled(&self) -> bool {
        (self.cancelled)()
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The next step. A number of passes counts as no time: the run before it said how long they take.
    pub(super) fn begin(&self, step: String, budget: Budget) {
        let expected = match budget {
            Budget::CpuSeconds(seconds) => seconds,
            Budget::Passes(_) => self.state().expected,
        };
        let mut state = self.state();
        state.before += state.expected;
        state.expected = expected;
        state.step = step;
        (self.show)(&state.step, (state.before / self.all).min(1.0));
    }

    fn spent(&self, seconds: f64) {
        let state = self.state();
        (self.show)(&state.step, ((state.before + seconds.min(state.expected)) / self.all).min(1.0));
    }
}

/// Adds passes to the film until the budget is used. `already`: CPU-seconds that getting ready took. `after` is called after each pass;
/// true = it was the last. None: cancelled.
pub(super) fn spend(
    renderer: &mut Renderer,
    film: &mut Film,
    budget: Budget,
    already: f64,
    watch: &Watch,
    mut after: impl FnMut(&Spent, &Film, bool),
) -> Result<Option<Spent>, FilmError> {
    let mut spent = Spent { cpu_seconds: already, ..Spent::default() };
    loop {
        let start = ProcessTime::now();
        let Some((image, times)) = renderer.pass(spent.passes + 1, watch.cancelled) else { return Ok(None) };
        film.add(&image)?;
        let last = start.elapsed().as_secs_f64();
        spent.passes += 1;
        spent.cpu_seconds += last;
        spent.times += times;
        let ends = match budget {
            Budget::CpuSeconds(seconds) => spent.cpu_seconds + last > seconds,
            Budget::Passes(passes) => spent.passes >= passes,
        };
        watch.spent(spent.cpu_seconds);
        after(&spent, film, ends);
        if ends {
            return Ok(Some(spent));
        }
        if watch.is_cancelled() {
            return Ok(None);
        }
    }
}

/// Runs a method. None: cancelled.
///
/// # Errors
/// A pass that the film refuses.
pub(super) fn run(
    scene: &Scene,
    reference: &Reference,
    method: &Method,
    seed: u32,
    budget: Budget,
    watch: &Watch,
) -> Result<Option<Run>, FilmError> {
    let memory = super::machine::PeakMemory::watch();
    let start = ProcessTime::now();
    let mut renderer = method.renderer(scene, seed);
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
