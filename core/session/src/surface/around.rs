//! The photons around a place on a surface: how wide a disk holds enough of them, and the light that they bring.

use super::clearance::{Clearance, flat_within};
use super::map::SurfaceMap;
use super::photon::SurfacePhoton;
use crate::kind::{ByKind, Kind};
use covbeam::Curvature;
use glam::Vec3;
use std::f32::consts::PI;

/// Photons of light that arrives diffusely that a disk holds near other surfaces, in those of a caustic's disk. Of 0, 1 and 2 the error along a
/// shed's edges after 8 passes is 1, .64 and .46, that of boxes, stairs and a ball on a floor 1, .71 and .70; with 0 single pixels stand out.
const ENOUGH: usize = 2;

/// Photons of a disk whose ways are looked at, at most: of more, some stand for those beside them.
const MOST_LOOKS: usize = 64;

/// A photon whose disk reaches the place.
#[derive(Clone, Copy)]
struct Near {
    /// To it.
    way: Vec3,
    /// Of its disk.
    radius: f32,
    power: Vec3,
    caustic: bool,
    /// Whether the surface holds it; None: not looked at.
    held: Option<bool>,
}

impl Near {
    /// Asks once.
    fn is_held(&mut self, holds: impl Fn(Vec3) -> bool) -> bool {
        *self.held.get_or_insert_with(|| holds(self.way))
    }
}

/// The photons whose disks reach a place on a surface.
pub(crate) struct Around<'m> {
    map: &'m SurfaceMap,
    point: Vec3,
    normal: Vec3,
    /// In the order of the hierarchy; None: not asked for yet, and never where nothing else is near: most places are such.
    kept: Option<Vec<Near>>,
}

impl<'m> Around<'m> {
    /// At a point of a surface with this normal: photons count where theirs is about the same.
    pub(crate) fn new(map: &'m SurfaceMap, point: Vec3, normal: Vec3) -> Self {
        Self { map, point, normal, kept: None }
    }

    /// Visits the photons.
    #[inline]
    fn each(&self, mut visit: impl FnMut(Near)) {
        match &self.kept {
            Some(kept) => kept.iter().for_each(|near| visit(*near)),
            None => self.map.visit(self.point, self.normal, |photon, radius| {
                let way = photon.position - self.point;
                let SurfacePhoton { power, caustic, .. } = *photon;
                visit(Near { way, radius, power, caustic, held: None });
            }),
        }
    }

    /// Radius of the disk that ends at enough photons of light that arrives diffusely: that many but the last, evenly strewn, say without bias
    /// how dense they are, wherever that one is. Infinite: there are fewer.
    ///
    /// - `holds`: whether the surface does, by the way to the photon; as in [`Around::irradiance`], which asks for none a second time.
    pub(crate) fn enough(&mut self, holds: impl Fn(Vec3) -> bool) -> f32 {
        let Some(crowd) = self.map.disks.crowd else { return 0.0 };
        let mut all = Vec::new();
        self.each(|near| all.push(near));
        let photons = self.kept.insert(all).iter_mut();
        let mut diffuse: Vec<&mut Near> = photons
            .filter(|near| !near.caustic && near.way.length_squared() < near.radius * near.radius)
            .collect();
        diffuse
            .sort_unstable_by(|one, other| one.way.length_squared().total_cmp(&other.way.length_squared()));
        let mut held = 0;
        for (number, near) in diffuse.into_iter().enumerate() {
            held += usize::from(number < MOST_LOOKS && near.is_held(&holds));
            if held == ENOUGH * crowd || number == MOST_LOOKS {
                return near.way.length();
            }
        }
        f32::INFINITY
    }

    /// Irradiance \[W/m²\]: 2D Epanechnikov kernel over distances, no wider than the surface is flat. On a sphere that is as even as on a plane:
    /// the part of it within a distance d of a point has the area πd².
    ///
    /// - `clear`: of diffuse light there; `holds`: whether the surface holds a photon, by the way to it.
    pub(crate) fn irradiance(
        &self,
        curvature: &Curvature,
        clear: Clearance,
        holds: impl Fn(Vec3) -> bool,
    ) -> ByKind {
        let mut sum = ByKind::default();
        let widest = flat_within(curvature);
        let diffuse = widest.min(clear.radius);
        let mut beside = Vec::new();
        self.each(|near| {
            let (kind, widest) =
                if near.caustic { (Kind::Focused, widest) } else { (Kind::Scattered, diffuse) };
            let radius = near.radius.min(widest);
            let q2 = near.way.length_squared() / (radius * radius);
            if q2 < 1.0 {
                let arriving = near.power * (2.0 * (1.0 - q2) / (PI * radius * radius));
                if near.caustic || clear.share == 1.0 {
                    sum[kind as usize] += arriving;
                } else {
                    beside.push((near, arriving));
                }
            }
        });
        // Neighbours in the hierarchy are so in space.
        let together = beside.len().div_ceil(MOST_LOOKS).max(1);
        for some in beside.chunks_mut(together) {
            if some[some.len() / 2].0.is_held(&holds) {
                some.iter().for_each(|(_, arriving)| sum[Kind::Scattered as usize] += *arriving);
            }
        }
        sum[Kind::Scattered as usize] /= clear.share;
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;
    use crate::surface::{CROWD, Disks};
    use covbeam::Medium;

    /// A random unit vector.
    fn normal_of(random: &mut Random) -> Vec3 {
        // Isotropic.
        Medium::default().phase.sample(Vec3::Z, [random.uniform(), random.uniform()])
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
                let seen = Around::new(&map, ball * normal, normal);
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
                let around = Around::new(map, Vec3::X * (x as f32 / 100.0), Vec3::Y);
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
            let around = Around::new(&map, at, Vec3::Y);
            let seen = around.irradiance(&Curvature::default(), Clearance::of(f32::INFINITY), |_| true);
            sum += f64::from(seen[Kind::Focused as usize].x);
        }
        let sum = sum as f32 * (side / cells as f32).powi(2);
        // A disk of three cells' radius counts to 2 %, at random; there are 1,000 of them.
        assert!((sum / power - 1.0).abs() < 2e-3, "{sum} for {power}");
    }
}
