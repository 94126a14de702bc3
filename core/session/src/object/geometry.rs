//! Geometry of placed objects: meshes that were built here, or that of a host which keeps its own.

use covbeam::Curvature;
use covbeam_geometry::hit::Hit;
use covbeam_geometry::instances::{InstanceHit, Instances};
use glam::{DVec3, Vec3};
use smallvec::SmallVec;
use std::fmt;
use std::sync::Arc;

/// How far the squared length of a unit normal may be from 1.
const UNIT: f32 = 1e-3;

/// Surfaces that one way is followed through at most.
pub(crate) const MOST_SURFACES: usize = 512;

/// Where rays meet the surfaces of a host that keeps its own geometry. Asked from many threads at once; the same question must get the same
/// answer, or pictures depend on luck. What it says is checked: a hit that is out of reach or has numbers that mean nothing is none, and a
/// way that meets more than 512 surfaces ends there, so that no answer makes a NaN or a pass without end.
pub trait HostGeometry: fmt::Debug + Send + Sync {
    /// Lower and upper corner of a box around all of it \[scene unit\].
    fn bounds(&self) -> (Vec3, Vec3);

    /// The nearest surface at a distance in (0, `reach`), from either side; `direction` is unit. Objects of glass and such that fog fills must
    /// be met each time that their inside is entered and left.
    ///
    /// Of the hit: [`Hit::object`] and [`Hit::material`] are numbers of what the scene has of them, counted from 0; [`Hit::offset`] is more than
    /// rounding can have moved `position`: some 4 ulps of the largest coordinate; curvature 0 makes light fields see the surface as flat.
    fn cast(&self, origin: DVec3, direction: DVec3, reach: f64) -> Option<Hit>;

    /// Whether anything is met at a distance in (0, `reach`); None: see what [`HostGeometry::cast`] finds.
    fn is_blocked(&self, _origin: DVec3, _direction: DVec3, _reach: f64) -> Option<bool> {
        None
    }
}

/// Where rays meet placed objects.
#[derive(Clone, Debug)]
pub enum Surfaces {
    /// Instances of meshes.
    Built(Arc<Instances>),
    /// Whatever a host has.
    Host(Host),
}

/// Geometry of a host, and the numbers that its hits may bear.
#[derive(Clone, Debug)]
pub struct Host {
    geometry: Arc<dyn HostGeometry>,
    /// Below this.
    objects: usize,
    /// And below this.
    materials: usize,
}

/// How hits on meshes are described.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Shading {
    /// With the normals and curvatures that light sees.
    Smooth,
    /// As if shaded flat: cheaper.
    Flat,
}

/// Hits along a way, with their distances.
pub(crate) type Met = SmallVec<[(f64, Hit); 4]>;

impl Surfaces {
    /// A box around all of it; None: there is nothing, or a host's is no box.
    pub(crate) fn bounds(&self) -> Option<(Vec3, Vec3)> {
        match self {
            Self::Built(instances) => (!instances.is_empty()).then(|| instances.bounds()),
            Self::Host(host) => {
                let (min, max) = host.geometry.bounds();
                (min.is_finite() && max.is_finite() && min.cmple(max).all()).then_some((min, max))
            }
        }
    }

    /// The nearest hit with distance in (0, `reach`); `direction` is unit.
    #[inline]
    pub(crate) fn nearest(
        &self,
        (origin, direction): (DVec3, DVec3),
        reach: f64,
        shading: Shading,
    ) -> Option<Hit> {
        match self {
            Self::Built(instances) => {
                let hit = instances.intersect(origin, direction, reach)?;
                Some(described(instances, &hit, shading))
            }
            Self::Host(host) => {
                let hit = host.cast(origin, direction, reach)?;
                Some(if shading == Shading::Flat { flat(hit) } else { hit })
            }
        }
    }

    /// Whether anything is hit with distance in (0, `reach`).
    #[inline]
    pub(crate) fn is_blocked(&self, (origin, direction): (DVec3, DVec3), reach: f64) -> bool {
        match self {
            Self::Built(instances) => instances.occluded(origin, direction, reach),
            Self::Host(host) => {
                let blocked = host.geometry.is_blocked(origin, direction, reach);
                blocked.unwrap_or_else(|| host.cast(origin, direction, reach).is_some())
            }
        }
    }

    /// All hits with distance in (0, `reach`), from near to far. None: `ends` says of the material of one, by its number, that it ends the way.
    pub(crate) fn all_unless(
        &self,
        (origin, direction): (DVec3, DVec3),
        reach: f64,
        shading: Shading,
        ends: impl Fn(u32) -> bool,
    ) -> Option<Met> {
        let mut met = Met::new();
        match self {
            Self::Built(instances) => {
                let found = instances.all_unless(origin, direction, reach, ends)?;
                met.extend(found.iter().map(|hit| (hit.distance(), described(instances, hit, shading))));
            }
            Self::Host(_) => {
                let mut passed = 0.0;
                for _ in 0..MOST_SURFACES {
                    let from = origin + passed * direction;
                    let Some(hit) = self.nearest((from, direction), reach - passed, shading) else {
                        return Some(met);
                    };
                    if ends(hit.material) {
                        return None;
                    }
                    let distance = passed + f64::from(hit.distance);
                    met.push((distance, Hit { distance: distance as f32, ..hit }));
                    // Behind the surface, by more than rounding can have moved it.
                    let cosine = hit.geometric_normal.as_dvec3().dot(direction).abs().max(1e-3);
                    passed = distance + f64::from(hit.offset) / cosine;
                }
                return None;
            }
        }
        Some(met)
    }
}

fn described(instances: &Instances, hit: &InstanceHit, shading: Shading) -> Hit {
    match shading {
        Shading::Smooth => instances.describe(hit),
        Shading::Flat => instances.describe_flat(hit),
    }
}

/// A hit as if the surface were shaded flat.
fn flat(hit: Hit) -> Hit {
    let tangent = hit.geometric_normal.any_orthonormal_vector();
    let curvature = Curvature { tangent, along: 0.0, across: 0.0, twist: 0.0 };
    Hit { normal: hit.geometric_normal, curvature, ..hit }
}

impl Host {
    /// - `objects`, `materials`: how many numbers of each hits may bear.
    pub(crate) fn new(geometry: Arc<dyn HostGeometry>, objects: usize, materials: usize) -> Self {
        Self { geometry, objects, materials }
    }

    /// What the host finds, if it can be a hit.
    fn cast(&self, origin: DVec3, direction: DVec3, reach: f64) -> Option<Hit> {
        let hit = self.geometry.cast(origin, direction, reach)?;
        let is_unit = |normal: Vec3| (normal.length_squared() - 1.0).abs() <= UNIT;
        let curvature = hit.curvature;
        let numbers =
            [curvature.along, curvature.across, curvature.twist, curvature.tangent.length_squared()];
        let is_sound = hit.distance > 0.0
            && f64::from(hit.distance) < reach
            && hit.distance.is_finite()
            && hit.position.is_finite()
            && is_unit(hit.geometric_normal)
            && is_unit(hit.normal)
            && hit.normal.dot(hit.geometric_normal) >= 0.0
            && numbers.iter().all(|number| number.is_finite())
            && hit.offset >= 0.0
            && hit.offset.is_finite()
            && (hit.object as usize) < self.objects
            && (hit.material as usize) < self.materials;
        let least = f32::EPSILON * origin.abs().max_element() as f32;
        // One that does not move off the surface would be met again and again.
        let offset = if hit.offset > 0.0 { hit.offset } else { least.max(f32::MIN_POSITIVE) };
        is_sound.then_some(Hit { offset, ..hit })
    }
}
