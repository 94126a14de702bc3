//! The photons on a pass' surfaces, and how wide their disks are.

use super::clearance::FLAT;
use super::crowd;
use super::photon::{SurfacePhoton, hierarchy};
use glam::Vec3;
use obvhs::bvh2::Bvh2;

/// How wide the kernels of a pass' surface photons are \[m\].
#[derive(Clone, Copy, Debug)]
pub struct Disks {
    /// For light that arrives diffusely.
    pub diffuse: f32,
    /// For caustics.
    pub caustic: f32,
    /// Some: these are the widest. Light that arrives diffusely is no smoother than other surfaces are far, and the disk of a caustic's photon
    /// ends where it holds so many, itself included, 2 to `CROWD` (L. Breiman, W. Meisel and E. Purcell 1977). Disks belong to photons,
    /// not to the places that look them up: so what leaves one place arrives at another, and no light is made where photons are dense.
    pub crowd: Option<usize>,
    /// Whether light that arrives diffusely is divided by the share of its disk that lies on the surface.
    pub within: bool,
}

/// The surface photons of a pass.
pub struct SurfaceMap {
    photons: Vec<SurfacePhoton>,
    /// Of their disks.
    pub(super) radii: Vec<f32>,
    hierarchy: Bvh2,
    pub(super) disks: Disks,
}

impl SurfaceMap {
    /// Of a pass' photons.
    pub fn build(photons: Vec<SurfacePhoton>, disks: Disks) -> Self {
        let widest = |photon: &SurfacePhoton| if photon.caustic { disks.caustic } else { disks.diffuse };
        let mut radii: Vec<f32> = photons.iter().map(widest).collect();
        if let Some(crowd) = disks.crowd {
            let of_caustics: Vec<&SurfacePhoton> = photons.iter().filter(|photon| photon.caustic).collect();
            let found = crowd::radii(&of_caustics, crowd, disks.caustic);
            let narrowed = photons.iter().zip(&mut radii).filter(|(photon, _)| photon.caustic);
            narrowed.zip(found).for_each(|((_, radius), found)| *radius = found);
        }
        let places = photons.iter().map(|photon| photon.position);
        let hierarchy = hierarchy(places.zip(radii.iter().copied()));
        Self { photons, radii, hierarchy, disks }
    }

    /// Without photons.
    pub fn empty() -> Self {
        Self::build(Vec::new(), Disks { diffuse: 0.0, caustic: 0.0, crowd: None, within: false })
    }

    /// To which radius other surfaces narrow disks of diffuse light, and from which; None: they and borders do not count, or there is no light.
    pub(crate) fn reach(&self) -> Option<[f32; 2]> {
        let Disks { diffuse, caustic, crowd, within } = self.disks;
        let least = if crowd.is_some() { caustic } else { diffuse };
        (within && !self.photons.is_empty()).then_some([least, diffuse])
    }

    /// Visits the photons whose disks may reach a point, where they lie on a surface with about this normal, with their radii.
    #[inline]
    pub(super) fn visit(&self, point: Vec3, normal: Vec3, mut visit: impl FnMut(&SurfacePhoton, f32)) {
        if self.photons.is_empty() {
            return;
        }
        self.hierarchy.point_traverse(point.into(), |hierarchy, node| {
            let leaf = &hierarchy.nodes[node as usize];
            let first = leaf.first_index as usize;
            for &index in &hierarchy.primitive_indices[first..first + leaf.prim_count as usize] {
                let photon = &self.photons[index as usize];
                if photon.normal.dot(normal) > FLAT {
                    visit(photon, self.radii[index as usize]);
                }
            }
            true
        });
    }
}
