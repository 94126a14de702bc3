//! Plots of error over time and passes, and bars of time, as SVG.

use super::curves::{Curve, CurvePoint, Over, curves};
use super::palette::{Color as Srgb, PART_COLORS};
use super::{METHODS, Method, PARTS, Parts, Report, SceneResult};
use plotters::coord::Shift;
use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, ValueFormatter};
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use plotters::series::DashedLineSeries;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use std::ops::Range;

/// What the drawing library says.
pub type PlotError = DrawingAreaErrorKind<std::io::Error>;

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// Of a panel: as wide as a phone shows it.
const WIDTH: u32 = 360;
const PLOT_HEIGHT: u32 = 280;
const ROW: u32 = 22;
/// Height of letters as the drawing library counts it, 1.24 times what the SVG says.
const TEXT: u32 = 18;
const GREY: RGBColor = RGBColor(90, 90, 90);
const LIGHT_GREY: RGBColor = RGBColor(222, 222, 222);

/// Slopes of relMSE over passes that the theory has for plain beams and for adaptive ones.
const THEORY: [(f64, &str); 2] = [(-2.0 / 3.0, "−2/3"), (-4.0 / 5.0, "−4/5")];

/// A logarithmic axis with ticks at powers of ten; on short axes also at 3 times, or 2 and 5 times these.
struct LogAxis {
    low: f64,
    high: f64,
    /// Whether labels are numbers, not powers.
    plain: bool,
}

impl LogAxis {
    fn ticks(&self) -> Vec<f64> {
        let decades = (self.high / self.low).log10();
        let (first, last) = (self.low.log10().floor() as i32, self.high.log10().ceil() as i32);
        let step = if decades > 8.0 { 2 } else { 1 };
        let factors: &[f64] = match decades {
            ..1.5 => &[1.0, 2.0, 5.0],
            1.5..3.0 => &[1.0, 3.0],
            _ => &[1.0],
        };
        let exponents = (first..=last).filter(|exponent| exponent % step == 0);
        let all =
            exponents.flat_map(|exponent| factors.iter().map(move |factor| factor * 10f64.powi(exponent)));
        all.filter(|tick| (self.low..=self.high).contains(tick)).collect()
    }
}

impl Ranged for LogAxis {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, (start, end): (i32, i32)) -> i32 {
        let share = (value / self.low).ln() / (self.high / self.low).ln();
        start + (f64::from(end - start) * share).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, _: Hint) -> Vec<f64> {
        self.ticks()
    }

    fn range(&self) -> Range<f64> {
        self.low..self.high
    }
}

impl ValueFormatter<f64> for LogAxis {
    fn format_ext(&self, value: &f64) -> String {
        if self.plain { plain_number(*value) } else { power(*value) }
    }
}

fn plain_number(value: f64) -> String {
    let digits = (-value.log10().floor()).max(0.0) as usize;
    format!("{value:.digits$}")
}

/// 10⁻³, 2·10⁻³.
fn power(value: f64) -> String {
    let exponent = (value.log10() + 1e-9).floor();
    let factor = (value / 10f64.powf(exponent)).round();
    let raised: String = format!("{exponent}").chars().map(superscript).collect();
    if factor == 1.0 { format!("10{raised}") } else { format!("{factor}·10{raised}") }
}

fn superscript(digit: char) -> char {
    match digit {
        '-' => '⁻',
        '0'..='9' => ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'][digit as usize - '0' as usize],
        other => other,
    }
}

fn rgb([r, g, b]: Srgb) -> RGBColor {
    RGBColor(r, g, b)
}

/// Marks tell methods apart without colour: circle, square, triangle, diamond, cross.
fn mark(area: &Area, at: (i32, i32), method: &Method) -> Result<(), PlotError> {
    let (x, y) = at;
    let color = rgb(method.color);
    let filled = color.filled();
    let place = METHODS.iter().position(|other| other.name == method.name);
    match place.unwrap_or(0) % 5 {
        0 => area.draw(&Circle::new(at, 4, filled)),
        1 => area.draw(&Rectangle::new([(x - 4, y - 4), (x + 4, y + 4)], filled)),
        2 => area.draw(&Polygon::new(vec![(x - 5, y + 4), (x + 5, y + 4), (x, y - 5)], filled)),
        3 => area.draw(&Polygon::new(vec![(x - 5, y), (x, y - 5), (x + 5, y), (x, y + 5)], filled)),
        _ => area.draw(&Cross::new(at, 4, color.stroke_width(2))),
    }
}

/// The range of some positive values, with room.
fn padded(values: impl Iterator<Item = f64>, room: f64) -> Option<(f64, f64)> {
    let (low, high) = values
        .filter(|value| *value > 0.0 && value.is_finite())
        .fold((f64::INFINITY, 0.0_f64), |(low, high), value| (low.min(value), high.max(value)));
    (high > 0.0).then_some((low / room, high * room))
}

/// relMSE of all methods in one region: mean of the seeds, their spread as a band, the fitted slope in the legend; over passes also the theory's
/// slopes, dashed. None if nothing was measured that has a logarithm.
pub(super) fn error_panel(
    scene: &SceneResult,
    region: usize,
    title: &str,
    over: Over,
) -> Result<Option<String>, PlotError> {
    draw_panel(&curves(scene, region), title, over, (WIDTH, PLOT_HEIGHT), TEXT)
}

/// The one figure: the error of the whole picture of a scene over CPU time. None if nothing was measured.
///
/// # Errors
/// Those of the drawing library.
pub fn figure(report: &Report) -> Result<Option<String>, PlotError> {
    let Some(scene) = shown_scene(report) else { return Ok(None) };
    let title = format!("{}: error of the picture over CPU time", scene.name);
    draw_panel(&curves(scene, 0), &title, Over::CpuTime, (720, 430), 21)
}

/// The scene that stands for all: the glass ball, or the first one.
pub(super) fn shown_scene(report: &Report) -> Option<&SceneResult> {
    report.scenes.iter().find(|scene| scene.name == "glass-ball").or(report.scenes.first())
}

fn draw_panel(
    curves: &[Curve],
    title: &str,
    over: Over,
    (width, plot_height): (u32, u32),
    text: u32,
) -> Result<Option<String>, PlotError> {
    let points = || curves.iter().flat_map(Curve::positive);
    let Some((left, right)) = padded(points().map(|point| point.x(over)), 1.25) else { return Ok(None) };
    let errors = points().flat_map(|point| [point.error, point.low.max(0.5 * point.error), point.high]);
    let Some((bottom, top)) = padded(errors, 1.4) else { return Ok(None) };
    let row = ROW * text / TEXT;
    let guides = if over == Over::Passes { 1 } else { 0 };
    let height = plot_height + row * (curves.len() as u32 + guides) + 8;
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, (width, height)).into_drawing_area();
        root.fill(&WHITE)?;
        let (area, legend) = root.split_vertically(plot_height);
        let font = ("sans-serif", text);
        let mut chart = ChartBuilder::on(&area)
            .caption(title, ("sans-serif", text + 1))
            .margin(6)
            .margin_right(14)
            .x_label_area_size(5 * text / 2)
            .y_label_area_size(4 * text)
            .build_cartesian_2d(
                LogAxis { low: left, high: right, plain: true },
                LogAxis { low: bottom, high: top, plain: false },
            )?;
        chart
            .configure_mesh()
            .x_desc(if over == Over::Passes { "passes" } else { "CPU time [s]" })
            .y_desc("relMSE")
            .axis_desc_style(font)
            .label_style(font)
            .bold_line_style(LIGHT_GREY)
            .light_line_style(TRANSPARENT)
            .axis_style(GREY)
            .draw()?;
        let within = |error: f64| error.clamp(bottom, top);
        if over == Over::Passes {
            for (slope, name) in THEORY {
                // From above the highest curve's start, so that lines and curves can be told apart.
                let start = curves
                    .iter()
                    .filter_map(|curve| curve.positive().next())
                    .map(|p| p.error)
                    .fold(bottom, f64::max);
                let law = |x: f64| 1.15 * start.min(top / 1.15) * x.powf(slope);
                // Ends where it leaves the plot.
                let end = right.min((1.15 * start.min(top / 1.15) / bottom).powf(-1.0 / slope));
                let steps = 40;
                let at = |i: i32| end.powf(f64::from(i) / f64::from(steps));
                let line = (0..=steps).map(at).map(|x| (x, within(law(x))));
                let dash = if name == "−2/3" { (7, 5) } else { (2, 4) };
                chart.draw_series(DashedLineSeries::new(line, dash.0, dash.1, GREY.stroke_width(1)))?;
            }
        }
        for curve in curves {
            let color = rgb(curve.method.color);
            let band = |edge: fn(&CurvePoint) -> f64| {
                curve.positive().map(move |point| (point.x(over), within(edge(point)))).collect::<Vec<_>>()
            };
            let lower: Vec<_> = band(|point| point.low);
            let upper: Vec<_> = band(|point| point.high).into_iter().rev().collect();
            chart.draw_series([Polygon::new([lower, upper].concat(), color.mix(0.18).filled())])?;
            let line = curve.positive().map(|point| (point.x(over), point.error));
            chart.draw_series(LineSeries::new(line, color.stroke_width(2)))?;
        }
        for curve in curves {
            for point in curve.positive() {
                let at = chart.backend_coord(&(point.x(over), point.error));
                mark(&root, at, curve.method)?;
            }
        }
        draw_legend(&legend, curves, over, text, row)?;
        root.present()?;
    }
    Ok(Some(svg))
}

fn draw_legend(legend: &Area, curves: &[Curve], over: Over, text: u32, row: u32) -> Result<(), PlotError> {
    let style = ("sans-serif", text).into_font().color(&BLACK).pos(Pos::new(HPos::Left, VPos::Center));
    let (left, swatch) = (text as i32, 2 * text as i32);
    for (place, curve) in curves.iter().enumerate() {
        let y = (row * place as u32 + row / 2) as i32;
        let color = rgb(curve.method.color);
        legend.draw(&PathElement::new([(left, y), (left + swatch, y)], color.stroke_width(2)))?;
        mark(legend, (left + swatch / 2, y), curve.method)?;
        let slope = curve.slope(over).map_or_else(String::new, |slope| format!(", slope {}", signed(slope)));
        legend.draw(&Text::new(
            format!("{}{slope}", curve.method.name),
            (left + swatch + 8, y),
            style.clone(),
        ))?;
    }
    if over == Over::Passes {
        let y = (row * curves.len() as u32 + row / 2) as i32;
        let mut x = left;
        for ((_, name), (on, off)) in THEORY.into_iter().zip([(7, 5), (2, 4)]) {
            for dash in (0..swatch).step_by((on + off) as usize) {
                let end = (dash + on).min(swatch);
                legend.draw(&PathElement::new([(x + dash, y), (x + end, y)], GREY.stroke_width(1)))?;
            }
            let about = if on == 7 { "plain" } else { "adaptive" };
            legend.draw(&Text::new(format!("{name} ({about})"), (x + swatch + 8, y), style.clone()))?;
            x += swatch + 8 + 6 * text as i32;
        }
    }
    Ok(())
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
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, (WIDTH, bars_height + 3 * ROW)).into_drawing_area();
        root.fill(&WHITE)?;
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
        root.present()?;
    }
    Ok(svg)
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
    fn ticks_are_powers_of_ten_and_finer_on_short_axes() {
        let axis = |low, high| LogAxis { low, high, plain: true }.ticks();
        assert_eq!(axis(0.5, 2000.0), [1.0, 10.0, 100.0, 1000.0]);
        assert_eq!(axis(0.9, 22.0), [1.0, 2.0, 5.0, 10.0, 20.0]);
        assert_eq!(axis(3e-4, 4e-3).len(), 3, "5e-4, 1e-3, 2e-3");
        assert_eq!(axis(0.2, 50.0), [3.0 * 0.1, 1.0, 3.0, 10.0, 30.0]);
    }

    #[test]
    fn labels_are_short() {
        assert_eq!([plain_number(0.05), plain_number(1.0), plain_number(500.0)], ["0.05", "1", "500"]);
        assert_eq!([power(1e-3), power(2e-3), power(1.0), power(50.0)], ["10⁻³", "2·10⁻³", "10⁰", "5·10¹"]);
        assert_eq!(signed(-0.667), "−0.67");
    }

    #[test]
    fn bars_have_a_few_round_ticks() {
        assert_eq!(nice_ticks(100.0), [0.0, 20.0, 40.0, 60.0, 80.0, 100.0]);
        assert_eq!(nice_ticks(0.35), [0.0, 0.1, 0.2, 0.3]);
        assert_eq!(nice_ticks(1.7), [0.0, 0.5, 1.0, 1.5]);
    }
}
