//! What a render would use: the covariance grid after some passes.

use covbeam::{FluenceCell, GridLayout};
use covbeam_session::pass::Renderer;
use covbeam_session::paths::operators::Operator;
use covbeam_session::scene::Scene;
use covbeam_session::settings::{Method, Settings};

/// How the predicted spectra are made, as in a render.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prediction {
    /// Passes, > 0.
    pub passes: u32,
    /// Light paths a pass that carry a light field, > 0.
    pub field_paths: u32,
    /// Of the random numbers.
    pub seed: u32,
}

/// The resolved covariance grid: the same spectra as in a render's last pass. `report` as in
/// [`super::Fluence::measure`].
///
/// Guarantee: the same bits for any number of threads.
///
/// # Panics
/// If `layout` is not sound.
pub fn predict(
    scene: &Scene,
    layout: &GridLayout,
    prediction: &Prediction,
    report: &(dyn Fn(u32) -> bool + Sync),
) -> Option<Vec<FluenceCell>> {
    predict_without(scene, layout, prediction, None, report)
}

/// Like [`predict`], with an operator left out of all light fields, to see what it buys.
///
/// # Panics
/// If `layout` is not sound.
pub fn predict_without(
    scene: &Scene,
    layout: &GridLayout,
    prediction: &Prediction,
    left_out: Option<Operator>,
    report: &(dyn Fn(u32) -> bool + Sync),
) -> Option<Vec<FluenceCell>> {
    let Prediction { passes, field_paths, seed } = *prediction;
    let mut scene = scene.clone();
    scene.grid = *layout;
    // All paths of such a render carry a light field.
    scene.settings.light_field_share = 1.0;
    let settings = Settings { left_out, ..Settings::of(Method::Thesis, field_paths, seed) };
    Renderer::new(&scene, settings).spectra(passes, report)
}
