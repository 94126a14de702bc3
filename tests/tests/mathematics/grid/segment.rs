//! Deposits along segments, against a naive twin that clips the segment to every voxel in f64.

use covbeam::{Column, CovarianceGrid, GridCell, GridLayout, LightField, Medium, Vec3};
use covbeam_tests::random::Stream;

use super::{SKEW, UNIT, empty, point, resolved};

/// A point light's field 0.5 m before the segment.
pub(crate) fn field(direction: Vec3) -> LightField {
    let mut field = LightField::point(direction, 0.3);
    field.occlude(direction.any_orthonormal_vector(), 0.2);
    field.travel(0.5);
    field
}

/// The part [from, to] of a segment inside a box, if any, in f64.
fn clip(min: [f64; 3], max: [f64; 3], origin: Vec3, direction: Vec3, length: f32) -> Option<(f64, f64)> {
    let (mut from, mut to) = (0.0_f64, f64::from(length));
    for axis in 0..3 {
        let (o, d) = (f64::from(origin[axis]), f64::from(direction[axis]));
        if d == 0.0 {
            if o < min[axis] || o > max[axis] {
                return None;
            }
        } else {
            let (a, b) = ((min[axis] - o) / d, (max[axis] - o) / d);
            from = from.max(a.min(b));
            to = to.min(a.max(b));
        }
    }
    (from < to).then_some((from, to))
}

fn clip_to_box(layout: &GridLayout, origin: Vec3, direction: Vec3, length: f32) -> Option<(f64, f64)> {
    let corner = |v: Vec3| v.to_array().map(f64::from);
    clip(corner(layout.min), corner(layout.max), origin, direction, length)
}

/// ∫ exp(-extinction s) ds over [from, to].
fn attenuated(from: f64, to: f64, extinction: f32) -> f64 {
    let extinction = f64::from(extinction);
    if extinction == 0.0 {
        to - from
    } else {
        (-extinction * from).exp() * -(-extinction * (to - from)).exp_m1() / extinction
    }
}

#[derive(Clone, Copy, Debug)]
struct Segment {
    origin: Vec3,
    direction: Vec3,
    length: f32,
    extinction: f32,
}

impl Segment {
    fn random(stream: &mut Stream, layout: &GridLayout) -> Self {
        let origin = point(stream, layout, 0.2);
        let axis = [Vec3::X, Vec3::Y, Vec3::Z][(stream.uniform() * 3.0) as usize];
        let direction = match (stream.uniform() * 6.0) as u32 {
            0 => axis,
            1 => -axis,
            2 => (stream.direction() * Vec3::new(1.0, 1e-20, 1.0)).normalize(),
            3 => (stream.direction() * Vec3::new(1e-6, 1.0, 0.0)).normalize(),
            _ => stream.direction(),
        };
        let length = if stream.uniform() < 0.1 { f32::INFINITY } else { stream.decades(-3.0, 1.0) as f32 };
        let extinction = match (stream.uniform() * 3.0) as u32 {
            0 => 0.0,
            1 => stream.decades(-12.0, 0.0) as f32,
            _ => stream.between(0.0, 20.0) as f32,
        };
        Self { origin, direction, length, extinction }
    }

    fn deposit(&self, layout: GridLayout, power: f32) -> Vec<GridCell> {
        let mut cells = empty(layout);
        let mut grid = CovarianceGrid::new(layout, &mut cells).unwrap();
        grid.deposit(
            &Medium::homogeneous(0.0, self.extinction),
            &covbeam::Segment {
                origin: self.origin,
                length: self.length,
                power,
                unscattered: true,
                field: field(self.direction),
                edges: &[],
                column: Column::Uniform,
            },
        );
        cells
    }
}

#[test]
fn the_weights_of_a_segment_add_up_to_the_closed_form_over_it() {
    let layout = GridLayout { cells: [70, 50, 30], ..SKEW };
    let mut stream = Stream::new(6);
    let mut hits = 0;
    for _ in 0..3000 {
        let segment = Segment::random(&mut stream, &layout);
        let total: f64 = segment.deposit(layout, 2.0).iter().map(|cell| cell.weight).sum();
        match clip_to_box(&layout, segment.origin, segment.direction, segment.length) {
            Some((from, to)) => {
                hits += 1;
                let exact = 2.0 * attenuated(from, to, segment.extinction);
                // f32 pieces, and a transmittance that is the product of up to 150 of them: 150 x 6e-8; the
                // distance to the box is rounded to 6e-8 of its optical depth, at most 60 here.
                assert!((total / exact - 1.0).abs() < 1e-5, "{segment:?}: {total} for {exact}");
            }
            None => assert_eq!(total, 0.0, "{segment:?}"),
        }
    }
    assert!(hits > 1000, "{hits}");
}

#[test]
fn every_voxel_gets_the_piece_and_the_spectrum_of_the_naive_twin() {
    let mut stream = Stream::new(7);
    let size = (SKEW.max - SKEW.min).to_array().map(f64::from);
    for _ in 0..1000 {
        let segment =
            Segment { extinction: stream.between(0.0, 3.0) as f32, ..Segment::random(&mut stream, &SKEW) };
        let cells = segment.deposit(SKEW, 0.7);
        let out = resolved(SKEW, &mut cells.clone());
        for (index, cell) in cells.iter().enumerate() {
            let at = [index % 7, index / 7 % 5, index / 35];
            let corner = |step: usize| {
                [0, 1, 2].map(|axis| {
                    let n = f64::from(SKEW.cells[axis]);
                    f64::from(SKEW.min[axis]) + size[axis] * (at[axis] + step) as f64 / n
                })
            };
            let piece = clip(corner(0), corner(1), segment.origin, segment.direction, segment.length);
            let exact = piece.map_or(0.0, |(from, to)| 0.7 * attenuated(from, to, segment.extinction));
            // Twin and march round the planes differently, 1e-15 either way; f32 pieces to 1e-5 as above.
            assert!(
                (cell.weight - exact).abs() < 1e-5 * exact + 1e-12,
                "{segment:?} {at:?}: {}",
                cell.weight
            );
            if let Some((from, to)) = piece.filter(|(from, to)| to - from > 1e-9) {
                let mut field = field(segment.direction);
                field.travel((0.5 * (from + to)) as f32);
                // At most one cycle over the smallest side of a voxel.
                let finest = (0..3).map(|axis| f64::from(SKEW.cells[axis]) / size[axis]).fold(0.0, f64::max);
                let finest = finest as f32;
                let mut expected = field.fluence_within(finest);
                let along = field.variance_along_ray(segment.extinction).min(finest * finest);
                expected.add_along(field.direction, along);
                let scale = expected.xx + expected.yy + expected.zz;
                for (a, b) in out[index].spectrum.to_array().into_iter().zip(expected.to_array()) {
                    // One travel against up to 15 of them, each rounded to f32.
                    assert!((a - b).abs() <= 3e-6 * scale, "{segment:?} {at:?}: {a} for {b}");
                }
            }
        }
    }
}

#[test]
fn segments_along_planes_edges_and_diagonals_of_the_grid_are_counted_once() {
    let cases = [
        // In a face of the box, in an inner plane, along an inner edge, along an outer edge.
        (Vec3::new(-1.0, 1.0, 0.3), Vec3::X),
        (Vec3::new(-1.0, 0.5, 0.3), Vec3::X),
        (Vec3::new(0.25, 0.5, 2.0), -Vec3::Z),
        (Vec3::new(1.0, -1.0, 1.0), Vec3::Y),
        (Vec3::new(0.0, 2.0, 0.0), -Vec3::Y),
        // Through every corner on the way, both ways.
        (Vec3::splat(-0.5), Vec3::ONE.normalize()),
        (Vec3::splat(1.5), -Vec3::ONE.normalize()),
    ];
    for (origin, direction) in cases {
        let segment = Segment { origin, direction, length: 10.0, extinction: 0.0 };
        let total: f64 = segment.deposit(UNIT, 1.0).iter().map(|cell| cell.weight).sum();
        let exact = 1.0 / f64::from(direction.abs().max_element());
        assert!((total / exact - 1.0).abs() < 1e-6, "{segment:?}: {total} for {exact}");
    }
    // From a face outwards, and past a face: nothing.
    for (origin, direction) in [
        (Vec3::new(1.0, 0.5, 0.5), Vec3::X),
        (Vec3::new(0.0, 0.5, 0.5), -Vec3::X),
        (Vec3::new(0.5, 1.0 + f32::EPSILON, 0.5), Vec3::X),
    ] {
        let segment = Segment { origin, direction, length: 10.0, extinction: 0.0 };
        assert!(segment.deposit(UNIT, 1.0).iter().all(|cell| cell.weight == 0.0), "{segment:?}");
    }
}

#[test]
fn a_segment_inside_one_voxel_and_one_of_no_length() {
    let inside = Segment { origin: Vec3::splat(0.3), direction: Vec3::Z, length: 0.125, extinction: 0.0 };
    let cells = inside.deposit(UNIT, 4.0);
    assert_eq!(cells[1 + 4 * (1 + 4)].weight, 0.5);
    assert_eq!(cells.iter().filter(|cell| cell.weight != 0.0).count(), 1);
    let none = Segment { length: 0.0, ..inside };
    assert!(none.deposit(UNIT, 4.0).iter().all(|cell| cell.weight == 0.0));
}

#[test]
fn deep_in_a_dense_medium_the_weights_still_follow_the_exponential() {
    let layout = GridLayout { max: Vec3::new(1.0, 1.0, 64.0), cells: [1, 1, 64], ..UNIT };
    let ray = Segment {
        origin: Vec3::new(0.5, 0.5, 0.0),
        direction: Vec3::Z,
        length: 64.0,
        extinction: 200.0 / 64.0,
    };
    for (z, cell) in ray.deposit(layout, 1.0).iter().enumerate() {
        let exact = attenuated(z as f64, z as f64 + 1.0, ray.extinction);
        // Each step's exponential is right to 1e-7 and its depth exact; f32 ends at 1.2e-38 (depth 87).
        let error = (cell.weight - exact).abs();
        assert!(error <= 2e-7 * (z + 1) as f64 * exact + 1e-38, "voxel {z}: {} for {exact}", cell.weight);
    }
}

#[test]
fn segments_without_meaning_deposit_nothing() {
    let deposit = |origin: Vec3, direction: Vec3, length: f32, power: f32, extinction: f32| {
        let mut cells = empty(UNIT);
        let mut grid = CovarianceGrid::new(UNIT, &mut cells).unwrap();
        let field = LightField { direction, ..field(Vec3::Z) };
        grid.deposit(
            &Medium::homogeneous(0.0, extinction),
            &covbeam::Segment {
                origin,
                length,
                power,
                unscattered: true,
                field,
                edges: &[],
                column: Column::Uniform,
            },
        );
        cells.iter().map(|cell| cell.weight).sum::<f64>()
    };
    let inside = Vec3::splat(0.3);
    assert_eq!(deposit(inside, Vec3::Z, 0.5, 1.0, 0.0), 0.5);
    assert_eq!(deposit(inside, Vec3::ZERO, 0.5, 1.0, 0.0), 0.0);
    assert_eq!(deposit(inside, Vec3::new(0.0, f32::NAN, 1.0), 0.5, 1.0, 0.0), 0.0);
    assert_eq!(deposit(inside * f32::NAN, Vec3::Z, 0.5, 1.0, 0.0), 0.0);
    for bad in [-1.0, 0.0, f32::NAN] {
        assert_eq!(deposit(inside, Vec3::Z, bad, 1.0, 0.0), 0.0);
        assert_eq!(deposit(inside, Vec3::Z, 0.5, bad, 0.0), 0.0);
    }
    for bad in [-1.0, f32::NAN, f32::INFINITY] {
        assert_eq!(deposit(inside, Vec3::Z, 0.5, 1.0, bad), 0.0);
    }
    assert_eq!(deposit(inside, Vec3::Z, 0.5, f32::INFINITY, 0.0), 0.0);
}
