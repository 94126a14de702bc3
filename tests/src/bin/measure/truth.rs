//! How true the predicted spectra are, and what the pictures made with them are worth.

use crate::Effort;
use covbeam::GridLayout;
use covbeam_render::study::spectrum::{
    Analysis, BATCHES, Fluence, Options, Prediction, Shares, Verdict, compare, predict_without,
};
use covbeam_session::pass::PassTimes;
use covbeam_session::paths::operators::Operator;
use covbeam_session::scene::{Scene, Settings};

/// What the columns of [`Truth::cells`] are, for the line above a table.
pub(crate) const DEFINITION: &str = "Truth: predicted standard deviation of the fluence's spectrum within a factor of 2 of \
    the measured one, too small or too large by more, in % of the voxel-axes of 99 % of the energy that the measurement \
    decides; of all, and of those that are not flat to the grid (the rest to 100 %: no light field came by)";

/// Heads of the columns of [`Truth::cells`].
pub(crate) const COLUMNS: [&str; 7] =
    ["all: within", "too small", "too large", "not flat: within", "too small", "too large", "axes"];

/// The truth test with a fluence measured once.
pub(crate) struct Test<'a> {
    scene: &'a Scene,
    layout: GridLayout,
    paths: u32,
    fluence: Fluence,
}

impl<'a> Test<'a> {
    /// Measures the fluence in the voxels of the scene's grid.
    pub(crate) fn new(scene: &'a Scene, effort: Effort) -> Self {
        let (layout, paths) = (scene.grid, effort.paths.next_multiple_of(BATCHES));
        eprintln!("measuring the fluence of {:?} voxels with {paths} light paths", layout.cells);
        let fluence = Fluence::measure(scene, &layout, paths, scene.settings.seed, &|_| true);
        Self { scene, layout, paths, fluence: fluence.expect("never cancelled") }
    }

    /// Predicts what a render with these settings finds in its grid in its last pass, and compares. Only the settings and
    /// the operators may differ from those of the scene.
    pub(crate) fn judge(&self, settings: &Settings, passes: u32, left_out: Option<Operator>) -> Truth {
        let prediction = Prediction { passes, field_paths: field_paths(settings), seed: settings.seed };
        let Self { scene, layout, paths, fluence } = self;
        let resolved = predict_without(scene, layout, &prediction, left_out, &|_| true);
        let voxels = compare(scene, layout, &resolved.expect("never cancelled"), fluence);
        let options = Options { cells: layout.cells, prediction, paths: *paths };
        let analysis = Analysis { layout: *layout, options, voxels };
        Truth {
            all: Shares::of(&analysis, |_, _, axis| Some(axis.verdict)),
            rough: Shares::of(&analysis, |_, _, axis| (!axis.flat).then_some(axis.verdict)),
        }
    }
}

/// Result of a test.
pub(crate) struct Truth {
    all: Shares,
    rough: Shares,
}

impl Truth {
    /// See [`COLUMNS`].
    pub(crate) fn cells(&self) -> [String; 7] {
        let percent = |shares: &Shares| {
            [Verdict::Within, Verdict::TooSmall, Verdict::TooLarge]
                .map(|verdict| format!("{:.1}", 100.0 * shares.by_count(verdict)))
        };
        let ([a, b, c], [d, e, f]) = (percent(&self.all), percent(&self.rough));
        [a, b, c, d, e, f, self.rough.judged().to_string()]
    }
}

/// Light paths a pass that carry a light field, as many as in a render.
pub(crate) fn field_paths(settings: &Settings) -> u32 {
    let share = settings.photons as f32 * settings.light_field_share;
    (share.round() as u32).clamp(1, settings.photons)
}

/// Core-microseconds a light path for tracing, and those a light path with a light field on top.
pub(crate) fn microseconds(times: &PassTimes, settings: &Settings, passes: u32) -> [f64; 2] {
    let each = |seconds: f64, paths: u32| 1e6 * seconds / (f64::from(passes) * f64::from(paths));
    let fields = each(times.light_fields + times.grid, field_paths(settings));
    [each(times.trace, settings.photons), fields]
}
