//! Density in voxels: trilinear look-up, differences, and its exact integral along a ray, as a table of few
//! points.

use super::column::Knot;
use super::derivatives::Derivatives;
use crate::math::SIX;
use crate::voxels::{Dda, GridError, GridLayout, Lattice, Trilinear};
use glam::Vec3;
use libm::{ceil, sqrt};

/// Most parts that one cell of a density grid is cut into.
const MOST_PARTS: f64 = 64.0;

/// The first of the two places of a unit interval whose values' mean integrates exactly the cubic that a trilinear density is along a line.
const GAUSS: f32 = 0.211_324_87;

/// Relative density given at the centres of voxels: trilinear between them, held over the half voxel at the
/// border of the box, 0 outside it. The values belong to the caller.
#[derive(Clone, Copy, Debug)]
pub struct DensityGrid<'a> {
    voxels: Trilinear,
    values: &'a [f32],
}

impl<'a> DensityGrid<'a> {
    /// Wraps `values`, x fastest, then y, then z.
    ///
    /// - `values`: `layout.cell_count()` of them, each finite and >= 0.
    ///
    /// Errors: a layout that is not sound, a wrong number of values, or one that is negative or not finite
    /// ([`GridError::Value`]).
    ///
    /// ```
    /// use covbeam::{Density, DensityGrid, GridLayout, Vec3};
    /// let layout = GridLayout { min: Vec3::ZERO, max: Vec3::new(2.0, 1.0, 1.0), cells: [2, 1, 1] };
    /// let smoke = Density::Grid(DensityGrid::new(layout, &[1.0, 3.0])?);
    /// // Half-way between the two centres.
    /// assert_eq!(smoke.at(Vec3::new(1.0, 0.5, 0.5)), 2.0);
    /// assert_eq!(smoke.at(Vec3::splat(-1.0)), 0.0);
    /// # Ok::<(), covbeam::GridError>(())
    /// ```
    pub fn new(layout: GridLayout, values: &'a [f32]) -> Result<Self, GridError> {
        let voxels = Trilinear::new(layout, values.len())?;
        if !values.iter().all(|value| value.is_finite() && *value >= 0.0) {
            return Err(GridError::Value);
        }
        Ok(Self { voxels, values })
    }

    /// Values at the corners of cell `cell` between centres, x fastest.
    fn corners(&self, cell: [u32; 3]) -> [f64; 8] {
        let Trilinear { layout, strides: [dx, dy, dz], .. } = &self.voxels;
        let side = |axis: usize, stride: usize| {
            let last = layout.cells[axis] - 1;
            [0, 1].map(|up| (cell[axis] + up).saturating_sub(1).min(last) as usize * stride)
        };
        let (x, y, z) = (side(0, *dx), side(1, *dy), side(2, *dz));
        core::array::from_fn(|i| f64::from(self.values[x[i & 1] + y[i >> 1 & 1] + z[i >> 2]]))
    }

    pub(super) fn at(&self, position: Vec3) -> f32 {
        let Some((base, high)) = self.voxels.around(position) else { return 0.0 };
        let low = Vec3::ONE - high;
        let [dx, dy, dz] = self.voxels.strides;
        let row = |at: usize| low.x * self.values[at] + high.x * self.values[at + dx];
        let plane = |at: usize| low.y * row(at) + high.y * row(at + dy);
        low.z * plane(base) + high.z * plane(base + dz)
    }

    /// First and second differences over the voxels around the one that holds `position`.
    pub(super) fn derivatives(&self, position: Vec3) -> Derivatives {
        let Trilinear { layout, scale, .. } = self.voxels;
        let Some(center) = layout.voxel(position, scale) else { return Derivatives::default() };
        let value = |steps: &[(usize, i32)]| {
            let mut at = center;
            for &(axis, step) in steps {
                at[axis] = at[axis].saturating_add_signed(step).min(layout.cells[axis] - 1);
            }
            self.values[layout.index(at)]
        };
        let middle = value(&[]);
        let sides = [0, 1, 2].map(|axis| [1, -1].map(|step| value(&[(axis, step)])));
        let mixed = |a: usize, b: usize| {
            let corner = |i: i32, j: i32| value(&[(a, i), (b, j)]);
            let sum = corner(1, 1) - corner(1, -1) - corner(-1, 1) + corner(-1, -1);
            0.25 * sum * scale[a] * scale[b]
        };
        let first = |axis: usize| 0.5 * (sides[axis][0] - sides[axis][1]) * scale[axis];
        let second =
            |axis: usize| (sides[axis][0] - 2.0 * middle + sides[axis][1]) * scale[axis] * scale[axis];
        Derivatives {
            gradient: Vec3::from_array([0, 1, 2].map(first)),
            hessian: SIX.map(|(i, j)| if i == j { second(i) } else { mixed(i, j) }),
        }
    }

    /// See [`super::Density::knots`].
    pub(super) fn knots(
        &self,
        origin: Vec3,
        direction: Vec3,
        length: f32,
        error: f32,
        most: f32,
        knot: &mut dyn FnMut(Knot),
    ) {
        // Half of the error for the chord between two points of the march, half for leaving points out.
        let half = 0.5 * f64::from(error.max(f32::MIN_POSITIVE));
        let mut table = Thinning { half, last: None, candidate: None, low: 0.0, high: f64::INFINITY };
        self.march(origin, direction, length, half, &mut |distance, column| {
            table.add(distance, column, knot);
            column <= f64::from(most)
        });
        table.finish(knot);
    }

    /// See [`super::Density::column_over`].
    pub(super) fn column_over(&self, origin: Vec3, direction: Vec3, length: f32, most: f32) -> f32 {
        let Some(mut dda) = Dda::new(&self.voxels.layout, Lattice::Centres, origin, direction, length) else {
            return 0.0;
        };
        let Trilinear { layout, scale, strides: [dx, dy, dz], .. } = self.voxels;
        let start = (origin - layout.min) * scale + 0.5;
        let slope = direction * scale;
        let last = layout.cells.map(|count| count - 1);
        let mut column = 0.0;
        while let Some((cell, from, to)) = dda.next_cell() {
            let side = |axis: usize, stride: usize| {
                let low = cell[axis].saturating_sub(1);
                let high = cell[axis].min(last[axis]);
                [low as usize * stride, high as usize * stride]
            };
            let ([x, right], [y, above], [z, behind]) = (side(0, dx), side(1, dy), side(2, dz));
            let row = |at: usize| [self.values[at + x], self.values[at + right]];
            let [[a, b], [c, d], [e, f], [g, h]] =
                [row(y + z), row(above + z), row(y + behind), row(above + behind)];
            if a + b + c + d + e + f + g + h == 0.0 {
                continue;
            }
            let corner = Vec3::new(cell[0] as f32, cell[1] as f32, cell[2] as f32);
            let (from, step) = (from as f32, (to - from) as f32);
            let density = |share: f32| {
                let Vec3 { x, y, z } = start + (from + share * step) * slope - corner;
                let mix = |low: f32, high: f32, t: f32| low + t * (high - low);
                let front = mix(mix(a, b, x), mix(c, d, x), y);
                let back = mix(mix(e, f, x), mix(g, h, x), y);
                mix(front, back, z)
            };
            column += 0.5 * step * (density(GAUSS) + density(1.0 - GAUSS));
            if column > most {
                break;
            }
        }
        column.max(0.0)
    }

    /// See [`super::Density::most_knots`].
    pub(super) fn most_knots(&self) -> usize {
        // Between centres and up to both borders there is a cell more than voxels; the start has a knot, too.
        let cells = self.voxels.layout.cells.iter().map(|count| *count as usize + 1).sum::<usize>();
        cells * MOST_PARTS as usize + 1
    }

    /// Where the values are in memory, and the box over them: what tells one density from another without
    /// reading it.
    #[cfg(feature = "bvh")]
    pub(crate) fn identity(&self) -> (GridLayout, usize) {
        (self.voxels.layout, self.values.as_ptr().addr())
    }

    /// Smallest side of a voxel \[m\].
    pub(super) fn smallest_side(&self) -> f32 {
        1.0 / self.voxels.scale.max_element()
    }

    /// The columns at points along a ray, exact at each point; between two of them a straight line errs by at
    /// most `error`. See [`super::Density::knots`].
    fn march(
        &self,
        origin: Vec3,
        direction: Vec3,
        length: f32,
        error: f64,
        point: &mut dyn FnMut(f64, f64) -> bool,
    ) {
        let Some(mut dda) = Dda::new(&self.voxels.layout, Lattice::Centres, origin, direction, length) else {
            return;
        };
        let scale = self.voxels.scale.to_array().map(f64::from);
        let start: [f64; 3] = core::array::from_fn(|axis| {
            (f64::from(origin[axis]) - f64::from(self.voxels.layout.min[axis])) * scale[axis] + 0.5
        });
        let slope: [f64; 3] = core::array::from_fn(|axis| f64::from(direction[axis]) * scale[axis]);
        let mut column = 0.0;
        if !point(dda.position, column) {
            return;
        }
        while let Some((cell, from, to)) = dda.next_cell() {
            let corners = self.corners(cell);
            if corners == [0.0; 8] {
                if !point(to, column) {
                    return;
                }
                continue;
            }
            let [a, b, c, d, e, f, g, h] = corners;
            let density = |s: f64| {
                let place = |axis: usize| start[axis] + s * slope[axis] - f64::from(cell[axis]);
                let (x, y, z) = (place(0), place(1), place(2));
                let mix = |low: f64, high: f64, t: f64| low + t * (high - low);
                let front = mix(mix(a, b, x), mix(c, d, x), y);
                let back = mix(mix(e, f, x), mix(g, h, x), y);
                mix(front, back, z)
            };
            // |density'| <= its largest difference along each edge of the cell x the ray's slope on that axis;
            // a chord of a function errs by at most an eighth of its second derivative x its length squared.
            let largest = |d: [f64; 4]| d.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
            let change = largest([b - a, d - c, f - e, h - g]) * slope[0].abs()
                + largest([c - a, d - b, g - e, h - f]) * slope[1].abs()
                + largest([e - a, f - b, g - c, h - d]) * slope[2].abs();
            let step = to - from;
            let parts = ceil(step * sqrt(change / (8.0 * error))).clamp(1.0, MOST_PARTS);
            let integral =
                integral_of_cubic([0.0, 1.0, 2.0, 3.0].map(|third| density(from + third / 3.0 * step)));
            let before = column;
            for i in 1..=parts as u32 {
                let share = f64::from(i) / parts;
                // Where there is next to nothing it may fall by a rounding.
                column = f64::max(column, before + step * integral(share));
                let right = if f64::from(i) == parts { to } else { from + share * step };
                if !point(right, column) {
                    return;
                }
            }
        }
    }
}

/// The integral from 0 of a cubic, which a trilinear density is along a line, by its values at 0, 1/3, 2/3 and 1.
fn integral_of_cubic([q0, q1, q2, q3]: [f64; 4]) -> impl Fn(f64) -> f64 {
    let linear = 0.5 * (-11.0 * q0 + 18.0 * q1 - 9.0 * q2 + 2.0 * q3);
    let square = 4.5 * (2.0 * q0 - 5.0 * q1 + 4.0 * q2 - q3);
    let cube = 4.5 * (3.0 * (q1 - q2) + q3 - q0);
    let [half, third, quarter] = [linear / 2.0, square / 3.0, cube / 4.0];
    move |u| u * (q0 + u * (half + u * (third + u * quarter)))
}

/// Leaves out the points of a march that a straight line between the kept ones reproduces to `half`.
///
/// From the last knot, the slopes of all lines that pass within `half` of every point since form a cone; a
/// point outside it makes the point before it the next knot.
struct Thinning {
    half: f64,
    last: Option<(f64, f64)>,
    candidate: Option<(f64, f64)>,
    low: f64,
    high: f64,
}

impl Thinning {
    fn add(&mut self, distance: f64, column: f64, knot: &mut dyn FnMut(Knot)) {
        let Some(mut from) = self.last else {
            self.keep((distance, column), knot);
            return;
        };
        let slope = |from: (f64, f64)| (column - from.1) / (distance - from.0);
        let bends = !(self.low..=self.high).contains(&slope(from));
        if let Some(candidate) = self.candidate.filter(|_| bends) {
            self.keep(candidate, knot);
            from = candidate;
        }
        let run = distance - from.0;
        self.low = self.low.max((column - self.half - from.1) / run);
        self.high = self.high.min((column + self.half - from.1) / run);
        self.candidate = Some((distance, column));
    }

    fn keep(&mut self, (distance, column): (f64, f64), knot: &mut dyn FnMut(Knot)) {
        knot(Knot { distance: distance as f32, column: column as f32 });
        (self.last, self.candidate) = (Some((distance, column)), None);
        (self.low, self.high) = (f64::NEG_INFINITY, f64::INFINITY);
    }

    fn finish(&mut self, knot: &mut dyn FnMut(Knot)) {
        if let Some(candidate) = self.candidate {
            self.keep(candidate, knot);
        }
    }
}
