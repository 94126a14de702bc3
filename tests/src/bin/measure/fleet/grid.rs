//! The default method on scenes that are made as people make them.

use crate::Outcome;
use covbeam_render::progress::Display;
use covbeam_tests::fleet::agreement::{RUNS, level};
use covbeam_tests::fleet::snapped::{Doubt, Effort, Findings, Oracle, examine, snapped};
use cpu_time::ProcessTime;
use std::fmt::Write;
use std::ops::Range;
use std::path::Path;

struct Row {
    number: u32,
    found: Findings,
    seconds: f64,
}

/// `seconds`: CPU-seconds of all runs of the default, or of an oracle, for a scene.
pub(crate) fn run(seed: u32, numbers: Range<u32>, width: u32, seconds: f64, out: &Path) -> Outcome<()> {
    let folder = out.join("scenes");
    let effort = Effort { seconds, most: u32::MAX };
    let display = Display::new();
    let count = numbers.len();
    let mut rows = Vec::new();
    for (index, number) in numbers.clone().enumerate() {
        display.show(&format!("scene {number}"), index as f64 / count as f64);
        let start = ProcessTime::now();
        let scene = snapped(seed, number, width, &folder)?;
        let found = examine(&scene, effort)?;
        rows.push(Row { number, found, seconds: start.elapsed().as_secs_f64() });
        // What is there already outlives a run that is stopped.
        std::fs::write(out.join("grid.csv"), csv(&rows))?;
    }
    display.finish();
    let suspects = rows.iter().map(|row| row.found.doubts.len()).sum();
    let level = level(suspects);
    let heaviest = rows.iter().map(|row| row.found.heaviest).fold(0.0, f32::max);
    let spent: f64 = rows.iter().map(|row| row.seconds).sum();
    println!(
        "{count} snapped scenes of seed {seed}, from number {}, {width} x {width} pixels; {spent:.0} CPU-seconds\n",
        numbers.start
    );
    println!(
        "{suspects} suspects, judged at p = {level:.1e}; no light path weighs more than {heaviest:.1} times what it started with\n"
    );
    println!(
        "| scene | against | failing blocks and rings | worst, default over oracle | with half the radius |\n|---|---|---|---|---|"
    );
    let mut wrong = [0; 3];
    for row in &rows {
        for (oracle, wrong) in Oracle::ALL.into_iter().zip(&mut wrong) {
            let failing =
                row.found.doubts.iter().filter(|doubt| doubt.against == oracle && doubt.fails(level));
            let failing: Vec<&Doubt> = failing.collect();
            let off = |doubt: &&&Doubt| doubt.ratio[0].ln().abs();
            if let Some(worst) = failing.iter().max_by(|a, b| off(a).total_cmp(&off(b))) {
                *wrong += 1;
                let [wide, narrow] = worst.ratio;
                println!("| {:03} | {oracle} | {} | {wide:.3} | {narrow:.3} |", row.number, failing.len());
            }
        }
        if row.found.strays > 0 {
            println!(
                "| {:03} | the median of its runs | {} of {RUNS} pictures | | |",
                row.number, row.found.strays
            );
        }
        if row.found.is_too_heavy() {
            println!(
                "| {:03} | what paths start with | one weighs {:.0} times that | | |",
                row.number, row.found.heaviest
            );
        }
    }
    println!();
    for (oracle, wrong) in Oracle::ALL.into_iter().zip(wrong) {
        let asked = rows.iter().filter(|row| row.found.asked.contains(&oracle)).count();
        println!("{oracle}: {wrong} of {asked} scenes differ");
    }
    println!(
        "{} of {count} scenes fail; they are in {}",
        rows.iter().filter(|row| row.found.fails(level)).count(),
        folder.display()
    );
    Ok(())
}

fn csv(rows: &[Row]) -> String {
    let mut text = "scene,against,region,p,p_narrow,ratio,ratio_narrow,cpu_s\n".to_owned();
    for row in rows {
        for Doubt { region, against, p, ratio } in &row.found.doubts {
            let _ = writeln!(
                text,
                "{},{against},{region},{:.1e},{:.1e},{:.4},{:.4},{:.2}",
                row.number, p[0], p[1], ratio[0], ratio[1], row.seconds
            );
        }
    }
    text
}
