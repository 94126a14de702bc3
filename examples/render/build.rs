//! Tells `covbeam report` what the program was built with.

use std::process::Command;

fn main() {
    let variable = |name: &str| std::env::var(name).unwrap_or_else(|_| "unknown".to_owned());
    let compiler = Command::new(variable("RUSTC")).arg("--version").output();
    let version = compiler.ok().and_then(|said| String::from_utf8(said.stdout).ok());
    let version = version.map_or_else(|| "unknown".to_owned(), |text| text.trim().to_owned());
    println!("cargo::rustc-env=COVBEAM_RUSTC={version}");
    println!("cargo::rustc-env=COVBEAM_PROFILE={}", variable("PROFILE"));
    println!("cargo::rustc-env=COVBEAM_OPT_LEVEL={}", variable("OPT_LEVEL"));
    println!("cargo::rerun-if-changed=build.rs");
}
