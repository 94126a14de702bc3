//! Media whose density varies in space: relative density, its curvature, and its integral along a ray.
//!
//! A medium's coefficients ([`crate::Medium`]) hold where the relative density is 1. Elsewhere scattering and extinction
//! are that many times as large, so one number at a point and one integral along a ray serve all colour channels:
//! the *column* ∫ density ds \[m\], with an optical depth of extinction x column.

use crate::centres::Centres;
use crate::column::{Column, Knot};
use crate::walk::{Lattice, Walk};
use crate::{GridError, GridLayout, LightField, Medium, OPAQUE_DEPTH};
use glam::Vec3;
use libm::{ceil, expf, sqrt};

/// Largest magnitude of the logarithm of an exponential density: e^±80 is near the ends of what `f32` holds.
const LARGEST_LOGARITHM: f32 = 80.0;

/// Error of the optical depth in a table of columns: half a thousandth of the transmittance.
const DEPTH_ERROR: f32 = 5e-4;

/// Most steps in which a light field is carried.
const MOST_STEPS: f32 = 256.0;

/// Most parts that one cell of a density grid is cut into.
const MOST_PARTS: f64 = 64.0;

/// Relative density that falls exponentially with height, such as the air's.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExponentialDensity {
    /// A point at height 0, where the density is 1.
    pub origin: Vec3,
    /// Unit direction in which the density falls.
    pub up: Vec3,
    /// Height \[m\] > 0 over which it falls by the factor e.
    pub scale_height: f32,
}

impl ExponentialDensity {
    fn at(&self, position: Vec3) -> f32 {
        let mut height = (position - self.origin).dot(self.up);
        if height.is_nan() {
            // At the ends of what `f32` holds: inf - inf, or inf x 0.
            let along = |axis: usize| {
                (f64::from(position[axis]) - f64::from(self.origin[axis])) * f64::from(self.up[axis])
            };
            height = (along(0) + along(1) + along(2)) as f32;
        }
        expf((-height / self.scale_height).clamp(-LARGEST_LOGARITHM, LARGEST_LOGARITHM))
    }

    /// What the density falls by along a ray, exp(-rate s) \[1/m\].
    pub(crate) fn rate(&self, direction: Vec3) -> f32 {
        direction.dot(self.up) / self.scale_height
    }
}

/// Relative density given at the centres of voxels: trilinear between them, held over the half voxel at the border of
/// the box, 0 outside it. The values belong to the caller.
#[derive(Clone, Copy, Debug)]
pub struct DensityGrid<'a> {
    centres: Centres,
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
        let centres = Centres::new(layout, values.len())?;
        if !values.iter().all(|value| value.is_finite() && *value >= 0.0) {
            return Err(GridError::Value);
        }
        Ok(Self { centres, values })
    }

    /// Values at the corners of cell `cell` between centres, x fastest.
    fn corners(&self, cell: [u32; 3]) -> [f64; 8] {
        let Centres { layout, strides: [dx, dy, dz], .. } = &self.centres;
        let side = |axis: usize, stride: usize| {
            let last = layout.cells[axis] - 1;
            [0, 1].map(|up| (cell[axis] + up).saturating_sub(1).min(last) as usize * stride)
        };
        let ([x0, x1], [y0, y1], [z0, z1]) = (side(0, *dx), side(1, *dy), side(2, *dz));
        let value = |x: usize, y: usize, z: usize| f64::from(self.values[x + y + z]);
        [
            value(x0, y0, z0),
            value(x1, y0, z0),
            value(x0, y1, z0),
            value(x1, y1, z0),
            value(x0, y0, z1),
            value(x1, y0, z1),
            value(x0, y1, z1),
            value(x1, y1, z1),
        ]
    }

    fn at(&self, position: Vec3) -> f32 {
        let Some((base, high)) = self.centres.around(position) else { return 0.0 };
        let low = Vec3::ONE - high;
        let [dx, dy, dz] = self.centres.strides;
        let row = |at: usize| low.x * self.values[at] + high.x * self.values[at + dx];
        let plane = |at: usize| low.y * row(at) + high.y * row(at + dy);
        low.z * plane(base) + high.z * plane(base + dz)
    }

    /// First and second differences over the voxels around the one that holds `position`.
    fn derivatives(&self, position: Vec3) -> Derivatives {
        if !self.centres.layout.contains(position) {
            return Derivatives::default();
        }
        let q = (position - self.centres.layout.min) * self.centres.scale;
        let last = self.centres.layout.cells.map(|n| i64::from(n) - 1);
        let center: [i64; 3] = core::array::from_fn(|axis| (q[axis] as i64).min(last[axis]));
        let value = |step: [i64; 3]| {
            let at: [u32; 3] =
                core::array::from_fn(|axis| (center[axis] + step[axis]).clamp(0, last[axis]) as u32);
            self.values[self.centres.layout.index(at)]
        };
        let middle = value([0; 3]);
        let neighbours = |axis: usize| {
            [1, -1].map(|side| {
                let mut step = [0; 3];
                step[axis] = side;
                value(step)
            })
        };
        let mixed = |a: usize, b: usize| {
            let corner = |i: i64, j: i64| {
                let mut step = [0; 3];
                (step[a], step[b]) = (i, j);
                value(step)
            };
            let sum = corner(1, 1) - corner(1, -1) - corner(-1, 1) + corner(-1, -1);
            0.25 * sum * self.centres.scale[a] * self.centres.scale[b]
        };
        let sides: [[f32; 2]; 3] = core::array::from_fn(neighbours);
        let first = |axis: usize| 0.5 * (sides[axis][0] - sides[axis][1]) * self.centres.scale[axis];
        let second = |axis: usize| {
            (sides[axis][0] - 2.0 * middle + sides[axis][1])
                * self.centres.scale[axis]
                * self.centres.scale[axis]
        };
        Derivatives {
            gradient: Vec3::new(first(0), first(1), first(2)),
            hessian: [second(0), second(1), second(2), mixed(0, 1), mixed(0, 2), mixed(1, 2)],
        }
    }

    /// The columns at points along a ray, exact at each point; between two of them a straight line errs by at most
    /// `error`. See [`Density::knots`].
    fn march(
        &self,
        origin: Vec3,
        direction: Vec3,
        length: f32,
        error: f64,
        point: &mut dyn FnMut(f64, f64) -> bool,
    ) {
        let Some(mut walk) = Walk::new(&self.centres.layout, Lattice::Centres, origin, direction, length)
        else {
            return;
        };
        let scale = self.centres.scale.to_array().map(f64::from);
        let start: [f64; 3] = core::array::from_fn(|axis| {
            (f64::from(origin[axis]) - f64::from(self.centres.layout.min[axis])) * scale[axis] + 0.5
        });
        let slope: [f64; 3] = core::array::from_fn(|axis| f64::from(direction[axis]) * scale[axis]);
        let mut column = 0.0;
        if !point(walk.position(), column) {
            return;
        }
        while let Some((cell, from, to)) = walk.next_piece() {
            let [a, b, c, d, e, f, g, h] = self.corners(cell);
            let density = |s: f64| {
                let place = |axis: usize| start[axis] + s * slope[axis] - f64::from(cell[axis]);
                let (x, y, z) = (place(0), place(1), place(2));
                let mix = |low: f64, high: f64, t: f64| low + t * (high - low);
                let front = mix(mix(a, b, x), mix(c, d, x), y);
                let back = mix(mix(e, f, x), mix(g, h, x), y);
                mix(front, back, z)
            };
            // |density'| <= its largest difference along each edge of the cell x the ray's slope on that axis; a chord
            // of a function errs by at most an eighth of its second derivative x the square of its length.
            let largest = |d: [f64; 4]| d.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
            let change = largest([b - a, d - c, f - e, h - g]) * slope[0].abs()
                + largest([c - a, d - b, g - e, h - f]) * slope[1].abs()
                + largest([e - a, f - b, g - c, h - d]) * slope[2].abs();
            let step = to - from;
            let parts = ceil(step * sqrt(change / (8.0 * error))).clamp(1.0, MOST_PARTS);
            let part = step / parts;
            for i in 0..parts as u32 {
                let left = from + f64::from(i) * part;
                // Two Gauss points integrate the cubic that a trilinear density is along a line exactly.
                const GAUSS: f64 = 0.211_324_865_405_187_1;
                column += 0.5 * part * (density(left + GAUSS * part) + density(left + (1.0 - GAUSS) * part));
                let right = if f64::from(i + 1) == parts { to } else { left + part };
                if !point(right, column) {
                    return;
                }
            }
        }
    }
}

/// First and second derivatives of a density, or of an optical depth, in world axes.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Derivatives {
    /// \[1/m\] of a relative density.
    pub gradient: Vec3,
    /// \[xx, yy, zz, xy, xz, yz\] \[1/m²\] of a relative density.
    pub hessian: [f32; 6],
}

/// The derivatives of the optical depth of the way so far, and where on it they arose.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct DepthShape {
    pub(crate) sum: Derivatives,
    /// Sum of the steps' weights, and of these times distance: structure counts as standing at its centroid.
    weight: f32,
    moment: f32,
}

impl DepthShape {
    /// Adds what lies between `from` and `to` on the way, in steps of at most [`Density::step`].
    pub(crate) fn add(
        &mut self,
        density: &Density,
        (origin, direction): (Vec3, Vec3),
        [from, to]: [f32; 2],
        extinction: f32,
    ) {
        let count = libm::ceilf((to - from) / density.step()).clamp(1.0, MOST_STEPS);
        let step = (to - from) / count;
        for i in 0..count as u32 {
            let middle = from + (i as f32 + 0.5) * step;
            let here = density.derivatives(origin + middle * direction);
            let depth = extinction * step;
            self.sum.gradient += depth * here.gradient;
            for (sum, second) in self.sum.hessian.iter_mut().zip(here.hessian) {
                *sum += depth * second;
            }
            let weight = depth * here.hessian.iter().fold(0.0, |sum: f32, second| sum + second.abs());
            self.weight += weight;
            self.moment += weight * middle;
        }
    }

    /// The field `start` after `distance` on the way that this is the shape of.
    pub(crate) fn carried(&self, start: &LightField, distance: f32) -> LightField {
        let mut field = *start;
        let centroid = if self.weight > 0.0 { (self.moment / self.weight).clamp(0.0, distance) } else { 0.0 };
        field.travel(centroid);
        field.attenuate(self.sum.gradient, &self.sum.hessian);
        field.travel(distance - centroid);
        field
    }
}

/// How the relative density of a medium varies in space.
#[derive(Clone, Copy, Debug, Default)]
pub enum Density<'a> {
    /// 1 everywhere: a homogeneous medium. Costs nothing.
    #[default]
    Uniform,
    /// Exponential in height; columns are closed forms.
    Exponential(ExponentialDensity),
    /// A grid of voxels; columns are tables, see [`Density::knots`].
    Grid(DensityGrid<'a>),
}

impl Density<'_> {
    /// Relative density at a point, >= 0.
    ///
    /// - `position` \[m\]; NaN gives 0 in a grid.
    ///
    /// An exponential density is held beyond e^±80. Cost: an exponential, or a trilinear look-up.
    ///
    /// ```
    /// use covbeam::{Density, ExponentialDensity, Vec3};
    /// let air = ExponentialDensity { origin: Vec3::ZERO, up: Vec3::Y, scale_height: 2.0 };
    /// let halved = Density::Exponential(air).at(Vec3::Y * 2.0 * 2f32.ln());
    /// assert!((halved - 0.5).abs() < 1e-6);
    /// ```
    #[inline]
    pub fn at(&self, position: Vec3) -> f32 {
        match self {
            Density::Uniform => 1.0,
            Density::Exponential(exponential) => exponential.at(position),
            Density::Grid(grid) => grid.at(position),
        }
    }

    /// Derivatives of the density at a point: what [`crate::LightField::attenuate`] takes the integrals of, times the extinction.
    ///
    /// Exact for an exponential density; differences between the centres of neighbouring voxels for a grid, 0 outside it.
    ///
    /// ```
    /// use covbeam::{Density, ExponentialDensity, Vec3};
    /// let air = ExponentialDensity { origin: Vec3::ZERO, up: Vec3::Y, scale_height: 2.0 };
    /// let found = Density::Exponential(air).derivatives(Vec3::ZERO);
    /// assert_eq!(found.gradient, Vec3::new(0.0, -0.5, 0.0));
    /// assert_eq!(found.hessian, [0.0, 0.25, 0.0, 0.0, 0.0, 0.0]);
    /// ```
    pub fn derivatives(&self, position: Vec3) -> Derivatives {
        match self {
            Density::Uniform => Derivatives::default(),
            Density::Exponential(exponential) => {
                // Where they are beyond what `f32` holds: an infinity times a component of 0 would be NaN.
                let slope = (exponential.at(position) / exponential.scale_height).min(f32::MAX);
                let (n, curvature) = (exponential.up, (slope / exponential.scale_height).min(f32::MAX));
                Derivatives {
                    gradient: -slope * n,
                    hessian: [n.x * n.x, n.y * n.y, n.z * n.z, n.x * n.y, n.x * n.z, n.y * n.z]
                        .map(|nn| nn * curvature),
                }
            }
            Density::Grid(grid) => grid.derivatives(position),
        }
    }

    /// Moves a light field through the medium: a travel, with the [`LightField::attenuate`] of the whole way at the centroid of
    /// what varies on it. Just a travel where the density is uniform.
    ///
    /// - `field`: at `origin` \[m\]; it moves along its direction.
    /// - `distance` \[m\] >= 0.
    /// - `extinction` \[1/m\] >= 0 at density 1.
    ///
    /// The derivatives are summed in steps of at most [`Density::step`] (256 of them at most) by the midpoint rule: about 1 %
    /// in an exponential medium.
    ///
    /// ```
    /// use covbeam::{Density, ExponentialDensity, LightField, Vec3};
    /// let air = Density::Exponential(ExponentialDensity { origin: Vec3::ZERO, up: Vec3::Y, scale_height: 1.0 });
    /// let mut light = LightField::collimated(Vec3::X, f32::INFINITY);
    /// air.carry(&mut light, Vec3::ZERO, 2.0, 0.5);
    /// // Level parallel light at height 0: τ = 1, with slope and curvature 1, which cancel: the slope speaks.
    /// assert!((light.fluence().yy - 1.0 / (4.0 * std::f32::consts::PI.powi(2))).abs() < 1e-6);
    /// ```
    pub fn carry(&self, field: &mut LightField, origin: Vec3, distance: f32, extinction: f32) {
        if matches!(self, Density::Uniform) {
            field.travel(distance);
            return;
        }
        let mut shape = DepthShape::default();
        shape.add(self, (origin, field.direction), [0.0, distance], extinction);
        *field = shape.carried(field, distance);
    }

    /// Largest step \[m\] over which the density's second derivatives may be taken as constant: infinite for a homogeneous
    /// medium, half the scale height, or a voxel's smallest side.
    pub fn step(&self) -> f32 {
        match self {
            Density::Uniform => f32::INFINITY,
            Density::Exponential(exponential) => 0.5 * exponential.scale_height,
            Density::Grid(grid) => 1.0 / grid.centres.scale.max_element(),
        }
    }

    /// The table of columns along a ray through a grid: gives `knot` the points between which a straight line is within
    /// `error` of ∫ density ds. Nothing for the other densities, whose columns are closed forms.
    ///
    /// - `origin` \[m\], `direction` (unit): of the ray; none of it inside the box or not finite: no knots.
    /// - `length` \[m\] > 0; infinity ends where the ray leaves the box.
    /// - `error` \[m\] > 0: in the column; an `error` e gives a transmittance to e x extinction, relatively.
    /// - `most` \[m\]: the table ends at the first point with a larger column.
    ///
    /// Guarantee: the column is exact (the integral of the trilinear density, cell by cell) at each knot; distances grow,
    /// columns never fall. A cell is cut into at most 64 parts, which bounds the table by 64 x (nx + ny + nz) knots; only a
    /// cell over whose length the density changes by more than 2¹⁴ `error`/length needs more, and errs by more.
    /// Cost: about 20 ns a cell.
    ///
    /// ```
    /// use covbeam::{Column, Density, DensityGrid, GridLayout, Knot, Vec3};
    /// let layout = GridLayout { min: Vec3::ZERO, max: Vec3::ONE, cells: [2, 2, 2] };
    /// let smoke = Density::Grid(DensityGrid::new(layout, &[3.0; 8])?);
    /// let mut knots = Vec::new();
    /// smoke.knots(Vec3::new(0.5, 0.5, -1.0), Vec3::Z, f32::INFINITY, 1e-3, f32::INFINITY, &mut |knot| knots.push(knot));
    /// assert_eq!(knots.len(), 2); // in and out: the density between them is uniform
    /// assert_eq!(Column::Knots(&knots).at(1.5), 1.5);
    /// # Ok::<(), covbeam::GridError>(())
    /// ```
    pub fn knots(
        &self,
        origin: Vec3,
        direction: Vec3,
        length: f32,
        error: f32,
        most: f32,
        knot: &mut dyn FnMut(Knot),
    ) {
        let Density::Grid(grid) = self else { return };
        if !(origin.is_finite() && direction.is_finite() && direction != Vec3::ZERO && length > 0.0) {
            return;
        }
        // Half of the error for the chord between two points of the march, half for leaving points out.
        let half = 0.5 * f64::from(error.max(f32::MIN_POSITIVE));
        let mut table = Thinning { half, last: None, candidate: None, low: 0.0, high: f64::INFINITY };
        grid.march(origin, direction, length, half, &mut |distance, column| {
            table.add(distance, column, knot);
            column <= f64::from(most)
        });
        table.finish(knot);
    }

    /// [`Density::knots`] as a gather wants them in `medium`: within 5e-4 of the optical depth of the channel that is attenuated most,
    /// up to where every channel is opaque ([`Medium::opaque_column`]).
    ///
    /// ```
    /// use covbeam::{Density, DensityGrid, GridLayout, Knot, Medium, Vec3};
    /// let layout = GridLayout { min: Vec3::ZERO, max: Vec3::ONE, cells: [1, 1, 1] };
    /// let smoke = Density::Grid(DensityGrid::new(layout, &[3.0])?);
    /// let medium = Medium { scattering: Vec3::ONE, ..Medium::default() };
    /// let mut last = Knot::default();
    /// smoke.tabulate(&medium, Vec3::splat(0.5), Vec3::Z, f32::INFINITY, &mut |knot| last = knot);
    /// assert_eq!(last, Knot { distance: 0.5, column: 1.5 });
    /// # Ok::<(), covbeam::GridError>(())
    /// ```
    pub fn tabulate(
        &self,
        medium: &Medium,
        origin: Vec3,
        direction: Vec3,
        length: f32,
        knot: &mut dyn FnMut(Knot),
    ) {
        let error = DEPTH_ERROR / medium.extinction().max_element();
        self.knots(origin, direction, length, error, medium.opaque_column(), knot);
    }

    /// The column along a ray, given the table that [`Density::knots`] made of it (empty, and not read, unless the density is a
    /// grid).
    pub fn column<'k>(&self, origin: Vec3, direction: Vec3, knots: &'k [Knot]) -> Column<'k> {
        match self {
            Density::Uniform => Column::Uniform,
            Density::Exponential(exponential) => {
                Column::Exponential { density: exponential.at(origin), rate: exponential.rate(direction) }
            }
            Density::Grid(_) => Column::Knots(knots),
        }
    }

    /// Distance \[m\] beyond which nothing is left to see of light that starts at `origin`: where the column from there has
    /// reached `opaque`, or hardly grows any more.
    ///
    /// - `opaque` \[m\]: a column that lets nothing through.
    ///
    /// Infinite where the density never ends and `opaque` is infinite. A grid's end is that of its box.
    pub fn reach(&self, origin: Vec3, direction: Vec3, opaque: f32, knots: &[Knot]) -> f32 {
        match self {
            Density::Uniform => opaque,
            Density::Exponential(exponential) => {
                let rate = exponential.rate(direction);
                // e^-17 = 4e-8 of the column is still to come: below the last digit of the rest.
                let thin = if rate > 0.0 { OPAQUE_DEPTH / rate } else { f32::INFINITY };
                self.column(origin, direction, knots).distance_at(opaque).min(thin)
            }
            Density::Grid(_) => knots.last().map_or(0.0, |knot| knot.distance),
        }
    }
}

/// Leaves out the points of a march that a straight line between the kept ones reproduces to `half`.
///
/// From the last knot, the slopes of all lines that pass within `half` of every point since form a cone; a point
/// outside it makes the point before it the next knot.
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
        if let Some(candidate) = self.candidate
            && !(self.low..=self.high).contains(&slope(from))
        {
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
