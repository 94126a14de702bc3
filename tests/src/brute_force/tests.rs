//! The brute-force path tracer against closed forms.

use super::BruteForce;
use crate::statistics::Sample;
use std::f64::consts::PI;

/// Seeds of a mean, and standard errors that it may be off by: 5 of 8 runs, a chance of 2e-3 of a false alarm; seeds are fixed.
const RUNS: u32 = 8;
const ERRORS: f64 = 5.0;

/// Parallel rays along +z through a square of side 0.5, from z = -5.
const ALONG_Z: &str = "[camera]\nposition = [0, 0, -5]\nlook_at = [0, 0, 0]\nprojection = \"orthographic\"\nvertical_size = 0.5\n\
                       width = 4\nheight = 4\n";

/// Mean of a channel over the picture.
fn mean(text: &str, channel: usize, paths: u32) -> Sample {
    let scene = BruteForce::parse(text).expect("a scene that it knows");
    let of_run = |seed: u32| {
        let radiance = scene.picture(seed, paths).radiance;
        radiance.iter().map(|value| f64::from(value[channel])).sum::<f64>() / radiance.len() as f64
    };
    Sample::of(&(0..RUNS).map(of_run).collect::<Vec<_>>())
}

/// `most`: largest standard error, as part of what is expected, that the test is worth anything with.
fn assert_mean(found: Sample, expected: f64, most: f64) {
    assert!(found.error <= most * expected, "too noisy to tell: {found:?} for {expected}");
    // f32 pixels.
    let allowed = ERRORS * found.error + 1e-6 * expected;
    assert!((found.mean - expected).abs() <= allowed, "{found:?} for {expected}");
}

fn medium(name: &str, scattering: &str, absorption: &str, phase: &str) -> String {
    format!(
        "[[medium]]\nname = \"{name}\"\nscattering = {scattering}\nabsorption = {absorption}\nphase = {phase}\n"
    )
}

fn cuboid(min: &str, max: &str, material: &str) -> String {
    format!("[[object]]\nshape = \"box\"\nmin = {min}\nmax = {max}\nmaterial = {material}\n")
}

const GLASS: &str = "{ dielectric = { index = 1.5 } }";
const CLEAR: &str = "{ dielectric = { index = 1 } }";

/// A large wall at z = 4 that shines towards the camera with radiance 1, and is seen.
const WALL: &str = "[[light]]\nkind = \"rectangle\"\ncorner = [-90, -90, 4]\nedge_u = [0, 180, 0]\nedge_v = [180, 0, 0]\n\
                    radiance = 1\nvisible = true\n";

#[test]
fn fog_that_touches_fog_or_is_in_it_absorbs_what_its_length_says() {
    let media = medium("p", "0", "[1, 0.1, 0]", "\"isotropic\"") + &medium("q", "0", "0.5", "\"isotropic\"");
    let [p, q, r] = [("-1", "0", "p"), ("0", "1", "q"), ("-0.75", "-0.25", "q")].map(|(low, high, name)| {
        cuboid(&format!("[-1, -1, {low}]"), &format!("[1, 1, {high}]"), CLEAR)
            + &format!("inside = \"{name}\"\n")
    });
    for objects in [[&p, &q, &r], [&r, &q, &p], [&q, &p, &r]] {
        let text = [ALONG_Z, &media, objects[0], objects[1], objects[2], WALL].concat();
        // Half of p is q where r is.
        for (channel, of_p) in [1.0, 0.1, 0.0].into_iter().enumerate() {
            assert_mean(mean(&text, channel, 400), (-0.5 * of_p - 0.75_f64).exp(), 0.02);
        }
    }
}

#[test]
fn priority_goes_before_nesting_and_nesting_before_the_order() {
    let media = medium("p", "0", "1", "\"isotropic\"") + &medium("q", "0", "0.25", "\"isotropic\"");
    let outer = cuboid("[-1, -1, -1]", "[1, 1, 1]", CLEAR) + "inside = \"p\"\n";
    let inner = cuboid("[-1, -1, -0.5]", "[1, 1, 1]", CLEAR) + "inside = \"q\"\n";
    let beside = cuboid("[-1, -1, -0.5]", "[1, 1, 1.5]", CLEAR) + "inside = \"q\"\n";
    let above = |object: &str| format!("{object}priority = 1\n");
    for (objects, depth) in [
        (outer.clone() + &inner, 0.5 + 0.25 * 1.5),
        (inner.clone() + &outer, 0.5 + 0.25 * 1.5),
        (above(&outer) + &inner, 2.0),
        (outer.clone() + &beside, 0.5 + 0.25 * 2.0),
        (beside.clone() + &outer, 2.0 + 0.25 * 0.5),
        (above(&beside) + &outer, 0.5 + 0.25 * 2.0),
    ] {
        let text = [ALONG_Z, &media, &objects, WALL].concat();
        assert_mean(mean(&text, 0, 800), f64::exp(-depth), 0.02);
    }
}

#[test]
fn touching_glass_is_one_piece_of_glass() {
    let [front, back] = [("-1", "0"), ("0", "1")]
        .map(|(a, b)| cuboid(&format!("[-1, -1, {a}]"), &format!("[1, 1, {b}]"), GLASS));
    for objects in [[&front, &back], [&back, &front]] {
        let text = [ALONG_Z, objects[0], objects[1], WALL].concat();
        // (1 - R)/(1 + R) of a slab, R = .04.
        assert_mean(mean(&text, 0, 400), 0.96 / 1.04, 0.01);
    }
    // A gap of a hundredth: twice as many faces, (1 - R)/(1 + 3 R).
    let gap = cuboid("[-1, -1, 0.01]", "[1, 1, 1]", GLASS);
    assert_mean(mean(&[ALONG_Z, &front, &gap, WALL].concat(), 0, 400), 0.96 / 1.12, 0.01);
}

#[test]
fn a_closed_white_room_is_as_bright_as_its_albedo_says_with_glass_and_fog_in_it() {
    let albedo = 0.6;
    let room = cuboid("[-2, -2, -2]", "[2, 2, 2]", &format!("{{ lambert = {{ albedo = {albedo} }} }}"));
    let camera = "[camera]\nposition = [0, 0, -1.5]\nlook_at = [0, 0.2, 0]\nvertical_fov = 90\nwidth = 4\nheight = 4\n";
    let wall = |name: &str, corner: &str, u: &str, v: &str| {
        format!(
            "# {name}\n[[light]]\nkind = \"rectangle\"\ncorner = {corner}\nedge_u = {u}\nedge_v = {v}\nradiance = 0.4\nvisible = true\n"
        )
    };
    // All six walls shine with 1 - a: the radiance is 1 everywhere.
    let walls = [
        wall("floor", "[-2, -2, -2]", "[0, 0, 4]", "[4, 0, 0]"),
        wall("ceiling", "[-2, 2, -2]", "[4, 0, 0]", "[0, 0, 4]"),
        wall("front", "[-2, -2, -2]", "[4, 0, 0]", "[0, 4, 0]"),
        wall("back", "[-2, -2, 2]", "[0, 4, 0]", "[4, 0, 0]"),
        wall("left", "[-2, -2, -2]", "[0, 4, 0]", "[0, 0, 4]"),
        wall("right", "[2, -2, -2]", "[0, 0, 4]", "[0, 4, 0]"),
    ]
    .concat();
    let clear = [camera, &room, &walls].concat();
    assert_mean(mean(&clear, 0, 1500), 1.0, 0.01);
    // What only scatters and refracts changes nothing. (Where glass stood on a wall, that would have to shine into it n² times as bright.)
    let white = medium("w", "[1, 0.2, 3]", "0", "{ henyey_greenstein = 0.4 }");
    let milk = cuboid("[-0.5, -1.5, 0]", "[1, 0, 1]", GLASS) + "inside = \"w\"\n";
    let fog = cuboid("[-2, -2, -2]", "[2, 0.5, 2]", CLEAR) + "inside = \"w\"\n";
    let filled = [camera, &white, &fog, &room, &milk, &walls].concat();
    for channel in 0..3 {
        assert_mean(mean(&filled, channel, 1500), 1.0, 0.02);
    }
}

#[test]
fn fog_beside_a_lamp_is_as_bright_as_single_scattering_says() {
    // Scattering so thin that twice does not count, in a beam of parallel rays past a point lamp at distance 1: σ I/(4π) times the integral of
    // the inverse square over a slab of half-length h, 2 atan(h).
    let (sigma, half) = (1e-9, 1.5);
    let fog = cuboid("[-1, -1, -1.5]", "[1, 1, 1.5]", CLEAR) + "inside = \"p\"\n";
    let text = |lamp: &str| {
        let narrow = ALONG_Z.replace("vertical_size = 0.5", "vertical_size = 1e-3");
        [&narrow, &medium("p", "1e-9", "0", "\"isotropic\""), &fog, lamp].concat()
    };
    let expected = sigma / (4.0 * PI) * 2.0 * f64::atan(half);
    let point = "[[light]]\nkind = \"point\"\nposition = [0, 1, 0]\nintensity = 1\n";
    assert_mean(mean(&text(point), 0, 20), expected, 0.01);
    // Small lamps of the same intensity towards it, in the plane of the fog's upper face.
    let disk = "[[light]]\nkind = \"disk\"\ncenter = [0, 1, 0]\nnormal = [0, -1, 0]\nradius = 0.01\nradiance = 3183.1\n";
    // The cosine towards the place: ∫ (1 + z²)^(-3/2) dz = 2 h/√(1 + h²).
    let flat = sigma / (4.0 * PI) * 2.0 * half / f64::hypot(1.0, half);
    assert_mean(mean(&text(disk), 0, 100), flat, 0.01);
    let square = "[[light]]\nkind = \"rectangle\"\ncorner = [-0.005, 1, -0.005]\nedge_u = [0.01, 0, 0]\nedge_v = [0, 0, 0.01]\nradiance = 1e4\n";
    assert_mean(mean(&text(square), 0, 100), flat, 0.01);
    let ball = "[[light]]\nkind = \"sphere\"\ncenter = [0, 1, 0]\nradius = 0.01\nradiance = 3183.1\n";
    assert_mean(mean(&text(ball), 0, 400), expected, 0.01);
    // A spot whose cone holds all of it, and one that shines the other way.
    let spot = |at: &str| {
        format!(
            "[[light]]\nkind = \"spot\"\nposition = [0, 1, 0]\nlook_at = {at}\nintensity = 1\ninner_angle = 80\nouter_angle = 85\n"
        )
    };
    assert_mean(mean(&text(&spot("[0, 0, 0]")), 0, 20), expected, 0.01);
    assert_eq!(mean(&text(&spot("[0, 2, 0]")), 0, 20).mean, 0.0);
    // A sun along the view: forward scattering through all of it.
    let sun = |angle: f64| {
        format!("[[light]]\nkind = \"sun\"\ndirection = [0, 0, 1]\nirradiance = 1\nangle = {angle}\n")
    };
    // Of a wide sun more light crosses a ball than a plane.
    for angle in [0.0, 1.0_f64] {
        let wide = 2.0 / (1.0 + (0.5 * angle).to_radians().cos());
        assert_mean(mean(&text(&sun(angle)), 0, 20), wide * sigma * 2.0 * half / (4.0 * PI), 0.01);
    }
    // In glass what its faces let in and keep adds up to the same fluence, whatever they reflect, and so does what they let out of it, over the squared
    // index.
    let glass = text(&sun(0.0)).replace(CLEAR, GLASS);
    assert!(BruteForce::parse(&glass).unwrap().is_all_found());
    assert_mean(mean(&glass, 0, 2000), sigma * 2.0 * half / (4.0 * PI) / 2.25, 0.01);
    assert!(!BruteForce::parse(&glass.replace("[0, 0, 1]", "[0, 0.1, 1]")).unwrap().is_all_found());
}

#[test]
fn phase_functions_are_drawn_as_they_are_evaluated() {
    let mut stream = crate::random::Stream::new(3);
    for g in [-0.5, 0.0, 0.3, 0.85] {
        let count = 20_000;
        let cosines: Vec<f64> =
            (0..count).map(|_| super::path::sample_henyey_greenstein(g, stream.uniform())).collect();
        let found = Sample::of(&cosines);
        assert!((found.mean - g).abs() < 4.0 * found.error, "{found:?} for {g}");
        // The density's integral over the cosine, and its mean cosine, by the midpoint rule: to 1e-5 at g = .85.
        let step = 2.0 / 4000.0;
        let at = |i: i32| -1.0 + step * (f64::from(i) + 0.5);
        let sum = |power: i32| -> f64 {
            (0..4000).map(|i| super::path::henyey_greenstein(g, at(i)) * at(i).powi(power)).sum::<f64>()
                * step
                * 2.0
                * PI
        };
        assert!((sum(0) - 1.0).abs() < 1e-4 && (sum(1) - g).abs() < 1e-4, "{g}");
    }
}

#[test]
fn what_it_does_not_know_it_refuses() {
    let refused = |extra: &str| BruteForce::parse(&[ALONG_Z, extra].concat()).err().expect("refused");
    assert!(refused("near = 1\n").contains("near"));
    assert!(refused("[[object]]\nshape = \"mesh\"\nmaterial = \"black\"\n").contains("mesh"));
    assert!(refused("[[light]]\nkind = \"sky\"\n").contains("sky"));
    assert!(refused(&medium("p", "1", "0", "\"rayleigh\"")).contains("rayleigh"));
    assert!(
        refused(&cuboid("[0, 0, 0]", "[1, 1, 1]", "{ dielectric = { index = 1.5, roughness = 0.5 } }"))
            .contains("roughness")
    );
    let through = |material: &str| {
        let lamp = "[[light]]\nkind = \"point\"\nposition = [0, 1, 0]\nintensity = 1\n";
        BruteForce::parse(&[ALONG_Z, &cuboid("[0, 0, 0]", "[1, 1, 1]", material), lamp].concat()).unwrap()
    };
    assert!(through(CLEAR).is_all_found() && !through(GLASS).is_all_found());
}
