//! Grids as bytes: the format written out a second time by hand, round trips of real deposits, and damage.

use covbeam::{Column, CovarianceGrid, GridCell, GridError, GridLayout, LightField, Medium, Segment, Vec3};
use covbeam_tests::random::Stream;
use proptest::prelude::*;

use super::{SKEW, UNIT, empty, point, spectrum};

/// FNV-1a of 64 bits.
fn fnv(bytes: impl IntoIterator<Item = u8>) -> u64 {
    let mut sum: u64 = 14_695_981_039_346_656_037;
    for byte in bytes {
        sum ^= u64::from(byte);
        sum = sum.wrapping_mul(1_099_511_628_211);
    }
    sum
}

/// The checksum of a saved grid, computed again.
fn seal(bytes: &mut [u8]) {
    let sum = fnv(bytes[..48].iter().chain(&bytes[56..]).copied());
    bytes[48..56].copy_from_slice(&sum.to_le_bytes());
}

/// The format as the documentation has it.
fn by_hand(layout: &GridLayout, cells: &[GridCell]) -> Vec<u8> {
    let mut bytes = b"covbeamG".to_vec();
    bytes.extend([1, 0, 0, 0]);
    for corner in [layout.min, layout.max] {
        for axis in 0..3 {
            bytes.extend(corner[axis].to_le_bytes());
        }
    }
    for count in layout.cells {
        bytes.extend(count.to_le_bytes());
    }
    bytes.extend([0; 8]);
    for cell in cells {
        for number in cell.sum {
            bytes.extend(number.to_le_bytes());
        }
        bytes.extend(cell.weight.to_le_bytes());
    }
    seal(&mut bytes);
    bytes
}

fn saved(layout: GridLayout, cells: &[GridCell]) -> Vec<u8> {
    let mut bytes = vec![0; layout.saved_size()];
    layout.save(cells, &mut bytes).unwrap();
    bytes
}

fn load(layout: GridLayout, cells: &mut [GridCell], bytes: &[u8]) -> Result<(), GridError> {
    CovarianceGrid::new(layout, cells).unwrap().load(bytes)
}

fn bits(cells: &[GridCell]) -> Vec<[u64; 7]> {
    cells
        .iter()
        .map(|cell| {
            let [a, b, c, d, e, f] = cell.sum;
            [a, b, c, d, e, f, cell.weight].map(f64::to_bits)
        })
        .collect()
}

/// A light field after some events, each number over twelve decades.
fn random_field(stream: &mut Stream) -> LightField {
    let direction = stream.direction();
    let number = |stream: &mut Stream| stream.decades(-6.0, 6.0) as f32;
    let mut field = match (stream.uniform() * 4.0) as u32 {
        0 => LightField::point(direction, number(stream)),
        1 => LightField::disk(direction, stream.direction(), number(stream), number(stream)),
        2 => LightField::collimated(direction, number(stream)),
        _ => {
            let [a, b, c, d] = [(); 4].map(|()| number(stream));
            LightField::gaussian(direction, stream.direction(), [a, b], [c, d])
        }
    };
    for _ in 0..(stream.uniform() * 5.0) as u32 {
        match (stream.uniform() * 4.0) as u32 {
            0 => field.travel(number(stream)),
            1 => field.occlude(stream.direction(), number(stream)),
            2 => field.scatter(stream.direction(), number(stream)),
            _ => field.diffuse(stream.direction(), stream.direction()),
        }
    }
    field
}

/// A segment of such a field through the grid.
fn deposit_random(stream: &mut Stream, layout: &GridLayout, grid: &mut CovarianceGrid) {
    let field = random_field(stream);
    let from = point(stream, layout, 0.0) - field.direction * stream.between(0.0, 1.0) as f32;
    let length = stream.decades(-3.0, 1.0) as f32;
    let extinction = stream.decades(-6.0, 2.0) as f32;
    let power = stream.decades(-6.0, 6.0) as f32;
    let unscattered = stream.uniform() < 0.5;
    grid.deposit(
        &Medium::homogeneous(0.0, extinction),
        &Segment { origin: from, length, power, unscattered, field, edges: &[], column: Column::Uniform },
    );
}

fn filled(stream: &mut Stream, layout: GridLayout, segments: usize) -> Vec<GridCell> {
    let mut cells = empty(layout);
    let mut grid = CovarianceGrid::new(layout, &mut cells).unwrap();
    for _ in 0..segments {
        deposit_random(stream, &layout, &mut grid);
    }
    cells
}

#[test]
fn the_bytes_are_those_of_the_documented_format() {
    // The published vectors of FNV-1a.
    assert_eq!(fnv(*b""), 0xCBF2_9CE4_8422_2325);
    assert_eq!(fnv(*b"a"), 0xAF63_DC4C_8601_EC8C);
    assert_eq!(fnv(*b"foobar"), 0x8594_4171_F739_67E8);
    let cells = filled(&mut Stream::new(1), SKEW, 200);
    assert!(cells.iter().any(|cell| cell.weight > 0.0 && cell.sum[3] != 0.0));
    let bytes = saved(SKEW, &cells);
    assert_eq!(bytes.len(), 56 + 56 * 105);
    assert_eq!(bytes, by_hand(&SKEW, &cells));
    assert_eq!(GridLayout::of_saved(&bytes), Ok(SKEW));
    // No memory has this size: the number saturates.
    assert_eq!(GridLayout { cells: [u32::MAX; 3], ..UNIT }.saved_size(), usize::MAX);
}

#[test]
fn a_grid_saved_in_the_middle_goes_on_with_the_same_bits() {
    let mut stream = Stream::new(2);
    let mut straight = filled(&mut stream, SKEW, 300);
    let bytes = saved(SKEW, &straight);
    // What the cells held before is gone.
    let mut loaded = filled(&mut Stream::new(77), SKEW, 50);
    load(SKEW, &mut loaded, &bytes).unwrap();
    assert_eq!(bits(&loaded), bits(&straight));
    for cells in [&mut straight, &mut loaded] {
        let mut stream = stream.clone();
        let mut grid = CovarianceGrid::new(SKEW, cells).unwrap();
        for _ in 0..300 {
            deposit_random(&mut stream, &SKEW, &mut grid);
        }
    }
    assert_eq!(bits(&loaded), bits(&straight));
    assert_ne!(saved(SKEW, &loaded), bytes);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12 * ProptestConfig::default().cases))]

    #[test]
    fn what_deposits_and_merges_leave_is_never_refused(
        seed in any::<u64>(),
        segments in 0_usize..60,
        size in -3.0_f64..3.0,
        merges in 0_usize..4,
    ) {
        let mut stream = Stream::new(seed);
        let size = 10_f64.powf(size) as f32;
        let layout = GridLayout { min: SKEW.min * size, max: SKEW.max * size, ..SKEW };
        let mut cells = filled(&mut stream, layout, segments);
        for _ in 0..merges {
            let more = filled(&mut stream, layout, segments);
            CovarianceGrid::new(layout, &mut cells).unwrap().merge(&more).unwrap();
        }
        let mut bytes = vec![0; layout.saved_size()];
        prop_assert_eq!(layout.save(&cells, &mut bytes), Ok(()));
        prop_assert_eq!(GridLayout::of_saved(&bytes), Ok(layout));
        let mut loaded = empty(layout);
        prop_assert_eq!(load(layout, &mut loaded, &bytes), Ok(()));
        prop_assert_eq!(bits(&loaded), bits(&cells));
    }

    #[test]
    fn roots_of_any_finite_size_save_where_they_deposit(
        seed in any::<u64>(),
        exponents in prop::array::uniform10(-45.0_f64..30.0),
        [power, size] in [-40.0_f64..30.0, -10.0..10.0],
    ) {
        // Down to where the squares, or the numbers themselves, leave the range of f32.
        let mut stream = Stream::new(seed);
        let root = exponents.map(|exponent| {
            let sign = if stream.uniform() < 0.5 { -1.0 } else { 1.0 };
            (sign * 10_f64.powf(exponent)) as f32
        });
        let mut axis = || match (stream.uniform() * 3.0) as u32 {
            0 => stream.direction(),
            1 => (stream.direction() * Vec3::new(1.0, 1e-15, 1e-25)).normalize(),
            _ => (stream.direction() * Vec3::new(1e-20, 1.0, 1e-3)).normalize(),
        };
        let field = LightField { root, x_axis: axis(), direction: axis() };
        let side = 10_f64.powf(size) as f32;
        let layout = GridLayout { min: Vec3::ZERO, max: Vec3::splat(side), cells: [1, 1, 2] };
        let mut cells = empty(layout);
        let mut grid = CovarianceGrid::new(layout, &mut cells).unwrap();
        let power = 10_f64.powf(power) as f32;
        let centre = Vec3::splat(0.5 * side);
        for unscattered in [true, false] {
            grid.deposit(&Medium::homogeneous(0.0, 0.0), &Segment { origin: centre, length: side, power, unscattered, field, edges: &[], column: Column::Uniform });
        }
        let mut bytes = vec![0; layout.saved_size()];
        prop_assert_eq!(layout.save(&cells, &mut bytes), Ok(()), "{:?}", cells);
        let mut loaded = empty(layout);
        prop_assert_eq!(load(layout, &mut loaded, &bytes), Ok(()));
        prop_assert_eq!(bits(&loaded), bits(&cells));
    }
}

#[test]
fn a_thousand_million_equal_deposits_save() {
    // A grid merged with itself thirty times, of a spectrum without width across (1, 2, 3): its covariances are the roots of the
    // variances' products exactly, and rounding shows.
    let mut cells = empty(UNIT);
    let mut grid = CovarianceGrid::new(UNIT, &mut cells).unwrap();
    let v = [0.1_f32, 0.2, 0.3];
    let outer = [v[0] * v[0], v[1] * v[1], v[2] * v[2], v[0] * v[1], v[0] * v[2], v[1] * v[2]];
    grid.deposit_spectrum(Vec3::splat(0.1), &spectrum(outer), 0.3);
    for _ in 0..30 {
        let copy = cells.clone();
        CovarianceGrid::new(UNIT, &mut cells).unwrap().merge(&copy).unwrap();
    }
    let bytes = saved(UNIT, &cells);
    let mut loaded = empty(UNIT);
    load(UNIT, &mut loaded, &bytes).unwrap();
    assert_eq!(bits(&loaded), bits(&cells));
}

#[test]
fn every_byte_counts() {
    let layout = GridLayout { cells: [2, 1, 1], ..SKEW };
    let cells = filled(&mut Stream::new(3), layout, 20);
    assert!(cells.iter().all(|cell| cell.weight > 0.0));
    let bytes = saved(layout, &cells);
    for at in 0..bytes.len() {
        for bit in 0..8 {
            let mut damaged = bytes.clone();
            damaged[at] ^= 1 << bit;
            let mut loaded = empty(layout);
            let error = load(layout, &mut loaded, &damaged).unwrap_err();
            let expected: &[GridError] = match at {
                0..12 => &[GridError::Format],
                // A corner may be moved to where it is no corner; otherwise only the checksum tells.
                12..36 => &[GridError::Layout, GridError::Damaged],
                36..48 => &[GridError::Layout, GridError::Length],
                _ => &[GridError::Damaged],
            };
            assert!(expected.contains(&error), "byte {at} bit {bit}: {error:?}");
            assert_eq!(bits(&loaded), bits(&empty(layout)), "byte {at} bit {bit}");
        }
    }
}

#[test]
fn bytes_of_another_length_are_refused_on_both_ways() {
    let mut cells = filled(&mut Stream::new(4), UNIT, 20);
    let bytes = saved(UNIT, &cells);
    for short in 0..bytes.len() {
        let expected = if short < 56 { GridError::Format } else { GridError::Length };
        assert_eq!(GridLayout::of_saved(&bytes[..short]), Err(expected), "{short} bytes");
        assert_eq!(load(UNIT, &mut cells, &bytes[..short]), Err(expected), "{short} bytes");
    }
    let mut long = bytes.clone();
    long.push(0);
    assert_eq!(GridLayout::of_saved(&long), Err(GridError::Length));
    assert_eq!(load(UNIT, &mut cells, &long), Err(GridError::Length));
    for length in [0, 55, 56, bytes.len() - 1, bytes.len() + 1] {
        let mut out = vec![0xAA; length];
        assert_eq!(UNIT.save(&cells, &mut out), Err(GridError::Length));
        assert_eq!(UNIT.save(&cells[1..], &mut vec![0; UNIT.saved_size()]), Err(GridError::Length));
        assert!(out.iter().all(|&byte| byte == 0xAA));
    }
    assert_eq!(saved(UNIT, &cells), bytes);
}

#[test]
fn layouts_that_no_grid_has_are_refused_before_anyone_allocates_for_them() {
    let cells = empty(UNIT);
    for layout in [
        GridLayout { min: Vec3::ONE, ..UNIT },
        GridLayout { max: Vec3::new(1.0, f32::NAN, 1.0), ..UNIT },
        GridLayout { max: Vec3::new(1.0, 1.0, f32::INFINITY), ..UNIT },
        GridLayout { cells: [0, 4, 4], ..UNIT },
        GridLayout { cells: [1 << 12, 1 << 12, 2], ..UNIT },
        GridLayout { cells: [u32::MAX; 3], ..UNIT },
    ] {
        assert_eq!(GridLayout::of_saved(&by_hand(&layout, &cells)), Err(GridError::Layout), "{layout:?}");
    }
    // As many as a grid may have, but the bytes are not there.
    let most = GridLayout { cells: [1 << 12, 1 << 12, 1], ..UNIT };
    assert_eq!(GridLayout::of_saved(&by_hand(&most, &cells)), Err(GridError::Length));
}

#[test]
fn a_grid_loads_only_its_own_layout_bit_for_bit() {
    let mut cells = filled(&mut Stream::new(5), UNIT, 20);
    let before = bits(&cells);
    let next = f32::from_bits(1.0_f32.to_bits() + 1);
    for other in [
        GridLayout { cells: [2, 8, 4], ..UNIT },
        GridLayout { cells: [4, 4, 3], ..UNIT },
        GridLayout { min: Vec3::new(0.0, -0.0, 0.0), ..UNIT },
        GridLayout { max: Vec3::new(1.0, 1.0, next), ..UNIT },
    ] {
        let bytes = by_hand(&other, &empty(other));
        assert_eq!(GridLayout::of_saved(&bytes), Ok(other));
        assert_eq!(load(UNIT, &mut cells, &bytes), Err(GridError::OtherLayout), "{other:?}");
    }
    assert_eq!(bits(&cells), before);
}

#[test]
fn sums_that_no_deposits_add_up_to_are_refused_on_both_ways() {
    let good = GridCell { sum: [4.0, 9.0, 16.0, 6.0, -8.0, 12.0], weight: 2.0 };
    let with = |index: usize, value: f64| {
        let mut cell = good;
        *if index == 6 { &mut cell.weight } else { &mut cell.sum[index] } = value;
        cell
    };
    let mut bad = Vec::new();
    for index in 0..7 {
        bad.extend([f64::NAN, f64::INFINITY, f64::NEG_INFINITY].map(|value| with(index, value)));
    }
    // Variances and weights below 0, covariances beyond the roots 6, 8 and 12.
    bad.extend([0, 1, 2, 6].map(|index| with(index, -1e-3)));
    bad.extend([(3, 6.001), (3, -6.001), (4, 8.001), (5, -12.001)].map(|(index, value)| with(index, value)));
    // Without weight, and with so little that the mean is no f32.
    bad.push(with(6, 0.0));
    bad.push(with(6, 1e-38));
    bad.push(GridCell { sum: [0.0, 0.0, 0.0, 1e-300, 0.0, 0.0], weight: 0.0 });
    bad.push(GridCell { sum: [0.0, 1.0, 0.0, 1e-15, 0.0, 0.0], weight: 1.0 });
    // So bright that the bounds themselves are infinite.
    bad.push(GridCell { sum: [f64::INFINITY, 0.0, 0.0, 0.0, 0.0, 0.0], weight: 1e300 });
    bad.push(GridCell { sum: [f64::MAX, f64::MAX, 0.0, f64::INFINITY, 0.0, 0.0], weight: 1e300 });
    // Where a product of variances would overflow or vanish.
    bad.push(GridCell { sum: [1e200, 1e200, 0.0, 1.1e200, 0.0, 0.0], weight: 1e180 });
    bad.push(GridCell { sum: [1e-200, 1e-200, 0.0, 1.1e-200, 0.0, 0.0], weight: 1e-180 });
    for cell in bad {
        let mut cells = filled(&mut Stream::new(6), UNIT, 20);
        let before = bits(&cells);
        let mut hostile = cells.clone();
        hostile[63] = cell;
        assert_eq!(load(UNIT, &mut cells, &by_hand(&UNIT, &hostile)), Err(GridError::Value), "{cell:?}");
        assert_eq!(bits(&cells), before);
        let mut out = vec![0xAA; UNIT.saved_size()];
        assert_eq!(UNIT.save(&hostile, &mut out), Err(GridError::Value), "{cell:?}");
        assert!(out.iter().all(|&byte| byte == 0xAA));
    }
    for cell in [
        good,
        with(3, -6.0),
        GridCell { sum: [1e200, 1e200, 0.0, 0.9e200, 0.0, 0.0], weight: 1e180 },
        // The variance of 1e-60 that f32 cannot hold, its covariance with 1 that it can.
        GridCell { sum: [0.0, 1.0, 0.0, 1e-30, 0.0, 0.0], weight: 1.0 },
        GridCell::default(),
    ] {
        let mut cells = empty(UNIT);
        let mut source = empty(UNIT);
        source[63] = cell;
        assert_eq!(load(UNIT, &mut cells, &by_hand(&UNIT, &source)), Ok(()), "{cell:?}");
        assert_eq!(bits(&cells), bits(&source));
    }
}

#[test]
fn each_refusal_says_what_is_wrong() {
    for (error, word) in [
        (GridError::Format, "not a saved grid"),
        (GridError::Damaged, "checksum"),
        (GridError::OtherLayout, "another box or resolution"),
        (GridError::Length, "length"),
        (GridError::Value, "sums"),
        (GridError::Value, "density"),
    ] {
        assert!(error.to_string().contains(word), "{error}");
    }
}

/// Prints the cost: `cargo test --release -p covbeam-tests --test mathematics saved -- --ignored --nocapture`.
#[test]
#[ignore = "a measurement, to be run alone and in release"]
fn the_cost_of_saving_and_loading() {
    let layout = GridLayout { cells: [64; 3], ..UNIT };
    let mut cells = filled(&mut Stream::new(7), layout, 2000);
    let mut bytes = vec![0; layout.saved_size()];
    let time = |work: &mut dyn FnMut()| {
        let start = std::time::Instant::now();
        (0..5).for_each(|_| work());
        start.elapsed().as_secs_f64() / 5.0 / f64::from(1 << 18) * 1e9
    };
    let save = time(&mut || layout.save(&cells, &mut bytes).unwrap());
    let load = time(&mut || load(layout, &mut cells, &bytes).unwrap());
    println!("save {save:.0} ns a voxel, load {load:.0} ns a voxel");
}
