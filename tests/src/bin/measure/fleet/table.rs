//! Tables of a fleet.

use super::Fleet;
use super::row::{Point, Row};
use covbeam_tests::fleet::agreement::Suspect;
use covbeam_tests::fleet::rings::{ENDS, Ratio};
use covbeam_tests::fleet::runs::Estimator;
use std::fmt::Write;

/// A ratio that counts as no worse.
const EQUAL: f64 = 1.05;

const AGAINST: [&str; 2] = ["plain", "every pixel"];

/// Blocks that fail, by what they were held against.
pub(super) fn agreement(rows: &[Row], suspects: usize, level: f64) {
    println!(
        "| default against | scenes | blocks and rings | suspects | failing | as blurred as plain beams | failing scenes |\n|---|---|---|---|---|---|---|"
    );
    for (name, against) in
        [("plain beams, narrow", Estimator::Reference), ("light tracing", Estimator::Light)]
    {
        let tested = || rows.iter().filter(|row| against != Estimator::Light || row.light_traced);
        let blocks: usize = tested().map(|row| row.blocks).sum();
        let of = |of: &[Suspect]| of.iter().filter(|suspect| suspect.against == against).count();
        let suspects: usize = tested().map(|row| of(&row.suspects)).sum();
        let failing: Vec<usize> = tested().map(|row| of(&row.failures)).filter(|count| *count > 0).collect();
        let blurred: usize = tested()
            .flat_map(|row| &row.suspects)
            .filter(|suspect| suspect.against == against && suspect.judged.p < level && !suspect.fails(level))
            .count();
        println!(
            "| {name} | {} | {blocks} | {suspects} | {} | {blurred} | {} |",
            tested().count(),
            failing.iter().sum::<usize>(),
            failing.len()
        );
    }
    println!(
        "\nSuspects are judged by fresh runs, rejecting below {level:.1e} (Šidák, {suspects} tests, 1 % over all blocks and rings of all scenes)."
    );
    let failing: Vec<String> = rows
        .iter()
        .filter(|row| !row.failures.is_empty())
        .map(|row| format!("{} ({})", row.number, row.failures.len()))
        .collect();
    println!(
        "Failing scenes (blocks and rings): {}",
        if failing.is_empty() { "none".to_owned() } else { failing.join(", ") }
    );
}

/// Value at a share of a sorted list.
fn quantile(sorted: &[f64], share: f64) -> f64 {
    sorted.get(((sorted.len() as f64 - 1.0) * share).round() as usize).copied().unwrap_or(f64::NAN)
}

fn sorted(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut values: Vec<f64> = values.filter(|value| !value.is_nan()).collect();
    values.sort_by(f64::total_cmp);
    values
}

const SHARES: [f64; 5] = [0.0, 0.05, 0.5, 0.95, 1.0];

/// Brightness by distance from the brightest part.
pub(super) fn rings(rows: &[Row]) {
    println!("\nBrightness by distance from the brightest part, default over plain beams, over the scenes\n");
    println!(
        "| pixels | scenes | min | 5 % | median | 95 % | max | ± median | scenes off by > 3 % and > 4 standard errors |\n|---|---|---|---|---|---|---|---|---|"
    );
    let mut from = 0.0;
    for (ring, to) in ENDS.into_iter().enumerate() {
        let found: Vec<Ratio> = rows.iter().filter_map(|row| row.rings[ring]).collect();
        let off =
            found.iter().filter(|ratio| (ratio.value - 1.0).abs() > (4.0 * ratio.error).max(0.03)).count();
        let values = sorted(found.iter().map(|ratio| ratio.value));
        let error = quantile(&sorted(found.iter().map(|ratio| ratio.error)), 0.5);
        let cells = SHARES.map(|share| format!("{:.3}", quantile(&values, share))).join(" | ");
        println!("| {from:.0}-{to:.0} | {} | {cells} | {error:.3} | {off} |", values.len());
        from = to;
    }
    let totals = sorted(rows.iter().map(|row| row.total));
    let cells = SHARES.map(|share| format!("{:.3}", quantile(&totals, share))).join(" | ");
    println!("| whole picture | {} | {cells} | | |", totals.len());
}

/// True error of the default over the one that it states.
pub(super) fn calibration(rows: &[Row]) {
    let values = sorted(rows.iter().filter_map(|row| row.calibration));
    let cells = SHARES.map(|share| format!("{:.2}", quantile(&values, share))).join(" | ");
    println!("\nTrue error over the stated one, default at the last budget, over the scenes\n");
    println!(
        "| scenes | min | 5 % | median | 95 % | max |\n|---|---|---|---|---|---|\n| {} | {cells} |",
        values.len()
    );
}

/// Error of the default over that of the others at equal CPU time.
pub(super) fn ratios(rows: &[Row], budgets: &[f64]) {
    println!(
        "\nrelMSE of the default over that of another method at equal CPU time, over the scenes; bounded: no pixel counts for more than an \
         error of 100 %\n"
    );
    println!(
        "| CPU-s | over | min | 5 % | median | 95 % | max | ± median | share <= {EQUAL} | surely worse | CPU-s spent (medians) |\n|---|---|---|---|---|---|---|---|---|---|---|"
    );
    for (budget, seconds) in budgets.iter().enumerate() {
        for (index, name) in AGAINST.into_iter().enumerate() {
            let spent = [0, index + 1].map(|method| {
                format!(
                    "{:.2}",
                    quantile(&sorted(rows.iter().map(|row| row.points[budget].seconds[method])), 0.5)
                )
            });
            for (kind, is_bounded) in [("", false), (", bounded", true)] {
                let of = |point: &Point| if is_bounded { point.bounded } else { point.ratios }[index];
                let all: Vec<Ratio> = rows.iter().map(|row| of(&row.points[budget])).collect();
                let values = sorted(all.iter().map(|ratio| ratio.value));
                let error = quantile(&sorted(all.iter().map(|ratio| ratio.error)), 0.5);
                let good =
                    values.iter().filter(|value| **value <= EQUAL).count() as f64 / values.len() as f64;
                let worse = all.iter().filter(|ratio| ratio.value - 3.0 * ratio.error > EQUAL).count();
                let cells = SHARES.map(|share| format!("{:.3}", quantile(&values, share))).join(" | ");
                println!(
                    "| {seconds} | {name}{kind} | {cells} | {error:.3} | {:.1} % | {worse} | {} |",
                    100.0 * good,
                    spent.join(", ")
                );
            }
        }
    }
    println!(
        "\n±: standard error by the jackknife over blocks. Surely worse: above {EQUAL} by three of them."
    );
}

/// The scenes to look at first: most failing blocks, then the largest ratio at the last budget.
pub(super) fn worst(rows: &[Row], count: usize) -> Vec<&Row> {
    let ratio = |row: &Row| {
        let last = row.points.last().map_or([f64::NAN; 2], |point| point.ratios.map(|ratio| ratio.value));
        last[0].max(last[1])
    };
    let mut order: Vec<&Row> = rows.iter().collect();
    order.sort_by(|a, b| {
        b.failures
            .len()
            .cmp(&a.failures.len())
            .then(ratio(b).total_cmp(&ratio(a)))
            .then(a.number.cmp(&b.number))
    });
    order.truncate(count);
    order
}

/// The command that measures a scene of the fleet again.
pub(super) fn command(fleet: &Fleet, number: u32) -> String {
    let seconds: Vec<String> = fleet.seconds.iter().map(f64::to_string).collect();
    format!(
        "measure fleet --seed {} --first {number} --scenes 1 --width {} --seconds {} --runs {} --reference {}",
        fleet.seed,
        fleet.width,
        seconds.join(","),
        fleet.runs,
        fleet.reference
    )
}

/// One line about a scene.
pub(super) fn summary(row: &Row) -> String {
    let last = row.points.last().expect("at least one budget");
    let ratios: Vec<String> = AGAINST
        .into_iter()
        .zip(last.ratios)
        .map(|(name, ratio)| format!("relMSE over {name} {:.3} ± {:.3}", ratio.value, ratio.error))
        .collect();
    let rings = row.rings.map(|ring| ring.map_or("-".to_owned(), |ring| format!("{:.2}", ring.value)));
    format!(
        "scene {}: {} of {} blocks and rings fail; {}; rings {}",
        row.number,
        row.failures.len(),
        row.blocks,
        ratios.join(", "),
        rings.join(" ")
    )
}

pub(super) fn print_worst(fleet: &Fleet, worst: &[&Row]) {
    println!("\nThe worst, and the commands that make them\n");
    for row in worst {
        println!("- {}\n  `{}`", summary(row), command(fleet, row.number));
    }
}

/// One line a scene.
pub(super) fn csv(rows: &[Row], budgets: &[f64]) -> String {
    let mut text =
        "scene,default_passes,reference_passes,light_passes,blocks,light_traced,suspects,failures,total"
            .to_owned();
    for end in ENDS {
        let _ = write!(text, ",ring_to_{end},ring_to_{end}_error");
    }
    for seconds in budgets {
        for method in ["default", "plain", "every_pixel"] {
            let _ = write!(
                text,
                ",{method}_{seconds}_passes,{method}_{seconds}_cpu_s,{method}_{seconds}_relmse,{method}_{seconds}_relmse_error"
            );
        }
        for method in ["plain", "every_pixel"] {
            let _ = write!(text, ",over_{method}_{seconds},over_{method}_{seconds}_error");
            let _ = write!(text, ",bounded_over_{method}_{seconds},bounded_over_{method}_{seconds}_error");
        }
    }
    text += ",true_over_stated,reference_noise,cpu_s\n";
    for row in rows {
        let _ = write!(
            text,
            "{},{},{},{},{},{},{},{},{}",
            row.number,
            row.passes.default,
            row.passes.reference,
            row.passes.light,
            row.blocks,
            row.light_traced,
            row.suspects.len(),
            row.failures.len(),
            row.total
        );
        for ring in row.rings {
            let _ = match ring {
                Some(Ratio { value, error }) => write!(text, ",{value:.5},{error:.5}"),
                None => write!(text, ",,"),
            };
        }
        for point in &row.points {
            for method in 0..3 {
                let Ratio { value, error } = point.rel_mse[method];
                let _ = write!(
                    text,
                    ",{},{:.3},{value:.4e},{error:.2e}",
                    point.passes[method], point.seconds[method]
                );
            }
            for ratios in point.ratios.into_iter().zip(point.bounded) {
                for Ratio { value, error } in [ratios.0, ratios.1] {
                    let _ = write!(text, ",{value:.4},{error:.4}");
                }
            }
        }
        let calibration = row.calibration.map_or(String::new(), |ratio| format!("{ratio:.3}"));
        let _ = write!(text, ",{calibration}");
        let _ = writeln!(text, ",{:.4e},{:.2}", row.noise, row.cpu_seconds);
    }
    text
}
