//! Tables of the page, and the numbers in them.

use super::curves::{Value, common_time, curves};
use super::palette::{PART_COLORS, hex};
use super::{Compared, Feature, LIGHT_BY_KIND, METHODS, PARTS, PLACES, Report, SceneResult};
use std::fmt::Write;

/// Text as HTML shows it.
pub(super) fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// Two significant digits, with a power of ten where that is shorter.
pub(super) fn number(value: f64) -> String {
    if value.is_nan() {
        return "NaN".to_owned();
    }
    if value == 0.0 {
        return "0".to_owned();
    }
    let exponent = value.abs().log10().floor() as i32;
    let text = match exponent {
        -2..=3 => format!("{value:.*}", (1 - exponent).max(0) as usize),
        _ => format!("{value:.1e}"),
    };
    text.replace('-', "−")
}

/// A method's name with its colour.
pub(super) fn method_label(name: &str) -> String {
    let color = Compared::named(name).map_or([0; 3], |method| method.color);
    format!(
        "<span class=\"method\"><span class=\"swatch\" style=\"background:{}\"></span><b>{}</b></span>",
        hex(color),
        escape(name)
    )
}

/// A table in a box of its own that scrolls if the table is wider than the page.
struct Table {
    html: String,
}

impl Table {
    fn new(label: &str, columns: &[&str]) -> Self {
        let head: String = columns.iter().map(|column| format!("<th scope=\"col\">{column}</th>")).collect();
        let html = format!(
            "<div class=\"scroll\" role=\"region\" aria-label=\"{}\" tabindex=\"0\"><table><thead><tr>{head}</tr></thead><tbody>",
            escape(label)
        );
        Self { html }
    }

    /// Cells are HTML; the first one heads the row.
    fn row(&mut self, cells: &[String]) {
        let Some((first, rest)) = cells.split_first() else { return };
        let _ = write!(self.html, "<tr><th scope=\"row\">{first}</th>");
        rest.iter().for_each(|cell| {
            let _ = write!(self.html, "<td>{cell}</td>");
        });
        self.html += "</tr>\n";
    }

    fn end(self) -> String {
        self.html + "</tbody></table></div>\n"
    }
}

const MISSING: &str = "–";

fn optional(value: Option<f64>) -> String {
    value.map_or_else(|| MISSING.to_owned(), number)
}

/// Each scene and method at equal CPU time, against the first method of the table: how much sooner the error of the whole picture is reached, and how
/// much smaller it is in each region.
pub(super) fn overview(report: &Report) -> String {
    let base = METHODS[0].name;
    let mut regions: Vec<&str> = Vec::new();
    for region in report.scenes.iter().flat_map(|scene| &scene.regions) {
        if !regions.contains(&region.name) {
            regions.push(region.name);
        }
    }
    let heads: Vec<String> = regions.iter().map(|region| format!("{region} ÷")).collect();
    let mut columns = vec!["scene", "method", "CPU-s", "sooner"];
    columns.extend(heads.iter().map(String::as_str));
    let mut table = Table::new("Error at equal CPU time, all scenes", &columns);
    let mut rows = 0;
    for scene in &report.scenes {
        let by_region: Vec<_> = (0..scene.regions.len()).map(|region| curves(scene, region)).collect();
        let Some(time) = by_region.first().and_then(|curves| common_time(curves)) else { continue };
        let methods: Vec<&'static Compared> = by_region[0].iter().map(|curve| curve.method).collect();
        let Some(base) = methods.iter().position(|method| method.name == base) else { continue };
        for (place, method) in methods.iter().enumerate().filter(|(place, _)| *place != base) {
            let target = by_region[0][base].error_at(time);
            let sooner = target.and_then(|error| {
                let number = time / by_region[0][place].time_to(error.number)?;
                Some(Value { number, ..error })
            });
            let mut cells =
                vec![escape(&scene.name), method_label(method.name), format!("{time:.2}"), times(sooner)];
            cells.extend(regions.iter().map(|name| {
                let Some(region) = scene.regions.iter().position(|region| region.name == *name) else {
                    return String::new();
                };
                let [plain, ours] = [base, place].map(|place| by_region[region][place].error_at(time));
                times(plain.zip(ours).map(|(plain, ours)| Value {
                    number: plain.number / ours.number,
                    is_doubtful: plain.is_doubtful || ours.is_doubtful,
                }))
            }));
            table.row(&cells);
            rows += 1;
        }
    }
    if rows == 0 { String::new() } else { table.end() }
}

/// A factor; bold where it is a gain of more than a tenth.
fn times(factor: Option<Value>) -> String {
    match factor {
        None => MISSING.to_owned(),
        Some(Value { number, is_doubtful: true }) => doubtful(&format!("{number:.1}×")),
        Some(Value { number, .. }) if number > 1.1 => format!("<b>{number:.1}×</b>"),
        Some(Value { number, .. }) => format!("{number:.2}×"),
    }
}

fn doubtful(text: &str) -> String {
    format!("<span class=\"doubt\">≈ {text}</span>")
}

fn value(value: Option<Value>) -> String {
    match value {
        None => MISSING.to_owned(),
        Some(Value { number: found, is_doubtful: true }) => doubtful(&number(found)),
        Some(Value { number: found, .. }) => number(found),
    }
}

/// Error of each method when the same CPU time is spent.
pub(super) fn equal_time(scene: &SceneResult) -> String {
    let all: Vec<_> = (0..scene.regions.len()).map(|region| curves(scene, region)).collect();
    let Some(time) = all.first().and_then(|curves| common_time(curves)) else { return String::new() };
    let mut columns: Vec<String> = vec!["region".into(), "pixels".into(), "noise of reference".into()];
    let methods: Vec<&str> = all[0].iter().map(|curve| curve.method.name).collect();
    columns.extend(methods.iter().map(|method| method_label(method)));
    columns.extend(methods.iter().map(|method| format!("bias {}", escape(method))));
    let columns: Vec<&str> = columns.iter().map(String::as_str).collect();
    let mut table = Table::new("relMSE at equal CPU time", &columns);
    for (region, curves) in scene.regions.iter().zip(&all) {
        let mut cells =
            vec![region.name.to_owned(), region.pixels.to_string(), optional(region.reference_noise)];
        cells.extend(curves.iter().map(|curve| value(curve.error_at(time))));
        cells.extend(curves.iter().map(|curve| match curve.points.last() {
            Some(last) => format!("{:+.2} %", 100.0 * last.bias).replace('-', "−"),
            None => MISSING.to_owned(),
        }));
        table.row(&cells);
    }
    format!(
        "<h4>relMSE when each method has spent {time:.2} CPU-seconds</h4>\n{}<p class=\"note\">Between measured points by their \
         power law; ≈: less than three standard errors above zero. Bias: of the region's mean, at the end of the runs.</p>\n",
        table.end()
    )
}

/// CPU-seconds until the whole picture's error has fallen to round values.
pub(super) fn time_to_error(scene: &SceneResult) -> String {
    let curves = curves(scene, 0);
    let errors = || curves.iter().flat_map(|curve| curve.positive()).map(|point| point.error);
    let (low, high) = (errors().fold(f64::INFINITY, f64::min), errors().fold(0.0, f64::max));
    let steps = (-12..=9).rev().flat_map(|exponent| [3.0, 1.0].map(|factor| factor * 10f64.powi(exponent)));
    let targets: Vec<f64> = steps.filter(|target| (low..=high).contains(target)).collect();
    if targets.is_empty() {
        return String::new();
    }
    let mut columns = vec!["relMSE, whole".to_owned()];
    columns.extend(curves.iter().map(|curve| method_label(curve.method.name)));
    let columns: Vec<&str> = columns.iter().map(String::as_str).collect();
    let mut table = Table::new("CPU-seconds to reach an error", &columns);
    for target in targets {
        let mut cells = vec![number(target)];
        cells.extend(curves.iter().map(|curve| optional(curve.time_to(target))));
        table.row(&cells);
    }
    let table = table.end();
    format!(
        "<h4>CPU-seconds until the error of the whole picture falls to</h4>\n{table}<p class=\"note\">{MISSING}: below it from the first \
         measured point, or not reached.</p>\n"
    )
}

/// Core-milliseconds a pass by part of the first runs, and memory.
pub(super) fn parts(scene: &SceneResult) -> String {
    let mut columns = vec!["method".to_owned(), "passes".to_owned()];
    columns.extend(part_heads());
    columns.extend(["sum", "million pairs", "peak memory"].map(str::to_owned));
    let columns: Vec<&str> = columns.iter().map(String::as_str).collect();
    let mut table = Table::new("Core-milliseconds a pass, by part", &columns);
    for run in scene.runs.iter().filter(|run| run.seed == 1) {
        let passes = run.points.last().map_or(1, |point| point.passes);
        let a_pass = run.parts.a_pass(passes);
        let mut cells = vec![method_label(run.method), passes.to_string()];
        cells.extend(a_pass.seconds().map(milliseconds));
        cells.push(milliseconds(a_pass.total()));
        cells.push(format!("{:.2}", a_pass.pairs as f64 / 1e6));
        cells.push(run.peak_memory.map_or_else(|| "unknown".to_owned(), |bytes| megabytes(bytes as f64)));
        table.row(&cells);
    }
    let memory = &scene.memory;
    format!(
        "{}<p class=\"note\">Peak memory: of the whole program, during the run. A pass has {} beams (without those of light fields); their \
         map takes {} with the plain radius and {} with kernels up to the largest radius, the covariance grid {}.</p>\n",
        table.end(),
        memory.beams,
        megabytes(memory.plain_map as f64),
        megabytes(memory.adaptive_map as f64),
        megabytes(memory.grid as f64)
    )
}

fn part_heads() -> impl Iterator<Item = String> {
    let head = |(name, color): (&str, _)| {
        format!("<span class=\"swatch\" style=\"background:{}\"></span>{name}", hex(color))
    };
    PARTS.into_iter().zip(PART_COLORS).map(head)
}

fn milliseconds(seconds: f64) -> String {
    format!("{:.1}", 1e3 * seconds)
}

fn megabytes(bytes: f64) -> String {
    format!("{:.1} MB", bytes / 1e6)
}

/// Where the error that is left comes from; empty if that was not measured.
pub(super) fn error_budget(scene: &SceneResult) -> String {
    let Some(budget) = &scene.error_budget else { return String::new() };
    let percent = |share: f64| format!("{:.0} %", 100.0 * share);
    let mut columns = vec!["kind of light".to_owned()];
    columns.extend(PLACES.map(str::to_owned));
    let columns: Vec<&str> = columns.iter().map(String::as_str).collect();
    let mut table = Table::new("Error budget", &columns);
    for kind in &budget.kinds {
        let mut cells = vec![kind.kind.to_owned()];
        cells.extend(kind.places.map(percent));
        table.row(&cells);
    }
    format!(
        "<h3>Error budget of {}</h3>\n<p class=\"note\">Where the variance of a picture of {} passes comes from, {} of its squared \
         brightness: shares of each kind of light in pixels that a silhouette or the border of a shadow crosses, in those that see a mirror \
         or glass first, and in others. {} of it is in the fog before the first surface.</p>\n{}",
        method_label(LIGHT_BY_KIND),
        budget.passes,
        number(budget.variance),
        percent(budget.fog),
        table.end()
    )
}

/// Core-milliseconds a pass of each variant.
pub(super) fn features(features: &[Feature]) -> String {
    let mut columns = vec!["switched on".to_owned(), "÷ plain".to_owned()];
    columns.extend(part_heads());
    columns.extend(["sum".to_owned(), "million pairs".to_owned(), "what it is".to_owned()]);
    let columns: Vec<&str> = columns.iter().map(String::as_str).collect();
    let mut table = Table::new("Cost of each feature", &columns);
    for feature in features {
        let mut cells = vec![escape(feature.name), format!("{:.2}", feature.ratio)];
        cells.extend(feature.parts.seconds().map(milliseconds));
        cells.push(milliseconds(feature.parts.total()));
        cells.push(format!("{:.2}", feature.parts.pairs as f64 / 1e6));
        cells.push(format!("<span class=\"about\">{}</span>", escape(feature.about)));
        table.row(&cells);
    }
    table.end()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_two_digits() {
        let text = [0.0123, 0.5, 7.0, 42.0, 1234.0, 1.2e-5, -0.25, 0.0, f64::NAN].map(number);
        assert_eq!(text, ["0.012", "0.50", "7.0", "42", "1234", "1.2e−5", "−0.25", "0", "NaN"]);
    }

    #[test]
    fn names_cannot_bring_markup_into_the_page() {
        assert_eq!(escape("<b a=\"1\">&"), "&lt;b a=&quot;1&quot;&gt;&amp;");
    }
}
