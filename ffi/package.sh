#!/bin/bash
# Packages for other people's machines, from one with Linux: ffi/package.sh OUT [PLATFORM...]
#   PLATFORM: linux-x86_64 linux-aarch64 windows-x86_64 macos-aarch64 macos-x86_64    (all if none is named)
# Into OUT, which is new or empty: of each platform covbeam-VERSION-PLATFORM.tar.gz (Windows: .zip), with the C library, its headers, CMake and
# pkg-config files and the renderer's program, and Python's wheel; extensions/, from which Blender updates, with one zip for all; SHA256SUMS.
#
# Debian's packages: rustc-web, cargo-web and rust-web-src, which make the standard library of every target; cmake, ninja-build;
# gcc-aarch64-linux-gnu; gcc-mingw-w64-x86-64 (Windows); clang and lld-19 (macOS). In the environment of python3, from PyPI: hatchling; ziglang
# and cargo-zigbuild, for an old glibc and macOS' library. COVBEAM_BLENDER names a Blender, or a Python with its package bpy: its own
# tool makes the index of extensions/. A platform takes minutes, in $CARGO_TARGET_DIR/package. Tested by tests/platforms.sh.
set -euo pipefail
root="$(cd "$(dirname "$0")/.." && pwd)"
fail() { echo "package: $*" >&2; exit 1; }
[ $# -gt 0 ] || { sed -n '2,3s/^# *//p' "$0" >&2; exit 1; }
mkdir -p "$1"
out="$(cd "$1" && pwd)"
shift
[ -z "$(ls -A "$out")" ] || fail "$out is not empty"
[ $# -gt 0 ] || set -- linux-x86_64 linux-aarch64 windows-x86_64 macos-aarch64 macos-x86_64
work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT
version="$(sed -n 's/^version = "\(.*\)"/\1/p' "$root/Cargo.toml")"

# The oldest systems that Rust's standard library runs on.
glibc=2.17
macos=11.0

# need COMMAND WHERE: a command that must be there.
need() { command -v "$1" > /dev/null || fail "$1 is missing: $2"; }

# quietly WHAT COMMAND...: its output only if it fails.
quietly() {
    local what="$1"
    shift
    "$@" > "$work/log" 2>&1 || { tail -n 60 "$work/log" >&2; fail "$what (above)"; }
}

need cmake "Debian's package cmake"
need ninja "Debian's package ninja-build"
need /usr/bin/cargo "Debian's package cargo-web"
need cargo-zigbuild "pip install cargo-zigbuild"
python3 -c 'import hatchling, ziglang' 2> "$work/log" || fail "python3 lacks something: pip install hatchling ziglang"
[ -d "$(/usr/bin/rustc --print sysroot)/lib/rustlib/src/rust/library" ] || fail "Rust's sources are missing: Debian's package rust-web-src"
export CARGO=/usr/bin/cargo RUSTC=/usr/bin/rustc RUSTC_BOOTSTRAP=1 CARGO_UNSTABLE_BUILD_STD=std,panic_unwind
export CARGO_TARGET_DIR="${CARGO_TARGET_DIR:-$root/target}/package" CARGO_PROFILE_RELEASE_DEBUG=none

# zig_cargo TARGET: a cargo that builds for an old glibc.
zig_cargo() {
    cat > "$work/cargo-$1" <<SH
#!/bin/bash
arguments=()
for argument in "\$@"; do
    case "\$argument" in
        build) argument=zigbuild ;;
        $1) argument=$1.$glibc ;;
    esac
    arguments+=("\$argument")
done
# The compiler that CMake has found knows the glibc of its machine alone.
unset CARGO_TARGET_$(tr 'a-z-' 'A-Z_' <<< "$1")_LINKER
exec cargo-zigbuild "\${arguments[@]}"
SH
    chmod +x "$work/cargo-$1"
    echo "$work/cargo-$1"
}

# apple_cc ARCHITECTURE: a compiler that links for macOS by what zig knows of its library: without an SDK.
apple_cc() {
    local library="$work/sdk/usr/lib"
    mkdir -p "$library"
    # Of processors that lld 19 has not heard of nothing is needed.
    python3 - "$library/libSystem.tbd" <<'PYTHON'
import pathlib, re, sys, ziglang
text = (pathlib.Path(ziglang.__file__).parent / "lib/libc/darwin/libSystem.tbd").read_text()
text = re.sub(r"arm64e\.x1-\w+,\s*", "", re.sub(r",\s*arm64e\.x1-\w+", "", text))
pathlib.Path(sys.argv[1]).write_text(text)
PYTHON
    # All of these are that one library, or nothing is asked of them.
    for name in m c pthread dl iconv; do ln -sf libSystem.tbd "$library/lib$name.tbd"; done
    # clang knows the linker's options by its version.
    printf '#!/bin/sh\nexec clang --target=%s-apple-macos%s -Wno-unused-command-line-argument -mlinker-version=711 -Wl,-x --ld-path=%s -isysroot "%s" "$@"\n' \
        "$1" "$macos" "$(command -v ld64.lld-19)" "$work/sdk" > "$work/cc-$1"
    chmod +x "$work/cc-$1"
    echo "$work/cc-$1"
}

# describe PLATFORM: how it is built for: rust, its target; compiler; cargo; libraries, that Rust's standard library links there; system, CMake's name.
describe() {
    cargo=/usr/bin/cargo
    export CARGO_PROFILE_RELEASE_STRIP=symbols
    case "$1" in
        linux-x86_64) rust=x86_64-unknown-linux-gnu compiler=gcc ;;
        linux-aarch64) rust=aarch64-unknown-linux-gnu compiler=aarch64-linux-gnu-gcc ;;
        windows-x86_64) rust=x86_64-pc-windows-gnu compiler=x86_64-w64-mingw32-gcc ;;
        macos-aarch64) rust=aarch64-apple-darwin compiler=arm64 ;;
        macos-x86_64) rust=x86_64-apple-darwin compiler=x86_64 ;;
        *) fail "'$1' is no platform: linux-x86_64, linux-aarch64, windows-x86_64, macos-aarch64, macos-x86_64" ;;
    esac
    case "$1" in
        linux-*) system=Linux libraries="-lutil -lrt -lpthread -lm -ldl -lc" cargo="$(zig_cargo "$rust")" ;;
        windows-*) system=Windows libraries="-lkernel32 -lntdll -luserenv -lws2_32 -ldbghelp" ;;
        macos-*)
            need clang "Debian's package clang"
            need ld64.lld-19 "Debian's package lld-19"
            # There the linker leaves symbols out: rustc would call a tool of its own for it, which Debian's has not.
            export CARGO_PROFILE_RELEASE_STRIP=none
            system=Darwin libraries=-lSystem compiler="$(apple_cc "$compiler")" ;;
    esac
    need "$compiler" "a package of Debian named at the top of $0"
}

# make_tree PLATFORM FOLDER: what the archive of a platform has.
make_tree() {
    local build="$work/build-$1" name=covbeam
    printf 'set(CMAKE_SYSTEM_NAME %s)\nset(CMAKE_SYSTEM_PROCESSOR %s)\nset(CMAKE_C_COMPILER "%s")\n' \
        "$system" "${1#*-}" "$compiler" > "$work/$1.cmake"
    CARGO="$cargo" quietly "$1: cmake" cmake -G Ninja -S "$root/ffi" -B "$build" "-DCMAKE_TOOLCHAIN_FILE=$work/$1.cmake" -DCMAKE_BUILD_TYPE=Release \
        -DCMAKE_INSTALL_LIBDIR=lib "-DCOVBEAM_RUST_TARGET=$rust" "-DCOVBEAM_SYSTEM_LIBRARIES=$libraries"
    quietly "$1: the library" cmake --build "$build"
    quietly "$1: install" cmake --install "$build" --prefix "$2"
    quietly "$1: the program" env "CARGO_TARGET_$(tr 'a-z-' 'A-Z_' <<< "$rust")_LINKER=$compiler" \
        "$cargo" build --release --locked --manifest-path "$root/Cargo.toml" --package covbeam-render --bin covbeam --target "$rust"
    [ "$system" != Windows ] || name=covbeam.exe
    mkdir -p "$2/bin"
    cp "$CARGO_TARGET_DIR/$rust/release/$name" "$2/bin/"
    cp "$root"/LICENSE-{MIT,APACHE} "$root/CHANGELOG.md" "$2/"
    # The program holds all crates that the library does.
    PYTHONPATH="$root/ffi/python" PYTHONDONTWRITEBYTECODE=1 python3 -c 'import sys, hatch_build; sys.stdout.write(hatch_build.third_party("covbeam-render", *sys.argv[1:]))' \
        "$rust" "$root" > "$2/THIRD-PARTY"
}

# pack PLATFORM: its archive and its wheel.
pack() {
    local tree="covbeam-$version-$1" library started=$SECONDS
    describe "$1"
    export SDKROOT="$work/sdk" MACOSX_DEPLOYMENT_TARGET="$macos"
    make_tree "$1" "$work/$tree"
    # The same files are the same bytes.
    case "$1" in
        windows-*)
            library="$work/$tree/bin/covbeam.dll"
            (cd "$work" && find "$tree" ! -type d | LC_ALL=C sort > files && cmake -E tar cf "$out/$tree.zip" --format=zip --mtime=2026-01-01 --files-from=files)
            ;;
        *)
            library="$(find "$work/$tree/lib" -maxdepth 1 -type f \( -name '*.so.*' -o -name '*.dylib' \))"
            tar -C "$work" --sort=name --mtime=2026-01-01 --owner=0 --group=0 --numeric-owner -c "$tree" | gzip -9n > "$out/$tree.tar.gz"
            ;;
    esac
    (cd "$root/ffi/python" && COVBEAM_LIBRARY="$library" quietly "$1: the wheel" python3 -m hatchling build --target wheel --directory "$out")
    echo "package: $1: $(stat -c %s "$out/$tree".*) bytes, library $(stat -c %s "$library"), in $((SECONDS - started)) s"
}

for platform in "$@"; do pack "$platform"; done

# Blender's own tool writes the index that it looks for updates in.
mkdir "$out/extensions"
quietly "the extension for Blender" python3 "$root/examples/blender/build.py" --output "$out/extensions" "$out"/*.whl
blender="${COVBEAM_BLENDER:-blender}"
need "$blender" "set COVBEAM_BLENDER to a Blender, or to a Python with its package bpy"
if "$blender" -c 'import bpy' > "$work/log" 2>&1; then
    tool="$("$blender" -c 'import bpy, os; print(os.path.join(bpy.utils.system_resource("SCRIPTS"), "addons_core", "bl_pkg", "cli", "blender_ext.py"))' | tail -n 1)"
    generate=("$blender" "$tool")
else
    generate=("$blender" --command extension)
fi
quietly "the index of the extensions" "${generate[@]}" server-generate --repo-dir "$out/extensions"

(cd "$out" && find . -type f | sed 's|^\./||' | LC_ALL=C sort | xargs sha256sum > "$work/sums" && mv "$work/sums" SHA256SUMS)
echo "package: $(wc -l < "$out/SHA256SUMS") files in $out"
