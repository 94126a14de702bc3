//! The C ABI of covbeam.
//!
//! Thin by rule: each function checks what the host passed (`memory`, `check`, `handle`), calls the core, and writes the
//! result; a failure becomes a status and a message (`status`). The headers in `include/` are generated from here, so the docs
//! of the functions are written for C programmers. Functions work on arrays; lines `@single`, `@kinds` and `@extra` of their
//! docs are for the program that makes the headers, see `tests/src/header`.
#![deny(missing_docs)]

mod arrays;
mod beam_map;
mod check;
mod column;
mod density;
mod edges;
mod emission;
#[cfg(test)]
mod field_tests;
mod film;
mod grid;
mod handle;
mod heap;
#[cfg(test)]
mod hostile;
mod image;
mod importance;
mod kernel;
mod layout;
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
#[cfg(feature = "session")]
mod session;
mod spectrum;
mod status;
mod types;
mod version;
