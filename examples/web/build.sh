#!/bin/bash
# Builds the page: examples/web/build.sh OUT. Then open OUT/index.html; it needs no server and no network.
# Takes rustup's target wasm32-unknown-unknown; without it, a Rust whose standard library has its sources (Debian's
# rustc-web, cargo-web, rust-web-src, or rustup's component rust-src) and wasm-ld (Debian's lld).
set -euo pipefail
[ $# -eq 1 ] || { echo "usage: $0 OUT" >&2; exit 1; }
mkdir -p "$1"
out="$(realpath "$1")"
here="$(cd "$(dirname "$0")" && pwd)"
cd "$here/../.."
target="$(realpath -m "${CARGO_TARGET_DIR:-target}")"
export RUSTFLAGS="-C target-feature=+simd128"
module=(--quiet --locked --package covbeam-web --lib --profile web --target wasm32-unknown-unknown)

# has_sources RUSTC: whether the compiler's standard library can be built.
has_sources() { [ -e "$("$1" --print sysroot 2> /dev/null)/lib/rustlib/src/rust/library/std/Cargo.toml" ]; }

# The standard library is built along: an unstable option, which a stable compiler is told to take.
with_std() {
    command -v wasm-ld > /dev/null || { echo "build.sh: no linker wasm-ld (Debian's package lld)" >&2; exit 1; }
    RUSTC="$1" RUSTC_BOOTSTRAP=1 CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_LINKER=wasm-ld \
        "$2" build -Zbuild-std=std,panic_abort "${module[@]}"
}

if [ -d "$(rustc --print sysroot 2> /dev/null)/lib/rustlib/wasm32-unknown-unknown/lib" ]; then
    echo "build.sh: cargo, with its target wasm32-unknown-unknown"
    CARGO_TARGET_DIR="$target" cargo build "${module[@]}"
elif has_sources /usr/bin/rustc; then
    echo "build.sh: no target wasm32-unknown-unknown (rustup target add wasm32-unknown-unknown): Debian's cargo, with its standard library"
    # Of another compiler's version.
    target="$target/debian"
    PATH=/usr/bin:/bin CARGO_TARGET_DIR="$target" with_std /usr/bin/rustc /usr/bin/cargo
elif has_sources rustc; then
    echo "build.sh: no target wasm32-unknown-unknown (rustup target add wasm32-unknown-unknown): cargo, with its standard library"
    CARGO_TARGET_DIR="$target" with_std rustc cargo
else
    echo "build.sh: Rust cannot build for WebAssembly: rustup target add wasm32-unknown-unknown" >&2
    exit 1
fi

# As text in a script: a page that was opened as a file may fetch nothing.
wasm="$target/wasm32-unknown-unknown/web/covbeam_web.wasm"
cp "$here"/page/* "$out"
{ printf "const MODULE = '"; base64 -w 0 "$wasm"; printf "';\n"; } > "$out/module.js"
echo "build.sh: a module of $(stat -c %s "$wasm") bytes; open $out/index.html"
