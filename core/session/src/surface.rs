//! Photons on diffuse surfaces and the radiance that they make visible. Light straight from a lamp is looked
//! up by shadow rays; lamps themselves are invisible.

mod around;
pub(crate) mod clearance;
mod crowd;
pub(crate) mod encounter;
mod map;
pub(crate) mod origin;
mod photon;

pub(crate) use around::Around;
pub(crate) use crowd::CROWD;
pub use map::{Disks, SurfaceMap};
pub use photon::SurfacePhoton;
