//! Frequency-aware photon beams.
//!
//! # Conventions
//!
//! - **Local light field** around a central ray: `l(x, y, u, v)`. `x, y` are offsets perpendicular to the ray
//!   in metres, `u, v` direction slopes along the same axes in radians. The frame `(x, y, z)` is right-handed
//!   and `z` is the direction of propagation.
//! - **Fourier kernel** `exp(-i 2π ω·q)`: frequencies in cycles/m and cycles/rad.
//! - **Covariance** Σ is the second moment of the spectrum, normalised by its integral (thesis Eq 5.12), so that
//!   `Hess f(p) = -4π² f(p) Σ`. A Gaussian of standard deviation `w` has Σ = 1/(4π²w²).
//! - **Units**: any unit of length will do (the docs say metre); powers are watts per colour channel.
//! - **cos θ** of a scattering event is dot(incoming propagation, outgoing propagation): forward is +1.
//!
//! Section and equation numbers without a source refer to L. Belcour, *A Frequency Analysis of Light Transport:
//! from Theory to Implementation* (2012).
#![no_std]
#![forbid(unsafe_code)]
#![deny(missing_docs)]

#[cfg(feature = "bvh")]
extern crate std;

mod beam;
#[cfg(feature = "bvh")]
mod beam_map;
mod grid;
mod image;
mod kernel;
mod light_field;
mod march;
mod math;
mod medium;
mod saved_grid;
mod voxels;

pub use glam::{Vec2, Vec3};

pub use beam::{
    BLOCK, Beam, BeamBlock, Crossing, EyeRay, Gathered, PARALLEL_SINE, Passage, cross, gather_pair,
};
#[cfg(feature = "bvh")]
pub use beam_map::{BeamMap, Contact, GatherScratch, MAX_BEAMS, Stop, Unfinished};
pub use grid::{Attenuation, CovarianceGrid, FluenceCell, FluenceGrid, GridCell};
pub use image::{
    FILM_TILE, FILM_TILE_PIXELS, FilmEvidence, FilmFilterNode, FilmFilters, FilmLattice, FilmNode, FilmPixel,
    FilmSample, FilmSizeError, FilmSums, FilmUnit, ImageFilter, ImageSpectrum, PixelStep, Reconstruction,
    film_regions, pixel_threshold, standard_errors, verify_filters,
};
pub use kernel::{Kernel, KernelShape, Schedule, error_bound, progressive_radius};
pub use light_field::{Curvature, EVEN_LAMP, FluenceSpectrum, LightField};
pub use march::{MARCH_KNOTS, March, MarchCell, MarchError, MarchKnot, MarchSample};
pub use medium::{
    Column, Density, DensityGrid, Derivatives, ExponentialDensity, Knot, Medium, PhaseFunction, PhaseKind,
};
pub use voxels::{GridError, GridLayout};
