//! Meshes: watertight for glass, normals and curvature against closed forms, files refused with a reason.

use std::fmt::Write;

use super::shapes::{Random, deformed, glass, globe, lumpy};
use covbeam::Curvature;
use covbeam_geometry::mesh::{Mesh, MeshError, Placement};
use covbeam_geometry::obj::{self, ObjError, ObjTriangles};
use covbeam_session::scene::Scene;
use glam::{DMat2, DVec3, Quat, Vec3};
use proptest::prelude::*;

const PLACEMENTS: [(f32, Vec3); 3] =
    [(1.0, Vec3::ZERO), (1e-4, Vec3::new(1e-4, 0.0, -2e-4)), (300.0, Vec3::new(1e6, -1e6, 5e5))];

fn placed(source: ObjTriangles, scale: f32, translation: Vec3, smooth: bool) -> Mesh {
    Mesh::new(source, &Placement { scale, translation, ..Placement::default() }, smooth).expect("valid")
}

fn shoot(scene: &Scene, from: Vec3, direction: Vec3) -> Option<covbeam_geometry::hit::Hit> {
    scene.intersect(from, direction, f32::INFINITY)
}

/// The text that Blender writes for these triangles.
fn to_obj(source: &ObjTriangles) -> String {
    let mut text = String::from("# exported\nmtllib none.mtl\no thing\n");
    for p in &source.positions {
        writeln!(text, "v {} {} {}", p.x, p.y, p.z).expect("writes to a string");
    }
    for n in &source.normals {
        writeln!(text, "vn {} {} {}", n.x, n.y, n.z).expect("writes to a string");
    }
    text += "usemtl glass\ns 1\n";
    for t in &source.indices {
        let corner = |i: u32| match source.normals.is_empty() {
            true => format!("{}", i + 1),
            false => format!("{0}//{0}", i + 1),
        };
        writeln!(text, "f {} {} {}", corner(t[0]), corner(t[1]), corner(t[2])).expect("writes to a string");
    }
    text
}

#[test]
fn no_ray_from_inside_a_closed_mesh_escapes() {
    let mut random = Random(1);
    let mut leaks = 0;
    let mut shot = 0;
    for (scale, at) in PLACEMENTS {
        // The cube's boxes in the hierarchy are flat.
        let cube = obj::parse(CUBE.as_bytes()).expect("valid");
        for (source, inner) in [(globe(100), 0.9), (lumpy(80), 0.2), (cube, 0.9)] {
            let mesh = placed(source.clone(), scale, at, true);
            assert!(mesh.is_closed());
            let scene = glass(mesh);
            for i in 0..200_000 {
                let from = at + scale * inner * random.direction() * random.unit() as f32;
                // Two in three at a vertex or at a point of an edge as exactly as f32 allows: that is where
                // cracks are.
                let triangle = source.indices[random.index(source.indices.len())];
                let [a, b, _] = triangle.map(|k| source.positions[k as usize] * scale + at);
                let direction = match i % 3 {
                    0 => random.direction(),
                    1 => (a - from).normalize(),
                    _ => (a + random.unit() as f32 * (b - a) - from).normalize(),
                };
                shot += 1;
                leaks += usize::from(shoot(&scene, from, direction).is_none());
            }
        }
    }
    println!("rays that escaped from a closed mesh: {leaks} of {shot}");
    assert_eq!(leaks, 0);
}

#[test]
fn light_that_bounces_inside_a_mesh_stays_inside() {
    let mut random = Random(2);
    for (scale, at) in PLACEMENTS {
        let scene = glass(placed(globe(100), scale, at, true));
        let (mut from, mut direction) = (at, random.direction());
        // A start point pushed through the neighbouring triangle: the next hit is missing or seen from outside.
        let (mut escapes, bounces) = (0, 100_000);
        for _ in 0..bounces {
            match shoot(&scene, from, direction) {
                Some(hit) if hit.geometric_normal.dot(direction) > 0.0 => {
                    direction = (0.999 * random.direction() - hit.geometric_normal).normalize();
                    from = hit.leave(direction);
                }
                _ => {
                    escapes += 1;
                    (from, direction) = (at, random.direction());
                }
            }
        }
        println!("bounces in a mesh of size {scale} at {at} that got out: {escapes} of {bounces}");
        // The push is ~1e-6 of the size (1e-3 in the far placement, which f32 resolves no better), the edges are
        // 0.03 apart and bent by 0.03 rad: only a push along an edge's own bend can pass through the neighbour.
        assert_eq!(escapes, 0);
    }
}

#[test]
fn a_ray_that_leaves_a_convex_mesh_does_not_come_back() {
    let mut random = Random(3);
    for (scale, at) in PLACEMENTS {
        let scene = glass(placed(globe(60), scale, at, true));
        let mut again = 0;
        for _ in 0..100_000 {
            let from = at + 3.0 * scale * random.direction();
            let aim = (at + 0.7 * scale * random.direction() - from).normalize();
            let hit = shoot(&scene, from, aim).expect("aimed at the mesh");
            let direction = (0.999 * random.direction() + hit.geometric_normal).normalize();
            again += usize::from(shoot(&scene, hit.leave(direction), direction).is_some());
        }
        assert_eq!(again, 0, "scale {scale}");
    }
}

#[test]
fn the_hierarchy_finds_what_testing_every_triangle_finds() {
    let source = lumpy(24);
    let scene = glass(placed(source.clone(), 1.0, Vec3::ZERO, true));
    let mut random = Random(4);
    let mut hits = 0;
    for _ in 0..3_000 {
        let (from, direction) = (2.0 * random.cube().as_vec3(), random.direction());
        // Möller and Trumbore (1997) in f64, over all triangles.
        let (o, d) = (from.as_dvec3(), direction.as_dvec3());
        let nearest = source
            .indices
            .iter()
            .filter_map(|t| {
                let [a, b, c] = t.map(|i| source.positions[i as usize].as_dvec3());
                let (e1, e2, s) = (b - a, c - a, o - a);
                let determinant = e1.dot(d.cross(e2));
                let u = s.dot(d.cross(e2)) / determinant;
                let v = d.dot(s.cross(e1)) / determinant;
                let distance = e2.dot(s.cross(e1)) / determinant;
                // Rays within 1e-6 of an edge may go either way.
                (u >= 1e-6 && v >= 1e-6 && u + v <= 1.0 - 1e-6 && distance > 0.0).then_some(distance)
            })
            .fold(f64::INFINITY, f64::min);
        let found = shoot(&scene, from, direction);
        if nearest.is_finite() {
            hits += 1;
            let found = found.expect("the naive loop found one");
            // f32 distances of a few units; grazing hits lose a digit.
            assert!(f64::from(found.distance) <= nearest + 2e-5, "{} against {nearest}", found.distance);
            assert!(scene.occluded(from, from + direction * (found.distance + 0.01)));
        }
    }
    assert!(hits > 200, "{hits} hits test nothing");
}

/// Eigenvalues of the curvature tensor and the world direction of the larger one.
fn principal(curvature: &Curvature, normal: Vec3) -> (f64, f64, DVec3) {
    let (a, b, c) = (f64::from(curvature.along), f64::from(curvature.twist), f64::from(curvature.across));
    let (mean, radius) = (0.5 * (a + c), (0.25 * (a - c) * (a - c) + b * b).sqrt());
    let angle = 0.5 * (2.0 * b).atan2(a - c);
    let (t, n) = (curvature.tangent.as_dvec3(), normal.as_dvec3());
    (mean + radius, mean - radius, angle.cos() * t + angle.sin() * n.cross(t))
}

/// Shape operator of x²/a² + y²/b² + z²/c² = 1 at a point, in the frame (t, n x t): S = Hess F / |grad F|.
fn ellipsoid_operator(axes: DVec3, p: DVec3, t: DVec3) -> DMat2 {
    let inverse = 1.0 / (axes * axes);
    let gradient = p * inverse;
    let s = gradient.normalize().cross(t);
    let form = |a: DVec3, b: DVec3| (a * inverse).dot(b) / gradient.length();
    DMat2::from_cols_array(&[form(t, t), form(t, s), form(s, t), form(s, s)])
}

/// Largest relative deviation of the curvature tensor and of the normal over random hits on an ellipsoid.
fn ellipsoid_errors(rows: u32, scale: f32, at: Vec3, exact_normals: bool) -> (f64, f64) {
    let axes = DVec3::new(0.8, 1.0, 1.3);
    let mut source = deformed(globe(rows), |p| (p.as_dvec3() * axes).as_vec3());
    if exact_normals {
        let normal = |p: &Vec3| (p.as_dvec3() / (axes * axes)).normalize().as_vec3();
        source.normals = source.positions.iter().map(normal).collect();
    }
    let scene = glass(placed(source, scale, at, true));
    let mut random = Random(5);
    let (mut worst_curvature, mut worst_normal) = (0.0f64, 0.0f64);
    for _ in 0..5_000 {
        let mut direction = random.direction();
        // The globe's poles have needle triangles that no tessellation error bound covers.
        direction.z = direction.z.clamp(-0.8, 0.8);
        let direction = direction.normalize();
        let hit = shoot(&scene, at, direction).expect("inside");
        let on_mesh = (hit.position.as_dvec3() - at.as_dvec3()) / f64::from(scale);
        let p = on_mesh / (on_mesh / axes).length();
        let normal = (p / (axes * axes)).normalize();
        worst_normal = worst_normal.max((normal - hit.normal.as_dvec3()).length());
        let t = (hit.curvature.tangent.as_dvec3() - normal * hit.curvature.tangent.as_dvec3().dot(normal))
            .normalize();
        let expected = ellipsoid_operator(axes, p, t);
        let c = hit.curvature;
        let found =
            DMat2::from_cols_array(&[c.along, c.twist, c.twist, c.across].map(f64::from)) * f64::from(scale);
        let difference = (found - expected).to_cols_array().map(f64::abs);
        worst_curvature = worst_curvature.max(difference.into_iter().fold(0.0, f64::max));
    }
    (worst_curvature, worst_normal)
}

#[test]
fn curvature_and_normals_of_a_fine_mesh_approach_the_ellipsoids() {
    for exact_normals in [true, false] {
        let (coarse, coarse_normal) = ellipsoid_errors(50, 1.0, Vec3::ZERO, exact_normals);
        let (fine, fine_normal) = ellipsoid_errors(200, 1.0, Vec3::ZERO, exact_normals);
        println!(
            "exact normals {exact_normals}: curvature off by {coarse:.1e}, then {fine:.1e}; normal {coarse_normal:.1e}, then {fine_normal:.1e}"
        );
        // Linear interpolation: normals to second order in the edge length, their derivative to first. Four
        // times finer must give nearly 16 and 4 times less.
        assert!(fine < coarse / 3.0 && fine < 0.05, "curvature {coarse} -> {fine}");
        assert!(
            fine_normal < coarse_normal / 10.0 && fine_normal < 1e-3,
            "normal {coarse_normal} -> {fine_normal}"
        );
    }
    for (scale, at) in [(1e-4, Vec3::ZERO), (3e5, Vec3::new(1e6, -1e6, 5e5))] {
        let (error, _) = ellipsoid_errors(200, scale, at, true);
        assert!(error < 0.05, "scale {scale}: {error}");
    }
}

#[test]
fn principal_curvatures_of_a_cylinder_are_its_inverse_radius_and_zero() {
    // A tube of radius 2 along z, open at both ends.
    let columns = 400;
    let point = |i: u32, z: f32| {
        let angle = std::f64::consts::TAU * f64::from(i % columns) / f64::from(columns);
        Vec3::new((2.0 * angle.cos()) as f32, (2.0 * angle.sin()) as f32, z)
    };
    let (mut positions, mut indices) = (Vec::new(), Vec::new());
    for i in 0..columns {
        let k = positions.len() as u32;
        positions.extend([point(i, -1.0), point(i + 1, -1.0), point(i + 1, 1.0), point(i, 1.0)]);
        indices.extend([[k, k + 1, k + 2], [k, k + 2, k + 3]]);
    }
    let mesh = placed(ObjTriangles { positions, normals: Vec::new(), indices }, 1.0, Vec3::ZERO, true);
    assert!(!mesh.is_closed());
    assert_eq!(mesh.open_edges(), 800, "both rims");
    let scene = glass(mesh);
    let mut random = Random(6);
    for _ in 0..2_000 {
        let angle = std::f32::consts::TAU * random.unit() as f32;
        let from = Vec3::new(0.0, 0.0, 1.6 * random.unit() as f32 - 0.8);
        let hit = shoot(&scene, from, Vec3::new(angle.cos(), angle.sin(), 0.0)).expect("inside the tube");
        let (strong, weak, axis) = principal(&hit.curvature, hit.normal);
        // 400 facets: (π/400)² = 6e-5 of chord against arc, and the vertices' two or three triangles weigh
        // unequally by as much.
        assert!((strong - 0.5).abs() < 1e-3 && weak.abs() < 1e-3, "{strong} {weak}");
        assert!(axis.z.abs() < 0.01, "{axis}");
    }
}

#[test]
fn a_flat_shaded_mesh_has_no_curvature() {
    let scene = glass(placed(globe(20), 1.0, Vec3::ZERO, false));
    let hit = shoot(&scene, Vec3::ZERO, Vec3::new(0.3, 0.5, 0.1).normalize()).expect("inside");
    assert_eq!(hit.normal, hit.geometric_normal);
    assert_eq!((hit.curvature.along, hit.curvature.across, hit.curvature.twist), (0.0, 0.0, 0.0));
}

/// The cube [-1, 1]³ with its faces cut along arbitrary diagonals.
const CUBE: &str = "v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1\n\
                    f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 3 4 8 7\nf 1 5 8 4\nf 2 3 7 6\n";

#[test]
fn angle_weights_make_the_normals_of_a_cube_point_along_its_diagonals() {
    let mesh =
        Mesh::new(obj::parse(CUBE.as_bytes()).expect("valid"), &Placement::default(), true).expect("valid");
    assert_eq!((mesh.triangle_count(), mesh.is_closed(), mesh.degenerate()), (12, true, 0));
    assert!((mesh.volume() - 8.0).abs() < 1e-6);
    let scene = glass(mesh);
    for corner in [Vec3::ONE, Vec3::new(-1.0, 1.0, -1.0), Vec3::new(1.0, -1.0, 1.0)] {
        let hit =
            shoot(&scene, Vec3::ZERO, (corner * Vec3::new(1.0, 1.0, 0.999_999)).normalize()).expect("inside");
        // 1e-6 away from the corner, on an edge of length 2.
        assert!((hit.normal - corner.normalize()).length() < 1e-5, "{} at {corner}", hit.normal);
    }
}

#[test]
fn a_mesh_turned_inside_out_is_turned_back() {
    let mut source = globe(20);
    source.indices.iter_mut().for_each(|t| t.swap(0, 1));
    source.normals = source.positions.iter().map(|p| -*p).collect();
    let scene = glass(placed(source, 1.0, Vec3::ZERO, true));
    let direction = Vec3::new(0.3, 0.5, 0.1).normalize();
    let hit = shoot(&scene, Vec3::ZERO, direction).expect("inside");
    assert!(hit.geometric_normal.dot(direction) > 0.9 && hit.normal.dot(direction) > 0.99);
    assert!((hit.curvature.along - 1.0).abs() < 0.05, "convex outwards: {:?}", hit.curvature);
}

#[test]
fn a_mesh_is_scaled_then_rotated_then_moved() {
    let placement = Placement {
        scale: 2.0,
        rotation: Quat::from_axis_angle(Vec3::Z, std::f32::consts::FRAC_PI_2),
        translation: Vec3::new(0.0, 0.0, 7.0),
    };
    let mut source = globe(40);
    source.positions.iter_mut().for_each(|p| *p = *p * 0.1 + Vec3::X);
    source.normals = globe(40).positions;
    let scene = glass(Mesh::new(source, &placement, true).expect("valid"));
    let hit = shoot(&scene, Vec3::new(0.0, 0.0, 7.0), Vec3::Y).expect("x turned to y");
    assert!((hit.distance - 1.8).abs() < 1e-3, "{}", hit.distance);
    assert!((hit.normal + Vec3::Y).length() < 0.1);
    assert!((hit.curvature.along - 5.0).abs() < 0.1, "radius 0.2: {:?}", hit.curvature);
}

#[test]
fn triangles_without_area_are_dropped_and_counted() {
    let text = format!("{CUBE}v 0 0 1\nf 1 1 2\nf 5 7 9\n");
    let mesh =
        Mesh::new(obj::parse(text.as_bytes()).expect("valid"), &Placement::default(), true).expect("valid");
    assert_eq!((mesh.triangle_count(), mesh.degenerate()), (12, 2));
    let lines = obj::parse(b"v 0 0 0\nv 1 1 1\nv 2 2 2\nf 1 2 3\nf 3 2 1").expect("valid");
    let error = Mesh::new(lines, &Placement::default(), true).expect_err("no area");
    assert!(matches!(error, MeshError::AllDegenerate(2)), "{error}");
}

#[test]
fn a_missing_face_or_a_flipped_one_makes_a_mesh_open() {
    for (text, edges) in [
        (CUBE.replace("f 2 3 7 6\n", ""), 4),
        (CUBE.replace("f 2 3 7 6\n", "f 6 7 3 2\n"), 8),
        (format!("{CUBE}f 2 3 7 6\n"), 16),
    ] {
        let mesh = Mesh::new(obj::parse(text.as_bytes()).expect("valid"), &Placement::default(), true)
            .expect("valid");
        assert!(!mesh.is_closed());
        assert!(mesh.open_edges() >= edges, "{} open edges", mesh.open_edges());
    }
}

#[test]
fn seams_of_texture_coordinates_and_normals_do_not_open_a_mesh() {
    // As Maya writes hard edges: each face has corners and normals of its own.
    let text = "v -1 -1 -1\nv 1 -1 -1\nv 0 1 -1\nv 0 0 1\nvt 0 0\nvt 1 0\nvt 0 1\nvn 0 0 -1\nvn 0 -1 0\nvn 1 1 1\nvn -1 1 1\n\
                f 3/1/1 2/2/1 1/3/1\nf 1/1/2 2/2/2 4/3/2\nf 2/1/3 3/2/3 4/3/3\nf 3/1/4 1/2/4 4/3/4\n";
    let mesh =
        Mesh::new(obj::parse(text.as_bytes()).expect("valid"), &Placement::default(), true).expect("valid");
    assert!(mesh.is_closed());
}

#[test]
fn marks_of_byte_order_colours_of_some_vertices_and_lines_that_go_on_are_read() {
    let plain = obj::parse(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3").expect("valid");
    for text in [
        "\u{feff}v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3",
        "v 0 0 0 .1 .2 .3\nv 1 0 0\nv 0 1 0 1 1 1\nf 1 2 3",
        "v 0 0 \\\n0\nv 1 0 0\nv 0 1 0\nf 1 \\\n 2 \\\r\n 3\\",
    ] {
        assert_eq!(obj::parse(text.as_bytes()), Ok(plain.clone()), "{text:?}");
    }
    // It is the first line's number.
    let error = obj::parse(b"v 0 0 0\nv 1 \\\n\\\nx 0\n").expect_err("no number");
    assert!(error.to_string().contains("line 2: found `x`"), "{error}");
}

#[test]
fn a_face_of_many_corners_is_a_fan() {
    let count = 200_000;
    let vertices = (0..count).map(|k| {
        let (s, c) = (f64::from(k) / f64::from(count) * std::f64::consts::TAU).sin_cos();
        format!("v {c} {s} 0\n")
    });
    let face = (1..=count).map(|k| format!(" {k}"));
    let text = vertices.chain(["f".to_owned()]).chain(face).collect::<String>();
    let read = obj::parse(text.as_bytes()).expect("valid");
    assert_eq!((read.indices.len(), read.indices[7]), (count as usize - 2, [0, 8, 9]));
}

#[test]
fn every_kind_of_wrong_file_is_refused_with_its_line() {
    let table: &[(&str, &str)] = &[
        ("", "no triangles"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\n", "no triangles"),
        ("v 0 0 0\nv 1 nan 0\nv 0 1 0\nf 1 2 3", "line 2: found `nan`, expected a finite number"),
        ("v 0 0 0\nv 1 inf 0\nv 0 1 0\nf 1 2 3", "line 2: found `inf`"),
        ("v 0 0 0\nv 1 1e99 0\nv 0 1 0\nf 1 2 3", "line 2: found `1e99`"),
        ("v 0 0 0\nv 1 0\nv 0 1 0\nf 1 2 3", "line 2: found `v 1 0`, expected 3 coordinates"),
        ("v 0 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3", "line 1: found `v 0 0 0 0`, expected finite coordinates"),
        ("v 0 0 x\n", "line 1: found `x`"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4", "line 4: index 4 is out of range, the file has 3 vertices"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 0", "line 4: index 0 is out of range"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 -4", "line 4: index -4 is out of range, the file has 3 vertices"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 99999999999", "line 4: index 99999999999 is out of range"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 99999999999999999999", "line 4: found `99999999999999999999`"),
        (
            "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1/1 2/1 3/1",
            "line 4: index 1 is out of range, the file has 0 texture",
        ),
        (
            "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1//1 2//1 3//2",
            "line 5: index 2 is out of range, the file has 1 normals",
        ),
        (
            "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 0\nf 1//1 2//1 3//1",
            "line 4: found `vn 0 0 0`, expected a normal",
        ),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 nan 1\nf 1//1 2//1 3//1", "line 4: found `nan`"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1//1 2//1 3", "some faces have normals"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2", "line 4: found `f 1 2`, expected a face of at least 3 corners"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3/", ""),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 /3", "line 4: found ``, expected a face corner"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3/1/1/1", "line 4"),
    ];
    for (text, expected) in table {
        match obj::parse(text.as_bytes()) {
            Ok(read) => assert!(expected.is_empty() && read.indices.len() == 1, "{text:?} was read"),
            Err(error) => assert!(
                !expected.is_empty() && error.to_string().contains(expected),
                "{text:?}: \"{error}\" lacks \"{expected}\""
            ),
        }
    }
    let far = Placement { translation: Vec3::splat(3e9), ..Placement::default() };
    let error = Mesh::new(globe(4), &far, true).expect_err("beyond 1e9");
    assert!(matches!(error, MeshError::Size { .. }), "{error}");
    let mut wrong = globe(4);
    wrong.indices[3][1] = 9999;
    let error = Mesh::new(wrong, &Placement::default(), true).expect_err("out of range");
    assert!(matches!(error, MeshError::Index(3)), "{error}");
    assert!(matches!(obj::parse(b"v 0 0 0 1 2"), Err(ObjError::Line { line: 1, .. })));
}

/// What the renderer does with a mesh file, and one ray.
fn read_and_shoot(bytes: &[u8]) {
    if let Ok(mesh) =
        obj::parse(bytes).map_err(MeshError::from).and_then(|o| Mesh::new(o, &Placement::default(), true))
    {
        let (min, max) = mesh.bounds();
        let center = 0.5 * (min + max);
        if let Some(hit) = shoot(&glass(mesh), center + Vec3::X, -Vec3::X) {
            assert!(hit.position.is_finite() && hit.normal.is_normalized() && hit.distance > 0.0);
        }
    }
}

#[test]
fn a_valid_obj_cut_anywhere_or_with_any_byte_changed_is_read_or_refused() {
    let mut source = globe(3);
    source.normals = source.positions.clone();
    let text = to_obj(&source) + "f -1//-1 -2//-2 -3//-3\nf 1//1 2//2 3//3 4//4 5//5\n";
    for end in 0..=text.len() {
        read_and_shoot(&text.as_bytes()[..end]);
    }
    for place in 0..text.len() {
        for byte in [0, b' ', b'\n', b'-', b'/', b'9', b'e', 0xff] {
            let mut bytes = text.clone().into_bytes();
            bytes[place] = byte;
            read_and_shoot(&bytes);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(8 * ProptestConfig::default().cases))]

    #[test]
    fn an_obj_of_random_words_is_read_or_refused(words in prop::collection::vec(
        prop::sample::select(vec!["v ", "vn ", "vt ", "f ", "l ", "g ", "o", "usemtl ", "mtllib ", "\n", "1 ", "2 ", "-1 ", "3/", "//",
            "0 ", "1e30 ", "-1e-30 ", "nan ", "\\\n", "\u{fffd}", "-9223372036854775808 ", "9223372036854775807 ", "\nv 0 0 1\n", "\nv 1 0 0\n", "\nf 1 2 3\n"]), 0..60)) {
        read_and_shoot(words.concat().as_bytes());
    }
}
