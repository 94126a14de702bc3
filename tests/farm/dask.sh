#!/usr/bin/env bash
# The Dask example, with three workers on this machine: tests/farm/dask.sh BINARY
# A worker is killed in the middle of a piece, and a render is stopped by Ctrl-C; the picture must have the bytes of one
# render, and no process may be left.
# shellcheck source=tests/farm/common.sh
. "$(dirname "$0")/common.sh"

python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet --no-deps -r "$tests/dask-requirements.txt"
"$work/venv/bin/pip" check > "$work/pip.log"

# What covbeam says on standard error is of no interest to render.py, but it is here.
cat > "$work/covbeam" << END
#!/bin/sh
exec '$covbeam' "\$@" 2>> '$work/covbeam.log'
END
chmod +x "$work/covbeam"
run=("$work/venv/bin/python" "$farm/dask/render.py" "$work/scene.toml" --passes 22 --chunk 8 --checkpoint 0 --workers 3
    --threads 1 --covbeam "$work/covbeam")
whole 22

# A worker dies, and its covbeam cannot end: it is halted. Another worker gets the piece, and must not begin before.
"${run[@]}" --show --out "$work/killed.exr" > "$work/killed.log" 2>&1 &
shard=$work/killed.pieces/8-16.shard
within 120 begun "$shard" || fail "the piece was not begun"
process=$(writer "$shard")
kill -STOP "$process"
worker=$(sed -n 's/^PPid:\t//p' "/proc/$process/status")
[[ $(tr '\0' ' ' < "/proc/$worker/cmdline") == "$work/venv/bin/python"* ]] ||
    fail "process $worker is not a worker of this test"
kill -9 "$worker"
for _ in {1..40}; do
    sleep 0.1
    test "$(writer "$shard")" = "$process" || fail "two processes write one shard"
done
kill -CONT "$process"
wait $! || fail "the render failed when a worker was killed"
grep -q 'passes 8\.\.16 are there' "$work/killed.log" || fail "the piece is not said to be there"
gone_on "$work/covbeam.log" 8 16
same "$work/killed.exr"
test -s "$work/killed-so-far.exr" || fail "--show has shown nothing"
none_left "" || fail "processes are left: $(ours)"

# Ctrl-C in a terminal goes to the whole process group, which only a job of its own has (set -m).
set -m
"${run[@]}" --out "$work/stopped.exr" > "$work/stopped.log" 2>&1 &
set +m
within 120 begun "$work/stopped.pieces/0-8.shard" || fail "the piece was not begun"
kill -INT -- "-$!"
code=0
wait $! || code=$?
test "$code" -eq 130 || fail "the exit code after Ctrl-C is $code"
grep -q 'the same command goes on from there' "$work/stopped.log" || fail "Ctrl-C is not answered with what to do next"
none_left "" || fail "processes are left: $(ours)"
test ! -e "$work/stopped.exr" || fail "there is a picture of a stopped render"
rm "$work/covbeam.log"
"${run[@]}" --out "$work/stopped.exr" > "$work/again.log" 2>&1
gone_on "$work/covbeam.log" 0 8
same "$work/stopped.exr"

# What no further try can mend ends the render at once, with covbeam's own words.
code=0
"${run[@]}" --seed 7 --out "$work/stopped.exr" > "$work/refused.log" 2>&1 || code=$?
test "$code" -eq 3 || fail "the exit code for refused input is $code"
grep -q 'error: .*it holds passes of another render (seed 1, not 7)' "$work/refused.log" || fail "no reason was given"
none_left "" || fail "processes are left: $(ours)"
echo "dask.sh: all as expected, in $SECONDS s"
