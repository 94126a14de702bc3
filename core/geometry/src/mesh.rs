//! Triangle meshes as objects of a scene: read, placed, their normals, what they enclose.

use std::path::Path;

use covbeam::Curvature;
use glam::{DVec3, Quat, Vec3};

use crate::MAX_COORDINATE;
use crate::obj::{self, ObjError, ObjTriangles};
use crate::triangles::{Frame, TriangleHit, Triangles, area_vector, shade};

/// A triangle mesh with smooth normals and its hierarchy.
#[derive(Clone)]
pub struct Mesh {
    triangles: Triangles,
    min: Vec3,
    max: Vec3,
    volume: f64,
    open_edges: usize,
    degenerate: usize,
}

impl std::fmt::Debug for Mesh {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { min, max, open_edges, degenerate, .. } = self;
        let count = self.triangle_count();
        write!(f, "Mesh {{ {count} triangles, {min}..{max}, {open_edges} open edges, {degenerate} dropped }}")
    }
}

/// How a mesh is placed in the scene: first scaled, then rotated, then moved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// Uniform, > 0.
    pub scale: f32,
    /// Unit.
    pub rotation: Quat,
    /// Scene units.
    pub translation: Vec3,
}

impl Default for Placement {
    fn default() -> Self {
        Self { scale: 1.0, rotation: Quat::IDENTITY, translation: Vec3::ZERO }
    }
}

impl Placement {
    /// Where a point of the mesh is in the scene.
    fn place(&self, point: Vec3) -> DVec3 {
        let rotated = self.rotation.as_dquat() * point.as_dvec3();
        rotated * f64::from(self.scale) + self.translation.as_dvec3()
    }
}

/// Why a mesh was refused.
#[derive(Debug, thiserror::Error)]
pub enum MeshError {
    /// The file could not be read.
    #[error("cannot be read: {0}")]
    Unreadable(#[from] std::io::Error),
    /// A directory, a device or a pipe.
    #[error("is not a regular file")]
    NotAFile,
    /// The file's content is wrong.
    #[error("{0}")]
    Content(#[from] ObjError),
    /// An index points beyond the lists.
    #[error("triangle {0} refers to a vertex or normal that does not exist")]
    Index(usize),
    /// All triangles are points or lines.
    #[error("all {0} triangles have zero area")]
    AllDegenerate(usize),
    /// A placed vertex is NaN, infinite or beyond [`MAX_COORDINATE`], or the mesh is too small for f32.
    #[error(
        "placed in the scene it spans {min} to {max}, expected a size in 1e-9..=1e9 and coordinates within ±1e9"
    )]
    Size {
        /// Lower corner.
        min: DVec3,
        /// Upper corner.
        max: DVec3,
    },
}

/// The surface at a hit.
pub struct MeshSurface {
    /// The point, on the triangle.
    pub position: DVec3,
    /// Of the triangle, outward, unit.
    pub geometric_normal: Vec3,
    /// For shading: unit, on the same side.
    pub normal: Vec3,
    /// Of the field of shading normals \[1 / scene unit\], positive = convex towards `normal`.
    pub curvature: Curvature,
}

impl Mesh {
    /// Reads an OBJ file (see [`obj::parse`]) and places it. `smooth`: interpolate the file's normals, or if it
    /// has none, the angle-weighted means of the adjacent triangles'; otherwise triangles are shaded flat.
    pub fn load(path: &Path, placement: &Placement, smooth: bool) -> Result<Self, MeshError> {
        // A device or a pipe may never end.
        if !std::fs::metadata(path)?.is_file() {
            return Err(MeshError::NotAFile);
        }
        Self::new(obj::parse(&std::fs::read(path)?)?, placement, smooth)
    }

    /// Builds a mesh from triangles. `smooth` as in [`Mesh::load`].
    ///
    /// Vertices at the same position are one. Triangles of exactly zero area are dropped and counted. A closed
    /// mesh whose triangles face inwards is turned outwards; normals follow the triangles' side.
    pub fn new(source: ObjTriangles, placement: &Placement, smooth: bool) -> Result<Self, MeshError> {
        let ObjTriangles { positions, normals, indices } = source;
        let has_normals = !normals.is_empty();
        let known = |&index: &u32| {
            (index as usize) < positions.len() && (!has_normals || (index as usize) < normals.len())
        };
        if let Some(wrong) = indices.iter().position(|triangle| !triangle.iter().all(known)) {
            return Err(MeshError::Index(wrong));
        }

        let world: Vec<DVec3> = positions.iter().map(|position| placement.place(*position)).collect();
        let (min, max) = bounds(indices.iter().flatten().map(|&index| world[index as usize]))?;
        let frame = Frame::around(min, max);
        let local: Vec<Vec3> = world.iter().map(|&p| frame.local(p)).collect();
        let welded = weld(&local);
        let edges = open_edges(&indices, &welded);

        let total = indices.len();
        let mut triangles: Vec<[u32; 3]> = indices
            .into_iter()
            .filter(|&[a, b, c]| area_vector([a, b, c].map(|i| local[i as usize])) != DVec3::ZERO)
            .collect();
        let degenerate = total - triangles.len();
        if triangles.is_empty() {
            return Err(MeshError::AllDegenerate(total));
        }
        let mut volume = triangles.iter().map(|t| signed_volume(t.map(|i| local[i as usize]))).sum::<f64>();
        if edges == 0 && volume < 0.0 {
            triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
            volume = -volume;
        }

        let corner_normals = match (smooth, has_normals) {
            (false, _) => Vec::new(),
            (true, true) => file_normals(&triangles, &local, &normals, placement.rotation),
            (true, false) => mean_normals(&triangles, &local, &welded),
        };
        let corners: Vec<[Vec3; 3]> = triangles.iter().map(|t| t.map(|i| local[i as usize])).collect();
        Ok(Self {
            triangles: Triangles::new(frame, &corners, &corner_normals),
            min: min.as_vec3(),
            max: max.as_vec3(),
            volume: volume * frame.scale() * frame.scale() * frame.scale(),
            open_edges: edges,
            degenerate,
        })
    }

    /// True if the mesh encloses a volume: every edge belongs to exactly two triangles that run through it in
    /// opposite directions.
    pub fn is_closed(&self) -> bool {
        self.open_edges == 0 && self.volume > 0.0
    }

    /// Number of edges that do not belong to exactly two triangles of opposite direction.
    pub fn open_edges(&self) -> usize {
        self.open_edges
    }

    /// Triangles that were dropped because their area is exactly zero.
    pub fn degenerate(&self) -> usize {
        self.degenerate
    }

    /// Triangles that can be hit.
    pub fn triangle_count(&self) -> usize {
        self.triangles.count()
    }

    /// Corners of the triangles that can be hit, as they are placed.
    pub fn placed_corners(&self) -> Vec<[Vec3; 3]> {
        let frame = self.triangles.frame();
        let placed = |corner: Vec3| frame.outside(corner).as_vec3();
        self.triangles.all_corners().into_iter().map(|corners| corners.map(placed)).collect()
    }

    /// Lower and upper corner of the bounding box.
    pub fn bounds(&self) -> (Vec3, Vec3) {
        (self.min, self.max)
    }

    /// Enclosed volume of a closed mesh \[scene unit³\].
    pub fn volume(&self) -> f64 {
        self.volume
    }

    /// How far rounding may put a computed point from the surface, besides the rounding of the point itself.
    pub fn position_error(&self) -> f32 {
        self.triangles.position_error()
    }

    /// Nearest hit with distance in (0, max_distance). Watertight: a ray through a shared edge or vertex hits
    /// one of the triangles that share it.
    pub fn intersect(&self, origin: DVec3, direction: Vec3, max_distance: f64) -> Option<TriangleHit> {
        self.triangles.intersect(origin, direction.as_dvec3(), max_distance)
    }

    /// True if anything is hit with distance in (0, max_distance).
    pub fn occluded(&self, origin: DVec3, direction: Vec3, max_distance: f64) -> bool {
        self.triangles.occluded(origin, direction.as_dvec3(), max_distance)
    }

    /// Outward normal of the hit's triangle.
    pub fn geometric_normal(&self, hit: &TriangleHit) -> Vec3 {
        area_vector(self.triangles.corners(hit)).normalize().as_vec3()
    }

    /// Position, normals and curvature at a hit.
    pub fn surface(&self, hit: &TriangleHit) -> MeshSurface {
        let (corners, normals) = (self.triangles.corners(hit), self.triangles.normals(hit));
        let geometric_normal = self.geometric_normal(hit);
        let (normal, mut curvature) = shade(&corners, normals, hit.weights, geometric_normal);
        for value in [&mut curvature.along, &mut curvature.across, &mut curvature.twist] {
            *value /= self.triangles.frame().scale() as f32;
        }
        MeshSurface { position: self.triangles.position(hit), geometric_normal, normal, curvature }
    }

    /// True if `point` lies inside a closed mesh: the nearest surface is seen from behind. Three directions
    /// vote, because one of them may hit an edge between a front and a back.
    pub fn contains(&self, point: DVec3) -> bool {
        // No two of them are related to each other or to a coordinate axis.
        const DIRECTIONS: [Vec3; 3] = [
            Vec3::new(0.408_107_3, 0.867_205_1, 0.285_342_9),
            Vec3::new(-0.727_331_4, 0.130_627_3, 0.673_739_7),
            Vec3::new(0.251_937_8, -0.530_449_1, -0.809_412_1),
        ];
        let from_behind = |direction: &&Vec3| {
            let hit = self.intersect(point, **direction, f64::INFINITY);
            hit.is_some_and(|hit| self.geometric_normal(&hit).dot(**direction) > 0.0)
        };
        DIRECTIONS.iter().filter(from_behind).count() >= 2
    }
}

/// Lower and upper corner of the box around placed vertices, of a size that can be computed with.
fn bounds(mut vertices: impl Iterator<Item = DVec3> + Clone) -> Result<(DVec3, DVec3), MeshError> {
    let min = vertices.clone().fold(DVec3::INFINITY, DVec3::min);
    let max = vertices.clone().fold(DVec3::NEG_INFINITY, DVec3::max);
    let limit = f64::from(MAX_COORDINATE);
    let size = (max - min).max_element();
    // Also false for NaN.
    let bounded = vertices.all(|p| p.abs().max_element() <= limit) && size >= 1.0 / limit && size <= limit;
    if bounded { Ok((min, max)) } else { Err(MeshError::Size { min, max }) }
}

/// For each vertex the first one at the same position.
fn weld(positions: &[Vec3]) -> Vec<u32> {
    let mut first = std::collections::HashMap::with_capacity(positions.len());
    // Adding 0 turns -0 into 0.
    let key = |p: Vec3| (p + Vec3::ZERO).to_array().map(f32::to_bits);
    positions.iter().zip(0..).map(|(&p, index)| *first.entry(key(p)).or_insert(index)).collect()
}

/// Counts the edges that do not run exactly once each way between welded vertices.
fn open_edges(indices: &[[u32; 3]], welded: &[u32]) -> usize {
    let mut edges: Vec<(u32, u32)> = indices
        .iter()
        .map(|t| t.map(|i| welded[i as usize]))
        .flat_map(|[a, b, c]| [(a, b), (b, c), (c, a)])
        // A triangle that is a line runs through the same edge both ways; one that is a point has no edge.
        .filter(|(a, b)| a != b)
        .collect();
    edges.sort_unstable();
    let runs = |edge: (u32, u32)| {
        let start = edges.partition_point(|&other| other < edge);
        edges[start..].iter().take_while(|&&other| other == edge).count()
    };
    edges.iter().filter(|&&(a, b)| runs((a, b)) != 1 || runs((b, a)) != 1).count()
}

fn signed_volume([a, b, c]: [Vec3; 3]) -> f64 {
    a.as_dvec3().dot(b.as_dvec3().cross(c.as_dvec3())) / 6.0
}

/// The file's normals, rotated; negated if most of them contradict their triangles.
fn file_normals(triangles: &[[u32; 3]], local: &[Vec3], normals: &[Vec3], rotation: Quat) -> Vec<[Vec3; 3]> {
    let corner = |&i: &u32| rotation * normals[i as usize].normalize();
    let mut result: Vec<[Vec3; 3]> = triangles.iter().map(|t| t.each_ref().map(corner)).collect();
    let agrees = |(triangle, normals): (&[u32; 3], &[Vec3; 3])| {
        let side = area_vector(triangle.map(|i| local[i as usize]))
            .dot((normals[0] + normals[1] + normals[2]).as_dvec3());
        side.signum()
    };
    if triangles.iter().zip(&result).map(agrees).sum::<f64>() < 0.0 {
        result.iter_mut().flatten().for_each(|normal| *normal = -*normal);
    }
    result
}

/// Per vertex the mean of the adjacent triangles' normals, weighted by their angle there.
///
/// Source: G. Thürmer and C. Wüthrich, *Computing vertex normals from polygonal facets* (1998).
fn mean_normals(triangles: &[[u32; 3]], local: &[Vec3], welded: &[u32]) -> Vec<[Vec3; 3]> {
    let mut sums = vec![DVec3::ZERO; local.len()];
    for triangle in triangles {
        let corners = triangle.map(|i| local[i as usize].as_dvec3());
        let normal = area_vector(triangle.map(|i| local[i as usize])).normalize();
        for k in 0..3 {
            let (here, next, previous) = (corners[k], corners[(k + 1) % 3], corners[(k + 2) % 3]);
            sums[welded[triangle[k] as usize] as usize] +=
                (next - here).angle_between(previous - here) * normal;
        }
    }
    let mean = |triangle: &[u32; 3]| {
        let own = area_vector(triangle.map(|i| local[i as usize])).normalize();
        // Triangles back to back cancel: each then keeps its own normal.
        triangle.map(|i| sums[welded[i as usize] as usize].try_normalize().unwrap_or(own).as_vec3())
    };
    triangles.iter().map(mean).collect()
}
