//! What a look-up and a deposit cost.

use covbeam::{Column, CovarianceGrid, FluenceGrid, GridLayout, Medium, Segment, Vec3};
use covbeam_tests::random::Stream;

use super::{UNIT, empty, look_up::linear_cells, point, segment::field};

/// Prints the cost of a look-up: `cargo test --release -p covbeam-tests --test mathematics -- --ignored --nocapture`.
#[test]
#[ignore = "a measurement, to be run alone and in release"]
fn the_cost_of_look_ups_and_deposits() {
    let layout = GridLayout { cells: [32; 3], ..UNIT };
    let cells = linear_cells(&layout);
    let grid = FluenceGrid::new(layout, &cells).unwrap();
    let mut stream = Stream::new(9);
    let scattered: Vec<Vec3> = (0..100_000).map(|_| point(&mut stream, &layout, 0.0)).collect();
    let along: Vec<Vec3> = (0..100_000).map(|i| Vec3::new(0.2, 0.3, (i % 1000) as f32 / 1000.0)).collect();
    let best = |run: &mut dyn FnMut() -> f32| {
        (0..30)
            .map(|_| {
                let start = std::time::Instant::now();
                std::hint::black_box(run());
                start.elapsed().as_secs_f64()
            })
            .fold(f64::INFINITY, f64::min)
    };
    for (name, points) in [("scattered", &scattered), ("along rays", &along)] {
        let time = best(&mut || points.iter().filter_map(|&at| grid.look_up(at)).map(|s| s.xx).sum());
        println!("look_up, 32^3 voxels, {name}: {:.1} ns", time * 1e9 / points.len() as f64);
    }
    let mut sums = empty(layout);
    let mut grid = CovarianceGrid::new(layout, &mut sums).unwrap();
    let direction = Vec3::new(0.36, 0.48, 0.8);
    let field = field(direction);
    for extinction in [0.0, 0.3] {
        let time = best(&mut || {
            for _ in 0..1000 {
                grid.deposit(
                    &Medium::homogeneous(0.0, extinction),
                    &Segment {
                        origin: Vec3::splat(0.1),
                        length: 0.9,
                        power: 1.0,
                        unscattered: true,
                        field,
                        edges: &[],
                        column: Column::Uniform,
                    },
                );
            }
            0.0
        });
        println!("deposit_segment, 32^3 voxels, extinction {extinction}: {:.2} us", time * 1e3);
    }
    let pieces = sums.iter().filter(|cell| cell.weight > 0.0).count();
    println!("that is {pieces} voxels a segment");
}
