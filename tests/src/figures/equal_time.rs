//! Errors at equal CPU time, from the `results.csv` of a report.

use covbeam_render::study::report::fit;
use std::collections::BTreeMap;

const METHODS: [&str; 3] = ["plain", "thesis", "covbeam"];

/// Scenes of the table in the README: two in which covbeam wins, two in which little can be won.
const SHORT: [&str; 4] = ["glass-ball", "shaft", "smoke", "figurine"];

/// Of one scene.
struct Row {
    scene: String,
    seconds: f64,
    /// None: the method's first pass takes longer.
    errors: [Option<f64>; 3],
}

/// A table of all scenes, and one of four.
pub(super) fn tables(csv: &str) -> Result<[String; 2], String> {
    let rows = rows(csv)?;
    let short: Vec<&Row> = rows.iter().filter(|row| SHORT.contains(&row.scene.as_str())).collect();
    if short.len() != SHORT.len() {
        return Err(format!("a scene among {SHORT:?} is missing"));
    }
    Ok([table(&rows.iter().collect::<Vec<_>>()), table(&short)])
}

fn table(rows: &[&Row]) -> String {
    let mut text =
        "| scene | CPU-s | plain | thesis | covbeam | covbeam / plain |\n|---|---|---|---|---|---|\n"
            .to_owned();
    for Row { scene, seconds, errors } in rows {
        let [plain, thesis, covbeam] =
            errors.map(|error| error.map_or("–".to_owned(), |e| format!("{e:.1e}")));
        let ratio =
            errors[2].zip(errors[0]).map_or("–".to_owned(), |(ours, plain)| format!("{:.2}", ours / plain));
        let scene = scene.replace('-', " ");
        text += &format!("| {scene} | {seconds:.1} | {plain} | {thesis} | {covbeam} | {ratio} |\n");
    }
    text
}

/// By scene and method: passes with CPU-seconds and errors, a pair a seed.
type Points<'a> = BTreeMap<(&'a str, &'a str), BTreeMap<u32, Vec<[f64; 2]>>>;

fn rows(csv: &str) -> Result<Vec<Row>, String> {
    let mut points: Points = BTreeMap::new();
    for line in csv.lines().skip(1) {
        let cells: Vec<&str> = line.split(',').collect();
        let [scene, method, _seed, passes, seconds, region, error, ..] = cells[..] else {
            return Err(format!("not a line of a report: {line}"));
        };
        if region == "whole" {
            let number = |text: &str| text.parse::<f64>().map_err(|error| format!("{text}: {error}"));
            let passes = passes.parse::<u32>().map_err(|error| format!("{passes}: {error}"))?;
            let point = [number(seconds)?, number(error)?];
            points.entry((scene, method)).or_default().entry(passes).or_default().push(point);
        }
    }
    let mut scenes: Vec<&str> = points.keys().map(|(scene, _)| *scene).collect();
    scenes.dedup();
    scenes.into_iter().map(|scene| row(scene, &points)).collect()
}

fn row(scene: &str, points: &Points) -> Result<Row, String> {
    let mut curves = Vec::new();
    for method in METHODS {
        let found = points.get(&(scene, method)).ok_or_else(|| format!("{scene}: no {method}"))?;
        let seeds = found.values().map(Vec::len).max().unwrap_or(0);
        let means = found.values().filter(|runs| runs.len() == seeds).map(|runs| {
            let mean = |what: usize| runs.iter().map(|point| point[what]).sum::<f64>() / seeds as f64;
            (mean(0), mean(1))
        });
        // What the reference's noise has made negative has no logarithm.
        curves.push(means.filter(|(_, error)| *error > 0.0).collect::<Vec<_>>());
    }
    let ends = curves.iter().map(|curve| curve.last().map_or(0.0, |(seconds, _)| *seconds));
    let seconds = ends.fold(f64::INFINITY, f64::min);
    let errors = [0, 1, 2].map(|method| fit::at(&curves[method], seconds));
    Ok(Row { scene: scene.to_owned(), seconds, errors })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Errors that fall as 1/t, after 1, 2 and 4 s; covbeam's passes take half as long and its errors are
    /// half as large at equal time.
    fn results() -> String {
        let mut text = "scene,method,seed,passes,cpu_seconds,region,rel_mse,bias,standard_error\n".to_owned();
        for scene in SHORT {
            for (method, step, size) in [("plain", 1.0, 1.0), ("thesis", 1.0, 1.0), ("covbeam", 0.5, 0.5)] {
                for (seed, spread) in [(1, 0.9), (2, 1.1)] {
                    for passes in [1, 2, 4] {
                        let seconds = step * f64::from(passes);
                        for (region, factor) in [("whole", 1.0), ("smooth", 9.0)] {
                            let error = factor * spread * size / seconds;
                            text +=
                                &format!("{scene},{method},{seed},{passes},{seconds},{region},{error},0,0\n");
                        }
                    }
                }
            }
        }
        text
    }

    #[test]
    fn errors_are_compared_when_all_have_had_the_same_time() {
        let [all, short] = tables(&results()).unwrap();
        assert_eq!(all, short);
        assert!(all.contains("| glass ball | 2.0 | 5.0e-1 | 5.0e-1 | 2.5e-1 | 0.50 |"), "{all}");
        assert!(tables(&results().replace("shaft", "black-ball")).is_err());
    }
}
