//! Edges found by probe rays against silhouettes known in closed form.

use covbeam_render::edges::find_edges;
use covbeam_render::random::Random;
use covbeam_render::scene::Scene;
use glam::Vec3;
use std::path::Path;

fn scene(objects: &str) -> Scene {
    let text = format!(
        "[camera]\nposition = [0.0, 0.0, -20.0]\nlook_at = [0.0, 0.0, 0.0]\nvertical_fov = 30.0\nwidth = 8\nheight = 8\n\
         [[light]]\nkind = \"point\"\nposition = [0.0, 0.0, -10.0]\nintensity = 1.0\n{objects}\n\
         [[object]]\nshape = \"box\"\nmin = [-30.0, -30.0, -30.0]\nmax = [30.0, 30.0, 30.0]\nmaterial = \"black\"\n"
    );
    Scene::parse(&text, "edge test", Path::new(".")).expect("a valid scene")
}

const SPHERE: &str = "[[object]]\nshape = \"sphere\"\ncenter = [0.0, 0.0, 0.0]\nradius = 1.0\nmaterial = { dielectric = { index = 1.5 } }";

/// A ray from (0, 0, -5) at `angle` off the centre, turned by `turn` around the axis.
fn ray(angle: f32, turn: f32) -> (Vec3, Vec3) {
    let (sin, cos) = angle.sin_cos();
    (Vec3::new(0.0, 0.0, -5.0), Vec3::new(sin * turn.cos(), sin * turn.sin(), cos))
}

#[test]
fn the_silhouette_of_a_sphere_is_found_from_both_sides() {
    let scene = scene(SPHERE);
    // The tangent cone: sin = R/d; it touches at the distance sqrt(d² - R²).
    let silhouette = (1.0f32 / 5.0).asin();
    let depth = 24.0f32.sqrt();
    let mut random = Random::new([1, 1, 1, 1]);
    for offset in [-0.12, -0.04, -0.01, 0.01, 0.04, 0.12] {
        for _ in 0..50 {
            let turn = std::f32::consts::TAU * random.uniform();
            let (origin, direction) = ray(silhouette + offset, turn);
            let hit = scene.intersect(origin, direction, f32::INFINITY);
            let edges = find_edges(&scene, origin, direction, hit.as_ref());
            let edge = edges
                .iter()
                .min_by(|a, b| a.distance.total_cmp(&b.distance))
                .unwrap_or_else(|| panic!("no edge at {offset}, turned by {turn}"));
            // Light that runs into the sphere meets it before the silhouette: the edge is moved there.
            let depth = hit.filter(|hit| hit.object == 0).map_or(depth, |hit| hit.distance.min(depth));
            let expected = depth * offset.abs();
            // Bisection to 1/128 of a step of up to 0.2 rad: 1.5e-3; the silhouette between two azimuths is taken as
            // straight: its sagitta over 45° at the distance ρ is below ρ²/10 rad.
            let tolerance = depth * (1.6e-3 + 0.1 * offset * offset) + 0.12 * expected;
            assert!(
                (edge.distance - expected).abs() < tolerance,
                "{offset}: {} for {expected}",
                edge.distance
            );
            let outwards = Vec3::new(turn.cos(), turn.sin(), 0.0) * -offset.signum();
            let outwards = outwards.reject_from_normalized(direction).normalize();
            // Half an azimuth, 22.5°, at worst; where the silhouette is nearly straight between two probes, 10°.
            let cosine = if offset.abs() < 0.05 { 0.985 } else { 0.924 };
            assert!(edge.towards.dot(outwards) > cosine, "{offset}: towards {} not {outwards}", edge.towards);
            assert!((edge.depth / depth - 1.0).abs() < 0.05, "{offset}: depth {}", edge.depth);
        }
    }
}

#[test]
fn a_straight_edge_is_found_where_it_is() {
    let scene = scene(
        "[[object]]\nshape = \"rectangle\"\ncorner = [0.0, -9.0, 0.0]\nedge_u = [9.0, 0.0, 0.0]\nedge_v = [0.0, 18.0, 0.0]\nmaterial = \"black\"",
    );
    let mut random = Random::new([2, 2, 2, 2]);
    for _ in 0..200 {
        // From (x, y, -5) straight on: the edge x = 0 is |x| away at the depth 5.
        let x = (0.02 + 0.6 * random.uniform()) * if random.uniform() < 0.5 { -1.0 } else { 1.0 };
        let origin = Vec3::new(x, 2.0 * random.uniform(), -5.0);
        let hit = scene.intersect(origin, Vec3::Z, f32::INFINITY);
        let edges = find_edges(&scene, origin, Vec3::Z, hit.as_ref());
        assert_eq!(edges.len(), 1, "{edges:?}");
        // Bisection: 1/128 of at most 0.2 rad at the depth 5, on either of two probes.
        assert!((edges[0].distance - x.abs()).abs() < 0.017, "{edges:?} for {x}");
        assert!(edges[0].towards.dot(Vec3::X) * -x.signum() > 0.98, "{edges:?} for {x}");
        assert!((edges[0].depth - 5.0).abs() < 0.02, "{edges:?}");
    }
}

#[test]
fn a_slit_has_two_edges_and_a_room_has_none() {
    let slit = scene(
        "[[object]]\nshape = \"rectangle\"\ncorner = [0.1, -9.0, 0.0]\nedge_u = [9.0, 0.0, 0.0]\nedge_v = [0.0, 18.0, 0.0]\nmaterial = \"black\"\n\
         [[object]]\nshape = \"rectangle\"\ncorner = [-0.2, -9.0, 0.0]\nedge_u = [-9.0, 0.0, 0.0]\nedge_v = [0.0, 18.0, 0.0]\nmaterial = \"black\"",
    );
    let origin = Vec3::new(0.0, 0.0, -5.0);
    let hit = slit.intersect(origin, Vec3::Z, f32::INFINITY);
    let mut distances: Vec<f32> =
        find_edges(&slit, origin, Vec3::Z, hit.as_ref()).iter().map(|edge| edge.distance).collect();
    distances.sort_by(f32::total_cmp);
    assert_eq!(distances.len(), 2);
    assert!((distances[0] - 0.1).abs() < 0.01 && (distances[1] - 0.2).abs() < 0.01, "{distances:?}");

    let room = scene(
        "[[object]]\nshape = \"rectangle\"\ncorner = [-30.0, -29.9, -30.0]\nedge_u = [0.0, 0.0, 60.0]\nedge_v = [60.0, 0.0, 0.0]\nmaterial = { lambert = { albedo = 0.5 } }",
    );
    let direction = Vec3::new(0.0, -1.0, 1.0).normalize();
    let hit = room.intersect(Vec3::new(0.0, 0.0, 0.0), direction, f32::INFINITY);
    assert!(
        find_edges(&room, Vec3::ZERO, direction, hit.as_ref()).is_empty(),
        "where floor and wall meet is no edge"
    );
}
