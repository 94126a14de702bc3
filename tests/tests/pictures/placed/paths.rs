//! Eye and light paths among placed objects.

use super::scenes::{
    Part, ball, block, bound, camera, cube, glass, inverted, lamp, lobes, medium, part, scene, volume,
};
use covbeam_session::eye::EyeTracer;
use covbeam_session::eye::SmallLamps;
use covbeam_session::eye::segment::EyeSegment;
use covbeam_session::eye::starts::{EyeStart, EyeStarts};
use covbeam_session::kind::{ByKind, Kind};
use covbeam_session::lamps::LampTree;
use covbeam_session::paths::{PhotonRecord, PhotonTracer, Record};
use covbeam_session::random::{Emission, Random};
use covbeam_session::scene::media;
use covbeam_session::scene::{Lobes, Material, Scene, Sees};
use covbeam_session::surface::SurfaceMap;
use glam::Vec3;

/// Pieces of the eye path along a direction, and what it sees on surfaces.
pub(super) fn seen(scene: &Scene, direction: Vec3, asked: [bool; 2], seed: u32) -> (Vec<EyeSegment>, ByKind) {
    let (fogs, surfaces) = (media::all(scene), SurfaceMap::empty());
    let starts = EyeStarts::new(scene);
    let middle = starts.middle(0, 0);
    let start = EyeStart { origin: scene.camera.position, direction, interior: starts.interior(), ..middle };
    let lamps = LampTree::new(scene);
    let tracer = EyeTracer {
        scene,
        fogs: &fogs,
        starts,
        lamps: &lamps,
        surfaces: &surfaces,
        beyond: true,
        shown: Some(&SmallLamps::default()),
        is_apart: false,
    };
    let mut segments = Vec::new();
    let mut random = Random::new([seed, 0, 0, 0]);
    let light = tracer.trace_wanted(&start, 0, asked, &mut random, &mut segments);
    (segments, light)
}

/// Fog in fog, and a mirror in the inner one that shows them again.
fn nested(mirror: bool) -> Scene {
    let text = [
        camera([0.0, 0.0, -9.0], [0.0; 3], 40.0, 8),
        lamp([0.0, 5.0, 0.0], 1.0),
        medium("large", 0.1, 0.0),
        medium("small", 0.15, 0.05),
    ];
    let mut parts = vec![bound(block(2.0, Vec3::ZERO), 0), bound(block(1.0, Vec3::ZERO), 1)];
    if mirror {
        let material = Material::of_lobes(Lobes { metal: Vec3::ONE, edge: Vec3::ONE, ..lobes(1.0) });
        parts.push(part(cube(Vec3::new(-3.0, -3.0, 0.5), Vec3::new(3.0, 3.0, 0.6)), material));
    }
    let volumes = vec![volume(0, Vec3::splat(-2.0), Vec3::splat(2.0)), volume(1, Vec3::NEG_ONE, Vec3::ONE)];
    scene(&text.concat(), &parts, volumes)
}

#[test]
fn an_eye_path_gets_all_pieces_of_fog_on_its_way_and_all_of_them_are_first() {
    let scene = nested(false);
    let direction = Vec3::new(0.01, 0.0, 1.0).normalize();
    let slant = 1.0 / direction.z;
    for asked in [[true, true], [true, false]] {
        let (segments, _) = seen(&scene, direction, asked, 0);
        // Planes at z = -2, -1, 1 and 2.
        assert_eq!(segments.iter().map(|piece| piece.medium).collect::<Vec<_>>(), [0, 1, 0]);
        let depths = [0.0, 0.1, 0.1 + 0.2 * 2.0];
        for (piece, (length, depth)) in segments.iter().zip([1.0, 2.0, 1.0].into_iter().zip(depths)) {
            assert!(piece.is_first());
            assert!((piece.ray.length / (length * slant) - 1.0).abs() < 1e-4, "{piece:?}");
            let left = (-depth * slant).exp();
            assert!((piece.throughput / left - 1.0).abs().max_element() < 1e-4, "{piece:?}");
        }
    }
    assert!(seen(&scene, direction, [false, true], 0).0.is_empty(), "there is nothing but fog");
}

/// Along z: up to a mirror at 0.5 and back. What is wanted of the ray is what it gets.
#[test]
fn what_is_before_the_first_surface_and_what_is_beyond_it_are_told_apart() {
    let scene = nested(true);
    let ways = [[true, true], [true, false], [false, true]];
    let [both, first, beyond] = ways.map(|asked| seen(&scene, Vec3::Z, asked, 0).0);
    let media = |pieces: &[EyeSegment]| pieces.iter().map(|piece| piece.medium).collect::<Vec<_>>();
    assert_eq!(media(&both), [0, 1, 1, 0]);
    assert_eq!(both.iter().map(EyeSegment::is_first).collect::<Vec<_>>(), [true, true, false, false]);
    assert_eq!(media(&first), [0, 1]);
    assert_eq!(media(&beyond).len(), 2);
    assert!(beyond.iter().all(|piece| !piece.is_first() && piece.signature == beyond[0].signature));
    // 0.1 x 1, 0.2 x 1.5 there and back.
    let last = both.last().expect("four pieces");
    assert!((last.throughput.x / (-0.1 - 0.2 * 3.0_f32).exp() - 1.0).abs() < 1e-4, "{last:?}");
}

/// A slab of glass lets through what all reflections between its sides leave: (1 - R)/(1 + R), R = 0.04; in glass radiance is n² times as much.
#[test]
fn a_pane_lets_through_what_all_its_reflections_leave() {
    let text = [
        "outside_medium = \"fog\"\n",
        &camera([0.0, 0.0, -3.0], [0.0; 3], 20.0, 4),
        &lamp([0.0, 5.0, 0.0], 1.0),
        // Next to nothing, to see the pieces.
        &medium("fog", 1e-9, 0.0),
    ];
    let pane = || cube(Vec3::new(-5.0, -5.0, 0.0), Vec3::new(5.0, 5.0, 0.01));
    // White glass in the plainest form and as lobes, in which a transparent part is next to nothing.
    let mixed =
        Material::Lobes(Lobes { glass_reflection: Vec3::ONE, glass_transmission: Vec3::ONE, ..lobes(1.5) });
    assert_eq!(glass(), Material::Dielectric { index: 1.5 });
    for material in [glass(), mixed] {
        let scene = scene(&text.concat(), &[part(pane(), material)], Vec::new());
        let (mut through, count) = (0.0, 4000);
        for seed in 0..count {
            let (pieces, _) = seen(&scene, Vec3::Z, [true, true], seed);
            for piece in pieces {
                let is_beyond = piece.ray.origin.z > 0.005 && !scene.is_in_glass(piece.medium);
                if is_beyond && piece.ray.direction.z > 0.0 {
                    through += f64::from(piece.throughput.x) / f64::from(count);
                }
                if scene.is_in_glass(piece.medium) {
                    assert!(piece.throughput.x < 0.96 / 2.25 + 1e-5, "{piece:?}");
                }
            }
        }
        // Roulette turns a weight of .0016 into .02 with a probability of .08: a standard error of 9e-5; five of them.
        assert!((through - 0.96 / 1.04).abs() < 4.5e-4, "{material:?}: {through}");
    }
}

/// Bounds of fog around and between a lamp and a ball that casts a shadow.
#[test]
fn bounds_of_fog_have_no_edges_and_hide_none() {
    let text =
        [camera([0.0, 0.0, -9.0], [0.0; 3], 40.0, 8), lamp([0.0, 5.0, 0.0], 1.0), medium("fog", 0.1, 0.0)];
    let shadow = || part(ball(0.5, Vec3::ZERO, 24), Material::Black);
    let bounds = [bound(block(2.0, Vec3::ZERO), 0), bound(block(1.0, Vec3::X * 0.3), 0)];
    let volumes = || vec![volume(0, Vec3::splat(-2.0), Vec3::splat(2.0))];
    let bare = scene(&text.concat(), &[shadow()], Vec::new());
    let [first, second] = bounds;
    let fogged = scene(&text.concat(), &[shadow(), first, second], volumes());
    let origin = Vec3::new(0.1, 3.0, 0.2);
    let (mut found, mut cast) = (0, 0);
    for step in 0..60 {
        let direction = Vec3::new(0.02 * (step as f32 - 30.0), -3.0, 0.1).normalize();
        let [expected, edges] = [&bare, &fogged].map(|scene| {
            let hit = scene.intersect(origin, direction, f32::INFINITY);
            cast += usize::from(hit.is_some());
            scene.edges_beside(origin, direction, hit.as_ref())
        });
        assert_eq!(edges.len(), expected.len(), "{direction}");
        for (a, b) in edges.iter().zip(expected.iter()) {
            // Rays that start anew behind a bound are 1e-7 beside those that do not; where one grazes the ball, it meets it the root of
            // that earlier or later.
            assert!(
                (a.depth - b.depth).abs() < 1e-3 && (a.distance - b.distance).abs() < 1e-4,
                "{a:?} {b:?}"
            );
        }
        found += edges.len();
    }
    assert!(found > 20 && cast > 70, "{found}, {cast}");
}

/// What some paths leave; every balance closes.
pub(super) fn traced(scene: &Scene, paths: u32, record: Record) -> PhotonRecord {
    let (tracer, what) = (PhotonTracer::new(scene, 0, Emission::LowDiscrepancy), record);
    let mut record = PhotonRecord::default();
    (0..paths).for_each(|index| tracer.trace(0, index, paths, what, &mut record));
    let energy = record.energy;
    for channel in 0..3 {
        let all = [energy.medium, energy.surfaces, energy.escaped, energy.spent, energy.roulette];
        let sum: f64 = all.iter().map(|part| part[channel]).sum();
        assert!((sum / energy.emitted[channel] - 1.0).abs() < 1e-5, "{energy:?}");
    }
    record
}

pub(super) const HAZE: &str = "outside_medium = \"fog\"\n";

/// Walls and fog that absorb nothing, around things that do not either: what paths have is lost to chance alone.
#[test]
fn a_white_box_full_of_white_fog_loses_no_light() {
    let white = Vec3::ONE;
    let things: Vec<(&str, Option<Lobes>)> = vec![
        ("empty", None),
        ("metal", Some(Lobes { metal: white, edge: white, alpha: 0.3, ..lobes(1.5) })),
        ("glass", Some(Lobes { glass_reflection: white, glass_transmission: white, ..lobes(1.5) })),
        (
            "frosted",
            Some(Lobes { glass_reflection: white, glass_transmission: white, alpha: 0.3, ..lobes(1.5) }),
        ),
        ("translucent", Some(Lobes { diffuse: 0.3 * white, translucent: 0.7 * white, ..lobes(1.5) })),
        ("coated", Some(Lobes { diffuse: white, coat: white, ..lobes(1.5) })),
        ("half there", Some(Lobes { diffuse: 0.4 * white, transparent: 0.6 * white, ..lobes(1.5) })),
        ("a bound", Some(Lobes { transparent: white, ..lobes(1.5) })),
    ];
    for (name, lobes) in things {
        let text = [
            HAZE,
            &camera([0.0, 0.0, -1.0], [0.0; 3], 40.0, 8),
            &lamp([-1.0, 0.5, 0.3], 1.0),
            &medium("fog", 0.4, 0.0),
        ];
        let walls = part(inverted(block(2.0, Vec3::ZERO)), Material::Lambert { albedo: white });
        let thing = |lobes| part(ball(0.6, Vec3::X * 0.8, 24), Material::of_lobes(lobes));
        let mut scene = scene(
            &text.concat(),
            &[vec![walls], lobes.map(thing).into_iter().collect()].concat(),
            Vec::new(),
        );
        // Of later events chance makes few, of any weight.
        scene.settings.bounces = Some(64);
        let energy = traced(&scene, 1000, Record::Beams).energy;
        let lost = energy.medium[0] + energy.surfaces[0] + energy.escaped[0];
        // Factors that should be 1 are rounded to 2⁻²³, at 64 events a path. Rough metal keeps nothing of what a camera sees, from wherever that comes;
        // of what comes from one side a fifth may be missing or too much, here at a tenth of the events, of either sign.
        let most = if name == "metal" { 0.05 } else { 64.0 * 1.2e-7 };
        assert!(lost.abs() < most * energy.emitted[0], "{name}: {lost} of {energy:?}");
    }
}

/// With no bounces all light is straight; with some, what has them used up ends: of a lamp in fog so large and thick that nothing leaves it, of
/// albedo a, the powers of n + 1 flights are 1, a, .., aⁿ of the lamp's.
#[test]
fn paths_end_when_their_bounces_are_used_up() {
    let (scattering, absorption) = (3.0_f32, 1.0);
    let text = [HAZE, &camera([0.0, 0.0, -1.0], [0.0; 3], 40.0, 8), &lamp([0.0; 3], 1.0)].concat();
    let mut scene = scene(&[text, medium("fog", scattering, absorption)].concat(), &[], Vec::new());
    scene.placed = Some(super::scenes::placed(
        &[bound(block(50.0, Vec3::ZERO), 0)],
        vec![volume(0, Vec3::splat(-50.0), Vec3::splat(50.0))],
        &[],
    ));
    let albedo = f64::from(scattering / (scattering + absorption));
    for most in [0, 1, 3] {
        scene.settings.bounces = Some(most);
        let record = traced(&scene, 4000, Record::Beams);
        let flown: f64 = record.beams.iter().map(|beam| f64::from(beam.beam.power.x)).sum();
        let expected: f64 = (0..=most as i32).map(|n| albedo.powi(n)).sum();
        let found = flown / record.energy.emitted[0];
        // Each flight ends by a chance of 1/4: a standard error of some 1 % of 4000 paths for the longest.
        assert!((found / expected - 1.0).abs() < 0.03, "{most}: {found} for {expected}");
        let spent = record.energy.spent[0] / record.energy.emitted[0];
        assert!((spent - albedo.powi(most as i32 + 1)).abs() < 0.03, "{most}: {spent}");
        assert_eq!(record.beams.iter().all(|beam| beam.kind == Kind::Straight), most == 0);
    }
}

/// Through bounds of fog light stays straight, and is counted as no bounce, however many there are.
#[test]
fn bounds_of_fog_are_no_event() {
    let text =
        [camera([0.0, 0.0, -9.0], [0.0; 3], 40.0, 8), lamp([0.0, 0.0, -3.0], 1.0), medium("fog", 1e-6, 0.0)];
    // Twice as many are crossed: more than the 64 surfaces after which chance ends paths.
    let layers: Vec<Part> = (0..36).map(|i| bound(block(1.0 - 0.025 * i as f32, Vec3::ZERO), i)).collect();
    let volumes =
        (0..36).map(|i| volume(0, Vec3::splat(0.025 * i as f32 - 1.0), Vec3::splat(1.0 - 0.025 * i as f32)));
    let mut scene = scene(&text.concat(), &layers, volumes.collect());
    scene.settings.bounces = Some(0);
    let paths = 1000;
    let record = traced(&scene, paths, Record::BeamsAndField);
    let pieces = record.beams.len();
    assert!(pieces > 1000, "{pieces}");
    for beam in &record.beams {
        assert_eq!(beam.kind, Kind::Straight);
        // Powers are those of the lamp, but for a paths that are ended by chance after 64 surfaces and others that stand for them.
        assert!(beam.beam.power.x * paths as f32 / (4.0 * std::f32::consts::PI) < 8.0);
    }
    assert!(record.deposits.iter().all(|(_, segment)| segment.unscattered && segment.edges.is_empty()));
    assert!(record.energy.spent[0] < 1e-4 * record.energy.emitted[0], "{:?}", record.energy);
    // All of the light leaves, however often chance decides: 1/2 of it at least meets 36 layers and leaves them.
    assert!((record.energy.escaped[0] / record.energy.emitted[0] - 1.0).abs() < 0.02, "{:?}", record.energy);
}

/// Where photons start is found from the lamp's place, however much of it sticks out: beams of fog start where the fog is.
#[test]
fn light_of_a_lamp_that_sticks_out_of_fog_starts_where_it_starts() {
    let lights = [
        "[[light]]\nkind = \"rectangle\"\ncorner = [-0.5, 0.3, 0]\nedge_u = [4, 0, 0]\nedge_v = [0, 0, 0.4]\nradiance = 9\n",
        "[[light]]\nkind = \"disk\"\ncenter = [1.2, 0, 0]\nnormal = [0, 1, 0.02]\nradius = 0.6\nradiance = 9\n",
        "[[light]]\nkind = \"sphere\"\ncenter = [0.2, 0.1, 0]\nradius = 1.3\nradiance = 9\n",
    ];
    for light in lights {
        let text = [&camera([0.0, 0.0, -9.0], [0.0; 3], 40.0, 8), light, &medium("fog", 1e-3, 0.0)].concat();
        let scene =
            scene(&text, &[bound(block(1.0, Vec3::ZERO), 0)], vec![volume(0, Vec3::NEG_ONE, Vec3::ONE)]);
        let record = traced(&scene, 3000, Record::Beams);
        assert!(record.beams.len() > 500, "{light}: {}", record.beams.len());
        for beam in record.beams.iter().map(|beam| &beam.beam) {
            for end in [1e-4, beam.length - 1e-4] {
                let place = beam.origin + end * beam.direction;
                assert!(beam.length < 2e-4 || place.abs().max_element() < 1.0 + 1e-5, "{light}: {place}");
            }
        }
    }
}

/// A sun from any side starts outside of everything.
#[test]
fn beams_of_a_sun_are_in_the_fog_that_it_shines_on() {
    for direction in ["[1, 1, 1]", "[-1, -1, -1]", "[0.2, -1, 0.1]"] {
        let sun = format!("[[light]]\nkind = \"sun\"\ndirection = {direction}\nangle = 1\nirradiance = 1\n");
        let dummy =
            "[[object]]\nshape = \"box\"\nmin = [-1, -1, -1]\nmax = [1, 1, 1]\nmaterial = \"black\"\n";
        let text =
            [&camera([0.0, 0.0, -9.0], [0.0; 3], 40.0, 8), &sun, dummy, &medium("fog", 1e-3, 0.0)].concat();
        let mut scene =
            scene(&text, &[bound(block(1.0, Vec3::ZERO), 0)], vec![volume(0, Vec3::NEG_ONE, Vec3::ONE)]);
        scene.objects.clear();
        let record = traced(&scene, 2000, Record::BeamsAndField);
        assert!(record.beams.len() > 800, "{}", record.beams.len());
        let inside = |place: Vec3| place.abs().max_element() < 1.0 + 1e-4;
        for beam in record.beams.iter().map(|beam| &beam.beam) {
            assert!(inside(beam.origin) && inside(beam.origin + beam.length * beam.direction));
        }
    }
}

/// In pictures of fog alone a floor under a lamp is black; its light lights the fog all the same.
#[test]
fn surfaces_are_black_where_fog_alone_is_seen() {
    let floor = "[[light]]\nkind = \"rectangle\"\ncorner = [-1, 2.9, -1]\nedge_u = [2, 0, 0]\nedge_v = [0, 0, 2]\nradiance = 9\n";
    let text =
        [HAZE, &camera([0.0, 1.0, -4.0], [0.0, 0.0, 0.0], 40.0, 8), floor, &medium("fog", 0.3, 0.0)].concat();
    let gloss = Lobes { diffuse: Vec3::splat(0.5), coat: Vec3::ONE, alpha: 0.2, ..lobes(1.5) };
    for material in [Material::Lambert { albedo: Vec3::splat(0.8) }, Material::of_lobes(gloss)] {
        let slab = part(cube(Vec3::new(-3.0, -1.0, -3.0), Vec3::new(3.0, 0.0, 3.0)), material);
        let mut scene = scene(&text, &[slab], Vec::new());
        let direction = scene.camera.forward;
        let bright = seen(&scene, direction, [true, true], 0);
        let photons = traced(&scene, 500, Record::Beams);
        scene.sees = Sees::FogAlone;
        let dark = seen(&scene, direction, [true, true], 0);
        assert!(bright.1[0].x > 0.0 && dark.1 == ByKind::default(), "{material:?}");
        assert_eq!(dark.0.len(), bright.0.len(), "the fog is the same");
        let others = traced(&scene, 500, Record::Beams);
        assert!(!photons.surface.is_empty() && others.surface.is_empty(), "{material:?}");
        assert_eq!(others.beams.len(), photons.beams.len());
        assert_eq!(others.energy, photons.energy);
    }
}

/// Where fog goes on inside of glass its beams are kept apart, and no light field is left.
#[test]
fn beams_in_glass_are_kept_apart() {
    let text = [
        HAZE,
        &camera([0.0, 0.0, -4.0], [0.0; 3], 40.0, 8),
        &lamp([1.0, 2.4, 0.0], 25.0),
        &medium("fog", 0.15, 0.05),
    ];
    let scene = scene(&text.concat(), &[part(ball(0.5, Vec3::ZERO, 32), glass())], Vec::new());
    let record = traced(&scene, 16_000, Record::BeamsAndField);
    let mut inside = 0;
    for beam in &record.beams {
        let middle = beam.beam.origin + 0.5 * beam.beam.length * beam.beam.direction;
        let is_inside = scene.is_in_glass(beam.medium);
        // The mesh is as large as a ball, and may be 1 % off it.
        assert!(if is_inside { middle.length() < 0.505 } else { middle.length() > 0.3 }, "{beam:?}");
        inside += usize::from(is_inside);
        for (normal, side) in [(beam.beam.start_normal, 1.0), (beam.beam.end_normal, -1.0)] {
            assert!(side * normal.dot(beam.beam.direction) >= -1e-6, "{beam:?}");
        }
    }
    assert!(inside > 100, "{inside}");
    assert!(record.deposits.iter().all(|(region, _)| !scene.is_in_glass(*region)));
    assert!(!record.deposits.is_empty());
}

/// A ball of glass in fog over a floor, as shapes of a scene file and as meshes: paths of the same numbers meet the same things.
#[test]
fn a_placed_ball_of_glass_is_as_one_of_a_scene_file() {
    let text = [
        HAZE,
        &camera([0.0, 0.3, -3.0], [0.0, -0.1, 0.0], 40.0, 32),
        &lamp([0.5, 2.4, 0.3], 25.0),
        &medium("fog", 0.3, 0.1),
    ]
    .concat();
    let shapes = "[[object]]\nshape = \"box\"\nmin = [-9, -9, -9]\nmax = [9, -0.8, 9]\nmaterial = { lambert = { albedo = 0.5 } }\n\
        [[object]]\nshape = \"sphere\"\ncenter = [0, 0, 0]\nradius = 0.5\nmaterial = { dielectric = { index = 1.5 } }\ninside = \"fog\"\n";
    let in_file = scene(&[&text, shapes].concat(), &[], Vec::new());
    let floor = Material::Lambert { albedo: Vec3::splat(0.5) };
    let parts = [
        part(cube(Vec3::splat(-9.0), Vec3::new(9.0, -0.8, 9.0)), floor),
        part(ball(0.5, Vec3::ZERO, 96), glass()),
    ];
    let placed = scene(&text, &parts, Vec::new());
    let records = [&in_file, &placed].map(|scene| traced(scene, 20_000, Record::Beams));
    let [expected, found] = records.each_ref().map(|record| {
        let caustic = record.surface.iter().filter(|photon| photon.caustic).map(|photon| photon.power.x);
        let emitted = record.energy.emitted[0];
        // On the floor, through glass, in the fog and on the floor at all.
        [f64::from(caustic.sum::<f32>()), record.energy.medium[0], record.energy.surfaces[0]]
            .map(|sum| sum / emitted)
    });
    for (found, expected) in found.iter().zip(expected) {
        // The mesh's triangles are flat: one path of a hundred that meet the ball leaves it elsewhere.
        assert!(expected > 1e-3 && (found / expected - 1.0).abs() < 0.01, "{found} for {expected}");
    }
    let [expected, found] = [&in_file, &placed].map(|scene| {
        let mut sums = [0.0; 2];
        for pixel in 0..32 * 32 {
            let direction = scene.camera.direction((pixel % 32) as f32 + 0.5, (pixel / 32) as f32 + 0.5);
            for piece in seen(scene, direction, [true, true], pixel).0 {
                let gone = 1.0 - (-0.4_f32 * piece.ray.length).exp();
                sums[usize::from(!piece.is_first())] += f64::from(piece.throughput.x * gone);
            }
        }
        sums
    });
    for (found, expected) in found.iter().zip(expected) {
        assert!((found / expected - 1.0).abs() < 0.01, "{found} for {expected}");
    }
}

/// Light straight through two blocks of glass that touch loses what one block reflects, by Fresnel's equations 4 % at each end, and what the
/// haze around and in it takes.
#[test]
fn two_blocks_of_glass_that_touch_are_one() {
    let text = [
        "outside_medium = \"haze\"\n".to_owned(),
        camera([0.1, 0.2, -9.0], [0.1, 0.2, 0.0], 40.0, 8),
        lamp([0.0, 5.0, 0.0], 1.0),
        medium("haze", 0.01, 0.0),
    ];
    let halves = [[-1.0, 0.0], [0.0, 1.0]]
        .map(|[low, high]| part(cube(Vec3::new(-1.0, -1.0, low), Vec3::new(1.0, 1.0, high)), glass()));
    for order in [[0, 1], [1, 0]] {
        let parts: [Part; 2] = order.map(|half: usize| halves[half].clone());
        let (segments, _) = seen(&scene(&text.concat(), &parts, Vec::new()), Vec3::Z, [true; 2], 1);
        let behind = segments.iter().filter(|s| s.ray.origin.z > 0.999 && s.ray.direction.z > 0.999);
        let left = behind.map(|segment| segment.throughput.x).fold(0.0, f32::max);
        let expected = 0.96 * 0.96 * (-0.1_f32).exp();
        assert!((left / expected - 1.0).abs() < 1e-4, "{order:?}: {left} for {expected}");
    }
}
