//! Equivalent Gaussians of the predicted spectra at chosen points, after the thesis' Figure 5.18.

use super::walk::{index_of, voxel_at, voxel_size};
use super::{Analysis, Bounds, Voxel};
use crate::study::plot::{Area, PlotError, sheet};
use glam::{DMat3, DVec3, Vec3};
use plotters::prelude::*;
use std::f64::consts::{PI, TAU};

/// A voxel whose Gaussian is drawn, and what to call it.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// Caption.
    pub name: String,
    /// The voxel.
    pub cell: [u32; 3],
}

impl Point {
    /// The voxel around `position`; None outside the grid.
    pub fn at(analysis: &Analysis, position: Vec3) -> Option<Self> {
        let Vec3 { x, y, z } = position;
        voxel_at(&analysis.layout, position).map(|cell| Self { name: format!("at ({x}, {y}, {z})"), cell })
    }
}

const PANEL: u32 = 230;
const CAPTION: u32 = 46;

/// Axes drawn to the right and upwards in the three views.
const VIEWS: [[usize; 2]; 3] = [[0, 1], [2, 1], [0, 2]];

/// The covariance of a predicted spectrum, kept within what the grid can say: at least `bounds.low`² along each axis, and
/// blurred by a Gaussian that is flat beyond `bounds.high`. Both sides of the Fourier transform then exist.
fn bounded(voxel: &Voxel, bounds: &[Bounds; 3]) -> DMat3 {
    let s = voxel.spectrum.unwrap_or_default();
    let [xx, yy, zz, xy, xz, yz] = s.to_array().map(f64::from);
    let spectrum = DMat3::from_cols_array(&[xx, xy, xz, xy, yy, yz, xz, yz, zz]);
    let low = DMat3::from_diagonal(DVec3::from(bounds.map(|b| b.low * b.low)));
    let blur = DMat3::from_diagonal(DVec3::from(bounds.map(|b| 1.0 / (b.high * b.high))));
    ((spectrum + low).inverse() + blur).inverse()
}

/// Draws, for each point, the Gaussian of the predicted spectrum (standard deviation σ in cycles/unit, as in Figure 5.18)
/// and its Fourier transform, the light in space that it describes (standard deviation 1/(2πσ)), in three views each:
/// outlines at one standard deviation. Crosses mark the measured σ along the axes; the square is the voxel.
///
/// # Errors
/// Those of the drawing library.
pub fn draw_gaussians(analysis: &Analysis, points: &[Point]) -> Result<String, PlotError> {
    let size = voxel_size(&analysis.layout);
    let bounds = Bounds::of_voxel_edges(&size);
    // The same scales for all points, so that they can be compared.
    let frequencies = 1.1 * bounds.iter().map(|b| b.high).fold(0.0, f64::max);
    let distances = 1.1 * bounds.iter().map(|b| 1.0 / (2.0 * PI * b.low)).fold(0.0, f64::max);
    sheet((6 * PANEL, (PANEL + CAPTION) * points.len() as u32), |root| {
        for (point, row) in points.iter().zip(root.split_evenly((points.len(), 1))) {
            let voxel = &analysis.voxels[index_of(&analysis.layout, point.cell)];
            let [x, y, z] = voxel.center.to_array();
            let title = format!("{}: voxel around ({x:.2}, {y:.2}, {z:.2})", point.name);
            let row = row.titled(&title, ("sans-serif", 18))?;
            let spectrum = bounded(voxel, &bounds);
            let light = spectrum.inverse() * (1.0 / (4.0 * PI * PI));
            let panels = row.split_evenly((1, 6));
            for (number, view) in VIEWS.into_iter().enumerate() {
                let marks: Vec<(f64, f64)> = crosses(voxel, &bounds, view);
                let axes = view.map(|axis| ["x", "y", "z"][axis]);
                let name = format!("spectrum, {}{}", axes[0], axes[1]);
                draw_view(&panels[number], &name, frequencies, outline(&spectrum, view), &marks, None)?;
                let name = format!("light, {}{}", axes[0], axes[1]);
                let square = view.map(|axis| 0.5 * size[axis]);
                draw_view(&panels[3 + number], &name, distances, outline(&light, view), &[], Some(square))?;
            }
        }
        Ok(())
    })
}

/// The outline of a Gaussian's ellipsoid at one standard deviation, seen along the third axis.
fn outline(covariance: &DMat3, [right, up]: [usize; 2]) -> Vec<(f64, f64)> {
    let (a, b, c) = (covariance.col(right)[right], covariance.col(right)[up], covariance.col(up)[up]);
    // Cholesky factor of the 2x2 block, applied to a circle.
    let first = a.max(0.0).sqrt();
    let mixed = if first > 0.0 { b / first } else { 0.0 };
    let second = (c - mixed * mixed).max(0.0).sqrt();
    let at = |step: u32| {
        let (sin, cos) = (TAU * f64::from(step) / 96.0).sin_cos();
        (first * cos, mixed * cos + second * sin)
    };
    (0..=96).map(at).collect()
}

fn crosses(voxel: &Voxel, bounds: &[Bounds; 3], view: [usize; 2]) -> Vec<(f64, f64)> {
    let mut marks = Vec::new();
    for (place, axis) in view.into_iter().enumerate() {
        if let Some(measured) = voxel.axes[axis].measured {
            let sigma = bounds[axis].clamp(measured.sigma);
            for value in [sigma, -sigma] {
                marks.push(if place == 0 { (value, 0.0) } else { (0.0, value) });
            }
        }
    }
    marks
}

fn draw_view(
    panel: &Area,
    name: &str,
    reach: f64,
    outline: Vec<(f64, f64)>,
    marks: &[(f64, f64)],
    square: Option<[f64; 2]>,
) -> Result<(), PlotError> {
    let mut chart = ChartBuilder::on(panel)
        .caption(name, ("sans-serif", 14))
        .margin(6)
        .x_label_area_size(22)
        .y_label_area_size(38)
        .build_cartesian_2d(-reach..reach, -reach..reach)?;
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .x_labels(5)
        .y_labels(5)
        .x_label_formatter(&|v| format!("{v:.1}"))
        .y_label_formatter(&|v| format!("{v:.1}"))
        .draw()?;
    if let Some([x, y]) = square {
        chart.draw_series([Rectangle::new([(-x, -y), (x, y)], BLACK.mix(0.5))])?;
    }
    let color = RGBColor(200, 30, 30);
    chart.draw_series([Polygon::new(outline.clone(), color.mix(0.25))])?;
    chart.draw_series([PathElement::new(outline, color.stroke_width(2))])?;
    chart
        .draw_series(marks.iter().map(|mark| Cross::new(*mark, 5, RGBColor(30, 80, 170).stroke_width(2))))?;
    Ok(())
}
