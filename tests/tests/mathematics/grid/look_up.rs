//! Look-ups, against fields that are linear in position and against sums by hand.

use covbeam::{FluenceCell, FluenceGrid, GridLayout, Vec3};
use covbeam_tests::random::Stream;

use super::{SKEW, UNIT, point, spectrum};

fn linear(at: Vec3) -> [f32; 6] {
    [
        1.0 + at.x,
        2.0 - 0.5 * at.y,
        3.0 + 0.25 * at.z,
        at.x - at.y + at.z,
        0.3 * at.x + 0.7 * at.y,
        -0.2 * at.z,
    ]
}

pub(crate) fn linear_cells(layout: &GridLayout) -> Vec<FluenceCell> {
    let [nx, ny, nz] = layout.cells;
    let size = (layout.max - layout.min) / Vec3::new(nx as f32, ny as f32, nz as f32);
    let mut cells = Vec::new();
    for z in 0..nz {
        for y in 0..ny {
            for x in 0..nx {
                let centre = layout.min + (Vec3::new(x as f32, y as f32, z as f32) + 0.5) * size;
                cells.push(FluenceCell { spectrum: spectrum(linear(centre)), weight: 1e-20 });
            }
        }
    }
    cells
}

#[test]
fn look_ups_reproduce_a_linear_field_and_hold_it_at_the_border() {
    let one_thick = GridLayout { cells: [6, 1, 4], ..SKEW };
    for layout in [SKEW, one_thick] {
        let cells = linear_cells(&layout);
        let grid = FluenceGrid::new(layout, &cells).unwrap();
        let n = Vec3::from_array(layout.cells.map(|n| n as f32));
        let half = 0.5 * (layout.max - layout.min) / n;
        let mut stream = Stream::new(8);
        for _ in 0..20_000 {
            let at = point(&mut stream, &layout, 0.0).clamp(layout.min, layout.max);
            let found = grid.look_up(at).unwrap().to_array();
            let held = at.clamp(layout.min + half, layout.max - half);
            for (a, b) in found.into_iter().zip(linear(held)) {
                // Values up to 6; weights and terms rounded to 6e-8 each, eight of them.
                assert!((a - b).abs() < 6e-6, "{at}: {a} for {b}");
            }
        }
    }
}

#[test]
fn look_ups_at_centres_are_the_cells_themselves() {
    let cells = linear_cells(&UNIT);
    let grid = FluenceGrid::new(UNIT, &cells).unwrap();
    for (index, cell) in cells.iter().enumerate() {
        let centre = Vec3::new((index % 4) as f32, (index / 4 % 4) as f32, (index / 16) as f32);
        let found = grid.look_up((centre + 0.5) / 4.0).expect("data").to_array();
        for (found, expected) in found.iter().zip(cell.spectrum.to_array()) {
            // Times the weight and divided by it: two roundings.
            assert!((found - expected).abs() <= 2.0 * f32::EPSILON * expected.abs(), "{found} {expected}");
        }
    }
}

#[test]
fn outside_the_box_and_far_from_data_there_is_no_opinion() {
    let mut cells = vec![FluenceCell::default(); UNIT.cell_count()];
    cells[0] = FluenceCell { spectrum: spectrum([1.0, 2.0, 3.0, 4.0, 5.0, 6.0]), weight: 1.0 };
    let grid = FluenceGrid::new(UNIT, &cells).unwrap();
    for outside in [
        Vec3::new(-1e-6, 0.1, 0.1),
        Vec3::new(0.1, 1.000_001, 0.1),
        Vec3::new(f32::NAN, 0.1, 0.1),
        Vec3::new(0.1, 0.1, f32::INFINITY),
    ] {
        assert_eq!(grid.look_up(outside), None, "{outside}");
    }
    // A quarter is a voxel: its data reach up to the neighbours' centres, at 0.375, undiluted.
    for near in [Vec3::ZERO, Vec3::splat(0.1), Vec3::splat(0.37), Vec3::new(0.0, 0.37, 0.2)] {
        assert_eq!(grid.look_up(near), Some(cells[0].spectrum), "{near}");
    }
    for far in [Vec3::new(0.375, 0.1, 0.1), Vec3::new(0.1, 0.1, 0.4), Vec3::ONE] {
        assert_eq!(grid.look_up(far), None, "{far}");
    }
}

#[test]
fn voxels_without_data_do_not_dilute_their_neighbours() {
    let mut cells = linear_cells(&UNIT);
    let at = Vec3::new(0.3, 0.4, 0.3);
    // Voxels (0..2, 1..3, 0..2) are read; the two at x = 1, z = 1 have no data.
    for y in [1, 2] {
        cells[1 + 4 * (y + 4)] = FluenceCell::default();
    }
    let (fx, fy, fz) = (0.7, 0.1, 0.7); // 4 at - 0.5 is (0.7, 1.1, 0.7)
    let mut expected = [0.0_f64; 6];
    let mut total = 0.0;
    for (x, z, w) in [(0, 0, (1.0 - fx) * (1.0 - fz)), (1, 0, fx * (1.0 - fz)), (0, 1, (1.0 - fx) * fz)] {
        for (y, wy) in [(1, 1.0 - fy), (2, fy)] {
            let values = cells[x + 4 * (y + 4 * z)].spectrum.to_array();
            for (sum, value) in expected.iter_mut().zip(values) {
                *sum += w * wy * f64::from(value);
            }
            total += w * wy;
        }
    }
    let grid = FluenceGrid::new(UNIT, &cells).unwrap();
    for (a, b) in grid.look_up(at).unwrap().to_array().into_iter().zip(expected) {
        // The position is rounded at 6e-8, values reach 4.
        assert!((f64::from(a) - b / total).abs() < 4e-6, "{a} for {}", b / total);
    }
}

#[test]
fn a_look_up_is_the_mean_that_flux_and_nearness_weigh() {
    let layout = GridLayout { min: Vec3::ZERO, max: Vec3::new(2.0, 1.0, 1.0), cells: [2, 1, 1] };
    let cell = |value: f32, weight: f32| FluenceCell { spectrum: spectrum([value; 6]), weight };
    let cells = [cell(8.0, 1.0), cell(2.0, 0.25)];
    let grid = FluenceGrid::new(layout, &cells).unwrap();
    for x in [0.6f32, 1.0, 1.3] {
        let near = [1.5 - x, 0.25 * (x - 0.5)];
        let expected = (8.0 * near[0] + 2.0 * near[1]) / (near[0] + near[1]);
        let found = grid.look_up(Vec3::new(x, 0.5, 0.5)).unwrap().xx;
        assert!((found - expected).abs() < 1e-5, "{x}: {found} {expected}");
    }
    // Weights without meaning count as no data.
    for bad in [f32::NAN, -1.0, 0.0] {
        let cells = [cell(8.0, 1.0), cell(2.0, bad)];
        let grid = FluenceGrid::new(layout, &cells).unwrap();
        assert_eq!(grid.look_up(Vec3::new(1.3, 0.5, 0.5)).unwrap().xx, 8.0);
        assert!(grid.look_up(Vec3::new(1.6, 0.5, 0.5)).is_none());
    }
}
