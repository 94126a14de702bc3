//! Edges found by probe rays against silhouettes known in closed form.

use super::shapes::{globe, scene_of};
use covbeam_geometry::mesh::{Mesh, Placement};
use covbeam_geometry::obj::ObjTriangles;
use covbeam_render::scene_file;
use covbeam_session::random::Random;
use covbeam_session::scene::Scene;
use covbeam_session::scene::{Material, Shape};
use glam::Vec3;
use std::f32::consts::{PI, TAU};
use std::path::Path;

fn scene(objects: &str) -> Scene {
    let text = format!(
        "[camera]\nposition = [0.0, 0.0, -20.0]\nlook_at = [0.0, 0.0, 0.0]\nvertical_fov = 30.0\nwidth = 8\nheight = 8\n\
         [[light]]\nkind = \"point\"\nposition = [0.0, 0.0, -10.0]\nintensity = 1.0\n{objects}\n\
         [[object]]\nshape = \"box\"\nmin = [-30.0, -30.0, -30.0]\nmax = [30.0, 30.0, 30.0]\nmaterial = \"black\"\n"
    );
    scene_file::parse(&text, "edge test", Path::new(".")).expect("a valid scene")
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
            let edges = scene.edges_beside(origin, direction, hit.as_ref());
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
    assert_edge_at_zero(&scene, 2);
}

/// Straight rays from (x, y, -5), beside the edge x = 0 at z = 0.
fn assert_edge_at_zero(scene: &Scene, seed: u32) {
    let mut random = Random::new([seed; 4]);
    for _ in 0..200 {
        // The edge is |x| away at the depth 5.
        let x = (0.02 + 0.6 * random.uniform()) * if random.uniform() < 0.5 { -1.0 } else { 1.0 };
        let origin = Vec3::new(x, 2.0 * random.uniform(), -5.0);
        let hit = scene.intersect(origin, Vec3::Z, f32::INFINITY);
        let edges = scene.edges_beside(origin, Vec3::Z, hit.as_ref());
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
        slit.edges_beside(origin, Vec3::Z, hit.as_ref()).iter().map(|edge| edge.distance).collect();
    distances.sort_by(f32::total_cmp);
    assert_eq!(distances.len(), 2);
    assert!((distances[0] - 0.1).abs() < 0.01 && (distances[1] - 0.2).abs() < 0.01, "{distances:?}");

    let room = scene(
        "[[object]]\nshape = \"rectangle\"\ncorner = [-30.0, -29.9, -30.0]\nedge_u = [0.0, 0.0, 60.0]\nedge_v = [60.0, 0.0, 0.0]\nmaterial = { lambert = { albedo = 0.5 } }",
    );
    let direction = Vec3::new(0.0, -1.0, 1.0).normalize();
    let hit = room.intersect(Vec3::new(0.0, 0.0, 0.0), direction, f32::INFINITY);
    assert!(
        room.edges_beside(Vec3::ZERO, direction, hit.as_ref()).is_empty(),
        "where floor and wall meet is no edge"
    );
}

fn mesh(positions: Vec<Vec3>, indices: Vec<[u32; 3]>) -> Shape {
    let source = ObjTriangles { positions, normals: Vec::new(), indices };
    Shape::Mesh(Mesh::new(source, &Placement::default(), false).expect("a valid mesh"))
}

fn rectangle(x: [f32; 2], y: [f32; 2]) -> (Shape, Material) {
    let corner = Vec3::new(x[0], y[0], 0.0);
    let (edge_u, edge_v) = (Vec3::X * (x[1] - x[0]), Vec3::Y * (y[1] - y[0]));
    (Shape::Rectangle { corner, edge_u, edge_v }, Material::Black)
}

fn wall() -> (Shape, Material) {
    (Shape::Box { min: Vec3::splat(-30.0), max: Vec3::splat(30.0) }, Material::Black)
}

#[test]
fn an_edge_before_the_same_object_is_found_as_well() {
    // x > 0 at z = 0 and all of a wall at z = 4, in one mesh.
    let sheet = |x: f32, z: f32| {
        [(x, -20.0), (20.0, -20.0), (20.0, 20.0), (x, 20.0)].map(|(x, y)| Vec3::new(x, y, z))
    };
    let both = [sheet(0.0, 0.0), sheet(-20.0, 4.0)].concat();
    let one = mesh(both, vec![[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]]);
    let scene = scene_of(vec![(one, Material::Black), wall()]);
    // As with two objects.
    assert_edge_at_zero(&scene, 3);
}

#[test]
fn continuous_surfaces_have_no_edges_however_grazing_or_creased() {
    let globe = |material| {
        let mesh = Mesh::new(globe(40), &Placement::default(), true).expect("a valid mesh");
        scene_of(vec![(Shape::Mesh(mesh), material)])
    };
    let floor = rectangle([-30.0, 30.0], [-30.0, 30.0]);
    let scenes = [
        ("room", scene_of(vec![wall()])),
        ("floor and room", scene_of(vec![floor, wall()])),
        ("inside a faceted ball", globe(Material::Black)),
        ("inside glass", globe(Material::Dielectric { index: 1.5 })),
    ];
    let mut random = Random::new([4, 4, 4, 4]);
    for (name, scene) in scenes {
        let mut uniform = || 2.0 * random.uniform() - 1.0;
        for _ in 0..1000 {
            // Around the middle, above and below the floor; one in two within 3 degrees of it.
            let origin = 0.4 * Vec3::new(uniform(), uniform(), uniform()) + Vec3::new(0.0, 0.0, 0.01);
            let flat = if uniform() < 0.0 { 0.05 } else { 1.0 };
            let direction = Vec3::new(uniform(), uniform(), flat * uniform()).normalize();
            let hit = scene.intersect(origin, direction, f32::INFINITY);
            let edges = scene.edges_beside(origin, direction, hit.as_ref());
            assert!(edges.is_empty(), "{name}: from {origin} along {direction}: {edges:?}");
        }
    }
}

/// A plate with a round hole of this radius.
fn round_hole(radius: f32) -> (Shape, Material) {
    let n = 256;
    let ring = |r: f32| {
        (0..n).map(move |i| {
            r * Vec3::new((TAU * i as f32 / n as f32).cos(), (TAU * i as f32 / n as f32).sin(), 0.0)
        })
    };
    let positions = ring(radius).chain(ring(20.0)).collect();
    let indices =
        (0..n).flat_map(|i| [[i, (i + 1) % n, n + i], [(i + 1) % n, n + (i + 1) % n, n + i]]).collect();
    (mesh(positions, indices), Material::Black)
}

/// Deviations that the edges sum up to, along x and y, against those of the largest unoccluded ellipse.
fn sums(scene: &Scene, at: [f32; 2], free: [f32; 2]) -> [f32; 2] {
    let origin = Vec3::new(at[0], at[1], -5.0);
    let hit = scene.intersect(origin, Vec3::Z, f32::INFINITY);
    let edges = scene.edges_beside(origin, Vec3::Z, hit.as_ref());
    let along = |axis: Vec3| {
        edges.iter().map(|edge| (edge.towards.dot(axis) / (PI * edge.distance)).powi(2)).sum::<f32>().sqrt()
    };
    [along(Vec3::X) * PI * free[0], along(Vec3::Y) * PI * free[1]]
}

#[test]
fn edges_of_a_hole_sum_up_to_its_largest_unoccluded_ellipse() {
    // Half-widths across x and y, and the scene.
    let square = vec![
        rectangle([0.3, 20.0], [-20.0, 20.0]),
        rectangle([-20.0, -0.3], [-20.0, 20.0]),
        rectangle([-0.3, 0.3], [0.3, 20.0]),
        rectangle([-0.3, 0.3], [-20.0, -0.3]),
    ];
    let slit = vec![rectangle([0.3, 20.0], [-20.0, 20.0]), rectangle([-20.0, -0.3], [-20.0, 20.0])];
    let scene_with = |mut shapes: Vec<(Shape, Material)>| {
        shapes.push(wall());
        scene_of(shapes)
    };
    let (square, slit, round) = (scene_with(square), scene_with(slit), scene_with(vec![round_hole(0.3)]));
    let ball = scene_with(vec![(Shape::Sphere { center: Vec3::ZERO, radius: 0.3 }, Material::Black)]);
    for x in [0.0, 0.03, 0.1, 0.2, 0.27] {
        let across = 0.3 - x;
        let check = |name: &str, [along_x, along_y]: [f32; 2]| {
            println!("{name:7} {:3.0} % off the middle: {along_x:.2} across, {along_y:.2} along", x / 0.003);
            // Opposite edges at the same distance add up to sqrt(2) = 1.41; the chord of a round edge lies up to 8 % nearer
            // than the edge: 1.53; an edge 22 degrees off an axis has 0.92 of its deviation along it.
            (0.85..1.65).contains(&along_x) && (0.85..1.65).contains(&along_y)
        };
        assert!(check("square", sums(&square, [x, 0.0], [across, 0.3])));
        assert!(check("corner", sums(&square, [x, x], [across, across])));
        assert!(check("round", sums(&round, [x, 0.0], [across, (0.09 - x * x).sqrt()])));
        // A ball that the light enters: its silhouette is a round hole, moved to where the ball is hit.
        let hit = ball.intersect(Vec3::new(x, 0.0, -5.0), Vec3::Z, f32::INFINITY).expect("the ball");
        let (silhouette, aside) = ((0.3f32 / 5.0).asin(), x / 5.0);
        let free = [silhouette - aside, (silhouette * silhouette - aside * aside).sqrt()];
        assert!(check("ball", sums(&ball, [x, 0.0], free.map(|angle| hit.distance * angle))));
        let [along_x, along_y] = sums(&slit, [x, 0.0], [across, across]);
        println!("slit    {:3.0} % off the middle: {along_x:.2} across, {along_y:.2} along", x / 0.003);
        // Along the slit nothing is masked; two degrees of direction (a twentieth of 45) on each edge remain.
        assert!((0.95..1.5).contains(&along_x) && along_y < 0.1, "{along_x} {along_y}");
    }
}

#[test]
fn a_nearer_occluder_is_kept_beside_a_farther_one_of_smaller_angle() {
    // An edge at tangent 0.1 and depth 1, one at 0.05 and depth 20.
    let near = Shape::Rectangle {
        corner: Vec3::new(0.1, -9.0, -4.0),
        edge_u: Vec3::X * 20.0,
        edge_v: Vec3::Y * 18.0,
    };
    let far = Shape::Rectangle {
        corner: Vec3::new(1.0, -9.0, 15.0),
        edge_u: Vec3::X * 9.0,
        edge_v: Vec3::Y * 18.0,
    };
    let scene = scene_of(vec![(near, Material::Black), (far, Material::Black), wall()]);
    let origin = Vec3::new(0.0, 0.0, -5.0);
    let hit = scene.intersect(origin, Vec3::Z, f32::INFINITY);
    let edges = scene.edges_beside(origin, Vec3::Z, hit.as_ref());
    assert!(edges.len() >= 2, "{edges:?}");
    // 2.5 %: half the precision of the search.
    assert!((edges[0].depth - 1.0).abs() < 0.03 && (edges[0].distance - 0.1).abs() < 0.003, "{edges:?}");
    let last = edges.last().expect("two edges");
    assert!((last.depth - 20.0).abs() < 0.6 && (last.distance - 1.0).abs() < 0.03, "{edges:?}");
}
