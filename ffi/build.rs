//! Names the shared library as programs will look for it: see "Versions" at the top of `include/covbeam.h`.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    match std::env::var("CARGO_CFG_TARGET_OS").as_deref() {
        Ok("linux") => println!("cargo::rustc-link-arg-cdylib=-Wl,-soname,libcovbeam.so.1"),
        Ok("macos") => println!("cargo::rustc-link-arg-cdylib=-Wl,-install_name,@rpath/libcovbeam.1.dylib"),
        _ => {}
    }
}
