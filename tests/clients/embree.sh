#!/bin/bash
# examples/embree against an installed library: tests/clients/embree.sh PREFIX [PROGRAM]     PROGRAM: host of covbeam-tests; else it is built
# Strict builds, the same bits for any threads, both modes alike and as the renderer has the scenes, Ctrl-C, wrong options.
set -euo pipefail
root="$(cd "$(dirname "$0")/../.." && pwd)"
[ $# -ge 1 ] || { echo "usage: $0 PREFIX [PROGRAM]" >&2; exit 1; }
prefix="$(cd "$1" && pwd)"
program=(cargo run --quiet --locked --release --package covbeam-tests --bin host --)
[ $# -eq 1 ] || program=("$2")
work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT
strict="-Wall -Wextra -Wpedantic -Wshadow -Wconversion -Werror"

fail() { echo "embree: $*" >&2; exit 1; }

# render NAME ARGUMENT...: $work/NAME.pfm
render() {
    "$work/build-g++/covbeam-embree" "${@:2}" --out "$work/$1.pfm" 2> "$work/log" || { cat "$work/log" >&2; fail "covbeam-embree ${*:2}"; }
}

# Copied out of the repository, with both compilers. What is not the loaders of files is short.
cp -r "$root/examples/embree" "$work/host"
for compiler in g++ clang++; do
    cmake -S "$work/host" -B "$work/build-$compiler" -DCMAKE_CXX_COMPILER="$compiler" -DCMAKE_CXX_FLAGS="$strict" \
        -DCMAKE_PREFIX_PATH="$prefix" -DEXAMPLES="$root/examples" > "$work/log" 2>&1 && cmake --build "$work/build-$compiler" >> "$work/log" 2>&1 ||
        { cat "$work/log"; fail "with $compiler"; }
done
lines="$(cat "$work"/host/{host,scene}.hpp "$work"/host/{main,scenes}.cpp | grep -c .)"
[ "$lines" -le 300 ] || fail "$lines lines of code"
echo "embree: no warning from g++ and clang++; $lines lines of code"

for mode in "" "--own"; do
    for threads in 1 2 8; do
        # shellcheck disable=SC2086
        render "$threads" leaves $mode --passes 2 --width 32 --threads "$threads"
        cmp "$work/1.pfm" "$work/$threads.pfm" || fail "$threads threads give another picture"
    done
    grep -q 'pass [01] of 2, [0-9]* s left' "$work/log" || fail "no progress"
    echo "embree: leaves $mode: the same bits with 1, 2 and 8 threads ($(cksum < "$work/1.pfm" | cut -d ' ' -f 1))"
done

# Against the renderer, which has spheres and rectangles of its own; and functions of the host against what is described of lamp, camera and
# materials. Means of regions over many pixels: light paths make their noise, not pixels.
compare() { (cd "$root" && "${program[@]}" "$@" < /dev/null); }
render_seeds() {
    for seed in $(seq 5); do
        render "$1-$seed" "${@:2}" --seed "$seed" --passes 4 --width 32 --threads 1
    done
}
render_seeds glass-ball glass-ball
render_seeds own glass-ball --own
render_seeds shaft shaft
render_seeds rose-window rose-window --own
compare embree "$root/examples/scenes/glass-ball.toml" 4 0 "$work"/glass-ball-*.pfm
compare embree "$root/examples/scenes/glass-ball.toml" 4 0 "$work"/own-*.pfm
compare embree "$root/tests/scenes/embree-shaft.toml" 4 0 "$work"/shaft-*.pfm
compare embree "$root/tests/scenes/embree-rose-window.toml" 4 0 "$work"/rose-window-*.pfm
# Two pictures of other scenes are told apart.
if compare embree "$root/tests/scenes/embree-shaft.toml" 4 0 "$work"/glass-ball-*.pfm > "$work/log" 2>&1; then fail "another scene is not told apart"; fi

# Both modes of the scene with textures, which the renderer does not have.
render_seeds leaves leaves
render_seeds leaves-own leaves --own
python3 - "$work" <<'PYTHON'
import array, glob, math, statistics, sys

def blocks(name):
    values = array.array("f", open(name, "rb").read().split(b"\n", 3)[3])
    assert len(values) == 3 * 32 * 24 and all(map(math.isfinite, values)), f"{name} is not a picture"
    rows = [values[i : i + 96] for i in range(0, len(values), 96)]
    return [statistics.fmean(v for row in rows[y : y + 8] for v in row[x : x + 24]) for y in (0, 8, 16) for x in range(0, 96, 24)]

described, own = ([blocks(name) for name in sorted(glob.glob(f"{sys.argv[1]}/{kind}-[0-9].pfm"))] for kind in ("leaves", "leaves-own"))
worst = 0
for a, b in zip(zip(*described), zip(*own)):
    error = math.sqrt((statistics.variance(a) + statistics.variance(b)) / len(a))
    worst = max(worst, abs(statistics.fmean(a) - statistics.fmean(b)) / error)
# Twelve blocks, eight degrees of freedom: beyond it once in a thousand.
assert worst < 7, f"a block differs by {worst:.1f} standard errors"
print(f"embree: leaves: both modes alike, the worst of 12 blocks within {worst:.1f} standard errors")
PYTHON

# Ctrl-C keeps the passes that are done.
: > "$work/log"
"$work/build-g++/covbeam-embree" shaft --passes 100000 --width 32 --threads 2 --out "$work/stopped.pfm" 2> "$work/log" &
host=$!
for _ in $(seq 600); do
    tr '\r' '\n' < "$work/log" | grep -q 'pass 2 of' && break
    sleep 0.1
done
kill -INT "$host"
status=0
wait "$host" || status=$?
[ "$status" -eq 130 ] || fail "stopped by Ctrl-C the host exits with $status, not 130"
done="$(sed -n 's/^stopped after \([0-9]*\) passes$/\1/p' "$work/log")"
[ "${done:-0}" -ge 2 ] || fail "the host does not say after how many passes it stopped"
render whole shaft --passes "$done" --width 32
cmp "$work/stopped.pfm" "$work/whole.pfm" || fail "the picture of a stopped run is not that of its passes"
echo "embree: Ctrl-C after $done passes: exit code 130, the picture of these passes"

"$work/build-g++/covbeam-embree" --help | grep -q -- '--own' || fail "no help"
for arguments in "--threads x" "--passes" "--unknown 1" "nowhere"; do
    status=0
    # shellcheck disable=SC2086
    "$work/build-g++/covbeam-embree" $arguments 2> "$work/log" || status=$?
    [ "$status" -eq 2 ] && grep -q '^usage' "$work/log" || fail "covbeam-embree $arguments: $status"
done
status=0
"$work/build-g++/covbeam-embree" --passes 1 --width 8 --out "$work/nowhere/picture.pfm" 2> "$work/log" || status=$?
[ "$status" -eq 1 ] || fail "a picture that cannot be written: $status"
