//! Cameras of every projection and frame: rays, their differences, what a lens blurs, where points are seen.

use super::*;

/// Askew and off centre, so that no sign or axis can hide.
fn camera() -> Camera {
    let forward = Vec3::new(0.3, -0.5, 0.8).normalize();
    let right = forward.cross(Vec3::Y).normalize();
    let up = right.cross(forward);
    let position = Vec3::new(1.0, 2.0, -3.0);
    let (projection, frame) = (Projection::Perspective, Frame::Middle { half_height: 0.3 });
    Camera {
        position,
        forward,
        right,
        up,
        projection,
        frame,
        width: 96,
        height: 64,
        near: 0.0,
        lens: None,
        is_own: false,
    }
}

/// The same as others, and as a part that shows the same.
fn cameras() -> Vec<Camera> {
    let middle = camera();
    let half_height = 0.3;
    let step = [0.02, 0.015];
    let part = Frame::Part { left: -0.7, top: 0.4, step };
    [Projection::Perspective, Projection::Orthographic, Projection::Equirectangular, FISHEYE]
        .into_iter()
        .flat_map(|projection| {
            [Frame::Middle { half_height }, part].map(|frame| Camera { projection, frame, ..middle })
        })
        .collect()
}

const FISHEYE: Projection = Projection::Fisheye { widest: std::f32::consts::PI };

const POINTS: [(f32, f32); 5] = [(0.5, 0.5), (95.5, 0.5), (10.25, 63.5), (48.0, 32.0), (70.0, 12.0)];

#[test]
fn a_part_of_a_picture_shows_what_the_whole_shows_there() {
    let whole = camera();
    let pixel = 2.0 * 0.3 / 64.0;
    let frame = Frame::Part { left: (13.0 - 48.0) * pixel, top: (32.0 - 5.0) * pixel, step: [pixel; 2] };
    let part = Camera { frame, width: 40, height: 20, ..whole };
    for (x, y) in [(0.0, 0.0), (40.0, 20.0), (7.5, 3.5)] {
        let (found, expected) = (part.direction(x, y), whole.direction(x + 13.0, y + 5.0));
        assert!((found - expected).length() < 3e-7, "{found} for {expected}");
        let (px, py, importance) = part.project(part.position + 3.0 * found).unwrap_or((x, y, 0.0));
        assert!((px - x).abs() < 1e-3 && (py - y).abs() < 1e-3);
        let (_, _, same) = whole.project(part.position + 3.0 * expected).expect("in view");
        assert!(importance == 0.0 || (importance / same - 1.0).abs() < 1e-5);
    }
}

#[test]
fn a_picture_of_another_width_shows_the_same() {
    for camera in cameras() {
        let mut wide = camera;
        wide.set_width(192);
        assert_eq!((wide.width, wide.height), (192, 128));
        for (x, y) in POINTS {
            let (a, b) = (camera.ray(x, y, [0.0; 2]), wide.ray(2.0 * x, 2.0 * y, [0.0; 2]));
            assert!((a.0 - b.0).length() < 1e-6 && (a.1 - b.1).length() < 1e-6, "{camera:?}");
        }
    }
}

#[test]
fn parallel_rays_start_in_a_plane_and_fisheyes_and_maps_of_all_around_measure_angles() {
    let [forward, right, up] = [camera().forward, camera().right, camera().up];
    let of =
        |projection, half_height| Camera { projection, frame: Frame::Middle { half_height }, ..camera() };
    let parallel = of(Projection::Orthographic, 2.0);
    let (origin, direction) = parallel.ray(96.0, 0.0, [0.0; 2]);
    assert_eq!(direction, forward);
    // Half of 2 x 2 high, 3 x 2 wide.
    assert!((origin - (parallel.position + 3.0 * right + 2.0 * up)).length() < 1e-5);

    let half_turn = std::f32::consts::PI;
    let map = Camera { width: 128, ..of(Projection::Equirectangular, 0.5 * half_turn) };
    for (x, y, expected) in [
        (64.0, 32.0, forward),
        (96.0, 32.0, right),
        (32.0, 32.0, -right),
        (0.0, 32.0, -forward),
        (17.0, 0.0, up),
        (90.0, 64.0, -up),
        (64.0, 16.0, (forward + up).normalize()),
    ] {
        assert!((map.direction(x, y) - expected).length() < 1e-6, "({x}, {y})");
    }

    let fisheye = of(FISHEYE, 1.6);
    for (x, y) in POINTS {
        let angle = (x - 48.0).hypot(y - 32.0) * 1.6 / 32.0;
        let direction = fisheye.direction(x, y);
        let outward = ((x - 48.0) * right + (32.0 - y) * up).normalize_or_zero();
        let expected = angle.cos() * forward + angle.sin() * outward;
        assert!((direction - expected).length() < 1e-6, "({x}, {y})");
    }
}

#[test]
fn pixels_of_a_map_of_all_around_cover_the_sphere() {
    let half_height = std::f32::consts::FRAC_PI_2;
    let frame = Frame::Middle { half_height };
    let map = Camera { projection: Projection::Equirectangular, frame, width: 128, ..camera() };
    let area = |pixel: u32| {
        let [right, down] = map.pixel_steps((pixel % 128) as f32 + 0.5, (pixel / 128) as f32 + 0.5);
        f64::from(right.direction.cross(down.direction).length())
    };
    let sum: f64 = (0..128 * 64).map(area).sum();
    // The midpoint rule over the latitude: (π/64)²/24.
    assert!((sum / (4.0 * std::f64::consts::PI) - 1.0).abs() < 2e-4, "{sum}");
}

#[test]
fn steps_are_the_differences_of_rays() {
    for plain in cameras() {
        for camera in [plain, Camera { near: 0.8, ..plain }] {
            for (x, y) in POINTS {
                let (_, direction) = camera.ray(x, y, [0.0; 2]);
                let across = |v: Vec3| v - v.dot(direction) * direction;
                let steps = camera.pixel_steps(x, y);
                for (step, [dx, dy]) in steps.iter().zip([[0.5, 0.0], [0.0, 0.5]]) {
                    let [a, b] = [-1.0, 1.0].map(|s| camera.ray(x + s * dx, y + s * dy, [0.0; 2]));
                    let size = (b.0 - a.0).length().max((b.1 - a.1).length());
                    // Positions of 3 units have roundings of 2e-7, a pixel has a hundredth; its square over 24.
                    assert!((across(b.1 - a.1) - step.direction).length() < 1e-4 * size + 2e-7, "{camera:?}");
                    let moved = across(b.0 - a.0);
                    assert!((moved - across(step.origin)).length() < 1e-4 * size + 6e-7, "{camera:?}");
                }
            }
        }
    }
}

#[test]
fn rays_through_all_of_a_lens_meet_where_it_is_sharp() {
    for plain in cameras() {
        let lens = Lens { radius: 0.3, focus_distance: 2.5, blades: 5, rotation: 0.2, ratio: 0.8 };
        let camera = Camera { lens: Some(lens), ..plain };
        for (x, y) in POINTS {
            let (start, middle) = plain.ray(x, y, [0.0; 2]);
            let sharp = start + 2.5 / plain.depth_along(middle) * middle;
            for [u, v] in [[0.0, 0.0], [0.3, 0.7], [0.99, 0.1], [0.6, 0.5]] {
                let (origin, direction) = camera.ray(x, y, [u, v]);
                let along = (sharp - origin).dot(direction);
                assert!((origin + along * direction - sharp).length() < 2e-6, "{camera:?}");
                assert!((origin - start).length() <= 0.3 / 0.8 + 1e-6, "inside of the lens");
                let axis = if plain.depth_along(middle) == 1.0 { middle } else { plain.forward };
                assert!((origin - start).dot(axis).abs() < 1e-6, "{camera:?}");
                // A near plane cuts the same ray.
                let (cut, same) = Camera { near: 0.7, ..camera }.ray(x, y, [u, v]);
                assert_eq!(same, direction);
                assert!(((cut - start).dot(axis) - 0.7).abs() < 1e-5 || plain.depth_along(middle) == 1.0);
                assert!(((cut - origin).cross(direction)).length() < 1e-6);
            }
        }
    }
}

#[test]
fn what_is_blurred_is_as_wide_as_rays_through_the_lens_are_apart() {
    for plain in cameras() {
        let lens = Lens { radius: 0.05, focus_distance: 2.5, blades: 0, rotation: 0.0, ratio: 0.5 };
        let camera = Camera { lens: Some(lens), ..plain };
        // Straight ahead, seen from the widest place of the lens and from its middle.
        let (x, y) = match camera.frame {
            Frame::Middle { .. } => (48.0, 32.0),
            Frame::Part { left, top, step } => (-left / step[0], top / step[1]),
        };
        let pixel = camera.pixel_steps(x, y);
        for depth in [0.5, 2.5, 10.0] {
            let apart = |v: f32| {
                let (origin, direction) = camera.ray(x, y, [1.0 - f32::EPSILON, v]);
                let place = origin + depth / direction.dot(camera.forward) * direction - camera.position;
                (place - place.dot(camera.forward) * camera.forward).length()
            };
            let widest = apart(0.0).max(apart(0.25));
            let [across, down] = pixel.map(|step| (step.origin + depth * step.direction).length());
            let (found, expected) = (camera.blur(depth), widest / across.min(down));
            // Positions of 3 units have roundings of 2e-7, pixels a hundredth of the depth.
            assert!((found - expected).abs() <= 1e-3 * expected + 2e-4, "{found} for {expected}: {camera:?}");
        }
    }
}

#[test]
fn a_fisheye_is_dark_beyond_its_widest_angle_and_nothing_else_is() {
    for camera in cameras() {
        assert!(POINTS.iter().all(|(x, y)| camera.sees(*x, *y)), "{camera:?}");
    }
    // A circle of 20 pixels around (35, 80/3), as its pixels are no squares: 20 across and 26.67 down.
    let step = [0.02, 0.015];
    let frame = Frame::Part { left: -0.7, top: 0.4, step };
    let camera = Camera { projection: Projection::Fisheye { widest: 0.4 }, frame, ..camera() };
    for (x, y, sees) in [
        (35.0, 26.7, true),
        (15.1, 26.7, true),
        (14.9, 26.7, false),
        (35.0, 53.2, true),
        (35.0, 53.4, false),
        (20.0, 8.0, false),
    ] {
        assert_eq!(camera.sees(x, y), sees, "({x}, {y})");
    }
}

#[test]
fn only_a_pinhole_has_one_place_for_a_point() {
    let lens = Lens { radius: 0.3, focus_distance: 2.5, blades: 0, rotation: 0.0, ratio: 1.0 };
    let point = camera().position + 3.0 * camera().forward;
    assert!(camera().is_pinhole() && camera().project(point).is_some());
    for other in [
        Camera { lens: Some(lens), ..camera() },
        Camera { near: 0.1, ..camera() },
        Camera { projection: Projection::Orthographic, ..camera() },
        Camera { projection: Projection::Equirectangular, ..camera() },
        Camera { projection: FISHEYE, ..camera() },
    ] {
        assert!(!other.is_pinhole() && other.project(point).is_none());
    }
}

#[test]
fn the_middle_of_the_picture_is_straight_ahead_and_its_edges_at_half_the_field_of_view() {
    let camera = camera();
    assert!((camera.direction(48.0, 32.0) - camera.forward).length() < 1e-6);
    let top = camera.direction(48.0, 0.0);
    assert!((top.dot(camera.up) / top.dot(camera.forward) - 0.3).abs() < 1e-6, "up is row 0");
    let right = camera.direction(96.0, 32.0);
    assert!((right.dot(camera.right) / right.dot(camera.forward) - 0.45).abs() < 1e-6, "square pixels");
}

#[test]
fn a_point_projects_to_where_its_direction_came_from() {
    let camera = camera();
    for (x, y) in [(0.5, 0.5), (95.5, 0.5), (10.25, 63.5), (48.0, 32.0), (70.0, 12.0)] {
        let (px, py, _) = camera.project(camera.position + 7.0 * camera.direction(x, y)).expect("in view");
        // f32 positions of a few units, 100 pixels a unit.
        assert!((px - x).abs() < 1e-3 && (py - y).abs() < 1e-3, "({px}, {py}) for ({x}, {y})");
    }
}

#[test]
fn the_importance_is_the_inverse_of_the_pixels_solid_angle() {
    let camera = camera();
    for (x, y) in [(48.5, 32.5), (0.5, 0.5), (90.5, 60.5)] {
        let corner = |dx: f32, dy: f32| camera.direction(x + dx, y + dy).as_dvec3();
        let solid_angle = |a: glam::DVec3, b: glam::DVec3, c: glam::DVec3| {
            // van Oosterom and Strackee (1983), for unit vectors.
            2.0 * (a.dot(b.cross(c)).abs()).atan2(1.0 + a.dot(b) + b.dot(c) + c.dot(a))
        };
        let [a, b, c, d] = [corner(-0.5, -0.5), corner(0.5, -0.5), corner(0.5, 0.5), corner(-0.5, 0.5)];
        let expected = 1.0 / (solid_angle(a, b, c) + solid_angle(a, c, d));
        let (_, _, importance) = camera.project(camera.position + camera.direction(x, y)).expect("in view");
        // The importance varies by 1e-4 over a pixel; the corners' f32 directions add 1e-7 / 0.01.
        assert!((f64::from(importance) / expected - 1.0).abs() < 3e-4, "{importance} against {expected}");
    }
}

#[test]
fn what_is_behind_or_beside_the_picture_is_not_projected() {
    let camera = camera();
    assert!(camera.project(camera.position - camera.forward).is_none());
    assert!(camera.project(camera.position).is_none());
    for (x, y) in [(-0.5, 10.0), (96.5, 10.0), (10.0, -0.5), (10.0, 64.5)] {
        assert!(camera.project(camera.position + camera.direction(x, y)).is_none());
    }
}
