//! How smooth diffuse light on a surface may be, by what is around the place.

use crate::light::cosine_direction;
use crate::random::Random;
use crate::scene::Scene;
use crate::scene::optics::facing_normal;
use covbeam::Curvature;
use covbeam_geometry::hit::Hit;
use glam::Vec3;
use std::f32::consts::TAU;

/// Photons count where the normal differs by less than this cosine: others lie on another surface.
pub(crate) const FLAT: f32 = 0.9;

/// Rays that look for other surfaces.
const CONTACT_RAYS: u32 = 2;

/// Places around a disk that look for the border of the surface, and where, as a share of its radius.
const RING: u32 = 4;
const RING_AT: f32 = 0.8;

/// Places in it that say how much of it lies on the surface, and whether that is enough.
const PLACES: u32 = 16;
const FEW_PLACES: u32 = 8;

/// With less of it on the surface a disk is halved, at most as often as this. (A corner has a quarter of any.)
const LEAST_SHARE: f32 = 0.25;
const NARROWINGS: u32 = 4;

/// Height over the next place, as a share of the step there.
const RISE: f32 = 0.25;

/// Sides of glass that are looked through.
const MOST_SIDES: u32 = 4;

/// Turns from one place to the next: evenly around.
const GOLDEN: f32 = 0.618_034;

/// The surface around a place.
#[derive(Clone, Copy)]
pub(crate) struct Ground<'s> {
    pub(crate) scene: &'s Scene,
    /// Beside the surface.
    pub(crate) start: Vec3,
    /// Of the surface, on that side, unit.
    pub(crate) normal: Vec3,
}

/// How far light that arrives diffusely may be spread around a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Clearance {
    /// Radius of the disk \[m\].
    pub(crate) radius: f32,
    /// Share of it that lies on the surface, weighted as its photons are: light from the rest is none, and not dark.
    pub(crate) share: f32,
}

impl Clearance {
    /// All of it on the surface.
    pub(crate) fn of(radius: f32) -> Self {
        Self { radius, share: 1.0 }
    }

    /// At most `reach`: no farther than other surfaces are along random rays, since light varies over no less than about that (G. Ward,
    /// F. Rubinstein and R. Clear 1988 bound the gradient of irradiance by the mean distance).
    ///
    /// - `reach`: least radius near other surfaces, and largest \[m\] > 0. Where the surface itself is narrow it is less.
    /// - `enough`: the radius that holds enough photons; asked for where other surfaces are near. Some width is a small error there, one photon
    ///   or none a large one.
    ///
    /// Cost: ten short rays, and at borders 48 more, or up to 144 on what is narrow.
    pub(crate) fn new(
        ground: &Ground,
        [least, most]: [f32; 2],
        random: &mut Random,
        enough: impl FnOnce() -> f32,
    ) -> Self {
        let Ground { scene, start, normal } = *ground;
        let (least, mut radius) = (least.min(most), most);
        // Plain disks are narrowed by nothing.
        let rays = if least < most { CONTACT_RAYS } else { 0 };
        for _ in 0..rays {
            let direction = cosine_direction(normal, [random.uniform(), random.uniform()]);
            if let Some(hit) = scene.intersect_solid(start, direction, radius) {
                radius = hit.distance.max(least);
            }
        }
        if radius < most {
            radius = enough().clamp(radius, most);
        }
        let (across, aside) = normal.any_orthonormal_pair();
        let is_on = |distance: f32, turned: f32| {
            let (sin, cos) = libm::sincosf(TAU * turned);
            ground.goes_on(distance * (cos * across + sin * aside))
        };
        let turn = random.uniform();
        if (0..RING).all(|number| is_on(RING_AT * radius, turn + number as f32 / RING as f32)) {
            return Self::of(radius);
        }
        let mut share = |radius: f32, places: u32| {
            let (turn, shift) = (random.uniform(), random.uniform());
            let on = (0..places).filter(|number| {
                // As many below each radius as weigh there: 2 q² - q⁴ of an Epanechnikov kernel.
                let below = (*number as f32 + shift) / places as f32;
                is_on(radius * (1.0 - (1.0 - below).sqrt()).sqrt(), turn + *number as f32 * GOLDEN)
            });
            on.count() as f32 / places as f32
        };
        let mut found = share(radius, FEW_PLACES);
        for _ in 0..NARROWINGS {
            if found >= LEAST_SHARE {
                break;
            }
            radius *= 0.5;
            found = share(radius, FEW_PLACES);
        }
        // Places that decided nothing: what is accepted for being large is too large. Light is divided by it, so little is looked at closely.
        let share = share(radius, if found < 0.5 { 2 * PLACES } else { PLACES });
        Self { radius, share: share.max(0.5 * LEAST_SHARE) }
    }
}

impl Ground<'_> {
    /// Whether the surface is also there a step further, with nothing in between.
    fn goes_on(&self, step: Vec3) -> bool {
        if step == Vec3::ZERO {
            return true;
        }
        let Some((over, height)) = self.over(step) else { return false };
        let below = nearest(self.scene, self.start + over, -self.normal, 2.0 * height);
        below.is_some_and(|hit| facing_normal(&hit, -self.normal).dot(self.normal) > FLAT)
    }

    /// Whether a photon, whose normal is about the same, lies on this surface, with nothing in between.
    ///
    /// - `way`: from the place to the photon.
    ///
    /// Cost: a short ray.
    pub(crate) fn holds(&self, way: Vec3) -> bool {
        let rise = way.dot(self.normal);
        self.over(way - rise * self.normal).is_some_and(|(_, height)| rise.abs() <= height)
    }

    /// The way to over the place a step further, and how high over; None: something is in between.
    fn over(&self, step: Vec3) -> Option<(Vec3, f32)> {
        // What is [`FLAT`] rises and falls by less.
        let height = RISE * step.length();
        let over = step + height * self.normal;
        let length = over.length();
        let is_free = length == 0.0 || nearest(self.scene, self.start, over / length, length).is_none();
        is_free.then_some((over, height))
    }
}

/// The nearest surface on a way but for glass, under which others have photons all the same.
fn nearest(scene: &Scene, mut start: Vec3, direction: Vec3, mut length: f32) -> Option<Hit> {
    for _ in 0..MOST_SIDES {
        let hit = scene.intersect_solid(start, direction, length)?;
        let material = *scene.material(&hit);
        if !material.has_inside() || material.diffuse() != Vec3::ZERO {
            return Some(hit);
        }
        (start, length) = (hit.leave(direction), length - hit.distance);
    }
    None
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
    use crate::scene::Material;
    use crate::scene::made::{Made, camera, cuboid, point, rectangle, sphere};
    use crate::surface::{Around, CROWD, Disks, SurfaceMap, SurfacePhoton};

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

    const REACH: f32 = 0.2;

    /// A floor of 2 x 2 m that a box hovers over a part of, and a board beside it, 6 cm wide.
    fn scene() -> Scene {
        let square = rectangle([-1.0, 0.0, -1.0], [0.0, 0.0, 2.0], [2.0, 0.0, 0.0]);
        let board = rectangle([4.0, 0.0, -1.0], [0.0, 0.0, 2.0], [0.06, 0.0, 0.0]);
        Made::new(camera([0.0, 3.0, 0.0], [0.0, 0.0, 0.1], 1.0, [1, 1]))
            .object(square, Material::Black)
            .object(cuboid([-0.9, 0.01, -0.9], [-0.3, 0.5, 0.9]), Material::Black)
            .object(board, Material::Black)
            .object(sphere([8.0, 0.0, 0.0], 0.1), Material::Black)
            .object(sphere([0.5, 0.1, 0.5], 0.09999), Material::Dielectric { index: 1.5 })
            .light(point([0.0, 5.0, 0.0], 1.0))
            .scene()
    }

    /// At a place on the floor.
    fn found(place: [f32; 2]) -> Vec<Clearance> {
        let scene = scene();
        let ground = Ground { scene: &scene, start: Vec3::new(place[0], 1e-6, place[1]), normal: Vec3::Y };
        let of = |index| Clearance::new(&ground, [0.0, REACH], &mut Random::new([index, 0, 0, 0]), || 0.0);
        (0..4000).map(of).collect()
    }

    #[test]
    fn the_surface_is_where_it_is() {
        let (scene, start) = (scene(), Vec3::new(0.3, 1e-6, 0.0));
        assert!(Ground { scene: &scene, start, normal: Vec3::Y }.goes_on(Vec3::ZERO));
    }

    #[test]
    fn nothing_is_in_the_way_on_an_open_floor() {
        assert!(found([0.3, 0.0]).iter().all(|clear| *clear == Clearance::of(REACH)));
    }

    #[test]
    fn in_a_gap_it_is_about_as_wide_as_the_gap() {
        // A cosine-weighted ray goes farther than d with probability (h/d)², both of two with its square: 4/3 h is the mean.
        let found = found([-0.6, 0.0]);
        let mean = found.iter().map(|clear| clear.radius).sum::<f32>() / found.len() as f32;
        assert!(mean < 1.34 * 0.01 && mean > 0.001, "{mean}");
    }

    #[test]
    fn the_share_of_a_disk_beside_a_border_is_that_of_its_kernel() {
        for q in [0.1, 0.3, 0.5] {
            // Beyond a line at q of the radius: ∫ 8/(3π) (1 - x²)^(3/2) dx from q to 1, by midpoints.
            let steps = 10_000;
            let at = |step| q + (1.0 - q) * (f64::from(step) + 0.5) / f64::from(steps);
            let sum: f64 = (0..steps).map(|step| (1.0 - at(step) * at(step)).powf(1.5)).sum();
            let expected = 1.0 - 8.0 / (3.0 * std::f64::consts::PI) * sum * (1.0 - q) / f64::from(steps);
            let found = found([1.0 - q as f32 * REACH, 0.0]);
            assert!(found.iter().all(|clear| clear.radius == REACH));
            let share = found.iter().map(|clear| f64::from(clear.share)).sum::<f64>() / found.len() as f64;
            // 4,000 draws of 16 places or more, more even than at random: below .5/sqrt(64,000).
            assert!((share - expected).abs() < 0.002, "{share} for {expected}");
        }
    }

    #[test]
    fn a_ball_is_a_surface_as_far_as_it_is_flat_and_glass_is_none_that_ends_another() {
        let scene = scene();
        let ball = flat_within(&Curvature { along: 10.0, across: 10.0, ..Curvature::default() });
        let (on_ball, under_glass) = (Vec3::new(8.0, 0.100_001, 0.0), Vec3::new(0.5, 1e-6, 0.52));
        for (start, reach) in [(on_ball, ball), (under_glass, 0.05)] {
            for index in 0..1000 {
                let random = &mut Random::new([index, 3, 0, 0]);
                let ground = Ground { scene: &scene, start, normal: Vec3::Y };
                let clear = Clearance::new(&ground, [reach, reach], random, || 0.0);
                assert_eq!(clear, Clearance::of(reach));
            }
        }
    }

    /// What is clear at a place that faces up, and the irradiance there.
    fn seen(scene: &Scene, map: &SurfaceMap, point: Vec3, random: &mut Random) -> (Clearance, f32) {
        let ground = Ground { scene, start: point + 1e-6 * Vec3::Y, normal: Vec3::Y };
        let holds = |way| ground.holds(way);
        let mut around = Around::new(map, point, Vec3::Y);
        let clear = Clearance::new(&ground, map.reach().unwrap(), random, || around.enough(holds));
        let seen = around.irradiance(&Curvature::default(), clear, holds);
        (clear, seen[Kind::Scattered as usize].x)
    }

    /// Under the box the floor is a hundred times as bright.
    #[test]
    fn beside_a_wall_light_is_even_and_none_from_behind_it() {
        const PHOTONS: u32 = 1000;
        const MAPS: u32 = 400;
        let scene = scene();
        let disks = Disks { diffuse: REACH, caustic: 0.1 * REACH, crowd: Some(CROWD), within: true };
        let seen = |number| {
            let photon = |index| {
                let mut random = Random::new([index, 4, number, 0]);
                let position = Vec3::new(2.0 * random.uniform() - 1.0, 0.0, 2.0 * random.uniform() - 1.0);
                let power = if position.x < -0.3 { 100.0 } else { 1.0 };
                SurfacePhoton { position, normal: Vec3::Y, power: Vec3::splat(power), caustic: false }
            };
            let map = SurfaceMap::build((0..PHOTONS).map(photon).collect(), disks);
            seen(&scene, &map, Vec3::new(-0.25, 0.0, 0.0), &mut Random::new([number, 5, 0, 0])).1
        };
        let seen: Vec<f32> =
            (0..MAPS).map(seen).map(|irradiance| irradiance / (PHOTONS as f32 / 4.0)).collect();
        let mean = seen.iter().sum::<f32>() / MAPS as f32;
        let variance = seen.iter().map(|irradiance| (irradiance - mean).powi(2)).sum::<f32>() / MAPS as f32;
        // The widest disk holds 22 photons here, each of 4/3 of a photon's variance, and its share is known to a tenth.
        assert!(variance < 0.12, "{variance}");
        // 1/share is 1.6 % too much, and 3 deviations of the mean are 4 %.
        assert!((mean - 1.0).abs() < 0.06, "{mean}");
    }

    /// Disks that are wider than a board reach beyond it everywhere, or at its sides; light on it is as bright as if they did not.
    #[test]
    fn light_on_a_narrow_board_is_all_there() {
        for reach in [0.02, 0.05, 0.1, 0.2, 0.6] {
            light_on_a_board(reach);
        }
    }

    fn light_on_a_board(reach: f32) {
        const PHOTONS: u32 = 20_000;
        let (scene, [across, along]) = (scene(), [0.06, 2.0]);
        let place = |random: &mut Random| {
            Vec3::new(4.0 + across * random.uniform(), 0.0, along * (random.uniform() - 0.5))
        };
        let photons = (0..PHOTONS).map(|index| {
            let position = place(&mut Random::new([index, 1, 0, 0]));
            SurfacePhoton { position, normal: Vec3::Y, power: Vec3::ONE, caustic: false }
        });
        let disks = Disks { diffuse: reach, caustic: 0.0, crowd: Some(CROWD), within: true };
        let map = SurfaceMap::build(photons.collect(), disks);
        let seen = |index| {
            let random = &mut Random::new([index, 2, 0, 0]);
            let point = place(random);
            let (clear, seen) = seen(&scene, &map, point, random);
            assert!(clear.radius > 0.01, "narrowed to {}", clear.radius);
            seen
        };
        let mean = (0..8000).map(seen).sum::<f32>() / 8000.0;
        let expected = PHOTONS as f32 / (across * along);
        // All photons are in some look-up: 1/sqrt(20,000). 1/share of so many places is up to 1.6 % too much.
        assert!((mean / expected - 1.0).abs() < 0.023, "{mean} for {expected} with a reach of {reach}");
    }
}
