//! The records of arrays that Python reads and writes: the dtype HIT of the module; EDGE is core's [`covbeam::Edge`].

use covbeam::ProbeHit;
use covbeam_geometry::hit::Hit;
use glam::Vec3;

/// Where a ray meets a surface: see HIT in the Python module. A ray that meets none has the distance infinity.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HitRecord {
    /// Along the unit direction \[m\]; infinity = nothing hit.
    pub distance: f32,
    /// The point, moved onto the surface.
    pub position: [f32; 3],
    /// Unit, of the triangle by its winding.
    pub geometric_normal: [f32; 3],
    /// Unit, on the same side.
    pub normal: [f32; 3],
    /// Principal frame of the curvature: unit tangent.
    pub tangent: [f32; 3],
    /// Curvature along the tangent \[1/m\].
    pub along: f32,
    /// Curvature across it \[1/m\].
    pub across: f32,
    /// Their mixed term \[1/m\].
    pub twist: f32,
    /// Number given with the instance or the triangle; -1 = nothing hit.
    pub material: i32,
    /// Number given with the instance; -1 = nothing hit.
    pub object: i32,
    /// How far rays that leave start off the surface \[m\].
    pub offset: f32,
}

impl HitRecord {
    /// No surface.
    pub const MISS: Self = Self {
        distance: f32::INFINITY,
        position: [0.0; 3],
        geometric_normal: [0.0; 3],
        normal: [0.0; 3],
        tangent: [0.0; 3],
        along: 0.0,
        across: 0.0,
        twist: 0.0,
        material: -1,
        object: -1,
        offset: 0.0,
    };

    /// A hit whose `object` is the object's number.
    pub fn new(hit: &Hit, object: i32, material: i32) -> Self {
        Self {
            distance: hit.distance,
            position: hit.position.to_array(),
            geometric_normal: hit.geometric_normal.to_array(),
            normal: hit.normal.to_array(),
            tangent: hit.curvature.tangent.to_array(),
            along: hit.curvature.along,
            across: hit.curvature.across,
            twist: hit.curvature.twist,
            material,
            object,
            offset: hit.offset,
        }
    }

    /// What the search for edges reads of a hit; None if nothing was hit.
    pub fn probe_hit(&self) -> Option<ProbeHit> {
        let normal = Vec3::from_array(self.geometric_normal);
        let Self { distance, offset, .. } = *self;
        (distance < f32::INFINITY).then_some(ProbeHit { distance, normal, offset })
    }
}
