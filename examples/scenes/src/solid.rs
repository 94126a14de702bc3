//! Closed solids of triangles, and writing them as Wavefront OBJ.

use crate::outline::{Outline, area, circle};
use earcut::{Earcut, refine};
use glam::{DVec2, DVec3};
use std::fmt::Write;

/// Triangles that enclose one or more volumes, counter-clockwise seen from outside.
#[derive(Clone, Debug, Default)]
pub struct Solid {
    /// Corners.
    pub vertices: Vec<DVec3>,
    /// Three corners a triangle.
    pub triangles: Vec<[u32; 3]>,
}

impl Solid {
    /// The plate between `z = from` and `z = to` whose face is `outer` without `holes`.
    ///
    /// Faces are triangulated by ear clipping and then flipped to the Delaunay triangulation, which has no longer
    /// triangles than the outline demands.
    ///
    /// # Panics
    /// If an outline is not counter-clockwise, or `to <= from`.
    pub fn extruded(outer: &[DVec2], holes: &[Outline], from: f64, to: f64) -> Self {
        assert!(to > from, "a plate needs a thickness");
        let mut points: Vec<[f64; 2]> = Vec::new();
        let mut starts: Vec<u32> = Vec::new();
        for outline in std::iter::once(outer).chain(holes.iter().map(Vec::as_slice)) {
            assert!(area(outline) > 0.0, "outlines are counter-clockwise");
            starts.push(points.len() as u32);
            points.extend(outline.iter().map(|point| point.to_array()));
        }
        let mut face: Vec<u32> = Vec::new();
        Earcut::new().earcut_slice(&points, &starts[1..], &mut face);
        refine(&mut face, &points);

        let count = points.len() as u32;
        let layer = |z: f64| points.iter().map(move |point| DVec3::new(point[0], point[1], z));
        let mut solid = Self { vertices: layer(from).chain(layer(to)).collect(), triangles: Vec::new() };
        for corners in face.chunks_exact(3) {
            let [a, b, c] = [0, 1, 2].map(|i| DVec2::from_array(points[corners[i] as usize]));
            let (p, q, r) = match (b - a).perp_dot(c - a) > 0.0 {
                true => (corners[0], corners[1], corners[2]),
                false => (corners[0], corners[2], corners[1]),
            };
            solid.triangles.push([r, q, p]);
            solid.triangles.push([p + count, q + count, r + count]);
        }
        starts.push(count);
        for (ring, bounds) in starts.windows(2).enumerate() {
            for i in bounds[0]..bounds[1] {
                let next = if i + 1 == bounds[1] { bounds[0] } else { i + 1 };
                // Stone is on the left of the outer outline and on the right of a hole's.
                let (a, b) = if ring == 0 { (i, next) } else { (next, i) };
                solid.triangles.extend([[a, b, b + count], [a, b + count, a + count]]);
            }
        }
        solid
    }

    /// A lathed solid around the vertical through (`x`, `z`): `profile` = (radius, height) from the lowest to the
    /// highest; `sides` around.
    pub fn lathed(x: f64, z: f64, profile: &[DVec2], sides: u32) -> Self {
        let mut solid = Self::default();
        for point in profile {
            let ring = circle(DVec2::ZERO, point.x, sides);
            solid.vertices.extend(ring.iter().map(|at| DVec3::new(x + at.x, point.y, z + at.y)));
        }
        let top = (profile.len() as u32 - 1) * sides;
        let bottom_center = solid.vertices.len() as u32;
        solid.vertices.push(DVec3::new(x, profile[0].y, z));
        solid.vertices.push(DVec3::new(x, profile[profile.len() - 1].y, z));
        for i in 0..sides {
            let next = (i + 1) % sides;
            for below in (0..top).step_by(sides as usize) {
                let (a, b) = (below + i, below + next);
                solid.triangles.extend([[a, b + sides, b], [a, a + sides, b + sides]]);
            }
            solid.triangles.extend([[i, next, bottom_center], [top + next, top + i, bottom_center + 1]]);
        }
        solid
    }

    /// An axis-aligned block.
    pub fn block(min: DVec3, max: DVec3) -> Self {
        let face = [(min.x, min.y), (max.x, min.y), (max.x, max.y), (min.x, max.y)].map(DVec2::from);
        Self::extruded(&face, &[], min.z, max.z)
    }

    /// Adds another solid; where they overlap, both keep their triangles.
    pub fn append(&mut self, other: Self) {
        let first = self.vertices.len() as u32;
        self.vertices.extend(other.vertices);
        self.triangles.extend(other.triangles.iter().map(|corners| corners.map(|i| i + first)));
    }

    /// Wavefront OBJ text: `header` as comments, vertices in metres with four decimals (a tenth of a millimetre), and
    /// triangles.
    pub fn to_obj(&self, header: &str) -> String {
        let mut text = String::new();
        for line in header.lines() {
            writeln!(text, "# {line}").expect("a string takes all");
        }
        for v in &self.vertices {
            writeln!(text, "v {} {} {}", decimal(v.x), decimal(v.y), decimal(v.z))
                .expect("a string takes all");
        }
        for [a, b, c] in &self.triangles {
            writeln!(text, "f {} {} {}", a + 1, b + 1, c + 1).expect("a string takes all");
        }
        text
    }
}

/// Four decimals without trailing zeros, and no minus before zero.
fn decimal(value: f64) -> String {
    let text = format!("{value:.4}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}
