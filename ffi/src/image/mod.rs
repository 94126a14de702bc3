//! Image space: the spectrum around a pixel, the filters that it allows, and which pixels get an eye ray.

pub(crate) mod filter;
mod mask;
pub(crate) mod spectrum;
#[cfg(test)]
mod tests;
