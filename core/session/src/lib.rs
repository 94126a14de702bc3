//! covbeam's method as a library: pictures of scenes with fog, pass by pass.
//!
//! Hosts describe a scene ([`describe`]) and let a [`session`] render it. Below that, a [`scene::Scene`], [`settings::Settings`] and a
//! [`pass::Renderer`] make passes, which a [`film::Film`] adds up; [`render::render`] does that until a goal is reached.
#![doc = include_str!("../README.md")]
#![cfg_attr(not(test), deny(clippy::disallowed_methods))]

pub mod camera;
pub mod color;
pub mod describe;
pub mod eye;
pub mod film;
pub mod gather;
pub mod host;
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
