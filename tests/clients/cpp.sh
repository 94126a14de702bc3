#!/bin/bash
# Clients in C++ against an installed library: tests/clients/cpp.sh PREFIX
# covbeam.hpp alone and complete, tests/vectors.txt through it, its own tests, and examples/cpp: the same bits for any threads, Ctrl-C.
set -euo pipefail
root="$(cd "$(dirname "$0")/../.." && pwd)"
[ $# -eq 1 ] || { echo "usage: $0 PREFIX" >&2; exit 1; }
prefix="$(cd "$1" && pwd)"
work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT
export PKG_CONFIG_PATH="$prefix/lib/pkgconfig"
strict="-Wall -Wextra -Wpedantic -Wshadow -Wconversion -Werror"
clients="$root/tests/clients"

fail() { echo "cpp: $*" >&2; exit 1; }

# The header alone, with every template of it used by the test programs; hosts such as LLVM's have no run-time types.
echo '#include <covbeam_session.hpp>' > "$work/alone.cpp"
for compiler in g++ clang++; do
    for standard in "c++11 -fno-rtti" c++14 c++17 c++20; do
        # shellcheck disable=SC2086
        "$compiler" -std=$standard $strict -I"$prefix/include" -fsyntax-only "$work/alone.cpp" \
            "$clients/vectors.cpp" "$clients/wrapper.cpp" "$clients/session.cpp"
    done
done
echo "cpp: covbeam.hpp: no warning from g++ and clang++ as C++11 (without run-time types), 14, 17, 20"

# Every function of the C header is within reach of C++, and every struct has its layout asserted.
printf '#include <covbeam_extra.h>\n' | cc -E -P -I"$prefix/include" - > "$work/preprocessed"
tr '\n' ' ' < "$work/preprocessed" | grep -oE '\bcovbeam_[a-z0-9_]+ *\(' | tr -d ' (' | sort -u > "$work/functions"
[ "$(wc -l < "$work/functions")" -gt 100 ] || fail "the functions of covbeam.h were not found"
while read -r function; do
    case "$function" in covbeam_version) continue ;; esac # a string as it is
    grep -qw "$function" "$prefix/include/covbeam.hpp" || fail "covbeam.hpp does not call $function"
done < "$work/functions"
grep -oE '^typedef struct covbeam_[a-z_]+ \{' "$work/preprocessed" | sed -E 's/.*covbeam_([a-z_]+) .*/\1/' > "$work/structs"
[ "$(wc -l < "$work/structs")" -ge 18 ] || fail "the structs of covbeam.h were not found"
while read -r struct; do
    grep -q "^SIZE($struct, " "$clients/layout.h" || fail "layout.h does not assert the layout of covbeam_$struct"
done < "$work/structs"
echo "cpp: covbeam.hpp calls all $(wc -l < "$work/functions") functions; layout.h asserts $(wc -l < "$work/structs") structs"

# The header does not ask for the standard: an old one of one compiler and a new one of the other.
for build in g++:c++11 clang++:c++20; do
    for client in vectors wrapper session; do
        # shellcheck disable=SC2046,SC2086
        "${build%:*}" "-std=${build#*:}" -O1 $strict "$clients/$client.cpp" -o "$work/$client" \
            $(pkg-config --cflags --libs covbeam) "-Wl,-rpath,$prefix/lib" -pthread
    done
    for run in "vectors $root/tests/vectors.txt" "wrapper" "session"; do
        # shellcheck disable=SC2086
        "$work/"$run > "$work/log" || { cat "$work/log"; fail "$build: $run"; }
        echo "cpp: $build: $(cat "$work/log")"
    done
done
# The comparison sees one wrong bit.
sed 's/^\(progressive_radius .*\)[0-7]$/\18/' "$root/tests/vectors.txt" > "$work/wrong.txt"
if "$work/vectors" "$work/wrong.txt" > "$work/log"; then fail "vectors takes a wrong file"; fi
grep -q '^line [0-9]*: progressive_radius' "$work/log" || fail "vectors does not say which line is wrong"

# The host, copied out of the repository, with both compilers.
cp -r "$root/examples/cpp" "$work/host"
for compiler in g++ clang++; do
    cmake -S "$work/host" -B "$work/build-$compiler" -DCMAKE_CXX_COMPILER="$compiler" -DCMAKE_CXX_FLAGS="$strict" \
        -DCMAKE_PREFIX_PATH="$prefix" > "$work/log" 2>&1 && cmake --build "$work/build-$compiler" >> "$work/log" 2>&1 ||
        { cat "$work/log"; fail "examples/cpp with $compiler"; }
done
shaft="$work/build-g++/covbeam-shaft"
small="--passes 2 --photons 1000"
for threads in 1 2 8; do
    # shellcheck disable=SC2086
    "$shaft" $small --threads "$threads" --out "$work/$threads.pfm" 2> "$work/log"
    cmp "$work/1.pfm" "$work/$threads.pfm" || fail "$threads threads give another picture"
done
grep -q 'pass 2 of 2, 0 s left' "$work/log" || fail "no progress"
echo "cpp: examples/cpp: the same bits with 1, 2 and 8 threads ($(cksum < "$work/1.pfm" | cut -d ' ' -f 1))"

# The host's own fog is the built-in one but for roundings: a few of 6e-8 in each column and exponential, and those of float sums of
# up to 500 pairs in the same order. A contact before a beam's start whose column is not mirrored shows as 3e-5.
# shellcheck disable=SC2086
"$shaft" $small --own-medium --out "$work/own.pfm" 2> "$work/log"
python3 - "$work/1.pfm" "$work/own.pfm" <<'PYTHON'
import array, math, sys
a, b = (array.array("f", open(name, "rb").read().split(b"\n", 3)[3]) for name in sys.argv[1:])
assert len(a) == len(b) == 3 * 256 * 256 and all(map(math.isfinite, a)), "not a picture"
mean = sum(a) / len(a)
assert 0.02 < mean < 0.5, f"the mean of the picture is {mean}"
worst = max(abs(x - y) / max(x, 1e-3 * mean) for x, y in zip(a, b))
assert 0 < worst < 5e-6, f"the own medium differs by {worst}"
print(f"cpp: examples/cpp: --own-medium within {worst:.1e} of the built-in one in every pixel")
PYTHON

# Ctrl-C keeps the passes that are done. The log of the last run, which had a second pass too, is not to be read for that of this one.
: > "$work/log"
"$shaft" --passes 100000 --photons 1000 --threads 2 --out "$work/stopped.pfm" 2> "$work/log" &
host=$!
for _ in $(seq 600); do
    grep -q 'pass 2 of' "$work/log" && break
    sleep 0.1
done
before="$(date +%s%N)"
kill -INT "$host"
status=0
wait "$host" || status=$?
milliseconds=$((($(date +%s%N) - before) / 1000000))
[ "$status" -eq 130 ] || fail "stopped by Ctrl-C the host exits with $status, not 130"
done="$(sed -n 's/^stopped after \([0-9]*\) passes$/\1/p' "$work/log")"
[ "${done:-0}" -ge 2 ] || fail "the host does not say after how many passes it stopped"
"$shaft" --passes "$done" --photons 1000 --out "$work/whole.pfm" 2> "$work/log"
cmp "$work/stopped.pfm" "$work/whole.pfm" || fail "the picture of a stopped run is not that of its passes"
[ "$milliseconds" -lt 1000 ] || fail "Ctrl-C took $milliseconds ms"
echo "cpp: examples/cpp: Ctrl-C after $done passes: exit code 130 in $milliseconds ms, the picture of these passes"

# Wrong options, and a picture that cannot be written.
for arguments in "--threads 0" "--passes x" "--photons" "--unknown 1"; do
    status=0
    # shellcheck disable=SC2086
    "$shaft" $arguments 2> "$work/log" || status=$?
    [ "$status" -eq 2 ] && grep -q '^usage' "$work/log" || fail "covbeam-shaft $arguments: $status"
done
status=0
"$shaft" --passes 1 --photons 100 --out "$work/no-folder/x.pfm" 2> "$work/log" || status=$?
[ "$status" -eq 1 ] && grep -q 'cannot be written' "$work/log" || fail "a picture nowhere: $status"
