//! Plots of error over time and passes, and bars of time.

use super::curves::{Curve, Over, curves};
use super::palette::PART_COLORS;
use super::{METHODS, PARTS, Parts, Report, SceneResult};
use crate::study::plot::{self, LIGHT_GREY, Law, Plot, PlotError, rgb, sheet};
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// Of a panel: as wide as a phone shows it.
const WIDTH: u32 = 360;
const PLOT_HEIGHT: u32 = 280;
const ROW: u32 = 22;
const TEXT: u32 = 18;

/// Slopes of relMSE over passes that the theory has for plain beams and for adaptive ones.
const THEORY: [Law; 2] = [
    Law { exponent: -2.0 / 3.0, name: "−2/3 (plain)", dash: (7, 5) },
    Law { exponent: -4.0 / 5.0, name: "−4/5 (adaptive)", dash: (2, 4) },
];

/// relMSE of all methods in one region: mean of the seeds, their spread as a band, the fitted slope in the legend; over passes also the theory's
/// slopes, dashed. None if nothing was measured that has a logarithm.
pub(super) fn error_panel(
    scene: &SceneResult,
    region: usize,
    title: &str,
    over: Over,
) -> Result<Option<String>, PlotError> {
    error_plot(&curves(scene, region), title.to_owned(), over, TEXT).svg((WIDTH, PLOT_HEIGHT))
}

/// The one figure: the error of the whole picture of a scene over CPU time. None if nothing was measured.
///
/// # Errors
/// Those of the drawing library.
pub fn figure(report: &Report) -> Result<Option<String>, PlotError> {
    let Some(scene) = shown_scene(report) else { return Ok(None) };
    let title = format!("{}: error of the picture over CPU time", scene.name);
    error_plot(&curves(scene, 0), title, Over::CpuTime, 21).svg((720, 430))
}

/// The scene that stands for all: the glass ball, or the first one.
pub(super) fn shown_scene(report: &Report) -> Option<&SceneResult> {
    report.scenes.iter().find(|scene| scene.name == "glass-ball").or(report.scenes.first())
}

fn error_plot(curves: &[Curve], title: String, over: Over, text: u32) -> Plot {
    let curve = |curve: &Curve| {
        let slope = curve.slope(over).map_or_else(String::new, |slope| format!(", slope {}", signed(slope)));
        let place = METHODS.iter().position(|other| other.name == curve.method.name);
        let points = curve.positive();
        let points = points.map(|point| plot::Point {
            x: point.x(over),
            y: point.error,
            band: [point.low, point.high],
        });
        plot::Curve {
            name: format!("{}{slope}", curve.method.name),
            color: curve.method.color,
            mark: place.unwrap_or(0),
            points: points.collect(),
        }
    };
    let (x, laws): (_, &[Law]) = match over {
        Over::Passes => ("passes", &THEORY),
        Over::CpuTime => ("CPU time [s]", &[]),
    };
    Plot { title, axes: [x, "relMSE"], curves: curves.iter().map(curve).collect(), laws, text }
}

/// A number with two digits and a minus that is one.
pub(super) fn signed(value: f64) -> String {
    format!("{value:.2}").replace('-', "−")
}

/// Core-milliseconds a pass as stacked bars, one row a name.
pub(super) fn part_bars(rows: &[(&str, Parts)]) -> Result<String, PlotError> {
    let longest = rows.iter().map(|(_, parts)| parts.total()).fold(1e-9, f64::max) * 1e3;
    let (row, label) = (46, 22);
    let bars_height = row * rows.len() as u32 + 60;
    sheet((WIDTH, bars_height + 3 * ROW), |root| {
        let style = ("sans-serif", TEXT).into_font().color(&BLACK).pos(Pos::new(HPos::Left, VPos::Center));
        let axis: RangedCoordf64 = (0.0..1.04 * longest).into();
        let (left, right) = (8, WIDTH as i32 - 24);
        let place = |value: f64| axis.map(&value, (left, right));
        let bottom = (bars_height - 46) as i32;
        for tick in nice_ticks(longest) {
            let x = place(tick);
            root.draw(&PathElement::new([(x, 4), (x, bottom)], LIGHT_GREY))?;
            let centered = style.clone().pos(Pos::new(HPos::Center, VPos::Top));
            root.draw(&Text::new(format!("{tick}"), (x, bottom + 5), centered))?;
        }
        let centered = style.clone().pos(Pos::new(HPos::Center, VPos::Top));
        root.draw(&Text::new(
            "core-milliseconds a pass".to_owned(),
            ((left + right) / 2, bottom + 23),
            centered,
        ))?;
        for (number, (name, parts)) in rows.iter().enumerate() {
            let top = (row * number as u32) as i32 + 4;
            root.draw(&Text::new((*name).to_owned(), (left, top + 10), style.clone()))?;
            let mut before = 0.0;
            for (seconds, color) in parts.seconds().into_iter().zip(PART_COLORS) {
                let after = before + 1e3 * seconds;
                let corners = [(place(before), top + label), (place(after), top + label + 16)];
                root.draw(&Rectangle::new(corners, rgb(color).filled()))?;
                before = after;
            }
        }
        for (number, (name, color)) in PARTS.into_iter().zip(PART_COLORS).enumerate() {
            let (column, line) = (number as i32 % 3, number as i32 / 3);
            let (x, y) = (left + 120 * column, bars_height as i32 + 8 + ROW as i32 * line);
            root.draw(&Rectangle::new([(x, y - 6), (x + 14, y + 7)], rgb(color).filled()))?;
            root.draw(&Text::new(name.to_owned(), (x + 20, y), style.clone()))?;
        }
        Ok(())
    })
}

/// Three to six round numbers from 0 to at most `high`.
fn nice_ticks(high: f64) -> Vec<f64> {
    let scale = 10f64.powf((high / 3.0).log10().floor());
    let step = [5.0, 2.0, 1.0]
        .map(|factor| factor * scale)
        .into_iter()
        .find(|step| 3.0 * step <= high)
        .unwrap_or(scale);
    let count = (high / step) as u32;
    // Rounded to the step's own digits: 0.1 + 0.2 is no label.
    let digits = (-step.log10().floor()).max(0.0);
    let round = |value: f64| (value * 10f64.powf(digits)).round() / 10f64.powf(digits);
    (0..=count).map(|i| round(f64::from(i) * step)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_minus_is_one() {
        assert_eq!(signed(-0.667), "−0.67");
    }

    #[test]
    fn bars_have_a_few_round_ticks() {
        assert_eq!(nice_ticks(100.0), [0.0, 20.0, 40.0, 60.0, 80.0, 100.0]);
        assert_eq!(nice_ticks(0.35), [0.0, 0.1, 0.2, 0.3]);
        assert_eq!(nice_ticks(1.7), [0.0, 0.5, 1.0, 1.5]);
    }
}
