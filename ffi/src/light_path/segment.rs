//! Segments of light paths: what is checked of one, and the light field on its way along it.

use super::edge::{COVBEAM_MOST_EDGES, covbeam_edge};
use crate::arrays::write;
use crate::check::{
    direction, finite, finite_not_negative, not_negative, positive, positive_or_infinite, vector,
};
use crate::light_field::field::{covbeam_light_field, light_field};
use crate::medium::knots::{covbeam_knot, ordered_table};
use crate::medium::options::{covbeam_medium, read_medium};
use crate::memory::{Element, field, inputs, outputs};
use crate::status::{Failure, covbeam_status, run};
use covbeam_core::{Column, Edge, Knot, LightField, MOST_EDGES, Segment};
use glam::Vec3;

/// A straight piece of a photon's path that carries a light field.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct covbeam_segment {
    /// Where it starts [m], in or out of the grid. It runs along field.direction.
    pub origin: [f32; 3],
    /// Length [m] > 0; infinity reaches the end of the grid.
    pub length: f32,
    /// Flux at the origin [W] > 0, mean of the channels. Only its ratio to that of other segments matters: where
    /// a tenth of the photons carry fields, it need not be ten times the beam's.
    pub power: f32,
    /// 1 if the light comes from its source without scattering in a medium or on a diffuse surface (mirrors and
    /// glass are no scattering), else 0.
    pub unscattered: u32,
    /// The light field at the origin.
    pub field: covbeam_light_field,
    /// The edges that the light passes, sorted by depth: such as covbeam_find_edges finds, or 0.
    pub edges: [covbeam_edge; COVBEAM_MOST_EDGES],
    /// Number of edges that count.
    pub edge_count: u32,
    /// How the light is attenuated: NULL takes it from the medium. A host with media of its own gives a table
    /// of (distance from the origin, optical depth up to there / extinction of the medium passed), both finite,
    /// neither falling.
    pub knots: *const covbeam_knot,
    /// Number of knots; 0 if knots is NULL.
    pub knot_count: usize,
}

/// What a light field meets on its way along a segment.
pub(crate) struct Way {
    pub(crate) origin: Vec3,
    pub(crate) field: LightField,
    edges: [Edge; MOST_EDGES],
    edge_count: usize,
}

impl Way {
    /// As far as it has no end and no column.
    pub(crate) fn segment(&self) -> Segment<'_> {
        let (length, power, unscattered, column) = (f32::INFINITY, 1.0, false, Column::Uniform);
        let Self { origin, field, ref edges, edge_count } = *self;
        Segment { origin, length, power, unscattered, field, edges: &edges[..edge_count], column }
    }
}

/// The way along a segment, if it is sound.
fn way(e: Element<covbeam_segment>) -> Result<Way, Failure> {
    let edge_count = e.value.edge_count as usize;
    if edge_count > MOST_EDGES {
        return Err(field!(e, edge_count).is(format_args!("{edge_count} is more than {MOST_EDGES}")));
    }
    for i in 0..edge_count {
        let edge = field!(e, edges[i]);
        finite(field!(edge, depth))?;
        not_negative(field!(edge, distance))?;
        direction(field!(edge, towards))?;
        if i > 0 && e.value.edges[i].depth < e.value.edges[i - 1].depth {
            return Err(field!(edge, depth).is(format_args!("edges are not sorted by depth")));
        }
    }
    let (origin, field) = (vector(field!(e, origin))?, light_field(field!(e, field))?);
    Ok(Way { origin, field, edges: e.value.edges.map(Edge::from), edge_count })
}

/// The way along a segment and the host's columns, if all of it is sound.
pub(crate) fn whole<'a>(e: Element<covbeam_segment>) -> Result<(Way, Option<&'a [Knot]>), Failure> {
    positive_or_infinite(field!(e, length))?;
    positive(field!(e, power))?;
    if e.value.unscattered > 1 {
        return Err(field!(e, unscattered).is(format_args!("{} is neither 0 nor 1", e.value.unscattered)));
    }
    Ok((way(e)?, host_knots(e)?))
}

/// The table of columns that a host gives with a segment.
fn host_knots<'a>(e: Element<covbeam_segment>) -> Result<Option<&'a [Knot]>, Failure> {
    let covbeam_segment { knots, knot_count, .. } = e.value;
    if knots.is_null() {
        return if knot_count == 0 {
            Ok(None)
        } else {
            Err(field!(e, knots).is(format_args!("NULL, but knot_count is not 0")))
        };
    }
    // SAFETY: by the promise of the caller of `covbeam_grid_deposit`.
    unsafe { ordered_table(knots, knot_count, "knots of segments") }.map(Some)
}

/// The light field at a distance from a segment's origin: moved on through the medium, and occluded by each edge
/// up to there where it passes it.
///
/// @param count number of segments; with 0 nothing is done.
/// @param segments, segment_stride of each, origin, field and edges count; the rest is not looked at.
/// @param medium what it travels in; the mean extinction of the channels counts. Of no scattering and no
///     absorption in vacuum.
/// @param distances, distance_stride [m] >= 0, finite: to the photon's next event, at most to the surface on
///     which the segment ends.
/// @param out, out_stride the light fields there; segment->field is fine.
/// @note Thesis 5.3.1. In a density that varies, up to 256 look-ups of its derivatives from edge to edge.
/// @kinds <way <medium <f:q >field
/// @single covbeam_segment_field_at
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_segments_field_at(
    count: usize,
    segments: *const covbeam_segment,
    segment_stride: usize,
    medium: *const covbeam_medium,
    distances: *const f32,
    distance_stride: usize,
    out: *mut covbeam_light_field,
    out_stride: usize,
) -> covbeam_status {
    run(|| {
        inputs!(count, segments, segment_stride);
        // SAFETY: by the caller's promise.
        let medium = unsafe { read_medium(medium, "medium") }?;
        inputs!(count, distances, distance_stride);
        outputs!(count, out, out_stride);
        write(
            out,
            |i| Ok((way(segments.get(i))?, finite_not_negative(distances.get(i))?)),
            |(way, distance)| way.segment().field_at(&medium, distance).into(),
        )
    })
}

#[cfg(test)]
#[allow(clippy::undocumented_unsafe_blocks, reason = "every argument is a local, or refused")]
mod tests {
    use super::*;
    use crate::grid::deposit::covbeam_grid_deposit;
    use crate::grid::handle::{covbeam_grid, covbeam_grid_free, covbeam_grid_new};
    use crate::hostile::{Rule::*, UNTOUCHED, padded, refuses, values};
    use crate::medium::samples::{fog, haze};
    use crate::status::covbeam_status::*;
    use crate::voxels::covbeam_grid_layout;
    use core::ptr;

    fn edge(depth: f32, distance: f32, towards: [f32; 3]) -> covbeam_edge {
        covbeam_edge { depth, distance, towards }
    }

    fn segment(origin: [f32; 3], edges: &[covbeam_edge]) -> covbeam_segment {
        let mut all = [edge(f32::NAN, f32::NAN, [0.0; 3]); COVBEAM_MOST_EDGES];
        all[..edges.len()].copy_from_slice(edges);
        covbeam_segment {
            origin,
            length: 2.0,
            power: 1.0,
            unscattered: 1,
            field: LightField::point(Vec3::Z, 0.3).into(),
            edges: all,
            edge_count: edges.len() as u32,
            knots: ptr::null(),
            knot_count: 0,
        }
    }

    fn untouched() -> covbeam_light_field {
        covbeam_light_field { root: [UNTOUCHED; 10], x_axis: [0.0; 3], direction: [0.0; 3] }
    }

    #[test]
    fn a_bad_argument_is_refused_and_nothing_is_written() {
        let numbers = [
            (0.5, Finite),
            (0.4, Finite),
            (-1.0, Finite),
            // The later edge of two.
            (1.5, From(0.75)),
            (0.2, NotNegative),
            (1.0, Finite),
            (0.5, Finite),
            (0.0, Finite),
            (1.75, FiniteNotNegative),
        ];
        refuses(3, &numbers, |bad, n| {
            let edges = [edge(0.75, 0.5, [0.0, 1.0, 0.0]), edge(n[3], n[4], [n[5], n[6], n[7]])];
            let fog = fog();
            let (segment, mut out) = (segment([n[0], n[1], n[2]], &edges), untouched());
            let status = unsafe {
                let (segment, medium) = (bad.at(0, &segment), bad.at(1, &fog));
                covbeam_segments_field_at(1, segment, 0, medium, &n[8], 0, bad.at_mut(2, &mut out), 0)
            };
            (status, out != untouched())
        });
        let straight = edge(0.5, 0.5, [0.0; 3]);
        let mut many = segment([0.0; 3], &[]);
        many.edge_count = 5;
        for segment in [segment([0.0; 3], &[straight]), many] {
            let (mut out, mut grid) = (untouched(), ptr::null_mut::<covbeam_grid>());
            let layout = covbeam_grid_layout { min: [-1.0; 3], max: [1.0; 3], cells: [2; 3] };
            let statuses = unsafe {
                let made = covbeam_grid_new(&layout, &mut grid);
                let deposited = covbeam_grid_deposit(grid, &fog(), 1, &segment, 0, None, ptr::null_mut());
                covbeam_grid_free(grid);
                [made, deposited, covbeam_segments_field_at(1, &segment, 0, &fog(), &1.0, 0, &mut out, 0)]
            };
            assert_eq!(statuses, [COVBEAM_OK, COVBEAM_INVALID_VALUE, COVBEAM_INVALID_VALUE]);
            assert_eq!(out, untouched());
        }
    }

    #[test]
    fn many_are_the_bits_of_the_core() {
        let edges = [
            edge(-1.0, 0.1, [1.0, 0.0, 0.0]),
            edge(0.5, 0.3, [1.0, 2.0, 0.0]),
            edge(1.0, 0.1, [0.0, 1.0, 0.0]),
        ];
        let segments = padded(&[0, 1, 2, 3].map(|count| segment([0.1, 0.2, 0.3], &edges[..count])));
        let distances = padded(&[0.0, 0.7, 1.0, 3.0]);
        for medium in [fog(), haze()] {
            let mut out = padded(&[untouched(); 4]);
            let status = unsafe {
                let (from, size) = (&raw const segments[0].value, size_of_val(&segments[0]));
                let (distance, step) = (&raw const distances[0].value, size_of_val(&distances[0]));
                let (to, stride) = (&raw mut out[0].value, size_of_val(&out[0]));
                covbeam_segments_field_at(4, from, size, &medium, distance, step, to, stride)
            };
            assert_eq!(status, COVBEAM_OK);
            let Ok(medium) = (unsafe { read_medium(&medium, "medium") }) else { panic!("a sound medium") };
            for ((found, segment), distance) in
                values(&out).into_iter().zip(values(&segments)).zip(values(&distances))
            {
                let edges: Vec<Edge> =
                    segment.edges[..segment.edge_count as usize].iter().map(|edge| (*edge).into()).collect();
                let core = Segment {
                    origin: segment.origin.into(),
                    length: segment.length,
                    power: 1.0,
                    unscattered: true,
                    field: segment.field.into(),
                    edges: &edges,
                    column: Column::Uniform,
                };
                assert_eq!(found, core.field_at(&medium, distance).into());
            }
        }
    }
}
