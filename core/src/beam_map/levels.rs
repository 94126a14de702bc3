//! Every set of vector instructions that this processor has gives the same bits.

use super::cancel::Poll;
use super::rays::RayTables;
use super::search::{Query, Search};
use super::shade::OurMedium;
use super::simd::{Floats, load, max, min};
use crate::beam::{Beam, EyeRay, is_along};
use crate::beam_map::BeamMap;
use crate::grid::{FluenceCell, FluenceGrid};
use crate::kernel::{Kernel, KernelShape};
use crate::light_field::FluenceSpectrum;
use crate::medium::{Density, DensityGrid, ExponentialDensity, Medium, PhaseFunction, PhaseKind, PhaseShare};
use crate::pair::Gathered;
use crate::voxels::GridLayout;
use fearless_simd::{Level, Simd, dispatch};
use glam::Vec3;
use std::vec::Vec;

/// From the scalar code of processors without vectors, if the feature `scalar` keeps it, to the best.
fn levels() -> Vec<Level> {
    let (mut levels, best) = (Vec::new(), Level::new());
    #[cfg(feature = "scalar")]
    levels.push(Level::fallback());
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    {
        levels.extend(best.as_sse2().map(Simd::level));
        levels.extend(best.as_sse4_2().map(Simd::level));
        levels.extend(best.as_avx2().map(Simd::level));
        levels.extend(best.as_avx512().map(Simd::level));
    }
    #[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
    levels.push(best);
    std::println!("{levels:?}");
    assert!(levels.len() > 1);
    levels
}

/// Numbers in [0, 1), the same at each run.
struct Random(u64);

impl Random {
    fn uniform(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / (1 << 24) as f32
    }

    fn vector(&mut self, half: f32) -> Vec3 {
        Vec3::from([0; 3].map(|_| half * (2.0 * self.uniform() - 1.0)))
    }
}

fn beams(random: &mut Random) -> Vec<Beam> {
    let beam = |i: usize| {
        let direction = random.vector(1.0).normalize();
        // Every third is cut by a surface; every seventh runs along an axis, every fifth nearly along rays.
        let direction = match i {
            _ if i % 7 == 0 => Vec3::AXES[i % 3],
            _ if i % 5 == 0 => (Vec3::Z + random.vector(0.02)).normalize(),
            _ => direction,
        };
        Beam {
            origin: random.vector(2.0),
            direction,
            length: 4.0 * random.uniform(),
            power: random.vector(0.5) + 0.5,
            start_normal: if i % 3 == 0 { direction } else { Vec3::ZERO },
            end_normal: Vec3::ZERO,
        }
    };
    (0..1500).map(beam).collect()
}

/// One eye's rays, side by side; some have no end, some run along an axis, with zeros of both signs.
fn rays(random: &mut Random) -> Vec<EyeRay> {
    let ray = |i| EyeRay {
        origin: Vec3::new(0.0, -0.0, -4.0),
        direction: match i % 10 {
            0 => Vec3::new(0.0, -0.0, 1.0),
            1 => Vec3::new(-0.0, 0.0, 1.0),
            _ => (Vec3::Z + random.vector(0.3)).normalize(),
        },
        length: if i % 7 == 0 { f32::INFINITY } else { 9.0 * random.uniform() },
    };
    (0..300).map(ray).collect()
}

/// What rays gather with the instructions of a level.
fn gather(level: Level, map: &BeamMap, medium: &Medium, rays: &[EyeRay], kernel: &Kernel) -> Vec<Gathered> {
    let (mut gathered, tables) = (std::vec![Gathered::default(); rays.len()], &mut RayTables::default());
    tables.clear().unwrap();
    let (beams, columns) = (&map.beams, &map.columns);
    let mut shade = OurMedium { columns, rays, medium, gathered: &mut gathered, tables };
    let query = Query { level, beams, bvh: &map.bvh, rays, kernel };
    let go_on = &mut || true;
    let mut poll = Poll::new(go_on).unwrap();
    Search::default().all(&query, &mut poll, &mut shade).unwrap();
    gathered
}

fn bits(gathered: &[Gathered]) -> Vec<[u32; 7]> {
    let bits = |g: &Gathered| {
        let [red, green, blue] = g.radiance.to_array().map(f32::to_bits);
        [red, green, blue, g.pairs, g.weight.to_bits(), g.radius.to_bits(), g.sigma.to_bits()]
    };
    gathered.iter().map(bits).collect()
}

/// Calls `check` with maps in media of every density, and kernels with radii from a grid.
fn in_each_medium(check: impl Fn(&BeamMap, &Medium, &Kernel, &[EyeRay])) {
    let random = &mut Random(1);
    let (beams, rays) = (beams(random), rays(random));
    let layout = GridLayout { min: Vec3::splat(-1.5), max: Vec3::splat(1.5), cells: [4, 5, 3] };
    let cells: Vec<FluenceCell> = (0..layout.cell_count())
        .map(|i| {
            let mut spectrum = FluenceSpectrum::default();
            spectrum.add_along(random.vector(1.0).normalize(), 4.0 * random.uniform());
            FluenceCell { spectrum, weight: if i % 4 == 0 { 0.0 } else { random.uniform() } }
        })
        .collect();
    let kernel = Kernel {
        shape: KernelShape::Biweight,
        min_radius: 0.02,
        max_radius: 0.3,
        error: 0.01,
        grid: Some(FluenceGrid::new(layout, &cells).unwrap()),
    };
    let billows: Vec<f32> = (0..512).map(|_| 2.0 * random.uniform()).collect();
    let box_of_billows = GridLayout { min: Vec3::splat(-2.5), max: Vec3::splat(2.5), cells: [8; 3] };
    let air = ExponentialDensity { origin: Vec3::ZERO, up: Vec3::Y, scale_height: 2.0 };
    for density in [
        Density::Uniform,
        Density::Exponential(air),
        Density::Grid(DensityGrid::new(box_of_billows, &billows).unwrap()),
    ] {
        let medium = Medium {
            scattering: Vec3::new(0.3, 0.2, 0.1),
            absorption: Vec3::new(0.02, 0.0, 0.5),
            phase: PhaseFunction { kind: PhaseKind::HenyeyGreenstein, asymmetry: 0.7 },
            // Where density varies, what is scattered by another one too.
            more: if matches!(density, Density::Uniform) { &[] } else { &HAZE },
            density,
        };
        check(&BeamMap::build(beams.clone(), kernel.max_radius, &medium), &medium, &kernel, &rays);
    }
}

/// Of several colours.
const HAZE: [PhaseShare; 2] = [
    PhaseShare {
        phase: PhaseFunction { kind: PhaseKind::Rayleigh, asymmetry: 0.0 },
        share: Vec3::new(0.1, 0.2, 0.4),
    },
    PhaseShare {
        phase: PhaseFunction { kind: PhaseKind::HenyeyGreenstein, asymmetry: -0.4 },
        share: Vec3::new(0.5, 0.0, 0.6),
    },
];

#[test]
fn every_level_gathers_the_same_bits() {
    let levels = levels();
    in_each_medium(|map, medium, kernel, rays| {
        let lowest = gather(levels[0], map, medium, rays, kernel);
        let [pairs, lit] =
            [0, 1].map(|least| lowest.iter().map(|g| g.pairs).filter(|&n| n > least).sum::<u32>());
        assert!(pairs > 1000 && lit > 1000, "{pairs} pairs");
        let along = |beam: &&Beam| {
            rays.iter().any(|ray| is_along(ray.direction.cross(beam.direction).length_squared()))
        };
        assert!(map.beams().iter().filter(along).count() > 100);
        assert!(lowest.iter().any(|g| g.sigma > 0.0) && lowest.iter().any(|g| g.pairs == 0));
        for level in &levels[1..] {
            assert_eq!(bits(&gather(*level, map, medium, rays, kernel)), bits(&lowest), "{level:?}");
        }
    });
}

#[test]
fn rays_that_are_none_take_no_light_from_those_beside_them() {
    let none = [
        EyeRay { origin: Vec3::splat(f32::NAN), direction: Vec3::Z, length: 9.0 },
        EyeRay { origin: Vec3::new(0.0, f32::NAN, -4.0), direction: Vec3::Z, length: 9.0 },
        EyeRay { origin: Vec3::splat(f32::INFINITY), direction: Vec3::Z, length: 9.0 },
        EyeRay { origin: Vec3::ZERO, direction: Vec3::splat(f32::NAN), length: 9.0 },
        EyeRay { origin: Vec3::ZERO, direction: Vec3::ZERO, length: 9.0 },
        EyeRay { origin: Vec3::ZERO, direction: Vec3::Z, length: f32::NAN },
        EyeRay { origin: Vec3::splat(3e38), direction: Vec3::Z, length: 9.0 },
    ];
    in_each_medium(|map, medium, kernel, rays| {
        let wanted = bits(&gather(Level::new(), map, medium, rays, kernel));
        for (case, ray) in none.into_iter().enumerate() {
            for level in levels() {
                let mut with = Vec::from(rays);
                with.insert(100, ray);
                let mut found = bits(&gather(level, map, medium, &with, kernel));
                found.remove(100);
                let lost = found.iter().zip(&wanted).filter(|(found, wanted)| found != wanted).count();
                assert_eq!(lost, 0, "rays that differ in case {case}, {level:?}");
            }
        }
    });
}

#[test]
fn least_and_most_are_what_they_say_of_any_two_numbers_at_every_level() {
    let odd = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 0.0, -0.0, 1e-40, -1.0, 1.0];
    for level in levels() {
        for shift in 0..8 {
            let mut others: Floats = odd;
            others.rotate_left(shift);
            let found: [Floats; 2] = dispatch!(level, simd => {
                let (a, b) = (load(simd, &odd), load(simd, &others));
                [min(a, b).into(), max(a, b).into()]
            });
            for (lane, (a, b)) in odd.into_iter().zip(others).enumerate() {
                let wanted = [if a < b { a } else { b }, if a > b { a } else { b }];
                let found = found.map(|numbers| numbers[lane]);
                assert_eq!(found.map(f32::to_bits), wanted.map(f32::to_bits), "{a} and {b}, {level:?}");
            }
        }
    }
}
