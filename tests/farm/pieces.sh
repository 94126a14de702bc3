#!/bin/bash
# One render of 64 passes, the same in 2, 7 and 64 pieces merged in random order and in a tree, and the same killed with -9 twenty times
# at random moments and gone on with: the same bytes of EXR and PNG, for three methods on three scenes.
# pieces.sh BINARY [SEED]
set -euo pipefail
root="$(cd "$(dirname "$0")/../.." && pwd)"
covbeam="$(realpath "$1")"
RANDOM="${2:-1}"
passes=64
folder="$(mktemp -d)"
trap 'rm -rf "$folder"' EXIT
cd "$folder"
ln -s "$root/examples/scenes/meshes" "$root/examples/scenes/volumes" .

quietly() { "$@" > log 2>&1 || { cat log; exit 1; }; }

same() { cmp "one.exr" "$1.exr" && cmp "one.png" "$1.png"; }

for scene in glass-ball shaft rose-window; do
    sed -e 's/^width = .*/width = 64/; s/^height = .*/height = 60/' "$root/examples/scenes/$scene.toml" > "$scene.toml"
    for method in ppb adaptive march; do
        flags=(--method "$method" --photons 500)
        quietly "$covbeam" render "$scene.toml" "${flags[@]}" --passes "$passes" --out one.exr
        for count in 2 7 64; do
            for ((piece = 0; piece < count; piece++)); do
                range="$((piece * passes / count))..$(((piece + 1) * passes / count))"
                quietly "$covbeam" render "$scene.toml" "${flags[@]}" --passes "$range" --out "$piece.shard"
            done
            mapfile -t shards < <(ls | grep -E '^[0-9]+\.shard$' | shuf --random-source=<(yes "$RANDOM"))
            quietly "$covbeam" merge "${shards[@]}" --out flat.exr --passes "$passes"
            same flat
            # In a tree: two at a time, until one is left.
            level=0
            while [ "${#shards[@]}" -gt 1 ]; do
                next=()
                for ((i = 0; i < ${#shards[@]}; i += 2)); do
                    quietly "$covbeam" merge "${shards[@]:i:2}" --out "tree-$level-$i.shard"
                    next+=("tree-$level-$i.shard")
                done
                shards=("${next[@]}")
                level=$((level + 1))
            done
            quietly "$covbeam" merge "${shards[0]}" --out tree.exr --passes "$passes"
            same tree
            rm -f ./*.shard
        done

        # Moments all over the render: its length is measured first.
        start="$(date +%s%N)"
        quietly "$covbeam" render "$scene.toml" "${flags[@]}" --passes "$passes" --checkpoint 0 --out whole.exr
        length=$((($(date +%s%N) - start) / 1000000))
        same whole
        kills=0
        attempts=0
        while [ "$kills" -lt 20 ]; do
            attempts=$((attempts + 1))
            [ "$attempts" -lt 400 ] || { echo "$scene, $method: only $kills kills in 400 renders" >&2; exit 1; }
            "$covbeam" render "$scene.toml" "${flags[@]}" --passes "$passes" --checkpoint 0 --resume --out killed.exr \
                > /dev/null 2>&1 &
            render=$!
            # A twentieth of the length on average: the render gets on between two kills.
            sleep "$(printf '0.%03d' $((30 + RANDOM % (length / 8 + 30))))"
            if kill -9 "$render" 2> /dev/null; then
                kills=$((kills + 1))
            else
                # It came to its end: once more from the start.
                rm -f killed.exr killed.png killed.shard
            fi
            wait "$render" 2> /dev/null || true
        done
        quietly "$covbeam" render "$scene.toml" "${flags[@]}" --passes "$passes" --resume --out killed.exr
        grep -q 'wrote killed.exr' log
        same killed
        rm -f ./*.shard
        echo "$scene, $method: 2, 7 and 64 pieces, in random order and in a tree, and 20 kills of a render of $length ms: the same bytes"
    done
done

# A merge that is killed at any moment leaves no picture or the whole one.
for ((piece = 0; piece < 16; piece++)); do
    quietly "$covbeam" render glass-ball.toml --photons 500 --passes "$((4 * piece))..$((4 * piece + 4))" --out "$piece.shard"
done
quietly "$covbeam" merge ./*.shard --out one.exr
kills=0
for ((attempt = 0; attempt < 100; attempt++)); do
    rm -f killed.*
    "$covbeam" merge ./*.shard --out killed.exr > /dev/null 2>&1 &
    merge=$!
    sleep "$(printf '0.%03d' $((RANDOM % 60)))"
    if kill -9 "$merge" 2> /dev/null; then kills=$((kills + 1)); fi
    wait "$merge" 2> /dev/null || true
    for file in exr png; do
        [ ! -e "killed.$file" ] || cmp "one.$file" "killed.$file"
    done
done
[ "$kills" -ge 20 ] || { echo "only $kills of 100 merges were killed" >&2; exit 1; }
echo "$kills merges killed: no picture, or the whole one"
