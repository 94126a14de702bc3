//! What each operator on light fields buys.

use crate::rendering::{Run, error_cells, error_heads, load, load_both, name, print_heads};
use crate::truth::{COLUMNS, DEFINITION, Test, microseconds};
use crate::{Effort, Outcome, Size};
use covbeam_session::paths::operators::Operator;
use covbeam_session::settings::Method;
use std::path::Path;

pub(crate) fn run(path: &Path, reference: Option<&Path>, effort: Effort, size: Size) -> Outcome<()> {
    let (scene, reference) = match reference {
        Some(reference) => load_both(path, reference, size).map(|(scene, found)| (scene, Some(found)))?,
        None => (load(path, size)?, None),
    };
    let (settings, passes) = (&scene.settings, effort.passes);
    let origin = reference.as_ref().map_or("none", |reference| &reference.origin);
    let test = Test::new(&scene, effort);
    println!(
        "{}: each operator on light fields left out in turn; {passes} passes of {} light paths, {} x {} pixels. \
         {DEFINITION}. Reference: {origin}. Times are core-microseconds\n",
        name(path),
        settings.photons,
        scene.camera.width,
        scene.camera.height
    );
    let mut heads = vec!["left out".to_owned()];
    heads.extend(COLUMNS.map(str::to_owned));
    heads.extend(reference.iter().flat_map(error_heads));
    heads.extend(["trace a light path", "light field on top"].map(str::to_owned));
    print_heads(&heads);
    let mut rows = vec![("nothing", Method::Thesis, None)];
    rows.extend(Operator::ALL.map(|operator| (operator.name(), Method::Thesis, Some(operator))));
    rows.push(("all: plain beams", Method::Plain, None));
    for (label, method, left_out) in rows {
        eprintln!("left out: {label}");
        let mut cells = vec![label.to_owned()];
        cells.extend(match method {
            Method::Thesis => test.judge(settings, passes, left_out).cells(),
            _ => COLUMNS.map(|_| "–".to_owned()),
        });
        let (picture, times) =
            Run { left_out, ..Run::new(&scene, method, settings.seed, passes) }.picture()?;
        cells.extend(reference.iter().flat_map(|reference| error_cells(reference, &picture)));
        cells.extend(microseconds(&times, settings, passes).map(|time| format!("{time:.1}")));
        println!("| {} |", cells.join(" | "));
    }
    Ok(())
}
