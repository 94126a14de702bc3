//! Geometry of placed objects: meshes that were built here, or that of a host which keeps its own.

use crate::host::Host;
use covbeam::Curvature;
use covbeam_geometry::hit::Hit;
use covbeam_geometry::instances::{InstanceHit, Instances};
use glam::{DVec3, Vec3};
use smallvec::SmallVec;
use std::sync::Arc;

/// Surfaces that one way is followed through at most.
pub(crate) const MOST_SURFACES: usize = 512;

/// Where rays meet placed objects.
#[derive(Clone, Debug)]
pub enum Surfaces {
    /// Instances of meshes.
    Built(Arc<Instances>),
    /// Whatever a host has.
    Host(Host),
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
            Self::Host(host) => host.bounds(),
        }
    }

    /// Whose they are; None: they were built here.
    pub(crate) fn host(&self) -> Option<&Host> {
        match self {
            Self::Built(_) => None,
            Self::Host(host) => Some(host),
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
            Self::Host(host) => host.is_blocked(origin, direction, reach),
        }
    }

    /// All hits with distance in (0, `reach`), from near to far. None: `ends` says of one, by the numbers of its material and
    /// its object, that it ends the way.
    pub(crate) fn all_unless(
        &self,
        (origin, direction): (DVec3, DVec3),
        reach: f64,
        shading: Shading,
        ends: impl Fn(u32, u32) -> bool,
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
                    if ends(hit.material, hit.object) {
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
