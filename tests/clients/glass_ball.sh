#!/bin/bash
# Whether examples/c/glass_ball.c and the Rust renderer make the same picture at equal work:
#   tests/clients/glass_ball.sh PREFIX [PROGRAM]     PROGRAM: glass_ball of covbeam-tests; if it is not given, it is built
# And whether the comparison would notice fog of the same extinction that scatters 2 % more.
set -euo pipefail
root="$(cd "$(dirname "$0")/../.." && pwd)"
[ $# -ge 1 ] || { echo "usage: $0 PREFIX [PROGRAM]" >&2; exit 1; }
prefix="$(cd "$1" && pwd)"
program=(cargo run --quiet --locked --release --package covbeam-tests --bin glass_ball --)
[ $# -eq 1 ] || program=("$2")
work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT
# Regions are means over many pixels: light paths make their noise, not pixels. So few pixels and many paths.
runs=8 passes=8 photons=20000 size=32

# shellcheck disable=SC2046
cc -std=c99 -O2 "$root/examples/c/glass_ball.c" -o "$work/glass_ball" \
    $(PKG_CONFIG_PATH="$prefix/lib/pkgconfig" pkg-config --cflags --libs covbeam) -lm "-Wl,-rpath,$prefix/lib"
for seed in $(seq "$runs"); do
    "$work/glass_ball" "$work/$seed.pfm" --passes "$passes" --photons "$photons" --seed "$seed" --size "$size" > "$work/log"
done
echo "glass ball: the host's last picture: $(cat "$work/log")"

compare() {
    (cd "$root" && "${program[@]}" "$1" "$passes" "$photons" "$work"/?.pfm < /dev/null)
}
scene="$root/examples/scenes/open-glass-ball.toml"
compare "$scene"

sed -e 's/^scattering = 0.15$/scattering = 0.153/' -e 's/^absorption = 0.15$/absorption = 0.147/' "$scene" > "$work/brighter.toml"
[ "$(diff "$scene" "$work/brighter.toml" | grep -c '^>')" -eq 2 ] || { echo "glass ball: no fog to change" >&2; exit 1; }
if compare "$work/brighter.toml" 2> "$work/log"; then
    echo "glass ball: fog that scatters 2 % more is not told apart" >&2
    exit 1
fi
grep 'the means differ' "$work/log" || { cat "$work/log" >&2; exit 1; }
echo "glass ball: the same within noise, and told apart from fog that scatters 2 % more"
