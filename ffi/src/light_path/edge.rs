//! Edges beside a ray.

use covbeam_core::{Edge, MOST_EDGES};

/// An edge of an occluder beside a ray.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct covbeam_edge {
    /// Distance along the ray at which the edge passes by [m], finite; one at a depth <= 0 does not count.
    pub depth: f32,
    /// Distance from the ray to the edge there [m] >= 0; infinity is no edge.
    pub distance: f32,
    /// Direction from the ray to the nearest point of the edge, any length but 0.
    pub towards: [f32; 3],
}

/// Most edges of a segment.
pub const COVBEAM_MOST_EDGES: usize = 4;

const _: () = assert!(COVBEAM_MOST_EDGES == MOST_EDGES);

impl From<covbeam_edge> for Edge {
    fn from(edge: covbeam_edge) -> Self {
        Self { depth: edge.depth, distance: edge.distance, towards: edge.towards.into() }
    }
}

impl From<Edge> for covbeam_edge {
    fn from(edge: Edge) -> Self {
        Self { depth: edge.depth, distance: edge.distance, towards: edge.towards.into() }
    }
}
