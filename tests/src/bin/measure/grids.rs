//! How many photons should carry a light field, and into how fine a grid.

use crate::rendering::{Run, error_cells, error_heads, load_both, name, print_heads};
use crate::truth::{COLUMNS, DEFINITION, Test};
use crate::{Effort, Outcome, Size};
use covbeam_session::settings::Method;
use std::path::Path;

const SHARES: [f32; 3] = [0.01, 0.1, 1.0];
const CELLS: [u32; 3] = [16, 32, 64];

pub(crate) fn run(path: &Path, reference: &Path, effort: Effort, size: Size) -> Outcome<()> {
    let (mut scene, reference) = load_both(path, reference, size)?;
    let passes = effort.passes;
    println!(
        "{}: shares of the photons that carry a light field, and voxels of the covariance grid; {passes} passes of {} light \
         paths, {} x {} pixels. {DEFINITION}. Reference: {}\n",
        name(path),
        scene.settings.photons,
        scene.camera.width,
        scene.camera.height,
        reference.origin
    );
    let mut heads = ["voxels", "share"].map(str::to_owned).to_vec();
    heads.extend(COLUMNS.map(str::to_owned));
    heads.extend(error_heads(&reference));
    heads.extend(["core-seconds", "of it light fields + grid"].map(str::to_owned));
    print_heads(&heads);
    for cells in CELLS {
        scene.grid.cells = [cells; 3];
        let test_scene = scene.clone();
        let test = Test::new(&test_scene, effort);
        for share in SHARES {
            eprintln!("{cells}³ voxels, {} % light fields", 100.0 * share);
            scene.settings.light_field_share = share;
            let mut row = vec![format!("{cells}³"), format!("{} %", 100.0 * share)];
            row.extend(test.judge(&scene.settings, passes, None).cells());
            let (picture, times) = Run::new(&scene, Method::Thesis, scene.settings.seed, passes).picture()?;
            row.extend(error_cells(&reference, &picture));
            row.extend([times.total(), times.light_fields + times.grid].map(|time| format!("{time:.1}")));
            println!("| {} |", row.join(" | "));
        }
    }
    Ok(())
}
