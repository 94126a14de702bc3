//! The search for edges with nothing but a function that casts rays, against silhouettes in closed form; and the numbers of
//! light paths.

use covbeam::edges::MOST_PROBES;
use covbeam::{EMISSION_DIMENSIONS, Edges, MOST_EDGES, ProbeHit, Vec3, find_edges, path_number};
use covbeam_tests::random::Stream;

/// The nearest hit of a ray from the origin with a ball.
fn ball(center: Vec3, radius: f32, direction: Vec3) -> Option<ProbeHit> {
    let (center, direction) = (center.as_dvec3(), direction.as_dvec3().normalize());
    let along = center.dot(direction);
    let half2 = f64::from(radius).powi(2) - (center - along * direction).length_squared();
    let distance = along - half2.max(0.0).sqrt();
    let normal = (distance * direction - center).as_vec3();
    (half2 > 0.0 && distance > 0.0).then_some(ProbeHit { distance: distance as f32, normal, offset: 1e-6 })
}

#[test]
fn the_silhouette_of_a_ball_lies_where_its_tangents_touch() {
    let mut stream = Stream::new(91);
    for _ in 0..500 {
        // The tangent cone has sin = R/d and touches at sqrt(d² - R²).
        let (distance, radius) = (5.0, stream.between(0.5, 1.5) as f32);
        let silhouette = (radius / distance).asin();
        let offset = stream.decades(-2.5, -1.0) as f32 * if stream.uniform() < 0.5 { -1.0 } else { 1.0 };
        let direction = stream.direction();
        let across = direction.any_orthonormal_vector();
        let angle = silhouette + offset;
        let center = distance * (angle.cos() * direction + angle.sin() * across);
        let hit = ball(center, radius, direction);
        assert_eq!(hit.is_some(), offset < 0.0);
        let mut probes = 0;
        let edges = find_edges(direction, hit, |towards| {
            probes += 1;
            assert!(towards.is_normalized());
            ball(center, radius, towards)
        });
        assert!(probes <= MOST_PROBES && edges.len() <= MOST_EDGES);
        assert!(edges.is_sorted_by(|a, b| a.depth <= b.depth));
        let nearest = edges.iter().min_by(|a, b| a.distance.total_cmp(&b.distance)).expect("an edge");
        let touch = (distance * distance - radius * radius).sqrt();
        let depth = hit.map_or(touch, |hit| hit.distance.min(touch));
        // Half the last bracket, 2.5 %; between two azimuths the silhouette is taken as straight, 8 %; the tangent of 0.1 rad is not
        // the angle.
        let expected = depth * offset.abs().tan();
        assert!((nearest.distance / expected - 1.0).abs() < 0.12, "{offset}: {nearest:?} for {expected}");
        assert!((nearest.depth / depth - 1.0).abs() < 0.05, "{offset}: {nearest:?} at {depth}");
        // Half an azimuth, 22.5 degrees, at worst.
        assert!(nearest.towards.dot(across) * offset.signum() > 0.92, "{offset}: {nearest:?}, {across}");
        assert!(nearest.towards.dot(direction).abs() < 1e-5 && nearest.towards.is_normalized());
    }
}

#[test]
fn nothing_around_and_a_plane_all_around_have_no_edges() {
    assert!(find_edges(Vec3::Z, None, |_| None).is_empty());
    let floor = |towards: Vec3| {
        let distance = -1.0 / towards.y;
        (distance > 0.0).then_some(ProbeHit { distance, normal: Vec3::Y, offset: 1e-6 })
    };
    let mut stream = Stream::new(92);
    for _ in 0..500 {
        let direction = stream.direction();
        assert!(find_edges(direction, floor(direction), floor).is_empty(), "{direction}");
    }
}

#[test]
fn the_surface_that_a_ray_leaves_has_no_edge() {
    // From just above a ball, along it.
    let (radius, offset) = (0.5, 1e-6);
    let center = Vec3::NEG_Y * (radius + offset);
    let mut stream = Stream::new(93);
    for _ in 0..200 {
        let direction = Vec3::new(1.0, stream.decades(-3.0, 0.0) as f32, 0.0).normalize();
        let edges = find_edges(direction, None, |towards| ball(center, radius, towards));
        assert!(edges.is_empty(), "{direction}: {edges:?}");
    }
}

/// Hosts move rays by some 1e-4 off what they leave.
#[test]
fn what_is_near_has_an_edge_however_far_off_surfaces_rays_start() {
    for offset in [0.0, 1e-6, 1e-4, 1e-3] {
        // From a floor, past a post 5 cm away; the floor goes on behind it.
        let origin = Vec3::Y * offset;
        let cast = |towards: Vec3| {
            let floor = -origin.y / towards.y;
            let floor = ProbeHit { distance: floor, normal: Vec3::Y, offset };
            let post = 0.05 / towards.z;
            let post = ProbeHit { distance: post, normal: -Vec3::Z, offset };
            let is_post = post.distance > 0.0 && post.distance * towards.x > 0.005;
            let is_floor = floor.distance > 0.0 && !(is_post && post.distance < floor.distance);
            if is_floor { Some(floor) } else { is_post.then_some(post) }
        };
        let edges = find_edges(Vec3::new(0.0, 0.05, 1.0).normalize(), None, cast);
        assert_eq!(edges.len(), 1, "{offset}: {edges:?}");
        let [edge] = edges[..] else { unreachable!() };
        assert!((edge.depth / 0.05 - 1.0).abs() < 0.01, "{offset}: {edge:?}");
        assert!((edge.distance / 0.005 - 1.0).abs() < 0.05 && edge.towards.x > 0.98, "{offset}: {edge:?}");
    }
}

fn is_sound(edges: &Edges) -> bool {
    edges.iter().all(|edge| {
        edge.depth > 0.0
            && edge.distance > 0.0
            && edge.depth.is_finite()
            && edge.distance.is_finite()
            && edge.towards.is_normalized()
    })
}

#[test]
fn whatever_a_host_answers_the_edges_are_sound() {
    let hostile = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 0.0, -1.0, 1e-45, 1e-30, 1.0, 3e38];
    let mut stream = Stream::new(94);
    let pick = |stream: &mut Stream| {
        let u = stream.uniform();
        if u < 0.5 { stream.decades(-2.0, 2.0) as f32 } else { hostile[(stream.uniform() * 9.0) as usize] }
    };
    let mut found = 0;
    for _ in 0..20_000 {
        let mut probes = 0;
        let mut answer = |_| {
            probes += 1;
            let numbers = [(); 5].map(|()| pick(&mut stream));
            let [distance, x, y, z, offset] = numbers;
            let offset = if probes % 3 == 0 { offset } else { 0.0 };
            (distance.to_bits() % 5 != 0).then_some(ProbeHit { distance, normal: Vec3::new(x, y, z), offset })
        };
        let hit = answer(Vec3::Z);
        let edges = find_edges(Vec3::Z, hit, answer);
        found += edges.len();
        assert!(is_sound(&edges), "{edges:?}");
        assert!(probes <= MOST_PROBES + 1);
    }
    assert!(found > 10_000, "{found} edges");
    for direction in [Vec3::ZERO, Vec3::NAN, Vec3::splat(f32::INFINITY), Vec3::splat(1e-30), 2.0 * Vec3::Z] {
        assert!(find_edges(direction, None, |_| panic!("asked for a probe along {direction}")).is_empty());
    }
}

#[test]
fn the_first_numbers_of_paths_fill_their_dimensions_evenly() {
    for (seed, sequence) in [(0, 0), (1, 0), (0, 1), (u32::MAX, 7)] {
        for dimension in 0..EMISSION_DIMENSIONS {
            // Blocks of 2^k paths, wherever they start at a multiple.
            for first in [0, 3 * 512, u32::MAX - 511] {
                let mut seen = [false; 512];
                for path in 0..512 {
                    let number = path_number(seed, sequence, first + path, dimension);
                    let cell = (512.0 * number) as usize;
                    assert!(!seen[cell], "{seed} {sequence} {dimension}: {number} is the second of its cell");
                    seen[cell] = true;
                }
            }
        }
        // The first two together are a (0, 2)-sequence: 2^8 paths put one into each of 2^a x 2^(8-a) boxes.
        for a in 0..=8 {
            let (columns, rows) = (1 << a, 256 >> a);
            let mut seen = [false; 256];
            for path in 256..512 {
                let [x, y] = [0, 1].map(|dimension| path_number(seed, sequence, path, dimension));
                let cell = (columns as f32 * x) as usize * rows + (rows as f32 * y) as usize;
                assert!(!seen[cell], "{seed} {sequence}: two paths in one of {columns} x {rows} boxes");
                seen[cell] = true;
            }
        }
    }
}

#[test]
fn numbers_of_paths_are_uniform_and_of_seeds_sequences_and_dimensions_unrelated() {
    let count = 1 << 14;
    for dimension in [0, 7, 8, 9, 1000, u32::MAX] {
        let of = |seed: u32, sequence: u32, dimension: u32| {
            (0..count).map(move |path| f64::from(path_number(seed, sequence, path, dimension)) - 0.5)
        };
        assert!(of(1, 2, dimension).all(|number| (-0.5..0.5).contains(&number)));
        let mean = |values: &mut dyn Iterator<Item = f64>| values.sum::<f64>() / f64::from(count);
        // Standard errors sqrt(1/12n) = 2.3e-3 of a mean, 1/12 / sqrt(n) = 6.5e-4 of a product: 5 of them, a false alarm in a
        // million each.
        assert!(mean(&mut of(1, 2, dimension)).abs() < 1.15e-2);
        // Two scrambles of one stratified dimension are unrelated on average over the seeds only.
        let others = [(1, 2, dimension ^ 1), (3, 2, dimension), (1, 3, dimension)];
        let compared = if dimension < EMISSION_DIMENSIONS { 1 } else { 3 };
        for (seed, sequence, other) in others.into_iter().take(compared) {
            let product = mean(&mut of(1, 2, dimension).zip(of(seed, sequence, other)).map(|(a, b)| a * b));
            assert!(product.abs() < 3.3e-3, "{dimension}: {product} with {seed} {sequence} {other}");
        }
    }
}
