//! Media of a scene.

pub mod density;
pub mod fogs;
pub mod glow;
pub mod volume;

use crate::medium::density::MediumDensity;
use crate::medium::glow::Glow;
use crate::scene::visibility::Heed;
use covbeam::{Medium, PhaseShare};
use std::sync::Arc;

/// Index into [`Scene::media`](crate::scene::Scene::media).
pub type MediumId = u32;

/// A medium and where there is how much of it.
#[derive(Clone, Debug)]
pub struct SceneMedium {
    /// Coefficients at density 1, and the phase function.
    pub medium: Medium<'static>,
    /// Phase functions beside that one's, of media that overlap.
    pub more: Vec<PhaseShare>,
    /// Relative density.
    pub density: MediumDensity,
    /// Light that it sends out of itself; a scene's lights have it, too, as [`Light::Glow`](crate::light::kinds::Light::Glow). None: it is dark.
    pub glow: Option<Arc<Glow>>,
    /// By which rays and lamps it is not heeded: of the rays those of the camera and those to lamps count.
    pub heed: Heed,
}
