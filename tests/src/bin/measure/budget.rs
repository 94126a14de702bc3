//! Renders for a given CPU time.

use crate::Outcome;
use crate::rendering::cpu_seconds;
use covbeam_render::film::{Film, Picture};
use covbeam_render::pass::Renderer;
use covbeam_render::scene::Scene;

/// What a budget bought.
pub(crate) struct Spent {
    pub(crate) passes: u32,
    /// CPU-seconds, with making the picture.
    pub(crate) seconds: f64,
    pub(crate) picture: Picture,
}

/// Renders until the last of some rising budgets is spent; a pass is not begun that would end after a budget, if it took as long as
/// the last. Making the renderer counts.
pub(crate) fn spend<'a>(
    scene: &Scene,
    renderer: impl FnOnce() -> Renderer<'a>,
    budgets: &[f64],
) -> Outcome<Vec<Spent>> {
    let mut start = cpu_seconds()?;
    let mut renderer = renderer();
    let mut film = Film::of_scene(scene);
    let (mut points, mut now) = (Vec::new(), 0.0);
    for passes in 1.. {
        let before = now;
        let (image, _) = renderer.pass(passes, &|| false).expect("never cancelled");
        film.add(&image)?;
        now = cpu_seconds()? - start;
        while points.len() < budgets.len() && 2.0 * now - before > budgets[points.len()] {
            let unspent = cpu_seconds()?;
            let picture = film.picture();
            let making = cpu_seconds()? - unspent;
            // Only its own point pays for a picture.
            start += making;
            points.push(Spent { passes, seconds: now + making, picture });
        }
        if points.len() == budgets.len() {
            break;
        }
    }
    Ok(points)
}
