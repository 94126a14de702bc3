//! Triangles in a local frame of their own: hierarchy, ray intersection, curvature.

use crate::four::{Four, LANES, Met, Shear};
use crate::ray::Ray;
use crate::wide::Wide;
use covbeam::Curvature;
use glam::{DVec3, Vec3, Vec3A};
use obvhs::aabb::Aabb;

/// Boxes of the hierarchy grow by this much in the local frame [-1, 1]³. It covers the rounding of the box test
/// and of the triangle test for origins up to `NEAR` away (about 2e-6), so no triangle is culled that its
/// neighbour's edge test relies on.
pub(crate) const PADDING: f32 = 1e-5;

/// Rays that start farther than this from the local origin are first moved towards it.
const NEAR: f64 = 4.0;

/// A local frame: centred and scaled by a power of two, so that what it was made around lies in [-1, 1]³.
///
/// So a figurine of 1e-4 units and one 1e6 units away are traced with the same relative accuracy.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    center: DVec3,
    /// Length of one local unit: a power of two, so that what is multiplied by it or its inverse is not rounded.
    scale: f64,
    inverse_scale: f64,
}

impl Frame {
    /// Around a box that is not a point.
    pub fn around(min: DVec3, max: DVec3) -> Self {
        let scale = libm::exp2(libm::log2(0.5 * (max - min).max_element()).ceil());
        Self { center: (0.5 * (min + max)).as_vec3().as_dvec3(), scale, inverse_scale: 1.0 / scale }
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
    pub(crate) fn ray(&self, origin: DVec3, direction: DVec3, max_distance: f64) -> Option<(Ray, f64)> {
        let mut start = (origin - self.center) * self.inverse_scale;
        let mut skipped = 0.0;
        if start.length_squared() > NEAR * NEAR {
            // All lies within sqrt(3) of the local origin.
            skipped = start.length() - 2.0;
            start += direction * skipped;
        }
        let (start, reach) = (start.as_vec3(), (max_distance * self.inverse_scale - skipped) as f32);
        let ray = Ray { origin: start, direction: direction.as_vec3(), end: reach };
        // Where single precision ends, a ray that has been moved towards the middle passes far from it.
        (reach > 0.0 && start.is_finite()).then_some((ray, skipped * self.scale))
    }
}

/// Triangles with their hierarchy, smooth or flat.
#[derive(Clone)]
pub struct Triangles {
    frame: Frame,
    hierarchy: Wide,
    /// In the frame, one of the hierarchy's leaves each.
    leaves: Vec<Four>,
    count: usize,
    /// Unit, one a corner, as they were given; empty = flat shading.
    normals: Vec<[Vec3; 3]>,
}

/// Where a ray meets a triangle.
#[derive(Clone, Copy, Debug)]
pub struct TriangleHit {
    /// Along the ray, > 0.
    pub distance: f64,
    /// Its place among those of all leaves.
    place: u32,
    /// Barycentric weights of the three corners.
    pub weights: Vec3,
}

impl Triangles {
    /// Builds the hierarchy.
    ///
    /// - `corners`: in `frame`; none of the triangles without area.
    /// - `normals`: unit, one a corner; empty for flat shading.
    pub fn new(frame: Frame, corners: &[[Vec3; 3]], normals: &[[Vec3; 3]]) -> Self {
        let padded = |corners: &[Vec3; 3]| {
            let [a, b, c] = corners.map(Vec3A::from);
            Aabb::new(a.min(b).min(c) - PADDING, a.max(b).max(c) + PADDING)
        };
        let (hierarchy, leaves) = Wide::over(&corners.iter().map(padded).collect::<Vec<_>>());
        let leaves = leaves.into_iter().map(|numbers| Four::new(numbers, corners)).collect();
        Self { frame, hierarchy, leaves, count: corners.len(), normals: normals.to_vec() }
    }

    /// How many.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Memory held \[bytes\].
    pub fn memory(&self) -> usize {
        self.hierarchy.memory() + size_of_val(&self.leaves[..]) + size_of_val(&self.normals[..])
    }

    /// The frame that they are in.
    pub fn frame(&self) -> &Frame {
        &self.frame
    }

    /// How far rounding may put a computed point from the surface, besides the rounding of the point itself.
    pub fn position_error(&self) -> f32 {
        f32::EPSILON * self.frame.scale as f32
    }

    /// Nearest hit with distance in (0, max_distance) along `direction` (unit); of several as near, of the triangle that was given first.
    /// Watertight: a ray through a shared edge or vertex hits one of the triangles that share it.
    pub fn intersect(&self, origin: DVec3, direction: DVec3, max_distance: f64) -> Option<TriangleHit> {
        let (ray, skipped) = self.frame.ray(origin, direction, max_distance)?;
        let shear = Shear::new(&ray);
        let mut found: Option<(u32, TriangleHit)> = None;
        self.hierarchy.nearest(&ray, |mut end, index| {
            let leaf = &self.leaves[index];
            let Some(met) = shear.meets(leaf, end) else { return end };
            for (lane, distance) in met.lanes() {
                let number = leaf.number(lane);
                let is_before = |found: (u32, TriangleHit)| distance == end && number < found.0;
                if distance < end || found.is_some_and(is_before) {
                    end = distance;
                    found = Some((number, self.hit(&met, (index, lane), distance, skipped)));
                }
            }
            end
        });
        found.map(|(_, hit)| hit)
    }

    /// A triangle that is met: in a lane of a leaf.
    fn hit(&self, met: &Met, (leaf, lane): (usize, usize), distance: f32, skipped: f64) -> TriangleHit {
        TriangleHit {
            distance: f64::from(distance) * self.frame.scale + skipped,
            place: (LANES * leaf + lane) as u32,
            weights: met.weights(lane),
        }
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
        let shear = Shear::new(&ray);
        self.hierarchy.any(&ray, |index| {
            let Some(met) = shear.meets(&self.leaves[index], ray.end) else { return false };
            let mut before_end = met.lanes().filter(|(_, distance)| *distance < ray.end);
            before_end.any(|(lane, distance)| test(self.hit(&met, (index, lane), distance, skipped)))
        })
    }

    fn at(&self, hit: &TriangleHit) -> (&Four, usize) {
        (&self.leaves[hit.place as usize / LANES], hit.place as usize % LANES)
    }

    /// Which of the triangles given to [`Triangles::new`] was hit.
    pub fn index(&self, hit: &TriangleHit) -> usize {
        let (leaf, lane) = self.at(hit);
        leaf.number(lane) as usize
    }

    /// Corners of the hit's triangle in the frame.
    pub fn corners(&self, hit: &TriangleHit) -> [Vec3; 3] {
        let (leaf, lane) = self.at(hit);
        leaf.corners(lane)
    }

    /// Corners of all triangles in the frame, as they were given.
    pub fn all_corners(&self) -> Vec<[Vec3; 3]> {
        let mut all = vec![[Vec3::ZERO; 3]; self.count];
        for leaf in &self.leaves {
            for (lane, number) in leaf.numbers().enumerate() {
                all[number as usize] = leaf.corners(lane);
            }
        }
        all
    }

    /// Normals at the corners of the hit's triangle; None = flat shading.
    pub fn normals(&self, hit: &TriangleHit) -> Option<&[Vec3; 3]> {
        if self.normals.is_empty() { None } else { Some(&self.normals[self.index(hit)]) }
    }

    /// The hit point, on the triangle.
    pub fn position(&self, hit: &TriangleHit) -> DVec3 {
        self.frame.outside(interpolate(&self.corners(hit), hit.weights))
    }
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
