//! Volume files: what is written arrives, and whatever is wrong is refused before memory is spent on it.

use std::path::PathBuf;

use covbeam::{DensityGrid, GridLayout};
use covbeam_session::medium::volume::{MAX_DENSITY, MAX_VOXELS, Volume, VolumeError};
use glam::Vec3;
use proptest::prelude::*;

const FLOAT32: i32 = 1;
const UINT8: i32 = 3;
const BOX: [f32; 6] = [-1.0, 0.0, 2.0, 1.0, 3.0, 2.5];

/// A header as the format's description has it, field by field.
fn header(encoding: i32, cells: [i32; 3], corners: [f32; 6]) -> Vec<u8> {
    let mut bytes = b"VOL\x03".to_vec();
    for integer in [encoding, cells[0], cells[1], cells[2], 1] {
        bytes.extend(integer.to_le_bytes());
    }
    corners.iter().for_each(|coordinate| bytes.extend(coordinate.to_le_bytes()));
    bytes
}

/// A float32 volume.
fn volume(cells: [i32; 3], values: &[f32]) -> Vec<u8> {
    let mut bytes = header(FLOAT32, cells, BOX);
    values.iter().for_each(|value| bytes.extend(value.to_le_bytes()));
    bytes
}

/// 2 x 3 x 2 voxels, and their bytes.
fn small() -> (Vec<f32>, Vec<u8>) {
    let values: Vec<f32> = (0..12).map(|i| 0.25 * i as f32).collect();
    let bytes = volume([2, 3, 2], &values);
    (values, bytes)
}

fn refused(bytes: &[u8]) -> String {
    match Volume::parse(bytes, None) {
        Ok(volume) => panic!("{volume:?} was accepted"),
        Err(error) => error.to_string(),
    }
}

/// `bytes` with others from `at` on.
fn with(mut bytes: Vec<u8>, at: usize, other: &[u8]) -> Vec<u8> {
    bytes[at..at + other.len()].copy_from_slice(other);
    bytes
}

/// Scratch folder with one file.
fn file(bytes: &[u8]) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("smoke.vol");
    std::fs::write(&path, bytes).expect("written");
    (folder, path)
}

#[test]
fn what_is_written_arrives_bit_by_bit() {
    let values = [0.0, -0.0, f32::MIN_POSITIVE, 1e-45, 1.0 / 3.0, MAX_DENSITY];
    let read = Volume::parse(&volume([1, 2, 3], &values), None).expect("valid");
    assert_eq!(read.layout.cells, [1, 2, 3]);
    assert_eq!((read.layout.min, read.layout.max), (Vec3::new(-1.0, 0.0, 2.0), Vec3::new(1.0, 3.0, 2.5)));
    let bits = |values: &[f32]| values.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
    assert_eq!(bits(&read.values), bits(&values));
    assert_eq!(read.largest(), MAX_DENSITY);
}

#[test]
fn bytes_mean_fractions_of_255() {
    let mut bytes = header(UINT8, [256, 1, 1], BOX);
    bytes.extend(0..=255u8);
    let read = Volume::parse(&bytes, None).expect("valid");
    assert_eq!((read.values[0], read.values[51], read.values[255]), (0.0, 0.2, 1.0));
    assert!(read.values.is_sorted_by(|a, b| a < b));
}

#[test]
fn x_runs_fastest_and_z_slowest() {
    // The density is 1 only in voxel (1, 2, 0).
    let mut values = [0.0; 2 * 3 * 4];
    values[1 + 2 * 2] = 1.0;
    let read = Volume::parse(&volume([2, 3, 4], &values), None).expect("valid");
    let grid = covbeam::Density::Grid(DensityGrid::new(read.layout, &read.values).expect("sound"));
    // Box [-1, 1] x [0, 3] x [2, 2.5]: voxels of 1 x 1 x 1/8.
    assert_eq!(grid.at(Vec3::new(0.5, 2.5, 2.0625)), 1.0);
    for neighbour in [Vec3::new(-0.5, 2.5, 2.0625), Vec3::new(0.5, 1.5, 2.0625), Vec3::new(0.5, 2.5, 2.1875)]
    {
        assert_eq!(grid.at(neighbour), 0.0);
    }
}

/// Written by Mitsuba 3.9.1: `VolumeGrid((0.25 * arange(12)).reshape(2, 3, 2, 1)).write(...)`.
#[test]
fn a_file_from_mitsuba_is_read() {
    let bytes = b"VOL\x03\x01\0\0\0\x02\0\0\0\x03\0\0\0\x02\0\0\0\x01\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\x80?\0\0\x80?\0\0\x80?\
        \0\0\0\0\0\0\x80>\0\0\0?\0\0@?\0\0\x80?\0\0\xa0?\0\0\xc0?\0\0\xe0?\0\0\0@\0\0\x10@\0\0 @\0\x000@";
    let read = Volume::parse(bytes, None).expect("valid");
    assert_eq!(read.layout, GridLayout { min: Vec3::ZERO, max: Vec3::ONE, cells: [2, 3, 2] });
    assert_eq!(read.values, small().0);
}

#[test]
fn a_volume_longer_than_the_reading_buffer_arrives_whole() {
    // 50 x 41 x 37 voxels are 303,400 bytes, which is not a multiple of any buffer's size.
    let values: Vec<f32> = (0..50 * 41 * 37).map(|i| i as f32).collect();
    let (_folder, path) = file(&volume([50, 41, 37], &values));
    assert!(Volume::load(&path, None).expect("valid").values == values);
    let bytes: Vec<u8> = (0..50 * 41 * 37).map(|i| (i % 251) as u8).collect();
    let (_folder, path) = file(&[header(UINT8, [50, 41, 37], BOX), bytes.clone()].concat());
    let read = Volume::load(&path, None).expect("valid");
    assert!(read.values.iter().zip(&bytes).all(|(value, &byte)| *value == f32::from(byte) / 255.0));
}

#[test]
fn a_volume_without_any_density_is_a_volume() {
    let read = Volume::parse(&volume([3, 1, 1], &[0.0; 3]), None).expect("valid");
    assert_eq!(read.largest(), 0.0);
}

#[test]
fn the_scenes_box_replaces_the_files() {
    let corners = (Vec3::splat(-2.0), Vec3::splat(2.0));
    let (values, bytes) = small();
    let nowhere = with(bytes.clone(), 24, &f32::NAN.to_le_bytes());
    for bytes in [bytes, nowhere] {
        let read = Volume::parse(&bytes, Some(corners)).expect("valid");
        let layout = GridLayout { min: corners.0, max: corners.1, cells: [2, 3, 2] };
        assert_eq!((read.layout, &read.values), (layout, &values));
    }
}

#[test]
fn every_wrong_header_is_refused_with_what_was_found_what_is_expected_and_what_to_do() {
    let (_, bytes) = small();
    let int = |at: usize, value: i32| with(bytes.clone(), at, &value.to_le_bytes());
    let cases: &[(Vec<u8>, &str)] = &[
        (
            Vec::new(),
            "has 0 bytes, expected at least the 48 of the header of a .vol file: write the file again",
        ),
        (b"VO".to_vec(), "has 2 bytes, expected at least the 48"),
        (bytes[..47].to_vec(), "has 47 bytes, expected at least the 48"),
        (b"v 0 0 0\n".to_vec(), "starts with v 0, expected \"VOL\": only Mitsuba's .vol files are read"),
        (b" BDV\0\0\0\0".to_vec(), "convert OpenVDB and others"),
        (with(bytes.clone(), 0, b"VOX"), "starts with VOX, expected \"VOL\""),
        (with(bytes.clone(), 0, &[0xff, 0, b'\n']), "starts with \\xff\\x00\\n, expected"),
        (with(bytes.clone(), 3, &[2]), "has version 2 of the .vol format, expected version 3: export"),
        (int(4, 2), "has encoding 2, expected 1 (float32) or 3 (uint8): export the densities as float32"),
        (int(4, -1), "has encoding -1, expected 1"),
        (int(20, 3), "has 3 channels, expected 1: export the density alone"),
        (int(20, 0), "has 0 channels"),
        (int(20, i32::MIN), "has -2147483648 channels"),
        (int(8, 0), "has 0 x 3 x 2 voxels, expected at least 1 along each axis: export it again"),
        (int(12, -3), "has 2 x -3 x 2 voxels, expected at least 1"),
        (int(16, i32::MIN), "has 2 x 3 x -2147483648 voxels, expected at least 1"),
        (
            int(8, 1 << 24),
            "has 16777216 x 3 x 2 voxels, expected at most 16777216 together: export it at a lower",
        ),
    ];
    for (bytes, expected) in cases {
        let message = refused(bytes);
        assert!(message.contains(expected), "found {message}, expected {expected}");
    }
    // Two negative numbers of voxels do not make a positive one, and three large ones do not wrap around.
    let message = refused(&with(int(8, -2), 12, &(-3i32).to_le_bytes()));
    assert!(message.contains("-2 x -3 x 2 voxels, expected at least 1"), "{message}");
    for side in [1 << 16, 1 << 22, i32::MAX] {
        let message = refused(&header(FLOAT32, [side; 3], BOX));
        assert!(message.contains("expected at most 16777216"), "{message}");
    }
}

#[test]
fn a_file_of_the_wrong_length_is_refused_with_both_lengths() {
    let (_, bytes) = small();
    for end in 48..bytes.len() {
        let message = refused(&bytes[..end]);
        let expected = format!("has {end} bytes, expected 96 for 2 x 3 x 2 voxels: the file is cut off");
        assert!(message.contains(&expected), "{message}");
    }
    let message = refused(&[bytes.as_slice(), &[0]].concat());
    assert!(
        message.contains("has 97 bytes, expected 96 for 2 x 3 x 2 voxels: the file is too long"),
        "{message}"
    );
    let (_folder, path) = file(&bytes[..95]);
    let error = Volume::load(&path, None).expect_err("cut off");
    assert!(matches!(error, VolumeError::Length { found: 95, expected: 96, cells: [2, 3, 2] }), "{error}");
    // As float32 the same bytes are a quarter of what they are as uint8.
    let message = refused(&with(bytes, 4, &UINT8.to_le_bytes()));
    assert!(message.contains("has 96 bytes, expected 60"), "{message}");
}

#[test]
fn a_box_without_extent_or_beyond_the_scenes_limits_is_refused() {
    let (values, bytes) = small();
    let (nan, inf) = (f32::NAN, f32::INFINITY);
    for corners in [
        [0.0; 6],
        [-1.0, 0.0, 2.0, 1.0, 0.0, 2.5],
        [1.0, 0.0, 2.0, -1.0, 3.0, 2.5],
        [nan, 0.0, 2.0, 1.0, 3.0, 2.5],
        [-1.0, 0.0, 2.0, 1.0, 3.0, nan],
        [-inf, 0.0, 2.0, 1.0, 3.0, 2.5],
        [-1.0, 0.0, 2.0, 1.0, inf, 2.5],
        [-1.0, 0.0, 2.0, 1.0, 2e9, 2.5],
        // Voxels of 0.9e-9.
        [0.0, 0.0, 2.0, 1.8e-9, 3.0, 2.5],
        [f32::MIN, f32::MIN, f32::MIN, f32::MAX, f32::MAX, f32::MAX],
    ] {
        let mut wrong = header(FLOAT32, [2, 3, 2], corners);
        values.iter().for_each(|value| wrong.extend(value.to_le_bytes()));
        let message = refused(&wrong);
        assert!(
            message.contains("has the box [") && message.contains("±1e9") && message.contains("give `min`"),
            "{message}"
        );
        // Nor may the scene ask for it.
        let scene = (Vec3::from_slice(&corners), Vec3::from_slice(&corners[3..]));
        assert!(matches!(Volume::parse(&bytes, Some(scene)), Err(VolumeError::Box { .. })), "{corners:?}");
    }
}

#[test]
fn a_density_that_is_none_is_refused_with_its_voxel() {
    let (values, _) = small();
    // The next number after 1e9 in f32.
    let above = MAX_DENSITY.next_up();
    for wrong in [f32::NAN, -f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1e-45, -1.0, above, f32::MAX] {
        for (index, voxel) in [(0, [0, 0, 0]), (5, [1, 2, 0]), (8, [0, 1, 1]), (11, [1, 2, 1])] {
            let mut broken = values.clone();
            broken[index] = wrong;
            let error = Volume::parse(&volume([2, 3, 2], &broken), None).expect_err("not a density");
            let [x, y, z] = voxel;
            let start =
                format!("has density {wrong} in voxel [{x}, {y}, {z}] (number {index}), expected 0..=1e9: ");
            assert!(error.to_string().starts_with(&start), "{error}");
        }
    }
    // The first of several is named.
    let error = Volume::parse(&volume([2, 1, 1], &[-1.0, f32::NAN]), None).expect_err("two wrong ones");
    assert!(matches!(error, VolumeError::Density { index: 0, found: -1.0, .. }), "{error}");
}

#[test]
fn what_is_no_file_is_refused() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    assert!(matches!(Volume::load(folder.path(), None), Err(VolumeError::NotAFile)));
    let missing = Volume::load(&folder.path().join("none.vol"), None).expect_err("missing");
    assert!(missing.to_string().starts_with("cannot be read: "), "{missing}");
    #[cfg(unix)]
    #[cfg(unix)]
    assert!(matches!(Volume::load("/dev/zero".as_ref(), None), Err(VolumeError::NotAFile)));
}

/// The files are as long as their headers ask for, but have no content on the disk.
#[test]
fn memory_is_bounded_before_it_is_allocated() {
    let sparse = |cells: [i32; 3], length: u64| {
        let (folder, path) = file(&header(FLOAT32, cells, BOX));
        std::fs::OpenOptions::new().write(true).open(&path).expect("open").set_len(length).expect("sparse");
        (folder, path)
    };
    // 10⁹ voxels and none of them there; 10⁹ voxels, all there; as many as allowed and none of them there.
    for (cells, length) in [([1000; 3], 48), ([1000; 3], 48 + 4_000_000_000), ([256; 3], 48), ([256; 3], 49)]
    {
        let (_folder, path) = sparse(cells, length);
        let mut result = None;
        let used = allocation_counter::measure(|| result = Some(Volume::load(&path, None)));
        let error = result.expect("ran").expect_err("too large or cut off");
        assert!(matches!(error, VolumeError::TooLarge(_) | VolumeError::Length { .. }), "{error}");
        // The path as the operating system wants it.
        assert!(used.bytes_total < 4096, "{cells:?}, {length} bytes: allocated {}", used.bytes_total);
    }
    let bytes = header(FLOAT32, [1000; 3], BOX);
    let used = allocation_counter::measure(|| assert!(Volume::parse(&bytes, None).is_err()));
    assert_eq!(used.bytes_total, 0);

    // The largest volume: 4 bytes a voxel and a buffer.
    let (_folder, path) = sparse([256; 3], 48 + 4 * u64::from(MAX_VOXELS));
    let mut voxels = 0;
    let used =
        allocation_counter::measure(|| voxels = Volume::load(&path, None).expect("valid").values.len());
    assert_eq!(voxels, MAX_VOXELS as usize);
    assert!(used.bytes_max <= 65 << 20, "{} bytes", used.bytes_max);
}

#[test]
fn a_volume_cut_anywhere_or_with_any_byte_changed_is_read_or_refused() {
    let (_, bytes) = small();
    for end in 0..bytes.len() {
        assert!(Volume::parse(&bytes[..end], None).is_err(), "cut at {end}");
    }
    for place in 0..bytes.len() {
        for byte in 0..=255 {
            check(&with(bytes.clone(), place, &[byte]));
        }
    }
}

/// Whatever is accepted is what the core takes, and what the file has.
fn check(bytes: &[u8]) {
    match Volume::parse(bytes, None) {
        Ok(volume) => {
            assert!(DensityGrid::new(volume.layout, &volume.values).is_ok(), "{volume:?}");
            assert!(volume.largest() <= MAX_DENSITY && volume.values.len() < bytes.len());
        }
        Err(error) => assert!(!error.to_string().contains('\n'), "{error}"),
    }
}

/// Headers near valid ones, so that all checks are reached; the length is right, wrong by a little, or anything.
fn near_volumes() -> impl Strategy<Value = Vec<u8>> {
    let side = prop_oneof![8 => 1i32..5, 1 => any::<i32>(), 1 => Just(0)];
    let coordinate = prop_oneof![6 => -10.0f32..10.0, 1 => any::<f32>(), 1 => Just(f32::NAN)];
    let encoding = prop_oneof![4 => Just(FLOAT32), 4 => Just(UINT8), 1 => any::<i32>()];
    let tail = prop::collection::vec(prop_oneof![3 => 0u8..64, 1 => any::<u8>()], 520);
    (encoding, [side.clone(), side.clone(), side], prop::array::uniform6(coordinate), tail, 0usize..8)
        .prop_map(|(encoding, cells, corners, tail, off)| {
            let count = cells.iter().try_fold(1i32, |count, &n| count.checked_mul(n)).unwrap_or(0);
            let size = if encoding == FLOAT32 { 4 } else { 1 };
            let length = (size * count.clamp(0, 128)) as usize + off.saturating_sub(4);
            [header(encoding, cells, corners), tail[..length].to_vec()].concat()
        })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(80 * ProptestConfig::default().cases))]

    #[test]
    fn any_bytes_are_a_volume_or_an_error(
        bytes in prop_oneof![3 => near_volumes(), 1 => prop::collection::vec(any::<u8>(), 0..200)]
    ) {
        check(&bytes);
    }

    #[test]
    fn any_densities_in_range_survive_the_way_through_a_file(
        values in prop::collection::vec(0.0f32..=MAX_DENSITY, 24)
    ) {
        prop_assert_eq!(Volume::parse(&volume([2, 3, 4], &values), None).expect("valid").values, values);
    }
}
