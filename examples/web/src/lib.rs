//! A lamp, a glass ball and fog: progressive photon beams in a browser, with plain and with adaptive kernels.
//!
//! A page runs two instances of this library on the same settings. Both trace the same photons; one gathers
//! them with a kernel radius that is the same everywhere, the other with radii from the covariance grid.
//! Natively the same code gives the same bits (`tests/clients/web.sh`).

#![cfg_attr(not(test), deny(clippy::disallowed_methods))]

mod ball;
mod exports;
mod eye;
mod film;
mod photons;
mod scene;
mod straight;
mod view;

pub use scene::Settings;
pub use view::View;
