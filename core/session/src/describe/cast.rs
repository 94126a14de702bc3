//! Nearest hits, for callers that look at what they have built.

use crate::work::failure::{Result, invalid};
use covbeam_geometry::instances::Instances;
use glam::Vec3;

/// How far the squared length of a unit direction may be from 1.
const UNIT: f32 = 1e-4;

/// Where a ray meets a surface: the dtype HIT of the Python module.
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
    /// Number given with the instance or the triangle; -1 = nothing hit.
    pub material: i32,
    /// Number given with the instance; -1 = nothing hit.
    pub object: i32,
}

impl HitRecord {
    /// No surface.
    pub const MISS: Self = Self {
        distance: f32::INFINITY,
        position: [0.0; 3],
        geometric_normal: [0.0; 3],
        normal: [0.0; 3],
        material: -1,
        object: -1,
    };
}

/// Casts rays, which must be as many as the hits.
pub fn cast(
    geometry: &Instances,
    origins: &[[f32; 3]],
    directions: &[[f32; 3]],
    hits: &mut [HitRecord],
) -> Result<()> {
    for (index, (origin, direction)) in origins.iter().zip(directions).enumerate() {
        if !Vec3::from_array(*origin).is_finite() {
            return Err(invalid!("origins[{index}]: {origin:?}; give finite points"));
        }
        if !((Vec3::from_array(*direction).length_squared() - 1.0).abs() <= UNIT) {
            return Err(invalid!("directions[{index}]: {direction:?}; give vectors of length 1"));
        }
    }
    for (hit, (origin, direction)) in hits.iter_mut().zip(origins.iter().zip(directions)) {
        let [origin, direction] = [*origin, *direction].map(|vector| Vec3::from_array(vector).as_dvec3());
        let found = geometry.intersect(origin, direction, f64::INFINITY).map(|hit| geometry.describe(&hit));
        *hit = found.map_or(HitRecord::MISS, |hit| HitRecord {
            distance: hit.distance,
            position: hit.position.to_array(),
            geometric_normal: hit.geometric_normal.to_array(),
            normal: hit.normal.to_array(),
            // With the bits that they were given with.
            material: hit.material as i32,
            object: hit.object as i32,
        });
    }
    Ok(())
}
