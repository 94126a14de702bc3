#!/bin/bash
# The C library in the projects of others: tests/clients/cmake.sh PREFIX    (PREFIX: where install.sh has installed)
# In the tree by add_subdirectory and FetchContent, installed by find_package and pkg-config; Makefiles and Ninja; linked wholly static,
# into plug-ins, and beside another static library in Rust.
set -euo pipefail
root="$(cd "$(dirname "$0")/../.." && pwd)"
[ $# -eq 1 ] || { echo "usage: $0 PREFIX" >&2; exit 1; }
prefix="$(cd "$1" && pwd)"
work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT
export PKG_CONFIG_PATH="$prefix/lib/pkgconfig" CARGO_NET_OFFLINE=true
clients="$root/tests/clients"
# So that cargo builds once, where install.sh has built.
export CARGO_TARGET_DIR="${CARGO_TARGET_DIR:-$work/cargo}"

fail() { echo "cmake: $*" >&2; exit 1; }

# quietly WHAT COMMAND...: its output only if it fails.
quietly() {
    local what="$1"
    shift
    "$@" > "$work/log" 2>&1 || { tail -n 60 "$work/log"; fail "$what"; }
}

# symbols FILE: what a shared library shows to others.
symbols() { nm -D --defined-only "$1" | awk '$2 != "A" { print $NF }' | LC_ALL=C sort; }

# A host with a program for each library, in C++ as most are, that takes covbeam as README.md says.
readme() { awk -v wanted="$1" '/^```cmake$/ { n++; inside = 1; next } /^```$/ { inside = 0 } inside && n == wanted' "$root/README.md"; }
readme 1 > "$work/find_package"
readme 2 > "$work/add_subdirectory"
readme 3 > "$work/fetch_content"
mkdir "$work/host"
cat > "$work/host/main.cpp" <<'CPP'
#include <covbeam_session.hpp>
#include <cstdio>

int main() { return std::printf("ABI %u\n", static_cast<unsigned>(covbeam_abi_version())) < 0 || covbeam_abi_version() != COVBEAM_ABI_VERSION; }
CPP
cat > "$work/host/CMakeLists.txt" <<'CMAKE'
cmake_minimum_required(VERSION 3.20)
project(host LANGUAGES CXX)
set(CMAKE_CXX_STANDARD 11)
add_executable(host main.cpp)
include(${WAY})
add_executable(host_static main.cpp)
target_link_libraries(host_static PRIVATE covbeam::covbeam_static)
install(TARGETS host host_static)
CMAKE
ln -s "$root" "$work/host/covbeam"

# host NAME WAY GENERATOR OPTIONS...: configured, built, built again with nothing to do, installed.
host() {
    local name="$1" way="$2" generator="$3" program
    shift 3
    quietly "$name: configure" cmake -S "$work/host" -B "$work/$name" -G "$generator" "-DWAY=$work/$way" \
        -DFETCHCONTENT_SOURCE_DIR_COVBEAM="$root" "$@"
    quietly "$name: build" cmake --build "$work/$name" --config Release
    quietly "$name: build again" cmake --build "$work/$name" --config Release
    if grep -E 'Linking|one object' "$work/log"; then fail "$name: built twice (above)"; fi
    quietly "$name: install" cmake --install "$work/$name" --config Release --prefix "$work/$name-prefix"
    # Where it is built the shared library is found, too.
    for program in host host_static; do
        quietly "$name: $program" "$(find "$work/$name" -type f -executable -name "$program")"
        grep -q '^ABI' "$work/log" || fail "$name: $program"
    done
    # Of covbeam only what a project asks for is installed.
    [ "$(cd "$work/$name-prefix" && find . -type f | LC_ALL=C sort | xargs)" = "./bin/host ./bin/host_static" ] ||
        fail "$name: installed: $(cd "$work/$name-prefix" && find . -type f)"
    "$work/$name-prefix/bin/host_static" > /dev/null || fail "$name: host_static, installed"
    echo "cmake: $name: built once, run, shared and static"
}
host find-package find_package "Unix Makefiles" "-DCMAKE_PREFIX_PATH=$prefix"
host find-package-ninja find_package Ninja "-DCMAKE_PREFIX_PATH=$prefix"
host subdirectory add_subdirectory "Unix Makefiles"
host subdirectory-ninja add_subdirectory Ninja
host fetch-content fetch_content Ninja
host fetch-content-configurations fetch_content "Ninja Multi-Config"
# The object is the same whoever makes it.
for name in subdirectory subdirectory-ninja fetch-content; do
    cmp "$(find "$work/$name" -name libcovbeam.a -not -path "*/archive/*")" "$prefix/lib/libcovbeam.a" || fail "$name: another libcovbeam.a than that of $prefix"
done

# A project that has it and does not link it does not build it.
mkdir "$work/idle"
ln -s "$root" "$work/idle/covbeam"
printf '%s\n' 'cmake_minimum_required(VERSION 3.20)' 'project(idle LANGUAGES CXX)' 'add_subdirectory(covbeam/ffi)' > "$work/idle/CMakeLists.txt"
for generator in "Unix Makefiles" Ninja; do
    CARGO=/bin/false quietly "idle: configure" cmake -S "$work/idle" -B "$work/idle/build" -G "$generator"
    quietly "idle: build" cmake --build "$work/idle/build"
    [ -z "$(find "$work/idle/build" -name libcovbeam.a)" ] || fail "built, though nothing links it"
    if cmake --build "$work/idle/build" --target covbeam_libraries > "$work/log" 2>&1; then fail "idle: CARGO was not used"; fi
    rm -r "$work/idle/build"
done
echo "cmake: in a project that does not link it: not built"

# What is missing is named, with its remedy.
printf '#!/bin/sh\necho "an ld of another kind"\n' > "$work/ld"
chmod +x "$work/ld"
# refused PATTERN OPTIONS...
refused() {
    local pattern="$1"
    shift
    if cmake -S "$root/ffi" -B "$work/refused" "$@" > "$work/log" 2>&1; then fail "not refused: $*"; fi
    tr -s ' \n' ' ' < "$work/log" | grep -q "$pattern" || { cat "$work/log"; fail "refused without '$pattern': $*"; }
    rm -r "$work/refused"
}
refused "install GNU binutils for it, and set COVBEAM_LD" "-DCOVBEAM_LD=$work/ld"
refused "install GNU binutils for it, and set COVBEAM_OBJCOPY" "-DCOVBEAM_OBJCOPY=$work/none"
mkdir "$work/tools"
for tool in cmake make cc as ld ar ranlib objcopy tr grep rm; do ln -s "$(command -v "$tool")" "$work/tools/"; done
# CMake looks into the system's folders, too, where a distribution's Rust may be.
PATH="$work/tools" refused "install Rust" -DCMAKE_FIND_USE_CMAKE_SYSTEM_PATH=OFF
refused "set COVBEAM_RUST_TARGET" -DCMAKE_SYSTEM_NAME=Linux -DCMAKE_SYSTEM_PROCESSOR=unheard-of
refused "rustup target add bpfel-unknown-none" -DCOVBEAM_RUST_TARGET=bpfel-unknown-none
echo "cmake: five things that are missing are named, with the remedy"

# One file, which needs nothing of the system.
static="$(pkg-config --static --libs covbeam)"
# shellcheck disable=SC2046,SC2086
quietly "g++ -static" g++ -static -std=c++11 "$work/host/main.cpp" -o "$work/alone" $(pkg-config --cflags covbeam) $static
if grep warning "$work/log"; then fail "g++ -static warns (above)"; fi
"$work/alone" > /dev/null || fail "g++ -static"
if readelf -l "$work/alone" | grep INTERP; then fail "g++ -static is not static"; fi
# Of the library a program has what it calls.
gcc -O2 "$work/host/main.cpp" -o "$work/small" -I"$prefix/include" "$prefix/lib/libcovbeam.a" -lm -Wl,--gc-sections
[ "$(stat -c %s "$work/small")" -lt 100000 ] || fail "a program of one call has $(stat -c %s "$work/small") bytes"
echo "cmake: g++ -static: $(stat -c %s "$work/alone") bytes; one call, with --gc-sections: $(stat -c %s "$work/small")"

# A plug-in: what is declared is seen through it, or with --exclude-libs nothing; of Rust nothing in any case.
cat > "$work/plugin.c" <<'C'
#include <covbeam_session.h>
unsigned plugin(void) { return covbeam_abi_version(); }
C
cat > "$work/load.c" <<'C'
#include <dlfcn.h>
#include <stdio.h>
int main(int count, char **names)
{
    for (int i = 1; i < count; i++) {
        void *library = dlopen(names[i], RTLD_NOW | RTLD_LOCAL);
        unsigned (*plugin)(void) = 0;
        if (library) *(void **)&plugin = dlsym(library, "plugin");
        if (!plugin) return fprintf(stderr, "%s\n", dlerror());
        if (plugin() == 0 || dlclose(library)) return 1;
    }
    return 0;
}
C
gcc "$work/load.c" -o "$work/load"
LC_ALL=C sort "$(find "$work/subdirectory" -name symbols)" > "$work/declared"
for compiler in "gcc -fuse-ld=bfd" "clang -fuse-ld=lld"; do
    # shellcheck disable=SC2206
    plugin=($compiler -shared -fPIC "$work/plugin.c" -I"$prefix/include" "$prefix/lib/libcovbeam.a" -lm)
    "${plugin[@]}" -o "$work/plain.so"
    diff <(symbols "$work/plain.so" | grep -vx plugin) "$work/declared" || fail "$compiler: a plug-in shows (<) what is not declared"
    "${plugin[@]}" -Wl,--exclude-libs,ALL -o "$work/closed.so"
    [ "$(symbols "$work/closed.so" | xargs)" = plugin ] || fail "$compiler: with --exclude-libs a plug-in shows: $(symbols "$work/closed.so")"
    "$work/load" "$work/plain.so" "$work/closed.so" || fail "$compiler: plug-ins"
done
echo "cmake: a plug-in shows the $(wc -l < "$work/declared") declared functions, with --exclude-libs,ALL none; nothing of Rust"

# Beside another static library in Rust, in both orders.
cat > "$work/other.rs" <<'RUST'
//! Another library in Rust, which catches a panic.
#[unsafe(no_mangle)]
pub extern "C" fn other_caught() -> i32 {
    std::panic::set_hook(Box::new(|_| {}));
    std::panic::catch_unwind(|| [0][std::hint::black_box(7)]).map_or(7, |_| 0)
}
RUST
rustc --edition 2024 --crate-type staticlib -O "$work/other.rs" -o "$work/libother.a"
orders=("$prefix/lib/libcovbeam.a $work/libother.a" "$work/libother.a $prefix/lib/libcovbeam.a")
for link in "gcc -fuse-ld=bfd" "gcc -fuse-ld=lld" "clang -fuse-ld=bfd" "clang -fuse-ld=lld"; do
    for order in "${orders[@]}"; do
        # shellcheck disable=SC2086
        $link -std=c99 -O1 -Wall -Wextra -Wpedantic -Werror -I"$prefix/include" "$clients"/{two_rusts,hosted}.c $order -lm \
            -Wl,--wrap=clock_gettime -o "$work/two" || fail "$link: two libraries in Rust: $order"
        "$work/two" 2> "$work/log" && [ ! -s "$work/log" ] || { cat "$work/log"; fail "$link: two libraries in Rust: $order"; }
    done
done
# The archive as Rust makes it does not link so: what is checked here is not true of itself.
cargo build --quiet --release --locked --manifest-path "$root/Cargo.toml" --package covbeam-ffi
if gcc -std=c99 -I"$prefix/include" "$clients"/{two_rusts,hosted}.c "$work/libother.a" "$CARGO_TARGET_DIR/release/libcovbeam.a" -lm \
    -Wl,--wrap=clock_gettime -o "$work/two" 2> "$work/log"; then
    fail "Rust's own archive links beside another: is one object needed?"
fi
grep -q 'multiple definition' "$work/log" || { tail "$work/log"; fail "Rust's own archive does not link for another reason"; }
echo "cmake: beside another static library in Rust, in both orders, by GNU ld and lld, gcc and clang: both catch their panics"
