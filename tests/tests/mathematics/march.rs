//! Adaptive sampling along an eye ray: unbiased, where it should be dense, and what it does with bad input.

use covbeam::{MARCH_KNOTS, March, MarchCell, MarchError, MarchKnot, MarchSample, Vec3};
use covbeam_render::scene_file;
use covbeam_session::gather::march::{Marching, Placement};
use covbeam_session::pass::Renderer;
use covbeam_session::scene::Scene;
use covbeam_session::settings::{Method, Settings};
use covbeam_tests::random::Stream;
use covbeam_tests::single_scatter::{Density, Emission, Lamp, World};
use covbeam_tests::statistics::Sample;
use glam::DVec3;
use proptest::prelude::*;
use std::path::Path;

/// A lamp 0.7 m aside of a ray of 4 m, at its third metre; light in between as that of a point in clear air.
const LAMP: Vec3 = Vec3::new(0.7, 0.0, 3.0);
const LENGTH: f32 = 4.0;

fn light(distance: f32) -> f32 {
    1.0 / (0.49 + (distance - 3.0) * (distance - 3.0))
}

/// ∫ of [`light`]: arcs over the height.
fn exact(from: f64, to: f64) -> f64 {
    (((to - 3.0) / 0.7).atan() - ((from - 3.0) / 0.7).atan()) / 0.7
}

fn table(count: usize) -> Vec<MarchKnot> {
    let mut knots = vec![MarchKnot::default(); count];
    MarchKnot::lay(Vec3::ZERO, Vec3::Z, 0.0, LENGTH, LAMP, &mut knots).unwrap();
    for knot in &mut knots {
        knot.radiance = light(knot.distance);
    }
    knots
}

fn jitter(stream: &mut Stream, count: usize) -> Vec<f32> {
    (0..count).map(|_| stream.uniform() as f32).collect()
}

/// Both rounds, with `visible` for shadow rays.
fn two_rounds(
    knots: &[MarchKnot],
    rounds: [usize; 2],
    visible: impl Fn(f32) -> bool,
    stream: &mut Stream,
) -> [Vec<MarchSample>; 2] {
    let mut cells = vec![MarchCell::default(); knots.len()];
    let march = March::new(knots, &mut cells).unwrap();
    let [mut first, mut second] = rounds.map(|count| vec![MarchSample::default(); count]);
    march.place(&jitter(stream, rounds[0]), &mut first);
    for sample in &mut first {
        sample.visibility = if visible(sample.distance) { 1.0 } else { 0.0 };
    }
    march.refine(&first, &jitter(stream, rounds[1]), &mut second);
    [first, second]
}

fn estimate(samples: &[MarchSample], value: impl Fn(f32) -> f32) -> f64 {
    samples.iter().map(|s| f64::from(s.weight) * f64::from(value(s.distance))).sum()
}

#[test]
fn knots_are_laid_at_equal_angles_seen_from_the_light() {
    let mut knots = [MarchKnot::default(); 9];
    let (origin, direction) = (Vec3::new(1.0, -2.0, 0.5), Vec3::new(2.0, 3.0, 6.0) / 7.0);
    let light = Vec3::new(1.5, 0.5, 3.0);
    MarchKnot::lay(origin, direction, 0.5, 9.0, light, &mut knots).unwrap();
    assert_eq!((knots[0].distance, knots[8].distance), (0.5, 9.0));
    let places = knots.map(|knot| origin + knot.distance * direction - light);
    let whole = places[0].angle_between(places[8]);
    for pair in places.windows(2) {
        // An f32 angle of a few roundings at 10 m.
        assert!((pair[0].angle_between(pair[1]) - whole / 8.0).abs() < 1e-4);
    }
    assert!(
        knots.iter().all(|knot| knot.radiance == 0.0 && knot.deviation.is_nan() && knot.visibility.is_nan())
    );
}

#[test]
fn a_light_on_the_ray_and_a_ray_without_end_have_knots_too() {
    let mut knots = [MarchKnot::default(); 5];
    MarchKnot::lay(Vec3::ZERO, Vec3::Z, 1.0, 3.0, Vec3::new(0.0, 0.0, 2.0), &mut knots).unwrap();
    assert_eq!(knots.map(|knot| knot.distance), [1.0, 1.5, 2.0, 2.5, 3.0]);
    MarchKnot::lay(Vec3::ZERO, Vec3::Z, 0.0, f32::INFINITY, LAMP, &mut knots).unwrap();
    let end = knots[4].distance;
    let left = (0.7 / (end - 3.0)).atan();
    assert!(end.is_finite() && left < 1e-3, "{end}");
    for light in [Vec3::NAN, Vec3::splat(f32::INFINITY)] {
        let refused = MarchKnot::lay(Vec3::ZERO, Vec3::Z, 0.0, 1.0, light, &mut knots);
        assert_eq!(refused, Err(MarchError::Distance));
    }
    assert_eq!(MarchKnot::lay(Vec3::ZERO, Vec3::Z, 2.0, 1.0, LAMP, &mut knots), Err(MarchError::Distance));
    assert_eq!(MarchKnot::lay(Vec3::ZERO, Vec3::Z, 0.0, 1.0, LAMP, &mut knots[..1]), Err(MarchError::Length));
    assert_eq!(knots[4].distance, end, "a refused call has written");
}

#[test]
fn both_rounds_are_unbiased_and_a_wrong_weight_is_not() {
    // A bar of shadow and a thin gap in a second one; the table expects light elsewhere, to make it hard.
    let visible =
        |t: f32| !(0.8..1.9).contains(&t) && (!(2.9..3.4).contains(&t) || (3.10..3.13).contains(&t));
    let truth = exact(0.0, 0.8) + exact(1.9, 2.9) + exact(3.10, 3.13) + exact(3.4, 4.0);
    let mut knots = table(33);
    for (index, knot) in knots.iter_mut().enumerate() {
        knot.deviation = if index < 20 { 3.0 } else { 0.0 };
        knot.visibility = [0.9, 0.0, f32::NAN][index % 3];
    }
    for rounds in [[5, 1], [6, 3], [9, 21], [2, 40]] {
        let mut stream = Stream::new(7);
        let value = |t: f32| if visible(t) { light(t) } else { 0.0 };
        let runs: Vec<[f64; 2]> = (0..40_000)
            .map(|_| two_rounds(&knots, rounds, visible, &mut stream).map(|round| estimate(&round, value)))
            .collect();
        let z = |which: usize| {
            let sample = Sample::of(&runs.iter().map(|run| run[which]).collect::<Vec<_>>());
            (sample.mean - truth) / sample.error
        };
        // Eight tests at 4.5 standard errors: a false alarm in 2e4.
        assert!(z(0).abs() < 4.5 && z(1).abs() < 4.5, "{rounds:?}: {} {}", z(0), z(1));
    }
    // The control: a weight that is wrong by 3 % is seen.
    let mut stream = Stream::new(7);
    let wrong: Vec<f64> = (0..40_000)
        .map(|_| {
            0.97 * estimate(&two_rounds(&knots, [9, 21], visible, &mut stream)[1], |t| {
                if visible(t) { light(t) } else { 0.0 }
            })
        })
        .collect();
    let sample = Sample::of(&wrong);
    assert!((sample.mean - truth).abs() > 4.5 * sample.error);
}

#[test]
fn without_occluders_a_few_samples_give_the_closed_form_of_airlight() {
    let truth = exact(0.0, f64::from(LENGTH));
    let mut stream = Stream::new(3);
    let [first, second] = two_rounds(&table(MARCH_KNOTS), [4, 4], |_| true, &mut stream);
    for samples in [first, second] {
        // Between knots 1/97 of 2.6 rad apart, a straight line is off by 1e-3 at most.
        assert!((estimate(&samples, light) / truth - 1.0).abs() < 1e-3);
    }
}

#[test]
fn the_error_of_a_shadow_border_falls_with_the_square_of_the_samples_and_faster_with_a_first_round() {
    let visible = |t: f32| t < 2.345;
    let knots = table(MARCH_KNOTS);
    let variance = |rounds: [usize; 2], which: usize| {
        let mut stream = Stream::new(11);
        let runs: Vec<f64> = (0..4000)
            .map(|_| {
                let samples = &two_rounds(&knots, rounds, visible, &mut stream)[which];
                estimate(samples, |t| if visible(t) { light(t) } else { 0.0 })
            })
            .collect();
        let sample = Sample::of(&runs);
        sample.error * sample.error * sample.count
    };
    let (few, many) = (variance([8, 0], 0), variance([64, 0], 0));
    let slope = (many / few).log2() / 8f64.log2();
    // 4000 runs: each variance to 2 to 4 %; where the border lies in its stratum moves both by up to a factor of 1.5.
    assert!((slope + 2.0).abs() < 0.35, "slope {slope}");
    let guided = variance([20, 44], 1);
    assert!(guided < 0.15 * many, "{guided} {many}");
}

#[test]
fn the_second_round_crowds_where_the_visibility_changes() {
    let mut stream = Stream::new(5);
    let [first, second] = two_rounds(&table(MARCH_KNOTS), [12, 40], |t| t < 2.0, &mut stream);
    let before = first
        .iter()
        .filter(|sample| sample.distance < 2.0)
        .map(|sample| sample.distance)
        .next_back()
        .unwrap();
    let after = first.iter().map(|sample| sample.distance).find(|&distance| distance >= 2.0).unwrap();
    let inside = second.iter().filter(|sample| (before..after).contains(&sample.distance)).count();
    // A thirteenth of the light, if it were alone.
    assert!(inside > 8, "{inside} of 40 between {before} and {after}");
}

#[test]
fn a_high_variance_and_an_unsure_visibility_attract_samples() {
    let crowd = |change: &dyn Fn(&mut MarchKnot)| {
        let mut knots = table(MARCH_KNOTS);
        let middle = |t: f32| (1.0..2.0).contains(&t);
        for knot in &mut knots {
            (knot.deviation, knot.visibility) = (0.5, 0.5);
            if middle(knot.distance) {
                change(knot);
            }
        }
        let mut stream = Stream::new(9);
        let [first, _] = two_rounds(&knots, [200, 0], |_| true, &mut stream);
        first.iter().filter(|sample| middle(sample.distance)).count()
    };
    let plain = crowd(&|_| ());
    // Eight times the changes are twice the density, of what is not left to the light alone.
    let varied = crowd(&|knot| knot.deviation = 4.0);
    assert!((1.4..2.0).contains(&(varied as f32 / plain as f32)), "{varied} {plain}");
    assert!(crowd(&|knot| knot.visibility = 1.0) < plain);
    assert!(crowd(&|knot| knot.visibility = 0.0) < plain / 2);
}

#[test]
fn what_is_expected_is_the_tables_integral_and_its_error_the_spread_of_one_round() {
    let mut knots = table(513);
    for knot in &mut knots {
        knot.visibility = if knot.distance < 2.0 { 1.0 } else { 0.25 };
    }
    let mut cells = vec![MarchCell::default(); knots.len()];
    let march = March::new(&knots, &mut cells).unwrap();
    let truth = exact(0.0, 2.0) + 0.25 * exact(2.0, 4.0);
    // A knot's step where the visibility jumps, and a straight line between knots.
    assert!((f64::from(march.expected_radiance()) / truth - 1.0).abs() < 5e-3);
    assert!((f64::from(march.radiance()) / exact(0.0, 4.0) - 1.0).abs() < 1e-4);

    // Changes at random, as many as the deviation says: a telegraph signal.
    let mut stream = Stream::new(21);
    let mut knots = table(MARCH_KNOTS);
    knots.iter_mut().for_each(|knot| (knot.deviation, knot.visibility) = (1.5, 0.5));
    let mut cells = vec![MarchCell::default(); knots.len()];
    let march = March::new(&knots, &mut cells).unwrap();
    let mut squares = Vec::new();
    for _ in 0..4000 {
        let mut borders = vec![0.0];
        while *borders.last().unwrap() < 4.0 {
            let step = -(1.0 - stream.uniform()).ln() / 1.5;
            borders.push(borders.last().unwrap() + step);
        }
        let lit = stream.uniform() < 0.5;
        let visible = |t: f32| (borders.partition_point(|&b| b <= f64::from(t)) % 2 == 0) == lit;
        let pieces = borders.windows(2).enumerate().filter(|(i, _)| ((i + 1) % 2 == 0) == lit);
        let truth: f64 = pieces.map(|(_, piece)| exact(piece[0], piece[1].min(4.0))).sum();
        let mut samples = [MarchSample::default(); 64];
        march.place(&jitter(&mut stream, 64), &mut samples);
        let seen = estimate(&samples, |t| if visible(t) { light(t) } else { 0.0 });
        squares.push((seen - truth).powi(2));
    }
    let found = Sample::of(&squares).mean.sqrt() * 64.0;
    // A tenth of the strata follow other rules, and some strata hold two borders.
    assert!(
        (0.8..1.25).contains(&(found / f64::from(march.expected_error()))),
        "{found} {}",
        march.expected_error()
    );
}

#[test]
fn a_first_round_is_advised_where_the_changes_are_few() {
    let rounds = |deviation: f32, rays: usize| {
        let mut knots = table(MARCH_KNOTS);
        knots.iter_mut().for_each(|knot| (knot.deviation, knot.visibility) = (deviation, 0.5));
        let mut cells = vec![MarchCell::default(); knots.len()];
        March::new(&knots, &mut cells).unwrap().first_round(rays)
    };
    assert_eq!([rounds(0.25, 4), rounds(0.25, 0), rounds(5.0, 64)], [0, 0, 0]);
    assert!((10..32).contains(&rounds(0.25, 64)));
}

#[test]
fn bad_tables_are_refused_and_bad_values_count_as_dark_or_unknown() {
    let knots = table(9);
    let mut cells = vec![MarchCell::default(); 9];
    assert_eq!(March::new(&knots[..1], &mut cells[..1]).err(), Some(MarchError::Length));
    assert_eq!(March::new(&knots, &mut cells[..8]).err(), Some(MarchError::Length));
    for distance in [f32::NAN, f32::INFINITY, -1.0] {
        let mut bad = knots.clone();
        bad[4].distance = distance;
        assert_eq!(March::new(&bad, &mut cells).err(), Some(MarchError::Distance), "{distance}");
    }
    for value in [f32::NAN, f32::INFINITY, -1.0] {
        let (mut bad, mut dark) = (knots.clone(), knots.clone());
        (bad[4].radiance, dark[4].radiance) = (value, 0.0);
        (bad[2].deviation, bad[7].visibility) = (value, if value > 0.0 { f32::NAN } else { value });
        let samples = |knots: &[MarchKnot]| two_rounds(knots, [5, 7], |t| t < 2.0, &mut Stream::new(1));
        assert_eq!(samples(&bad), samples(&dark), "{value}");
    }
}

#[test]
fn a_dark_table_needs_no_shadow_ray_and_no_samples_are_no_error() {
    let mut knots = table(9);
    knots.iter_mut().for_each(|knot| knot.radiance = 0.0);
    let [first, second] = two_rounds(&knots, [3, 5], |_| true, &mut Stream::new(1));
    assert!(first.iter().chain(&second).all(|sample| sample.weight == 0.0 && sample.distance == 0.0));
    let [first, second] = two_rounds(&table(9), [0, 0], |_| true, &mut Stream::new(1));
    assert!(first.is_empty() && second.is_empty());
    // All knots at one place.
    let knots = [MarchKnot { distance: 2.0, radiance: 1.0, ..MarchKnot::default() }; 4];
    let [first, _] = two_rounds(&knots, [3, 0], |_| true, &mut Stream::new(1));
    assert!(first.iter().all(|sample| sample.weight == 0.0));
}

#[test]
fn a_huge_table_and_a_huge_round_keep_their_sums() {
    let knots = table(100_001);
    let [first, _] = two_rounds(&knots, [20_000, 0], |_| true, &mut Stream::new(1));
    // Radiances of the order 1 summed in f64, weights rounded to f32 each.
    assert!((estimate(&first, light) / exact(0.0, 4.0) - 1.0).abs() < 1e-6);
}

proptest! {
    #[test]
    fn samples_of_any_table_are_in_order_inside_it_and_where_light_is(
        steps in prop::collection::vec((0.0..1.0f32, -3..9i32, 0..4u8, -0.5..1.5f32), 2..40),
        rounds in [0..20usize, 0..20usize],
        seed in any::<u64>(),
    ) {
        let mut distance = -1.0;
        let knots: Vec<MarchKnot> = steps
            .iter()
            .map(|&(step, magnitude, kind, visibility)| {
                distance += step;
                let radiance = if kind == 0 { 0.0 } else { 10f32.powi(magnitude) };
                let deviation = [f32::NAN, 0.0, 0.1, 1e6][kind as usize];
                MarchKnot { distance, radiance, deviation, visibility }
            })
            .collect();
        let mut stream = Stream::new(seed);
        let found = two_rounds(&knots, rounds, |t| (3.0 * t).sin() > 0.0, &mut stream);
        prop_assert_eq!(&found, &two_rounds(&knots, rounds, |t| (3.0 * t).sin() > 0.0, &mut Stream::new(seed)));
        let lit = |t: f32| {
            knots.windows(2).any(|pair| {
                (pair[0].distance..=pair[1].distance).contains(&t) && pair[0].radiance.max(pair[1].radiance) > 0.0
            })
        };
        for samples in &found {
            let placed: Vec<_> = samples.iter().filter(|sample| sample.weight != 0.0).collect();
            prop_assert!(placed.iter().all(|sample| sample.weight.is_finite() && sample.weight > 0.0));
            prop_assert!(placed.windows(2).all(|pair| pair[0].distance <= pair[1].distance));
            prop_assert!(placed.iter().all(|sample| lit(sample.distance)), "{:?}", samples);
        }
    }

    /// Where the visibility is not known, a sample weighs what its stratum holds: the weights times the table add up to its integral.
    #[test]
    fn the_density_integrates_to_one(
        steps in prop::collection::vec((0.01..1.0f32, 0.0..2.0f32, 0.0..5.0f32), 2..40),
        count in 1..50usize,
        seed in any::<u64>(),
    ) {
        let mut distance = 0.0;
        let knots: Vec<MarchKnot> = steps
            .iter()
            .map(|&(step, radiance, deviation)| {
                distance += step;
                MarchKnot { distance, radiance, deviation, visibility: f32::NAN }
            })
            .collect();
        let [samples, _] = two_rounds(&knots, [count, 0], |_| true, &mut Stream::new(seed));
        let table = |t: f32| {
            let after = knots.partition_point(|knot| knot.distance <= t).clamp(1, knots.len() - 1);
            let (a, b) = (&knots[after - 1], &knots[after]);
            a.radiance + (t - a.distance) / (b.distance - a.distance) * (b.radiance - a.radiance)
        };
        let whole: f64 = knots
            .windows(2)
            .map(|p| 0.5 * f64::from(p[1].distance - p[0].distance) * f64::from(p[0].radiance + p[1].radiance))
            .sum();
        // An f32 distance in a cell 0.01 wide at 40 is a place in it to 4e-4.
        prop_assert!((estimate(&samples, table) / whole - 1.0).abs() < 1e-2);
    }
}

/// The black ball's room, lit as `lamp` says.
fn room(lamp: &str) -> Scene {
    let text = format!(
        "outside_medium = \"fog\"\n\
         [camera]\nposition = [0.1, 0.3, -3.9]\nlook_at = [0.2, 0.0, 0.0]\nvertical_fov = 40\nwidth = 12\nheight = 10\n\
         [[medium]]\nname = \"fog\"\nscattering = [0.3, 0.2, 0.1]\nabsorption = [0.0, 0.1, 0.02]\nphase = {{ henyey_greenstein = 0.4 }}\n\
         density = {{ exponential = {{ scale_height = 1.5 }} }}\n\
         [[object]]\nshape = \"sphere\"\ncenter = [0.1, 0.2, 0.4]\nradius = 0.6\nmaterial = \"black\"\n\
         [[object]]\nshape = \"box\"\nmin = [-4, -4, -4]\nmax = [4, 4, 4]\nmaterial = \"black\"\n\
         [[light]]\n{lamp}\nvisible = false\n\
         [grid]\ncells = [8, 8, 8]\n"
    );
    scene_file::parse(&text, "room", Path::new(".")).unwrap()
}

#[test]
fn the_picture_of_every_placement_is_that_of_the_quadrature() {
    let (position, axis) = (DVec3::new(0.9, 1.8, -0.4), DVec3::new(-0.5, -1.0, 0.4));
    let spot = "kind = \"spot\"\nposition = [0.9, 1.8, -0.4]\nlook_at = [0.4, 0.8, 0.0]\n\
                intensity = [9.0, 8.0, 7.0]\ninner_angle = 30\nouter_angle = 40\n";
    let point = "kind = \"point\"\nposition = [0.9, 1.8, -0.4]\nintensity = [9.0, 8.0, 7.0]\n";
    for (lamp, emission) in [
        (point, Emission::Even),
        (
            spot,
            Emission::Spot { axis: axis.normalize(), inner: 30f64.to_radians(), outer: 40f64.to_radians() },
        ),
    ] {
        let scene = room(lamp);
        let world = World {
            density: Density::Exponential { scale_height: 1.5 },
            scattering: DVec3::new(0.3, 0.2, 0.1),
            absorption: DVec3::new(0.0, 0.1, 0.02),
            asymmetry: 0.4,
            lamp: Lamp { position, intensity: DVec3::new(9.0, 8.0, 7.0), emission },
            ball: (DVec3::new(0.1, 0.2, 0.4), 0.6),
            room: (DVec3::splat(-4.0), DVec3::splat(4.0)),
        };
        let camera = &scene.camera;
        let truth: Vec<DVec3> = (0..camera.width * camera.height)
            .map(|i| {
                let (x, y) = ((i % camera.width) as f32 + 0.5, (i / camera.width) as f32 + 0.5);
                world.radiance(
                    camera.position.as_dvec3(),
                    camera.direction(x, y).as_dvec3().normalize(),
                    1000,
                )
            })
            .collect();
        let whole: f64 = truth.iter().map(|radiance| radiance.element_sum()).sum();
        for (placement, samples) in [
            (Placement::Adaptive, 2),
            (Placement::Adaptive, 24),
            (Placement::Uniform, 8),
            (Placement::EquiAngular, 8),
            (Placement::MaximumDensity, 16),
        ] {
            let runs: Vec<f64> = (1..=40)
                .map(|seed| {
                    let marching = Marching { placement, samples, centred: true };
                    let settings = Settings { marching, ..Settings::of(Method::March, 200, seed) };
                    let mut renderer = Renderer::new(&scene, settings);
                    let (image, _) = renderer.pass(1, &|| false).unwrap();
                    let sum: f64 = image.radiance.iter().map(|r| r.as_dvec3().element_sum()).sum();
                    sum / whole
                })
                .collect();
            let sample = Sample::of(&runs);
            // The column is kept to 5e-4 of the depth, the quadrature is off by half a step of 1000 at the ball's shadow: 5e-4 each.
            // Ten tests at 5 standard errors.
            let error = (sample.mean - 1.0).abs();
            assert!(error < 5.0 * sample.error + 1e-3, "{placement:?} with {samples}, {lamp}: {sample:?}");
            assert!(sample.error < 0.03, "{placement:?} could not see an error of a tenth: {sample:?}");
        }
    }
}

#[test]
fn the_marched_picture_is_the_same_bits_for_any_number_of_threads_and_any_order_of_passes() {
    let disk =
        "kind = \"disk\"\ncenter = [0.9, 1.8, -0.4]\nnormal = [0, -1, 0]\nradius = 0.3\nradiance = 9.0\n";
    let scene = room(disk);
    let picture = |threads: usize, passes: [u32; 2], seed: u32| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut renderer = Renderer::new(&scene, Settings::of(Method::March, 300, seed));
            let mut images = passes.map(|pass| (pass, renderer.pass(pass, &|| false).unwrap().0));
            images.sort_by_key(|image| image.0);
            images
        })
    };
    let one = picture(1, [1, 2], 3);
    assert!(one == picture(2, [1, 2], 3), "threads");
    assert!(one == picture(3, [2, 1], 3), "order");
    assert!(one != picture(1, [1, 2], 4), "the seed does nothing");
}

#[test]
fn a_cancelled_march_returns_nothing() {
    let scene = room("kind = \"point\"\nposition = [0.9, 1.8, -0.4]\nintensity = 1.0\n");
    assert!(Renderer::new(&scene, Settings::of(Method::March, 300, 1)).pass(1, &|| true).is_none());
}

#[test]
fn knots_are_laid_in_order_over_stretches_as_long_as_numbers_go() {
    let lights =
        [Vec3::new(1.0, 1.2, -0.7), Vec3::splat(1e18), Vec3::splat(-1e-30), Vec3::new(0.0, 0.0, 3.0)];
    let ends = [-f32::MAX, -1e30, -1.0, -1e-38, 0.0, 1e-38, 1.0, 1e30, f32::MAX];
    for light in lights {
        for (index, from) in ends.into_iter().enumerate() {
            for to in ends[index..].iter().copied() {
                let mut knots = [MarchKnot::default(); 7];
                let origin = Vec3::new(0.17, -0.0, -1e-38);
                MarchKnot::lay(origin, Vec3::Z, from, to, light, &mut knots).expect("a sound stretch");
                let distances = knots.map(|knot| knot.distance);
                assert!(
                    distances.is_sorted() && distances.iter().all(|d| d.is_finite()),
                    "{from} to {to}: {distances:?}"
                );
                assert!(distances[0] >= from && distances[6] == to, "{from} to {to}: {distances:?}");
            }
        }
    }
}
