//! Instances under a hierarchy of their own, and what a ray hits of them.

use crate::hit::Hit;
use crate::instance::Instance;
use crate::model::Model;
use crate::triangles::{Frame, PADDING, TriangleHit, Triangles};
use crate::wide::Wide;
use glam::{DVec3, Vec3, Vec3A};
use obvhs::aabb::Aabb;
use smallvec::SmallVec;

/// Models placed by transforms.
pub struct Instances {
    models: Vec<Model>,
    /// Those with triangles, in the order of the hierarchy's leaves: one each.
    instances: Vec<Instance>,
    hierarchy: Wide,
    /// None without instances.
    frame: Option<Frame>,
    bounds: (Vec3, Vec3),
}

/// Where a ray meets an instance.
#[derive(Clone, Copy, Debug)]
pub struct InstanceHit {
    /// In the order of the leaves.
    instance: u32,
    triangle: TriangleHit,
}

impl InstanceHit {
    /// Along the ray, > 0.
    pub fn distance(&self) -> f64 {
        self.triangle.distance
    }
}

impl std::fmt::Debug for Instances {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (count, (min, max)) = (self.instances.len(), self.bounds);
        write!(f, "Instances {{ {count} of {} models, {min}..{max} }}", self.models.len())
    }
}

impl Default for Instances {
    /// None.
    fn default() -> Self {
        Self::new(Vec::new(), Vec::new())
    }
}

impl Instances {
    /// Builds the hierarchy over the instances.
    pub fn new(models: Vec<Model>, mut instances: Vec<Instance>) -> Self {
        instances.retain(|instance| models[instance.model].triangles().is_some());
        let min = instances.iter().map(|instance| instance.bounds.0).fold(DVec3::INFINITY, DVec3::min);
        let max = instances.iter().map(|instance| instance.bounds.1).fold(DVec3::NEG_INFINITY, DVec3::max);
        let bounds = (min.as_vec3(), max.as_vec3());
        if instances.is_empty() {
            let bounds = (Vec3::ZERO, Vec3::ZERO);
            return Self { models, instances, hierarchy: Wide::default(), frame: None, bounds };
        }
        let frame = Frame::around(min, max);
        let padded = |instance: &Instance| {
            let [min, max] = [instance.bounds.0, instance.bounds.1].map(|p| Vec3A::from(frame.local(p)));
            Aabb::new(min - PADDING, max + PADDING)
        };
        let (hierarchy, leaves) = Wide::over(&instances.iter().map(padded).collect::<Vec<_>>());
        let in_order = leaves.iter().map(|&[number]| instances[number as usize].clone()).collect();
        Self { models, instances: in_order, hierarchy, frame: Some(frame), bounds }
    }

    /// Triangles of all models, each counted once however many instances it has.
    pub fn triangle_count(&self) -> usize {
        self.models.iter().filter_map(Model::triangles).map(Triangles::count).sum()
    }

    /// Whether there is nothing to hit.
    pub fn is_empty(&self) -> bool {
        self.instances.is_empty()
    }

    /// Memory held \[bytes\].
    pub fn memory(&self) -> usize {
        self.models.iter().map(Model::memory).sum::<usize>()
            + size_of_val(&self.instances[..])
            + self.hierarchy.memory()
    }

    /// The largest numbers of objects and materials that hits may bear; None: there is nothing to hit.
    pub fn largest_numbers(&self) -> Option<[u32; 2]> {
        let numbers = |instance: &Instance| {
            let own = instance.material;
            [instance.object, own.unwrap_or_else(|| self.models[instance.model].largest_material())]
        };
        self.instances.iter().map(numbers).reduce(|a, b| [a[0].max(b[0]), a[1].max(b[1])])
    }

    /// A box around the transformed boxes of all instances' models; zero without triangles.
    pub fn bounds(&self) -> (Vec3, Vec3) {
        self.bounds
    }

    fn triangles(&self, instance: &Instance) -> &Triangles {
        self.models[instance.model].triangles().expect("instances without triangles are left out")
    }

    /// Nearest hit with distance in (0, max_distance); `direction` is unit.
    pub fn intersect(&self, origin: DVec3, direction: DVec3, max_distance: f64) -> Option<InstanceHit> {
        let mut nearest = max_distance;
        let frame = self.frame.as_ref()?;
        let (ray, skipped) = frame.ray(origin, direction, nearest)?;
        let mut found = None;
        self.hierarchy.nearest(&ray, |end, index| {
            let instance = &self.instances[index];
            match instance.intersect(self.triangles(instance), origin, direction, nearest) {
                Some(triangle) if triangle.distance < nearest => {
                    nearest = triangle.distance;
                    found = Some(InstanceHit { instance: index as u32, triangle });
                    end.min(((nearest - skipped) / frame.scale()) as f32)
                }
                _ => end,
            }
        });
        found
    }

    /// True if anything is hit with distance in (0, max_distance); `direction` is unit.
    pub fn occluded(&self, origin: DVec3, direction: DVec3, max_distance: f64) -> bool {
        let Some(frame) = &self.frame else { return false };
        let Some((ray, _)) = frame.ray(origin, direction, max_distance) else { return false };
        self.hierarchy.any(&ray, |index| {
            let instance = &self.instances[index];
            instance.occluded(self.triangles(instance), origin, direction, max_distance)
        })
    }

    /// All hits with distance in (0, max_distance), from near to far; `direction` is unit. None: `ends` says of one, by the numbers of its
    /// material and its object, that it ends the ray. A ray through an edge hits both triangles, and one through a corner all.
    pub fn all_unless(
        &self,
        origin: DVec3,
        direction: DVec3,
        max_distance: f64,
        ends: impl Fn(u32, u32) -> bool,
    ) -> Option<SmallVec<[InstanceHit; 8]>> {
        let mut found = SmallVec::new();
        let Some(frame) = &self.frame else { return Some(found) };
        let Some((ray, _)) = frame.ray(origin, direction, max_distance) else { return Some(found) };
        let is_ended = self.hierarchy.any(&ray, |index| {
            let instance = &self.instances[index];
            instance.any(self.triangles(instance), origin, direction, max_distance, |triangle| {
                let hit = InstanceHit { instance: index as u32, triangle };
                let is_end = ends(self.material(&hit), instance.object);
                if !is_end {
                    found.push(hit);
                }
                is_end
            })
        });
        found.sort_by(|a, b| a.distance().total_cmp(&b.distance()));
        (!is_ended).then_some(found)
    }

    /// Everything about a hit.
    pub fn describe(&self, hit: &InstanceHit) -> Hit {
        let instance = &self.instances[hit.instance as usize];
        let described = instance.describe(self.triangles(instance), &hit.triangle);
        Hit { material: self.material(hit), ..described }
    }

    /// The same as on a surface that is shaded flat: cheaper.
    pub fn describe_flat(&self, hit: &InstanceHit) -> Hit {
        let instance = &self.instances[hit.instance as usize];
        let described = instance.describe_flat(self.triangles(instance), &hit.triangle);
        Hit { material: self.material(hit), ..described }
    }

    /// The number of the material that was hit.
    pub fn material(&self, hit: &InstanceHit) -> u32 {
        let instance = &self.instances[hit.instance as usize];
        let of_triangle =
            || self.models[instance.model].material(self.triangles(instance).index(&hit.triangle));
        instance.material.unwrap_or_else(of_triangle)
    }
}
