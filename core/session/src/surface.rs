//! Photons on diffuse surfaces and the radiance that they make visible. Light straight from a lamp is looked
//! up by shadow rays; lamps themselves are invisible.

mod around;
pub(crate) mod clearance;
mod crowd;
pub(crate) mod encounter;
pub(crate) mod origin;
mod photon;

pub(crate) use crowd::CROWD;
pub use photon::SurfacePhoton;

use crate::surface::clearance::FLAT;
use around::Around;
use covbeam::Curvature;
use glam::Vec3;
use obvhs::bvh2::Bvh2;
use photon::hierarchy;

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
    radii: Vec<f32>,
    hierarchy: Bvh2,
    disks: Disks,
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

    /// The photons whose disks reach a point of a surface with about this normal.
    pub(crate) fn around(&self, point: Vec3, normal: Vec3) -> Around<'_> {
        Around::new(self, point, normal)
    }

    /// Visits the photons whose disks may reach a point, where they lie on a surface with about this normal, with their radii.
    #[inline]
    fn visit(&self, point: Vec3, normal: Vec3, mut visit: impl FnMut(&SurfacePhoton, f32)) {
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

/// How far a surface is [`FLAT`] around a place \[m\].
pub(crate) fn flat_within(curvature: &Curvature) -> f32 {
    // cos θ = 1 - d²/2 of points of a unit sphere at a distance of d.
    (2.0 * (1.0 - FLAT)).sqrt() / strongest(curvature)
}

/// The larger of the two principal curvatures, in size.
fn strongest(curvature: &Curvature) -> f32 {
    let Curvature { along, across, twist, .. } = *curvature;
    (0.5 * (along + across)).abs() + libm::hypotf(0.5 * (along - across), twist)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kind::Kind;
    use crate::random::Random;
    use crate::surface::clearance::Clearance;
    use covbeam::Medium;
    use std::f32::consts::PI;

    /// A random unit vector.
    fn normal_of(random: &mut Random) -> Vec3 {
        // Isotropic.
        Medium::default().phase.sample(Vec3::Z, [random.uniform(), random.uniform()])
    }

    #[test]
    fn the_strongest_curvature_is_that_of_the_principal_axes() {
        // A cylinder of radius ½ with axes turned by φ: 2 cos²φ, 2 sin²φ, 2 sinφ cosφ; and a saddle.
        let (sin, cos) = 0.7_f32.sin_cos();
        let tensor = |along, across, twist| Curvature { along, across, twist, ..Curvature::default() };
        let cylinder = tensor(2.0 * cos * cos, 2.0 * sin * sin, 2.0 * sin * cos);
        assert!((strongest(&cylinder) - 2.0).abs() < 1e-6);
        assert_eq!(strongest(&tensor(-3.0, 1.0, 0.0)), 3.0);
        assert_eq!(strongest(&Curvature::default()), 0.0);
    }

    /// A ball lit evenly from all sides by a watt: 1/(4πρ²) everywhere, however wide the kernel.
    #[test]
    fn light_on_a_small_ball_is_all_there() {
        const PHOTONS: u32 = 40_000;
        let ball = 0.1;
        let photons = (0..PHOTONS).map(|index| {
            let mut random = Random::new([index, 0, 0, 0]);
            let normal = normal_of(&mut random);
            let power = Vec3::splat(1.0 / PHOTONS as f32);
            SurfacePhoton { position: ball * normal, normal, power, caustic: false }
        });
        let photons: Vec<SurfacePhoton> = photons.collect();
        let curvature = Curvature { along: 1.0 / ball, across: 1.0 / ball, ..Curvature::default() };
        for radius in [0.03, 0.05, 0.2] {
            let map = SurfaceMap::build(
                photons.clone(),
                Disks { diffuse: radius, caustic: radius, crowd: None, within: false },
            );
            let mut sum = 0.0;
            for index in 0..64 {
                let mut random = Random::new([index, 1, 0, 0]);
                let normal = normal_of(&mut random);
                let seen = map.around(ball * normal, normal);
                let seen = seen.irradiance(&curvature, Clearance::of(radius), |_| true);
                sum += seen[Kind::Scattered as usize].x / 64.0;
            }
            let expected = 1.0 / (4.0 * PI * ball * ball);
            // Each of 64 disks has 900 photons or more.
            assert!((sum / expected - 1.0).abs() < 0.02, "{sum} for {expected} with a radius of {radius}");
        }
    }

    /// As a caustic: a thousandth of the floor holds half of the light.
    #[test]
    fn disks_that_follow_the_photons_lose_and_make_no_light() {
        const PHOTONS: u32 = 2000;
        let photon = |index| {
            let mut random = Random::new([index, 2, 0, 0]);
            let [x, z] = [random.uniform() - 0.5, random.uniform() - 0.5];
            let scale = if index % 2 == 0 { Vec3::new(1.0, 0.0, 0.001) } else { Vec3::ONE };
            let position = scale * Vec3::new(x, 0.0, z);
            let power = Vec3::splat(random.uniform());
            SurfacePhoton { position, normal: Vec3::Y, power, caustic: true }
        };
        let photons: Vec<SurfacePhoton> = (0..PHOTONS).map(photon).collect();
        let power: f32 = photons.iter().map(|photon| photon.power.x).sum();
        let widest = 0.1;
        let disks = Disks { diffuse: widest, caustic: widest, crowd: Some(CROWD), within: false };
        let even = SurfaceMap::build(photons.clone(), Disks { crowd: None, ..disks });
        let map = SurfaceMap::build(photons, disks);
        let on_line = |map: &SurfaceMap| -> f32 {
            let seen = |x: i32| {
                let around = map.around(Vec3::X * (x as f32 / 100.0), Vec3::Y);
                around.irradiance(&Curvature::default(), Clearance::of(0.0), |_| true)
            };
            (-40..40).map(|x| seen(x)[Kind::Focused as usize].x).sum()
        };
        // A disk's profile across a line is 4/(πr): 250 W along 1 m, narrowest and widest, and 250 W/m² that are everywhere.
        let expected = (250.0 * 4.0 / (PI * 0.1 * widest) + 250.0) / (250.0 * 4.0 / (PI * widest) + 250.0);
        let ratio = on_line(&map) / on_line(&even);
        assert!((ratio / expected - 1.0).abs() < 0.1, "{ratio} for {expected}");
        let narrowed = map.radii.iter().filter(|radius| **radius < 0.5 * widest).count();
        assert!(narrowed > PHOTONS as usize / 3, "{narrowed} of {PHOTONS} disks are narrower");
        // Cells of a third of the narrowest disk, over all that any disk reaches.
        let cells = 400;
        let side = 1.0 + 2.0 * widest;
        let place = |cell: i32| side * ((cell as f32 + 0.5) / cells as f32 - 0.5);
        let mut sum = 0.0;
        for (row, column) in (0..cells).flat_map(|row| (0..cells).map(move |column| (row, column))) {
            let at = Vec3::new(place(row), 0.0, place(column));
            let around = map.around(at, Vec3::Y);
            let seen = around.irradiance(&Curvature::default(), Clearance::of(f32::INFINITY), |_| true);
            sum += f64::from(seen[Kind::Focused as usize].x);
        }
        let sum = sum as f32 * (side / cells as f32).powi(2);
        // A disk of three cells' radius counts to 2 %, at random; there are 1,000 of them.
        assert!((sum / power - 1.0).abs() < 2e-3, "{sum} for {power}");
    }
}
