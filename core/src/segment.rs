//! A straight segment of a light path, with the edges that it passes.

use crate::edges::Edge;
use crate::light_field::LightField;
use crate::medium::{Column, Medium};
use glam::Vec3;

/// A straight stretch of a light path through a medium, with the light field at its start and the edges
/// beside it.
///
/// What a light path does with one: [`CovarianceGrid::deposit`](crate::CovarianceGrid::deposit), which is
/// over all of it, and [`Segment::field_at`], which is as far as the light flies.
#[derive(Clone, Copy, Debug)]
pub struct Segment<'a> {
    /// Where it starts \[m\], in or out of the grid's box. It runs along `field.direction`.
    pub origin: Vec3,
    /// Length \[m\] > 0; infinity reaches the end of the box.
    pub length: f32,
    /// Power \[W\] > 0 at `origin`.
    pub power: f32,
    /// Whether the light comes from its source without scattering in the medium or on a diffuse surface: then
    /// its [`LightField::variance_along_ray`] counts too.
    pub unscattered: bool,
    /// The light field at `origin`.
    pub field: LightField,
    /// The edges of occluders that the light passes, sorted by depth; those at depths <= 0 are behind it and
    /// do not count.
    pub edges: &'a [Edge],
    /// The column from `origin`: [`Density::column`](crate::Density::column) of the medium.
    pub column: Column<'a>,
}

impl Segment<'_> {
    /// The light field at a distance from `origin`: moved on as by [`LightField::travel_through`], and
    /// occluded by each edge up to there where it passes the edge.
    ///
    /// - `medium`: what the segment is in; [`Medium::default`] is vacuum.
    /// - `distance` \[m\] >= 0, which may be beyond `length`.
    ///
    /// Of edges that are not sorted those that lie before an earlier one do not count.
    ///
    /// ```
    /// use covbeam::{Column, Edge, LightField, Medium, Segment, Vec3};
    /// let mut field = LightField::point(Vec3::Z, 0.1);
    /// let edges = [Edge { depth: 1.0, distance: 0.1, towards: Vec3::X }];
    /// let (origin, column) = (Vec3::ZERO, Column::Uniform);
    /// let segment = Segment { origin, length: 5.0, power: 1.0, unscattered: true, field, edges: &edges, column };
    /// let found = segment.field_at(&Medium::default(), 3.0);
    /// field.travel(1.0);
    /// field.occlude(Vec3::X, 0.1);
    /// field.travel(2.0);
    /// assert_eq!(found, field);
    /// ```
    pub fn field_at(&self, medium: &Medium, distance: f32) -> LightField {
        let (mut field, from) = self.pass_edges(medium, distance, |_, _| ());
        field.travel_through(medium, self.origin + from * field.direction, distance - from);
        field
    }

    /// The field behind the last edge up to `distance`, and how far away that is. `stretch` is told of the
    /// ways up to each of the edges: the field at the start, and where it starts and ends.
    pub(crate) fn pass_edges(
        &self,
        medium: &Medium,
        distance: f32,
        mut stretch: impl FnMut(&LightField, [f32; 2]),
    ) -> (LightField, f32) {
        let (mut field, mut from) = (self.field, 0.0);
        for edge in self.edges {
            if edge.depth > 0.0 && edge.depth >= from && edge.depth <= distance {
                stretch(&field, [from, edge.depth]);
                field.travel_through(medium, self.origin + from * field.direction, edge.depth - from);
                field.occlude(edge.towards, edge.distance);
                from = edge.depth;
            }
        }
        (field, from)
    }
}
