//! Error against time and passes of all methods on chosen scenes, with what else a user wants to know before choosing: one page.

mod curves;
mod error_budget;
mod features;
mod files;
pub mod fit;
mod machine;
mod measure;
mod methods;
mod page;
mod palette;
mod pictures;
mod plots;
mod references;
mod scene_section;
mod spend;
mod tables;

pub use error_budget::{ErrorBudget, KindShare, PLACES, error_budget};
pub use features::{Feature, Memory};
pub use files::{csv, json};
pub use machine::Machine;
pub use measure::{PARTS, Parts, Point, Run};
pub use methods::{Compared, METHODS};
pub use page::page;
pub use plots::figure;
pub use references::{Reference, ReferenceError, RegionError};
pub use spend::{Budget, Watch};

use covbeam_session::film::{FilmError, Picture};
use covbeam_session::scene::Scene;
use serde::Serialize;
use std::path::PathBuf;

/// The method whose error is split by kind of light.
pub const LIGHT_BY_KIND: &str = "covbeam";

/// Pictures that its variance is found from, which together have as many passes as one run, two each at least.
const BUDGET_PICTURES: u32 = 4;

/// What is measured.
#[derive(Clone, Debug)]
pub struct Options {
    /// In the order of the page.
    pub methods: Vec<&'static Compared>,
    /// Runs of each method, with seeds 1, 2, …
    pub seeds: u32,
    /// CPU-seconds of the first run of a method on a scene; the others make as many passes.
    pub budget: f64,
    /// CPU-seconds of each of the two runs of a reference.
    pub reference_budget: f64,
    /// Pixels across; None: the given reference's, or `usual_width`.
    pub width: Option<u32>,
    /// Pixels across of pictures whose reference is rendered here.
    pub usual_width: u32,
    /// Folder of references.
    pub references: Option<PathBuf>,
    /// Runs fewer passes of the features.
    pub quick: bool,
    /// Whether the costs of features are measured, on the glass ball whatever the scenes are.
    pub features: bool,
}

/// A scene with its name.
#[derive(Clone, Debug)]
pub struct Subject {
    /// As its file is called, without ending.
    pub name: String,
    /// The scene.
    pub scene: Scene,
}

/// A region of a scene's pictures.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RegionInfo {
    /// Name.
    pub name: &'static str,
    /// Number of its pixels.
    pub pixels: usize,
    /// relMSE of the reference itself; None if not known.
    pub reference_noise: Option<f64>,
}

/// What was measured of a scene.
#[derive(Serialize)]
pub struct SceneResult {
    /// Name.
    pub name: String,
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Light paths a pass.
    pub photons: u32,
    /// Of those that go where the picture needs them.
    pub guided_photons: u32,
    /// Where the reference came from.
    pub reference: String,
    /// Regions, in the order of each point's errors.
    pub regions: Vec<RegionInfo>,
    /// All runs, by method, then seed.
    pub runs: Vec<Run>,
    /// Of a pass.
    pub memory: Memory,
    /// Of [`LIGHT_BY_KIND`]; None if it is not among the methods.
    pub error_budget: Option<ErrorBudget>,
    /// The reference.
    #[serde(skip)]
    pub reference_picture: Picture,
    /// (I - R) / √(R² + (0.01 mean R)²) of the first run of each method, by pixel.
    #[serde(skip)]
    pub relative_errors: Vec<(&'static str, Vec<f32>)>,
}

/// All that was measured.
#[derive(Serialize)]
pub struct Report {
    /// The command that made it, as typed.
    pub command: String,
    /// Where.
    pub machine: Machine,
    /// Names of the methods.
    pub methods: Vec<&'static str>,
    /// Runs of each method.
    pub seeds: u32,
    /// CPU-seconds of a run.
    pub budget: f64,
    /// What was not measured any more; None if all was.
    pub stopped: Option<String>,
    /// Time from start to end, by the clock \[s\].
    pub elapsed: f64,
    /// CPU time of all threads, from start to end \[s\].
    pub cpu_seconds: f64,
    /// Scenes that have at least one run.
    pub scenes: Vec<SceneResult>,
    /// Costs of features; empty if they were left out.
    pub features: Vec<Feature>,
}

/// Why a report failed.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    /// No reference.
    #[error(transparent)]
    Reference(#[from] ReferenceError),
    /// A pass that no picture can be made of.
    #[error("'{scene}', method {method}: {source}")]
    Pass {
        /// Name of the scene.
        scene: String,
        /// Name of the method.
        method: &'static str,
        /// What is wrong.
        source: FilmError,
    },
}

impl Options {
    /// CPU-seconds that a report of some scenes is allowed, each with the reference that [`Options::prepare`] found for it.
    pub fn cpu_seconds(&self, subjects: &[(Subject, Option<Reference>)]) -> f64 {
        let runs = self.methods.len() as f64 * f64::from(self.seeds) * self.budget;
        let budgets =
            if self.methods.iter().any(|method| method.name == LIGHT_BY_KIND) { self.budget } else { 0.0 };
        let missing = subjects.iter().filter(|(_, reference)| reference.is_none()).count() as f64;
        let features = if self.features { self.features_seconds() } else { 0.0 };
        subjects.len() as f64 * (runs + budgets) + missing * 2.0 * self.reference_budget + features
    }

    /// About what the features take.
    fn features_seconds(&self) -> f64 {
        if self.quick { 1.0 } else { 10.0 }
    }

    /// Where a scene's reference is, if one is given.
    fn reference_path(&self, name: &str) -> Option<PathBuf> {
        let path = self.references.as_ref()?.join(format!("{name}.exr"));
        path.exists().then_some(path)
    }

    /// Sets the size of a scene's pictures, and reads its reference where one is given.
    ///
    /// # Errors
    /// A reference that cannot be used.
    pub fn prepare(&self, subject: &mut Subject) -> Result<Option<Reference>, ReferenceError> {
        match self.reference_path(&subject.name) {
            Some(path) => Reference::load(&path, &subject.name, &mut subject.scene, self.width).map(Some),
            None => {
                subject.scene.camera.set_width(self.width.unwrap_or(self.usual_width));
                Ok(None)
            }
        }
    }
}

/// Measures scenes, each with the reference that [`Options::prepare`] found for it, and, on `glass_ball`, what features cost. Cancelled, it
/// returns what was measured until then, and [`Report::stopped`] says so.
///
/// Passes and errors do not depend on the number of threads; where a run ends does, as its budget is time.
///
/// # Errors
/// A scene that shows no light, or a pass that went wrong.
pub fn measure(
    subjects: Vec<(Subject, Option<Reference>)>,
    glass_ball: &Scene,
    options: &Options,
    command: String,
    watch: &Watch,
) -> Result<Report, ReportError> {
    let (start, cpu) = (std::time::Instant::now(), cpu_time::ProcessTime::now());
    let mut report = Report {
        command,
        machine: Machine::here(rayon::current_num_threads()),
        methods: options.methods.iter().map(|method| method.name).collect(),
        seeds: options.seeds,
        budget: options.budget,
        stopped: None,
        elapsed: 0.0,
        cpu_seconds: 0.0,
        scenes: Vec::new(),
        features: Vec::new(),
    };
    for (subject, reference) in subjects {
        let name = subject.name.clone();
        let (scene, is_whole) = measure_scene(subject, reference, options, watch)?;
        report.scenes.extend(scene);
        if !is_whole {
            report.stopped = Some(format!("stopped by the user at the scene {name}"));
            break;
        }
    }
    if options.features && report.stopped.is_none() {
        watch.begin("cost of features".to_owned(), Budget::CpuSeconds(options.features_seconds()));
        let mut glass_ball = glass_ball.clone();
        glass_ball.camera.set_width(options.width.unwrap_or(options.usual_width));
        let passes = if options.quick { 1 } else { 4 };
        match features::features(&glass_ball, passes, &|| watch.is_cancelled()) {
            Some(found) => report.features = found,
            None => report.stopped = Some("stopped by the user after the last scene".to_owned()),
        }
    }
    (report.elapsed, report.cpu_seconds) = (start.elapsed().as_secs_f64(), cpu.elapsed().as_secs_f64());
    Ok(report)
}

/// Runs on a scene.
struct Runs {
    /// By method, then seed.
    runs: Vec<Run>,
    /// As in [`SceneResult`].
    relative_errors: Vec<(&'static str, Vec<f32>)>,
    /// Whether none is missing.
    is_whole: bool,
}

/// Runs all methods on a scene with all seeds.
fn measure_runs(
    name: &str,
    scene: &Scene,
    reference: &Reference,
    options: &Options,
    watch: &Watch,
) -> Result<Runs, ReportError> {
    let mut runs: Vec<Run> = Vec::new();
    let mut relative_errors = Vec::new();
    let mut is_whole = true;
    'methods: for method in &options.methods {
        let mut budget = Budget::CpuSeconds(options.budget);
        for seed in 1..=options.seeds {
            watch.begin(format!("{name}: {}, seed {seed}", method.name), budget);
            let run = measure::run(scene, reference, method, seed, budget, watch);
            let run = run.map_err(|source| ReportError::Pass {
                scene: name.to_owned(),
                method: method.name,
                source,
            })?;
            let Some(run) = run else {
                is_whole = false;
                break 'methods;
            };
            budget = Budget::Passes(run.points.last().map_or(1, |point| point.passes));
            if seed == 1 {
                relative_errors.push((method.name, reference.relative_errors(&run.picture)));
            }
            runs.push(run);
        }
    }
    Ok(Runs { runs, relative_errors, is_whole })
}

/// The result of a scene, if there is any, and whether all of it was measured.
fn measure_scene(
    subject: Subject,
    reference: Option<Reference>,
    options: &Options,
    watch: &Watch,
) -> Result<(Option<SceneResult>, bool), ReportError> {
    let Subject { name, scene } = subject;
    let reference = match reference {
        Some(reference) => Some(reference),
        None => Reference::render(&name, &scene, Budget::CpuSeconds(options.reference_budget), watch)?,
    };
    let Some(reference) = reference else { return Ok((None, false)) };
    let Runs { runs, relative_errors, mut is_whole } =
        measure_runs(&name, &scene, &reference, options, watch)?;
    if runs.is_empty() {
        return Ok((None, false));
    }
    let mut error_budget = None;
    let of_kinds = |run: &&Run| run.method == LIGHT_BY_KIND;
    if let Some(run) = runs.iter().find(of_kinds).filter(|_| is_whole) {
        watch.begin(format!("{name}: error budget"), Budget::CpuSeconds(options.budget));
        let all = run.points.last().map_or(1, |point| point.passes);
        let passes = all.div_ceil(BUDGET_PICTURES).max(2);
        let method = Compared::named(run.method).expect("a run's method is in the table");
        error_budget =
            error_budget::error_budget(&scene, method, passes, BUDGET_PICTURES, &|| watch.is_cancelled())
                .map_err(|source| ReportError::Pass { scene: name.clone(), method: method.name, source })?;
        is_whole = error_budget.is_some();
    }
    let region = |(index, region): (usize, &crate::study::regions::Region)| RegionInfo {
        name: region.name,
        pixels: region.count(),
        reference_noise: reference.noise.as_ref().map(|noise| noise[index]),
    };
    let regions = reference.regions.iter().enumerate().map(region).collect();
    let result = SceneResult {
        width: scene.camera.width,
        height: scene.camera.height,
        photons: scene.settings.photons,
        guided_photons: scene.settings.guided_photons,
        reference: reference.origin,
        regions,
        runs,
        memory: features::memory(&scene),
        error_budget,
        reference_picture: reference.picture,
        relative_errors,
        name,
    };
    Ok((Some(result), is_whole))
}
