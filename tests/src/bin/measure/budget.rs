//! Renders for a given CPU time.

use crate::Outcome;
use covbeam_session::film::{Film, Picture};
use covbeam_session::pass::Renderer;
use covbeam_session::scene::Scene;
use cpu_time::ProcessTime;

/// What a budget bought.
pub(crate) struct Spent {
    pub(crate) passes: u32,
    /// CPU-seconds, with making the picture.
    pub(crate) seconds: f64,
    pub(crate) picture: Picture,
}

/// Renders until the last of some rising budgets is spent; a pass is not begun that would end after a budget, if it took as long as
/// the last. Making the renderer counts, once.
pub(crate) fn spend<'a>(
    scene: &Scene,
    renderer: impl FnOnce() -> Renderer<'a>,
    budgets: &[f64],
) -> Outcome<Vec<Spent>> {
    let start = ProcessTime::now();
    let mut renderer = renderer();
    let mut film = Film::of_scene(scene);
    // Only its own point pays for a picture.
    let (mut points, mut pictures) = (Vec::new(), 0.0);
    let mut now = start.elapsed().as_secs_f64();
    for passes in 1.. {
        let before = now;
        let (image, _) = renderer.pass(passes, &|| false).expect("never cancelled");
        film.add(&image)?;
        now = start.elapsed().as_secs_f64() - pictures;
        while points.len() < budgets.len() && 2.0 * now - before > budgets[points.len()] {
            let making = ProcessTime::now();
            let picture = film.picture();
            let making = making.elapsed().as_secs_f64();
            pictures += making;
            points.push(Spent { passes, seconds: now + making, picture });
        }
        if points.len() == budgets.len() {
            break;
        }
    }
    Ok(points)
}
