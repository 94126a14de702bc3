//! Rays against meshes in many places: what is hit, from which side, and that nothing leaks.

use crate::shapes::{Random, Shape, add, alone, built, cast, distance_to, hit, icosphere, lumpy, rows};
use covbeam_session::describe::MeshArrays;
use covbeam_session::describe::geometry::Geometry;
use glam::{DMat4, DVec3, Vec3};

#[test]
fn instances_are_hit_where_testing_every_triangle_in_the_world_says() {
    let mut random = Random(1);
    let meshes = [icosphere(1), lumpy(2), lumpy(1)];
    let geometry = Geometry::default();
    let numbers: Vec<u32> =
        meshes.iter().zip(10..).map(|(shape, material)| add(&geometry, shape, material, None)).collect();
    // Corners in the world, a point in front of the triangle by its winding in the mesh, object and material.
    let mut world: Vec<([DVec3; 3], DVec3, u32, u32)> = Vec::new();
    for object in 0..40 {
        let (matrix, of) = (random.transform(), random.index(meshes.len()));
        // One in four has a material of its own.
        let (own, material) = if object % 4 == 0 { (77, 77) } else { (-1, 10 + of as u32) };
        geometry.add_instance(numbers[of], &rows(matrix), object, own).expect("valid");
        for triangle in 0..meshes[of].triangles.len() {
            let [a, b, c] = meshes[of].corners(triangle).map(|p| p.as_dvec3());
            let before = (a + b + c) / 3.0 + 0.1 * (b - a).cross(c - a).normalize();
            let corners = [a, b, c].map(|p| matrix.transform_point3(p));
            world.push((corners, matrix.transform_point3(before), object as u32, material));
        }
    }
    let scene = built(&geometry);
    let mut hits = 0;
    for _ in 0..3000 {
        // Far ones too.
        let origin = (if random.signed() < 0.0 { 8.0 } else { 200.0 } * random.cube()).as_vec3();
        let direction = (5.0 * random.cube() - origin.as_dvec3()).normalize().as_vec3().normalize();
        let found = cast(&scene, origin, direction, f32::INFINITY);
        let (from, along) = (origin.as_dvec3(), direction.as_dvec3());
        let tested = world.iter().filter_map(|t| distance_to(from, along, t.0).map(|distance| (distance, t)));
        let Some((distance, (corners, before, object, material))) = tested.min_by(|a, b| a.0.total_cmp(&b.0))
        else {
            assert!(found.is_none(), "{found:?}");
            continue;
        };
        let found = found.expect("a triangle is hit");
        hits += 1;
        // Start and direction are rounded to 4e-7 of a mesh's frame, whose unit is up to 7.5 m, and the distance to
        // 6e-8. Seen at a grazing angle that is more along the ray.
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize();
        let tolerance = (4e-6 + 6e-8 * distance) / normal.dot(along).abs().max(1e-3);
        assert!(
            (f64::from(found.distance) - distance).abs() < tolerance,
            "{} not {distance}",
            found.distance
        );
        assert_eq!((found.object, found.material), (*object, *material));
        let geometric = found.geometric_normal.as_dvec3();
        let front = normal * normal.dot(*before - corners[0]).signum();
        // Unit to single precision; triangles of the world computed in double.
        assert!(geometric.distance(front) < 1e-5, "{geometric} not {front}");
        assert_eq!(found.normal, found.geometric_normal);
        let off = (found.position.as_dvec3() - corners[0]).dot(normal);
        assert!(
            off.abs() < f64::from(found.offset),
            "{off} from the surface, the offset is {}",
            found.offset
        );
    }
    // Otherwise the rays would say little.
    assert!(hits > 1000, "{hits}");
}

#[test]
fn a_mirrored_instance_keeps_its_front_where_the_mirror_takes_it() {
    // Faces +z.
    let shape = Shape {
        positions: [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]].map(|[x, y]| Vec3::new(x, y, 0.0)).to_vec(),
        triangles: vec![[0, 1, 2]],
    };
    let normals = [[[0.0, 0.0, 1.0]; 3]];
    for (scale, front) in [
        (DVec3::new(1.0, 1.0, 1.0), Vec3::Z),
        (DVec3::new(-1.0, 1.0, 1.0), Vec3::Z),
        (DVec3::new(1.0, 1.0, -1.0), -Vec3::Z),
        (DVec3::new(-1.0, -1.0, -1.0), -Vec3::Z),
    ] {
        let at = (DVec3::new(0.2, 0.2, 0.0) * scale).as_vec3();
        for normals in [None, Some(&normals[..])] {
            let scene = alone(&shape, normals, DMat4::from_scale(scale));
            let hit = hit(&scene, at - Vec3::Z, Vec3::Z);
            assert_eq!(hit.geometric_normal, front, "{scale}");
            assert_eq!(hit.normal, front, "{scale}");
        }
    }
}

/// Sizes and places of the world: metres at home, a tenth of a millimetre, and kilometres far away.
fn places(random: &mut Random) -> Vec<DMat4> {
    let mut places = Vec::new();
    for (size, away) in [(1.0, 0.0), (1e-4, 1.0), (1e-4, 0.0), (3e3, 1e6), (1.0, 1e4), (1e-8, 0.0)] {
        for stretch in [DVec3::ONE, DVec3::new(1.0, 1.0, -1.0), DVec3::new(0.05, 1.0, 4.0)] {
            let turn = random.turn();
            let moved = DMat4::from_translation(away * random.direction());
            places.push(moved * turn * DMat4::from_scale(size * stretch) * random.turn());
        }
    }
    places
}

#[test]
fn no_ray_from_inside_a_closed_mesh_escapes_wherever_it_is() {
    let mut random = Random(2);
    let shape = lumpy(4);
    for matrix in places(&mut random) {
        let scene = alone(&shape, None, matrix);
        for i in 0..4000 {
            let from = matrix.transform_point3(0.1 * random.cube()).as_vec3();
            // Two in three at a vertex or at a point of an edge as exactly as single precision allows: there cracks
            // would be.
            let [a, b, _] = shape.corners(random.index(shape.triangles.len())).map(|p| p.as_dvec3());
            let towards = |p: DVec3| (matrix.transform_point3(p) - from.as_dvec3()).normalize();
            let direction = match i % 3 {
                0 => random.direction(),
                1 => towards(a),
                _ => towards(a.lerp(b, 0.5 + 0.5 * random.signed())),
            };
            let hit = cast(&scene, from, direction.as_vec3().normalize(), f32::INFINITY);
            let hit = hit.unwrap_or_else(|| panic!("from {from} along {direction} in {matrix}"));
            let side = hit.geometric_normal.dot(direction.as_vec3());
            assert!(side > -1e-3, "the inside of the mesh is the back of its triangles");
        }
    }
}

#[test]
fn a_ray_that_leaves_a_surface_does_not_meet_it_again() {
    let mut random = Random(3);
    // Convex to rounding: what leaves it outwards never comes back, what leaves it inwards does.
    let shape = icosphere(3);
    for matrix in places(&mut random) {
        let scene = alone(&shape, None, matrix);
        for _ in 0..1000 {
            let from = matrix.transform_point3(0.1 * random.cube()).as_vec3();
            let hit = hit(&scene, from, random.direction().as_vec3().normalize());
            let normal = hit.geometric_normal;
            let direction = random.direction().as_vec3().normalize();
            // Rays along the surface stay within its rounding for long.
            if normal.dot(direction).abs() < 0.05 {
                continue;
            }
            let side = normal.dot(direction).signum();
            let start = hit.position + side * hit.offset * normal;
            let next = cast(&scene, start, direction, f32::INFINITY);
            assert_eq!(next.is_some(), side < 0.0, "{hit:?} {direction} {next:?} in {matrix}");
        }
    }
}

#[test]
fn a_ray_ends_at_its_length() {
    let scene = alone(&icosphere(2), None, DMat4::from_translation(DVec3::new(0.0, 0.0, 5.0)));
    let distance = hit(&scene, Vec3::ZERO, Vec3::Z).distance;
    assert!((distance - 4.0).abs() < 0.1);
    let within = |length: f32| cast(&scene, Vec3::ZERO, Vec3::Z, length).map(|hit| hit.distance);
    assert_eq!(within(1.001 * distance), Some(distance));
    assert_eq!(within(0.999 * distance), None);
    assert_eq!(within(0.0), None);
    assert!(cast(&scene, Vec3::ZERO, -Vec3::Z, f32::INFINITY).is_none());
}

#[test]
fn any_number_of_triangles_or_instances_is_found_from_none_on() {
    // Sheets across x, one behind the other.
    let sheets = |count: usize| Shape {
        positions: (0..count)
            .flat_map(|i| [[-1.0, -1.0], [3.0, -1.0], [-1.0, 3.0]].map(|[y, z]| Vec3::new(i as f32, y, z)))
            .collect(),
        triangles: (0..count as i32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
    };
    for count in 0..70 {
        let in_one_mesh = alone(&sheets(count), None, DMat4::IDENTITY);
        let geometry = Geometry::default();
        let mesh = add(&geometry, &sheets(1), 0, None);
        for i in 0..count {
            let matrix = DMat4::from_translation(DVec3::X * i as f64);
            geometry.add_instance(mesh, &rows(matrix), 0, -1).expect("valid");
        }
        let in_instances = built(&geometry);
        for scene in [in_one_mesh, in_instances] {
            for i in 0..count {
                let hit = hit(&scene, Vec3::new(i as f32 - 0.5, 0.1, 0.1), Vec3::X);
                // A rounding of the place, at most 70.
                assert!((hit.distance - 0.5).abs() < 1e-5, "{i} of {count}: {hit:?}");
            }
            let beyond = cast(&scene, Vec3::new(count as f32, 0.1, 0.1), Vec3::X, f32::INFINITY);
            assert!(beyond.is_none(), "{count}");
        }
    }
}

#[test]
fn triangles_without_area_are_dropped_with_their_materials_and_normals() {
    let geometry = Geometry::default();
    let positions = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];
    // The first is a line, the third a point; their normals are none.
    let triangles = [[0, 1, 0], [0, 1, 2], [3, 3, 3], [1, 3, 2]];
    let nothing = [[0.0; 3]; 3];
    let up = [[0.0, 0.0, 1.0]; 3];
    let tilted = [[0.6, 0.0, 0.8]; 3];
    let arrays = MeshArrays {
        positions: &positions,
        triangles: &triangles,
        materials: &[1, 2, 3, 4],
        normals: Some(&[nothing, up, nothing, tilted]),
    };
    let (mesh, dropped) = geometry.add_mesh(&arrays).expect("valid");
    assert_eq!(dropped, 2);
    geometry.add_instance(mesh, &rows(DMat4::IDENTITY), 5, -1).expect("valid");
    let scene = built(&geometry);
    assert_eq!(scene.triangle_count(), 2);
    let first = hit(&scene, Vec3::new(0.2, 0.2, -1.0), Vec3::Z);
    assert_eq!((first.material, first.normal), (2, Vec3::Z));
    let hit = hit(&scene, Vec3::new(0.8, 0.8, -1.0), Vec3::Z);
    assert_eq!((hit.material, hit.object), (4, 5));
    // Normals of one direction make one direction, to rounding.
    assert!(hit.normal.distance(Vec3::new(0.6, 0.0, 0.8)) < 1e-6);
}

#[test]
fn bounds_hold_all_instances_that_have_triangles() {
    let geometry = Geometry::default();
    let ball = add(&geometry, &icosphere(2), 0, None);
    let nothing =
        add(&geometry, &Shape { positions: vec![Vec3::ZERO; 3], triangles: vec![[0, 1, 2]] }, 0, None);
    for (mesh, x) in [(ball, 3.0), (ball, -4.0), (nothing, 100.0)] {
        let matrix = DMat4::from_translation(DVec3::X * x) * DMat4::from_scale(DVec3::new(1.0, 2.0, -1.0));
        geometry.add_instance(mesh, &rows(matrix), 0, -1).expect("valid");
    }
    let (min, max) = built(&geometry).bounds();
    // The box of an icosphere is a little smaller than that of the sphere: h²/8 for edges of 0.3.
    assert!(min.distance(Vec3::new(-5.0, -2.0, -1.0)) < 0.02, "{min}");
    assert!(max.distance(Vec3::new(4.0, 2.0, 1.0)) < 0.02, "{max}");
}
