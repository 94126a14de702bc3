//! Instances under a hierarchy of their own: what a ray hits, and the edges beside it.

use crate::failure::{Result, invalid};
use crate::instance::Instance;
use crate::mesh::Mesh;
use crate::records::HitRecord;
use crate::wide::Wide;
use covbeam::{Edge, MOST_EDGES, ProbeHit, find_edges};
use covbeam_geometry::triangles::{Frame, Hierarchy, PADDING, TriangleHit, Triangles};
use glam::{DVec3, Vec3, Vec3A};
use obvhs::aabb::Aabb;
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Rays that a thread takes at a time.
const CHUNK: usize = 1024;

/// How far the squared length of a unit direction may be from 1.
const UNIT: f32 = 1e-4;

/// A ray that has passed this many surfaces which let light through is taken to meet nothing.
const MOST_THROUGH: usize = 64;

/// Meshes and instances that can be hit.
pub struct Scene {
    meshes: Vec<Mesh>,
    /// Those with triangles, in the order of the hierarchy's leaves.
    instances: Vec<Instance>,
    hierarchy: Wide,
    /// None without instances.
    frame: Option<Frame>,
    bounds: (Vec3, Vec3),
}

impl Scene {
    /// Builds the hierarchy over the instances.
    pub fn new(meshes: Vec<Mesh>, mut instances: Vec<Instance>) -> Self {
        instances.retain(|instance| meshes[instance.mesh].triangles.is_some());
        let min = instances.iter().map(|instance| instance.bounds.0).fold(DVec3::INFINITY, DVec3::min);
        let max = instances.iter().map(|instance| instance.bounds.1).fold(DVec3::NEG_INFINITY, DVec3::max);
        let bounds = (min.as_vec3(), max.as_vec3());
        if instances.is_empty() {
            let bounds = (Vec3::ZERO, Vec3::ZERO);
            return Self { meshes, instances, hierarchy: Wide::default(), frame: None, bounds };
        }
        let frame = Frame::around(min, max);
        let padded = |instance: &Instance| {
            let [min, max] = [instance.bounds.0, instance.bounds.1].map(|p| Vec3A::from(frame.local(p)));
            Aabb::new(min - PADDING, max + PADDING)
        };
        let hierarchy = Wide::over(&instances.iter().map(padded).collect::<Vec<_>>());
        let in_order = hierarchy.order().iter().map(|&i| instances[i as usize].clone()).collect();
        Self { meshes, instances: in_order, hierarchy, frame: Some(frame), bounds }
    }

    /// Triangles of all meshes, each counted once however many instances it has.
    pub fn triangle_count(&self) -> usize {
        self.meshes.iter().filter_map(|mesh| mesh.triangles.as_ref()).map(Triangles::count).sum()
    }

    /// Memory held \[bytes\].
    pub fn memory(&self) -> usize {
        self.meshes.iter().map(Mesh::memory).sum::<usize>()
            + size_of_val(&self.instances[..])
            + self.hierarchy.memory()
    }

    /// A box around the transformed boxes of all instances' meshes; zero without triangles.
    pub fn bounds(&self) -> (Vec3, Vec3) {
        self.bounds
    }

    fn triangles(&self, instance: &Instance) -> &Triangles<Wide> {
        self.meshes[instance.mesh].triangles.as_ref().expect("instances without triangles are left out")
    }

    fn intersect(
        &self,
        origin: Vec3,
        direction: Vec3,
        max_distance: f32,
    ) -> Option<(&Instance, TriangleHit)> {
        let (origin, direction) = (origin.as_dvec3(), direction.as_dvec3());
        let mut nearest = f64::from(max_distance);
        let frame = self.frame.as_ref()?;
        let (ray, skipped) = frame.ray(origin, direction, nearest)?;
        let mut found = None;
        self.hierarchy.nearest(ray, |_, index| {
            let instance = &self.instances[index];
            match instance.intersect(self.triangles(instance), origin, direction, nearest) {
                Some(hit) if hit.distance < nearest => {
                    nearest = hit.distance;
                    found = Some((instance, hit));
                    ((nearest - skipped) / frame.scale()) as f32
                }
                _ => f32::INFINITY,
            }
        });
        found
    }

    /// The nearest hit with distance in (0, max_distance); `direction` is unit.
    pub fn cast(&self, origin: Vec3, direction: Vec3, max_distance: f32) -> HitRecord {
        self.intersect(origin, direction, max_distance).map_or(HitRecord::MISS, |(instance, hit)| {
            let triangles = self.triangles(instance);
            let material = instance.material(&self.meshes[instance.mesh], triangles.index(&hit));
            HitRecord::new(&instance.describe(triangles, &hit), instance.object, material)
        })
    }

    /// Casts many rays on the threads of the pool that this runs in. `lengths`: one a ray, or one for all.
    pub fn cast_many(
        &self,
        origins: &[[f32; 3]],
        directions: &[[f32; 3]],
        lengths: &[f32],
        hits: &mut [HitRecord],
    ) -> Result<()> {
        let length = |index: usize| if lengths.len() == 1 { lengths[0] } else { lengths[index] };
        let wrong = First::default();
        hits.par_chunks_mut(CHUNK).enumerate().for_each(|(chunk, hits)| {
            for (hit, index) in hits.iter_mut().zip(chunk * CHUNK..) {
                let (origin, direction) = (origins[index].into(), directions[index].into());
                if !is_ray(origin, direction) || !(length(index) >= 0.0) {
                    return wrong.note(index);
                }
                *hit = self.cast(origin, direction, length(index));
            }
        });
        let Some(index) = wrong.index() else { return Ok(()) };
        if !(length(index) >= 0.0) {
            return Err(invalid!(
                "lengths[{index}]: {}; give a number >= 0, inf for no limit",
                length(index)
            ));
        }
        Err(not_a_ray(index, origins[index], directions[index]))
    }

    /// Searches the edges beside many rays, whose hits are known, on the threads of the pool that this runs in. Materials whose
    /// byte in `through` is not 0 cast no shadow: what is behind them counts.
    pub fn edges_many(
        &self,
        origins: &[[f32; 3]],
        directions: &[[f32; 3]],
        hits: &[HitRecord],
        through: &[u8],
        counts: &mut [u8],
        edges: &mut [[Edge; MOST_EDGES]],
    ) -> Result<()> {
        /// Rays that a thread takes at a time: each shoots up to 128 others.
        const FEW: usize = 32;
        let wrong = First::default();
        counts.par_chunks_mut(FEW).zip(edges.par_chunks_mut(FEW)).enumerate().for_each(
            |(chunk, (counts, edges))| {
                for ((count, edges), index) in counts.iter_mut().zip(edges).zip(chunk * FEW..) {
                    let (origin, direction) = (origins[index].into(), directions[index].into());
                    if !is_ray(origin, direction) {
                        return wrong.note(index);
                    }
                    let opaque = Opaque { scene: self, through };
                    let passes = opaque.lets_through(hits[index].material);
                    let hit =
                        if passes { opaque.nearest(origin, direction) } else { hits[index].probe_hit() };
                    let found = find_edges(direction, hit, |towards| opaque.nearest(origin, towards));
                    *count = found.len() as u8;
                    *edges = Default::default();
                    edges[..found.len()].copy_from_slice(&found);
                }
            },
        );
        wrong.index().map_or(Ok(()), |index| Err(not_a_ray(index, origins[index], directions[index])))
    }
}

/// What casts shadows.
struct Opaque<'a> {
    scene: &'a Scene,
    through: &'a [u8],
}

impl Opaque<'_> {
    fn lets_through(&self, material: i32) -> bool {
        usize::try_from(material)
            .ok()
            .and_then(|index| self.through.get(index))
            .is_some_and(|&byte| byte != 0)
    }

    fn nearest(&self, origin: Vec3, direction: Vec3) -> Option<ProbeHit> {
        let mut start = origin;
        for _ in 0..MOST_THROUGH {
            let (instance, hit) = self.scene.intersect(start, direction, f32::INFINITY)?;
            let triangles = self.scene.triangles(instance);
            let mut found = instance.describe_flat(triangles, &hit);
            if start != origin {
                found.distance = (found.position - origin).dot(direction);
            }
            let material = instance.material(&self.scene.meshes[instance.mesh], triangles.index(&hit));
            if !self.lets_through(material) {
                return Some((&found).into());
            }
            start = found.leave(direction);
        }
        None
    }
}

fn is_ray(origin: Vec3, direction: Vec3) -> bool {
    origin.is_finite() && (direction.length_squared() - 1.0).abs() <= UNIT
}

fn not_a_ray(index: usize, origin: [f32; 3], direction: [f32; 3]) -> crate::failure::Failure {
    if Vec3::from_array(origin).is_finite() {
        return invalid!("directions[{index}]: {direction:?}; give vectors of length 1");
    }
    invalid!("origins[{index}]: {origin:?}; give finite points")
}

/// The first of the elements that threads found wrong.
struct First(AtomicUsize);

impl Default for First {
    fn default() -> Self {
        Self(AtomicUsize::new(usize::MAX))
    }
}

impl First {
    fn note(&self, index: usize) {
        self.0.fetch_min(index, Ordering::Relaxed);
    }

    fn index(self) -> Option<usize> {
        Some(self.0.into_inner()).filter(|&index| index < usize::MAX)
    }
}
