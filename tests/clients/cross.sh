#!/bin/bash
# The C library for other machines, by CMake on this one: tests/clients/cross.sh [windows] [aarch64]    (both if none is named)
# Each is built with a toolchain file, installed, found by find_package, and replays tests/vectors.txt: under Wine and under QEMU. The picture of README's
# session is the one of tests/golden.txt.
# Debian's packages: rustc-web, cargo-web and rust-web-src, which make the standard library of the targets; cmake and ninja-build;
# gcc-mingw-w64-x86-64 and wine64; gcc-aarch64-linux-gnu and qemu-user. Minutes each, in $CARGO_TARGET_DIR/cross.
set -euo pipefail
root="$(cd "$(dirname "$0")/../.." && pwd)"
target="$(realpath -m "${CARGO_TARGET_DIR:-$root/target}")/cross"
work="$(mktemp -d)"
# Wine's server outlives its programs, and writes into its folder.
ended() {
    [ ! -e "$work/wine" ] || WINEPREFIX="$work/wine" wineserver -k || true
    rm -rf "$work"
}
trap ended EXIT
version="$(sed -n 's/^version = "\(.*\)"/\1/p' "$root/Cargo.toml")"
[ $# -gt 0 ] || set -- windows aarch64

fail() { echo "cross: $*" >&2; exit 1; }
# shellcheck source=tests/clients/systems.sh
. "$root/tests/clients/systems.sh"

# quietly WHAT COMMAND...: its output only if it fails.
quietly() {
    local what="$1"
    shift
    "$@" > "$work/log" 2>&1 || { tail -n 60 "$work/log"; fail "$what"; }
}

# FNV-1a, of a file.
hash() {
    python3 - "$1" <<'PYTHON'
import sys
value = 0xCBF29CE484222325
for byte in open(sys.argv[1], "rb").read():
    value = (value ^ byte) * 0x100000001B3 % 2**64
print(f"{value:016x}")
PYTHON
}
golden="$(sed -n "s/^README.md's fog.pfm //p" "$root/tests/golden.txt")"
[ -n "$golden" ] || fail "tests/golden.txt has no picture of README's session"

# What both machines run: every function's bits, layouts and values, and a picture.
mkdir "$work/clients"
awk '/^```c$/ { inside = 1; next } /^```$/ { if (inside) exit } inside' "$root/README.md" > "$work/clients/session.c"
cat > "$work/clients/CMakeLists.txt" <<'CMAKE'
cmake_minimum_required(VERSION 3.21)
project(clients LANGUAGES C)
find_package(covbeam REQUIRED)
set(CMAKE_C_STANDARD 99)
foreach(link shared static)
    foreach(client vectors abi)
        add_executable(${client}-${link} ${CLIENTS}/${client}.c)
    endforeach()
    add_executable(glass_ball-${link} ${CLIENTS}/../../examples/c/glass_ball.c)
    add_executable(session-${link} session.c)
    foreach(client vectors abi glass_ball session)
        if(link STREQUAL "static")
            target_link_libraries(${client}-${link} PRIVATE covbeam::covbeam_static)
        else()
            target_link_libraries(${client}-${link} PRIVATE covbeam::covbeam)
        endif()
        if(UNIX)
            target_link_libraries(${client}-${link} PRIVATE m)
        elseif(link STREQUAL "shared")
            # As README.md has it: a program for Windows finds the library beside itself.
            add_custom_command(TARGET ${client}-${link} POST_BUILD
                COMMAND ${CMAKE_COMMAND} -E copy_if_different $<TARGET_RUNTIME_DLLS:${client}-${link}> $<TARGET_FILE_DIR:${client}-${link}>
                COMMAND_EXPAND_LISTS)
        endif()
    endforeach()
endforeach()
CMAKE

# cross NAME GENERATOR LIBRARIES SUFFIX RUNNER...: builds, installs and runs with $work/NAME.cmake. LIBRARIES are those that Rust's standard
# library links: rustc tells only where it comes with one. SUFFIX is that of programs.
cross() {
    local name="$1" generator="$2" libraries="$3" suffix="$4"
    shift 4
    local cmake=(cmake -G "$generator" "-DCMAKE_TOOLCHAIN_FILE=$work/$name.cmake") started=$SECONDS
    export RUSTC_BOOTSTRAP=1 CARGO_UNSTABLE_BUILD_STD=std,panic_unwind CARGO_TARGET_DIR="$target"
    # In less time, to the same bits.
    export CARGO_PROFILE_RELEASE_LTO=off CARGO_PROFILE_RELEASE_CODEGEN_UNITS=16 CARGO_PROFILE_RELEASE_DEBUG=none
    CARGO=/usr/bin/cargo RUSTC=/usr/bin/rustc quietly "$name: cmake -S ffi" "${cmake[@]}" -S "$root/ffi" -B "$work/$name" \
        -DCMAKE_INSTALL_LIBDIR=lib "-DCOVBEAM_SYSTEM_LIBRARIES=$libraries"
    quietly "$name: build" cmake --build "$work/$name"
    quietly "$name: install" cmake --install "$work/$name" --prefix "$work/$name-prefix"
    quietly "$name: find_package" "${cmake[@]}" -S "$work/clients" -B "$work/$name-clients" -DCMAKE_BUILD_TYPE=Release \
        "-DCLIENTS=$root/tests/clients" "-Dcovbeam_DIR=$work/$name-prefix/lib/cmake/covbeam"
    quietly "$name: the clients" cmake --build "$work/$name-clients"
    echo "cross: $name: built in $((SECONDS - started)) s"
    (
        cd "$work/$name-clients"
        export WINEPREFIX="$work/wine" WINEDEBUG=-all
        local link
        for link in shared static; do
            "$@" "./abi-$link$suffix" "$version" > said 2> warned || { cat said warned; fail "$name: abi, $link"; }
            "$@" "./vectors-$link$suffix" "$root/tests/vectors.txt" > said 2> warned || { cat said warned; fail "$name: vectors, $link"; }
            echo "cross: $name, $link: $(tr -d '\r' < said | paste -sd ';')"
            "$@" "./glass_ball-$link$suffix" "$link.pfm" --passes 1 --size 32 > said 2> warned || { cat said warned; fail "$name: glass_ball, $link"; }
            "$@" "./session-$link$suffix" > said 2> warned || { cat said warned; fail "$name: README's session, $link"; }
            [ "$(hash fog.pfm)" = "$golden" ] || fail "$name: README's session, $link: $(hash fog.pfm), not $golden"
        done
        cmp shared.pfm static.pfm || fail "$name: shared and static differ"
        echo "cross: $name: README's session has the golden bits, $golden"
    )
}

windows() {
    cat > "$work/windows.cmake" <<'CMAKE'
set(CMAKE_SYSTEM_NAME Windows)
set(CMAKE_SYSTEM_PROCESSOR x86_64)
set(CMAKE_C_COMPILER x86_64-w64-mingw32-gcc)
CMAKE
    mkdir -p "$work/windows-clients"
    random_numbers "$work/windows-clients"
    cross windows "Unix Makefiles" "-lkernel32 -lntdll -luserenv -lws2_32 -ldbghelp" .exe wine
    [ "$(cd "$work/windows-prefix" && find bin lib -maxdepth 1 -type f | LC_ALL=C sort | xargs)" = \
        "bin/covbeam.dll lib/libcovbeam.a lib/libcovbeam.dll.a" ] || fail "windows: installed: $(find "$work/windows-prefix")"
    # The DLL exports what the headers declare.
    local exported
    exported="$(exports windows "$work/windows-prefix/bin/covbeam.dll")"
    diff <(declared) <(echo "$exported") || fail "windows: covbeam.dll exports (>) other functions than the headers declare (<)"
    echo "cross: windows: covbeam.dll and libcovbeam.dll.a, $(wc -l <<< "$exported") functions exported, as declared"
}

aarch64() {
    cat > "$work/aarch64.cmake" <<'CMAKE'
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_C_COMPILER aarch64-linux-gnu-gcc)
CMAKE
    cross aarch64 Ninja "-lutil -lrt -lpthread -lm -ldl -lc" "" qemu-aarch64 -L /usr/aarch64-linux-gnu
    local symbols
    symbols="$(aarch64-linux-gnu-nm --defined-only --extern-only "$work/aarch64-prefix/lib/libcovbeam.a" | awk 'NF == 3 { print $NF }' | LC_ALL=C sort)"
    diff <(declared) <(echo "$symbols") || fail "aarch64: libcovbeam.a has (>) other symbols than the headers declare (<)"
    echo "cross: aarch64: libcovbeam.a, $(stat -c %s "$work/aarch64-prefix/lib/libcovbeam.a") bytes, $(wc -l <<< "$symbols") symbols, as declared"
}

for machine in "$@"; do
    case "$machine" in
        windows | aarch64) "$machine" ;;
        *) fail "usage: $0 [windows] [aarch64]" ;;
    esac
done
