//! The truth test itself on trial: on light that is known in closed form, with predictions that are wrong on purpose.

use covbeam::{FluenceCell, FluenceSpectrum, GridLayout};
use covbeam_render::scene_file;
use covbeam_render::study::spectrum::{
    Analysis, BATCHES, Fluence, Options, Prediction, Shares, Verdict, Voxel, analyse, compare, predict,
    summary, write_table,
};
use covbeam_session::scene::Scene;
use glam::DVec3;
use std::f64::consts::PI;
use std::path::Path;

/// In 32³ voxels over the whole room.
const GLASS: &str = concat!(
    include_str!("../../../scenes/glass-ball.toml"),
    "\n[grid]\nmin = [-4.0, -1.5, -6.0]\nmax = [4.0, 4.5, 4.0]\ncells = [32, 32, 32]\n"
);

/// A point light just outside a corner of the grid, in a medium that absorbs and hardly scatters, in a black room.
const LAMP: &str = r#"
outside_medium = "fog"
[camera]
position = [0.0, 0.0, -1.0]
look_at = [0.0, 0.0, 0.0]
vertical_fov = 35.0
width = 8
height = 8
[[medium]]
name = "fog"
scattering = 1e-5
absorption = 0.5
phase = "isotropic"
[[object]]
shape = "box"
min = [-2.0, -2.0, -2.0]
max = [3.0, 3.0, 3.0]
material = "black"
[[light]]
kind = "point"
position = [-0.15, -0.2, -0.1]
intensity = 10.0
[grid]
min = [0.0, 0.0, 0.0]
max = [0.8, 0.9, 1.0]
cells = [8, 9, 8]
"#;
const POSITION: DVec3 = DVec3::new(-0.15, -0.2, -0.1);
const INTENSITY: f64 = 10.0;
const EXTINCTION: f64 = 0.50001;

fn scene(text: &str) -> Scene {
    scene_file::parse(text, "test scene", Path::new(".")).expect("a valid scene")
}

fn index(layout: &GridLayout, [x, y, z]: [u32; 3]) -> usize {
    ((z * layout.cells[1] + y) * layout.cells[0] + x) as usize
}

fn size(layout: &GridLayout) -> DVec3 {
    (layout.max - layout.min).as_dvec3() / DVec3::from(layout.cells.map(f64::from))
}

/// Mean of I exp(-κd)/d² over each voxel of the lamp scene: midpoint rule, 8³ points. The integrand's second derivative
/// over its value is below 6/d² and d at least 2 voxels, so the error is below 6/(24 · 16²) · 3 = 3e-3 next to the lamp
/// and falls with 1/d².
fn closed_form(layout: &GridLayout) -> Vec<f64> {
    const POINTS: u32 = 8;
    let size = size(layout);
    let mut fluence = vec![0.0; layout.cell_count()];
    for z in 0..layout.cells[2] {
        for y in 0..layout.cells[1] {
            for x in 0..layout.cells[0] {
                let low = layout.min.as_dvec3() + DVec3::from([x, y, z].map(f64::from)) * size;
                let mut sum = 0.0;
                for i in 0..POINTS.pow(3) {
                    let part = [i % POINTS, i / POINTS % POINTS, i / POINTS / POINTS];
                    let at = low + size * (DVec3::from(part.map(f64::from)) + 0.5) / f64::from(POINTS);
                    let d = at.distance(POSITION);
                    sum += INTENSITY * (-EXTINCTION * d).exp() / (d * d);
                }
                fluence[index(layout, [x, y, z])] = sum / f64::from(POINTS.pow(3));
            }
        }
    }
    fluence
}

/// The standard deviation that the closed form's differences around an inner voxel tell, written afresh.
fn sigma(layout: &GridLayout, fluence: &[f64], cell: [u32; 3], axis: usize) -> f64 {
    let at = |step: i32| {
        let mut cell = cell;
        cell[axis] = cell[axis].wrapping_add_signed(step);
        fluence[index(layout, cell)]
    };
    let h = size(layout)[axis];
    let mean = (at(-1) + 2.0 * at(0) + at(1)) / 4.0;
    let curvature = (at(1) - at(0) - (at(0) - at(-1))) / (h * h) / mean;
    let gradient = (at(1) - at(-1)) / (2.0 * h) / mean;
    curvature.abs().max(gradient.powi(2)).sqrt() / (2.0 * PI)
}

fn options(scene: &Scene, passes: u32, paths: u32) -> Options {
    let prediction = Prediction { passes, field_paths: 500, seed: 1 };
    Options { cells: scene.grid.cells, prediction, paths }
}

fn shares(scene: &Scene, voxels: Vec<Voxel>) -> Shares {
    let analysis = Analysis { layout: scene.grid, options: options(scene, 1, BATCHES), voxels };
    Shares::of(&analysis, |_, _, axis| (!axis.flat).then_some(axis.verdict))
}

#[test]
fn the_measured_fluence_and_its_spectrum_are_those_of_the_closed_form() {
    let scene = scene(LAMP);
    let layout = scene.grid;
    let truth = closed_form(&layout);
    let analysis = analyse(&scene, &options(&scene, 1, 4_000_000), &|_| true).expect("not cancelled");
    let (mut axes, mut misses) = (0, 0);
    for (voxel, truth_here) in analysis.voxels.iter().zip(&truth) {
        // 5 standard errors (estimated from 16 batches: t-distributed), and 0.3 % of quadrature and scattering.
        let allowed = 5.0 * voxel.noise + 0.003;
        assert!(
            (voxel.fluence / truth_here - 1.0).abs() < allowed,
            "{:?}: {voxel:?}, {truth_here}",
            voxel.cell
        );
        assert_eq!(voxel.medium, 1.0, "all fog");
        for (axis, found) in voxel.axes.iter().enumerate() {
            let inner = (1..layout.cells[axis] - 1).contains(&voxel.cell[axis]);
            assert_eq!(found.verdict == Verdict::Border, !inner);
            let Some(measured) = found.measured else { continue };
            let exact = sigma(&layout, &truth, voxel.cell, axis);
            let error = 0.5 * (measured.high - measured.low);
            // 2 % for the quadrature next to the lamp: 3e-3 of f is 3 to 4 times as much of a second difference, half
            // of that of its root.
            misses += u32::from((measured.sigma - exact).abs() > 4.0 * error + 0.02 * exact);
            axes += 1;
        }
    }
    assert_eq!(axes, 6 * 9 * 8 + 8 * 7 * 8 + 8 * 9 * 6);
    // Far from the lamp the curvature is small beside its noise, which has more than a Gaussian's tails: 16 batches.
    assert!(misses <= axes / 200, "{misses} of {axes}");
}

/// Shares of a prediction that is `factor` times what differences of the fluence
/// exp(amplitude (sin(x/h) + sin(y/h) + sin(z/h))) tell, h the voxels' size. None = no prediction at all.
fn shares_of_wave(amplitude: f64, factor: Option<f64>) -> Shares {
    let scene = scene(LAMP);
    let layout = scene.grid;
    let [nx, ny, _] = layout.cells;
    let cell_of = |i: u32| [i % nx, i / nx % ny, i / nx / ny];
    let count = layout.cell_count() as u32;
    let wave = |i| (amplitude * cell_of(i).map(|x| f64::from(x).sin()).iter().sum::<f64>()).exp();
    let truth: Vec<f64> = (0..count).map(wave).collect();
    let batch: Vec<f32> = truth.iter().map(|f| *f as f32).collect();
    let fluence = Fluence { batches: vec![batch; 2], shares: vec![[1.0, 0.0, 0.0]; truth.len()] };
    let predicted = |i| {
        let factor = factor?;
        // Of the nearest inner voxel.
        let mut cell = cell_of(i);
        for (x, n) in cell.iter_mut().zip(layout.cells) {
            *x = (*x).clamp(1, n - 2);
        }
        let variance = |axis| (factor * sigma(&layout, &truth, cell, axis)).powi(2) as f32;
        let (xx, yy, zz) = (variance(0), variance(1), variance(2));
        let spectrum = FluenceSpectrum { xx, yy, zz, ..Default::default() };
        Some(FluenceCell { spectrum, weight: 1.0 })
    };
    let cells: Vec<FluenceCell> = (0..count).map(|i| predicted(i).unwrap_or_default()).collect();
    shares(&scene, compare(&scene, &layout, &cells, &fluence))
}

#[test]
fn a_right_prediction_passes_and_one_that_is_three_times_off_is_caught() {
    for amplitude in [0.5, 1.2] {
        let right = shares_of_wave(amplitude, Some(1.0));
        assert!(right.judged() > 500.0, "too few voxels are rough: {}", right.judged());
        assert_eq!(right.by_count(Verdict::Within), 1.0, "{right:?}");
    }
    // Of smooth waves three times the deviation is still below the upper bound, of steep ones a third above the lower.
    for (amplitude, factor, verdict) in [(0.5, 3.0, Verdict::TooLarge), (1.2, 1.0 / 3.0, Verdict::TooSmall)] {
        let wrong = shares_of_wave(amplitude, Some(factor));
        assert!(wrong.by_count(verdict) > 0.8, "{factor}: {wrong:?}");
        assert_eq!(wrong.by_count(verdict) + wrong.by_count(Verdict::Within), 1.0, "{factor}: {wrong:?}");
    }
    assert_eq!(shares_of_wave(1.0, None).by_count(Verdict::NoData), 1.0);
}

#[test]
fn a_measurement_in_noise_is_undecided_and_more_light_paths_decide_it() {
    let scene = scene(GLASS);
    let undecided = |paths| {
        let analysis = analyse(&scene, &options(&scene, 1, paths), &|_| true).expect("not cancelled");
        Shares::of(&analysis, |_, _, axis| Some(axis.verdict)).undecided()[0]
    };
    let (few, many) = (undecided(64_000), undecided(2_000_000));
    assert!(few > 0.3, "{few}");
    assert!(many < 0.02, "{many}");
}

#[test]
fn what_is_no_medium_in_all_voxels_is_the_volume_of_the_objects() {
    let mut scene = scene(GLASS);
    scene.grid = GridLayout {
        min: glam::Vec3::new(-0.6, -0.7, -0.65),
        max: glam::Vec3::new(0.7, 0.6, 0.65),
        cells: [13; 3],
    };
    let black = GLASS.replace("{ dielectric = { index = 1.5 } }", "\"black\"");
    for scene in [scene.clone(), Scene { objects: self::scene(&black).objects, ..scene }] {
        let fluence =
            Fluence { batches: vec![vec![1.0; 13 * 13 * 13]; 2], shares: vec![[0.0; 3]; 13 * 13 * 13] };
        let cells = vec![FluenceCell::default(); 13 * 13 * 13];
        let voxels = compare(&scene, &scene.grid, &cells, &fluence);
        let missing: f64 = voxels.iter().map(|voxel| 1.0 - f64::from(voxel.medium)).sum();
        let volume = missing * size(&scene.grid).element_product();
        // Some 400 voxels on the sphere, 216 jittered points each: 1 % is 10 standard errors.
        let truth = 4.0 / 3.0 * PI * 0.5_f64.powi(3);
        assert!((volume / truth - 1.0).abs() < 0.01, "{volume} of {truth}");
        // No stencil may reach into the ball: its reach is 1.5 voxels of 0.1.
        for voxel in &voxels {
            let distance = voxel.center.length();
            let judged = voxel.axes.iter().any(|axis| axis.measured.is_some());
            assert!(distance > 0.5 || !judged, "{:?} is in the ball", voxel.center);
            let inner = voxel.cell.iter().all(|i| (1..12).contains(i));
            assert!(distance < 0.75 || !inner || judged, "{:?} is left out", voxel.center);
        }
    }
}

#[test]
fn a_thin_wall_between_two_voxels_is_noticed() {
    // A black sheet exactly on the faces between the fourth and the fifth voxels along y.
    let wall = r#"
[[object]]
shape = "rectangle"
corner = [-2.0, 0.4, -2.0]
edge_u = [5.0, 0.0, 0.0]
edge_v = [0.0, 0.0, 5.0]
material = "black"
[[light]]"#;
    let scene = scene(&LAMP.replacen("[[light]]", wall, 1));
    let count = scene.grid.cell_count();
    let fluence = Fluence { batches: vec![vec![1.0; count]; 2], shares: vec![[0.0; 3]; count] };
    let voxels = compare(&scene, &scene.grid, &vec![FluenceCell::default(); count], &fluence);
    for voxel in voxels {
        // Only differences across it are spoilt.
        assert_eq!(
            voxel.axes[1].verdict == Verdict::Surface,
            [3, 4].contains(&voxel.cell[1]),
            "{:?}",
            voxel.cell
        );
        assert!(voxel.axes[0].verdict != Verdict::Surface && voxel.axes[2].verdict != Verdict::Surface);
    }
}

#[test]
fn the_result_is_the_same_bits_for_any_number_of_threads() {
    let scene = scene(GLASS);
    let options = options(&scene, 2, 16_000);
    let with_threads = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let analysis = pool.install(|| analyse(&scene, &options, &|_| true)).expect("not cancelled");
        let mut table = Vec::new();
        write_table(&analysis, &mut table).unwrap();
        let text = summary(&analysis, "test");
        (analysis.voxels, table, text)
    };
    let one = with_threads(1);
    assert!(one == with_threads(5));
    assert_eq!(
        one.1
            .split(|byte| *byte == b'\n')
            .filter(|line| line.first().is_some_and(u8::is_ascii_digit))
            .count(),
        32_768
    );
}

#[test]
fn more_passes_reach_more_voxels_and_another_seed_gives_another_prediction() {
    let scene = scene(GLASS);
    let cells = |passes, seed| {
        let prediction = Prediction { passes, field_paths: 100, seed };
        predict(&scene, &scene.grid, &prediction, &|_| true).expect("not cancelled")
    };
    let reached = |cells: &[FluenceCell]| cells.iter().filter(|cell| cell.weight > 0.0).count();
    assert!(reached(&cells(1, 1)) < reached(&cells(4, 1)));
    assert!(cells(1, 1) != cells(1, 2), "the seed does nothing");
}

#[test]
fn a_test_that_is_cancelled_returns_nothing() {
    let scene = scene(LAMP);
    assert!(analyse(&scene, &options(&scene, 1, 1_000_000), &|_| false).is_none());
    assert!(analyse(&scene, &options(&scene, 1, 1_000_000), &|done| done < 0.5).is_none());
}
