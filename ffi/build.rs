//! Names the shared library as programs will look for it: see "Versions" at the top of `include/covbeam.h`.

use std::env::var;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed=Cargo.toml");
    // cargo-c does so itself, and two names are one too many.
    if var("CARGO_FEATURE_CAPI").is_ok() {
        return;
    }
    let manifest = std::fs::read_to_string("Cargo.toml").expect("the manifest that cargo has just read");
    let version = manifest.lines().find_map(|line| line.strip_prefix("version = \""));
    let abi = version.and_then(|version| version.split('.').next()).expect("a version of the library");
    let name = |option| println!("cargo::rustc-link-arg-cdylib=-Wl,{option}");
    match var("CARGO_CFG_TARGET_OS").as_deref() {
        Ok("linux") => name(format!("-soname,libcovbeam.so.{abi}")),
        Ok("macos") => name(format!("-install_name,@rpath/libcovbeam.{abi}.dylib")),
        _ => {}
    }
}
