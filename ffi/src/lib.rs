//! The C ABI of covbeam.
//!
//! Thin by rule: each function checks what the host passed (`memory`, `check`, `handle`), calls the core, and writes the
//! result; a failure becomes a status and a message (`status`). The header in `include/` is generated from here, so the docs
//! of the functions are written for C programmers.
#![deny(missing_docs)]

mod arrays;
mod beam_map;
mod check;
mod column;
mod density;
mod edges;
mod emission;
mod film;
mod grid;
mod handle;
#[cfg(test)]
mod hostile;
mod image;
mod importance;
mod kernel;
mod layout;
mod light_field;
mod light_fields;
mod march;
mod medium;
mod medium_points;
mod medium_rays;
mod memory;
#[cfg(test)]
mod overhead;
mod pair;
mod phase;
mod picture;
mod segment;
mod spectrum;
mod status;
mod types;
mod version;
