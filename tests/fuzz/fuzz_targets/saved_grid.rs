//! Any bytes as a saved grid: refused with an error that can be printed and no cell changed, or a grid that saves as the same bytes.
#![no_main]

use covbeam::{CovarianceGrid, GridCell, GridLayout, Vec3};
use libfuzzer_sys::fuzz_target;

/// A layout to load into that the bytes need not have.
const LAYOUT: GridLayout = GridLayout { min: Vec3::ZERO, max: Vec3::ONE, cells: [2, 1, 1] };

/// Magic, version, few voxels, the length and the checksum put right, so that the other numbers are looked at.
fn repair(bytes: &[u8]) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    bytes.resize(bytes.len().max(56), 0);
    bytes[..12].copy_from_slice(b"covbeamG\x01\0\0\0");
    let mut size = 56;
    for axis in 0..3 {
        let count = bytes[36 + 4 * axis] % 4;
        bytes[36 + 4 * axis..40 + 4 * axis].copy_from_slice(&[count, 0, 0, 0]);
        size *= usize::from(count);
    }
    bytes.resize(56 + size, 0);
    let mut sum = 0xCBF2_9CE4_8422_2325_u64;
    for &byte in bytes[..48].iter().chain(&bytes[56..]) {
        sum = (sum ^ u64::from(byte)).wrapping_mul(0x0100_0000_01B3);
    }
    bytes[48..56].copy_from_slice(&sum.to_le_bytes());
    bytes
}

fn load(layout: GridLayout, bytes: &[u8]) {
    let before = GridCell { sum: [1.0; 6], weight: 1.0 };
    let mut cells = vec![before; layout.cell_count()];
    let mut grid = CovarianceGrid::new(layout, &mut cells).expect("a sound layout");
    match grid.load(bytes) {
        Ok(()) => {
            let mut again = vec![0; layout.saved_size()];
            layout.save(&cells, &mut again).expect("what loads can be saved");
            assert!(again == bytes);
        }
        Err(error) => {
            assert!(!error.to_string().is_empty());
            assert!(cells.iter().all(|cell| *cell == before));
        }
    }
}

fuzz_target!(|input: &[u8]| {
    let Some((mode, bytes)) = input.split_first() else { return };
    let repaired = if mode % 2 == 1 { repair(bytes) } else { bytes.to_vec() };
    match GridLayout::of_saved(&repaired) {
        Ok(layout) => {
            assert_eq!(layout.saved_size(), repaired.len());
            load(layout, &repaired);
        }
        Err(error) => assert!(!error.to_string().is_empty()),
    }
    load(LAYOUT, &repaired);
});
