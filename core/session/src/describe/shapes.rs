//! Spheres, boxes and rectangles.

use super::fields::Fields;
use super::volumes::Media;
use crate::material::Asks;
use crate::object::Object;
use crate::scene::{Material, MediumDensity};
use crate::work::failure::Result;
use covbeam_geometry::MAX_COORDINATE;
use covbeam_geometry::shape::Shape;
use glam::Vec3;

/// A shape, exact where a mesh would have corners. Of closed ones of glass that overlap, that of higher priority counts; of equal priority what
/// lies inside of another one, but for a hundredth of its size, counts before that, else the later one.
#[derive(Clone, Debug)]
pub struct ShapeFields {
    /// A sphere, a box or a rectangle; meshes are placed as instances.
    pub shape: Shape,
    /// Number of its material.
    pub material: u32,
    /// Number of the volume that fills it, even and with no end of its own, or -1. Only of glass, which an index of 1 makes a mere bound.
    pub volume: i32,
    /// From -1000 to 1000.
    pub priority: i32,
}

impl ShapeFields {
    pub(super) fn object(&self, index: usize, materials: &[Material], media: &Media) -> Result<Object> {
        let fields = Fields::of("shapes", index);
        let shape = self.checked(&fields)?;
        let Some(material) = materials.get(self.material as usize).copied() else {
            let wanted = format_args!("the number of one of the {} materials", materials.len());
            return Err(fields.wrong("material", self.material, wanted));
        };
        if matches!(material, Material::Lobes(lobes) if lobes.asks != Asks::Nothing) {
            return Err(fields.wrong(
                "material",
                self.material,
                "one that asks nothing: shapes are not the host's",
            ));
        }
        let is_glass = material.index().is_some();
        if is_glass && !shape.is_closed() {
            return Err(fields.wrong(
                "material",
                self.material,
                "no glass to a rectangle, which has no inside",
            ));
        }
        if !(-1000..=1000).contains(&self.priority) {
            return Err(fields.wrong("priority", self.priority, "a number from -1000 to 1000"));
        }
        let inside = match self.volume {
            -1 => None,
            _ if !is_glass => {
                return Err(fields.wrong("volume", self.volume, "-1 to what is not of glass"));
            }
            _ => {
                let even = media.even(self.volume);
                let wanted =
                    "-1, or the number of a volume without voxels, which is not the world's and no sum";
                Some(even.ok_or_else(|| fields.wrong("volume", self.volume, wanted))?)
            }
        };
        let name = format!("shapes[{index}]");
        Ok(Object { name, shape, material, inside, priority: self.priority, inner: Vec::new() })
    }

    fn checked(&self, fields: &Fields) -> Result<Shape> {
        let point = |name, value: Vec3| fields.point(name, value.as_dvec3().to_array()).map(|_| ());
        let (least, most) = (1.0 / MAX_COORDINATE, MAX_COORDINATE);
        match &self.shape {
            Shape::Sphere { center, radius } => {
                point("center", *center)?;
                fields.length("radius", f64::from(*radius))?;
            }
            Shape::Rectangle { corner, edge_u, edge_v } => {
                point("corner", *corner)?;
                point("edge_u", *edge_u)?;
                point("edge_v", *edge_v)?;
                let area = edge_u.as_dvec3().cross(edge_v.as_dvec3()).length();
                if !((least * least) as f64 <= area && edge_u.cross(*edge_v).length() > 0.0) {
                    return Err(fields.wrong("edge_v", edge_v.to_array(), "edges that span an area"));
                }
            }
            Shape::Box { min, max } => {
                point("min", *min)?;
                point("max", *max)?;
                let size = *max - *min;
                if !(size.min_element() >= least && size.max_element() <= 2.0 * most) {
                    return Err(fields.wrong("max", max.to_array(), "an upper corner above the lower one"));
                }
            }
            Shape::Mesh(_) => return Err(fields.wrong("shape", "a mesh", "a sphere, a box or a rectangle")),
        }
        Ok(self.shape.clone())
    }
}

impl Media {
    /// The medium of a volume that fills shapes: homogeneous, and none of the world's or of a sum.
    fn even(&self, volume: i32) -> Option<u32> {
        let id = u32::try_from(volume).ok()?;
        let medium = self.all.get(id as usize)?;
        let is_even = matches!(medium.density, MediumDensity::Uniform) && Some(id) != self.outside;
        (is_even && !self.sums.contains(&id)).then_some(id)
    }
}
