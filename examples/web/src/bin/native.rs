//! Natively what the page does: renders the default scene by both methods and prints a hash of each picture's
//! bits and the seconds of a pass: native PASSES. `tests/clients/web.sh` compares the hashes with the module's.

use covbeam::Vec3;
use covbeam_web::{Settings, View};
use std::time::Instant;

fn main() {
    let passes: u32 = std::env::args().nth(1).and_then(|word| word.parse().ok()).expect("native PASSES");
    for adaptive in [false, true] {
        let mut view = View::new(&Settings { adaptive, ..Settings::FIRST }, 320, 256);
        let start = Instant::now();
        (0..passes).for_each(|_| view.pass());
        let seconds = start.elapsed().as_secs_f64() / f64::from(passes);
        println!("{} {:016x} {seconds:.3}", u32::from(adaptive), hash(view.picture()));
    }
}

/// FNV-1a over the bytes of the radiance, little-endian.
fn hash(picture: &[Vec3]) -> u64 {
    let bytes = picture.iter().flat_map(|radiance| radiance.to_array()).flat_map(f32::to_le_bytes);
    bytes.fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3))
}
