//! Rules for the kernel's radius, against estimates that share no code with the renderer: densities from random points, and random lines
//! that an eye ray crosses.

use covbeam::{Beam, GridLayout, KernelShape};
use covbeam_render::scene_file;
use covbeam_session::color::luminance;
use covbeam_session::film::{Film, Picture};
use covbeam_session::kind::Kind;
use covbeam_session::pass::Renderer;
use covbeam_session::paths::PathBeam;
use covbeam_session::plan::radius::{
    BeamVoxels, CROWD, RadiusRule, beams_a_metre, crowd_radius, least_error_radius,
};
use covbeam_session::scene::Scene;
use covbeam_session::scene::media;
use covbeam_session::settings::{Method, Settings};
use covbeam_tests::random::Stream;
use glam::Vec3;
use std::f64::consts::{PI, TAU};
use std::path::Path;

const GLASS: &str = include_str!("../../../examples/scenes/glass-ball.toml");
const KERNELS: [KernelShape; 3] = [KernelShape::Box, KernelShape::Epanechnikov, KernelShape::Biweight];
const RULES: [RadiusRule; 2] = [RadiusRule::LeastError, RadiusRule::BeamDensity];

fn scene(width: u32) -> Scene {
    let mut scene = scene_file::parse(GLASS, "test scene", Path::new(".")).expect("a valid scene");
    (scene.camera.width, scene.camera.height) = (width, width);
    scene
}

/// ∫K_1², by the midpoint rule.
fn roughness(kernel: KernelShape) -> f64 {
    let middles = (0..2000).map(|i| (f64::from(i) + 0.5) / 1000.0 - 1.0);
    middles.map(|q| f64::from(kernel.evaluate(q as f32, 1.0)).powi(2) / 1000.0).sum()
}

/// Points of density 4000 (1 + cos(2π x)), whose crest is estimated: its Hessian over its height is -2π², so σ² = 1/2.
#[test]
fn a_density_estimate_errs_least_at_the_least_error_radius() {
    const CREST: f64 = 8000.0;
    const TRIALS: u32 = 2000;
    let scales = [0.5, 0.7, 1.0, 1.4, 2.0];
    for kernel in KERNELS {
        let radius = least_error_radius(kernel, 0.5, CREST);
        let mut random = Stream::new(7);
        let mut errors = [0.0; 5];
        for _ in 0..TRIALS {
            let mut estimates = [0.0; 5];
            let mut x = -2.0 * radius;
            loop {
                // A Poisson process as dense as the crest, thinned.
                x -= (1.0 - random.uniform()).ln() / CREST;
                if x > 2.0 * radius {
                    break;
                }
                if random.uniform() < 0.5 * (1.0 + (TAU * x).cos()) {
                    for (estimate, scale) in estimates.iter_mut().zip(scales) {
                        *estimate += f64::from(kernel.evaluate(x as f32, (scale * radius) as f32)) / CREST;
                    }
                }
            }
            for (error, estimate) in errors.iter_mut().zip(estimates) {
                *error += (estimate - 1.0_f64).powi(2) / f64::from(TRIALS);
            }
        }
        // At the optimum the squared bias is a quarter of the variance.
        let least = 1.25 * roughness(kernel) / (CREST * radius);
        for (error, scale) in errors.into_iter().zip(scales) {
            let expected = least * (0.8 / scale + 0.2 * scale.powi(4));
            // Three standard deviations of 2000 squares, each 1 ± √2, and up to 8 % of the bias at twice the radius (next order).
            assert!(
                (error / expected - 1.0).abs() < 0.13,
                "{kernel:?} at {scale}: {error:e} for {expected:e}"
            );
            assert!(scale == 1.0 || errors[2] < error, "{kernel:?}: less at {scale} of the radius");
        }
    }
}

/// A line through the ball of radius [`BALL`] around the origin, from everywhere alike: its direction, and its point nearest to the origin.
fn line(random: &mut Stream) -> [Vec3; 2] {
    let direction = random.direction();
    let (u, v) = direction.any_orthonormal_pair();
    let (distance, angle) = (BALL * random.uniform().sqrt(), random.between(0.0, TAU));
    [direction, (distance * angle.cos()) as f32 * u + (distance * angle.sin()) as f32 * v]
}

const BALL: f64 = 0.7;
const LINES: u32 = 2_000_000;

/// Of `lines` lines: a mean chord of 4/3 of the radius over the ball's volume.
fn length_per_volume(lines: f64) -> f64 {
    lines * (4.0 / 3.0 * BALL) / (4.0 / 3.0 * PI * BALL.powi(3))
}

#[test]
fn light_from_everywhere_is_as_noisy_as_that_many_beams_a_metre() {
    const LENGTH: f64 = 1.0;
    const RADIUS: f64 = 0.1;
    let kernel = KernelShape::Epanechnikov;
    let mut random = Stream::new(11);
    let [mut first, mut second, mut power, mut square] = [0.0; 4];
    for _ in 0..LINES {
        let [direction, nearest] = line(&mut random);
        let weight = if random.uniform() < 0.5 { 1.0 } else { 3.0 };
        power += weight;
        square += weight * weight;
        // The eye ray runs along z, so the crossing is seen from above: the line's nearest point to the axis.
        let across = direction.truncate();
        let sine = f64::from(across.length());
        let s = -nearest.truncate().dot(across) / across.length_squared();
        let z = nearest.z + s * direction.z;
        let gap = nearest.truncate().perp_dot(across) / across.length();
        if f64::from(z).abs() < 0.5 * LENGTH {
            let term = weight * f64::from(kernel.evaluate(gap, RADIUS as f32)) / sine;
            first += term;
            second += term * term;
        }
    }
    // Sums over a Poisson process: the variance is the sum of the squares.
    let variance = second / (first * first);
    let equal = length_per_volume(power * power / square);
    let expected = roughness(kernel) / (beams_a_metre(equal, LENGTH) * RADIUS);
    // Squares of 1/sin θ have a mean, but no variance: of 200,000 such terms it is known to 1.7 % (their number to the power -1/3).
    assert!((variance / expected - 1.0).abs() < 0.05, "{variance:e} for {expected:e}");
}

#[test]
fn a_crowd_crosses_the_ball_of_the_crowd_radius() {
    let lines = 1000.0;
    let radius = crowd_radius(length_per_volume(lines));
    let centre = Vec3::new(0.1, -0.2, 0.3);
    let mut random = Stream::new(13);
    let mut crossing = 0;
    for _ in 0..LINES {
        let [direction, nearest] = line(&mut random);
        let offset = centre - nearest;
        let gap2 = offset.length_squared() - offset.dot(direction).powi(2);
        crossing += u32::from(f64::from(gap2) < radius * radius);
    }
    let found = f64::from(crossing) * lines / f64::from(LINES);
    // 16,000 of them: 0.8 %, three times.
    assert!((found / CROWD - 1.0).abs() < 0.024, "{found}");
}

#[test]
fn beams_of_unequal_power_are_as_many_as_would_be_as_noisy() {
    let scene = scene(8);
    let fogs = media::all(&scene);
    let layout = GridLayout { min: Vec3::ZERO, max: Vec3::ONE, cells: [4, 4, 4] };
    let beam = |y: f32, power: f32| {
        let (origin, direction) = (Vec3::new(-1.0, y, 0.6), Vec3::X);
        let beam = Beam { origin, direction, length: 1.75, power: Vec3::splat(power), ..Beam::default() };
        PathBeam { medium: 0, kind: Kind::Straight, near: 0.0, beam }
    };
    let mut voxels = BeamVoxels::new(layout);
    for _ in 0..2 {
        voxels.add(&[beam(0.3, 1.0), beam(0.4, 1.0), beam(0.9, 1.0), beam(0.8, 3.0)], &fogs);
    }
    let densities: Vec<f64> = voxels.densities().collect();
    for (index, density) in densities.into_iter().enumerate() {
        let [x, y, z] = [index % 4, index / 4 % 4, index / 16];
        // A quarter of a metre of each in a 64th of a cubic metre. The beams end at x = 0.75; 4²/10 of the unequal ones.
        let beams = match (x, y, z) {
            (0..3, 1, 2) => 2.0,
            (0..3, 3, 2) => 1.6,
            _ => 0.0,
        };
        // f32 lengths and exponentials.
        assert!((density - 16.0 * beams).abs() < 1e-4, "({x}, {y}, {z}): {density}");
    }
}

fn picture(scene: &Scene, rule: Option<RadiusRule>, planned: bool, passes: &[u32]) -> Picture {
    let method = if rule.is_some() { Method::Thesis } else { Method::Plain };
    let radius_rule = rule.unwrap_or_default();
    let settings = Settings { planned, radius_rule, ..Settings::of(method, 700, 3) };
    let mut renderer = Renderer::new(scene, settings);
    let mut film = Film::of_scene(scene);
    for index in passes {
        let (image, _) = renderer.pass(*index, &|| false).expect("not cancelled");
        film.add(&image).expect("finite");
    }
    film.picture()
}

#[test]
fn every_rule_gives_the_same_bits_for_any_number_of_threads_and_any_order_of_passes() {
    let scene = scene(32);
    let mut seen: Vec<Picture> = Vec::new();
    for (rule, planned) in RULES.into_iter().flat_map(|rule| [(rule, false), (rule, true)]) {
        let in_order = picture(&scene, Some(rule), planned, &[1, 2, 3, 4]);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().expect("threads");
        assert!(
            pool.install(|| picture(&scene, Some(rule), planned, &[1, 2, 3, 4])) == in_order,
            "{rule:?}: threads"
        );
        assert!(picture(&scene, Some(rule), planned, &[3, 1, 4, 2]) == in_order, "{rule:?}: order");
        assert!(seen.iter().all(|other| *other != in_order), "{rule:?} does what another does");
        seen.push(in_order);
    }
}

#[test]
fn a_pass_that_was_cancelled_leaves_no_trace_in_the_radii() {
    let scene = scene(32);
    for rule in RULES {
        let clean = picture(&scene, Some(rule), false, &[2]);
        for polls in [1, 8, 20, 40] {
            let settings = Settings { radius_rule: rule, ..Settings::of(Method::Thesis, 700, 3) };
            let mut renderer = Renderer::new(&scene, settings);
            let left = std::sync::atomic::AtomicI32::new(polls);
            let cancelled = || left.fetch_sub(1, std::sync::atomic::Ordering::Relaxed) <= 0;
            let gave_up = renderer.pass(4, &cancelled).is_none();
            assert!(gave_up, "{polls} polls are enough for a pass");
            let mut film = Film::of_scene(&scene);
            film.add(&renderer.pass(2, &|| false).expect("not cancelled").0).expect("finite");
            assert!(film.picture() == clean, "{rule:?} after {polls} polls");
        }
    }
}

#[test]
fn no_rule_makes_light() {
    let scene = scene(32);
    let mean = |picture: &Picture| {
        picture.radiance.iter().map(|radiance| f64::from(luminance(*radiance))).sum::<f64>()
    };
    let passes = [1, 2, 3, 4, 5, 6, 7, 8];
    let plain = mean(&picture(&scene, None, false, &passes));
    for rule in RULES {
        let ratio = mean(&picture(&scene, Some(rule), false, &passes)) / plain;
        // The same beams, moved by less than the kernels' largest radius: what crosses the picture's border, and next to the lamp.
        assert!((ratio - 1.0).abs() < 0.02, "{rule:?}: {ratio}");
    }
}
