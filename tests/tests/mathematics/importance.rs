//! Importance in voxels, weight windows and guided emission against closed forms, quadrature in f64 and counting.

use covbeam::{
    Density, EmissionGuide, ExponentialDensity, GridError, GridLayout, Importance, ImportanceCell,
    ImportanceGrid, ImportanceSums, Medium, weight_window,
};
use covbeam_tests::random::Stream;
use glam::{DVec3, Vec3};
use std::f64::consts::PI;

const NOTHING: ImportanceSums = ImportanceSums { seen: 0.0, scattered: 0.0, surface: 0.0 };

/// Voxels of .1 m: the longest stretch in one is .173 m.
const LAYOUT: GridLayout =
    GridLayout { min: Vec3::new(-1.0, -2.0, 0.5), max: Vec3::new(3.0, 1.0, 2.5), cells: [40, 30, 20] };
const LONGEST: f64 = 0.174;

/// Of the channels of [`coloured`].
const SCATTERING: DVec3 = DVec3::new(0.3, 0.6, 0.9);
const EXTINCTION: DVec3 = DVec3::new(0.7, 0.8, 0.9);

/// A medium whose channels differ.
fn coloured() -> Medium<'static> {
    Medium {
        scattering: Vec3::new(0.3, 0.6, 0.9),
        absorption: Vec3::new(0.4, 0.2, 0.0),
        ..Medium::homogeneous(0.0, 0.0)
    }
}

fn voxel(layout: &GridLayout, index: usize) -> [usize; 3] {
    let [nx, ny, _] = layout.cells.map(|cells| cells as usize);
    [index % nx, index / nx % ny, index / nx / ny]
}

fn side(layout: &GridLayout) -> DVec3 {
    (layout.max.as_dvec3() - layout.min.as_dvec3()) / DVec3::from_array(layout.cells.map(f64::from))
}

/// Where a segment is in a voxel, by the slabs of its six sides; None where it is not.
fn stretch(
    layout: &GridLayout,
    index: usize,
    origin: DVec3,
    direction: DVec3,
    length: f64,
) -> Option<[f64; 2]> {
    let low =
        layout.min.as_dvec3() + DVec3::from_array(voxel(layout, index).map(|at| at as f64)) * side(layout);
    let (a, b) = ((low - origin) / direction, (low + side(layout) - origin) / direction);
    let (from, to) = (a.min(b).max_element().max(0.0), a.max(b).min_element().min(length));
    (to > from).then_some([from, to])
}

/// Some segments: from inside and, unless told not to, from outside the box, short, long and without an end.
fn segments(outside: bool) -> Vec<(Vec3, Vec3, f32)> {
    let mut stream = Stream::new(7);
    (0..24)
        .map(|number| {
            let unit = Vec3::from_array([0, 1, 2].map(|_| stream.uniform() as f32));
            let inside = LAYOUT.min + unit * (LAYOUT.max - LAYOUT.min);
            let direction = stream.direction().normalize();
            let back = if outside && number % 3 == 0 { 6.0 } else { 0.0 };
            let length = [f32::INFINITY, 0.05, 1.0, 7.0][number % 4];
            (inside - back * direction, direction, length)
        })
        .collect()
}

#[test]
fn deposits_are_the_integral_of_the_transmittance() {
    let medium = coloured();
    for (origin, direction, length) in segments(true) {
        let weight = 3.0;
        let mut cells = vec![NOTHING; LAYOUT.cell_count()];
        let mut grid = ImportanceGrid::new(LAYOUT, &mut cells).unwrap();
        grid.add_eye_ray(&medium, origin, direction, length, weight);
        grid.add_path(&medium, origin, direction, length, 2.0 * weight);
        let [mut found, mut exact] = [0.0; 2];
        for (index, cell) in cells.iter().enumerate() {
            let range = stretch(&LAYOUT, index, origin.as_dvec3(), direction.as_dvec3(), f64::from(length));
            let of_channels = range.map_or(DVec3::ZERO, |[from, to]| {
                f64::from(weight) * ((-EXTINCTION * from).exp() - (-EXTINCTION * to).exp()) / EXTINCTION
            });
            let (scattered, seen) =
                ((SCATTERING * of_channels).element_sum() / 3.0, of_channels.element_sum() / 3.0);
            // The transmittance in a stretch's middle stands for its mean: (σh)²/24 = 1e-3 of it at most; and f32 for the stretch, 1e-6 m.
            let error = (EXTINCTION.max_element() * LONGEST).powi(2) / 24.0 * seen + 1e-5;
            assert!((cell.seen - scattered).abs() < error, "{origin} {direction} {length}: {cell:?}, {seen}");
            assert!(
                (cell.scattered - 2.0 * seen).abs() < 2.0 * error,
                "{origin} {direction}: {cell:?}, {seen}"
            );
            assert_eq!(cell.surface, 0.0);
            found += cell.seen;
            exact += scattered;
        }
        assert!((found / exact - 1.0).abs() < 1e-3 || exact == 0.0 && found == 0.0, "{found} {exact}");
    }
}

#[test]
fn deposits_in_thinning_air_are_quadrature() {
    let air = ExponentialDensity { origin: Vec3::new(0.0, -1.0, 0.0), up: Vec3::Y, scale_height: 0.7 };
    let medium = Medium { density: Density::Exponential(air), ..coloured() };
    let density = |p: DVec3| (-(p.y + 1.0) / 0.7).exp();
    for (origin, direction, length) in segments(false) {
        let mut cells = vec![NOTHING; LAYOUT.cell_count()];
        let mut grid = ImportanceGrid::new(LAYOUT, &mut cells).unwrap();
        grid.add_eye_ray(&medium, origin, direction, length, 1.0);
        grid.add_path(&medium, origin, direction, length, 1.0);
        let [found, found_scattered] =
            [cells.iter().map(|cell| cell.seen).sum::<f64>(), cells.iter().map(|cell| cell.scattered).sum()];
        let (origin, direction) = (origin.as_dvec3(), direction.as_dvec3());
        let (low, high) = (LAYOUT.min.as_dvec3(), LAYOUT.max.as_dvec3());
        let end = ((low - origin) / direction).max((high - origin) / direction).min_element();
        let end = end.min(f64::from(length));
        // Midpoint rule, 1 mm or less.
        let (steps, mut column, mut exact) = (8000, 0.0, [0.0; 2]);
        let step = end / f64::from(steps);
        for k in 0..steps {
            let here = density(origin + (f64::from(k) + 0.5) * step * direction);
            let passes = (-EXTINCTION * (column + 0.5 * here * step)).exp() * step / 3.0;
            exact = [exact[0] + here * SCATTERING.dot(passes), exact[1] + passes.element_sum()];
            column += here * step;
        }
        // The density in a stretch's middle stands for its mean, to (h/H)²/24 = 2.6e-3 at most; the transmittance as above, to 1.4e-2 where
        // the air is 4.2 times as dense. Few stretches are so long and so low.
        for (found, exact) in [(found, exact[0]), (found_scattered, exact[1])] {
            assert!((found / exact - 1.0).abs() < 8e-3, "{origin} {direction} {length}: {found} {exact}");
        }
    }
}

#[test]
fn without_extinction_a_deposit_is_the_length() {
    let clear = Medium::homogeneous(0.0, 0.0);
    let mut cells = vec![NOTHING; LAYOUT.cell_count()];
    let mut grid = ImportanceGrid::new(LAYOUT, &mut cells).unwrap();
    grid.add_path(&clear, Vec3::new(-5.0, 0.05, 1.05), Vec3::X, f32::INFINITY, 1.0);
    grid.add_eye_ray(&clear, Vec3::new(-5.0, 0.05, 1.05), Vec3::X, f32::INFINITY, 1.0);
    assert!((cells.iter().map(|cell| cell.scattered).sum::<f64>() - 4.0).abs() < 1e-5);
    assert!(cells.iter().all(|cell| cell.seen == 0.0));
}

#[test]
fn surfaces_count_where_they_are_and_merged_grids_are_their_sums() {
    let mut stream = Stream::new(3);
    let mut halves = [0, 1].map(|_| vec![NOTHING; LAYOUT.cell_count()]);
    let mut exact = vec![NOTHING; LAYOUT.cell_count()];
    for half in &mut halves {
        let mut grid = ImportanceGrid::new(LAYOUT, half).unwrap();
        for _ in 0..500 {
            let at = [0, 1, 2].map(|axis| stream.between(-0.2, f64::from(LAYOUT.cells[axis]) + 0.2));
            let weight = stream.uniform() as f32 + 0.1;
            let place = LAYOUT.min.as_dvec3() + DVec3::from_array(at) * side(&LAYOUT);
            grid.add_surface(place.as_vec3(), weight);
            let [x, y, z] = at.map(|at| at.floor() as i64);
            let [nx, ny, nz] = LAYOUT.cells.map(i64::from);
            if (0..nx).contains(&x) && (0..ny).contains(&y) && (0..nz).contains(&z) {
                exact[((z * ny + y) * nx + x) as usize].surface += f64::from(weight);
            }
        }
    }
    let [mut first, second] = halves;
    let expected: Vec<f64> = first.iter().zip(&second).map(|(a, b)| a.surface + b.surface).collect();
    let mut grid = ImportanceGrid::new(LAYOUT, &mut first).unwrap();
    grid.merge(&second).unwrap();
    assert_eq!(grid.merge(&second[1..]), Err(GridError::Length));
    for ((cell, expected), exact) in first.iter().zip(expected).zip(exact) {
        assert_eq!(cell.surface, expected);
        assert!((cell.surface - exact.surface).abs() < 1e-6, "{cell:?} {exact:?}");
    }
}

fn resolved(layout: GridLayout, cells: &mut [ImportanceSums]) -> Vec<ImportanceCell> {
    let mut out = vec![ImportanceCell::default(); cells.len()];
    ImportanceGrid::new(layout, cells).unwrap().resolve(&mut out).unwrap();
    out
}

#[test]
fn a_voxel_is_smoothed_over_its_neighbours_and_nothing_is_lost() {
    let volume = side(&LAYOUT).element_product();
    let at = 13 + 40 * (11 + 30 * 7);
    let mut cells = vec![NOTHING; LAYOUT.cell_count()];
    cells[at] = ImportanceSums { seen: 2.0, scattered: 3.0, surface: 5.0 };
    let out = resolved(LAYOUT, &mut cells);
    let count = out.len() as f64;
    let factors = [2.0 / (4.0 * PI * volume), 3.0 / (4.0 * PI * volume), 5.0 / volume.powf(2.0 / 3.0)];
    let mut totals = [0.0; 3];
    for (index, cell) in out.iter().enumerate() {
        let (a, b) = (voxel(&LAYOUT, index), voxel(&LAYOUT, at));
        let share = |axis: usize| match a[axis].abs_diff(b[axis]) {
            0 => 0.5_f64,
            1 => 0.25,
            _ => 0.0,
        };
        // A thousandth of the mean where there is less.
        let share = (share(0) * share(1) * share(2)).max(1e-3 / count);
        for (what, found) in [cell.beam, cell.scattered, cell.surface].into_iter().enumerate() {
            let expected = share * factors[what];
            assert!((f64::from(found) / expected - 1.0).abs() < 1e-5, "{index}: {cell:?}");
            totals[what] += f64::from(found) / factors[what];
        }
    }
    // And what the floor adds.
    assert!(totals.iter().all(|total| (1.0 - 1e-5..1.001).contains(total)), "{totals:?}");
}

#[test]
fn what_is_even_stays_even_up_to_the_border() {
    for layout in
        [LAYOUT, GridLayout { cells: [1, 1, 1], ..LAYOUT }, GridLayout { cells: [1, 2, 9], ..LAYOUT }]
    {
        let mut cells = vec![ImportanceSums { seen: 1.0, scattered: 2.0, surface: 4.0 }; layout.cell_count()];
        let volume = side(&layout).element_product();
        for cell in resolved(layout, &mut cells) {
            assert!((f64::from(cell.beam) * 4.0 * PI * volume - 1.0).abs() < 1e-5, "{cell:?}");
            assert!((f64::from(cell.scattered) * 4.0 * PI * volume - 2.0).abs() < 1e-5, "{cell:?}");
            assert!((f64::from(cell.surface) * volume.powf(2.0 / 3.0) - 4.0).abs() < 1e-5, "{cell:?}");
        }
        let mut empty = vec![NOTHING; layout.cell_count()];
        assert!(resolved(layout, &mut empty).iter().all(|cell| *cell == ImportanceCell::default()));
    }
}

/// Directions that fill the sphere evenly: a spiral of golden turns.
fn spiral(index: u32, count: u32) -> DVec3 {
    let z = 1.0 - (2.0 * f64::from(index) + 1.0) / f64::from(count);
    let (s, c) = (f64::from(index) * PI * (3.0 - 5f64.sqrt())).sin_cos();
    let r = (1.0 - z * z).sqrt();
    DVec3::new(r * c, r * s, z)
}

/// What a watt that is scattered at a place adds to the camera's picture by being scattered once more: found by light that leaves the place,
/// along the eye ray: W ∫ σ_s T(s)/(4π) T(d)/(4πd²) ds. And by paths from the camera in a grid, the other way round.
#[test]
fn importance_is_reciprocal() {
    let layout = GridLayout { min: Vec3::splat(-2.0), max: Vec3::splat(2.0), cells: [20; 3] };
    let (scattering, extinction) = (0.4, 0.5);
    let medium = Medium::homogeneous(0.4, 0.1);
    let (eye, direction, weight) = (DVec3::new(-4.0, 0.1, 0.1), DVec3::X, 2.5);
    let mut cells = vec![NOTHING; layout.cell_count()];
    let mut grid = ImportanceGrid::new(layout, &mut cells).unwrap();
    // All 12 m of the eye ray: what lies behind is e^-6 of it.
    let (steps, around) = (120, 4000);
    let step = 12.0 / f64::from(steps);
    let places: Vec<(DVec3, f64)> = (0..steps)
        .map(|k| {
            let s = (f64::from(k) + 0.5) * step;
            (eye + s * direction, weight * scattering * (-extinction * s).exp() * step)
        })
        .collect();
    for (place, weight) in &places {
        for ray in 0..around {
            let (origin, direction) = (place.as_vec3(), spiral(ray, around).as_vec3().normalize());
            grid.add_path(&medium, origin, direction, f32::INFINITY, (weight / f64::from(around)) as f32);
        }
    }
    grid.add_eye_ray(&medium, eye.as_vec3(), direction.as_vec3(), 12.0, weight as f32);
    let out = resolved(layout, &mut cells);
    let importance = Importance::new(layout, &out).unwrap();
    let response = |x: DVec3| {
        let of = |(place, weight): &(DVec3, f64)| {
            let d = (x - place).length();
            weight * (-extinction * d).exp() / (16.0 * PI * PI * d * d)
        };
        places.iter().map(of).sum::<f64>()
    };
    for x in [DVec3::new(0.1, 1.1, 0.3), DVec3::new(-1.1, -0.9, 0.9), DVec3::new(1.1, 0.1, -1.3)] {
        // Two axes of a voxel's width and of its neighbours: a variance of h²/12 + h²/2 on each axis, over distances of 1 m or more where
        // the response falls as 1/d: some h² 0.6 = 2 % more than in the middle, which the mean over the same places has too.
        let mut exact = 0.0;
        for index in 0..16 * 16 * 16 {
            let place = |number: u32| (f64::from(number) + 0.5) / 4.0 - 2.0;
            let (offset, mut share) =
                (DVec3::new(place(index % 16), place(index / 16 % 16), place(index / 256)), 1.0);
            for axis in 0..3 {
                // A voxel's box, with ½, and those beside it with ¼: in units of its side.
                share *= if offset[axis].abs() < 0.5 {
                    0.5
                } else if offset[axis].abs() < 1.5 {
                    0.25
                } else {
                    0.0
                } / 4.0;
            }
            exact += share * response(x + 0.2 * offset);
        }
        let found = importance.at(x.as_vec3()).scattered;
        // The paths through a voxel are some 4000 x 120 x (.2/d)²/4π: their lattice leaves some percent.
        assert!((f64::from(found) / exact - 1.0).abs() < 0.03, "{x}: {found} {exact}");
        // Light that leaves the place crosses the eye ray's voxels: what the grid says of it as beams is the same.
        let beams = (0..around)
            .map(|ray| {
                let direction = spiral(ray, around).as_vec3().normalize();
                f64::from(importance.of_segment(&medium, x.as_vec3(), direction, f32::INFINITY).beam)
            })
            .sum::<f64>()
            / f64::from(around);
        let in_box = {
            let of = |(place, weight): &(DVec3, f64)| {
                let d = (x - place).length();
                let inside = place.x.abs() < 2.0;
                if inside { weight * (-extinction * d).exp() / (16.0 * PI * PI * d * d) } else { 0.0 }
            };
            places.iter().map(of).sum::<f64>()
        };
        // The eye ray is blurred over its voxels and those beside it, and voxels without it are worth a thousandth of the mean.
        assert!((beams / in_box - 1.0).abs() < 0.04, "{x}: {beams} {in_box}");
    }
}

#[test]
fn a_segment_is_worth_what_quadrature_says() {
    let mut stream = Stream::new(11);
    let cells: Vec<ImportanceCell> = (0..LAYOUT.cell_count())
        .map(|_| ImportanceCell {
            beam: stream.uniform() as f32,
            scattered: stream.uniform() as f32,
            surface: stream.uniform() as f32,
        })
        .collect();
    let importance = Importance::new(LAYOUT, &cells).unwrap();
    let air = ExponentialDensity { origin: Vec3::new(0.0, -0.5, 0.0), up: Vec3::Y, scale_height: 2.0 };
    for density in [Density::Uniform, Density::Exponential(air)] {
        let medium = Medium { density, ..coloured() };
        let thins = !matches!(density, Density::Uniform);
        let at = |p: DVec3| if thins { (-(p.y + 0.5) / 2.0).exp() } else { 1.0 };
        for (origin, direction, length) in segments(!thins) {
            let found = importance.of_segment(&medium, origin, direction, length);
            let (origin, direction) = (origin.as_dvec3(), direction.as_dvec3());
            // Σ over voxels, in order along the segment.
            let mut crossed: Vec<(usize, [f64; 2])> = (0..cells.len())
                .filter_map(|index| {
                    Some((index, stretch(&LAYOUT, index, origin, direction, f64::from(length))?))
                })
                .collect();
            crossed.sort_by(|(_, a), (_, b)| a[0].total_cmp(&b[0]));
            let mut column = crossed.first().map_or(0.0, |(_, [from, _])| *from);
            let [mut beam, mut scattered] = [0.0; 2];
            for (index, [from, to]) in &crossed {
                let steps = 50;
                let step = (to - from) / f64::from(steps);
                for k in 0..steps {
                    let here = at(origin + (from + (f64::from(k) + 0.5) * step) * direction);
                    let passes = (-EXTINCTION * (column + 0.5 * here * step)).exp() * step / 3.0;
                    beam += f64::from(cells[*index].beam) * passes.element_sum();
                    scattered += f64::from(cells[*index].scattered) * here * SCATTERING.dot(passes);
                    column += here * step;
                }
            }
            // As for the deposits; the density is 2.1 at most and falls over 2 m.
            let near = |found: f32, exact: f64| (f64::from(found) - exact).abs() < 2.5e-3 * exact + 1e-6;
            assert!(near(found.beam, beam), "{origin} {direction} {length}: {found:?} {beam}");
            assert!(near(found.scattered, scattered), "{origin} {direction} {length}: {found:?} {scattered}");
            assert!(
                near(found.transmittance, (-EXTINCTION * column).exp().element_sum() / 3.0),
                "{origin} {direction} {length}: {found:?} {column}"
            );
        }
        // Beside the box there is nothing to lose or to gain.
        let beside = importance.of_segment(&medium, Vec3::splat(9.0), Vec3::X, f32::INFINITY);
        assert_eq!((beside.beam, beside.scattered, beside.transmittance), (0.0, 0.0, 1.0));
    }
}

#[test]
fn a_point_has_the_importance_of_the_nearest_voxel() {
    let cells: Vec<ImportanceCell> = (0..LAYOUT.cell_count())
        .map(|index| ImportanceCell { beam: index as f32, scattered: 1.0, surface: 2.0 })
        .collect();
    let importance = Importance::new(LAYOUT, &cells).unwrap();
    let mut stream = Stream::new(5);
    for _ in 0..2000 {
        let at = [0, 1, 2].map(|axis| stream.between(-20.0, f64::from(LAYOUT.cells[axis]) + 20.0));
        // Not where f32 decides.
        if at.iter().any(|at| (at - at.round()).abs() < 1e-3) {
            continue;
        }
        let place = LAYOUT.min.as_dvec3() + DVec3::from_array(at) * side(&LAYOUT);
        let [x, y, z] =
            [0, 1, 2].map(|axis| (at[axis].max(0.0) as usize).min(LAYOUT.cells[axis] as usize - 1));
        assert_eq!(importance.at(place.as_vec3()).beam, ((z * 30 + y) * 40 + x) as f32, "{place}");
    }
    assert_eq!(importance.at(Vec3::INFINITY).beam, (LAYOUT.cell_count() - 1) as f32);
    assert_eq!(importance.at(Vec3::NEG_INFINITY).beam, 0.0);
    for bad in [Vec3::NAN, Vec3::new(f32::NAN, 0.0, 1.0), Vec3::new(0.0, 0.0, f32::NAN)] {
        assert_eq!(importance.at(bad), ImportanceCell::default(), "{bad}");
    }
}

#[test]
fn bad_values_change_nothing() {
    let medium = coloured();
    let (origin, nan, inf) = (Vec3::new(0.0, 0.0, 1.0), f32::NAN, f32::INFINITY);
    let bad = [
        (Vec3::new(nan, 0.0, 1.0), Vec3::X, 1.0, 1.0),
        (Vec3::splat(inf), Vec3::X, 1.0, 1.0),
        (origin, Vec3::new(nan, 0.0, 1.0), 1.0, 1.0),
        (origin, Vec3::new(inf, 0.0, 1.0), 1.0, 1.0),
        (origin, Vec3::ZERO, 1.0, 1.0),
        (origin, Vec3::X, nan, 1.0),
        (origin, Vec3::X, 0.0, 1.0),
        (origin, Vec3::X, -1.0, 1.0),
        (origin, Vec3::X, 1.0, nan),
        (origin, Vec3::X, 1.0, 0.0),
        (origin, Vec3::X, 1.0, -1.0),
        (origin, Vec3::X, 1.0, inf),
    ];
    let cells = vec![ImportanceSums { seen: 1.0, scattered: 2.0, surface: 3.0 }; LAYOUT.cell_count()];
    let mut changed = cells.clone();
    let mut grid = ImportanceGrid::new(LAYOUT, &mut changed).unwrap();
    for (origin, direction, length, weight) in bad {
        grid.add_eye_ray(&medium, origin, direction, length, weight);
        grid.add_path(&medium, origin, direction, length, weight);
    }
    let sound = [Vec3::X, Vec3::ONE.normalize()];
    for broken in [nan, -1.0] {
        for direction in sound {
            let medium = Medium::homogeneous(0.5, broken);
            grid.add_eye_ray(&medium, origin, direction, 1.0, 1.0);
            grid.add_path(&medium, origin, direction, 1.0, 1.0);
        }
    }
    for (place, weight) in
        [(Vec3::NAN, 1.0), (Vec3::INFINITY, 1.0), (origin, nan), (origin, inf), (origin, -1.0)]
    {
        grid.add_surface(place, weight);
    }
    assert!(changed == cells);

    let worth = vec![ImportanceCell { beam: 1.0, scattered: 2.0, surface: 3.0 }; LAYOUT.cell_count()];
    let importance = Importance::new(LAYOUT, &worth).unwrap();
    for (origin, direction, length, _) in bad.iter().take(8).copied() {
        let found = importance.of_segment(&medium, origin, direction, length);
        assert_eq!((found.beam, found.scattered, found.transmittance), (0.0, 0.0, 1.0));
    }
}

#[test]
fn grids_of_other_sizes_are_refused() {
    let (mut cells, mut out) = (vec![NOTHING; 26], vec![ImportanceCell::default(); 26]);
    let layout = GridLayout { cells: [3, 3, 3], ..LAYOUT };
    assert_eq!(ImportanceGrid::new(layout, &mut cells).unwrap_err(), GridError::Length);
    assert_eq!(Importance::new(layout, &out).unwrap_err(), GridError::Length);
    let empty = GridLayout { max: LAYOUT.min, ..layout };
    let mut cells = vec![NOTHING; 27];
    assert_eq!(ImportanceGrid::new(empty, &mut cells).unwrap_err(), GridError::Layout);
    let mut grid = ImportanceGrid::new(layout, &mut cells).unwrap();
    assert_eq!(grid.merge(&[NOTHING; 26]), Err(GridError::Length));
    assert_eq!(grid.resolve(&mut out), Err(GridError::Length));
    assert!(out.iter().all(|cell| *cell == ImportanceCell::default()));
}

#[test]
fn the_mean_factor_of_a_weight_window_is_one() {
    let mut stream = Stream::new(2);
    const STEPS: u32 = 4096;
    for count in [1, 2, 5, 40] {
        for _ in 0..10 {
            let expected: Vec<f32> = (0..count).map(|_| stream.decades(-2.0, 1.0) as f32).collect();
            let sum: f64 = expected.iter().map(|&number| f64::from(number)).sum();
            let mut means = vec![0.0; count];
            for step in 0..STEPS {
                let mut factors = expected.clone();
                weight_window(&mut factors, (step as f32 + 0.5) / STEPS as f32);
                let copies: f64 =
                    factors.iter().zip(&expected).map(|(factor, number)| f64::from(factor * number)).sum();
                assert!(
                    (copies - sum).abs() < 1.0 + 1e-4 && (copies - copies.round()).abs() < 1e-3,
                    "{copies} of {sum}"
                );
                assert!(factors.iter().filter(|factor| **factor > 0.0).count() as f64 <= sum + 1.0);
                for (mean, factor) in means.iter_mut().zip(factors) {
                    *mean += f64::from(factor) / f64::from(STEPS);
                }
            }
            for (mean, number) in means.iter().zip(&expected) {
                // One step more or less falls where one copy more is made.
                let error = 1.0 / (f64::from(STEPS) * f64::from(*number)) + 1e-5;
                assert!((mean - 1.0).abs() < error, "{number} of {expected:?}: {mean}");
            }
        }
    }
}

#[test]
fn a_weight_window_takes_any_number() {
    let bad = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1.0, 0.0, -0.0];
    for u in [0.0, 0.3, 1.0 - f32::EPSILON / 2.0] {
        for value in bad {
            let (mut factors, mut alone) = ([0.4, value, 0.7], [0.4, 0.7]);
            weight_window(&mut factors, u);
            weight_window(&mut alone, u);
            assert_eq!([factors[0], factors[2]], alone, "{value}");
            assert_eq!(factors[1], 0.0, "{value}");
        }
        // What goes on always keeps its power, however much it is worth.
        let mut huge = [1e9, f32::MAX, 1.0];
        weight_window(&mut huge, u);
        assert!(huge.iter().all(|factor| (factor - 1.0).abs() < 1e-5), "{huge:?}");
        let mut tiny = [f32::MIN_POSITIVE, 1e-45];
        weight_window(&mut tiny, u);
        assert!(tiny.iter().all(|factor| *factor >= 0.0 && !factor.is_nan()), "{tiny:?}");
        weight_window(&mut [], u);
    }
}

/// The density that a cell must have: an even part, and one in proportion to the weights.
fn density(weights: &[f32], even: f64, cell: usize) -> f64 {
    let total: f64 = weights.iter().map(|&weight| f64::from(weight)).sum();
    if total == 0.0 {
        1.0
    } else {
        even + (1.0 - even) * f64::from(weights[cell]) * weights.len() as f64 / total
    }
}

#[test]
fn emission_goes_where_it_is_worth_it() {
    const STEPS: usize = 512;
    let mut stream = Stream::new(9);
    for (side, even) in [(1, 0.2), (2, 0.01), (5, 0.2), (24, 0.2), (7, 1.0)] {
        for kind in 0..3 {
            let weights: Vec<f32> = (0..side * side)
                .map(|cell| match kind {
                    0 => stream.uniform() as f32,
                    // Most of it in one cell, and rows of nothing.
                    1 if cell == side * side / 2 => 1e20,
                    _ => 0.0,
                })
                .collect();
            let mut numbers = vec![0.0; EmissionGuide::size(side)];
            let guide = EmissionGuide::fill(side, &weights, even, &mut numbers).unwrap();
            let exact: Vec<f64> =
                (0..side * side).map(|cell| density(&weights, f64::from(even), cell)).collect();
            let mut counts = vec![0.0; side * side];
            for k in 0..STEPS * STEPS {
                let at = [k / STEPS, k % STEPS].map(|at| (at as f32 + 0.5) / STEPS as f32);
                let (place, found) = guide.warp(at);
                assert!(place.iter().all(|place| (0.0..1.0).contains(place)), "{place:?}");
                let [row, column] = place.map(|place| (place * side as f32) as usize);
                let cell = row * side + column;
                // At a cell's border f32 may take the place for the next cell's.
                let inner = place.iter().all(|place| (place * side as f32).fract() > 1e-5);
                assert!(
                    !inner || (f64::from(found) / exact[cell] - 1.0).abs() < 1e-3,
                    "{side} {cell}: {found}"
                );
                assert!(found >= even * 0.9999, "{found}");
                counts[cell] += 1.0;
                if kind == 2 {
                    assert!(
                        (place[0] - at[0]).abs().max((place[1] - at[1]).abs()) < 1e-6,
                        "{at:?} {place:?}"
                    );
                    assert!((found - 1.0).abs() < 1e-4, "{found}");
                }
                // 1/density is the area that a small square goes to.
                let step = 1e-3;
                let (beside, there) = guide.warp(at.map(|at| at + step));
                if k % 7 == 0 && there == found && inner && at.iter().all(|at| at + step < 1.0) {
                    let area = (beside[0] - place[0]) * (beside[1] - place[1]) / (step * step);
                    let same = [0, 1].iter().all(|&i| (beside[i] * side as f32) as usize == [row, column][i]);
                    // Where a cell's border lies between, it is no derivative. Places are good to 6e-8, a side of the area to 1e-7 / 1e-3.
                    let sides = [(beside[0] - place[0]) / step, (beside[1] - place[1]) / step];
                    let error = 2e-4 * (1.0 / sides[0] + 1.0 / sides[1]) + 1e-3;
                    assert!(!same || (area * found - 1.0).abs() < error, "{side} {at:?}: {area} {found}");
                }
            }
            // Σ density x area of the cells.
            let mut integral = 0.0;
            let mut row_end = 0.0;
            for row in 0..side {
                let share: f64 =
                    exact[row * side..(row + 1) * side].iter().sum::<f64>() / (side * side) as f64;
                let row_count: f64 = counts[row * side..(row + 1) * side].iter().sum::<f64>() / STEPS as f64;
                row_end += share;
                assert!(
                    (row_count - share * STEPS as f64).abs() <= 1.01,
                    "row {row}: {row_count} for {share}"
                );
                for column in 0..side {
                    let cell = row * side + column;
                    let within = exact[cell] / (side * side) as f64 / share;
                    assert!(
                        (counts[cell] - row_count * within * STEPS as f64).abs() <= 1.01 * row_count,
                        "{side}, cell {cell}: {} points for a share of {within} of {row_count} rows",
                        counts[cell]
                    );
                    // Its density where the warp goes there, found from a point in its middle.
                    let before = exact[row * side..cell].iter().sum::<f64>() / (side * side) as f64 / share;
                    let (_, found) =
                        guide.warp([(row_end - 0.5 * share) as f32, (before + 0.5 * within) as f32]);
                    integral += f64::from(found) / (side * side) as f64;
                }
            }
            assert!((integral - 1.0).abs() < 1e-4, "{side} {kind}: {integral}");
            let read = EmissionGuide::new(side, &numbers).unwrap();
            assert!((read.warp([0.3, 0.6]).1).is_finite());
        }
    }
}

#[test]
fn a_guide_refuses_what_is_none() {
    let fill = |side: usize, weights: &[f32], even: f32, size: usize| {
        let mut numbers = vec![7.0; size];
        let refused = EmissionGuide::fill(side, weights, even, &mut numbers).err();
        assert!(refused.is_none() || numbers.iter().all(|&number| number == 7.0), "overwritten");
        refused
    };
    assert_eq!(fill(2, &[1.0; 4], 0.5, 6), None);
    assert_eq!(fill(0, &[], 0.5, 0), Some(GridError::Length));
    assert_eq!(fill(2, &[1.0; 3], 0.5, 6), Some(GridError::Length));
    assert_eq!(fill(2, &[1.0; 4], 0.5, 5), Some(GridError::Length));
    for bad in [f32::NAN, f32::INFINITY, -1.0, -1e-30] {
        assert_eq!(fill(2, &[1.0, bad, 1.0, 1.0], 0.5, 6), Some(GridError::Value), "{bad}");
    }
    for even in [0.0, 1e-45, 4e-38, -0.1, 1.1, f32::NAN, f32::INFINITY] {
        assert_eq!(fill(2, &[1.0; 4], even, 6), Some(GridError::Value), "{even}");
    }
    // In the second row there is next to nothing: still shares that add up.
    let mut numbers = [0.0; 6];
    EmissionGuide::fill(2, &[1.0, 0.0, 0.0, 0.0], 5e-38, &mut numbers).unwrap();
    assert_eq!(numbers, [1.0, 1.0, 1.0, 1.0, 0.5, 1.0]);
    assert_eq!(EmissionGuide::new(0, &[]).err(), Some(GridError::Length));
    assert_eq!(EmissionGuide::new(2, &[0.0; 5]).err(), Some(GridError::Length));
    // Weights near the ends of what f32 holds.
    for weight in [f32::MAX, f32::MIN_POSITIVE, 1e-45] {
        let mut numbers = vec![0.0; 6];
        let guide = EmissionGuide::fill(2, &[weight; 4], 0.2, &mut numbers).unwrap();
        assert!((guide.warp([0.7, 0.1]).1 - 1.0).abs() < 1e-5, "{weight}");
    }
}

#[test]
fn media_that_are_not_finite_leave_nothing() {
    for coefficient in [f32::INFINITY, f32::MAX, f32::NAN] {
        let medium = Medium::homogeneous(coefficient, 0.0);
        let mut sums = vec![ImportanceSums::default(); LAYOUT.cell_count()];
        let mut grid = ImportanceGrid::new(LAYOUT, &mut sums).unwrap();
        grid.add_path(&medium, Vec3::splat(0.1), Vec3::X, 10.0, 1.0);
        grid.add_eye_ray(&medium, Vec3::splat(-9.0), Vec3::ONE.normalize(), f32::INFINITY, 1.0);
        let finite = |cell: &ImportanceSums| (cell.seen + cell.scattered).is_finite();
        assert!(sums.iter().all(finite), "{coefficient}");
    }
}
