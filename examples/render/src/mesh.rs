//! Triangle meshes: smooth normals, hierarchy, ray intersection, curvature.

use std::path::Path;

use covbeam::Curvature;
use glam::{DVec3, Quat, Vec3, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::bvh2::{Bvh2, leaf_collapser::collapse, reinsertion::ReinsertionOptimizer};
use obvhs::ploc::{PlocBuilder, PlocSearchDistance, SortPrecision};
use obvhs::ray::{Ray, RayHit};

use crate::obj::{self, ObjError, ObjTriangles};

/// Largest magnitude of a coordinate in a scene, and the inverse of the smallest size of an object: squares and
/// products of lengths stay far inside the range of f32.
pub const MAX_COORDINATE: f32 = 1e9;

/// Boxes of the hierarchy grow by this much in the local frame [-1, 1]³. It covers the rounding of the box test
/// and of the triangle test for origins up to [`NEAR`] away (about 2e-6), so no triangle is culled that its
/// neighbour's edge test relies on.
const PADDING: f32 = 1e-5;

/// Rays that start farther than this from the local origin are first moved towards the mesh.
const NEAR: f64 = 4.0;

/// A triangle mesh with smooth normals and its hierarchy.
///
/// Triangles live in a local frame, centred and scaled by a power of two into [-1, 1]³, so that a figurine of
/// 1e-4 units and one 1e6 units away are traced with the same relative accuracy.
#[derive(Clone)]
pub struct Mesh {
    hierarchy: Bvh2,
    /// Local frame, in the order of the hierarchy's leaves.
    triangles: Vec<[Vec3; 3]>,
    /// Unit, one a corner, same order; empty = flat shading.
    normals: Vec<[Vec3; 3]>,
    center: DVec3,
    /// World length of one local unit.
    scale: f32,
    min: Vec3,
    max: Vec3,
    volume: f64,
    open_edges: usize,
    degenerate: usize,
}

impl std::fmt::Debug for Mesh {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { min, max, open_edges, degenerate, .. } = self;
        let count = self.triangles.len();
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

/// Where a ray meets a mesh.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MeshHit {
    /// World units along the ray.
    pub(crate) distance: f64,
    triangle: u32,
    /// Barycentric weights of the three corners.
    weights: Vec3,
}

/// The surface at a [`MeshHit`].
pub(crate) struct MeshSurface {
    pub(crate) position: DVec3,
    pub(crate) geometric_normal: Vec3,
    pub(crate) normal: Vec3,
    pub(crate) curvature: Curvature,
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

        let place = |p: &Vec3| {
            let rotated = placement.rotation.as_dquat() * p.as_dvec3();
            rotated * f64::from(placement.scale) + placement.translation.as_dvec3()
        };
        let world: Vec<DVec3> = positions.iter().map(place).collect();
        let used = || indices.iter().flatten().map(|&index| world[index as usize]);
        let min = used().fold(DVec3::INFINITY, DVec3::min);
        let max = used().fold(DVec3::NEG_INFINITY, DVec3::max);
        let limit = f64::from(MAX_COORDINATE);
        let size = (max - min).max_element();
        // Also false for NaN.
        let bounded = used().all(|p| p.abs().max_element() <= limit) && size >= 1.0 / limit && size <= limit;
        if !bounded {
            return Err(MeshError::Size { min, max });
        }

        let center = (0.5 * (min + max)).as_vec3().as_dvec3();
        let scale = (0.5 * size).log2().ceil().exp2();
        let local: Vec<Vec3> = world.iter().map(|&p| ((p - center) / scale).as_vec3()).collect();
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
        let hierarchy = build_hierarchy(&corners);
        let order = &hierarchy.primitive_indices;
        let in_order = |values: &[[Vec3; 3]]| order.iter().map(|&i| values[i as usize]).collect::<Vec<_>>();
        Ok(Self {
            triangles: in_order(&corners),
            normals: if corner_normals.is_empty() { corner_normals } else { in_order(&corner_normals) },
            hierarchy,
            center,
            scale: scale as f32,
            min: min.as_vec3(),
            max: max.as_vec3(),
            volume: volume * scale.powi(3),
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
        self.triangles.len()
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
    pub(crate) fn position_error(&self) -> f32 {
        f32::EPSILON * self.scale
    }

    /// The ray in the local frame and the world distance at which it starts there.
    fn local_ray(&self, origin: DVec3, direction: Vec3, max_distance: f64) -> Option<(Ray, f64)> {
        let scale = f64::from(self.scale);
        let mut start = (origin - self.center) / scale;
        let mut skipped = 0.0;
        let away = start.length();
        if away > NEAR {
            // The mesh lies within sqrt(3) of the local origin.
            skipped = away - 2.0;
            start += direction.as_dvec3() * skipped;
        }
        let reach = (max_distance / scale - skipped) as f32;
        let ray = || Ray::new(start.as_vec3().into(), direction.into(), 0.0, reach);
        (reach > 0.0).then(|| (ray(), skipped * scale))
    }

    /// Nearest hit with distance in (0, max_distance). Watertight: a ray through a shared edge or vertex hits
    /// one of the triangles that share it.
    pub(crate) fn intersect(&self, origin: DVec3, direction: Vec3, max_distance: f64) -> Option<MeshHit> {
        let (ray, skipped) = self.local_ray(origin, direction, max_distance)?;
        let shear = Shear::new(direction);
        let mut nearest = None;
        self.hierarchy.ray_traverse(ray, &mut RayHit::none(), |ray, index| {
            match shear.intersect(ray, &self.triangles[index]) {
                Some((distance, weights)) if distance < ray.tmax => {
                    nearest = Some((distance, index as u32, weights));
                    distance
                }
                _ => f32::INFINITY,
            }
        });
        nearest.map(|(distance, triangle, weights)| MeshHit {
            distance: f64::from(distance) * f64::from(self.scale) + skipped,
            triangle,
            weights,
        })
    }

    /// True if anything is hit with distance in (0, max_distance).
    pub(crate) fn occluded(&self, origin: DVec3, direction: Vec3, max_distance: f64) -> bool {
        let Some((ray, _)) = self.local_ray(origin, direction, max_distance) else { return false };
        let shear = Shear::new(direction);
        !self.hierarchy.ray_traverse_miss(ray, |ray, index| {
            shear.intersect(ray, &self.triangles[index]).map_or(f32::INFINITY, |(distance, _)| distance)
        })
    }

    /// Outward normal of the hit's triangle.
    pub(crate) fn geometric_normal(&self, hit: &MeshHit) -> Vec3 {
        area_vector(self.triangles[hit.triangle as usize]).normalize().as_vec3()
    }

    /// Position, normals and curvature at a hit.
    pub(crate) fn surface(&self, hit: &MeshHit) -> MeshSurface {
        let triangle = self.triangles[hit.triangle as usize];
        let local = interpolate(&triangle, hit.weights).as_dvec3();
        let geometric_normal = self.geometric_normal(hit);
        let smooth = self.normals.get(hit.triangle as usize).and_then(|normals| {
            let normal = interpolate(normals, hit.weights);
            // Normals that contradict the triangle say nothing about the surface.
            (normal.dot(geometric_normal) > 0.0).then(|| {
                let curvature = interpolated_curvature(&triangle, normals, normal);
                (normal.normalize(), curvature)
            })
        });
        let flat =
            || Curvature { tangent: geometric_normal.any_orthonormal_vector(), ..Curvature::default() };
        let (normal, mut curvature) = smooth.unwrap_or_else(|| (geometric_normal, flat()));
        for value in [&mut curvature.along, &mut curvature.across, &mut curvature.twist] {
            *value /= self.scale;
        }
        MeshSurface {
            position: local * f64::from(self.scale) + self.center,
            geometric_normal,
            normal,
            curvature,
        }
    }

    /// True if `point` lies inside a closed mesh: the nearest surface is seen from behind. Three directions
    /// vote, because one of them may hit an edge between a front and a back.
    pub(crate) fn contains(&self, point: DVec3) -> bool {
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

/// Twice the area along the normal; exactly zero if the corners are on a line, because f64 holds the products
/// of f32 differences.
fn area_vector([a, b, c]: [Vec3; 3]) -> DVec3 {
    (b.as_dvec3() - a.as_dvec3()).cross(c.as_dvec3() - a.as_dvec3())
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

fn build_hierarchy(triangles: &[[Vec3; 3]]) -> Bvh2 {
    let padded = |corners: &[Vec3; 3]| {
        let [a, b, c] = corners.map(Vec3A::from);
        Aabb::new(a.min(b).min(c) - PADDING, a.max(b).max(c) + PADDING)
    };
    let boxes: Vec<Aabb> = triangles.iter().map(padded).collect();
    // The steps of obvhs' `build_bvh2` with its medium preset, without the validation that it adds in debug
    // builds.
    let mut hierarchy = PlocBuilder::with_capacity(boxes.len()).build(
        PlocSearchDistance::Medium,
        &boxes,
        (0..boxes.len() as u32).collect(),
        SortPrecision::U64,
        3,
    );
    let mut optimizer = ReinsertionOptimizer::default();
    optimizer.run(&mut hierarchy, 0.05, None);
    collapse(&mut hierarchy, 8, 3.0);
    optimizer.run(&mut hierarchy, 0.1, None);
    // The traversal stack is sized by this and drops what does not fit.
    hierarchy.max_depth = hierarchy.max_depth.max(hierarchy.depth(0) + 1);
    hierarchy
}

fn interpolate([a, b, c]: &[Vec3; 3], weights: Vec3) -> Vec3 {
    weights.x * *a + weights.y * *b + weights.z * *c
}

/// Curvature of the field `normalize(interpolated normal)` over a triangle: the 2x2 tensor S with dn = S dp in
/// the tangent plane, from the two edges, made symmetric. `normal` is the interpolated normal before it is made
/// unit.
fn interpolated_curvature(triangle: &[Vec3; 3], normals: &[Vec3; 3], normal: Vec3) -> Curvature {
    let length = normal.length();
    let unit = normal / length;
    let tangent = unit.any_orthonormal_vector();
    let bitangent = unit.cross(tangent);
    // Multiplying by the two axes also projects onto the tangent plane.
    let components = |v: Vec3| (v.dot(tangent), v.dot(bitangent));
    let (p1, p2) = (components(triangle[1] - triangle[0]), components(triangle[2] - triangle[0]));
    let (n1, n2) = (components(normals[1] - normals[0]), components(normals[2] - normals[0]));
    let determinant = (p1.0 * p2.1 - p2.0 * p1.1) * length;
    if determinant == 0.0 {
        return Curvature { tangent, ..Curvature::default() };
    }
    // S = [n1 n2] [p1 p2]^-1.
    let along = (n1.0 * p2.1 - n2.0 * p1.1) / determinant;
    let across = (n2.1 * p1.0 - n1.1 * p2.0) / determinant;
    let upper = (n2.0 * p1.0 - n1.0 * p2.0) / determinant;
    let lower = (n1.1 * p2.1 - n2.1 * p1.1) / determinant;
    Curvature { tangent, along, across, twist: 0.5 * (upper + lower) }
}

/// A ray's direction as a permutation and shear that turn it into the z axis.
///
/// Source: S. Woop, C. Benthin and I. Wald, *Watertight Ray/Triangle Intersection*, JCGT 2(1), 2013. Differs from
/// it in that an edge function of zero is not decided in double precision: both neighbours are hit.
struct Shear {
    axes: [usize; 3],
    shear: [f32; 2],
    stretch: f32,
}

impl Shear {
    fn new(direction: Vec3) -> Self {
        let d = direction.to_array();
        let z = (0..3).max_by(|&i, &j| d[i].abs().total_cmp(&d[j].abs())).unwrap_or(2);
        let axes = [(z + 1) % 3, (z + 2) % 3, z];
        Self { axes, shear: [d[axes[0]] / d[z], d[axes[1]] / d[z]], stretch: 1.0 / d[z] }
    }

    /// Distance > 0 and barycentric weights.
    #[inline]
    fn intersect(&self, ray: &Ray, triangle: &[Vec3; 3]) -> Option<(f32, Vec3)> {
        let origin = Vec3::from(ray.origin);
        let [a, b, c] = triangle.map(|corner| {
            let p = (corner - origin).to_array();
            let z = p[self.axes[2]];
            [p[self.axes[0]] - self.shear[0] * z, p[self.axes[1]] - self.shear[1] * z, self.stretch * z]
        });
        // Exactly antisymmetric in the two corners, so neighbours agree on which side of an edge the ray is; both
        // take a ray on the edge.
        let u = c[0] * b[1] - c[1] * b[0];
        let v = a[0] * c[1] - a[1] * c[0];
        let w = b[0] * a[1] - b[1] * a[0];
        if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
            return None;
        }
        let determinant = u + v + w;
        let distance = (u * a[2] + v * b[2] + w * c[2]) / determinant;
        // Also refuses NaN, where the triangle is seen exactly edge-on.
        (distance > 0.0).then(|| (distance, Vec3::new(u, v, w) / determinant))
    }
}
