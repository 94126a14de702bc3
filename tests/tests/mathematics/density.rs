//! Densities and the columns along rays, against quadrature and closed forms.

use covbeam::{
    Column, Density, DensityGrid, Derivatives, ExponentialDensity, GridError, GridLayout, Knot, LightField,
    Medium, Vec3,
};
use covbeam_session::random::Random;

const LAYOUT: GridLayout =
    GridLayout { min: Vec3::new(-1.0, 0.5, 2.0), max: Vec3::new(2.0, 1.5, 4.0), cells: [7, 3, 5] };

fn random(seed: u32) -> Random {
    Random::new([seed, 3, 7, 0xde])
}

fn direction(random: &mut Random) -> Vec3 {
    let z = 2.0 * random.uniform() - 1.0;
    let (sin, cos) = (std::f32::consts::TAU * random.uniform()).sin_cos();
    let r = (1.0 - z * z).max(0.0).sqrt();
    Vec3::new(r * cos, z, r * sin).normalize()
}

fn values(random: &mut Random) -> Vec<f32> {
    // Ragged on purpose: zeros beside the largest.
    (0..LAYOUT.cell_count()).map(|_| (4.0 * random.uniform() - 1.0).max(0.0)).collect()
}

fn knots(density: &Density, origin: Vec3, direction: Vec3, length: f32, error: f32) -> Vec<Knot> {
    let mut knots = Vec::new();
    density.knots(origin, direction, length, error, f32::INFINITY, &mut |knot| knots.push(knot));
    knots
}

/// A trilinear look-up in f64, written for this test.
fn trilinear(values: &[f32], p: [f64; 3]) -> f64 {
    let (mut low, mut t) = ([0usize; 3], [0.0; 3]);
    for axis in 0..3 {
        let (min, max) = (f64::from(LAYOUT.min[axis]), f64::from(LAYOUT.max[axis]));
        if p[axis] < min || p[axis] > max {
            return 0.0;
        }
        let n = LAYOUT.cells[axis] as usize;
        let q = ((p[axis] - min) / (max - min) * n as f64 - 0.5).clamp(0.0, (n - 1) as f64);
        low[axis] = (q as usize).min(n - 2);
        t[axis] = q - low[axis] as f64;
    }
    let mut sum = 0.0;
    for corner in 0..8 {
        let bit = |axis: usize| corner >> axis & 1;
        let weight: f64 = (0..3).map(|axis| if bit(axis) == 1 { t[axis] } else { 1.0 - t[axis] }).product();
        let [x, y, z] = [low[0] + bit(0), low[1] + bit(1), low[2] + bit(2)];
        sum += weight * f64::from(values[(z * LAYOUT.cells[1] as usize + y) * LAYOUT.cells[0] as usize + x]);
    }
    sum
}

/// ∫ density ds up to each of `steps` equal distances by the midpoint rule on `fine` parts of each.
fn quadrature(
    values: &[f32],
    origin: Vec3,
    direction: Vec3,
    length: f64,
    steps: usize,
    fine: usize,
) -> Vec<f64> {
    let (o, d) = (origin.as_dvec3(), direction.as_dvec3());
    let h = length / (steps * fine) as f64;
    let mut sum = 0.0;
    let mut out = vec![0.0];
    for step in 0..steps {
        for i in 0..fine {
            let p = o + ((step * fine + i) as f64 + 0.5) * h * d;
            sum += h * trilinear(values, p.to_array());
        }
        out.push(sum);
    }
    out
}

#[test]
fn a_density_between_voxel_centres_is_trilinear() {
    let mut random = random(1);
    let values = values(&mut random);
    let density = Density::Grid(DensityGrid::new(LAYOUT, &values).unwrap());
    for _ in 0..2000 {
        let at = Vec3::new(random.uniform(), random.uniform(), random.uniform()) * 1.4 - 0.2;
        let p = LAYOUT.min + at * (LAYOUT.max - LAYOUT.min);
        let expected = trilinear(&values, p.as_dvec3().to_array());
        // f32 positions in a cell: a few 1e-7 of the coordinate over a voxel of 0.3, times differences of up to 3.
        assert!((f64::from(density.at(p)) - expected).abs() < 2e-5, "{p}: {} {expected}", density.at(p));
    }
}

#[test]
fn the_table_of_a_grid_is_within_its_error_of_the_integral() {
    let mut random = random(2);
    let values = values(&mut random);
    let density = Density::Grid(DensityGrid::new(LAYOUT, &values).unwrap());
    let mut most_knots = 0;
    for ray in 0..60 {
        let inside = LAYOUT.min
            + Vec3::new(random.uniform(), random.uniform(), random.uniform()) * (LAYOUT.max - LAYOUT.min);
        let d = if ray % 10 == 0 { Vec3::Z } else { direction(&mut random) };
        let origin = inside - if ray % 3 == 0 { 0.0 } else { 5.0 } * d;
        let truth = quadrature(&values, origin, d, 10.0, 250, 400);
        for error in [1e-2, 1e-3, 1e-4] {
            let knots = knots(&density, origin, d, 10.0, error);
            most_knots = most_knots.max(knots.len());
            let column = Column::Knots(&knots);
            for (i, truth) in truth.iter().enumerate() {
                let s = 0.04 * i as f32;
                let found = f64::from(column.at(s));
                // The midpoint rule's own error at the box's two faces: half a step of 1e-4 times a jump of up to 3.
                assert!(
                    (found - truth).abs() < f64::from(error) + 3e-4,
                    "ray {ray}, error {error}, s = {s}: {found} for {truth}"
                );
            }
            assert!(knots.windows(2).all(|k| k[0].distance < k[1].distance && k[0].column <= k[1].column));
        }
    }
    // At most 17 cells on a line; a chord of 1e-4 on a density that changes by 10 a metre is 9 mm long: 30 a cell.
    assert!(most_knots < 17 * 30, "{most_knots}");
}

/// Of ways that start inside, outside and at the border, end anywhere, or go along the axes, through cells that hold nothing and all others.
#[test]
fn a_column_without_a_table_is_the_integral() {
    let mut random = random(11);
    let values = values(&mut random);
    let grid = Density::Grid(DensityGrid::new(LAYOUT, &values).unwrap());
    let size = LAYOUT.max - LAYOUT.min;
    for way in 0..200 {
        let place = Vec3::from([0; 3].map(|_| 1.6 * random.uniform() - 0.3));
        let origin =
            LAYOUT.min + if way % 5 == 0 { place.clamp(Vec3::ZERO, Vec3::ONE) } else { place } * size;
        let direction = if way % 4 == 0 { Vec3::AXES[way / 4 % 3] } else { direction(&mut random) };
        let length = 4.0 * random.uniform() + 1e-3;
        let found = grid.column_over(origin, direction, length, f32::INFINITY);
        let expected = quadrature(&values, origin, direction, f64::from(length), 1, 20_000)[1];
        // The midpoint rule errs by as much where the density jumps at the box' sides: 3 x length/20,000.
        assert!(
            (f64::from(found) - expected).abs() < 1e-3,
            "{origin} {direction} {length}: {found}, {expected}"
        );
        let ended = grid.column_over(origin, direction, length, 0.1);
        assert!(ended <= found && (ended == found || ended > 0.1), "{ended} of {found}");
    }
    let nothing = [Vec3::NAN, Vec3::INFINITY].map(|origin| grid.column_over(origin, Vec3::X, 1.0, 1.0));
    assert_eq!(nothing, [0.0; 2]);
    let air = ExponentialDensity { origin: Vec3::ZERO, up: Vec3::Y, scale_height: 2.0 };
    for density in [Density::Uniform, Density::Exponential(air)] {
        let column = density.column(Vec3::ONE, Vec3::Y, &[]).at(3.0);
        assert_eq!(density.column_over(Vec3::ONE, Vec3::Y, 3.0, 1.0), column);
    }
}

#[test]
fn no_table_has_more_knots_than_the_density_says() {
    let mut random = random(9);
    for cells in [[7, 1, 1], [5, 4, 6], [2, 9, 3]] {
        let layout = GridLayout { cells, ..LAYOUT };
        // So jagged, and the error so small, that every cell is cut as often as may be.
        let values: Vec<f32> = (0..layout.cell_count()).map(|_| 1e6 * random.uniform()).collect();
        let density = Density::Grid(DensityGrid::new(layout, &values).unwrap());
        let (most, mut longest) = (density.most_knots(), 0);
        for _ in 0..500 {
            let at = Vec3::new(random.uniform(), random.uniform(), random.uniform());
            let (origin, d) = (LAYOUT.min + at * (LAYOUT.max - LAYOUT.min), direction(&mut random));
            longest =
                longest.max(knots(&density, origin - 9.0 * d, d, f32::INFINITY, f32::MIN_POSITIVE).len());
        }
        assert!(longest <= most && 3 * longest > most, "{longest} of {most}, {cells:?}");
    }
    assert_eq!(Density::Uniform.most_knots(), 0);
}

#[test]
fn a_finer_table_has_more_knots_and_an_empty_or_uniform_stretch_has_none_between() {
    let mut random = random(3);
    let values = values(&mut random);
    let grid = Density::Grid(DensityGrid::new(LAYOUT, &values).unwrap());
    let (origin, d) = (Vec3::new(-3.0, 1.0, 3.0), Vec3::X);
    let count = |density: &Density, error| knots(density, origin, d, f32::INFINITY, error).len();
    assert!(count(&grid, 1e-4) > 2 * count(&grid, 1e-2));
    let same = vec![2.5; LAYOUT.cell_count()];
    assert_eq!(count(&Density::Grid(DensityGrid::new(LAYOUT, &same).unwrap()), 1e-5), 2);
    let empty = vec![0.0; LAYOUT.cell_count()];
    assert_eq!(count(&Density::Grid(DensityGrid::new(LAYOUT, &empty).unwrap()), 1e-5), 2);
    assert_eq!(count(&Density::Uniform, 1e-5), 0);
}

#[test]
fn a_table_ends_where_its_column_is_reached_and_where_the_ray_ends() {
    let values = vec![2.0; LAYOUT.cell_count()];
    let density = Density::Grid(DensityGrid::new(LAYOUT, &values).unwrap());
    let origin = Vec3::new(-1.0, 1.0, 3.0);
    let mut last = Knot::default();
    density.knots(origin, Vec3::X, f32::INFINITY, 1e-3, 1.5, &mut |knot| last = knot);
    // Ends at the first cell border past 1.5 / 2; cells are 3/7 wide.
    assert!(last.column > 1.5 && last.column < 1.5 + 2.0 * 3.0 / 7.0, "{last:?}");
    let cut = knots(&density, origin, Vec3::X, 0.3, 1e-3);
    assert_eq!(cut.last().unwrap().distance, 0.3);
    assert!(knots(&density, origin - Vec3::Y * 5.0, Vec3::X, 9.0, 1e-3).is_empty());
    for bad in [Vec3::NAN, Vec3::INFINITY] {
        assert!(knots(&density, bad, Vec3::X, 9.0, 1e-3).is_empty());
        assert!(knots(&density, origin, bad, 9.0, 1e-3).is_empty());
    }
    assert!(knots(&density, origin, Vec3::X, f32::NAN, 1e-3).is_empty());
    // A clear medium asks for no accuracy at all.
    for error in [f32::NAN, 0.0, f32::INFINITY] {
        assert!(knots(&density, origin, Vec3::X, 1.0, error).len() >= 2);
    }
}

#[test]
fn an_exponential_column_is_its_closed_form_at_every_angle() {
    let air = ExponentialDensity { origin: Vec3::new(0.3, -0.2, 0.1), up: Vec3::Y, scale_height: 0.7 };
    let density = Density::Exponential(air);
    let mut random = random(4);
    for i in 0..500 {
        let mut d = direction(&mut random);
        if i % 5 == 0 {
            // Nearly level: where (1 - exp(-x))/x cancels.
            d = Vec3::new(1.0, 1e-4 * (random.uniform() - 0.5), 0.0).normalize();
        }
        let origin = 2.0 * Vec3::new(random.uniform(), random.uniform(), random.uniform()) - 1.0;
        let column = density.column(origin, d, &[]);
        let rate = f64::from(d.y) / 0.7;
        let start = (-(f64::from(origin.y) + 0.2) / 0.7).exp();
        for s in [1e-3, 0.1, 1.0, 3.0] {
            let expected = if rate.abs() < 1e-12 { start * s } else { -start * (-rate * s).exp_m1() / rate };
            let found = f64::from(column.at(s as f32));
            // Roundings of the height (1e-7 over 0.7) and of the product.
            assert!((found / expected - 1.0).abs() < 2e-6, "{d} {s}: {found} {expected}");
            let back = f64::from(column.distance_at(found as f32));
            // The inverse is worse conditioned by column / (density s) where the air thins out.
            let condition = expected / (start * (-rate * s).exp() * s);
            assert!((back / s - 1.0).abs() < 1e-6 * (1.0 + condition), "{d} {s}: {back}");
        }
    }
}

#[test]
fn a_ray_into_thin_air_never_reaches_more_than_its_whole_column() {
    let air = ExponentialDensity { origin: Vec3::ZERO, up: Vec3::Y, scale_height: 2.0 };
    let density = Density::Exponential(air);
    let up = density.column(Vec3::ZERO, Vec3::Y, &[]);
    assert_eq!(up.at(f32::INFINITY), 2.0);
    assert_eq!(up.distance_at(2.5), f32::INFINITY);
    // Light is down to 4e-8 of the column after 17 scale heights; below ground it is opaque long before.
    assert_eq!(density.opaque_distance(Vec3::ZERO, Vec3::Y, 100.0, &[]), 34.0);
    let down = density.column(Vec3::ZERO, -Vec3::Y, &[]);
    assert!(
        (density.opaque_distance(Vec3::ZERO, -Vec3::Y, 100.0, &[]) / (2.0 * 51f32.ln()) - 1.0).abs() < 1e-6
    );
    assert_eq!(down.at(f32::INFINITY), f32::MAX);
    assert_eq!(density.column(Vec3::ZERO, Vec3::X, &[]).at(f32::INFINITY), f32::MAX);
    // Beyond e^±80 the density is held.
    assert!(density.at(Vec3::Y * -1e9).is_finite() && density.at(Vec3::Y * 1e9) > 0.0);
    assert_eq!(Density::Uniform.opaque_distance(Vec3::ZERO, Vec3::Y, 7.0, &[]), 7.0);
}

#[test]
fn the_inverse_of_a_table_undoes_it() {
    let mut random = random(5);
    let values = values(&mut random);
    let density = Density::Grid(DensityGrid::new(LAYOUT, &values).unwrap());
    let knots = knots(&density, Vec3::new(-2.0, 0.9, 1.5), Vec3::new(0.8, 0.05, 0.6).normalize(), 9.0, 1e-3);
    let column = Column::Knots(&knots);
    let whole = knots.last().unwrap().column;
    for i in 1..1000 {
        let target = whole * i as f32 / 1000.0;
        let s = column.distance_at(target);
        assert!((column.at(s) - target).abs() < 2e-6 * whole, "{target}");
    }
    assert_eq!(column.distance_at(1.001 * whole), f32::INFINITY);
    assert_eq!(Column::Knots(&[]).distance_at(0.1), f32::INFINITY);
    assert_eq!(Column::Knots(&[]).at(3.0), 0.0);
    assert_eq!(Column::Uniform.distance_at(0.25), 0.25);
}

#[test]
fn the_derivatives_of_a_density_are_those_of_finite_differences() {
    let up = Vec3::new(0.48, 0.6, 0.64);
    let air = Density::Exponential(ExponentialDensity { origin: Vec3::ZERO, up, scale_height: 0.5 });
    let p = Vec3::new(0.1, 0.2, -0.1);
    let f = |p: glam::DVec3| (-(p.dot(up.as_dvec3())) / 0.5).exp();
    let h = 1e-3;
    let e = [glam::DVec3::X, glam::DVec3::Y, glam::DVec3::Z];
    let second = |a: usize, b: usize| {
        let at = |i: f64, j: f64| f(p.as_dvec3() + h * (i * e[a] + j * e[b]));
        (at(1.0, 1.0) - at(1.0, -1.0) - at(-1.0, 1.0) + at(-1.0, -1.0)) / (4.0 * h * h)
    };
    let expected = [second(0, 0), second(1, 1), second(2, 2), second(0, 1), second(0, 2), second(1, 2)];
    let found = air.derivatives(p);
    for (found, expected) in found.hessian.iter().zip(expected) {
        // Central differences of step 2h: relative error (2h/H)²/3 = 5e-6.
        assert!((f64::from(*found) / expected - 1.0).abs() < 1e-4, "{found} {expected}");
    }
    for (axis, e) in e.into_iter().enumerate() {
        let expected = (f(p.as_dvec3() + h * e) - f(p.as_dvec3() - h * e)) / (2.0 * h);
        assert!((f64::from(found.gradient[axis]) / expected - 1.0).abs() < 1e-4, "{found:?} {expected}");
    }
    // A grid that samples a quadratic has its second derivatives, exactly.
    let layout = GridLayout { min: Vec3::ZERO, max: Vec3::new(5.0, 10.0, 2.5), cells: [5, 5, 5] };
    let quadratic =
        |x: f32, y: f32, z: f32| 9.0 + x * x - 0.05 * y * y + 0.5 * z * z + 0.3 * x * y + x * z - 0.1 * y * z;
    let samples: Vec<f32> = (0..125)
        .map(|i| {
            quadratic((i % 5) as f32 + 0.5, 2.0 * (i / 5 % 5) as f32 + 1.0, 0.5 * (i / 25) as f32 + 0.25)
        })
        .collect();
    let grid = Density::Grid(DensityGrid::new(layout, &samples).unwrap());
    let found = grid.derivatives(Vec3::new(2.4, 5.1, 1.2));
    // At the voxel's centre, (2.5, 5, 1.25): 2x + 0.3y + z, -0.1y + 0.3x - 0.1z, z + x - 0.1y.
    let slope = Vec3::new(5.0 + 1.5 + 1.25, -0.5 + 0.75 - 0.125, 1.25 + 2.5 - 0.5);
    assert!(found.gradient.distance(slope) < 1e-4, "{found:?} {slope}");
    for (found, expected) in found.hessian.iter().zip([2.0, -0.1, 1.0, 0.3, 1.0, -0.1]) {
        // Differences of numbers around 30 in f32, over steps as small as 0.25.
        assert!((found - expected).abs() < 1e-4, "{found} {expected}");
    }
    assert_eq!(grid.derivatives(Vec3::splat(-1.0)), Derivatives::default());
    assert_eq!(Density::Uniform.derivatives(p), Derivatives::default());
    assert_eq!([Density::Uniform.step(), air.step(), grid.step()], [f32::INFINITY, 0.25, 0.5]);
}

#[test]
fn a_field_carried_through_thinning_air_gathers_the_curvature_on_its_way() {
    let air = ExponentialDensity { origin: Vec3::ZERO, up: Vec3::Y, scale_height: 0.7 };
    let density = Density::Exponential(air);
    for (direction, distance) in [(Vec3::new(0.8, 0.6, 0.0), 2.0), (Vec3::new(0.6, -0.8, 0.0), 1.0)] {
        // Parallel light keeps its spatial frequencies: the variance is the integral.
        let mut field = LightField::collimated(direction, f32::INFINITY);
        let origin = Vec3::new(0.2, 0.1, -0.3);
        field.travel_through(&Medium { density, ..Medium::homogeneous(0.4, 0.0) }, origin, distance);
        // τ's slope and curvature are τ/H and τ/H² upwards; what counts is how much the axis across the ray leans up.
        let depth = 0.4 * f64::from(density.column(origin, direction, &[]).at(distance));
        let lean = f64::from(direction.x);
        let relative = (depth * depth - depth).abs().max(depth * depth);
        let expected = relative / 0.49 * lean * lean / (4.0 * std::f64::consts::PI.powi(2));
        let fluence = field.fluence();
        let found = f64::from(fluence.xx + fluence.yy + fluence.zz);
        // The midpoint rule on steps of half a scale height: (1/2)²/24 = 1 %, twice that in the square.
        assert!((found / expected - 1.0).abs() < 0.021, "{found} {expected}");
    }
    let mut carried = LightField::point(Vec3::Z, 0.05);
    let mut travelled = carried;
    carried.travel_through(&Medium::homogeneous(0.4, 0.0), Vec3::ZERO, 3.0);
    travelled.travel(3.0);
    assert_eq!(carried, travelled);
}

#[test]
fn bad_densities_are_refused() {
    let count = LAYOUT.cell_count();
    assert_eq!(DensityGrid::new(LAYOUT, &vec![1.0; count - 1]).unwrap_err(), GridError::Length);
    for bad in [f32::NAN, f32::INFINITY, -1e-9] {
        let mut values = vec![1.0; count];
        values[count / 2] = bad;
        assert_eq!(DensityGrid::new(LAYOUT, &values).unwrap_err(), GridError::Value);
    }
    let layout = GridLayout { cells: [0, 3, 5], ..LAYOUT };
    assert_eq!(DensityGrid::new(layout, &[]).unwrap_err(), GridError::Layout);
}

#[test]
fn huge_densities_and_single_voxels_give_finite_columns() {
    for cells in [[1, 1, 1], [1, 2, 1], [2, 1, 1]] {
        let layout = GridLayout { min: Vec3::ZERO, max: Vec3::ONE, cells };
        let values = vec![f32::MAX; layout.cell_count()];
        let density = Density::Grid(DensityGrid::new(layout, &values).unwrap());
        assert_eq!(density.at(Vec3::splat(0.5)), f32::MAX);
        for knot in knots(&density, Vec3::new(0.5, 0.5, -1.0), Vec3::Z, 9.0, 1e-3) {
            assert!(knot.column.is_finite() && knot.distance.is_finite());
        }
    }
    let fog = Medium { scattering: Vec3::ONE, ..Medium::default() };
    assert_eq!(fog.transmittance(f32::MAX), Vec3::ZERO);
}

#[test]
fn an_exponential_density_is_a_number_wherever_it_is_asked_for() {
    // inf - inf and inf x 0 lie on the way to the height: above by far more than 80 scale heights, below, and level with the origin.
    let far = Vec3::new(f32::MAX, 0.0, 0.0);
    for (up, [at_far, at_near]) in
        [(Vec3::X, [-80.0f32, 80.0]), (-Vec3::X, [80.0, -80.0]), (Vec3::Y, [0.0, 0.0])]
    {
        let air = Density::Exponential(ExponentialDensity { origin: -far, up, scale_height: 1e-3 });
        assert_eq!(air.at(far), at_far.exp());
        let air = Density::Exponential(ExponentialDensity { origin: far, up, scale_height: 1e-3 });
        assert_eq!(air.at(-far), at_near.exp());
        let Derivatives { gradient, hessian } = air.derivatives(-far);
        assert!(gradient.is_finite() && hessian.iter().all(|second| second.is_finite()));
    }
}
