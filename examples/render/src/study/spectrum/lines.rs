//! Predicted and measured standard deviations along straight lines.

use super::walk::{voxel_size, walk};
use super::{Analysis, Bounds, Voxel};
use crate::study::plot::{Area, PlotError, sheet};
use glam::Vec3;
use plotters::prelude::*;

/// A straight line through the grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// Start.
    pub from: Vec3,
    /// End.
    pub to: Vec3,
}

impl Line {
    /// The voxels on the line, and where it enters and leaves them.
    pub fn voxels<'a>(&self, analysis: &'a Analysis) -> Vec<(f64, f64, &'a Voxel)> {
        let mut found = Vec::new();
        let (direction, length) = (self.to - self.from).normalize_and_length();
        walk(&analysis.layout, self.from, direction, length, |index, from, to| {
            found.push((from, to, &analysis.voxels[index]));
        });
        found
    }
}

const WIDTH: u32 = 1500;
const HEIGHT: u32 = 300;
const PREDICTED: RGBColor = RGBColor(200, 30, 30);
const MEASURED: RGBColor = RGBColor(30, 80, 170);

/// Draws, for each line, the fluence and the standard deviations along the three axes as SVG.
///
/// # Errors
/// Those of the drawing library.
pub fn draw_lines(analysis: &Analysis, lines: &[Line]) -> Result<String, PlotError> {
    sheet((WIDTH, HEIGHT * lines.len() as u32), |root| {
        for (line, row) in lines.iter().zip(root.split_evenly((lines.len(), 1))) {
            let title = format!(
                "from {} to {}: red = predicted, blue = measured, with its noise and a factor of 2",
                position(line.from),
                position(line.to)
            );
            let row = row.titled(&title, ("sans-serif", 17))?;
            let voxels = line.voxels(analysis);
            let panels = row.split_evenly((1, 4));
            draw_fluence(&panels[0], &voxels)?;
            for axis in 0..3 {
                draw_axis(&panels[1 + axis], analysis, &voxels, axis)?;
            }
        }
        Ok(())
    })
}

fn position(point: Vec3) -> String {
    format!("({:.2}, {:.2}, {:.2})", point.x, point.y, point.z)
}

/// Range of the distances along a line.
fn range(voxels: &[(f64, f64, &Voxel)]) -> std::ops::Range<f64> {
    let start = voxels.first().map_or(0.0, |(from, ..)| *from);
    start..voxels.last().map_or(start + 1.0, |(_, to, _)| *to)
}

fn draw_fluence(panel: &Area, voxels: &[(f64, f64, &Voxel)]) -> Result<(), PlotError> {
    let lit = || voxels.iter().map(|(_, _, voxel)| voxel.fluence).filter(|fluence| *fluence > 0.0);
    let high = lit().fold(f64::MIN_POSITIVE, f64::max);
    let low = lit().fold(high, f64::min).max(1e-6 * high);
    let mut chart = ChartBuilder::on(panel)
        .caption("fluence [W/unit²]", ("sans-serif", 14))
        .margin(6)
        .x_label_area_size(24)
        .y_label_area_size(52)
        .build_cartesian_2d(range(voxels), (0.7 * low..1.4 * high).log_scale())?;
    chart.configure_mesh().disable_mesh().y_labels(4).y_label_formatter(&|v| format!("{v:.0e}")).draw()?;
    chart.draw_series(steps(voxels, |voxel| Some(voxel.fluence.max(low)), BLACK.stroke_width(2)))?;
    Ok(())
}

fn draw_axis(
    panel: &Area,
    analysis: &Analysis,
    voxels: &[(f64, f64, &Voxel)],
    axis: usize,
) -> Result<(), PlotError> {
    let bounds = Bounds::of_voxel(voxel_size(&analysis.layout)[axis]);
    let clamp = |sigma: f64| bounds.clamp(sigma);
    let mut chart = ChartBuilder::on(panel)
        .caption(format!("σ along {} [cycles/unit]", ["x", "y", "z"][axis]), ("sans-serif", 14))
        .margin(6)
        .x_label_area_size(24)
        .y_label_area_size(52)
        .build_cartesian_2d(range(voxels), 0.0..1.15 * bounds.high)?;
    chart.configure_mesh().light_line_style(TRANSPARENT).y_label_formatter(&|v| format!("{v:.2}")).draw()?;
    let band = |low: f64, high: f64, style: ShapeStyle| {
        voxels.iter().filter_map(move |(from, to, voxel)| {
            let measured = voxel.axes[axis].measured?;
            let (low, high) = (low * clamp(measured.low), high * clamp(measured.high));
            let corners = [(*from, low), (*to, high.min(1.15 * bounds.high))];
            Some(Rectangle::new(corners, style))
        })
    };
    chart.draw_series(band(0.5, 2.0, MEASURED.mix(0.15).filled()))?;
    chart.draw_series(band(1.0, 1.0, MEASURED.mix(0.5).filled()))?;
    for limit in [bounds.low, bounds.high] {
        let ends = range(voxels);
        chart.draw_series(LineSeries::new([(ends.start, limit), (ends.end, limit)], BLACK.mix(0.5)))?;
    }
    let measured = |voxel: &Voxel| voxel.axes[axis].measured.map(|measured| clamp(measured.sigma));
    chart.draw_series(steps(voxels, measured, MEASURED.stroke_width(2)))?;
    let predicted = |voxel: &Voxel| voxel.axes[axis].predicted.map(clamp);
    chart.draw_series(steps(voxels, predicted, PREDICTED.stroke_width(2)))?;
    Ok(())
}

/// A level line over each voxel that has a value, joined to its neighbour's.
fn steps<'a>(
    voxels: &'a [(f64, f64, &'a Voxel)],
    value: impl Fn(&Voxel) -> Option<f64> + 'a,
    style: ShapeStyle,
) -> impl Iterator<Item = PathElement<(f64, f64)>> + 'a {
    let values: Vec<_> =
        voxels.iter().map(|(from, to, voxel)| value(voxel).map(|v| [(*from, v), (*to, v)])).collect();
    let runs: Vec<Vec<(f64, f64)>> = values
        .split(|value| value.is_none())
        .map(|run| run.iter().flatten().flatten().copied().collect())
        .collect();
    runs.into_iter().filter(|run| !run.is_empty()).map(move |run| PathElement::new(run, style))
}
