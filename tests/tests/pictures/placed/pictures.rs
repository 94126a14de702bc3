//! Pictures of fog in parts, of panes, and of placed geometry against the same scenes by other ways.

use super::scenes::{
    Part, ball, block, bound, camera, cube, inverted, lamp, lobes, medium, part, scene, sheet, volume,
};
use covbeam::GridLayout;
use covbeam_session::medium::volume::Volume;
use covbeam_session::pass::Renderer;
use covbeam_session::paths::{PhotonRecord, PhotonTracer, Record};
use covbeam_session::random::Emission;
use covbeam_session::scene::{Lobes, Material, MediumDensity, Scene, Sees};
use covbeam_session::settings::{Method, Settings};
use covbeam_tests::statistics::Sample;
use glam::Vec3;
use std::ops::Range;

/// Mean radiance of the picture's passes for some seeds; straight light by shadow rays, other light by guided paths.
fn guided(scene: &Scene, seeds: Range<u32>, passes: u32) -> Vec<f64> {
    means(seeds, passes, |seed| {
        Renderer::new(scene, Settings { planned: false, ..Settings::of_scene(Method::Covbeam, scene, seed) })
    })
}

/// The same by connections of paths with the camera, which have no kernels, no shadow rays along eye rays and no guidance.
fn traced(scene: &Scene, photons: u32, seeds: u32) -> Vec<f64> {
    means(100..100 + seeds, 1, |seed| Renderer::new(scene, Settings::of(Method::LightTrace, photons, seed)))
}

fn means<'a>(seeds: Range<u32>, passes: u32, make: impl Fn(u32) -> Renderer<'a>) -> Vec<f64> {
    let mean = |seed| {
        let mut renderer = make(seed);
        let mut of_pass = |pass| {
            let (image, _) = renderer.pass(pass, &|| false).expect("not cancelled");
            let sum: f64 = image.radiance.iter().map(|color| f64::from(color.element_sum()) / 3.0).sum();
            sum / image.radiance.len() as f64
        };
        (1..=passes).map(&mut of_pass).sum::<f64>() / f64::from(passes)
    };
    seeds.map(mean).collect()
}

/// - `bias`: what may be wrong; `most`: four standard errors of the difference may be this at most, all relative.
fn agree(name: &str, found: &[f64], expected: &[f64], bias: f64, most: f64) {
    let [of, against] = [found, expected].map(Sample::of);
    judge(name, of.mean / against.mean - 1.0, of.error.hypot(against.error) / against.mean, bias, most);
}

/// The same of scenes in which paths of the same numbers do the same: only what differs of them, seed by seed, is noise.
fn agree_path_by_path(name: &str, found: &[f64], expected: &[f64], bias: f64, most: f64) {
    assert_eq!(found.len(), expected.len());
    let mean = Sample::of(expected).mean;
    let changes: Vec<f64> = found.iter().zip(expected).map(|(a, b)| (a - b) / mean).collect();
    let Sample { mean: change, error, .. } = Sample::of(&changes);
    judge(name, change, error, bias, most);
}

fn judge(name: &str, change: f64, error: f64, bias: f64, most: f64) {
    let noise = 4.0 * error;
    println!("{name}: {change:+.4} ± {noise:.4}");
    // NaN, where nothing is seen, is too much.
    assert!(noise < most, "{name}: noise of {noise} hides all");
    assert!(change.abs() < bias + noise, "{name}: {change}, noise {noise}");
}

fn text(media: &str) -> String {
    [&camera([0.0, 0.0, -4.0], [0.0; 3], 40.0, 16), &lamp([1.3, 1.1, 0.9], 10.0), media].concat()
}

fn fog() -> String {
    medium("fog", 0.3, 0.1)
}

/// Cubes of the same fog.
fn fogs(boxes: &[(Vec3, Vec3)], media: &str) -> Scene {
    let parts: Vec<Part> =
        boxes.iter().zip(0..).map(|(&(min, max), fog)| bound(cube(min, max), fog)).collect();
    scene(&text(media), &parts, boxes.iter().map(|&(min, max)| volume(0, min, max)).collect())
}

const WHOLE: (Vec3, Vec3) = (Vec3::NEG_ONE, Vec3::ONE);

/// Halves that touch are those of the cloud below.
fn parts() -> [(&'static str, Vec<(Vec3, Vec3)>); 3] {
    let v = Vec3::new;
    [
        ("overlapping", vec![(WHOLE.0, v(0.4, 1.0, 1.0)), (v(-0.3, -1.0, -1.0), WHOLE.1)]),
        ("nested on the same floor", vec![WHOLE, (v(-0.5, -1.0, -0.5), Vec3::splat(0.5))]),
        ("twice", vec![WHOLE, WHOLE]),
    ]
}

#[test]
fn a_part_within_or_overlaps_are_one_piece_of_fog() {
    let expected = guided(&fogs(&[WHOLE], &fog()), 0..8, 2);
    for (name, boxes) in parts() {
        // Kernels end at bounds, which costs some of them their shape.
        agree(name, &guided(&fogs(&boxes, &fog()), 0..8, 2), &expected, 0.01, 0.05);
    }
}

/// The bound as a shape of a scene file: a dielectric that bends nothing.
#[test]
fn fog_in_a_placed_cube_is_that_in_a_box() {
    let object = "[[object]]\nshape = \"box\"\nmin = [-1, -1, -1]\nmax = [1, 1, 1]\nmaterial = { dielectric = { index = 1 } }\n\
        inside = \"fog\"\n";
    let expected = scene(&text(&[&fog(), object].concat()), &[], Vec::new());
    agree("box", &guided(&fogs(&[WHOLE], &fog()), 0..8, 3), &guided(&expected, 0..8, 3), 0.005, 0.05);
}

/// Of straight light, which has next to no noise.
#[test]
fn fog_within_the_same_fog_changes_nothing_wherever_lamp_and_camera_are() {
    // The lamp is out of the picture: beside it fog is as bright as one looks closely.
    let view = camera([0.0, 0.0, -4.0], [0.0; 3], 40.0, 16);
    let world = ["outside_medium = \"fog\"\n", &view, &lamp([1.3, 2.8, 0.9], 10.0), &fog()].concat();
    let picture = |parts: &[Part], volumes| {
        let mut scene = scene(&world, parts, volumes);
        scene.settings.bounces = Some(0);
        guided(&scene, 0..4, 3)
    };
    let expected = picture(&[], Vec::new());
    for half in [Vec3::ONE, Vec3::splat(2.0), Vec3::new(2.0, 4.0, 6.0)] {
        let (min, max) = (-half, half);
        let found = picture(&[bound(cube(min, max), 0)], vec![volume(0, min, max)]);
        agree_path_by_path(&format!("{half}"), &found, &expected, 0.002, 0.005);
    }
}

/// A coloured cloud of voxels, whole and in two halves, each with a bound and a medium of its own. What gets
/// through the first half is another colour then.
#[test]
fn light_goes_on_from_one_half_of_a_cloud_into_the_other() {
    let layout = GridLayout { min: Vec3::NEG_ONE, max: Vec3::ONE, cells: [8; 3] };
    let values = (0..512).map(|i| {
        let place = Vec3::new((i % 8) as f32, (i / 8 % 8) as f32, (i / 64) as f32) / 3.5 - 1.0;
        (-3.0 * (place - Vec3::new(-0.3, 0.2, 0.0)).length_squared()).exp()
    });
    let density = MediumDensity::Grid(Volume { layout, values: values.collect() });
    let cloud = |boxes: &[(Vec3, Vec3)]| {
        let media = [medium("left", 0.0, 0.1), medium("right", 0.0, 0.1)].concat();
        let mut scene = fogs(boxes, &media);
        let volumes = boxes.iter().zip(0..).map(|(&(min, max), fog)| volume(fog, min, max)).collect();
        let parts: Vec<Part> =
            boxes.iter().zip(0..).map(|(&(min, max), fog)| bound(cube(min, max), fog)).collect();
        scene.placed = Some(super::scenes::placed(&parts, volumes, &[]));
        for medium in &mut scene.media {
            medium.medium.scattering = Vec3::new(4.0, 1.5, 0.5);
            medium.density = density.clone();
        }
        scene
    };
    let halves = [(WHOLE.0, Vec3::new(0.0, 1.0, 1.0)), (Vec3::new(0.0, -1.0, -1.0), WHOLE.1)];
    let [found, expected] = [&halves[..], &[WHOLE]].map(|boxes| guided(&cloud(boxes), 0..8, 2));
    agree_path_by_path("cloud", &found, &expected, 0.015, 0.1);
}

#[test]
fn fog_whose_bound_is_seen_edge_on_is_there() {
    let view = |y: f32| {
        let text =
            [&camera([0.0, y, -4.0], [0.0, y, 0.0], 40.0, 16), &lamp([1.3, 1.1, 0.9], 10.0), &fog()[..]]
                .concat();
        guided(&scene(&text, &[bound(block(1.0, Vec3::ZERO), 0)], vec![volume(0, WHOLE.0, WHOLE.1)]), 0..8, 3)
    };
    // The camera lies in the plane of the upper face, and two thousandths above it.
    agree_path_by_path("edge on", &view(1.0), &view(1.002), 0.01, 0.02);
}

/// Fog on a floor gets the light that the floor sends back. The same paths but for a millimetre.
#[test]
fn fog_that_stands_on_a_floor_keeps_the_light_that_the_floor_sends_back() {
    let floor = Material::Lambert { albedo: Vec3::splat(0.8) };
    let text =
        [&camera([0.0, 0.5, -4.0], [0.0, -0.6, 0.0], 40.0, 16), &lamp([0.3, 0.4, 0.2], 10.0), &fog()[..]]
            .concat();
    let plane = sheet(Vec3::new(-2.0, -1.0, -2.0), Vec3::Z * 4.0, Vec3::X * 4.0);
    let found = [-1.0, -0.999].map(|bottom| {
        let min = Vec3::new(-1.0, bottom, -1.0);
        let parts = [bound(cube(min, Vec3::ONE), 0), part(plane.clone(), floor)];
        let mut scene = scene(&text, &parts, vec![volume(0, min, Vec3::ONE)]);
        scene.sees = Sees::FogAlone;
        guided(&scene, 0..6, 3)
    });
    // What the floor sends back is some 5 %.
    agree_path_by_path("floor", &found[0], &found[1], 0.005, 0.02);
}

/// Fog alone, bounded, on a floor that is not seen, around a glass ball and metal that are: paths of any number of bounces and of few.
#[test]
fn pictures_of_fog_alone_are_those_of_connected_paths() {
    let text =
        [&camera([0.0, 0.5, -4.0], [0.0, -0.2, 0.0], 40.0, 16), &lamp([0.3, 1.8, 0.2], 10.0), &fog()[..]]
            .concat();
    let metal =
        Material::of_lobes(Lobes { metal: Vec3::splat(0.8), edge: Vec3::ONE, alpha: 0.3, ..lobes(1.5) });
    let parts = [
        bound(cube(Vec3::new(-1.2, -1.0, -1.2), Vec3::splat(1.2)), 0),
        part(
            cube(Vec3::new(-2.0, -2.0, -2.0), Vec3::new(2.0, -1.0, 2.0)),
            Material::Lambert { albedo: Vec3::splat(0.8) },
        ),
        part(ball(0.4, Vec3::new(0.5, -0.55, 0.9), 32), metal),
    ];
    let volumes = vec![volume(0, Vec3::new(-1.2, -1.0, -1.2), Vec3::splat(1.2))];
    let mut scene = scene(&text, &parts, volumes);
    scene.sees = Sees::FogAlone;
    for bounces in [None, Some(0), Some(2)] {
        scene.settings.bounces = bounces;
        // The light that the metal mirrors is not in the connected paths': two thousandths or so.
        agree(&format!("{bounces:?}"), &guided(&scene, 0..8, 2), &traced(&scene, 10_000, 8), 0.01, 0.06);
    }
}

/// Of half of space, of albedo a: 1 - √(1 - a) H(1) of the light that falls straight down comes back, H(1) = 1.8501 for a = 0.9
/// (S. Chandrasekhar, *Radiative Transfer*, 1950, table XI).
#[test]
fn half_of_space_sends_back_what_the_h_function_says() {
    let spot = "[[light]]\nkind = \"spot\"\nposition = [0, 1, 0]\nlook_at = [0, 0, 0]\nintensity = 1\ninner_angle = 0\nouter_angle = 0.1\n";
    let text = [&camera([0.0, 3.0, -4.0], [0.0; 3], 40.0, 8), spot, &medium("fog", 9.0, 1.0)].concat();
    // So large that next to nothing gets to its other sides.
    let (min, max) = (Vec3::splat(-20.0), Vec3::new(20.0, 0.0, 20.0));
    let scene = scene(&text, &[bound(cube(min, max), 0)], vec![volume(0, min, max)]);
    let tracer = PhotonTracer::new(&scene, 0, Emission::LowDiscrepancy);
    let mut record = PhotonRecord::default();
    let paths = 8192;
    (0..paths).for_each(|index| tracer.trace(0, index, paths, Record::Beams, &mut record));
    let back = record.energy.escaped[0] / record.energy.emitted[0];
    // A photon comes back or not: a standard error of .0055.
    assert!((back - (1.0 - 0.1_f64.sqrt() * 1.8501)).abs() < 0.02, "{back}");
}

/// Bounds that are flat, inside out or open are no reason to fail.
#[test]
fn odd_bounds_make_finite_pictures() {
    let plane = sheet(Vec3::new(-1.0, -1.0, 0.0), Vec3::X * 2.0, Vec3::Y * 2.0);
    let flat = cube(Vec3::new(-1.0, -1.0, 0.0), Vec3::new(1.0, 1.0, 0.0));
    for mesh in [plane.clone(), inverted(plane), flat, inverted(block(1.0, Vec3::ZERO))] {
        let scene = scene(&text(&fog()), &[bound(mesh, 0)], vec![volume(0, WHOLE.0, WHOLE.1)]);
        let found = guided(&scene, 0..2, 1);
        assert!(found.iter().all(|mean| mean.is_finite() && *mean >= 0.0), "{found:?}");
    }
}
