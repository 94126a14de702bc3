//! Light that has a picture of its directions: cells of equal angles around an axis, drawn by how bright they are.

use glam::{DMat3, DVec3, Vec3};
use std::f64::consts::{PI, TAU};

/// A picture of directions. Rows of cells run from the axis to an angle from it, columns around it.
#[derive(Clone, PartialEq)]
pub(super) struct Cells {
    /// Row by row.
    values: Vec<Vec3>,
    columns: usize,
    /// From the axis to the end of the last row \[rad\].
    reach: f64,
    /// Columns: where the first column begins, the way that columns run, and the axis.
    axes: DMat3,
    /// Cosines of the rows' borders, from 1 down.
    cosines: Vec<f64>,
    /// Cumulative shares of the rows, and in each row those of its cells.
    rows: Vec<f64>,
    across: Vec<f64>,
    /// The [`starts`] of these.
    row_starts: Vec<u32>,
    across_starts: Vec<u32>,
}

impl std::fmt::Debug for Cells {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Cells {{ {} x {} as far as {} }}", self.rows.len(), self.columns, self.reach)
    }
}

/// A direction that was drawn.
pub(super) struct Drawn {
    /// Unit.
    pub(super) direction: DVec3,
    /// The picture over the probability density of the direction \[sr x the picture's unit\].
    pub(super) weight: Vec3,
}

impl Cells {
    /// None: no cells, not a whole number of rows, no light in any, or light that is negative or not finite.
    ///
    /// - `axes`: unit and orthogonal: where the first column begins, the way that columns run, and the rows' axis.
    /// - `reach` \[rad\]: in (0, π].
    /// - `wanted`: how much a row is wanted beside its brightness, > 0, by the cosine of its middle from the axis.
    pub(super) fn new(
        values: Vec<Vec3>,
        columns: usize,
        axes: DMat3,
        reach: f64,
        wanted: impl Fn(f64) -> f64,
    ) -> Option<Self> {
        let rows = values.len().checked_div(columns)?;
        let is_light = |value: &Vec3| value.is_finite() && value.min_element() >= 0.0;
        if rows * columns != values.len() || !values.iter().all(is_light) {
            return None;
        }
        let angle = |share: f64| reach * share / rows as f64;
        let cosines: Vec<f64> = (0..=rows).map(|row| libm::cos(angle(row as f64))).collect();
        let (mut of_rows, mut across) = (Vec::with_capacity(rows), Vec::with_capacity(values.len()));
        let mut total = 0.0;
        for (row, values) in values.chunks(columns).enumerate() {
            let mut sum = 0.0;
            across.extend(values.iter().map(|value| {
                sum += f64::from(value.max_element());
                sum
            }));
            let start = across.len() - columns;
            across[start..].iter_mut().for_each(|end| *end /= sum.max(f64::MIN_POSITIVE));
            total += sum * (cosines[row] - cosines[row + 1]) * wanted(libm::cos(angle(row as f64 + 0.5)));
            of_rows.push(total);
        }
        of_rows.iter_mut().for_each(|end| *end /= total);
        let (row_starts, across_starts) =
            (starts(&of_rows), across.chunks(columns).flat_map(starts).collect());
        let rows = of_rows;
        let made = Self { values, columns, reach, axes, cosines, rows, across, row_starts, across_starts };
        (total > 0.0).then_some(made)
    }

    /// Solid angle of the cells of a row \[sr\].
    pub(super) fn solid_angle(&self, row: usize) -> f64 {
        (self.cosines[row] - self.cosines[row + 1]) * (TAU / self.columns as f64)
    }

    /// Integral of the picture over its directions, times a factor on each row by the cosine of its middle \[sr x the picture's unit\].
    pub(super) fn integral(&self, factor: impl Fn(f64) -> f64) -> Vec3 {
        let of_row = |(row, values): (usize, &[Vec3])| {
            let middle = libm::cos(self.reach * (row as f64 + 0.5) / self.rows.len() as f64);
            let sum: DVec3 = values.iter().map(|value| value.as_dvec3()).sum();
            sum * (self.solid_angle(row) * factor(middle))
        };
        self.values.chunks(self.columns).enumerate().map(of_row).sum::<DVec3>().as_vec3()
    }

    /// The direction of a place in the unit square: the first number runs from the axis outwards, the second around it, both as light does.
    pub(super) fn draw(&self, [a, b]: [f32; 2]) -> Drawn {
        let (row, down, row_share) = pick(&self.rows, &self.row_starts, a);
        let cells = row * self.columns..(row + 1) * self.columns;
        let (column, along, share) = pick(&self.across[cells.clone()], &self.across_starts[cells.clone()], b);
        let cosine = self.cosines[row] + down * (self.cosines[row + 1] - self.cosines[row]);
        let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
        let (sin_phi, cos_phi) = libm::sincos(TAU * (column as f64 + along) / self.columns as f64);
        let direction = (self.axes * DVec3::new(sine * cos_phi, sine * sin_phi, cosine)).normalize();
        let over_density = (self.solid_angle(row) / (row_share * share)) as f32;
        Drawn { direction, weight: self.values[cells.start + column] * over_density }
    }

    /// The cell of a unit direction; None beyond the picture.
    pub(super) fn find(&self, direction: Vec3) -> Option<usize> {
        let local = self.axes.transpose() * direction.as_dvec3();
        let angle = libm::acos(local.z.clamp(-1.0, 1.0));
        let rows = self.rows.len();
        let row = (angle / self.reach * rows as f64) as usize;
        let turn = (libm::atan2(local.y, local.x) / TAU).rem_euclid(1.0);
        let column = ((turn * self.columns as f64) as usize).min(self.columns - 1);
        // Opposite to the axis there is no beyond.
        let row = if self.reach >= PI { row.min(rows - 1) } else { row };
        (row < rows).then_some(row * self.columns + column)
    }

    /// The picture in a unit direction; 0 beyond it.
    pub(super) fn value(&self, direction: Vec3) -> Vec3 {
        self.find(direction).map_or(Vec3::ZERO, |cell| self.values[cell])
    }
}

/// For each of as many equal parts of [0, 1) as there are shares, the first share that ends behind where the part begins.
fn starts(cumulative: &[f64]) -> Vec<u32> {
    let parts = cumulative.len() as f64;
    let mut share = 0;
    let start = |part| {
        while share + 1 < cumulative.len() && cumulative[share] <= part as f64 / parts {
            share += 1;
        }
        share as u32
    };
    (0..cumulative.len()).map(start).collect()
}

/// What a uniform number picks by cumulative shares, how far inside its share the number is, and that share. Nothing that has none is picked.
fn pick(cumulative: &[f64], starts: &[u32], number: f32) -> (usize, f64, f64) {
    let number = f64::from(number);
    let last = cumulative[cumulative.len() - 1];
    let sought = number.min(last.next_down());
    // From a part's start it is a step or two, where a bisection would look into a row of a large sky ten times.
    let mut picked = starts[((sought * starts.len() as f64) as usize).min(starts.len() - 1)] as usize;
    while cumulative[picked] <= sought {
        picked += 1;
    }
    let before = if picked == 0 { 0.0 } else { cumulative[picked - 1] };
    let share = cumulative[picked] - before;
    (picked, ((number - before) / share).clamp(0.0, 1.0), share)
}
