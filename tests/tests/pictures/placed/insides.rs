//! What rays are inside of, by what is known of cubes and balls.

use super::scenes::{
    Part, ball, block, bound, camera, cube, glass, inverted, lamp, medium, part, placed, scene, sheet, volume,
};
use covbeam_session::eye::starts::EyeStarts;
use covbeam_session::medium::fogs::FogSum;
use covbeam_session::scene::optics::Interior;
use covbeam_session::scene::{Material, Scene};
use covbeam_tests::random::Stream;
use glam::{DMat4, DVec3, Vec3};

fn text(media: u32) -> String {
    let media: String = (0..media).map(|number| medium(&format!("fog {number}"), 0.1, 0.0)).collect();
    [camera([0.0, 0.0, -9.0], [0.0; 3], 40.0, 8), lamp([0.0, 5.0, 0.0], 1.0), media].concat()
}

/// The medium at a place, and whether it is inside of glass.
fn at(scene: &Scene, place: Vec3) -> (Option<u32>, bool) {
    told(scene, Interior::at(scene, place))
}

fn told(scene: &Scene, interior: Interior) -> (Option<u32>, bool) {
    let region = interior.medium(scene);
    // Regions outside and inside of glass follow each other.
    let sides = scene.region_count() as u32 / scene.media.len() as u32;
    (region.map(|region| region / sides), region.is_some_and(|region| scene.is_in_glass(region)))
}

fn large_and_small() -> (Vec<Part>, Vec<covbeam_session::medium::fogs::FogVolume>) {
    let parts = vec![
        bound(block(2.0, Vec3::ZERO), 0),
        bound(block(1.0, Vec3::ZERO), 1),
        part(ball(0.3, Vec3::new(0.0, 0.0, 1.5), 16), glass()),
    ];
    (parts, vec![volume(0, Vec3::splat(-2.0), Vec3::splat(2.0)), volume(1, Vec3::NEG_ONE, Vec3::ONE)])
}

#[test]
fn the_smallest_volume_around_a_place_counts_and_fog_goes_on_in_glass() {
    let (parts, volumes) = large_and_small();
    let scene = scene(&text(2), &parts, volumes);
    assert_eq!(at(&scene, Vec3::ZERO), (Some(1), false));
    assert_eq!(at(&scene, Vec3::X * 1.5), (Some(0), false));
    assert_eq!(at(&scene, Vec3::X * 3.0), (None, false));
    assert_eq!(at(&scene, Vec3::Z * 1.5), (Some(0), true));
    assert_eq!(scene.region_count(), 4, "outside and inside of glass");
}

#[test]
fn a_sum_of_volumes_counts_where_these_are_and_no_others() {
    let (parts, volumes) = large_and_small();
    let mut scene = scene(&text(3), &[], Vec::new());
    scene.placed = Some(placed(&parts, volumes, &[FogSum { parts: vec![0, 1], medium: 2 }]));
    assert_eq!(at(&scene, Vec3::ZERO).0, Some(2));
    assert_eq!(at(&scene, Vec3::X * 1.5).0, Some(0));
    assert_eq!(at(&scene, Vec3::X * 3.0).0, None);
}

/// Balls and cubes that overlap and hold each other, in any order, each in a medium of its own: a place is in the smallest that holds it,
/// found from the place itself and along a straight line from any other.
#[test]
fn insides_are_those_of_the_shapes_from_a_place_itself_and_along_a_line_to_it() {
    let mut random = Stream::new(8);
    let mut point =
        move |reach: f64| Vec3::from_array([(); 3].map(|()| random.between(-reach, reach) as f32));
    let mut stream = Stream::new(9);
    // Middle, half of the width, and whether it is a ball.
    let shapes: Vec<(Vec3, f32, bool)> =
        (0..12).map(|number| (point(1.0), stream.between(0.2, 1.5) as f32, number % 2 == 0)).collect();
    let parts: Vec<Part> = shapes
        .iter()
        .zip(0..)
        .map(|(&(center, half, is_ball), fog)| {
            bound(if is_ball { ball(half.into(), center, 40) } else { block(half, center) }, fog)
        })
        .collect();
    let volumes =
        shapes.iter().zip(0..).map(|(&(center, half, _), fog)| volume(fog, center - half, center + half));
    let scene = scene(&text(12), &parts, volumes.collect());
    let size = |&(_, half, _): &(Vec3, f32, bool)| half;
    // None: too near to a border to tell.
    let expected = |place: Vec3| {
        let mut inside = Vec::new();
        for (number, &(center, half, is_ball)) in shapes.iter().enumerate() {
            let away = place - center;
            let far = if is_ball { away.length() } else { away.abs().max_element() };
            if (far - half).abs() < 0.01 {
                return None;
            }
            inside.extend((far < half).then_some(number));
        }
        let smallest = inside.into_iter().min_by(|&a, &b| size(&shapes[a]).total_cmp(&size(&shapes[b])));
        Some(smallest.map(|number| number as u32))
    };
    let (mut told_places, mut filled, mut from) = (0, 0, None);
    for _ in 0..3000 {
        let place = point(2.0);
        let Some(medium) = expected(place) else { continue };
        assert_eq!(at(&scene, place).0, medium, "{place}");
        if let Some(from) = from {
            let moved = Interior::at(&scene, from).moved(&scene, from, place);
            assert_eq!(told(&scene, moved).0, medium, "from {from} to {place}");
            assert_eq!(moved, Interior::at(&scene, place), "from {from} to {place}");
        }
        from = Some(place);
        told_places += 1;
        filled += usize::from(medium.is_some());
    }
    assert!(told_places > 2000 && filled > 800, "{told_places}, {filled}");
}

#[test]
fn mirrored_fog_is_inside_of_its_bound() {
    for mirror in [DVec3::new(-1.0, 1.0, 1.0), DVec3::new(-1.0, -1.0, -1.0), DVec3::ONE] {
        let box_of_fog = Part { transform: DMat4::from_scale(mirror), ..bound(block(1.0, Vec3::ZERO), 0) };
        let scene = scene(&text(1), &[box_of_fog], vec![volume(0, Vec3::NEG_ONE, Vec3::ONE)]);
        let far = Vec3::new(9.0, 8.0, 7.0);
        for (place, expected) in [
            (Vec3::new(0.3, 0.2, -0.1), Some(0)),
            (Vec3::new(1.3, 0.0, 0.0), None),
            (Vec3::new(-3.0, 0.0, 0.0), None),
        ] {
            assert_eq!(at(&scene, place).0, expected, "{mirror} {place}");
            let moved = Interior::default().moved(&scene, far, place);
            assert_eq!(told(&scene, moved).0, expected, "{mirror} {place}");
        }
    }
}

/// A camera on a bound is on the side that it looks to.
#[test]
fn a_camera_on_a_bound_is_where_it_looks() {
    let mut scene = scene(&text(1), &[part_of_fog()], vec![volume(0, Vec3::NEG_ONE, Vec3::ONE)]);
    // Where the bound is, drawn in by a hair.
    let face = 1.0 - 1.0 / (1 << 18) as f32;
    for place in [Vec3::new(face, 0.3, 0.2), Vec3::new(-face, 0.1, -0.4), Vec3::new(0.2, face, 0.0)] {
        let axis = if place.y == face { Vec3::Y } else { Vec3::X };
        for direction in [axis, -axis, Vec3::new(0.6, 0.64, 0.48), Vec3::new(-0.6, -0.64, -0.48)] {
            (scene.camera.position, scene.camera.forward) = (place, direction);
            let start = EyeStarts::new(&scene).at([4.0, 4.0], [0.0; 2]);
            let ahead = place + 1e-3 * start.direction;
            let is_inside = ahead.abs().max_element() < face;
            assert!((start.origin - place).length() < 4e-6, "{place} {}", start.origin);
            assert_eq!(told(&scene, start.interior).0.is_some(), is_inside, "{place} {direction}");
            // Nothing is met that is behind.
            assert!(scene.intersect(start.origin, start.direction, 1e-3).is_none(), "{place} {direction}");
        }
    }
}

fn part_of_fog() -> Part {
    bound(block(1.0, Vec3::ZERO), 0)
}

/// A cube of glass has an inside, seen from there and from outside; a pane without thickness has none, whichever way it is turned.
#[test]
fn closed_glass_has_an_inside_and_a_pane_without_thickness_none() {
    let mut haze = scene(&["outside_medium = \"fog 0\"\n", &text(1)].concat(), &[], Vec::new());
    haze.placed = Some(placed(&[part(block(1.0, Vec3::ZERO), glass())], Vec::new(), &[]));
    assert_eq!(at(&haze, Vec3::new(0.3, 0.1, 0.2)), (Some(0), true));
    assert_eq!(at(&haze, Vec3::new(1.3, 0.1, 0.2)), (Some(0), false));
    let moved = Interior::default().moved(&haze, Vec3::new(5.0, 4.0, 3.0), Vec3::ZERO);
    assert_eq!(told(&haze, moved), (Some(0), true));
    let pane = sheet(Vec3::new(-9.0, -9.0, 0.5), Vec3::X * 18.0, Vec3::Y * 18.0);
    for mesh in [pane.clone(), inverted(pane)] {
        haze.placed = Some(placed(&[Part { is_closed: false, ..part(mesh, glass()) }], Vec::new(), &[]));
        for place in [Vec3::ZERO, Vec3::Z] {
            assert_eq!(at(&haze, place), (Some(0), false));
            let moved = Interior::default().moved(&haze, Vec3::new(0.1, 0.2, 1.0 - place.z), place);
            assert_eq!(told(&haze, moved), (Some(0), false));
        }
        assert_eq!(haze.region_count(), 1, "there is no inside of glass");
    }
}

/// Fog in a glass, and glass that is filled: both at once.
#[test]
fn glass_may_be_filled_with_fog_of_its_own() {
    let filled = Part { fog: Some(0), ..part(block(1.0, Vec3::ZERO), glass()) };
    let scene = scene(&text(1), &[filled], vec![volume(0, Vec3::NEG_ONE, Vec3::ONE)]);
    assert_eq!(at(&scene, Vec3::ZERO), (Some(0), true));
    assert_eq!(at(&scene, Vec3::X * 2.0), (None, false));
}

/// Numbers that mean nothing are refused, with what is wrong.
#[test]
fn materials_objects_and_volumes_that_are_not_there_are_refused() {
    use covbeam_session::medium::fogs::AddedFogs;
    use covbeam_session::object::geometry::Surfaces;
    use covbeam_session::object::placed::{Placed, PlacedError, PlacedObject};
    let good = placed(&[part(cube(Vec3::ZERO, Vec3::ONE), Material::Black)], Vec::new(), &[]);
    let Surfaces::Built(instances) = good.surfaces() else { panic!("meshes") };
    let instances = || std::sync::Arc::clone(instances);
    let object = PlacedObject::default();
    let fogs = AddedFogs::default;
    let error = |materials: Vec<Material>, objects: Vec<PlacedObject>| {
        Placed::new(instances(), materials, objects, fogs()).expect_err("refused")
    };
    assert_eq!(error(vec![], vec![object]), PlacedError::Material(0, 0));
    assert_eq!(error(vec![Material::Black], vec![]), PlacedError::Object(0, 0));
    let filled = PlacedObject { fog: Some(3), ..object };
    assert_eq!(
        error(vec![Material::Black], vec![filled]).to_string(),
        "object 0 is filled with the volume 3, and there are 0"
    );
}
