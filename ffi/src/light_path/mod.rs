//! Light paths: their segments, the edges beside them, and the numbers that their decisions are drawn with.

pub(crate) mod edge;
mod emission_guide;
pub(crate) mod find_edges;
mod path_numbers;
pub(crate) mod segment;
