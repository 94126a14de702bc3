//! Triangles in a local frame of their own: hierarchy, ray intersection, curvature.

use covbeam::Curvature;
use glam::{DVec3, Vec3, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::bvh2::{Bvh2, leaf_collapser::collapse, reinsertion::ReinsertionOptimizer};
use obvhs::ploc::{PlocBuilder, PlocSearchDistance, SortPrecision};
use obvhs::ray::{Ray, RayHit};

/// Boxes of the hierarchy grow by this much in the local frame [-1, 1]³. It covers the rounding of the box test
/// and of the triangle test for origins up to `NEAR` away (about 2e-6), so no triangle is culled that its
/// neighbour's edge test relies on.
pub const PADDING: f32 = 1e-5;

/// Rays that start farther than this from the local origin are first moved towards it.
const NEAR: f64 = 4.0;

/// A local frame: centred and scaled by a power of two, so that what it was made around lies in [-1, 1]³.
///
/// So a figurine of 1e-4 units and one 1e6 units away are traced with the same relative accuracy.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    center: DVec3,
    /// Length of one local unit.
    scale: f64,
}

impl Frame {
    /// Around a box that is not a point.
    pub fn around(min: DVec3, max: DVec3) -> Self {
        let scale = libm::exp2(libm::log2(0.5 * (max - min).max_element()).ceil());
        Self { center: (0.5 * (min + max)).as_vec3().as_dvec3(), scale }
    }

    /// Length of one local unit.
    pub fn scale(&self) -> f64 {
        self.scale
    }

    /// A point in the frame.
    pub fn local(&self, point: DVec3) -> Vec3 {
        ((point - self.center) / self.scale).as_vec3()
    }

    /// A point of the frame outside of it.
    pub fn outside(&self, local: Vec3) -> DVec3 {
        local.as_dvec3() * self.scale + self.center
    }

    /// A ray in the frame, `direction` unit, and the distance outside at which it starts there. None if it ends before
    /// it comes near.
    pub fn ray(&self, origin: DVec3, direction: DVec3, max_distance: f64) -> Option<(Ray, f64)> {
        let mut start = (origin - self.center) / self.scale;
        let mut skipped = 0.0;
        let away = start.length();
        if away > NEAR {
            // All lies within sqrt(3) of the local origin.
            skipped = away - 2.0;
            start += direction * skipped;
        }
        let (start, reach) = (start.as_vec3(), (max_distance / self.scale - skipped) as f32);
        let ray = || Ray::new(start.into(), direction.as_vec3().into(), 0.0, reach);
        // Where single precision ends, a ray that has been moved towards the middle passes far from it.
        (reach > 0.0 && start.is_finite()).then(|| (ray(), skipped * self.scale))
    }
}

/// A hierarchy over boxes in a [`Frame`], whose elements a ray tests from near to far.
pub trait Hierarchy {
    /// Builds it.
    fn over(boxes: &[Aabb]) -> Self;

    /// The numbers of the boxes in the order of the leaves.
    fn order(&self) -> &[u32];

    /// Memory held \[bytes\].
    fn memory(&self) -> usize;

    /// Tests the elements in the ray's way: `test` gets the ray up to the nearest hit so far and a place in the order
    /// of the leaves, and returns the distance of a hit, or one beyond the ray's end.
    fn nearest(&self, ray: Ray, test: impl FnMut(&Ray, usize) -> f32);

    /// Whether the ray meets any of the elements in its way: `test` says so of one.
    fn any(&self, ray: Ray, test: impl FnMut(&Ray, usize) -> bool) -> bool;
}

/// Triangles with their hierarchy, smooth or flat.
#[derive(Clone)]
pub struct Triangles<H = Bvh2> {
    hierarchy: H,
    frame: Frame,
    /// In the frame, in the order of the hierarchy's leaves.
    corners: Vec<[Vec3; 3]>,
    /// Unit, one a corner, same order; empty = flat shading.
    normals: Vec<[Vec3; 3]>,
}

/// Where a ray meets a triangle.
#[derive(Clone, Copy, Debug)]
pub struct TriangleHit {
    /// Along the ray, > 0.
    pub distance: f64,
    /// In the order of the leaves.
    triangle: u32,
    /// Barycentric weights of the three corners.
    pub weights: Vec3,
}

impl<H: Hierarchy> Triangles<H> {
    /// Builds the hierarchy.
    ///
    /// - `corners`: in `frame`; none of the triangles without area.
    /// - `normals`: unit, one a corner; empty for flat shading.
    pub fn new(frame: Frame, corners: &[[Vec3; 3]], normals: &[[Vec3; 3]]) -> Self {
        let padded = |corners: &[Vec3; 3]| {
            let [a, b, c] = corners.map(Vec3A::from);
            Aabb::new(a.min(b).min(c) - PADDING, a.max(b).max(c) + PADDING)
        };
        let hierarchy = H::over(&corners.iter().map(padded).collect::<Vec<_>>());
        let order = hierarchy.order();
        let in_order = |values: &[[Vec3; 3]]| order.iter().map(|&i| values[i as usize]).collect();
        let normals = if normals.is_empty() { Vec::new() } else { in_order(normals) };
        Self { frame, corners: in_order(corners), normals, hierarchy }
    }

    /// How many.
    pub fn count(&self) -> usize {
        self.corners.len()
    }

    /// Memory held \[bytes\].
    pub fn memory(&self) -> usize {
        self.hierarchy.memory() + size_of_val(&self.corners[..]) + size_of_val(&self.normals[..])
    }

    /// The frame that they are in.
    pub fn frame(&self) -> &Frame {
        &self.frame
    }

    /// How far rounding may put a computed point from the surface, besides the rounding of the point itself.
    pub fn position_error(&self) -> f32 {
        f32::EPSILON * self.frame.scale as f32
    }

    /// Nearest hit with distance in (0, max_distance) along `direction` (unit). Watertight: a ray through a shared edge
    /// or vertex hits one of the triangles that share it.
    pub fn intersect(&self, origin: DVec3, direction: DVec3, max_distance: f64) -> Option<TriangleHit> {
        let (ray, skipped) = self.frame.ray(origin, direction, max_distance)?;
        let shear = Shear::new(direction.as_vec3());
        let mut nearest = None;
        self.hierarchy.nearest(ray, |ray, index| match shear.intersect(ray, &self.corners[index]) {
            Some((distance, weights)) if distance < ray.tmax => {
                nearest = Some((distance, index as u32, weights));
                distance
            }
            _ => f32::INFINITY,
        });
        nearest.map(|(distance, triangle, weights)| TriangleHit {
            distance: f64::from(distance) * self.frame.scale + skipped,
            triangle,
            weights,
        })
    }

    /// True if anything is hit with distance in (0, max_distance).
    pub fn occluded(&self, origin: DVec3, direction: DVec3, max_distance: f64) -> bool {
        self.any(origin, direction, max_distance, |_| true)
    }

    /// Whether `test` says so of any hit with distance in (0, max_distance) along `direction` (unit).
    pub fn any(
        &self,
        origin: DVec3,
        direction: DVec3,
        max_distance: f64,
        mut test: impl FnMut(TriangleHit) -> bool,
    ) -> bool {
        let Some((ray, skipped)) = self.frame.ray(origin, direction, max_distance) else { return false };
        let shear = Shear::new(direction.as_vec3());
        self.hierarchy.any(ray, |ray, index| {
            let hit = shear.intersect(ray, &self.corners[index]).filter(|(distance, _)| *distance < ray.tmax);
            hit.is_some_and(|(distance, weights)| {
                let distance = f64::from(distance) * self.frame.scale + skipped;
                test(TriangleHit { distance, triangle: index as u32, weights })
            })
        })
    }

    /// Which of the triangles given to [`Triangles::new`] was hit.
    pub fn index(&self, hit: &TriangleHit) -> usize {
        self.hierarchy.order()[hit.triangle as usize] as usize
    }

    /// Corners of the hit's triangle in the frame.
    pub fn corners(&self, hit: &TriangleHit) -> &[Vec3; 3] {
        &self.corners[hit.triangle as usize]
    }

    /// Corners of all triangles in the frame, in the order of the leaves.
    pub fn all_corners(&self) -> &[[Vec3; 3]] {
        &self.corners
    }

    /// Normals at the corners of the hit's triangle; None = flat shading.
    pub fn normals(&self, hit: &TriangleHit) -> Option<&[Vec3; 3]> {
        self.normals.get(hit.triangle as usize)
    }

    /// The hit point, on the triangle.
    pub fn position(&self, hit: &TriangleHit) -> DVec3 {
        self.frame.outside(interpolate(self.corners(hit), hit.weights))
    }
}

impl Hierarchy for Bvh2 {
    fn over(boxes: &[Aabb]) -> Self {
        build_hierarchy(boxes)
    }

    fn order(&self) -> &[u32] {
        &self.primitive_indices
    }

    fn memory(&self) -> usize {
        size_of_val(&self.nodes[..]) + size_of_val(&self.primitive_indices[..])
    }

    #[inline(always)]
    fn nearest(&self, ray: Ray, test: impl FnMut(&Ray, usize) -> f32) {
        self.ray_traverse(ray, &mut RayHit::none(), test);
    }

    #[inline(always)]
    fn any(&self, ray: Ray, mut test: impl FnMut(&Ray, usize) -> bool) -> bool {
        // A distance of 0 lies before any ray's end.
        !self.ray_traverse_miss(ray, |ray, index| if test(ray, index) { 0.0 } else { f32::INFINITY })
    }
}

/// Builds a binary hierarchy over boxes, at 0.4 us each.
pub fn build_hierarchy(boxes: &[Aabb]) -> Bvh2 {
    // The steps of obvhs' `build_bvh2` with its medium preset, without the validation that it adds in debug
    // builds.
    let mut hierarchy = PlocBuilder::with_capacity(boxes.len()).build(
        PlocSearchDistance::Medium,
        boxes,
        (0..boxes.len() as u32).collect(),
        SortPrecision::U64,
        3,
    );
    let mut optimizer = ReinsertionOptimizer::default();
    optimizer.run(&mut hierarchy, 0.05, None);
    collapse(&mut hierarchy, 8, 3.0);
    optimizer.run(&mut hierarchy, 0.1, None);
    // Only the steps above need these, and room for leaves of one triangle.
    hierarchy.parents = Vec::new();
    hierarchy.nodes.shrink_to_fit();
    // The traversal stack is sized by this and drops what does not fit.
    hierarchy.max_depth = hierarchy.max_depth.max(hierarchy.depth(0) + 1);
    hierarchy
}

/// Twice the area along the normal; exactly zero if the corners are on a line, because f64 holds the products
/// of f32 differences.
pub fn area_vector([a, b, c]: [Vec3; 3]) -> DVec3 {
    (b.as_dvec3() - a.as_dvec3()).cross(c.as_dvec3() - a.as_dvec3())
}

/// The shading normal and its curvature \[1 / unit of the corners\] at the barycentric `weights` of a triangle.
///
/// - `normals`: unit, one a corner; None = flat.
/// - `geometric_normal`: of the triangle, unit.
pub fn shade(
    corners: &[Vec3; 3],
    normals: Option<&[Vec3; 3]>,
    weights: Vec3,
    geometric_normal: Vec3,
) -> (Vec3, Curvature) {
    let smooth = normals.and_then(|normals| {
        let normal = interpolate(normals, weights);
        // Normals that contradict the triangle say nothing about the surface.
        (normal.dot(geometric_normal) > 0.0)
            .then(|| (normal.normalize(), interpolated_curvature(corners, normals, normal)))
    });
    let flat = || Curvature { tangent: geometric_normal.any_orthonormal_vector(), ..Curvature::default() };
    smooth.unwrap_or_else(|| (geometric_normal, flat()))
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
