# What the tests of examples/farm share; sourced by them, with the binary as $1. Linux only: it looks into /proc.
# shellcheck shell=bash
set -euo pipefail

test $# -eq 1 || { echo "usage: $0 BINARY" >&2; exit 2; }
tests=$(realpath "$(dirname "${BASH_SOURCE[0]}")")
farm=$(realpath "$tests/../../examples/farm")
work=$(realpath "$(mktemp -d)")
export PYTHONDONTWRITEBYTECODE=1 PIP_DISABLE_PIP_VERSION_CHECK=1
unset PYTHONPATH

# A copy of the binary in the test's own folder: what runs it was started by this test, and nothing else was.
mkdir "$work/bin"
cp "$1" "$work/bin/covbeam"
covbeam=$work/bin/covbeam

# ours TEXT...: the processes of this test's binary whose command lines hold all of these.
ours() {
    local process line text
    for process in /proc/[0-9]*; do
        [[ $process/exe -ef $covbeam ]] || continue
        line=$(tr '\0' ' ' 2> /dev/null < "$process/cmdline") || continue
        for text in "$@"; do
            [[ $line == *"$text"* ]] || continue 2
        done
        echo "${process#/proc/}"
    done
}

fail() {
    echo "$(basename "$0"): $*" >&2
    exit 1
}

# within SECONDS COMMAND...: waits until the command succeeds.
within() {
    local until=$((SECONDS + $1))
    shift
    until "$@"; do
        test "$SECONDS" -lt "$until" || return 1
        sleep 0.02
    done
}

# none_left TEXT...: whether `ours` finds nothing.
none_left() {
    test -z "$(ours "$@")"
}

clean_up() {
    local status=$? process
    if test "$status" -ne 0; then
        for log in "$work"/*.log; do
            test ! -e "$log" || { echo "--- $(basename "$log")"; tail -n 60 "$log"; } >&2
        done
    fi
    # What starts them first, if a test failed while it ran.
    for process in $(jobs -p) $(ours); do
        kill -9 "$process" 2> /dev/null || true
    done
    within 10 none_left ""
    rm -rf "$work"
}
trap clean_up EXIT

# writer SHARD: the process that renders into it. (A merge may read it at the same time.)
writer() {
    ours ' render ' "$(basename "$1")"
}

# A piece has begun when its shard is there: with --checkpoint 0 that is after its first pass.
begun() {
    test -e "$1" && test -n "$(writer "$1")"
}

gone() {
    [[ ! /proc/$1/exe -ef $covbeam ]]
}

# kill_piece SHARD: kills the process that writes this shard, with -9, when it has written some passes. That it was in the
# middle is for `gone_on` to see.
kill_piece() {
    local process
    within 120 begun "$1" || fail "$(basename "$1") was not begun"
    process=$(writer "$1")
    kill -9 "$process"
    within 10 gone "$process" || fail "process $process does not die"
    echo "killed the process of $(basename "$1")"
}

# gone_on LOG A B: the piece A..B was continued by what wrote this log, and neither begun anew nor only looked at.
gone_on() {
    local there
    there=$(sed -nE "s/.*passes $2\.\.$3, .*, ([0-9]+) pass.* there already.*/\1/p" "$1" | tail -n 1)
    test -n "$there" || fail "the log does not say that piece $2..$3 was gone on with"
    test "$there" -ge 1 && test "$there" -lt $(($3 - $2)) || fail "$there passes of piece $2..$3 were there"
    echo "piece $2..$3 went on where $there of its $(($3 - $2)) passes were there"
}

# A picture of 48 x 40 pixels, with so many photons that a pass takes some tenths of a second.
sed -E -e 's/^width = .*/width = 48/' -e 's/^height = .*/height = 40/' -e 's/^\[render\].*/&\nphotons = 40000/' \
    "$farm/../scenes/glass-ball.toml" > "$work/scene.toml"

# whole PASSES: the picture that all the others must be, in one go.
whole() {
    "$covbeam" render "$work/scene.toml" --passes "$1" --threads 1 --out "$work/whole.exr" > /dev/null 2> "$work/whole.log"
}

# same PICTURE: the bytes of the whole one.
same() {
    cmp "$work/whole.exr" "$1" || fail "$(basename "$1") is not the picture of one render"
    echo "$(basename "$1"): the same $(stat -c %s "$1") bytes as one render"
}
