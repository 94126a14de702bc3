#!/bin/bash
# What cargo-c installs is what CMake does, but for its package files: tests/clients/cinstall.sh PREFIX
# PREFIX: where install.sh has installed. Needs cargo-c (cargo install cargo-c), whose build is too long for .ci/run.
set -euo pipefail
root="$(cd "$(dirname "$0")/../.." && pwd)"
[ $# -eq 1 ] || { echo "usage: $0 PREFIX" >&2; exit 1; }
prefix="$(cd "$1" && pwd)"
work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT

(cd "$root" && cargo cinstall --release --locked --package covbeam-ffi --prefix "$work/prefix" --libdir lib)

# Names, kinds and targets of links; the exported symbols, the SONAME and the headers; pkg-config's fields, where
# order and what stands for the prefix do not matter. Cargo-c's static library is Rust's archive, CMake's one object (ffi/cmake/object.cmake),
# and only cargo-c names an unwinder.
describe() {
    (cd "$1" && find . ! -type d ! -path './lib/cmake/*' -printf '%p %y %l\n' | LC_ALL=C sort)
    nm -D --defined-only "$1/lib/libcovbeam.so" | awk '{ print $NF }' | LC_ALL=C sort
    readelf -d "$1/lib/libcovbeam.so" | grep SONAME
    cat "$1"/include/*
    grep -E '^[A-Z]' "$1/lib/pkgconfig/covbeam.pc" | sed '/^Libs.private/ s/ -lgcc_s\b//' | LC_ALL=C sort
}
diff <(describe "$prefix") <(describe "$work/prefix")
echo "cinstall: the same files as CMake's"
