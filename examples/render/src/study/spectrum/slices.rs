//! Predicted and measured standard deviations in planes through a point, as heat maps.

use super::table::log_ratio;
use super::walk::{index_of, voxel_size};
use super::{Analysis, Bounds, Voxel};
use crate::study::plot::{Area, PlotError, sheet};
use plotters::prelude::*;

/// Edge of a map, space between maps and their titles, in pixels.
const MAP: i32 = 300;
const GAP: i32 = 34;

/// Colours of a scale; equal neighbours are drawn as one rectangle.
const LEVELS: f64 = 32.0;

/// Anchors of the scale from low to high (viridis).
const SCALE: [[f64; 3]; 5] =
    [[68.0, 1.0, 84.0], [59.0, 82.0, 139.0], [33.0, 145.0, 140.0], [94.0, 201.0, 98.0], [253.0, 231.0, 37.0]];

/// Anchors from four times too small over agreement to four times too large.
const RATIO_SCALE: [[f64; 3]; 5] = [
    [5.0, 48.0, 97.0],
    [103.0, 169.0, 207.0],
    [247.0, 247.0, 247.0],
    [239.0, 138.0, 98.0],
    [103.0, 0.0, 31.0],
];

/// Left out: surfaces, the grid's border, undecided.
const LEFT_OUT: RGBColor = RGBColor(190, 190, 190);

/// Not among the voxels that hold 99 % of the energy.
const DARK: RGBColor = RGBColor(225, 225, 225);

/// Fluences below this share of the largest have the scale's first colour.
const DIMMEST: f64 = 1e-4;

/// Axes drawn to the right and upwards, for a plane across x, y, z.
const ACROSS: [[usize; 2]; 3] = [[2, 1], [0, 2], [0, 1]];

/// Draws the plane of voxels across `normal` (0, 1, 2 = x, y, z) through voxel `through` as SVG: the fluence, and for
/// each axis predicted, measured and their ratio.
///
/// # Errors
/// Those of the drawing library.
pub fn draw_slice(analysis: &Analysis, through: [u32; 3], normal: usize) -> Result<String, PlotError> {
    let slice = Slice { analysis, through, normal };
    // At least as high as the scales.
    let (across, down) = (MAP + GAP, GAP + slice.size()[1].round().max(200.0) as i32);
    sheet((4 * across as u32, 3 * down as u32), |root| {
        let panel =
            |column: i32, row: i32| root.clone().shrink((column * across, row * down), (across, down));
        let brightest = analysis.voxels.iter().map(|voxel| voxel.fluence).fold(0.0, f64::max);
        let level = |fluence: f64| 1.0 - (fluence / brightest).max(DIMMEST).ln() / DIMMEST.ln();
        slice.draw(&panel(0, 0), "fluence, 4 decades", |voxel| color(&SCALE, level(voxel.fluence)))?;
        slice.draw_scales(&panel(0, 1))?;
        for axis in 0..3 {
            let name = ["x", "y", "z"][axis];
            let bounds = Bounds::of_voxel(voxel_size(&analysis.layout)[axis]);
            let level = |sigma: f64| (sigma / bounds.low).ln() / (bounds.high / bounds.low).ln();
            let sigma = |value: Option<f64>| value.map_or(LEFT_OUT, |sigma| color(&SCALE, level(sigma)));
            let row = axis as i32;
            let predicted = |voxel: &Voxel| sigma(voxel.axes[axis].predicted);
            slice.draw(&panel(1, row), &format!("predicted σ_{name}"), predicted)?;
            let measured = |voxel: &Voxel| sigma(voxel.axes[axis].measured.map(|m| m.sigma));
            slice.draw(&panel(2, row), &format!("measured σ_{name}"), measured)?;
            slice.draw(&panel(3, row), "ratio", |voxel| {
                let ratio = log_ratio(analysis, axis, &voxel.axes[axis]);
                match ratio {
                    _ if !voxel.bright => DARK,
                    None => LEFT_OUT,
                    Some(ratio) => color(&RATIO_SCALE, 0.5 + 0.25 * ratio),
                }
            })?;
        }
        Ok(())
    })
}

/// `level` 0..=1 along a scale.
fn color(scale: &[[f64; 3]; 5], level: f64) -> RGBColor {
    let at = 4.0 * (level.clamp(0.0, 1.0) * LEVELS).round() / LEVELS;
    let anchor = (at as usize).min(3);
    let t = at - anchor as f64;
    let [r, g, b] =
        std::array::from_fn(|c| ((1.0 - t) * scale[anchor][c] + t * scale[anchor + 1][c]).round() as u8);
    RGBColor(r, g, b)
}

struct Slice<'a> {
    analysis: &'a Analysis,
    through: [u32; 3],
    normal: usize,
}

type Drawn = Result<(), PlotError>;

impl Slice<'_> {
    /// Width and height of a map in pixels: the larger side of the box fills it.
    fn size(&self) -> [f64; 2] {
        let extent = (self.analysis.layout.max - self.analysis.layout.min).as_dvec3();
        let sides = ACROSS[self.normal].map(|axis| extent[axis]);
        sides.map(|side| f64::from(MAP) * side / sides[0].max(sides[1]))
    }

    fn draw(&self, panel: &Area, title: &str, color: impl Fn(&Voxel) -> RGBColor) -> Drawn {
        let layout = &self.analysis.layout;
        let [right, up] = ACROSS[self.normal];
        let [width, height] = self.size();
        let counts = [layout.cells[right], layout.cells[up]];
        let x = |column: u32| GAP / 2 + (width * f64::from(column) / f64::from(counts[0])).round() as i32;
        let y = |row: u32| GAP + (height * (1.0 - f64::from(row) / f64::from(counts[1]))).round() as i32 - 8;
        let axes = ["x", "y", "z"];
        let reach = |axis: usize| format!("{} {:.1}..{:.1}", axes[axis], layout.min[axis], layout.max[axis]);
        let caption = format!("{title} (→ {}, ↑ {})", reach(right), reach(up));
        panel.draw(&Text::new(caption, (GAP / 2, 8), ("sans-serif", 13)))?;
        for row in 0..counts[1] {
            let mut cell = self.through;
            cell[up] = row;
            let colors: Vec<RGBColor> = (0..counts[0])
                .map(|column| {
                    cell[right] = column;
                    color(&self.analysis.voxels[index_of(layout, cell)])
                })
                .collect();
            let mut start = 0;
            for run in colors.chunk_by(|a, b| a == b) {
                let end = start + run.len() as u32;
                panel.draw(&Rectangle::new([(x(start), y(row + 1)), (x(end), y(row))], run[0].filled()))?;
                start = end;
            }
        }
        Ok(())
    }

    /// What the colours mean.
    fn draw_scales(&self, panel: &Area) -> Drawn {
        let center = super::walk::center_of(&self.analysis.layout, self.through)[self.normal];
        let axis = ["x", "y", "z"][self.normal];
        let text = |line: String, y: i32| panel.draw(&Text::new(line, (GAP / 2, y), ("sans-serif", 13)));
        text(format!("voxels at {axis} = {center:.3}"), 10)?;
        let scales = [
            (60, &SCALE, "σ from 0.05/h to 0.32/h (h: voxel's size)"),
            (130, &RATIO_SCALE, "ratio 1/4, 1/2, 1, 2, 4: blue = too small"),
        ];
        for (top, scale, meaning) in scales {
            text(meaning.to_owned(), top - 18)?;
            for step in 0..=LEVELS as i32 {
                let left = GAP / 2 + 8 * step;
                let style = color(scale, f64::from(step) / LEVELS).filled();
                panel.draw(&Rectangle::new([(left, top), (left + 8, top + 18)], style))?;
            }
        }
        for (top, style, meaning) in
            [(180, LEFT_OUT, "left out, or no data"), (210, DARK, "not in 99 % of the energy")]
        {
            panel.draw(&Rectangle::new([(GAP / 2, top), (GAP / 2 + 18, top + 18)], style.filled()))?;
            panel.draw(&Text::new(meaning, (GAP / 2 + 26, top + 2), ("sans-serif", 13)))?;
        }
        Ok(())
    }
}
