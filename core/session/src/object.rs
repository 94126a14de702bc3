//! Objects of a scene.

pub mod geometry;
pub mod placed;

use crate::material::Material;
use crate::medium::MediumId;
use covbeam_geometry::shape::Shape;

/// A shape with what it is made of.
#[derive(Clone, Debug)]
pub struct Object {
    /// For messages.
    pub name: String,
    /// Geometry.
    pub shape: Shape,
    /// What light does there.
    pub material: Material,
    /// The medium inside a closed dielectric; None = clear.
    pub inside: Option<MediumId>,
    /// Of closed dielectrics that overlap the one of higher priority counts.
    pub priority: i32,
    /// Numbers of the closed dielectrics that lie inside of it, ascending: from [`nest`](crate::scene::nest).
    pub inner: Vec<u32>,
}
