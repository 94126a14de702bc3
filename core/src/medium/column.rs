//! The column along a ray: how much medium lies between its start and a point on it.

use crate::math::exp_mean;
use libm::log1pf;

/// An optical depth that lets nothing through that single precision could see beside the rest: e^-17 = 4e-8.
pub(super) const OPAQUE_DEPTH: f32 = 17.0;

/// A point of a table of columns.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Knot {
    /// Distance along the ray \[m\].
    pub distance: f32,
    /// ∫ density ds up to there \[m\].
    pub column: f32,
}

/// The column ∫₀ˢ density ds along one ray, as a function of the distance s: monotone, in metres of
/// density 1.
#[derive(Clone, Copy, Debug, Default)]
#[doc(alias = "optical depth")]
#[doc(alias = "optical thickness")]
pub enum Column<'a> {
    /// Density 1: the distance itself.
    #[default]
    Uniform,
    /// Density `density` at the start, times exp(-`rate` s): density (1 - exp(-rate s))/rate.
    Exponential {
        /// At the start of the ray, >= 0.
        density: f32,
        /// \[1/m\], of either sign or 0.
        rate: f32,
    },
    /// Straight lines between knots, 0 before the first, constant after the last. Distances grow, columns do
    /// not fall.
    Knots(&'a [Knot]),
}

impl Column<'_> {
    /// The column up to `distance` \[m\]; >= 0 for distances >= 0.
    ///
    /// Guarantee: never falls with `distance`; an exponential one stays finite (`f32::MAX` at most). Cost:
    /// nothing, an exponential, or a binary search.
    ///
    /// ```
    /// let column = covbeam::Column::Exponential { density: 2.0, rate: 0.5 };
    /// assert!((column.at(3.0) - 2.0 * (1.0 - (-1.5f32).exp()) / 0.5).abs() < 1e-6);
    /// ```
    // Eight-wide twin of an exponential one: beam_map/exponential.rs.
    #[inline]
    pub fn at(&self, distance: f32) -> f32 {
        match *self {
            Column::Uniform => distance,
            Column::Exponential { density, rate } => {
                let column = density * distance * exp_mean(-rate * distance);
                if column.is_nan() { tail(density, rate) } else { column.min(f32::MAX) }
            }
            Column::Knots(knots) => {
                let after = knots.partition_point(|knot| knot.distance <= distance);
                match (after.checked_sub(1).map(|i| knots[i]), knots.get(after)) {
                    (None, _) => 0.0,
                    (Some(last), None) => last.column,
                    (Some(a), Some(b)) => {
                        let t = (distance - a.distance) / (b.distance - a.distance);
                        a.column + t * (b.column - a.column)
                    }
                }
            }
        }
    }

    /// The distance at which the column reaches `column` \[m\] >= 0: the inverse of [`Column::at`], infinity
    /// where it never does. What free flight is sampled with: column = -ln(1 - u)/extinction.
    ///
    /// ```
    /// let column = covbeam::Column::Exponential { density: 2.0, rate: 0.5 };
    /// assert!((column.distance_at(column.at(3.0)) - 3.0).abs() < 1e-5);
    /// assert_eq!(column.distance_at(4.1), f32::INFINITY); // only 2/0.5 = 4 in all
    /// ```
    #[doc(alias = "free flight")]
    pub fn distance_at(&self, column: f32) -> f32 {
        match *self {
            Column::Uniform => column,
            Column::Exponential { density, rate } => {
                let flat = column / density;
                let x = rate * flat;
                let distance = if x.abs() < 1e-4 { flat * (1.0 + 0.5 * x) } else { -log1pf(-x) / rate };
                if x < 1.0 { distance } else { f32::INFINITY }
            }
            Column::Knots(knots) => {
                let after = knots.partition_point(|knot| knot.column < column);
                match (after.checked_sub(1).map(|i| knots[i]), knots.get(after)) {
                    (_, None) => f32::INFINITY,
                    (None, Some(first)) => first.distance,
                    (Some(a), Some(b)) => {
                        let t = (column - a.column) / (b.column - a.column);
                        a.distance + t * (b.distance - a.distance)
                    }
                }
            }
        }
    }
}

/// The column of an infinite distance.
fn tail(density: f32, rate: f32) -> f32 {
    if density == 0.0 {
        0.0
    } else if rate > 0.0 {
        density / rate
    } else {
        f32::MAX
    }
}
