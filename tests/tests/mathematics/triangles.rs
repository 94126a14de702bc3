//! Triangles met by rays, against a test of each of them on its own, bit for bit.

use covbeam_geometry::triangles::{Frame, TriangleHit, Triangles, area_vector};
use covbeam_tests::random::Stream;
use glam::{DVec3, Vec3};

type Corners = [Vec3; 3];

/// A ray from a place along a direction, up to a distance.
type Ray = (Vec3, Vec3, f32);

/// What a ray meets: bits of the distance and of the weights, and which triangle.
type Met = (u32, usize, [u32; 3]);

/// The distance and the weights, as S. Woop, C. Benthin and I. Wald (JCGT 2013, appendix A) write them, but for their repetition in double
/// precision.
fn woop((origin, direction, _): Ray, triangle: &Corners) -> Option<(f32, [f32; 3])> {
    let d = direction.to_array();
    let kz = (0..3).fold(0, |most, axis| if d[axis].abs() >= d[most].abs() { axis } else { most });
    let (kx, ky) = ((kz + 1) % 3, (kz + 2) % 3);
    let (sx, sy, sz) = (d[kx] / d[kz], d[ky] / d[kz], 1.0 / d[kz]);
    let [a, b, c] = triangle.map(|corner| (corner - origin).to_array());
    let (ax, ay) = (a[kx] - sx * a[kz], a[ky] - sy * a[kz]);
    let (bx, by) = (b[kx] - sx * b[kz], b[ky] - sy * b[kz]);
    let (cx, cy) = (c[kx] - sx * c[kz], c[ky] - sy * c[kz]);
    let (u, v, w) = (cx * by - cy * bx, ax * cy - ay * cx, bx * ay - by * ax);
    if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
        return None;
    }
    let sum = u + v + w;
    let distance = (u * (sz * a[kz]) + v * (sz * b[kz]) + w * (sz * c[kz])) / sum;
    (distance > 0.0).then_some((distance, [u / sum, v / sum, w / sum]))
}

/// All that a ray meets, from near to far and in the order given.
fn each(triangles: &[Corners], ray: Ray) -> Vec<Met> {
    let of = |(index, triangle): (usize, &Corners)| {
        let (distance, weights) = woop(ray, triangle).filter(|(distance, _)| *distance < ray.2)?;
        Some((distance.to_bits(), index, weights.map(f32::to_bits)))
    };
    let mut met: Vec<Met> = triangles.iter().enumerate().filter_map(of).collect();
    met.sort_unstable();
    met
}

/// In a frame in which coordinates are what they are.
fn built(triangles: &[Corners]) -> Triangles {
    Triangles::new(Frame::around(DVec3::NEG_ONE, DVec3::ONE), triangles, &[])
}

fn bits(built: &Triangles, hit: &TriangleHit) -> Met {
    ((hit.distance as f32).to_bits(), built.index(hit), hit.weights.to_array().map(f32::to_bits))
}

/// Whether the nearest, all and any hit of a ray are those of each triangle on its own; returns how many there are.
fn assert_same(built: &Triangles, triangles: &[Corners], ray: Ray, what: &str) -> usize {
    let expected = each(triangles, ray);
    let (origin, direction, reach) = (ray.0.as_dvec3(), ray.1.as_dvec3(), f64::from(ray.2));
    let nearest = built.intersect(origin, direction, reach);
    assert_eq!(nearest.map(|hit| bits(built, &hit)), expected.first().copied(), "{what}: {ray:?}");
    let mut all = Vec::new();
    let is_ended = built.any(origin, direction, reach, |hit| {
        assert_eq!(built.corners(&hit), triangles[built.index(&hit)], "{what}");
        all.push(bits(built, &hit));
        false
    });
    all.sort_unstable();
    assert_eq!((is_ended, &all), (false, &expected), "{what}: {ray:?}");
    assert_eq!(built.occluded(origin, direction, reach), !expected.is_empty(), "{what}: {ray:?}");
    expected.len()
}

fn place(random: &mut Stream) -> Vec3 {
    Vec3::from_array([0; 3].map(|_| random.between(-1.0, 1.0) as f32))
}

/// Places of small whole numbers by 8: many in one plane, on one line or at the same place.
fn grid_place(random: &mut Stream) -> Vec3 {
    (8.0 * place(random)).round() / 8.0
}

fn with_area(count: usize, mut triangle: impl FnMut() -> Corners) -> Vec<Corners> {
    let mut next = || std::iter::repeat_with(&mut triangle).find(|t| area_vector(*t) != DVec3::ZERO).unwrap();
    (0..count).map(|_| next()).collect()
}

/// A plate of squares of two triangles each, in the plane z = 0.
fn plate() -> Vec<Corners> {
    let at = |i: usize, j: usize| Vec3::new(i as f32 / 8.0 - 1.0, j as f32 / 8.0 - 1.0, 0.0);
    let square = |k: usize| {
        let (i, j) = (k % 16, k / 16);
        let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
        [[a, b, c], [a, c, d]]
    };
    (0..256).flat_map(square).collect()
}

/// Sets of triangles, with what they are.
fn sets(random: &mut Stream) -> Vec<(&'static str, Vec<Corners>)> {
    let around = |middle: Vec3, size: f32, random: &mut Stream| {
        [(); 3].map(|()| (middle + size * place(random)).clamp(Vec3::NEG_ONE, Vec3::ONE))
    };
    let small = with_area(3000, || around(place(random), 0.1, random));
    let large = with_area(200, || [(); 3].map(|()| place(random)));
    let on_grid = with_area(700, || [(); 3].map(|()| grid_place(random)));
    let doubled = on_grid[..60].iter().chain(&on_grid[..60]).chain(&on_grid[30..90]).copied().collect();
    let many_at_one_place = vec![large[0]; 100];
    let nested = (0..300).map(|i| large[1].map(|corner| corner * 0.98_f32.powi(i))).collect();
    let one = vec![large[2]];
    let nine = large[..9].to_vec();
    vec![
        ("none", Vec::new()),
        ("one", one),
        ("nine", nine),
        ("small", small),
        ("large", large),
        ("on a grid", on_grid),
        ("several times", doubled),
        ("a hundred times the same", many_at_one_place),
        ("nested", nested),
        ("a plate", plate()),
    ]
}

/// A ray of any of several kinds: between any places, along an axis from a place of the grid, through a corner or an edge, and short ones.
fn ray(random: &mut Stream, triangles: &[Corners]) -> Ray {
    let axes = [Vec3::X, Vec3::Y, Vec3::Z, Vec3::NEG_X, Vec3::NEG_Y, Vec3::NEG_Z];
    let axis = axes[random.bits() as usize % 6];
    let reach = if random.uniform() < 0.5 { f32::INFINITY } else { random.uniform() as f32 };
    let kind = random.bits() % 6;
    let from = 2.0 * place(random);
    let target = triangles.get(random.bits() as usize % triangles.len().max(1));
    match (kind, target) {
        (0, _) | (_, None) => (from, random.direction(), reach),
        (1, _) => (grid_place(random) - axis, axis, reach),
        (2, Some([a, _, _])) => (*a - axis, axis, reach),
        (3, Some([a, b, _])) => (a.midpoint(*b) - 2.0 * axis, axis, reach),
        (4, Some([a, _, _])) => (from, (*a - from).normalize(), reach),
        (_, Some([a, b, _])) => (from, (a.lerp(*b, random.uniform() as f32) - from).normalize(), reach),
    }
}

#[test]
fn a_hierarchy_of_triangles_meets_what_each_of_them_meets() {
    let mut random = Stream::new(61);
    for (what, triangles) in sets(&mut random) {
        let built = built(&triangles);
        assert_eq!((built.count(), built.all_corners()), (triangles.len(), triangles.clone()), "{what}");
        let mut hits = 0;
        for _ in 0..4000 {
            let ray = ray(&mut random, &triangles);
            hits += assert_same(&built, &triangles, ray, what);
            // What is exactly at the end is not met.
            if let Some(last) = each(&triangles, ray).last() {
                assert_same(&built, &triangles, (ray.0, ray.1, f32::from_bits(last.0)), what);
            }
        }
        println!("{what}: {hits} hits");
        assert!(hits > 500 || triangles.len() < 2, "{what}: {hits}");
    }
}

/// Of those that lie on each other and those that share an edge or a corner, each as near as the others.
#[test]
fn of_several_triangles_as_near_the_first_is_met() {
    let plate = plate();
    let built = built(&plate);
    for (x, y, shared) in [(0.0, 0.0, 6), (0.0625, 0.0625, 2), (0.125, 0.03125, 2), (0.03, 0.01, 1)] {
        let ray = (Vec3::new(x, y, -1.5), Vec3::Z, f32::INFINITY);
        let met = each(&plate, ray);
        assert!(met.len() == shared && met.iter().all(|one| one.0 == met[0].0), "{met:?}");
        assert_same(&built, &plate, ray, "a plate");
        let reversed: Vec<Corners> = plate.iter().rev().copied().collect();
        assert_same(&self::built(&reversed), &reversed, ray, "a plate from its end");
    }
}

/// Of slivers single precision knows the distance less well than the boxes say: which of two neighbours is met is left open.
#[test]
fn a_ray_through_slivers_meets_one_of_them() {
    // Fans of 500 triangles from one corner.
    for width in [1e-2, 1e-4, 1e-5_f32] {
        let rim = |i: i32| Vec3::new(1.0, width * i as f32, 0.25);
        let corner = Vec3::new(-1.0, 0.0, -0.25);
        let fan: Vec<Corners> = (-250..250).map(|i| [corner, rim(i), rim(i + 1)]).collect();
        let built = built(&fan);
        let mut random = Stream::new(62);
        for i in 0..4000 {
            // Half of them on an edge, as exactly as single precision allows, and none beside the outermost.
            let (i, aside) = (i % 480 - 240, random.uniform().max(0.5) as f32 - 0.5);
            let at = corner.lerp(rim(i).lerp(rim(i + 1), aside), random.between(0.1, 0.9) as f32);
            let side = if random.uniform() < 0.5 { Vec3::Z } else { Vec3::NEG_Z };
            let along = (0.5 * random.direction() - side).normalize();
            let ray = (at - along, along, f32::INFINITY);
            let hit = built.intersect(ray.0.as_dvec3(), along.as_dvec3(), f64::INFINITY);
            let hit = hit.unwrap_or_else(|| panic!("none of a fan of {width} at {at}"));
            assert!(each(&fan, ray).contains(&bits(&built, &hit)), "{ray:?}");
            assert!((hit.distance - 1.0).abs() < 2e-2, "{hit:?}");
            assert!(built.occluded(ray.0.as_dvec3(), along.as_dvec3(), f64::INFINITY));
        }
    }
}

#[test]
fn rays_that_are_not_numbers_meet_nothing_and_end() {
    let mut random = Stream::new(63);
    for (_, triangles) in sets(&mut random) {
        let built = built(&triangles);
        for wrong in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300, 0.0] {
            for axis in 0..3 {
                let (mut place, mut along) = (DVec3::new(0.1, 0.2, -1.5), DVec3::new(0.0, 0.6, 0.8));
                along[axis] = wrong;
                built.intersect(place, along, f64::INFINITY);
                built.occluded(place, along, f64::INFINITY);
                along[axis] = 0.0;
                place[axis] = if wrong == 0.0 { f64::NAN } else { wrong };
                assert!(built.intersect(place, along, f64::INFINITY).is_none());
                assert!(!built.occluded(place, along, f64::INFINITY));
            }
        }
        for along in [DVec3::NAN, DVec3::INFINITY, DVec3::NEG_INFINITY, DVec3::ZERO] {
            assert!(built.intersect(DVec3::ZERO, along, f64::INFINITY).is_none());
            assert!(!built.occluded(DVec3::ZERO, along, f64::INFINITY));
        }
        for reach in [f64::NAN, 0.0, -1.0] {
            assert!(built.intersect(DVec3::ZERO, DVec3::Z, reach).is_none());
            assert!(!built.occluded(DVec3::ZERO, DVec3::Z, reach));
        }
    }
}
