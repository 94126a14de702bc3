//! The core's mathematics, against closed forms, finite differences and the naive twin.

mod along;
mod beam;
mod beam_map;
mod beam_map_bits;
mod density;
mod find_edges;
mod grid;
mod image_space;
mod importance;
mod kernel;
mod light_field;
mod march;
mod medium;
mod operators;
mod radius_rules;
mod triangles;
mod vectors;
