//! The report for programs.

use super::Report;
use std::fmt::Write;

/// All numbers; NaN and what is not known are null.
///
/// # Panics
/// Never: the report holds plain data.
pub fn json(report: &Report) -> String {
    serde_json::to_string_pretty(report).expect("plain data")
}

/// A line a point and region: scene, method, seed, passes, CPU-seconds, region, relMSE, bias, standard error of relMSE.
pub fn csv(report: &Report) -> String {
    let mut text = "scene,method,seed,passes,cpu_seconds,region,rel_mse,bias,standard_error\n".to_owned();
    for scene in &report.scenes {
        for run in &scene.runs {
            for point in &run.points {
                for (region, error) in scene.regions.iter().zip(&point.errors) {
                    let _ = writeln!(
                        text,
                        "{},{},{},{},{:.6},{},{:e},{:e},{:e}",
                        field(&scene.name),
                        run.method,
                        run.seed,
                        point.passes,
                        point.cpu_seconds,
                        region.name,
                        error.rel_mse,
                        error.bias,
                        error.standard_error
                    );
                }
            }
        }
    }
    text
}

/// As RFC 4180 writes a field that may hold commas, quotes or ends of lines.
fn field(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_owned()
    }
}
