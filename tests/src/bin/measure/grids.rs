//! How many photons should carry a light field, and into how fine a grid.

use crate::rendering::{Reference, Run, SHARPNESS, load, name};
use crate::truth::{COLUMNS, DEFINITION, Test};
use crate::{Effort, Outcome, Size};
use covbeam_render::pass::Method;
use std::path::Path;

const SHARES: [f32; 3] = [0.01, 0.1, 1.0];
const CELLS: [u32; 3] = [16, 32, 64];

pub(crate) fn run(path: &Path, reference: &Path, effort: Effort, size: Size) -> Outcome<()> {
    let mut scene = load(path, size)?;
    let reference = Reference::load(reference, &scene, Vec::new())?;
    let passes = effort.passes;
    println!(
        "{}: shares of the photons that carry a light field, and voxels of the covariance grid; {passes} passes of {} light \
         paths, {} x {} pixels. {DEFINITION}. {}\n",
        name(path),
        scene.settings.photons,
        scene.camera.width,
        scene.camera.height,
        reference.about_noise()
    );
    let errors = format!("relMSE {} | bias [%] {}", SHARPNESS.join(" | "), SHARPNESS.join(" | "));
    println!("| voxels | share | {COLUMNS} | {errors} | core-seconds | of it light fields + grid |");
    println!("|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|");
    for cells in CELLS {
        scene.grid.cells = [cells; 3];
        let test_scene = scene.clone();
        let test = Test::new(&test_scene, effort);
        for share in SHARES {
            eprintln!("{cells}³ voxels, {} % light fields", 100.0 * share);
            scene.settings.light_field_share = share;
            let truth = test.judge(&scene.settings, passes, None).cells();
            let (picture, times) =
                Run::new(&scene, Method::Adaptive, scene.settings.seed, passes).picture()?;
            let errors = reference.errors(&picture)?.cells().join(" | ");
            println!(
                "| {cells}³ | {} % | {truth} | {errors} | {:.1} | {:.1} |",
                100.0 * share,
                times.total(),
                times.light_fields + times.grid
            );
        }
    }
    Ok(())
}
