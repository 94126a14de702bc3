//! Many meshes placed by transforms under one hierarchy, with a material a triangle, and what fills them.

use crate::host::Host;
use crate::material::{Asks, Material};
use crate::medium::fogs::AddedFogs;
use crate::object::geometry::{MOST_SURFACES, Shading, Surfaces};
use crate::scene::visibility::{Heed, Links, Rays};
use covbeam_geometry::hit::Hit;
use covbeam_geometry::instances::Instances;
use covbeam_geometry::shape::unite;
use glam::Vec3;
use std::borrow::Cow;
use std::sync::Arc;

/// Along which a way out of what a place is inside of is looked for: unit, and no two of its parts are related to each other or to those of a
/// scene.
const PROBE: Vec3 = Vec3::new(0.408_103_88, 0.867_197_8, 0.285_340_5);

/// What places are moved by to be off a surface that they may lie on: more than the rounding of places on it, in shares of the largest
/// coordinate, and at the origin \[scene unit\].
const CLEAR: f64 = 1.0 / (1 << 21) as f64;
const LEAST_CLEAR: f64 = 1e-9;

/// How far off a surface places are that may lie on it, as they are rounded \[scene unit\].
pub(crate) fn hair(point: Vec3) -> f64 {
    (CLEAR * point.as_dvec3().abs().max_element()).max(LEAST_CLEAR)
}

/// A place moved by a hair, all places the same way, off surfaces that pass through it.
pub(crate) fn cleared(point: Vec3) -> Vec3 {
    (point.as_dvec3() + hair(point) * PROBE.as_dvec3()).as_vec3()
}

/// Geometry of many meshes and instances. A scene of it has no other rules than a ray's side of the triangle that it meets: nothing need be
/// closed, nested or the right way round.
#[derive(Clone, Debug)]
pub struct Placed {
    surfaces: Surfaces,
    materials: Vec<Material>,
    objects: Vec<PlacedObject>,
    fogs: AddedFogs,
    /// Whether something lets light go straight on.
    shows_through: bool,
    /// Whether objects that have an inside may be of glass.
    has_glass: bool,
    /// Whether any object is filled.
    has_fog: bool,
    /// Whether nothing is told of any object that some rays or lamps do not heed.
    is_plain: bool,
}

/// A placed object.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PlacedObject {
    /// The volume of [`AddedFogs`] that it is filled with.
    pub fog: Option<u8>,
    /// Whether it has an inside. A pane of glass without thickness has none: fog behind it is not inside of glass.
    pub is_closed: bool,
    /// By which rays and lamps it is not heeded.
    pub heed: Heed,
}

impl PlacedObject {
    /// Of light on its way from a lamp, what a surface of it lets by.
    #[inline]
    pub(crate) fn lets_by(&self, links: &Links, material: &Material) -> Vec3 {
        if self.heed.is_in_way(links) { material.shadow() } else { Vec3::ONE }
    }
}

/// Why placed geometry was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PlacedError {
    /// A triangle or an instance with a number that has no material.
    #[error("a triangle has the material {0}, and there are {1}")]
    Material(u32, usize),
    /// An instance with a number that has no object.
    #[error("an instance has the object {0}, and there are {1}")]
    Object(u32, usize),
    /// An object that is filled with a volume that is not there.
    #[error("object {object} is filled with the volume {volume}, and there are {volumes}")]
    Volume {
        /// Which object.
        object: usize,
        /// The volume.
        volume: u8,
        /// How many there are.
        volumes: usize,
    },
}

impl Placed {
    /// - `materials`, `objects`: what the numbers of the instances and their triangles mean.
    ///
    /// # Errors
    /// A number that means nothing.
    pub fn new(
        instances: Arc<Instances>,
        materials: Vec<Material>,
        objects: Vec<PlacedObject>,
        fogs: AddedFogs,
    ) -> Result<Self, PlacedError> {
        Self::of(Surfaces::Built(instances), materials, objects, fogs)
    }

    /// The same on any surfaces.
    pub(crate) fn of(
        surfaces: Surfaces,
        materials: Vec<Material>,
        objects: Vec<PlacedObject>,
        fogs: AddedFogs,
    ) -> Result<Self, PlacedError> {
        if let Surfaces::Built(instances) = &surfaces
            && let Some([object, material]) = instances.largest_numbers()
        {
            if object as usize >= objects.len() {
                return Err(PlacedError::Object(object, objects.len()));
            }
            if material as usize >= materials.len() {
                return Err(PlacedError::Material(material, materials.len()));
            }
        }
        let volumes = fogs.volumes().len();
        for (object, filled) in objects.iter().enumerate() {
            if let Some(volume) = filled.fog.filter(|volume| usize::from(*volume) >= volumes) {
                return Err(PlacedError::Volume { object, volume, volumes });
            }
        }
        let is_seen_through =
            |material: &Material| material.transparent().max(material.shadow()) != Vec3::ZERO;
        let shows_through = materials.iter().any(is_seen_through)
            || objects.iter().any(|object| object.heed.hidden.has(Rays::ALL.without(Rays::LIGHT)));
        let has_glass = materials.iter().any(|material| material.has_inside())
            && objects.iter().any(|object| object.is_closed);
        let has_fog = objects.iter().any(|object| object.fog.is_some());
        let is_plain = objects.iter().all(|object| object.heed == Heed::default());
        Ok(Self { surfaces, materials, objects, fogs, shows_through, has_glass, has_fog, is_plain })
    }

    /// Where rays meet it.
    pub fn surfaces(&self) -> &Surfaces {
        &self.surfaces
    }

    /// By the number that hits bear.
    pub fn materials(&self) -> &[Material] {
        &self.materials
    }

    /// By the number that instances bear.
    pub fn objects(&self) -> &[PlacedObject] {
        &self.objects
    }

    /// What fills the objects.
    pub fn fogs(&self) -> &AddedFogs {
        &self.fogs
    }

    /// A box around all of it; None: there is nothing.
    pub fn bounds(&self) -> Option<(Vec3, Vec3)> {
        self.surfaces.bounds()
    }

    /// A box around all fog that fills objects.
    pub(crate) fn filled_bounds(&self) -> Option<(Vec3, Vec3)> {
        let filled = |object: &PlacedObject| object.fog.map(|fog| self.fogs.volumes()[usize::from(fog)]);
        self.objects.iter().filter_map(filled).map(|fog| (fog.min, fog.max)).reduce(unite)
    }

    /// Whether something lets light go straight on.
    pub(crate) fn shows_through(&self) -> bool {
        self.shows_through
    }

    /// Whether nothing is told of any object that some rays or lamps do not heed.
    pub(crate) fn is_plain(&self) -> bool {
        self.is_plain
    }

    /// Whether rays are inside of anything anywhere.
    pub(crate) fn has_insides(&self) -> bool {
        self.has_fog || self.has_glass
    }

    /// How many lists beams of a medium are kept in: those inside of glass apart.
    pub(crate) fn sides(&self) -> u32 {
        1 + u32::from(self.has_glass)
    }

    /// The volumes that an object is filled with.
    ///
    /// - `object`: counted among the placed ones.
    pub(crate) fn volumes_of(&self, object: u32) -> u64 {
        self.objects[object as usize].fog.map_or(0, |fog| self.fogs.set_of(fog))
    }

    /// What a place is inside of, or is just beside if it lies on a surface: a set of volumes, and whether it is in glass.
    pub(crate) fn insides_at(&self, point: Vec3) -> (u64, bool) {
        self.insides_off(cleared(point))
    }

    /// The same, of a place that lies on no surface.
    ///
    /// The first surface of each volume on a way out, and the first of glass, tells by its side.
    pub(crate) fn insides_off(&self, point: Vec3) -> (u64, bool) {
        let (mut inside, mut seen, mut glass) = (0, 0, None);
        if !self.has_insides() {
            return (inside, false);
        }
        let mut origin = point;
        for _ in 0..MOST_SURFACES {
            let Some(hit) = self.nearest(origin, PROBE, f32::INFINITY) else { break };
            let is_behind = hit.geometric_normal.dot(PROBE) > 0.0;
            let new = self.volumes_of(hit.object) & !seen;
            seen |= new;
            inside |= if is_behind { new } else { 0 };
            if glass.is_none()
                && self.material(&hit).has_inside()
                && self.objects[hit.object as usize].is_closed
            {
                glass = Some(is_behind);
            }
            origin = hit.leave(PROBE);
        }
        (inside, glass == Some(true))
    }

    /// What a place is inside of, from what another one is: along a straight line, through whatever is there.
    pub(crate) fn insides_moved(
        &self,
        (mut inside, mut glass): (u64, bool),
        from: Vec3,
        to: Vec3,
    ) -> (u64, bool) {
        if !self.has_insides() {
            return (inside, glass);
        }
        let mut origin = cleared(from);
        for _ in 0..MOST_SURFACES {
            let way = to - origin;
            let Some(direction) = way.try_normalize() else { break };
            let Some(hit) = self.nearest(origin, direction, way.length()) else { break };
            let is_front = hit.geometric_normal.dot(direction) < 0.0;
            let volumes = self.volumes_of(hit.object);
            inside = if is_front { inside | volumes } else { inside & !volumes };
            if self.material(&hit).has_inside() && self.objects[hit.object as usize].is_closed {
                glass = is_front;
            }
            origin = hit.leave(direction);
        }
        (inside, glass)
    }

    /// The nearest hit, whose `object` is counted among the placed ones.
    fn nearest(&self, origin: Vec3, direction: Vec3, max_distance: f32) -> Option<Hit> {
        let way = (origin.as_dvec3(), direction.as_dvec3());
        self.surfaces.nearest(way, max_distance.into(), Shading::Flat)
    }

    /// What was hit, as it is described.
    pub(crate) fn material(&self, hit: &Hit) -> &Material {
        &self.materials[hit.material as usize]
    }

    /// What was hit, as it is there.
    ///
    /// - `object`: counted among the placed ones.
    pub(crate) fn material_at(&self, hit: &Hit, object: u32) -> Cow<'_, Material> {
        match (self.material(hit), self.host()) {
            (Material::Lobes(lobes), Some(host)) if lobes.asks != Asks::Nothing => {
                Cow::Owned(host.material(&Hit { object, ..*hit }, lobes))
            }
            (material, _) => Cow::Borrowed(material),
        }
    }

    /// Whose geometry it is; None: it was built here.
    pub(crate) fn host(&self) -> Option<&Host> {
        self.surfaces.host()
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::medium::fogs::FogVolume;
    use covbeam_geometry::instance::Instance;
    use covbeam_geometry::model::Model;
    use covbeam_geometry::triangles::{Frame, Triangles};
    use glam::{DMat4, DVec3};

    /// Cubes, each by its middle and half of its width, that do nothing but bound fog: of the medium of their number, the smaller before the
    /// larger.
    pub(crate) fn fogs(cubes: &[(Vec3, f32)]) -> Placed {
        let (low, high) = (DVec3::NEG_ONE, DVec3::ONE);
        let corner = |i: usize| {
            let choose = |axis: usize| if i >> axis & 1 == 0 { low[axis] } else { high[axis] };
            DVec3::new(choose(0), choose(1), choose(2)).as_vec3()
        };
        // Counter-clockwise from outside.
        let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]);
        let corners: Vec<[Vec3; 3]> = triangles.map(|triangle| triangle.map(corner)).collect();
        let model = Model::new(Some(Triangles::new(Frame::around(low, high), &corners, &[])), vec![0]);
        let instance = |(&(center, half), object): (&(Vec3, f32), u32)| {
            let matrix =
                DMat4::from_translation(center.as_dvec3()) * DMat4::from_scale(DVec3::splat(half.into()));
            Instance::new(0, &matrix.transpose().to_cols_array(), (low, high), object, None).expect("affine")
        };
        let instances = cubes.iter().zip(0..).map(instance).collect();
        let volume = |(&(center, half), medium): (&(Vec3, f32), u32)| FogVolume {
            medium,
            min: center - half,
            max: center + half,
        };
        let volumes = AddedFogs::new(cubes.iter().zip(0..).map(volume).collect(), &[]).expect("few");
        let objects = (0..cubes.len() as u8).map(|fog| PlacedObject {
            fog: Some(fog),
            is_closed: true,
            ..PlacedObject::default()
        });
        let instances = Arc::new(Instances::new(vec![model], instances));
        Placed::new(instances, vec![Material::Clear], objects.collect(), volumes)
            .expect("numbers that mean something")
    }
}
