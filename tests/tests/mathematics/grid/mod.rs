//! The covariance grid: what deposits add up to, in the voxels and over segments, and what look-ups find there.

mod cost;
mod edges;
mod hostile;
mod look_up;
mod saved;
mod segment;

use covbeam::{
    CovarianceGrid, FluenceCell, FluenceGrid, FluenceSpectrum, GridCell, GridError, GridLayout, Vec3,
};
use covbeam_tests::random::Stream;

const UNIT: GridLayout = GridLayout { min: Vec3::ZERO, max: Vec3::ONE, cells: [4, 4, 4] };

/// Unequal on every axis, so that swapped axes show.
const SKEW: GridLayout =
    GridLayout { min: Vec3::new(-1.0, 0.5, 2.0), max: Vec3::new(2.0, 1.25, 2.5), cells: [7, 5, 3] };

fn empty(layout: GridLayout) -> Vec<GridCell> {
    vec![GridCell::default(); layout.cell_count()]
}

fn spectrum(values: [f32; 6]) -> FluenceSpectrum {
    FluenceSpectrum::from_array(values)
}

fn resolved(layout: GridLayout, cells: &mut [GridCell]) -> Vec<FluenceCell> {
    let mut out = vec![FluenceCell::default(); layout.cell_count()];
    CovarianceGrid::new(layout, cells).unwrap().resolve(&mut out).unwrap();
    out
}

/// A point of the box, grown by `margin` of its size on every side.
fn point(stream: &mut Stream, layout: &GridLayout, margin: f64) -> Vec3 {
    let at = Vec3::from_array([(); 3].map(|()| stream.between(-margin, 1.0 + margin) as f32));
    layout.min + at * (layout.max - layout.min)
}

#[test]
fn layouts_without_volume_and_slices_of_another_length_are_refused() {
    let bad = [
        GridLayout { min: Vec3::ONE, ..UNIT },
        GridLayout { min: Vec3::new(0.0, 2.0, 0.0), ..UNIT },
        GridLayout { min: Vec3::new(f32::NAN, 0.0, 0.0), ..UNIT },
        GridLayout { max: Vec3::new(1.0, 1.0, f32::NAN), ..UNIT },
        GridLayout { max: Vec3::new(1.0, f32::INFINITY, 1.0), ..UNIT },
        GridLayout { min: Vec3::splat(-3e38), max: Vec3::splat(3e38), ..UNIT },
        GridLayout { max: Vec3::new(1e-45, 1.0, 1.0), ..UNIT },
        GridLayout { cells: [4, 0, 4], ..UNIT },
        GridLayout { cells: [1 << 12, 1 << 12, 2], ..UNIT },
        GridLayout { cells: [u32::MAX; 3], ..UNIT },
    ];
    for layout in bad {
        assert_eq!(CovarianceGrid::new(layout, &mut []).err(), Some(GridError::Layout), "{layout:?}");
        assert_eq!(FluenceGrid::new(layout, &[]).err(), Some(GridError::Layout), "{layout:?}");
    }
    for count in [0, 63, 65] {
        let mut cells = vec![GridCell::default(); count];
        assert_eq!(CovarianceGrid::new(UNIT, &mut cells).err(), Some(GridError::Length));
        assert_eq!(
            FluenceGrid::new(UNIT, &vec![FluenceCell::default(); count]).err(),
            Some(GridError::Length)
        );
    }
    assert_eq!(SKEW.cell_count(), 105);
    assert_eq!(GridLayout { cells: [u32::MAX; 3], ..UNIT }.cell_count(), usize::MAX);
    for error in [GridError::Layout, GridError::Length] {
        assert!(error.to_string().contains("grid"));
    }
}

#[test]
fn merge_and_resolve_refuse_another_length_and_change_nothing() {
    let mut cells = empty(UNIT);
    let mut grid = CovarianceGrid::new(UNIT, &mut cells).unwrap();
    grid.deposit_spectrum(Vec3::splat(0.1), &spectrum([1.0; 6]), 2.0);
    assert_eq!(grid.merge(&empty(SKEW)), Err(GridError::Length));
    let mut out = vec![FluenceCell { weight: 5.0, ..FluenceCell::default() }; 3];
    assert_eq!(grid.resolve(&mut out), Err(GridError::Length));
    assert!(out.iter().all(|cell| cell.weight == 5.0));
    assert_eq!(cells[0], GridCell { sum: [2.0; 6], weight: 2.0 });
    assert!(cells[1..].iter().all(|cell| *cell == GridCell::default()));
}

#[test]
fn a_deposit_lands_in_the_voxel_around_it_x_first() {
    let mut stream = Stream::new(4);
    for z in 0..3_u32 {
        for y in 0..5_u32 {
            for x in 0..7_u32 {
                let mut cells = empty(SKEW);
                let size = (SKEW.max - SKEW.min) / Vec3::new(7.0, 5.0, 3.0);
                // Not closer to a face than f32 resolves.
                let inside = Vec3::from_array([(); 3].map(|()| stream.between(0.001, 0.999) as f32));
                let at = SKEW.min + (Vec3::new(x as f32, y as f32, z as f32) + inside) * size;
                let mut grid = CovarianceGrid::new(SKEW, &mut cells).unwrap();
                grid.deposit_spectrum(at, &spectrum([1.0, 2.0, 3.0, 4.0, 5.0, 6.0]), 0.5);
                let index = (x + 7 * (y + 5 * z)) as usize;
                assert_eq!(cells[index], GridCell { sum: [0.5, 1.0, 1.5, 2.0, 2.5, 3.0], weight: 0.5 });
                assert_eq!(cells.iter().filter(|cell| cell.weight != 0.0).count(), 1);
            }
        }
    }
}

#[test]
fn the_faces_of_the_box_belong_to_it_and_nothing_beyond() {
    let mut cells = empty(UNIT);
    let mut grid = CovarianceGrid::new(UNIT, &mut cells).unwrap();
    let flat = spectrum([1.0; 6]);
    grid.deposit_spectrum(Vec3::ZERO, &flat, 1.0);
    grid.deposit_spectrum(Vec3::ONE, &flat, 1.0);
    for outside in [
        Vec3::new(-1e-30, 0.5, 0.5),
        Vec3::new(0.5, 1.0 + f32::EPSILON, 0.5),
        Vec3::new(0.5, 0.5, f32::NAN),
        Vec3::splat(f32::INFINITY),
    ] {
        grid.deposit_spectrum(outside, &flat, 1.0);
    }
    assert_eq!((cells[0].weight, cells[63].weight), (1.0, 1.0));
    assert_eq!(cells.iter().map(|cell| cell.weight).sum::<f64>(), 2.0);
}

#[test]
fn the_mean_of_a_voxel_is_weighted_by_flux() {
    let mut cells = empty(UNIT);
    let mut grid = CovarianceGrid::new(UNIT, &mut cells).unwrap();
    let at = Vec3::new(0.6, 0.3, 0.9);
    grid.deposit_spectrum(at, &spectrum([1.0, 2.0, 3.0, 0.5, -0.25, 0.0]), 3.0);
    grid.deposit_spectrum(at, &spectrum([5.0, 6.0, 7.0, 0.5, 0.75, 8.0]), 1.0);
    let out = resolved(UNIT, &mut cells);
    let index = 2 + 4 * (1 + 4 * 3);
    assert_eq!(out[index].spectrum.to_array(), [2.0, 3.0, 4.0, 0.5, 0.0, 2.0]);
    assert_eq!(cells[index].weight, 4.0);
    // The brightest voxel has weight 1.
    assert_eq!(out[index].weight, 1.0);
    assert_eq!(out[0], FluenceCell::default());
}

#[test]
fn ten_million_deposits_do_not_stall() {
    // An f32 sum stops growing at 2^24 equal terms; here the terms are worth 1 to 3 after 10^7 of them, and one
    // deposit of 2^24 before them would already swallow them all.
    let mut cells = empty(UNIT);
    let mut grid = CovarianceGrid::new(UNIT, &mut cells).unwrap();
    let at = Vec3::splat(0.5);
    grid.deposit_spectrum(at, &spectrum([1.0; 6]), (1 << 25) as f32);
    let n = 10_000_000_u32;
    for i in 0..n {
        grid.deposit_spectrum(at, &spectrum([(i % 3) as f32 + 1.0; 6]), 1.0);
    }
    // Integers below 2^53: the f64 sums are exact.
    let sum = f64::from(1 << 25) + f64::from(n / 3 * 6 + 1);
    let weight = f64::from(1 << 25) + f64::from(n);
    let index = 2 + 4 * (2 + 4 * 2);
    assert_eq!(cells[index], GridCell { sum: [sum; 6], weight });
    assert_eq!(resolved(UNIT, &mut cells)[index].spectrum.xx, (sum / weight) as f32);
}

#[test]
fn a_thousand_million_deposits_keep_their_mean() {
    // A billion deposits as 30 merges of a grid with itself: sums reach 2^30, where f32 steps are 64 wide.
    let mut cells = empty(UNIT);
    let mut grid = CovarianceGrid::new(UNIT, &mut cells).unwrap();
    let at = Vec3::splat(0.1);
    grid.deposit_spectrum(at, &spectrum([0.1; 6]), 0.3);
    for _ in 0..30 {
        let copy = cells.clone();
        CovarianceGrid::new(UNIT, &mut cells).unwrap().merge(&copy).unwrap();
    }
    let mut grid = CovarianceGrid::new(UNIT, &mut cells).unwrap();
    for _ in 0..1000 {
        grid.deposit_spectrum(at, &spectrum([0.7; 6]), 0.3);
    }
    let n = f64::from(1 << 30);
    let exact = (n * f64::from(0.1_f32) + 1000.0 * f64::from(0.7_f32)) / (n + 1000.0);
    // The thousand at the end move the mean by 5.6e-6 of itself: seen to one f32 rounding.
    let mean = f64::from(resolved(UNIT, &mut cells)[0].spectrum.xy);
    assert!((mean / exact - 1.0).abs() < 6e-8, "{mean} for {exact}");
    assert!(mean > f64::from(0.1_f32));
}

#[test]
fn merging_in_order_is_depositing_in_order() {
    let mut stream = Stream::new(5);
    let deposits: Vec<_> = (0..3000)
        .map(|_| {
            // Multiples of 2^-12: exact sums, so that order cannot matter and equality can be asked for.
            let at = point(&mut stream, &SKEW, 0.1);
            let mut exact = || ((stream.uniform() * 4096.0).floor() / 4096.0) as f32;
            let values = [(); 6].map(|()| exact());
            (at, spectrum(values), exact() + 1.0)
        })
        .collect();
    let mut sequential = empty(SKEW);
    let mut grid = CovarianceGrid::new(SKEW, &mut sequential).unwrap();
    for (at, spectrum, weight) in &deposits {
        grid.deposit_spectrum(*at, spectrum, *weight);
    }
    let mut total = empty(SKEW);
    for chunk in deposits.chunks(700) {
        let mut part = empty(SKEW);
        let mut grid = CovarianceGrid::new(SKEW, &mut part).unwrap();
        for (at, spectrum, weight) in chunk {
            grid.deposit_spectrum(*at, spectrum, *weight);
        }
        CovarianceGrid::new(SKEW, &mut total).unwrap().merge(&part).unwrap();
    }
    assert_eq!(total, sequential);
    assert!(total.iter().all(|cell| cell.weight > 0.0));
}
