//! Which library runs.

/// Of the ABI that the header declares. A host compares it with covbeam_abi_version().
pub const COVBEAM_ABI_VERSION: u32 = 3;

/// The ABI of the library that runs, which is COVBEAM_ABI_VERSION of the header it was built with.
///
/// Equal numbers fit together. The shared library's SONAME changes with it.
#[unsafe(no_mangle)]
pub extern "C" fn covbeam_abi_version() -> u32 {
    COVBEAM_ABI_VERSION
}

/// The version of the library that runs, such as "0.1.0".
///
/// @return a static string.
#[unsafe(no_mangle)]
pub extern "C" fn covbeam_version() -> *const core::ffi::c_char {
    concat!(env!("CARGO_PKG_VERSION"), "\0").as_ptr().cast()
}
