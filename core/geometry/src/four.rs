//! Four triangles side by side, and the test of a ray against them.

use crate::ray::Ray;
use crate::wide::VACANT;
use glam::{BVec4A, Vec3, Vec4};

/// Triangles side by side.
pub(crate) const LANES: usize = 4;

/// Up to four triangles.
#[derive(Clone, Copy)]
pub(crate) struct Four {
    /// Corners a, b and c, of each the coordinates x, y and z.
    corners: [[Vec4; 3]; 3],
    /// Of the triangles; then [`VACANT`], of one whose corners are NaN: nothing meets it.
    numbers: [u32; LANES],
}

/// What a ray meets of four triangles, side by side.
pub(crate) struct Met {
    /// A bit for each that is met.
    lanes: u32,
    distances: [f32; LANES],
    /// The edge functions opposite to a, b and c, and their sum.
    edges: [Vec4; 4],
}

impl Four {
    /// - `numbers`: of triangles in `corners`; [`VACANT`] behind the last.
    pub(crate) fn new(numbers: [u32; LANES], corners: &[[Vec3; 3]]) -> Self {
        let triangles = numbers.map(|number| corners.get(number as usize).copied().unwrap_or([Vec3::NAN; 3]));
        let side_by_side =
            |corner: usize, axis: usize| Vec4::from_array(triangles.map(|triangle| triangle[corner][axis]));
        Self { corners: [0, 1, 2].map(|corner| [0, 1, 2].map(|axis| side_by_side(corner, axis))), numbers }
    }

    /// The number of the triangle in a lane.
    pub(crate) fn number(&self, lane: usize) -> u32 {
        self.numbers[lane]
    }

    /// The numbers of all, by lane.
    pub(crate) fn numbers(&self) -> impl Iterator<Item = u32> {
        self.numbers.into_iter().filter(|&number| number != VACANT)
    }

    /// The corners of the triangle in a lane.
    pub(crate) fn corners(&self, lane: usize) -> [Vec3; 3] {
        self.corners.map(|[x, y, z]| Vec3::new(x[lane], y[lane], z[lane]))
    }
}

impl Met {
    /// The lanes of those that are met, and their distances.
    #[inline]
    pub(crate) fn lanes(&self) -> impl Iterator<Item = (usize, f32)> {
        let mut lanes = self.lanes;
        std::iter::from_fn(move || {
            let lane = lanes.trailing_zeros() as usize;
            lanes &= lanes.wrapping_sub(1);
            (lane < LANES).then(|| (lane, self.distances[lane]))
        })
    }

    /// The barycentric weights of the corners of the triangle in a lane that is met.
    pub(crate) fn weights(&self, lane: usize) -> Vec3 {
        let [u, v, w, sum] = self.edges.map(|edge| edge[lane]);
        Vec3::new(u, v, w) / sum
    }
}

/// A ray's direction as a permutation and shear that turn it into the z axis, with the ray's start: each number for four triangles.
///
/// Source: S. Woop, C. Benthin and I. Wald, *Watertight Ray/Triangle Intersection*, JCGT 2(1), 2013. Differs from
/// it in that an edge function of zero is not decided in double precision: both neighbours are hit.
pub(crate) struct Shear {
    axes: [usize; 3],
    origin: [Vec4; 3],
    shear: [Vec4; 2],
    stretch: Vec4,
}

impl Shear {
    #[inline(always)]
    pub(crate) fn new(ray: &Ray) -> Self {
        let size = ray.direction.abs();
        // The last of the largest.
        let axes = match () {
            () if size.z >= size.x && size.z >= size.y => [0, 1, 2],
            () if size.y >= size.x => [2, 0, 1],
            () => [1, 2, 0],
        };
        let [x, y, z] = axes.map(|axis| ray.direction[axis]);
        Self {
            axes,
            origin: axes.map(|axis| Vec4::splat(ray.origin[axis])),
            shear: [Vec4::splat(x / z), Vec4::splat(y / z)],
            stretch: Vec4::splat(1.0 / z),
        }
    }

    /// Those that are met at a distance in (0, `end`].
    #[inline(always)]
    pub(crate) fn meets(&self, four: &Four, end: f32) -> Option<Met> {
        let [a, b, c] = four.corners.each_ref().map(|corner| {
            let z = corner[self.axes[2]] - self.origin[2];
            let x = corner[self.axes[0]] - self.origin[0] - self.shear[0] * z;
            let y = corner[self.axes[1]] - self.origin[1] - self.shear[1] * z;
            [x, y, z]
        });
        // Exactly antisymmetric in the two corners, so neighbours agree on which side of an edge the ray is; both
        // take a ray on the edge.
        let u = c[0] * b[1] - c[1] * b[0];
        let v = a[0] * c[1] - a[1] * c[0];
        let w = b[0] * a[1] - b[1] * a[0];
        let is_in = all_at_least_zero(u, v, w) | all_at_least_zero(-u, -v, -w);
        if !is_in.any() {
            return None;
        }
        let sum = u + v + w;
        let [a, b, c] = [a, b, c].map(|corner| self.stretch * corner[2]);
        let distances = (u * a + v * b + w * c) / sum;
        // Also refuses NaN, where the triangle is seen exactly edge-on.
        let is_met = is_in & distances.cmpgt(Vec4::ZERO) & distances.cmple(Vec4::splat(end));
        let lanes = is_met.bitmask();
        (lanes != 0).then(|| Met { lanes, distances: distances.to_array(), edges: [u, v, w, sum] })
    }
}

/// False where one is NaN.
#[inline(always)]
fn all_at_least_zero(u: Vec4, v: Vec4, w: Vec4) -> BVec4A {
    u.cmpge(Vec4::ZERO) & v.cmpge(Vec4::ZERO) & w.cmpge(Vec4::ZERO)
}
