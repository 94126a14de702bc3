//! A model placed in the world by an affine transform.

use crate::MAX_COORDINATE;
use crate::hit::Hit;
use crate::triangles::{TriangleHit, Triangles, area_vector, shade};
use covbeam::Curvature;
use glam::{DMat3, DMat4, DVec3, Vec3};

/// Columns of a transform are taken as dependent if the box that they span, of sides made unit, has a volume below
/// this: double precision then leaves nine digits of the inverse.
const SINGULAR: f64 = 1e-7;

/// Why a transform was refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum InstanceError {
    /// NaN or infinite.
    #[error("matrix: has a number that is not finite: {0:?}")]
    NotFinite(Box<[f64; 16]>),
    /// The last row is another one.
    #[error("matrix: the last row is {0:?}; give an affine one, [0, 0, 0, 1]")]
    NotAffine([f64; 4]),
    /// What it makes has no inside.
    #[error("matrix: flattens the mesh to nothing: {0:?}; leave the instance out")]
    Flat(Box<[f64; 16]>),
    /// Beyond [`MAX_COORDINATE`].
    #[error("matrix: takes the mesh to {min} .. {max}; stay within 1e9")]
    TooFar {
        /// Lower corner.
        min: DVec3,
        /// Upper corner.
        max: DVec3,
    },
}

/// A model placed in the world.
#[derive(Clone, Debug)]
pub struct Instance {
    /// Number of the model.
    pub model: usize,
    /// Number that hits bear.
    pub object: u32,
    /// Number that hits bear; None: the triangles' own.
    pub material: Option<u32>,
    linear: DMat3,
    translation: DVec3,
    inverse: DMat3,
    /// Length that no unit vector of the model's space exceeds in the world.
    stretch: f64,
    /// In the world.
    pub bounds: (DVec3, DVec3),
}

impl Instance {
    /// - `matrix`: model to world, affine, by rows.
    /// - `bounds`: of the model in its space; infinite and the wrong way round without triangles.
    ///
    /// # Errors
    /// A matrix that cannot be used.
    pub fn new(
        model: usize,
        matrix: &[f64; 16],
        bounds: (DVec3, DVec3),
        object: u32,
        material: Option<u32>,
    ) -> Result<Self, InstanceError> {
        let rows = DMat4::from_cols_array(matrix).transpose();
        if !rows.is_finite() {
            return Err(InstanceError::NotFinite(Box::new(*matrix)));
        }
        if matrix[12..] != [0.0, 0.0, 0.0, 1.0] {
            return Err(InstanceError::NotAffine([matrix[12], matrix[13], matrix[14], matrix[15]]));
        }
        let linear = DMat3::from_mat4(rows);
        let unit = |column: DVec3| column.normalize_or_zero();
        let volume = unit(linear.x_axis).dot(unit(linear.y_axis).cross(unit(linear.z_axis)));
        let inverse = linear.inverse();
        if volume.abs() < SINGULAR || !inverse.is_finite() {
            return Err(InstanceError::Flat(Box::new(*matrix)));
        }
        let stretch = linear.to_cols_array().iter().map(|x| x * x).sum::<f64>().sqrt();
        let translation = rows.w_axis.truncate();
        let corner = |i: usize| {
            let choose = |axis: usize| if i >> axis & 1 == 0 { bounds.0[axis] } else { bounds.1[axis] };
            linear * DVec3::new(choose(0), choose(1), choose(2)) + translation
        };
        let world = if bounds.0.cmple(bounds.1).all() {
            (1..8).map(corner).fold((corner(0), corner(0)), |(min, max), p| (min.min(p), max.max(p)))
        } else {
            bounds
        };
        let reach = world.0.abs().max(world.1.abs()).max_element();
        if bounds.0.x <= bounds.1.x && !(reach <= f64::from(MAX_COORDINATE)) {
            return Err(InstanceError::TooFar { min: world.0, max: world.1 });
        }
        Ok(Self { model, object, material, linear, translation, inverse, stretch, bounds: world })
    }

    /// Nearest hit with world distance in (0, max_distance); `direction` is unit. The distance returned is the world's.
    pub(crate) fn intersect(
        &self,
        triangles: &Triangles,
        origin: DVec3,
        direction: DVec3,
        max_distance: f64,
    ) -> Option<TriangleHit> {
        // The difference first: it loses nothing far from the origin.
        let start = self.inverse * (origin - self.translation);
        let along = self.inverse * direction;
        let length = along.length();
        let mut hit = triangles.intersect(start, along / length, max_distance * length)?;
        hit.distance /= length;
        Some(hit)
    }

    /// Whether anything is hit with world distance in (0, max_distance); `direction` is unit.
    pub(crate) fn occluded(
        &self,
        triangles: &Triangles,
        origin: DVec3,
        direction: DVec3,
        max_distance: f64,
    ) -> bool {
        self.any(triangles, origin, direction, max_distance, |_| true)
    }

    /// Whether `test` says so of any hit with world distance in (0, max_distance); `direction` is unit. It gets the world's distances.
    pub(crate) fn any(
        &self,
        triangles: &Triangles,
        origin: DVec3,
        direction: DVec3,
        max_distance: f64,
        mut test: impl FnMut(TriangleHit) -> bool,
    ) -> bool {
        let start = self.inverse * (origin - self.translation);
        let along = self.inverse * direction;
        let length = along.length();
        triangles.any(start, along / length, max_distance * length, |mut hit| {
            hit.distance /= length;
            test(hit)
        })
    }

    /// A hit as on a surface that is shaded flat; its `material` is 0.
    pub(crate) fn describe_flat(&self, triangles: &Triangles, hit: &TriangleHit) -> Hit {
        let position = self.linear * triangles.position(hit) + self.translation;
        let geometric_normal =
            (self.normals_to_world() * area_vector(triangles.corners(hit))).normalize().as_vec3();
        // The rounding of the point to f32, and that of the mesh's own arithmetic in f32.
        let own_error = triangles.position_error() * self.stretch as f32;
        let error = f32::EPSILON * position.abs().max_element() as f32 + own_error;
        Hit {
            distance: hit.distance as f32,
            position: position.as_vec3(),
            geometric_normal,
            normal: geometric_normal,
            curvature: Curvature {
                tangent: geometric_normal.any_orthonormal_vector(),
                ..Curvature::default()
            },
            object: self.object,
            material: 0,
            mark: [0; 3],
            is_alone: false,
            offset: 4.0 * error,
        }
    }

    /// Everything about a hit; its `material` is 0.
    pub(crate) fn describe(&self, triangles: &Triangles, hit: &TriangleHit) -> Hit {
        let mut described = self.describe_flat(triangles, hit);
        let Some(normals) = triangles.normals(hit) else { return described };
        let to_world = self.normals_to_world();
        let normals = normals.map(|normal| (to_world * normal.as_dvec3()).normalize().as_vec3());
        // The triangle in the world but for its place and size, which single precision could not hold.
        let [a, b, c] = triangles.corners(hit).map(|corner| corner.as_dvec3());
        let edge = |to: DVec3| (self.linear * ((to - a) / self.stretch)).as_vec3();
        let corners = [Vec3::ZERO, edge(b), edge(c)];
        let (normal, mut curvature) =
            shade(&corners, Some(&normals), hit.weights, described.geometric_normal);
        let size = triangles.frame().scale() * self.stretch;
        for value in [&mut curvature.along, &mut curvature.across, &mut curvature.twist] {
            let scaled = (f64::from(*value) / size) as f32;
            // Normals that turn over a sliver of next to no height say nothing about the surface.
            *value = if scaled.is_finite() { scaled } else { 0.0 };
        }
        (described.normal, described.curvature) = (normal, curvature);
        described
    }

    /// Takes normals from the model to the world; not their lengths. A mirroring transform's front stays the front:
    /// the sign of n · v does not change.
    fn normals_to_world(&self) -> DMat3 {
        self.inverse.transpose()
    }
}
