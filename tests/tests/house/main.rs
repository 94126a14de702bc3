//! The house's own rules: what sources, headers and documents must keep to.

mod core_house;
mod figures;
mod guards;
mod header;
