//! The C ABI of covbeam.
//!
//! Thin by rule: each function checks what the host passed (`memory`, `check`, `handle`), calls the core, and writes the
//! result; a failure becomes a status and a message (`status`). The headers in `include/` are generated from here, so the docs
//! of the functions are written for C programmers. Functions work on arrays; lines `@single`, `@kinds` and `@extra` of their
//! docs are for the program that makes the headers, see `tests/src/header`.
//!
//! Here stands what every function needs, and what several rooms have in common; the functions stand in rooms named as
//! core's.
#![deny(missing_docs)]
#![cfg_attr(not(test), deny(clippy::disallowed_methods))]

mod arrays;
mod beam;
mod beam_map;
mod check;
mod eye_ray;
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
mod light_field;
mod light_path;
mod march;
mod medium;
mod memory;
mod pair;
#[cfg(feature = "session")]
mod session;
mod spectrum;
mod status;
mod version;
mod voxels;
