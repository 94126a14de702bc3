//! Segments with edges, against the same segments cut by hand: each piece deposited on its own, the field moved and occluded
//! between.

use covbeam::{
    Column, CovarianceGrid, Density, DensityGrid, Edge, ExponentialDensity, GridCell, GridLayout, Knot,
    LightField, Medium, Segment, Vec3,
};
use covbeam_tests::random::Stream;

use super::{SKEW, empty, point};

/// Of the medium along a ray; `knots` is its memory.
fn column<'a>(medium: &Medium, origin: Vec3, direction: Vec3, knots: &'a mut Vec<Knot>) -> Column<'a> {
    knots.clear();
    medium.tabulate(origin, direction, 1e3, &mut |knot| knots.push(knot));
    medium.density.column(origin, direction, knots)
}

/// Sorted, with some behind the origin, some at the same depth and some that are farther than the segment is long.
fn random_edges(stream: &mut Stream) -> Vec<Edge> {
    let mut edges: Vec<Edge> = (0..(stream.uniform() * 6.0) as usize)
        .map(|_| Edge {
            depth: stream.between(-0.5, 3.5) as f32,
            distance: stream.decades(-2.0, 0.0) as f32,
            towards: stream.direction(),
        })
        .collect();
    edges.sort_by(|a, b| a.depth.total_cmp(&b.depth));
    if edges.len() > 2 {
        edges[1].depth = edges[2].depth;
    }
    edges
}

fn segment<'a>(stream: &mut Stream, edges: &'a [Edge]) -> Segment<'a> {
    let (origin, direction) = (point(stream, &SKEW, 0.1), stream.direction());
    let mut field = LightField::point(direction, 0.3);
    field.travel(stream.decades(-1.0, 1.0) as f32);
    let length = if stream.uniform() < 0.2 { f32::INFINITY } else { stream.between(0.5, 3.0) as f32 };
    let unscattered = stream.uniform() < 0.5;
    Segment { origin, length, power: 2.0, unscattered, field, edges, column: Column::Uniform }
}

fn media(values: &[f32], run: impl Fn(&Medium, f64)) {
    let air = ExponentialDensity { origin: SKEW.min, up: Vec3::new(0.3, 1.0, 0.1), scale_height: 0.5 };
    let smoke = DensityGrid::new(SKEW, values).expect("as many values as voxels");
    let fog = Medium::homogeneous(0.4, 0.3);
    // Roundings of depths of up to 20; of tables of columns, twice their own error of 5e-4.
    for (density, tolerance) in
        [(Density::Uniform, 3e-6), (Density::Exponential(air), 1e-5), (Density::Grid(smoke), 1e-3)]
    {
        run(&Medium { density, ..fog }, tolerance);
    }
}

fn smoke(stream: &mut Stream) -> Vec<f32> {
    (0..SKEW.cell_count()).map(|_| stream.between(0.0, 2.0) as f32).collect()
}

/// The pieces and what comes out of the last, which ends at `distance`.
fn by_hand(segment: &Segment, medium: &Medium, distance: f32, mut piece: impl FnMut(Segment)) -> LightField {
    let direction = segment.field.direction;
    let (mut field, mut at) = (segment.field, 0.0_f32);
    let passed = segment.edges.iter().filter(|edge| edge.depth > 0.0 && edge.depth <= distance);
    for (depth, edge) in passed.map(|edge| (edge.depth, Some(edge))).chain([(distance, None)]) {
        let origin = segment.origin + at * direction;
        let left = (-f64::from(medium.mean_extinction()) * f64::from(segment.column.at(at))).exp();
        let power = (f64::from(segment.power) * left) as f32;
        let mut knots = Vec::new();
        let column = column(medium, origin, direction, &mut knots);
        piece(Segment { origin, length: depth - at, power, field, edges: &[], column, ..*segment });
        field.travel_through(medium, origin, depth - at);
        if let Some(edge) = edge {
            field.occlude(edge.towards, edge.distance);
        }
        at = depth;
    }
    field
}

#[test]
fn a_deposit_with_edges_is_that_of_the_pieces_cut_by_hand() {
    let mut stream = Stream::new(81);
    let values = smoke(&mut stream);
    for _ in 0..300 {
        let edges = random_edges(&mut stream);
        let segment = segment(&mut stream, &edges);
        media(&values, |medium, tolerance| {
            let mut knots = Vec::new();
            let column = column(medium, segment.origin, segment.field.direction, &mut knots);
            let segment = Segment { column, ..segment };
            let (mut cells, mut pieces) = (empty(SKEW), empty(SKEW));
            CovarianceGrid::new(SKEW, &mut cells).unwrap().deposit(medium, &segment);
            let mut grid = CovarianceGrid::new(SKEW, &mut pieces).unwrap();
            by_hand(&segment, medium, segment.length, |piece| grid.deposit(medium, &piece));
            let scale = |of: fn(&GridCell) -> f64| cells.iter().map(of).fold(1e-30, f64::max);
            let (weights, traces) = (scale(|cell| cell.weight), scale(|cell| cell.sum[..3].iter().sum()));
            for (cell, other) in cells.iter().zip(&pieces) {
                assert!((cell.weight - other.weight).abs() <= tolerance * weights, "{segment:?} {medium:?}");
                for (a, b) in cell.sum.iter().zip(other.sum) {
                    // Relative to the largest in the grid: a border between voxels may lie a rounding off.
                    assert!((a - b).abs() <= 3.0 * tolerance * traces, "{segment:?} {medium:?}: {a} {b}");
                }
            }
        });
    }
}

#[test]
fn edges_change_what_is_deposited_but_not_how_much() {
    let mut stream = Stream::new(82);
    let fog = Medium::homogeneous(0.4, 0.3);
    let mut changed = 0;
    for _ in 0..100 {
        let mut edges = random_edges(&mut stream);
        // Near enough for the box, 0.5 m thick.
        edges.iter_mut().for_each(|edge| edge.depth *= 0.1);
        let segment = segment(&mut stream, &edges);
        // An even light, whose spectrum is that of the edges alone.
        let field = LightField::collimated(segment.field.direction, f32::INFINITY);
        let deposit = |edges: &[Edge]| {
            let mut cells = empty(SKEW);
            let segment = Segment { edges, field, unscattered: false, ..segment };
            CovarianceGrid::new(SKEW, &mut cells).unwrap().deposit(&fog, &segment);
            cells
        };
        let total = |cells: &[GridCell]| cells.iter().map(|cell| cell.weight).sum::<f64>();
        let (plain, cut) = (deposit(&[]), deposit(&edges));
        assert!((total(&plain) - total(&cut)).abs() <= 1e-5 * total(&plain), "{segment:?}");
        assert!(plain.iter().all(|cell| cell.sum == [0.0; 6]));
        changed += usize::from(cut.iter().any(|cell| cell.sum != [0.0; 6]));
    }
    assert!(changed > 20, "edges change {changed} of 100 deposits");
}

#[test]
fn a_field_past_edges_is_the_one_moved_by_hand() {
    let mut stream = Stream::new(83);
    let values = smoke(&mut stream);
    for _ in 0..300 {
        let edges = random_edges(&mut stream);
        let segment = segment(&mut stream, &edges);
        let distance = stream.between(0.0, 3.5) as f32;
        media(&values, |medium, _| {
            let expected = by_hand(&segment, medium, distance, |_| ());
            assert_eq!(segment.field_at(medium, distance), expected, "{segment:?} {medium:?}");
        });
    }
}

#[test]
fn a_straight_edge_has_the_spectrum_of_its_shadow() {
    // An even field: past the edge at depth 1 and distance d, a variance 1/(4π²d²) across it; before it, none.
    let layout =
        GridLayout { min: Vec3::new(-1.0, -1.0, 0.0), max: Vec3::new(1.0, 1.0, 2.0), cells: [1, 1, 2] };
    let mut cells = empty(layout);
    let field = LightField::collimated(Vec3::Z, f32::INFINITY);
    let edges = [Edge { depth: 1.0, distance: 2.5, towards: Vec3::Y }];
    let (origin, column) = (Vec3::ZERO, Column::Uniform);
    let segment =
        Segment { origin, length: 2.0, power: 1.0, unscattered: false, field, edges: &edges, column };
    CovarianceGrid::new(layout, &mut cells).unwrap().deposit(&Medium::default(), &segment);
    let variance = 1.0 / (4.0 * std::f64::consts::PI.powi(2) * 2.5 * 2.5);
    assert_eq!(cells[0].sum, [0.0; 6]);
    assert!((cells[1].sum[1] / cells[1].weight / variance - 1.0).abs() < 1e-6, "{cells:?}");
    assert!(cells[1].sum[0].abs() < 1e-12 && cells[1].sum[2].abs() < 1e-12, "{cells:?}");
}

#[test]
fn hostile_edges_leave_cells_and_fields_sound() {
    let hostile = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 0.0, -0.0, -1.0, 1e-45, 0.5, f32::MAX];
    let fog = Medium::homogeneous(0.4, 0.3);
    for depth in hostile {
        for distance in hostile {
            for towards in hostile {
                // Out of order as well.
                let edge = Edge { depth, distance, towards: Vec3::new(towards, 1.0, 0.0) };
                let edges = [Edge { depth: 0.3, ..edge }, edge, Edge { depth: 0.1, ..edge }];
                for length in [1.0, f32::INFINITY] {
                    let segment = Segment { length, edges: &edges, ..segment(&mut Stream::new(84), &[]) };
                    let mut cells = empty(SKEW);
                    CovarianceGrid::new(SKEW, &mut cells).unwrap().deposit(&fog, &segment);
                    let sound =
                        cells.iter().all(|c| c.weight.is_finite() && c.sum.iter().all(|s| s.is_finite()));
                    assert!(sound, "{segment:?}");
                    let field = segment.field_at(&fog, length);
                    assert!(field.root.iter().all(|entry| entry.is_finite()), "{segment:?}: {field:?}");
                }
            }
        }
    }
}
