//! Any bytes as a volume: densities that the core takes, or an error that can be printed.
#![no_main]

use covbeam::DensityGrid;
use covbeam_session::medium::volume::{MAX_DENSITY, Volume};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| match Volume::parse(bytes, None) {
    Ok(volume) => {
        // At least a byte a voxel.
        assert!(volume.values.len() < bytes.len() && volume.largest() <= MAX_DENSITY);
        assert!(DensityGrid::new(volume.layout, &volume.values).is_ok());
    }
    Err(error) => assert!(!error.to_string().is_empty()),
});
