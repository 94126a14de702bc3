//! Films: pictures from few eye rays, where these are needed, what they saw, and each pixel through its filter.

mod error;
mod handle;
mod layer;
pub(crate) mod picture;
mod plan;
pub(crate) mod rays;
mod regions;
mod size;
mod state;
#[cfg(test)]
mod tests;
