#!/bin/bash
# The C clients against an installed tree: tests/clients/vectors.sh PREFIX
# Every function of the ABI gives the bits of the Rust library (vectors.c), layouts and values are those of the header (abi.c),
# threads and batches change nothing (determinism.c), and light guided by importance is the same light (importance.c).
set -euo pipefail
root="$(cd "$(dirname "$0")/../.." && pwd)"
[ $# -eq 1 ] || { echo "usage: $0 PREFIX" >&2; exit 1; }
prefix="$(cd "$1" && pwd)"
work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT
export PKG_CONFIG_PATH="$prefix/lib/pkgconfig"
clients="$root/tests/clients"
version="$(sed -n 's/^version = "\(.*\)"/\1/p' "$root/Cargo.toml")"

fail() { echo "vectors: $*" >&2; exit 1; }

# build COMPILER STANDARD LINK CLIENT OUT [OPTIMISATION]
build() {
    local libraries
    case $3 in
        shared) libraries="$(pkg-config --libs covbeam) -Wl,-rpath,$prefix/lib" ;;
        static) libraries="$prefix/lib/libcovbeam.a $(pkg-config --static --libs-only-l covbeam | sed 's/-lcovbeam//')" ;;
    esac
    # shellcheck disable=SC2046,SC2086
    "$1" "-std=$2" "${6:--O2}" -pthread -Wall -Wextra -Wpedantic -Werror $(pkg-config --cflags covbeam) \
        "$clients/$4.c" -o "$5" $libraries -lm
    case $3 in
        shared) ldd "$5" | grep > /dev/null -e "$prefix/lib/libcovbeam" || fail "$4 does not use the library of $prefix" ;;
        static) ! ldd "$5" | grep libcovbeam || fail "$4 needs the shared library" ;;
    esac
}

for compiler in gcc clang; do
    for link in shared static; do
        build "$compiler" c99 "$link" vectors "$work/vectors"
        "$work/vectors" "$root/tests/vectors.txt" > "$work/log" || fail "vectors, $compiler, $link"
        echo "vectors: $compiler, $link: $(paste -sd ';' "$work/log")"
        for standard in c99 c11; do
            build "$compiler" "$standard" "$link" abi "$work/abi"
            "$work/abi" "$version" > "$work/log" || fail "abi, $compiler, $link, $standard"
            echo "vectors: $compiler, $link, $standard: $(cat "$work/log")"
        done
    done
done

# Callers that keep everything in memory, as a debugger's user has them.
for compiler in gcc clang; do
    build "$compiler" c99 static vectors "$work/vectors-slow" -O0
    "$work/vectors-slow" "$root/tests/vectors.txt" > "$work/log" || fail "vectors, $compiler, static, -O0"
    echo "vectors: $compiler, static, -O0: $(paste -sd ';' "$work/log")"
done

# A client that takes anything would pass, too: one bit, one input, a name, a line without its end.
last="$(grep -n '^light_field_travel ' "$root/tests/vectors.txt" | tail -n 1 | cut -d : -f 1)"
wrong() {
    sed "$1" "$root/tests/vectors.txt" > "$work/wrong.txt"
    ! cmp -s "$work/wrong.txt" "$root/tests/vectors.txt" || fail "'$1' changes nothing"
    if "$work/vectors" "$work/wrong.txt" > "$work/log" 2>&1; then fail "vectors takes a file after '$1'"; fi
    grep -q "^line $2:" "$work/log" || { cat "$work/log"; fail "vectors does not name line $2"; }
}
wrong "$last s/0\$/1/; $last t; $last s/.\$/0/" "$last"
wrong "$last s/ [0-9a-f]* ->/ 3f9d70a4 ->/" "$last"
wrong "$last s/travel/traverse/" "$last"
wrong "$last s/ [0-9a-f]* ->/ ->/" "$last"
echo "vectors: four wrong files refused"

for compiler in gcc clang; do
    build "$compiler" c99 shared determinism "$work/determinism-$compiler"
    "$work/determinism-$compiler" > "$work/$compiler.txt" || fail "determinism"
done
cmp "$work/gcc.txt" "$work/clang.txt" || fail "gcc and clang get other bits"
sed 's/^/vectors: /' "$work/gcc.txt"

build gcc c99 shared importance "$work/importance"
"$work/importance" || fail "importance"
