#!/bin/bash
# Builds the C library as a host's author would and installs it: tests/clients/install.sh PREFIX (new or empty)
# Then checks names, links, dependencies, what is exported, and what the library keeps.
set -euo pipefail
root="$(cd "$(dirname "$0")/../.." && pwd)"
[ $# -eq 1 ] || { echo "usage: $0 PREFIX" >&2; exit 1; }
mkdir -p "$1"
prefix="$(cd "$1" && pwd)"
[ -z "$(ls -A "$prefix")" ] || { echo "install: $prefix is not empty" >&2; exit 1; }
work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT

fail() { echo "install: $*" >&2; exit 1; }

# same WHAT FOUND EXPECTED
same() {
    if [ "$2" != "$3" ]; then
        diff <(printf '%s\n' "$2") <(printf '%s\n' "$3") >&2 || true
        fail "$1 is not as expected (< found, > expected, above)"
    fi
}

# Without the network, by the tools that the environment names: each says so and does its work.
host="$(rustc -vV | sed -n 's/^host: //p')"
cargo fetch --quiet --locked --target "$host" --manifest-path "$root/Cargo.toml"
for tool in cargo rustc; do
    printf '#!/bin/sh\necho "$@" >> "%s/by-%s"\nexec "%s" "$@"\n' "$work" "$tool" "$(command -v "$tool")" \
        > "$work/$tool"
    chmod +x "$work/$tool"
done
CARGO="$work/cargo" RUSTC="$work/rustc" \
    cmake -S "$root/ffi" -B "$work/build" -DCMAKE_INSTALL_LIBDIR=lib > "$work/log" ||
    { cat "$work/log"; fail "cmake -S ffi"; }
CARGO_NET_OFFLINE=true cmake --build "$work/build"
grep -q -- 'build .*--locked' "$work/by-cargo" || fail "CARGO, or Cargo.lock, was not used"
grep -q -- '--crate-name' "$work/by-rustc" || fail "RUSTC was not used by cargo"
archive="$(stat -c %s "${CARGO_TARGET_DIR:-$work/build/cargo}/release/libcovbeam.a")"
cmake --install "$work/build" --prefix "$prefix" > "$work/log" || { cat "$work/log"; fail "cmake --install"; }

version="$(sed -n 's/^version = "\(.*\)"/\1/p' "$root/Cargo.toml")"
abi="$(sed -n 's/^#define COVBEAM_ABI_VERSION //p' "$root/include/covbeam.h")"
soname="libcovbeam.so.$abi"
full="$(basename "$(realpath "$prefix/lib/$soname")")"
[[ "$full" =~ ^libcovbeam\.so\.$abi\.[0-9]+\.[0-9]+$ ]] || fail "the shared library is $full"
same "the list of installed files" "$(cd "$prefix" && find . ! -type d | LC_ALL=C sort)" "./include/covbeam.h
./include/covbeam.hpp
./include/covbeam_extra.h
./include/covbeam_session.h
./include/covbeam_session.hpp
./lib/cmake/covbeam/covbeam-config-version.cmake
./lib/cmake/covbeam/covbeam-config.cmake
./lib/libcovbeam.a
./lib/libcovbeam.so
./lib/$soname
./lib/$full
./lib/pkgconfig/covbeam.pc"
shared="$prefix/lib/$full"
for link in libcovbeam.so "$soname"; do
    same "the link $link" "$(readlink "$prefix/lib/$link")" "$full"
done
readelf -d "$shared" > "$work/dynamic"
same "the SONAME" "$(sed -n 's/.*SONAME.*\[\(.*\)\]/\1/p' "$work/dynamic")" "$soname"
# The C library, its loader, and gcc's unwinder for panics. Mathematics is covbeam's own.
same "the list of libraries needed" \
    "$(sed -n 's/.*NEEDED.*\[\(.*\)\.so\.[0-9]*\]/\1/p' "$work/dynamic" | grep -v '^ld-linux' | LC_ALL=C sort)" "libc
libgcc_s"
if ldd "$shared" | grep 'not found'; then fail "a library is missing (above)"; fi

# What is exported is what the headers declare but for their inline functions, and nothing else.
nm -D --defined-only "$shared" | awk '{ print $NF }' | LC_ALL=C sort > "$work/exported"
printf '#include <covbeam_extra.h>\n#include <covbeam_session.h>\n' | cc -E -P -I"$prefix/include" - | grep -vE '^(static inline| +return) ' | tr '\n' ' ' |
    grep -oE '\bcovbeam_[a-z0-9_]+ *\(' | tr -d ' (' | LC_ALL=C sort -u > "$work/declared"
same "the list of exported symbols" "$(cat "$work/exported")" "$(cat "$work/declared")"

# The static library is one object with the same symbols. It has what panics are caught by, and asks for nothing of Rust's.
one_object() {
    same "the number of members of $1" "$(ar t "$1" | wc -l)" 1
    nm --defined-only --extern-only "$1" | awk 'NF == 3 { print $NF }' | LC_ALL=C sort > "$work/symbols"
    same "the list of symbols of $1" "$(cat "$work/symbols")" "$(cat "$2")"
    readelf -SW "$1" | grep -oE ' \.(eh_frame|gcc_except_table|debug|llvmbc|group)' | LC_ALL=C sort -u | xargs > "$work/sections"
    same "what there is of tables for panics, debug information, bitcode and groups in $1" "$(cat "$work/sections")" ".eh_frame .gcc_except_table"
    if nm --undefined-only "$1" | grep -E ' (_R|_ZN|__rust|rust_)'; then fail "$1 lacks functions of Rust's (above)"; fi
}
one_object "$prefix/lib/libcovbeam.a" "$work/declared"

# The kernels alone, as hosts build them that need no sessions.
cmake -S "$root/ffi" -B "$work/kernels" -DCOVBEAM_SESSION=OFF > "$work/log" || { cat "$work/log"; fail "COVBEAM_SESSION=OFF"; }
CARGO_NET_OFFLINE=true cmake --build "$work/kernels"
kernels="${CARGO_TARGET_DIR:-$work/kernels/cargo}/release/libcovbeam.so"
nm -D --defined-only "$kernels" | awk '{ print $NF }' | LC_ALL=C sort > "$work/exported-kernels"
printf '#include <covbeam_extra.h>\n' | cc -E -P -I"$prefix/include" - | grep -vE '^(static inline| +return) ' | tr '\n' ' ' |
    grep -oE '\bcovbeam_[a-z0-9_]+ *\(' | tr -d ' (' | LC_ALL=C sort -u > "$work/declared-kernels"
same "the list of exported symbols of the kernels alone" "$(cat "$work/exported-kernels")" "$(cat "$work/declared-kernels")"
one_object "$work/kernels/libcovbeam.a" "$work/declared-kernels"

# Writable memory of those that is not a thread's own. Rust's standard library has some, and the C runtime; covbeam has the hook of panics
# that was there before it made its own quiet. What the processor can do is kept by those who asked it, always the same. Tables of constants that hold addresses are in .data.rel.ro, read-only once loaded.
objdump -t "$kernels" | awk '/ (\.data|\.bss)\t/ && !/ df / { print $NF }' | LC_ALL=C sort > "$work/globals"
standard='^(__dso_handle|__TMC_END__|completed\.0|DW\.ref\.rust_eh_personality|_rust_extern_with_linkage_.*)$|_(3std|6memchr)([0-9]|$)'
grep -vE "$standard|^\.(data|bss)$" "$work/globals" > "$work/own" || true
processor='10std_detect6detect5cache5CACHE|13fearless_simd9X86_LEVEL'
[ "$(grep -cvE "$processor" "$work/own")" -eq 1 ] && grep -q '7covbeam6status17keep_panics_quiet6BEFORE' "$work/own" ||
    { cat "$work/own"; fail "covbeam has writable memory besides one hook (above)"; }

# No thread can be started by the kernels alone, by what cannot call for one; no text can reach the host's streams but Rust's own for a panic
# outside of a call.
nm -D --undefined-only "$kernels" | awk '{ sub("@.*", "", $NF); print $NF }' > "$work/undefined"
if grep -E '^(pthread_create|thrd_create|clone3?|fork|vfork|system|posix_spawn.*|exit|_exit|.*printf|f?puts|fwrite|signal|sigaction)$' \
    "$work/undefined"; then
    fail "the kernels call what they should not (above)"
fi

# pkg-config, here and after the tree has moved.
check_pc() {
    local pc="$1/lib/pkgconfig"
    same "the version of covbeam.pc" "$(PKG_CONFIG_PATH="$pc" pkg-config --modversion covbeam)" "$version"
    local flags folder
    flags="$(PKG_CONFIG_PATH="$pc" pkg-config --cflags --libs covbeam)"
    same "the kinds of flags of covbeam.pc" "$(tr ' ' '\n' <<< "$flags" | grep . | cut -c 1-2 | xargs)" "-I -L -l"
    for folder in $(grep -oE -- '-[IL][^ ]+' <<< "$flags" | cut -c 3-); do
        case "$(realpath "$folder")" in
            "$1/include" | "$1/lib") ;;
            *) fail "covbeam.pc: $folder is not in $1" ;;
        esac
    done
    # With what threads and mathematics need. The unwinder is the compiler's: -lgcc_s would forbid -static (cmake.sh links so).
    flags="$(PKG_CONFIG_PATH="$pc" pkg-config --static --libs-only-l covbeam)"
    same "the libraries of covbeam.pc when static" "$(tr ' ' '\n' <<< "$flags" | grep -xE -- '-l(covbeam|pthread|m|gcc_s)' | xargs)" \
        "-lcovbeam -lpthread -lm"
}
moved="$(realpath "$work")/moved"
check_pc "$(realpath "$prefix")"
cp -a "$prefix" "$moved"
check_pc "$moved"

# find_package: what fits is found, in the tree that has moved too; what does not fit is refused.
mkdir "$work/find"
cat > "$work/find/CMakeLists.txt" <<'CMAKE'
cmake_minimum_required(VERSION 3.20)
project(find LANGUAGES C)
find_package(covbeam ${WANTED} REQUIRED)
foreach(target covbeam::covbeam covbeam::covbeam_static)
    get_target_property(location ${target} IMPORTED_LOCATION)
    if(NOT location MATCHES "^${TREE}/lib/")
        message(FATAL_ERROR "${location} is not in ${TREE}")
    endif()
endforeach()
CMAKE
find_covbeam() {
    rm -rf "$work/find/build"
    cmake -S "$work/find" -B "$work/find/build" -DWANTED="$1" -DTREE="$2" -DCMAKE_PREFIX_PATH="$2" > "$work/log" 2>&1
}
for wanted in 0.1 0.1.0; do
    find_covbeam "$wanted" "$prefix" || { cat "$work/log"; fail "find_package(covbeam $wanted)"; }
done
find_covbeam 0.1 "$moved" || { cat "$work/log"; fail "find_package(covbeam 0.1) in a tree that has moved"; }
for wanted in 0.0 0.1.99 0.2 1.0; do
    if find_covbeam "$wanted" "$prefix"; then fail "find_package(covbeam $wanted) takes version $version"; fi
    grep -q 'requested version' "$work/log" || { cat "$work/log"; fail "find_package(covbeam $wanted)"; }
done

echo "install: $full ($(stat -c %s "$shared") bytes), libcovbeam.a ($(stat -c %s "$prefix/lib/libcovbeam.a") bytes of the $archive that Rust makes)," \
    "$(wc -l < "$work/exported") symbols, all declared in covbeam.h, covbeam_extra.h and covbeam_session.h"
echo "install: the kernels alone: $(strip -o "$work/stripped" "$kernels"; stat -c %s "$work/stripped") bytes of $(strip -o "$work/stripped" "$shared"; stat -c %s "$work/stripped"), both stripped; writable globals: 1 of covbeam (that panics are quiet), $(grep -cE "$processor" "$work/own") on what the processor can do," \
    "$(grep -cE "$standard" "$work/globals") of Rust's standard library and the C runtime; no thread can be started"
