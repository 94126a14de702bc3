//! Kernels for light in fog: spectra of light fields, their grid, and photon beams as wide as the light is smooth.
//!
#![cfg_attr(feature = "bvh", doc = include_str!("../README.md"))]
#![cfg_attr(
    not(feature = "bvh"),
    doc = "README.md has an example, which is shown here with the feature `bvh`."
)]
//!
//! # Conventions
//!
//! - **Local light field** around a central ray: `l(x, y, u, v)`. `x, y` are offsets perpendicular to the ray
//!   in metres, `u, v` direction slopes along the same axes in radians. The frame `(x, y, z)` is right-handed
//!   and `z` is the direction of propagation.
//! - **Fourier kernel** `exp(-i 2π ω·q)`: frequencies in cycles/m and cycles/rad.
//! - **Covariance** Σ is the second moment of the spectrum, normalised by its integral (thesis Eq 5.12), so
//!   that `Hess f(p) = -4π² f(p) Σ`. A Gaussian of standard deviation `w` has Σ = 1/(4π²w²).
//! - **Units**: any unit of length will do (the docs say metre); powers are watts per colour channel.
//! - **cos θ** of a scattering event is dot(incoming propagation, outgoing propagation): forward is +1.
//!
//! Section and equation numbers without a source refer to L. Belcour, *A Frequency Analysis of Light
//! Transport: from Theory to Implementation* (2012).
//!
//! # Where to read
//!
//! | thesis | what | module |
//! |---|---|---|
//! | 5.3.1 | light fields, their events, the slice of their spectrum (Eq 5.14) | [`light_field`] |
//! | | what attenuates and scatters them | [`medium`] |
//! | | a segment of a light path, the edges beside it, numbers to draw paths with | [`segment`], [`edges`], [`emission`] |
//! | 5.3.1, Eq 5.15 | the covariance grid | [`grid`], over [`voxels`] |
//! | 5.3.4 | kernels as wide as the light allows, and the gather of one pair | [`kernel`], [`beam`], [`pair`] |
//! | 5.3.2 | few eye rays and a filter: image space | [`image`] |
//! | 5.3.3 | shadow rays along an eye ray | [`march`] |
//! | | which light paths the picture needs | [`importance`], [`emission`] |
//! | | the same gather, of many rays and beams, fast | `beam_map` (feature `bvh`) |
#![no_std]
#![forbid(unsafe_code)]
#![deny(missing_docs)]
#![cfg_attr(not(test), deny(clippy::disallowed_methods))]

#[cfg(feature = "bvh")]
extern crate std;

mod along;
pub mod beam;
#[cfg(feature = "bvh")]
pub mod beam_map;
pub mod edges;
pub mod emission;
pub mod grid;
pub mod image;
pub mod importance;
pub mod kernel;
pub mod light_field;
pub mod march;
mod math;
pub mod medium;
pub mod pair;
mod saved_grid;
pub mod segment;
pub mod voxels;

pub use glam::{Vec2, Vec3};

pub use along::PLACES;
pub use beam::{ALONG_SINE, BLOCK, Beam, BeamBlock, Crossing, EyeRay, PARALLEL_SINE, cross};
#[cfg(feature = "bvh")]
pub use beam_map::{BeamMap, Contact, GatherScratch, MAX_BEAMS, Stop, Unfinished};
pub use edges::{Edge, Edges, MOST_EDGES, ProbeHit, find_edges};
pub use emission::{EMISSION_DIMENSIONS, EVEN_LAMP, EmissionGuide, path_number};
pub use grid::{CovarianceGrid, FluenceCell, FluenceGrid, GridCell};
pub use image::{
    FILM_TILE, FILM_TILE_PIXELS, FilmEvidence, FilmFilterNode, FilmFilters, FilmLattice, FilmNode, FilmPixel,
    FilmSample, FilmSizeError, FilmSums, FilmUnit, ImageFilter, ImageSpectrum, PartError, PixelStep,
    Reconstruction, RegionNode, film_regions, part_regions, pixel_threshold, standard_errors, verify_filters,
};
pub use importance::{
    Importance, ImportanceCell, ImportanceGrid, ImportanceSums, SegmentImportance, weight_window,
};
pub use kernel::{Kernel, KernelShape, Schedule, error_bound, progressive_radius};
pub use light_field::{Curvature, FluenceSpectrum, LightField};
pub use march::{MARCH_KNOTS, March, MarchCell, MarchError, MarchKnot, MarchSample};
pub use medium::{
    Column, Density, DensityGrid, Derivatives, ExponentialDensity, Knot, Medium, PhaseFunction, PhaseKind,
    PhaseShare,
};
pub use pair::{Gathered, gather_pair};
pub use segment::Segment;
pub use voxels::{GridError, GridLayout};
