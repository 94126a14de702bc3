//! Media whose density varies in space: relative density, its curvature, and its integral along a ray.
//!
//! A medium's coefficients ([`crate::Medium`]) hold where the relative density is 1. Elsewhere scattering and
//! extinction are that many times as large, so one number at a point and one integral along a ray serve all
//! colour channels: the *column* ∫ density ds \[m\], with an optical depth of extinction x column.

use super::column::{Column, Knot, OPAQUE_DEPTH};
use super::derivatives::Derivatives;
use super::voxel_density::DensityGrid;
use crate::math::{SIX, exp};
use glam::Vec3;

/// Largest magnitude of the logarithm of an exponential density: e^±80 is near the ends of what `f32` holds.
pub(crate) const LARGEST_LOGARITHM: f32 = 80.0;

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
    // Eight-wide twin: beam_map/exponential.rs.
    pub(crate) fn at(&self, position: Vec3) -> f32 {
        let mut height = (position - self.origin).dot(self.up);
        if height.is_nan() {
            // At the ends of what `f32` holds: inf - inf, or inf x 0.
            height = (position.as_dvec3() - self.origin.as_dvec3()).dot(self.up.as_dvec3()) as f32;
        }
        exp((-height / self.scale_height).clamp(-LARGEST_LOGARITHM, LARGEST_LOGARITHM))
    }

    /// What the density falls by along a ray, exp(-rate s) \[1/m\].
    pub(crate) fn rate(&self, direction: Vec3) -> f32 {
        direction.dot(self.up) / self.scale_height
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

    /// Derivatives of the density at a point: what [`crate::LightField::attenuate`] takes the integrals of,
    /// times the extinction.
    ///
    /// Exact for an exponential density; differences between the centres of neighbouring voxels for a grid, 0
    /// outside it.
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
                Derivatives { gradient: -slope * n, hessian: SIX.map(|(i, j)| n[i] * n[j] * curvature) }
            }
            Density::Grid(grid) => grid.derivatives(position),
        }
    }

    /// Largest step \[m\] over which the density's second derivatives may be taken as constant: infinite for
    /// a homogeneous medium, half the scale height, or a voxel's smallest side.
    pub fn step(&self) -> f32 {
        match self {
            Density::Uniform => f32::INFINITY,
            Density::Exponential(exponential) => 0.5 * exponential.scale_height,
            Density::Grid(grid) => grid.smallest_side(),
        }
    }

    /// The table of columns along a ray through a grid: gives `knot` the points between which a straight line
    /// is within `error` of ∫ density ds. Nothing for the other densities, whose columns are closed forms.
    ///
    /// - `origin` \[m\], `direction` (unit): of the ray; none of it inside the box or not finite: no knots.
    /// - `length` \[m\] > 0; infinity ends where the ray leaves the box.
    /// - `error` \[m\] > 0: in the column; an `error` e gives a transmittance to e x extinction, relatively.
    /// - `most` \[m\]: the table ends at the first point with a larger column.
    ///
    /// Guarantee: the column is exact (the integral of the trilinear density, cell by cell) at each knot;
    /// distances grow, columns never fall. A cell is cut into at most 64 parts, which bounds the table by
    /// [`Density::most_knots`]; only a cell over whose length the density changes by more than 2¹⁴
    /// `error`/length needs more, and errs by more. Cost: about 20 ns a cell. Example:
    /// [`crate::Medium::tabulate`].
    pub fn knots(
        &self,
        origin: Vec3,
        direction: Vec3,
        length: f32,
        error: f32,
        most: f32,
        knot: &mut dyn FnMut(Knot),
    ) {
        if let Density::Grid(grid) = self {
            grid.knots(origin, direction, length, error, most, knot);
        }
    }

    /// The column of a straight way alone, without a table: what a shadow ray needs.
    ///
    /// - `origin` \[m\], `direction` (unit), `length` \[m\] > 0: of the way; in a grid none of it inside the box or not finite: 0.
    /// - `most` \[m\]: in a grid it ends at the first cell behind which the column is larger.
    ///
    /// Guarantee: in a grid the integral of the trilinear density, cell by cell, to single precision. Cost: about 12 ns a cell, a quarter of the table's.
    pub fn column_over(&self, origin: Vec3, direction: Vec3, length: f32, most: f32) -> f32 {
        match self {
            Density::Grid(grid) => grid.column_over(origin, direction, length, most),
            _ => self.column(origin, direction, &[]).at(length),
        }
    }

    /// The most knots that [`Density::knots`] makes, for a host that has their memory ready: 64 for each cell
    /// that a ray can meet, about 64 (nx + ny + nz) in a grid; 0 for the other densities.
    pub fn most_knots(&self) -> usize {
        if let Density::Grid(grid) = self { grid.most_knots() } else { 0 }
    }

    /// The column along a ray, given the table that [`Density::knots`] made of it (empty, and not read,
    /// unless the density is a grid).
    pub fn column<'k>(&self, origin: Vec3, direction: Vec3, knots: &'k [Knot]) -> Column<'k> {
        match self {
            Density::Uniform => Column::Uniform,
            Density::Exponential(exponential) => {
                Column::Exponential { density: exponential.at(origin), rate: exponential.rate(direction) }
            }
            Density::Grid(_) => Column::Knots(knots),
        }
    }

    /// Distance \[m\] beyond which nothing is left to see of light that starts at `origin`: where the column
    /// from there has reached `opaque`, or hardly grows any more.
    ///
    /// - `opaque` \[m\]: a column that lets nothing through.
    ///
    /// Infinite where the density never ends and `opaque` is infinite. A grid's end is that of its box.
    pub fn opaque_distance(&self, origin: Vec3, direction: Vec3, opaque: f32, knots: &[Knot]) -> f32 {
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
