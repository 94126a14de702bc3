//! covbeam's method as a library: pictures of scenes with fog, pass by pass.
//!
//! A host describes a scene ([`scene::Scene`]), chooses [`settings::Settings`], makes a [`pass::Renderer`] of both, and adds the passes up in a
//! [`film::Film`]; [`render::render`] does that until a goal is reached. Light is traced with the spectra of the kernel crate ([`covbeam`]), guided
//! to where the picture needs it, and gathered with kernels as wide as those spectra allow.

pub mod camera;
pub mod color;
pub mod describe;
pub mod eye;
pub mod film;
pub mod gather;
pub mod kind;
pub mod lamps;
pub mod light;
pub mod material;
pub mod medium;
pub mod object;
pub mod pass;
pub mod paths;
pub mod pilot;
pub mod plan;
pub mod random;
pub mod render;
pub mod scene;
pub mod session;
pub mod settings;
pub mod surface;
pub mod work;
