//! What each operator on light fields buys.

use crate::rendering::{Reference, Run, SHARPNESS, load, name};
use crate::truth::{COLUMNS, DEFINITION, Test, microseconds};
use crate::{Effort, Outcome, Size};
use covbeam_render::operators::Operator;
use covbeam_render::pass::Method;
use std::path::Path;

pub(crate) fn run(path: &Path, reference: Option<&Path>, effort: Effort, size: Size) -> Outcome<()> {
    let scene = load(path, size)?;
    let reference = reference.map(|reference| Reference::load(reference, &scene, Vec::new())).transpose()?;
    let (settings, passes) = (&scene.settings, effort.passes);
    let noise = reference.as_ref().map_or_else(|| "No reference".to_owned(), Reference::about_noise);
    let test = Test::new(&scene, effort);
    println!(
        "{}: each operator on light fields left out in turn; {passes} passes of {} light paths, {} x {} pixels. {DEFINITION}. {noise}. \
         Times are core-microseconds\n",
        name(path),
        settings.photons,
        scene.camera.width,
        scene.camera.height
    );
    let errors = format!("relMSE {} | bias [%] {}", SHARPNESS.join(" | "), SHARPNESS.join(" | "));
    println!("| left out | {COLUMNS} | {errors} | trace a light path | light field on top |");
    println!("|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|");
    let mut rows = vec![("nothing", Method::Adaptive, None)];
    rows.extend(Operator::ALL.map(|operator| (operator.name(), Method::Adaptive, Some(operator))));
    rows.push(("all: plain beams", Method::Ppb, None));
    for (label, method, left_out) in rows {
        eprintln!("left out: {label}");
        let truth = match method {
            Method::Adaptive => test.judge(settings, passes, left_out).cells(),
            _ => ["–"; 7].join(" | "),
        };
        let (picture, times) =
            Run { left_out, ..Run::new(&scene, method, settings.seed, passes) }.picture()?;
        let errors = match &reference {
            Some(reference) => reference.errors(&picture)?.cells().join(" | "),
            None => ["–"; 6].join(" | "),
        };
        let [trace, field] = microseconds(&times, settings, passes);
        println!("| {label} | {truth} | {errors} | {trace:.1} | {field:.1} |");
    }
    Ok(())
}
