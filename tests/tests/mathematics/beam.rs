//! Beams against the naive twin: every pair tested, in double precision.

use covbeam::{
    ALONG_SINE, BLOCK, Beam, BeamBlock, BeamMap, Column, EyeRay, GatherScratch, Gathered, Medium, Vec3,
    cross, gather_pair,
};
use covbeam_session::random::Random;
use covbeam_tests::kernel::plain;
use glam::DVec3;

fn direction(random: &mut Random) -> Vec3 {
    loop {
        let v = 2.0 * Vec3::new(random.uniform(), random.uniform(), random.uniform()) - Vec3::ONE;
        let l = v.length();
        if l > 0.01 && l < 1.0 {
            return v / l;
        }
    }
}

fn point(random: &mut Random) -> Vec3 {
    8.0 * Vec3::new(random.uniform(), random.uniform(), random.uniform()) - Vec3::splat(4.0)
}

const FOG: Medium = Medium {
    scattering: Vec3::new(0.2, 0.15, 0.1),
    absorption: Vec3::new(0.02, 0.03, 0.0),
    ..Medium::homogeneous(0.0, 0.0)
};

fn random_beams(count: usize, random: &mut Random) -> Vec<Beam> {
    (0..count)
        .map(|i| Beam {
            origin: point(random),
            direction: direction(random),
            length: 0.01 + 6.0 * random.uniform() * random.uniform(),
            power: Vec3::new(random.uniform(), random.uniform(), random.uniform()),
            start_normal: if i % 3 == 0 { direction(random) } else { Vec3::ZERO },
            end_normal: if i % 2 == 0 { direction(random) } else { Vec3::ZERO },
        })
        .collect()
}

/// Textbook estimator in f64, without end planes.
fn naive(ray: &EyeRay, beam: &Beam, medium: &Medium, radius: f64) -> Option<[f64; 3]> {
    let (e, b) = (ray.direction.as_dvec3().normalize(), beam.direction.as_dvec3().normalize());
    let w: DVec3 = beam.origin.as_dvec3() - ray.origin.as_dvec3();
    // Normal equations of the two closest points.
    let (cos, we, wb) = (e.dot(b), w.dot(e), w.dot(b));
    let sin2 = 1.0 - cos * cos;
    let t = (we - wb * cos) / sin2;
    let s = (we * cos - wb) / sin2;
    let gap = (w + s * b - t * e).length();
    let hit =
        t >= 0.0 && t <= f64::from(ray.length) && s >= 0.0 && s <= f64::from(beam.length) && gap < radius;
    hit.then(|| {
        let q = gap / radius;
        let kernel = 0.75 / radius * (1.0 - q * q);
        let scale = kernel / (4.0 * std::f64::consts::PI) / sin2.sqrt();
        std::array::from_fn(|c| {
            let extinction = f64::from(medium.scattering[c]) + f64::from(medium.absorption[c]);
            f64::from(medium.scattering[c]) * f64::from(beam.power[c]) * scale * (-extinction * (s + t)).exp()
        })
    })
}

#[test]
fn one_pair_agrees_with_the_textbook_estimator_in_double_precision() {
    let mut random = Random::new([1, 2, 3, 4]);
    let mut compared = 0;
    for _ in 0..1_000_000 {
        let mut beam = random_beams(1, &mut random)[0];
        (beam.start_normal, beam.end_normal) = (Vec3::ZERO, Vec3::ZERO);
        let ray = EyeRay { origin: point(&mut random), direction: direction(&mut random), length: 10.0 };
        let mut gathered = Gathered::default();
        let accepted = gather_pair(
            &ray,
            &beam,
            [0.0, beam.length],
            &FOG,
            &[Column::Uniform; 2],
            &plain(0.3),
            &mut gathered,
        );
        let truth = naive(&ray, &beam, &FOG, 0.3);
        let sine = ray.direction.cross(beam.direction).length();
        if sine < ALONG_SINE {
            continue; // An integral of its own: along.rs.
        }
        if let (true, Some(truth)) = (accepted, truth) {
            compared += 1;
            for (c, truth) in truth.iter().enumerate() {
                let error = (f64::from(gathered.radiance[c]) / truth - 1.0).abs();
                // Rounding of positions of size 10 (6e-7) moves the gap near the kernel's rim, where its slope
                // over its value grows without bound, and 1/sin² amplifies it; the typical pair is at 1e-6.
                let rim = 0.3 / (0.3 - f64::from(cross(&ray, &beam).unwrap().gap));
                assert!(error < 1e-5 * rim / f64::from(sine * sine), "{error} at sin {sine}, rim {rim}");
            }
        }
    }
    assert!(compared > 3000, "only {compared} pairs were compared");
}

#[test]
fn square_on_pairs_are_not_lost() {
    let mut random = Random::new([5, 6, 7, 8]);
    for _ in 0..20_000 {
        let e = direction(&mut random);
        let b = e.any_orthonormal_vector();
        let meet = point(&mut random);
        let ray = EyeRay { origin: meet - 2.0 * e, direction: e, length: 4.0 };
        let beam = Beam {
            origin: meet - 1.5 * b + 0.01 * e.cross(b),
            direction: b,
            length: 3.0,
            power: Vec3::ONE,
            ..Beam::default()
        };
        let crossing = cross(&ray, &beam).expect("square-on");
        // Positions of size 8 carry 5e-7 of rounding.
        assert!((crossing.ray_distance - 2.0).abs() < 4e-6 && (crossing.beam_distance - 1.5).abs() < 4e-6);
        assert!((crossing.gap - 0.01).abs() < 4e-6);
    }
}

#[test]
fn the_map_accepts_the_same_pairs_as_testing_every_beam() {
    let mut random = Random::new([9, 9, 9, 9]);
    for (count, radius) in [(1, 0.3), (7, 0.5), (500, 0.2), (3000, 0.02), (3000, 0.6)] {
        let beams = random_beams(count, &mut random);
        let map = BeamMap::build(beams.clone(), radius, &FOG);
        assert_eq!(map.beams().len(), count);
        let mut scratch = GatherScratch::default();
        for spread in [0.0, 0.02, 0.3, 3.0] {
            let center = direction(&mut random);
            let eye = point(&mut random);
            let rays: Vec<EyeRay> = (0..64)
                .map(|i| EyeRay {
                    origin: eye + 0.1 * spread * direction(&mut random),
                    direction: (center + spread * direction(&mut random)).normalize(),
                    length: if i % 5 == 0 { f32::INFINITY } else { 9.0 * random.uniform() },
                })
                .collect();
            let mut fast = vec![Gathered::default(); rays.len()];
            map.gather(&FOG, &rays, &plain(radius), &mut fast, &mut scratch).unwrap();
            for (ray, fast) in rays.iter().zip(&fast) {
                let mut slow = Gathered::default();
                for beam in &beams {
                    gather_pair(
                        ray,
                        beam,
                        [0.0, beam.length],
                        &FOG,
                        &[Column::Uniform; 2],
                        &plain(radius),
                        &mut slow,
                    );
                }
                assert_eq!(fast.pairs, slow.pairs, "{count} beams, radius {radius}, spread {spread}");
                // Only the order of summation differs.
                let error = (fast.radiance - slow.radiance).abs().max_element();
                assert!(
                    error <= 2e-5 * slow.radiance.max_element(),
                    "{:?} {:?}",
                    fast.radiance,
                    slow.radiance
                );
            }
        }
    }
}

#[test]
fn a_wall_neither_takes_nor_gives_light() {
    // Parallel beams run into a wall that they and the eye ray meet at a slant. Far from the wall the estimate of a
    // slab of light is exact on average; with square-cut beam ends it would lose light where the kernel reaches
    // over the wall. Closed form: n beams of power 1 spread over the height H give ∫ dt n/H on every eye ray.
    let wall = Vec3::new(0.3, 0.2, -1.0).normalize();
    let b = Vec3::new(0.3, 0.0, 1.0).normalize();
    let e = Vec3::new(-0.6, 0.0, 1.0).normalize();
    let clear = Medium::homogeneous(1e-6, 0.0);
    // Distance along `direction` from `from` to the wall through the origin.
    let to_wall = |from: Vec3, direction: Vec3| -from.dot(wall) / direction.dot(wall);
    let radius = 0.4;
    let axis = e.cross(b).normalize();
    let count = 4000;
    let mut sum = Gathered::default();
    let eye = Vec3::new(2.0, 0.0, -3.0);
    let ray = EyeRay { origin: eye, direction: e, length: to_wall(eye, e) };
    let meet = ray.origin + ray.length * e;
    let mut expected = 0.0;
    for k in -20..=0 {
        // A sheet of beams that crosses the eye ray at this distance before the wall.
        let at = meet + 0.05 * (k as f32 - 0.5) * e;
        expected += 1.0;
        for i in 0..count {
            let offset = ((i as f32 + 0.5) / count as f32 - 0.5) * 2.0 * radius;
            let from = at + offset * axis - 4.0 * b;
            let length = to_wall(from, b);
            let beam = Beam {
                origin: from,
                direction: b,
                length,
                power: Vec3::splat(2.0 * radius / count as f32),
                start_normal: Vec3::ZERO,
                end_normal: wall,
            };
            gather_pair(&ray, &beam, [0.0, length], &clear, &[Column::Uniform; 2], &plain(radius), &mut sum);
        }
    }
    let unit = 1e-6 / (4.0 * std::f32::consts::PI) / e.cross(b).length();
    let ratio = sum.radiance.x / (unit * expected);
    // The cap of the kernel cuts the corner where the slant would need more than a radius: here it does not.
    assert!((ratio - 1.0).abs() < 0.01, "{ratio}");
}

#[test]
fn worthless_beams_and_rays_change_nothing() {
    let good = Beam { direction: Vec3::X, length: 1.0, power: Vec3::ONE, ..Beam::default() };
    let nan = f32::NAN;
    let bad = [
        Beam { length: 0.0, ..good },
        Beam { length: -1.0, ..good },
        Beam { length: nan, ..good },
        Beam { length: f32::INFINITY, ..good },
        Beam { origin: Vec3::splat(nan), ..good },
        Beam { direction: Vec3::new(nan, 0.0, 0.0), ..good },
        Beam { power: Vec3::splat(f32::INFINITY), ..good },
        Beam { origin: Vec3::splat(3e38), direction: Vec3::X, length: 3e38, ..good },
    ];
    let unsound = BeamMap::build(bad.to_vec(), 0.1, &FOG);
    // Kept, so that indices are the caller's, but in no piece.
    assert_eq!((unsound.beams().len(), unsound.memory()), (bad.len(), bad.len() * size_of::<Beam>()));
    let map = BeamMap::build(vec![good], 0.1, &FOG);
    let mut scratch = GatherScratch::default();
    let ray = EyeRay { origin: Vec3::new(0.5, 0.0, -1.0), direction: Vec3::Z, length: 2.0 };
    let rays = [
        EyeRay { origin: Vec3::splat(nan), ..ray },
        EyeRay { direction: Vec3::splat(nan), ..ray },
        EyeRay { direction: Vec3::ZERO, ..ray },
        EyeRay { length: nan, ..ray },
        EyeRay { length: -1.0, ..ray },
        EyeRay { direction: Vec3::X, ..ray },
    ];
    for ray in rays {
        let mut gathered = [Gathered::default()];
        map.gather(&FOG, &[ray], &plain(0.1), &mut gathered, &mut scratch).unwrap();
        assert_eq!(gathered[0], Gathered::default(), "{ray:?}");
    }
    let mut gathered = [Gathered::default()];
    map.gather(&FOG, &[ray], &plain(0.1), &mut gathered, &mut scratch).unwrap();
    assert_eq!(gathered[0].pairs, 1);
    for radius in [0.0, -1.0, nan] {
        let mut gathered = [Gathered::default()];
        map.gather(&FOG, &[ray], &plain(radius), &mut gathered, &mut scratch).unwrap();
        assert_eq!(gathered[0], Gathered::default(), "radius {radius}");
    }
}

#[test]
fn the_filter_lets_every_accepted_pair_through_and_few_others() {
    let mut random = Random::new([4, 4, 4, 4]);
    let (mut accepted, mut passed) = (0, 0);
    for _ in 0..20_000 {
        let beams = random_beams(BLOCK, &mut random);
        let mut block = BeamBlock::EMPTY;
        for (slot, beam) in beams.iter().enumerate() {
            block.set(slot, beam, 0.0, beam.length);
        }
        let ray = EyeRay { origin: point(&mut random), direction: direction(&mut random), length: 8.0 };
        let mask = block.test(&ray, 0.1);
        for (slot, beam) in beams.iter().enumerate() {
            let mut gathered = Gathered::default();
            if gather_pair(
                &ray,
                beam,
                [0.0, beam.length],
                &FOG,
                &[Column::Uniform; 2],
                &plain(0.1),
                &mut gathered,
            ) {
                accepted += 1;
                assert!(mask >> slot & 1 == 1, "slot {slot} of {ray:?} was filtered out");
            }
        }
        passed += mask.count_ones();
        block.clear_from(3);
        assert_eq!(block.test(&ray, 0.1), mask & 0b111);
        block.clear_from(0);
        assert_eq!(block.test(&ray, 0.1), 0);
    }
    // The slack at the ends of ray and beam lets through what ends within a radius of the other.
    assert!(accepted > 200 && passed < accepted + accepted / 2, "{accepted} accepted of {passed}");
}

#[test]
fn a_map_says_what_it_holds() {
    let map = |count| BeamMap::build(random_beams(count, &mut Random::new([6, 6, 6, 6])), 0.1, &FOG);
    let (small, large) = (map(100).memory(), map(10_000).memory());
    let bytes = large as f64 / 10_000.0;
    // 76 bytes a beam, 36 a piece and 32 a node, about four pieces a beam and two nodes or less a piece.
    assert!(small < large && (76.0..500.0).contains(&bytes), "{bytes} bytes a beam");
}
