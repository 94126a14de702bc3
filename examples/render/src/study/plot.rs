//! Plots as SVG: a sheet to draw on, and curves over logarithmic axes.

use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, ValueFormatter};
use plotters::coord::{CoordTranslate, Shift};
use plotters::prelude::*;
use plotters::series::DashedLineSeries;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use std::ops::Range;

/// What the drawing library says.
pub type PlotError = DrawingAreaErrorKind<std::io::Error>;

/// A sheet, or a part of one.
pub type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

pub(crate) const GREY: RGBColor = RGBColor(90, 90, 90);
pub(crate) const LIGHT_GREY: RGBColor = RGBColor(222, 222, 222);

/// Draws on a white sheet, so many pixels across and down. Returns the SVG document.
///
/// # Errors
/// Those of the drawing library.
pub fn sheet(
    size: (u32, u32),
    draw: impl FnOnce(&Area) -> Result<(), PlotError>,
) -> Result<String, PlotError> {
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, size).into_drawing_area();
        root.fill(&WHITE)?;
        draw(&root)?;
        root.present()?;
    }
    Ok(svg)
}

/// A point of a curve; all > 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// To the right.
    pub x: f64,
    /// Upwards.
    pub y: f64,
    /// Lower and upper end of the band around the curve; low may be below 0.
    pub band: [f64; 2],
}

/// A curve with a mark at each point and a band around it.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// In the legend.
    pub name: String,
    /// sRGB.
    pub color: [u8; 3],
    /// Number of its marks' shape, of five that take turns: curves are told apart without colour.
    pub mark: usize,
    /// With rising x.
    pub points: Vec<Point>,
}

/// A power law to hold curves against: a dashed line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Law {
    /// Of x, < 0.
    pub exponent: f64,
    /// In the legend.
    pub name: &'static str,
    /// Pixels on and off.
    pub dash: (u32, u32),
}

/// Curves over two logarithmic axes, with a legend below.
#[derive(Clone, Debug, PartialEq)]
pub struct Plot {
    /// Above it.
    pub title: String,
    /// What the axes are, to the right and upwards.
    pub axes: [&'static str; 2],
    /// The curves.
    pub curves: Vec<Curve>,
    /// They start at x = 1, above the curve that starts highest.
    pub laws: &'static [Law],
    /// Height of letters as the drawing library counts it, 1.24 times what the SVG says.
    pub text: u32,
}

impl Plot {
    /// As a document, `size` pixels across and down, without the legend below. None if there is no point.
    ///
    /// # Errors
    /// Those of the drawing library.
    pub fn svg(&self, (width, height): (u32, u32)) -> Result<Option<String>, PlotError> {
        if self.ranges().is_none() {
            return Ok(None);
        }
        sheet((width, height + self.legend_height()), |root| self.draw(root, height)).map(Some)
    }

    /// Pixels that the legend takes.
    pub fn legend_height(&self) -> u32 {
        let laws = if self.laws.is_empty() { 0 } else { 1 };
        self.row() * (self.curves.len() as u32 + laws) + 8
    }

    /// Height of a row of the legend.
    fn row(&self) -> u32 {
        11 * self.text / 9
    }

    /// Of both axes, with room. None without points.
    fn ranges(&self) -> Option<[(f64, f64); 2]> {
        let points = || self.curves.iter().flat_map(|curve| &curve.points);
        // A band that reaches to nothing does not stretch the axis without end.
        let ends = |point: &Point| [point.y, point.band[0].max(0.5 * point.y), point.band[1]];
        Some([padded(points().map(|point| point.x), 1.25)?, padded(points().flat_map(ends), 1.4)?])
    }

    /// Into an area whose upper `height` pixels are the plot's and the rest the legend's; nothing without points.
    ///
    /// # Errors
    /// Those of the drawing library.
    pub fn draw(&self, area: &Area, height: u32) -> Result<(), PlotError> {
        let Some([(left, right), (bottom, top)]) = self.ranges() else { return Ok(()) };
        let (area, legend) = area.split_vertically(height);
        let font = ("sans-serif", self.text);
        let mut chart = ChartBuilder::on(&area)
            .caption(&self.title, ("sans-serif", self.text + 1))
            .margin(6)
            .margin_right(14)
            .x_label_area_size(5 * self.text / 2)
            .y_label_area_size(4 * self.text)
            .build_cartesian_2d(
                LogAxis { low: left, high: right, plain: true },
                LogAxis { low: bottom, high: top, plain: false },
            )?;
        chart
            .configure_mesh()
            .x_desc(self.axes[0])
            .y_desc(self.axes[1])
            .axis_desc_style(font)
            .label_style(font)
            .bold_line_style(LIGHT_GREY)
            .light_line_style(TRANSPARENT)
            .axis_style(GREY)
            .draw()?;
        let within = |y: f64| y.clamp(bottom, top);
        let highest = self.curves.iter().filter_map(|curve| curve.points.first());
        // From above the highest curve's start, so that lines and curves can be told apart.
        let start = 1.15 * highest.map(|point| point.y).fold(bottom, f64::max).min(top / 1.15);
        for law in self.laws {
            // Ends where it leaves the plot.
            let end = right.min((start / bottom).powf(-1.0 / law.exponent));
            let steps = 40;
            let at = |i: i32| end.powf(f64::from(i) / f64::from(steps));
            let line = (0..=steps).map(at).map(|x| (x, within(start * x.powf(law.exponent))));
            let (on, off) = law.dash;
            chart.draw_series(DashedLineSeries::new(line, on, off, GREY.stroke_width(1)))?;
        }
        for curve in &self.curves {
            let color = rgb(curve.color);
            let edge = |end: usize| curve.points.iter().map(move |point| (point.x, within(point.band[end])));
            let band: Vec<_> = edge(0).chain(edge(1).rev()).collect();
            chart.draw_series([Polygon::new(band, color.mix(0.18).filled())])?;
            let line = curve.points.iter().map(|point| (point.x, point.y));
            chart.draw_series(LineSeries::new(line, color.stroke_width(2)))?;
        }
        for curve in &self.curves {
            for point in &curve.points {
                draw_mark(chart.plotting_area(), (point.x, point.y), curve)?;
            }
        }
        self.draw_legend(&legend)
    }

    fn draw_legend(&self, legend: &Area) -> Result<(), PlotError> {
        let row = self.row();
        let style =
            ("sans-serif", self.text).into_font().color(&BLACK).pos(Pos::new(HPos::Left, VPos::Center));
        let (left, swatch) = (self.text as i32, 2 * self.text as i32);
        for (place, curve) in self.curves.iter().enumerate() {
            let y = (row * place as u32 + row / 2) as i32;
            legend
                .draw(&PathElement::new([(left, y), (left + swatch, y)], rgb(curve.color).stroke_width(2)))?;
            draw_mark(legend, (left + swatch / 2, y), curve)?;
            legend.draw(&Text::new(curve.name.clone(), (left + swatch + 8, y), style.clone()))?;
        }
        let y = (row * self.curves.len() as u32 + row / 2) as i32;
        let mut x = left;
        for law in self.laws {
            let (on, off) = (law.dash.0 as i32, law.dash.1 as i32);
            for dash in (0..swatch).step_by((on + off) as usize) {
                let end = (dash + on).min(swatch);
                legend.draw(&PathElement::new([(x + dash, y), (x + end, y)], GREY.stroke_width(1)))?;
            }
            legend.draw(&Text::new(law.name, (x + swatch + 8, y), style.clone()))?;
            x += swatch + 8 + 6 * self.text as i32;
        }
        Ok(())
    }
}

pub(crate) fn rgb([r, g, b]: [u8; 3]) -> RGBColor {
    RGBColor(r, g, b)
}

/// Circle, square, triangle, diamond, cross.
fn draw_mark<C: CoordTranslate>(
    area: &DrawingArea<SVGBackend, C>,
    at: C::From,
    curve: &Curve,
) -> Result<(), PlotError>
where
    C::From: Copy,
{
    let (color, at) = (rgb(curve.color), EmptyElement::at(at));
    let filled = color.filled();
    match curve.mark % 5 {
        0 => area.draw(&(at + Circle::new((0, 0), 4, filled))),
        1 => area.draw(&(at + Rectangle::new([(-4, -4), (4, 4)], filled))),
        2 => area.draw(&(at + Polygon::new(vec![(-5, 4), (5, 4), (0, -5)], filled))),
        3 => area.draw(&(at + Polygon::new(vec![(-5, 0), (0, -5), (5, 0), (0, 5)], filled))),
        _ => area.draw(&(at + Cross::new((0, 0), 4, color.stroke_width(2)))),
    }
}

/// The range of some positive values, with room.
fn padded(values: impl Iterator<Item = f64>, room: f64) -> Option<(f64, f64)> {
    let (low, high) = values
        .filter(|value| *value > 0.0 && value.is_finite())
        .fold((f64::INFINITY, 0.0_f64), |(low, high), value| (low.min(value), high.max(value)));
    (high > 0.0).then_some((low / room, high * room))
}

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
    }
}
