//! Marches: where shadow rays go along an eye ray, for light scattered once.

pub(crate) mod expected;
mod handle;
pub(crate) mod knots;
pub(crate) mod rounds;
#[cfg(test)]
mod tests;
