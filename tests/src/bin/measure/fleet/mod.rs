//! The default method on scenes that nobody tuned: is it right, and is it ever worse than simpler ones?

pub(crate) mod grid;
mod page;
mod row;
mod table;

use crate::Outcome;
use covbeam_render::progress::Display;
use covbeam_tests::fleet::agreement::level;
use covbeam_tests::fleet::blocks::SUSPECT;
use covbeam_tests::fleet::member;
use cpu_time::ProcessTime;
use row::{Row, measure};
use std::path::PathBuf;

/// What is asked for.
pub(crate) struct Fleet {
    pub(crate) scenes: u32,
    pub(crate) seed: u32,
    pub(crate) first: u32,
    pub(crate) width: u32,
    pub(crate) seconds: Vec<f64>,
    /// Independent runs of a method at equal time.
    pub(crate) runs: u32,
    /// CPU-seconds of each half of the reference.
    pub(crate) reference: f64,
    pub(crate) out: PathBuf,
}

/// Scenes that the page shows.
const SHOWN: usize = 5;

pub(crate) fn run(fleet: &Fleet) -> Outcome<()> {
    let folder = fleet.out.join("scenes");
    let display = Display::new();
    let start = ProcessTime::now();
    let mut rows: Vec<Row> = Vec::new();
    for index in 0..fleet.scenes {
        let number = fleet.first + index;
        let share = |part: f64| (f64::from(index) + part) / f64::from(fleet.scenes);
        display.show(&format!("scene {number}"), share(0.0));
        let scene = member(fleet.seed, number, fleet.width, &folder)?;
        rows.push(measure(number, &scene, fleet, &|step, part| {
            display.show(&format!("scene {number}: {step}"), share(part));
        })?);
        // What is there already outlives a run that is stopped.
        std::fs::write(fleet.out.join("fleet.csv"), table::csv(&rows, &fleet.seconds))?;
    }
    display.finish();
    let suspects: usize = rows.iter().map(|row| row.suspects.len()).sum();
    let level = level(suspects);
    for row in &mut rows {
        row.failures = row.suspects.iter().filter(|suspect| suspect.fails(level)).copied().collect();
    }
    std::fs::write(fleet.out.join("fleet.csv"), table::csv(&rows, &fleet.seconds))?;
    let spent = start.elapsed().as_secs_f64();
    println!(
        "{} scenes of seed {}, from number {}, {} x {} pixels; {spent:.0} CPU-seconds, {:.1} a scene\n",
        fleet.scenes,
        fleet.seed,
        fleet.first,
        fleet.width,
        fleet.width,
        spent / f64::from(fleet.scenes)
    );
    table::agreement(&rows, suspects, level);
    table::rings(&rows);
    table::calibration(&rows);
    table::ratios(&rows, &fleet.seconds);
    let worst = table::worst(&rows, SHOWN);
    table::print_worst(fleet, &worst);
    page::write(fleet, &worst)?;
    println!("\nThe scenes, fleet.csv and index.html are in {}", fleet.out.display());
    println!("Suspects: p < {SUSPECT} in the first runs; see covbeam_tests::fleet::blocks");
    Ok(())
}
