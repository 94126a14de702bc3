//! What the page says of one scene.

use super::curves::Over;
use super::plots::{error_panel, part_bars};
use super::tables::escape;
use super::{SceneResult, pictures, tables};
use crate::study::plot::PlotError;
use std::fmt::Write;

/// An SVG inside the page, with a description for those who cannot see it.
pub(super) fn inline(svg: &str, alt: &str) -> String {
    let start = svg.find("<svg").unwrap_or(0);
    svg[start..].replacen("<svg ", &format!("<svg role=\"img\" aria-label=\"{}\" ", escape(alt)), 1)
}

/// All of it; `id` is the anchor.
pub(super) fn section(scene: &SceneResult, id: &str) -> Result<String, PlotError> {
    let name = escape(&scene.name);
    let mut html = format!(
        "<section id=\"{id}\"><h2>{name}</h2>\n<p>{} × {} pixels, {} light paths a pass, {} of guided ones. Reference: {}.</p>\n",
        scene.width,
        scene.height,
        scene.photons,
        scene.guided_photons,
        escape(&scene.reference)
    );
    for (over, title) in [(Over::CpuTime, "Error over CPU time"), (Over::Passes, "Error over passes")] {
        let _ = write!(html, "<h3>{title}</h3>\n<div class=\"panels\">");
        for (index, region) in scene.regions.iter().enumerate() {
            match error_panel(scene, index, region.name, over)? {
                Some(svg) => {
                    html += &inline(&svg, &format!("{title}, {}, region {}", scene.name, region.name))
                }
                None => {
                    let _ = write!(html, "<p class=\"note\">{}: no error above its noise.</p>", region.name);
                }
            }
        }
        html += "</div>\n";
    }
    html += &tables::equal_time(scene);
    html += &tables::time_to_error(scene);
    html += &tables::error_budget(scene);
    let _ = write!(
        html,
        "<h3>Pictures at the end of the first runs</h3>\n{}\
         <h3>Their relative errors</h3>\n<p class=\"note\">Blue: too dark, red: too bright; on one scale, which 2 % of the errors exceed.</p>\n{}",
        pictures::previews(scene),
        pictures::errors(scene)
    );
    let maps = pictures::maps(scene);
    if !maps.is_empty() {
        let _ = write!(
            html,
            "<h3>What the covariances say</h3>\n<p class=\"note\">Logarithmic; black: no value. The radius and the bandwidth are means over the \
             beams that an eye ray met, weighted by their light.</p>\n{maps}"
        );
    }
    let first_runs = scene.runs.iter().filter(|run| run.seed == 1);
    let rows: Vec<_> = first_runs
        .map(|run| (run.method, run.parts.a_pass(run.points.last().map_or(1, |point| point.passes))))
        .collect();
    let _ = write!(
        html,
        "<h3>Where the time goes, and memory</h3>\n<div class=\"panels\">{}</div>\n{}</section>\n",
        inline(&part_bars(&rows)?, &format!("core-milliseconds a pass by part, {}", scene.name)),
        tables::parts(scene)
    );
    Ok(html)
}
