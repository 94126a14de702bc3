//! What the passes add up to. (contract stub)

use glam::Vec3;

/// One pass' picture, row by row from the upper left pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct PassImage {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Estimate of radiance [W/(m² sr)].
    pub radiance: Vec<Vec3>,
    /// Per pixel, over accepted pairs with contribution c (luminance): Σ c, Σ c·radius, Σ c·σ, number of pairs.
    /// Empty for methods that gather nothing (light-trace).
    pub gather: Vec<[f32; 4]>,
}
