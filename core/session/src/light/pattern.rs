//! Lamps whose light depends on its direction: a picture in front of them, or what was measured.

use super::cells::{Cells, Drawn};
use super::rays::CURVATURE;
use super::spot::Cone;
use glam::{DMat3, Vec3};

/// How far fine things are felt, in doublings of a cell.
const SCALES: usize = 6;

/// A row whose middle is dark by the lamp's own fall-off may be lit at its border, and is wanted so much at least.
const LEAST_WANTED: f64 = 0.01;

/// Factors on a lamp's intensity by direction.
#[derive(Clone, PartialEq)]
pub struct Pattern {
    cells: Cells,
    /// Of the spectrum in each cell \[cycles²/rad²\].
    variances: Vec<f32>,
    /// Integral over all directions, with the lamp's own fall-off \[sr\].
    total: Vec3,
}

impl std::fmt::Debug for Pattern {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Pattern {{ {:?}, {} sr }}", self.cells, self.total)
    }
}

impl Pattern {
    /// Cells of equal angles around an axis. None: no cells, not a whole number of rows, no light in any, or factors that are negative or not
    /// finite.
    ///
    /// - `values`: factors >= 0, row by row from the axis to the angle `reach` from it.
    /// - `columns`: cells of a row, from the first of `axes` towards the second and on around the third.
    /// - `axes`: unit, orthogonal: to the right of the lamp, up, and along its axis.
    /// - `reach` \[rad\]: in (0, π].
    /// - `cone`: of the lamp that it is for, around the same axis.
    pub fn new(
        values: Vec<Vec3>,
        columns: usize,
        axes: [Vec3; 3],
        reach: f32,
        cone: Option<&Cone>,
    ) -> Option<Self> {
        let rows = values.len().checked_div(columns)?;
        let falloff = |cosine: f64| cone.map_or(1.0, |cone| cone.falloff_at(cosine));
        let [x, y, z] = axes.map(|axis| axis.as_dvec3().normalize());
        let axes = DMat3::from_cols(x, y, z);
        let brightness: Vec<f64> = values.iter().map(|value| f64::from(value.max_element())).collect();
        let reach = f64::from(reach);
        let cells = Cells::new(values, columns, axes, reach, |cosine| falloff(cosine).max(LEAST_WANTED))?;
        let variances = variances(brightness, rows, columns, reach);
        let total = cells.integral(falloff);
        Some(Self { cells, variances, total })
    }

    /// Integral over all directions, with the lamp's own fall-off \[sr\].
    pub(super) fn total(&self) -> Vec3 {
        self.total
    }

    /// A direction by how bright it is.
    pub(super) fn draw(&self, place: [f32; 2]) -> Drawn {
        self.cells.draw(place)
    }

    /// The factor in a unit direction.
    pub(super) fn factor(&self, direction: Vec3) -> Vec3 {
        self.cells.value(direction)
    }

    /// Angular variance of its spectrum in a unit direction \[cycles²/rad²\].
    pub(super) fn angular_variance(&self, direction: Vec3) -> f32 {
        self.cells.find(direction).map_or(0.0, |cell| self.variances[cell])
    }
}

/// The largest squared relative gradient around each cell, over 4π²: of the cells, and of what is left of them when they are blurred, so that
/// an edge is felt at a distance as one over that.
fn variances(mut cells: Vec<f64>, rows: usize, columns: usize, reach: f64) -> Vec<f32> {
    let height = reach / rows as f64;
    let mut found = vec![0.0f64; cells.len()];
    let mut blurred = cells.clone();
    for step in (0..SCALES).map(|scale| 1usize << scale) {
        let at = |cells: &[f64], row: usize, column: usize| cells[row * columns + column];
        let beside = |column: usize| {
            let step = step % columns;
            [(column + columns - step) % columns, (column + step) % columns]
        };
        for row in 0..rows {
            let sine = libm::sin((row as f64 + 0.5) * height).max(0.5 * height);
            let width = sine * (std::f64::consts::TAU / columns as f64);
            let [above, below] = [row.saturating_sub(step), (row + step).min(rows - 1)];
            for column in 0..columns {
                let here = at(&cells, row, column);
                let [up, down] = [above, below].map(|row| at(&cells, row, column));
                let [left, right] = beside(column).map(|column| at(&cells, row, column));
                let steepest = |a: f64, b: f64| (here - a).abs().max((b - here).abs());
                let along = steepest(up, down) / (step as f64 * height);
                let around = steepest(left, right) / (step as f64 * width);
                let mean = ((up + down + left + right + here) / 5.0).max(1e-300);
                let squared = (along * along + around * around) / (mean * mean);
                let cell = row * columns + column;
                found[cell] = found[cell].max(squared);
                blurred[cell] = 0.25 * (up + down) + 0.5 * here;
            }
        }
        for row in 0..rows {
            for column in 0..columns {
                let [left, right] = beside(column).map(|column| at(&blurred, row, column));
                cells[row * columns + column] = 0.25 * (left + right) + 0.5 * at(&blurred, row, column);
            }
        }
    }
    found.into_iter().map(|squared| squared as f32 * CURVATURE).collect()
}
