//! The spectrum of the picture around one pixel, read off the covariance grid along its eye ray.

use crate::beam::EyeRay;
use crate::grid::{FluenceGrid, Surroundings};
use crate::math::{Sym2, symmetric};
use crate::medium::{Column, Density, Medium};
use crate::voxels::{Dda, Lattice};
use core::f32::consts::PI;
use glam::{Vec2, Vec3};
use libm::ceilf;

/// Most steps along one eye ray.
const MOST_STEPS: f32 = 1024.0;

/// How much an eye ray changes from one pixel to the next.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PixelStep {
    /// Of its origin \[m / pixel\]: zero for a pinhole.
    pub origin: Vec3,
    /// Of its unit direction \[1 / pixel\]: zero for an orthographic camera. Only what is across the ray
    /// counts.
    pub direction: Vec3,
}

/// Covariance of the spectrum of the in-scattered light around a pixel, in the plane of the picture
/// \[cycles²/pixel²\]: x to the right, y down. Positive semi-definite.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ImageSpectrum {
    /// Variance across.
    pub xx: f32,
    /// Covariance of across and down.
    pub xy: f32,
    /// Variance down.
    pub yy: f32,
    /// In-scattered light on the way, the dimmest around, in the grid's relative unit; 0 = the grid has no
    /// data, and the other numbers are 0.
    pub weight: f32,
}

impl ImageSpectrum {
    /// Accumulates the grid along an eye ray: at each step the slice of the fluence's covariance across the
    /// ray, in pixels, plus the curvature of density and eye attenuation, with the weights fluence x density
    /// x transmittance to the eye, the mean of the channels by their scattering; over the sum of these weights for the dimmest light around (the harmonic
    /// mean of the voxels around): beside a bright shaft, in the dark, a filter that is right for the shaft
    /// would leak it.
    ///
    /// A frequency of ω cycles/m at a point that moves by m metres when the eye ray moves by a pixel is ω m
    /// cycles/pixel.
    ///
    /// - `ray`: from the eye; to where the light it gathers ends, or infinity.
    /// - `steps`: how the ray changes with a step to the right and a step down.
    /// - `medium`, `column`: what the ray is in, and its column from its origin.
    ///
    /// What is not finite, or outside the grid's box, gives weight 0. Surfaces that end the rays of
    /// neighbouring pixels at other distances are no part of it: see [`crate::film_regions`].
    ///
    /// Guarantee: positive semi-definite up to rounding. Error: the midpoint rule in steps of a voxel's
    /// smallest side (at most 1024); what a medium's structure before the grid's box adds is left out. Cost:
    /// about 40 ns a step in a homogeneous medium, where the second part is 0 and costs nothing; 95 ns in an
    /// exponential one, 200 ns in voxels (bench `film/spectrum`).
    ///
    /// Source: thesis 5.3.2. The exact relative Hessian of density x transmittance, with the magnitudes of
    /// its eigenvalues, stands for the "attenuation" of the thesis. Differs from it beside shadows.
    pub fn along(
        ray: &EyeRay,
        steps: &[PixelStep; 2],
        grid: &FluenceGrid,
        medium: &Medium,
        column: &Column,
    ) -> Self {
        let sound = steps.iter().all(|step| step.origin.is_finite() && step.direction.is_finite());
        let layout = &grid.voxels.layout;
        let dda = || Dda::new(layout, Lattice::Voxels, ray.origin, ray.direction, ray.length);
        let Some(dda) = sound.then(dda).flatten() else { return Self::default() };
        let (from, length) = (dda.position as f32, (dda.end - dda.position) as f32);
        let voxel = ((layout.max - layout.min) / layout.resolution()).min_element();
        let count = ceilf(length / voxel).clamp(1.0, MOST_STEPS);
        let step = length / count;
        let (extinction, density) = (medium.mean_extinction(), &medium.density);
        let (mut sum, mut weight_sum) = (Sym2::default(), 0.0);
        let mut depth = DepthInPixels::default();
        for i in 0..count as u32 {
            let distance = from + (i as f32 + 0.5) * step;
            let position = ray.origin + distance * ray.direction;
            let across = steps.map(|step| {
                let moved = step.origin + distance * step.direction;
                moved - moved.dot(ray.direction) * ray.direction
            });
            let mut here = 1.0;
            let mut structure = Sym2::default();
            if !matches!(density, Density::Uniform) {
                here = density.at(position);
                structure = depth.step(density, position, across, here, extinction * step);
            }
            let Some(Surroundings { spectrum, flux, dimmest }) = grid.around(position) else { continue };
            let seen = here * medium.seen_through(column.at(distance)) * step;
            let weight = flux * seen;
            if !(weight > 0.0 && weight.is_finite()) {
                continue;
            }
            structure.add(1.0, &slice(spectrum.to_array(), across));
            sum.add(weight, &structure);
            // Beside voxels without data, what they dilute is dimmer still.
            weight_sum += seen * dimmest;
        }
        let Sym2 { xx, xy, yy } = sum.map(|sum| sum / weight_sum);
        let sound = weight_sum > 0.0 && (xx + xy + yy + weight_sum).is_finite();
        if sound { Self { xx, xy, yy, weight: weight_sum } } else { Self::default() }
    }
}

/// Jᵀ S J of a symmetric matrix S = \[xx, yy, zz, xy, xz, yz\] for the two columns of J.
fn slice(matrix: [f32; 6], [right, down]: [Vec3; 2]) -> Sym2 {
    let matrix = symmetric(matrix);
    let below = matrix * down;
    Sym2 { xx: right.dot(matrix * right), xy: right.dot(below), yy: down.dot(below) }
}

/// Gradient and Hessian, in pixels, of the optical depth to the eye.
#[derive(Default)]
struct DepthInPixels {
    gradient: Vec2,
    hessian: Sym2,
}

impl DepthInPixels {
    /// What density x transmittance adds to the spectrum at a point \[cycles²/pixel²\]; then goes on by one
    /// step.
    fn step(
        &mut self,
        density: &Density,
        position: Vec3,
        across: [Vec3; 2],
        here: f32,
        extinction_step: f32,
    ) -> Sym2 {
        let found = density.derivatives(position);
        let slope = Vec2::from(across.map(|v| found.gradient.dot(v)));
        let hessian = slice(found.hessian, across);
        // Half of the step lies before its middle.
        self.add(0.5 * extinction_step, slope, &hessian);
        let mut shape = None;
        if here > 0.0 {
            let r = slope / here;
            let g = r - self.gradient;
            // Hess(ρ e^-τ)/(ρ e^-τ) = Hess ρ/ρ - Hess τ + (∇ρ/ρ - ∇τ)(∇ρ/ρ - ∇τ)ᵀ - (∇ρ/ρ)(∇ρ/ρ)ᵀ.
            let mut relative = hessian.map(|second| second / here);
            relative.add(-1.0, &self.hessian);
            let outer =
                Sym2 { xx: g.x * g.x - r.x * r.x, xy: g.x * g.y - r.x * r.y, yy: g.y * g.y - r.y * r.y };
            relative.add(1.0, &outer);
            shape = relative.through_eigenvalues(|curvature| curvature.abs() / (4.0 * PI * PI));
        }
        self.add(0.5 * extinction_step, slope, &hessian);
        shape.unwrap_or_default()
    }

    fn add(&mut self, depth: f32, slope: Vec2, hessian: &Sym2) {
        self.gradient += depth * slope;
        self.hessian.add(depth, hessian);
    }
}
