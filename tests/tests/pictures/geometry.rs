//! Rays against spheres, rectangles and boxes: the hit must satisfy the surface's own equation, at every scale
//! and distance from the origin.

use super::shapes::{Random, deformed, globe, scene_of};
use covbeam_session::scene::nest;
use covbeam_session::scene::{Material, Scene, Shape};
use glam::{DVec3, Vec3};

const GLASS: Material = Material::Dielectric { index: 1.5 };

/// Sizes and places: ordinary, tiny, and as far away as f32 can still resolve the size to 1e-3.
const FRAMES: [(f32, Vec3); 4] = [
    (1.0, Vec3::ZERO),
    (1e-4, Vec3::new(2e-4, -1e-4, 5e-5)),
    (1e6, Vec3::new(1e6, 2e6, -3e6)),
    (100.0, Vec3::new(1e6, 1e6, -1e6)),
];

fn sphere(size: f32, at: Vec3) -> Shape {
    Shape::Sphere { center: at, radius: size }
}

fn cuboid(size: f32, at: Vec3) -> Shape {
    Shape::Box { min: at - size * Vec3::new(1.0, 0.5, 0.7), max: at + size * Vec3::new(0.6, 1.0, 0.9) }
}

fn rectangle(size: f32, at: Vec3) -> Shape {
    let (edge_u, edge_v) = (size * Vec3::new(1.3, 0.2, -0.4), size * Vec3::new(-0.3, 1.1, 0.5));
    Shape::Rectangle { corner: at - 0.5 * (edge_u + edge_v), edge_u, edge_v }
}

fn alone(shape: Shape, material: Material) -> Scene {
    scene_of(vec![(shape, material)])
}

/// Signed distance from the surface, positive outside; for a rectangle from its plane.
fn surface_distance(shape: &Shape, p: DVec3) -> f64 {
    match shape {
        Shape::Sphere { center, radius } => (p - center.as_dvec3()).length() - f64::from(*radius),
        Shape::Box { min, max } => {
            let outside = (min.as_dvec3() - p).max(p - max.as_dvec3());
            outside.max(DVec3::ZERO).length() + outside.max_element().min(0.0)
        }
        Shape::Rectangle { corner, edge_u, edge_v } => {
            (p - corner.as_dvec3()).dot(edge_u.as_dvec3().cross(edge_v.as_dvec3()).normalize())
        }
        Shape::Mesh(_) => unreachable!("not used here"),
    }
}

#[test]
fn a_hit_lies_on_the_surface_and_on_the_ray() {
    let mut random = Random(1);
    for (size, at) in FRAMES {
        for shape in [sphere(size, at), cuboid(size, at), rectangle(size, at)] {
            let scene = alone(shape.clone(), Material::Black);
            let mut hits = 0;
            for _ in 0..20_000 {
                let from = (at.as_dvec3() + 3.0 * f64::from(size) * random.cube()).as_vec3();
                let direction = random.direction();
                let Some(hit) = scene.intersect(from, direction, f32::INFINITY) else { continue };
                hits += 1;
                // Rounding of the position to f32 and nothing else: half a unit in the last place a coordinate.
                let ulp = f64::from(f32::EPSILON) * f64::from(hit.position.abs().max_element());
                let off = surface_distance(&shape, hit.position.as_dvec3()).abs();
                assert!(off <= ulp + 1e-12 * f64::from(size), "{shape:?}: {off:e} off the surface");
                // Rounding of the distance and of the direction's length as well, over at most 10 sizes; and
                // at a box's edges 4 units in the last place along both other axes (see `leave`).
                let on_ray = from.as_dvec3() + f64::from(hit.distance) * direction.as_dvec3();
                let aside = (on_ray - hit.position.as_dvec3()).length();
                assert!(aside <= 8.0 * ulp + 3e-6 * f64::from(size), "{shape:?}: {aside:e} off the ray");
                assert!((hit.geometric_normal.length() - 1.0).abs() < 1e-6);
                assert_eq!(hit.normal, hit.geometric_normal);
            }
            assert!(hits > 200, "{shape:?} was hit {hits} times: the test tests nothing");
        }
    }
}

#[test]
fn a_sphere_is_hit_exactly_when_the_line_passes_its_centre_within_the_radius() {
    let mut random = Random(2);
    for (size, at) in FRAMES {
        let scene = alone(sphere(size, at), Material::Black);
        for _ in 0..20_000 {
            // From a thousand radii away the quadratic's textbook f32 form loses all digits.
            let from = (at.as_dvec3() + 1e3 * f64::from(size) * random.direction().as_dvec3()).as_vec3();
            let target = at.as_dvec3() + 1.5 * f64::from(size) * random.cube();
            let direction = (target - from.as_dvec3()).normalize().as_vec3();
            let along = direction.as_dvec3().normalize();
            let aside = (at.as_dvec3() - from.as_dvec3()).cross(along).length() / f64::from(size);
            // f64 decides everything but a band of 1e-9.
            if (aside - 1.0).abs() > 1e-9 {
                let hit = scene.intersect(from, direction, f32::INFINITY);
                assert_eq!(hit.is_some(), aside < 1.0, "{aside}");
            }
        }
    }
}

#[test]
fn the_nearest_surface_wins_and_max_distance_ends_the_ray() {
    let scene = scene_of(vec![
        (sphere(1.0, Vec3::Z * 5.0), Material::Black),
        (sphere(1.0, Vec3::Z * 2.0), Material::Black),
        (cuboid(20.0, Vec3::ZERO), Material::Black),
    ]);
    let hit = scene.intersect(Vec3::ZERO, Vec3::Z, f32::INFINITY).expect("a sphere is ahead");
    assert_eq!((hit.object, hit.distance), (1, 1.0));
    assert!(scene.intersect(Vec3::ZERO, Vec3::Z, 1.0).is_none(), "the end is not part of the ray");
    assert!(scene.intersect(Vec3::ZERO, Vec3::Z, 1.001).is_some());
    let inside = scene.intersect(Vec3::ZERO, Vec3::X, f32::INFINITY).expect("the box is around");
    assert_eq!((inside.object, inside.geometric_normal), (2, Vec3::X), "outward also when seen from inside");
}

#[test]
fn a_ray_that_leaves_a_surface_does_not_hit_it_again_at_once() {
    let mut random = Random(3);
    for (size, at) in FRAMES {
        for shape in [sphere(size, at), cuboid(size, at), rectangle(size, at)] {
            let scene = alone(shape.clone(), Material::Black);
            let mut tried = 0;
            while tried < 20_000 {
                let from = (at.as_dvec3() + 3.0 * f64::from(size) * random.cube()).as_vec3();
                let Some(hit) = scene.intersect(from, random.direction(), f32::INFINITY) else { continue };
                tried += 1;
                // As grazing as 1e-6, to both sides.
                let cosine = (10.0f64.powf(-6.0 * random.unit()) as f32).copysign(random.unit() as f32 - 0.5);
                let tangent = hit.normal.cross(random.direction()).normalize();
                let direction = (tangent + cosine * hit.normal).normalize();
                let again = scene.intersect(hit.leave(direction), direction, f32::INFINITY);
                let inwards = direction.dot(hit.geometric_normal) < 0.0;
                match &shape {
                    // Convex: outwards nothing, inwards the far side.
                    Shape::Sphere { .. } | Shape::Box { .. } if inwards => {
                        assert!(again.is_some(), "{shape:?}: lost from {} along {direction}", hit.position);
                    }
                    _ => assert!(again.is_none(), "{shape:?}: hit itself after leaving {}", hit.position),
                }
            }
        }
    }
}

#[test]
fn a_chord_of_a_sphere_has_its_length() {
    let mut random = Random(4);
    for (size, at) in FRAMES {
        let scene = alone(sphere(size, at), GLASS);
        for _ in 0..10_000 {
            let from = at + 3.0 * size * random.direction();
            let Some(hit) = scene.intersect(from, random.direction(), f32::INFINITY) else { continue };
            let inward = -(hit.normal + 0.999 * random.direction()).normalize();
            let far = scene.intersect(hit.leave(inward), inward, f32::INFINITY).expect("inside a sphere");
            let chord = 2.0 * size * hit.normal.dot(-inward);
            // The start may be off by a few units in the last place of the position, which a grazing direction
            // (cosine down to 0.03 here) stretches.
            let slack =
                40.0 * f32::EPSILON * far.position.abs().max_element().max(size) / hit.normal.dot(-inward);
            assert!((far.distance - chord).abs() <= slack, "{} against {chord}", far.distance);
        }
    }
}

#[test]
fn light_that_bounces_inside_a_closed_shape_never_gets_out() {
    let mut random = Random(5);
    for (size, at) in FRAMES {
        for shape in [sphere(size, at), cuboid(size, at)] {
            let scene = alone(shape.clone(), GLASS);
            let (mut from, mut direction) = (at, random.direction());
            for bounce in 0..50_000 {
                let hit = scene.intersect(from, direction, f32::INFINITY);
                let hit = hit.unwrap_or_else(|| panic!("{shape:?}: out after {bounce} bounces"));
                direction = (0.999 * random.direction() - hit.geometric_normal).normalize();
                from = hit.leave(direction);
            }
        }
    }
}

#[test]
fn only_what_lies_strictly_between_two_points_occludes() {
    let scene = scene_of(vec![
        (sphere(0.5, Vec3::ZERO), GLASS),
        (rectangle(1.0, Vec3::X * 10.0), Material::Black),
        (
            Shape::Mesh(
                covbeam_geometry::mesh::Mesh::new(
                    deformed(globe(16), |p| p + Vec3::Y * 10.0),
                    &Default::default(),
                    true,
                )
                .expect("valid"),
            ),
            GLASS,
        ),
    ]);
    assert!(scene.occluded(Vec3::Y * -2.0, Vec3::Y * 2.0));
    assert!(!scene.occluded(Vec3::Y * -2.0, Vec3::Y * -0.51), "the sphere lies beyond");
    assert!(!scene.occluded(Vec3::Y * 2.0, Vec3::new(0.0, 2.0, 5.0)));
    assert!(scene.occluded(Vec3::X * 9.0, Vec3::X * 11.0));
    assert!(scene.occluded(Vec3::Y * 12.0, Vec3::Y * 8.0));
    assert!(scene.occluded(Vec3::Y * 10.0, Vec3::Y * 12.0), "from inside the mesh");
    assert!(!scene.occluded(Vec3::Y * 10.0, Vec3::Y * 10.5), "inside the mesh");
    assert!(!scene.occluded(Vec3::ONE, Vec3::ONE));
}

#[test]
fn two_points_on_a_surface_see_each_other_past_it() {
    let scene = alone(sphere(1.0, Vec3::ZERO), Material::Black);
    let hit = scene.intersect(Vec3::Y * 3.0, -Vec3::Y, f32::INFINITY).expect("ahead");
    let light = Vec3::new(0.5, 5.0, 0.3);
    let to_light = (light - hit.position).normalize();
    assert!(!scene.occluded(hit.leave(to_light), light));
    assert!(scene.occluded(hit.leave(-to_light), Vec3::Y * -5.0), "through the ball");
}

#[test]
fn shapes_around_a_point_are_known_and_what_lies_inside_of_which() {
    let mesh = |size: f32| {
        let source = deformed(globe(24), |p| size * p);
        Shape::Mesh(covbeam_geometry::mesh::Mesh::new(source, &Default::default(), true).expect("valid"))
    };
    let cube = |half: f32| Shape::Box { min: Vec3::splat(-half), max: Vec3::splat(half) };
    let mut scene = scene_of(vec![
        (sphere(1.0, Vec3::ZERO), GLASS),
        (cube(4.0), GLASS),
        (cube(9.0), Material::Black),
        (mesh(2.0), GLASS),
        (sphere(0.5, Vec3::X * 3.0), GLASS),
        // As large as the second, sticking out of the third, and of the ball.
        (cube(4.0), GLASS),
        (sphere(0.5, Vec3::X * 1.75), GLASS),
        (cube(0.6), GLASS),
    ]);
    nest(&mut scene.objects);
    let containing = |place: Vec3| scene.containing(place).collect::<Vec<u32>>();
    assert_eq!(containing(Vec3::new(0.1, 0.2, 0.3)), [0, 1, 3, 5, 7]);
    assert_eq!(containing(Vec3::new(0.0, 1.5, 0.0)), [1, 3, 5]);
    assert_eq!(containing(Vec3::new(3.0, 0.1, 0.0)), [1, 4, 5]);
    assert_eq!(containing(Vec3::splat(5.0)), [0u32; 0], "black walls hold no medium");
    // The corners of the smallest cube are 1.04 from the middle.
    let inner: Vec<&[u32]> = scene.objects.iter().map(|object| &object.inner[..]).collect();
    let all: &[u32] = &[0, 3, 4, 6, 7];
    assert_eq!(inner, [&[], all, &[], &[0, 7], &[], all, &[], &[]] as [&[u32]; 8]);
}

#[test]
fn a_sphere_curves_by_its_radius_and_a_plane_not_at_all() {
    for (size, at) in FRAMES {
        let from = at - 3.0 * size * Vec3::Z;
        let ball = alone(sphere(size, at), GLASS).intersect(from, Vec3::Z, f32::INFINITY).expect("ahead");
        let curvature = ball.curvature;
        assert_eq!((curvature.along, curvature.across, curvature.twist), (1.0 / size, 1.0 / size, 0.0));
        assert!(
            curvature.tangent.dot(ball.normal).abs() < 1e-6
                && (curvature.tangent.length() - 1.0).abs() < 1e-6
        );
        for shape in [cuboid(size, at), rectangle(size, at)] {
            let hit = alone(shape, Material::Black).intersect(from, Vec3::Z, f32::INFINITY).expect("ahead");
            let curvature = hit.curvature;
            assert_eq!((curvature.along, curvature.across, curvature.twist), (0.0, 0.0, 0.0));
        }
    }
}

#[test]
fn a_ray_along_an_edge_or_through_a_corner_of_a_box_is_never_nan() {
    let scene = alone(Shape::Box { min: -Vec3::ONE, max: Vec3::ONE }, GLASS);
    // On a face's plane, along an edge, through two corners.
    for (from, direction) in [
        (Vec3::new(1.0, 0.0, -3.0), Vec3::Z),
        (Vec3::new(1.0, 1.0, -3.0), Vec3::Z),
        (Vec3::splat(-3.0), Vec3::ONE.normalize()),
    ] {
        if let Some(hit) = scene.intersect(from, direction, f32::INFINITY) {
            assert!(hit.distance.is_finite() && hit.position.is_finite() && hit.normal.is_normalized());
        }
    }
}
