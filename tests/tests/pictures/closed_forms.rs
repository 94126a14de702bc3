//! The bandwidth that the covariance grid predicts, beside that of fluences known in closed form.
//!
//! The truth at a point along an axis is σ² = max(|f''|/f, (f'/f)²)/(4π²): the covariance is an envelope that knows no
//! phase, so at an inflection the gradient speaks. Derivatives are central differences of the closed form over one voxel,
//! which is what a grid can know. Media absorb and hardly scatter, so that the closed form is the whole fluence.

use covbeam::{CovarianceGrid, FluenceCell, FluenceGrid, GridCell, GridLayout};
use covbeam_render::scene_file;
use covbeam_session::paths::{PhotonRecord, PhotonTracer, Record};
use covbeam_session::random::Emission;
use covbeam_session::scene::Scene;
use glam::{DVec3, Vec3};
use std::f64::consts::PI;
use std::path::Path;

/// Absorption of the test medium.
const ABSORPTION: f64 = 0.05;

/// A scene in a black box filled with a medium that hardly scatters.
fn scene(contents: &str) -> Scene {
    let text = format!(
        "outside_medium = \"air\"\n\
         [camera]\nposition = [0.0, 0.0, -19.0]\nlook_at = [0.0, 0.0, 0.0]\nvertical_fov = 30.0\nwidth = 8\nheight = 8\n\
         [[medium]]\nname = \"air\"\nscattering = 1e-7\nabsorption = {ABSORPTION}\n{contents}\n\
         [[object]]\nshape = \"box\"\nmin = [-20.0, -20.0, -20.0]\nmax = [20.0, 20.0, 20.0]\nmaterial = \"black\"\n"
    );
    scene_file::parse(&text, "closed form", Path::new(".")).expect("a valid scene")
}

fn tracer(scene: &Scene) -> PhotonTracer<'_> {
    PhotonTracer::new(scene, 7, Emission::LowDiscrepancy)
}

/// The light fields of `paths` light paths.
fn trace(scene: &Scene, paths: u32) -> PhotonRecord {
    let tracer = tracer(scene);
    let mut record = PhotonRecord::default();
    for index in 0..paths {
        tracer.trace(1, index, paths, Record::Field, &mut record);
    }
    record
}

/// A resolved grid.
struct Grid {
    layout: GridLayout,
    cells: Vec<FluenceCell>,
}

impl Grid {
    fn of(scene: &Scene, record: &PhotonRecord, min: Vec3, max: Vec3, cells: [u32; 3]) -> Self {
        let layout = GridLayout { min, max, cells };
        let mut sums = vec![GridCell::default(); layout.cell_count()];
        let mut grid = CovarianceGrid::new(layout, &mut sums).expect("a sound layout");
        tracer(scene).deposit_into(&mut grid, &record.deposits);
        let mut cells = vec![FluenceCell::default(); layout.cell_count()];
        grid.resolve(&mut cells).expect("as many cells");
        Self { layout, cells }
    }

    /// Predicted σ.
    fn sigma(&self, at: DVec3, axis: DVec3) -> f64 {
        let grid = FluenceGrid::new(self.layout, &self.cells).expect("a sound layout");
        let spectrum = grid.look_up(at.as_vec3()).expect("light reaches the whole line");
        f64::from(spectrum.variance_along(axis.as_vec3())).sqrt()
    }
}

/// True σ of `fluence` with derivatives over `step`.
fn truth(fluence: &impl Fn(DVec3) -> f64, at: DVec3, axis: DVec3, step: f64) -> f64 {
    let (before, here, after) = (fluence(at - step * axis), fluence(at), fluence(at + step * axis));
    let curvature = (before - 2.0 * here + after) / (step * step * here);
    let gradient = (after - before) / (2.0 * step * here);
    curvature.abs().max(gradient * gradient).sqrt() / (2.0 * PI)
}

/// Prints a row of the table, predicted / true, and asserts that the ratio is within `factor` either way.
fn row(
    case: &str,
    grid: &Grid,
    fluence: &impl Fn(DVec3) -> f64,
    (at, axis): (DVec3, DVec3),
    step: f64,
    factor: f64,
) {
    let (predicted, truth) = (grid.sigma(at, axis), truth(fluence, at, axis, step));
    let ratio = predicted / truth;
    println!(
        "{case:40} ({:6.3} {:6.3} {:6.3})  {predicted:8.4} / {truth:8.4} = {ratio:6.3}  (factor {factor})",
        at.x, at.y, at.z
    );
    assert!(ratio > 1.0 / factor && ratio < factor, "{case} at {at}: {ratio}, not within {factor}");
}

/// First order: what the method knows is exact, and noise, voxels and absorption are left.
const EXACT: f64 = 1.15;
/// A shape that the method knows by one number only, or terms beyond the first order.
const ROUGH: f64 = 2.0;
/// Curvatures of unlike signs, which cancel in part in the truth and whose envelopes add up in the prediction.
const CANCELLING: f64 = 2.2;

fn point_fluence(offset: DVec3) -> f64 {
    let d2 = offset.length_squared();
    (-ABSORPTION * d2.sqrt()).exp() / d2
}

#[test]
fn a_point_light() {
    let scene = scene("[[light]]\nkind = \"point\"\nposition = [0.0, 0.0, 0.0]\nintensity = 1.0\n");
    let record = trace(&scene, 60_000);
    let grid = Grid::of(&scene, &record, Vec3::new(0.5, -0.3, -0.3), Vec3::new(4.5, 0.3, 0.3), [40, 6, 6]);
    // Across the ray the truth is 2/d² + κ/d: a longer way through the medium is not in the light field. It takes
    // 1 - (1 + κ d/2)^(-1/2) off σ: 5 % at d = 4, 30 % at two mean free paths.
    for d in [1.0, 1.5, 2.0, 3.0, 4.0] {
        let at = DVec3::new(d, 0.0, 0.0);
        row("point light, across", &grid, &point_fluence, (at, DVec3::Y), 0.02, EXACT);
        row("point light, across", &grid, &point_fluence, (at, DVec3::new(0.0, 0.6, 0.8)), 0.02, EXACT);
        row("point light, along", &grid, &point_fluence, (at, DVec3::X), 0.02, EXACT);
        // At 45° to the ray the curvatures 6/d² and -2/d² cancel in part; an envelope adds them up, to √2 times σ.
        let oblique = DVec3::new(1.0, 1.0, 0.0).normalize();
        row("point light, oblique", &grid, &point_fluence, (at, oblique), 0.02, CANCELLING);
    }
}

#[test]
fn a_disk_light_without_occluders() {
    for radius in [0.05, 0.5] {
        let scene = scene(&format!(
            "[[light]]\nkind = \"disk\"\ncenter = [0.0, 0.0, 0.0]\nnormal = [0.0, 0.0, 1.0]\nradius = {radius}\nradiance = 1.0\n"
        ));
        let record = trace(&scene, 200_000);
        // Solid angle of the disk by the midpoint rule over rings and sectors.
        let fluence = |p: DVec3| {
            let (rings, sectors) = (24, 48);
            let mut sum = 0.0;
            for i in 0..rings {
                let rho = radius * ((f64::from(i) + 0.5) / f64::from(rings)).sqrt();
                for j in 0..sectors {
                    let (s, c) = ((f64::from(j) + 0.5) / f64::from(sectors) * 2.0 * PI).sin_cos();
                    let offset = p - DVec3::new(rho * c, rho * s, 0.0);
                    let d2 = offset.length_squared();
                    sum += (-ABSORPTION * d2.sqrt()).exp() * offset.z / (d2 * d2.sqrt());
                }
            }
            sum
        };
        for distance in [0.5, 1.0, 2.0, 4.0] {
            for angle in [0.0f64, 30.0, 50.0, 65.0, 75.0] {
                let (s, c) = angle.to_radians().sin_cos();
                let at = distance * DVec3::new(s, 0.0, c);
                let half = Vec3::splat(0.1 * distance as f32);
                let grid = Grid::of(&scene, &record, at.as_vec3() - half, at.as_vec3() + half, [1, 1, 1]);
                let step = 0.05 * distance;
                // Up to two radii away the disk's rim and its middle are seen under angles that no small-angle model joins.
                let factor = if distance >= 4.0 * radius { EXACT } else { ROUGH };
                let name = |axis| format!("disk R = {radius}, {angle} degrees, {axis}");
                let across = DVec3::new(c, 0.0, -s);
                row(&name("in plane"), &grid, &fluence, (at, across), step, factor);
                row(&name("out of plane"), &grid, &fluence, (at, DVec3::Y), step, factor);
                row(&name("along"), &grid, &fluence, (at, DVec3::new(s, 0.0, c)), step, factor);
            }
        }
    }
}

#[test]
fn the_penumbra_of_a_disk_light_behind_a_straight_edge() {
    let (radius, before) = (0.4, 4.0);
    let scene = scene(
        "[[light]]\nkind = \"disk\"\ncenter = [0.0, 0.0, -4.0]\nnormal = [0.0, 0.0, 1.0]\nradius = 0.4\nradiance = 1.0\n\
         [[object]]\nshape = \"rectangle\"\ncorner = [0.0, -15.0, 0.0]\nedge_u = [15.0, 0.0, 0.0]\nedge_v = [0.0, 30.0, 0.0]\nmaterial = \"black\"",
    );
    let record = trace(&scene, 300_000);
    for behind in [1.0, 2.0, 4.0] {
        // t = 1: the whole disk is seen, -1: nothing of it.
        let half = radius * behind / before;
        let visible = |t: f64| {
            let t = t.clamp(-1.0, 1.0);
            0.5 + (t.asin() + t * (1.0 - t * t).sqrt()) / PI
        };
        let fluence = |p: DVec3| {
            let offset = p + DVec3::new(0.0, 0.0, before);
            let d2 = offset.length_squared();
            visible(-p.x / half) * (-ABSORPTION * d2.sqrt()).exp() * offset.z / (d2 * d2.sqrt())
        };
        let (x, z) = (1.5 * half as f32, behind as f32);
        let cells = 60;
        let grid = Grid::of(
            &scene,
            &record,
            Vec3::new(-x, -1.0, z - 0.1),
            Vec3::new(x, 1.0, z + 0.1),
            [cells, 1, 1],
        );
        let voxel = 3.0 * half / f64::from(cells);
        let at = |t: f64| (DVec3::new(-t * half, 0.0, behind), DVec3::X);
        // Rays that pass the edge at 0 to 2 half-widths stand for the disk's chord: the shape is known by one number.
        for t in [1.0, 0.75, 0.25, 0.0, -0.25, -0.5] {
            row(&format!("penumbra at {behind}, t = {t}"), &grid, &fluence, at(t), voxel, ROUGH);
        }
        // The truth is smallest where the curvature takes over from the gradient; the prediction is smooth.
        row(&format!("penumbra at {behind}, t = 0.5"), &grid, &fluence, at(0.5), voxel, 1.1 * ROUGH);
        // Towards the dark end the truth grows without limit as 0.14/(1 + t), the prediction does not: too small by more
        // than two below t = -0.6, but hardly any light is there.
        let (mut light, mut too_small) = (0.0, 0.0);
        for i in 0..200 {
            let t = -1.0 + (f64::from(i) + 0.5) / 100.0;
            let (at, axis) = at(t);
            let ratio = grid.sigma(at, axis) / truth(&fluence, at, axis, voxel);
            light += visible(t);
            too_small += if ratio < 1.0 / ROUGH { visible(t) } else { 0.0 };
        }
        println!(
            "penumbra at {behind}: too small by more than {ROUGH} in {:.3} of its light",
            too_small / light
        );
        assert!(too_small / light < 0.025, "{too_small} of {light}");
    }
}

#[test]
fn the_rim_of_a_spot() {
    let (inner, outer) = (10f64.to_radians(), 20f64.to_radians());
    let scene = scene(
        "[[light]]\nkind = \"spot\"\nposition = [0.0, 0.0, 0.0]\nlook_at = [0.0, 0.0, 1.0]\nintensity = 1.0\ninner_angle = 10.0\nouter_angle = 20.0\n",
    );
    let record = trace(&scene, 200_000);
    let fluence = |p: DVec3| spot(p, DVec3::Z, inner, outer);
    let grid = Grid::of(&scene, &record, Vec3::new(0.2, -0.05, 2.9), Vec3::new(1.2, 0.05, 3.1), [50, 1, 1]);
    // q = 1: inner angle, 0: outer angle.
    for q in [1.5, 1.1, 1.0, 0.9, 0.75, 0.6, 0.5, 0.4, 0.25, 0.15, 0.1] {
        let (s, c) = (outer - q * (outer - inner)).sin_cos();
        let at = 3.0 / c * DVec3::new(s, 0.0, c);
        // The curvature jumps at q = 1: one voxel around it mixes both sides.
        let factor = if q == 1.0 { ROUGH } else { EXACT };
        let name = |axis| format!("spot rim, q = {q}, {axis}");
        row(&name("across"), &grid, &fluence, (at, DVec3::new(c, 0.0, -s)), 0.01, factor);
        row(&name("around"), &grid, &fluence, (at, DVec3::Y), 0.01, factor);
    }
}

/// Fluence of a spot at the origin that looks along `axis`.
fn spot(offset: DVec3, axis: DVec3, inner: f64, outer: f64) -> f64 {
    let theta = offset.cross(axis).length().atan2(offset.dot(axis));
    let q = ((outer - theta) / (outer - inner)).clamp(0.0, 1.0);
    q * q * (3.0 - 2.0 * q) * point_fluence(offset)
}

#[test]
fn two_crossing_spots() {
    let (inner, outer) = (4f64.to_radians(), 12f64.to_radians());
    let light = |position| {
        format!(
            "[[light]]\nkind = \"spot\"\nposition = {position}\nlook_at = [0.0, 0.0, 0.0]\nintensity = 1.0\ninner_angle = 4.0\nouter_angle = 12.0\n"
        )
    };
    let scene = scene(&(light("[-3.0, 0.0, 0.0]") + &light("[0.0, -3.0, 0.0]")));
    let record = trace(&scene, 400_000);
    let fluence = |p: DVec3| {
        spot(p + 3.0 * DVec3::X, DVec3::X, inner, outer) + spot(p + 3.0 * DVec3::Y, DVec3::Y, inner, outer)
    };
    let grid =
        Grid::of(&scene, &record, Vec3::new(-0.81, -0.03, -0.03), Vec3::new(0.81, 0.03, 0.03), [81, 1, 1]);
    let diagonal = DVec3::new(1.0, 1.0, 0.0).normalize();
    for x in [-0.5, -0.3, 0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6] {
        let at = DVec3::new(x, 0.0, 0.0);
        // Across both rays all signs are alike and the flux-weighted mean is exact.
        row("crossing spots, across both", &grid, &fluence, (at, DVec3::Z), 0.02, EXACT);
        // Elsewhere curvatures of unlike signs cancel in the truth, and a gradient of the fainter beam alone, g² f₂/f, is
        // more than that of the sum, (g f₂/f)²: too large by up to sqrt(f/f₂).
        let faint = spot(at + 3.0 * DVec3::Y, DVec3::Y, inner, outer);
        let factor = CANCELLING.max((fluence(at) / faint).sqrt());
        row("crossing spots, along the first", &grid, &fluence, (at, DVec3::X), 0.02, factor);
        row("crossing spots, along the second", &grid, &fluence, (at, DVec3::Y), 0.02, factor);
        row("crossing spots, diagonal", &grid, &fluence, (at, diagonal), 0.02, factor);
    }
}

#[test]
fn a_point_light_in_an_exponential_medium() {
    let (scale_height, scattering) = (1.0, 1e-7);
    for extinction in [0.1, 0.3, 1.0] {
        let text = format!(
            "outside_medium = \"air\"\n\
             [camera]\nposition = [0.0, 0.0, -19.0]\nlook_at = [0.0, 0.0, 0.0]\nvertical_fov = 30.0\nwidth = 8\nheight = 8\n\
             [[medium]]\nname = \"air\"\nscattering = {scattering}\nabsorption = {extinction}\n\
             density = {{ exponential = {{ origin = [0, 0, 0], up = [0, 1, 0], scale_height = {scale_height:?} }} }}\n\
             [[light]]\nkind = \"point\"\nposition = [0.0, 0.0, 0.0]\nintensity = 1.0\n\
             [[object]]\nshape = \"box\"\nmin = [-8.0, -4.0, -8.0]\nmax = [8.0, 8.0, 8.0]\nmaterial = \"black\"\n"
        );
        let scene = scene_file::parse(&text, "closed form", Path::new(".")).expect("a valid scene");
        let record = trace(&scene, 60_000);
        let grid =
            Grid::of(&scene, &record, Vec3::new(-0.2, -1.7, -0.5), Vec3::new(4.4, 2.7, 0.5), [46, 44, 10]);
        let fluence = |p: DVec3| {
            let d = p.length();
            // ∫ exp(-y/H) ds from height 0 to y.
            let rise = p.y / scale_height;
            let mean = if rise.abs() < 1e-9 { 1.0 } else { (1.0 - (-rise).exp()) / rise };
            (-extinction * d * mean).exp() / (d * d)
        };
        for d in [1.0, 2.0, 4.0] {
            for y in [-1.0, 0.0, 1.0, 2.0] {
                let at = DVec3::new(d, y, 0.0);
                let depth = -(fluence(at) * at.length_squared()).ln();
                let across = DVec3::new(-y, d, 0.0).normalize();
                let name = |axis| format!("exponential {extinction}, depth {depth:.2}, {axis}");
                // The depth's slope and curvature across the ray are known; κ/d of the longer way beside it is not: first order
                // in the depth. At a depth of 7, where a thousandth of the light is left, it is half of what there is level.
                let factor = match depth {
                    ..0.4 => EXACT,
                    ..5.0 => ROUGH,
                    _ => 3.0,
                };
                row(&name("across"), &grid, &fluence, (at, across), 0.02, factor);
                row(&name("level"), &grid, &fluence, (at, DVec3::Z), 0.02, factor);
                // Height is oblique to most rays: 6/d² and -2/d² cancel there.
                row(&name("height"), &grid, &fluence, (at, DVec3::Y), 0.02, factor.max(CANCELLING));
            }
        }
    }
}
