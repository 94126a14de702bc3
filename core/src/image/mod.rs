//! Image space: how many eye rays the in-scattered light needs where, and the picture from the rays that were
//! traced.
//!
//! The grid knows how fast the light varies across the picture ([`ImageSpectrum`]); where it varies slowly, a
//! few rays under a wide filter ([`ImageFilter`]) tell as much as one a pixel. A pass of a host:
//!
//! 1. [`ImageSpectrum::along`] the eye rays of the nodes of a [`FilmLattice`], and [`FilmFilters::new`]:
//!    filters as wide as the spectra allow, none of which reaches where a narrower one is asked for;
//! 2. an eye ray through each pixel whose [`pixel_threshold`] is below its density: that of its filter,
//!    [`ImageFilter::density`], or [`FilmLattice::least_density`]. The host adds up what the rays saw
//!    ([`FilmSums`]) and the densities of all passes, pixel by pixel;
//! 3. whenever a picture is wanted: a [`Reconstruction`] of the sums over the densities, inside regions
//!    between silhouettes ([`film_regions`], [`part_regions`]); the filters checked by the samples ([`FilmFilters::evidence`],
//!    [`verify_filters`]): a spectrum is local, a filter is not, so each is narrowed until what it gives
//!    agrees with what narrower ones give; then the picture, tile by tile ([`Reconstruction::tile`]), and its
//!    error ([`standard_errors`]).
//!
//! Surfaces have spectra that the grid does not know: a host samples them on their own and adds them to the
//! picture.

mod blocks;
mod contacts;
mod error;
mod filter;
mod lattice;
mod mask;
mod reconstruction;
mod regions;
mod spectrum;
mod sums;
mod tile;
mod tilt;
mod verify;

pub use blocks::FilmNode;
pub use contacts::{PartError, RegionNode, part_regions};
pub use error::standard_errors;
pub use filter::ImageFilter;
pub use lattice::{FilmFilterNode, FilmFilters, FilmLattice};
pub use mask::pixel_threshold;
pub use reconstruction::{FilmSample, Reconstruction};
pub use regions::film_regions;
pub use spectrum::{ImageSpectrum, PixelStep};
pub use sums::{FilmSums, FilmUnit};
pub use tile::{FILM_TILE, FILM_TILE_PIXELS, FilmPixel};
pub use verify::{FilmEvidence, verify_filters};

use core::fmt;
use glam::Vec3;

/// Luminance of a linear colour with Rec. 709 primaries.
pub(crate) fn luminance(color: Vec3) -> f32 {
    color.dot(Vec3::new(0.2126, 0.7152, 0.0722))
}

/// Largest number of pixels across or down.
pub(crate) const MOST_PIXELS: u32 = 1 << 16;

/// A slice whose length is not the one that the picture asks for, or a picture of more than 65536 pixels
/// across or down, or 2³¹ in all.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FilmSizeError;

impl fmt::Display for FilmSizeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(
            "the length of a slice is not the one that the picture asks for, or the picture has more than 65536 pixels \
             across or down, or 2^31 in all",
        )
    }
}

impl core::error::Error for FilmSizeError {}

/// The four corners of a cell, as columns and rows, with their bilinear weights at a place in it; those
/// without weight are left out.
pub(crate) fn corners([right, below]: [f32; 2]) -> impl Iterator<Item = ([usize; 2], f32)> {
    let (left, above) = (1.0 - right, 1.0 - below);
    let corners =
        [([0, 0], left * above), ([0, 1], left * below), ([1, 0], right * above), ([1, 1], right * below)];
    corners.into_iter().filter(|(_, weight)| *weight != 0.0)
}

/// Number of pixels of a picture that is not too large.
pub(crate) fn pixel_count(width: u32, height: u32) -> Result<usize, FilmSizeError> {
    let count = u64::from(width) * u64::from(height);
    if width <= MOST_PIXELS && height <= MOST_PIXELS && count <= 1 << 31 {
        Ok(count as usize)
    } else {
        Err(FilmSizeError)
    }
}
