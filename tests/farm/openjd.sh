#!/usr/bin/env bash
# The Open Job Description template, run by the openjd command: tests/farm/openjd.sh BINARY
# One of its tasks is killed; the job run again must go on from the shard, and end in the bytes of one render.
# shellcheck source=tests/farm/common.sh
. "$(dirname "$0")/common.sh"

python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet --no-deps -r "$tests/openjd-requirements.txt"
"$work/venv/bin/pip" check > "$work/pip.log"
template=$farm/openjd/covbeam.yaml
# Where the sessions have their folders, and the picture its own.
export TMPDIR=$work
mkdir "$work/a picture"
out="$work/a picture/it's.exr"
pieces=${out%.exr}.pieces

"$work/venv/bin/openjd" check "$template"

# 20 passes, 8 a task, so the last task is shorter.
run=("$work/venv/bin/openjd" run "$template" -p Scene="$work/scene.toml" -p Out="$out" -p Passes=20 -p PassesATask=8
    -p Threads=1 -p Covbeam="$covbeam")

"${run[@]}" -p Checkpoint=0 --step Merge --run-dependencies > "$work/killed.log" 2>&1 &
kill_piece "$pieces/8-16.shard"
! wait $! || fail "the run did not fail when a task was killed"
grep -q 'exited with code: .*-9' "$work/killed.log" || fail "the run failed for another reason"
test ! -e "$out" || fail "there is a picture, though a task failed"

"${run[@]}" -p Checkpoint=0 --step Merge --run-dependencies > "$work/again.log" 2>&1
grep -q 'openjd_status: .*/0-8.shard: finished before' "$work/again.log" || fail "a finished task was not seen as such"
gone_on "$work/again.log" 8 16
grep -q 'passes 16\.\.20,' "$work/again.log" || fail "the last task was not the short one"
grep -q 'openjd_progress: 100' "$work/again.log" || fail "no progress"
whole 20
same "$out"

# One task by hand, of another seed: its pieces are refused, with the reason where a scheduler finds it.
! "${run[@]}" -p Seed=7 --step Render -tp First=9 > "$work/refused.log" 2>&1 || fail "the shard of another seed was taken"
grep -q 'openjd_fail: .*seed 1, not 7' "$work/refused.log" || fail "no reason was given"
grep -q 'exited with code: 3 ' "$work/refused.log" || fail "not the exit code of refused input"

# A cancelation leaves covbeam the time to write the passes it has, which no checkpoint would have written yet.
rm "$pieces/0-8.shard"
"${run[@]}" -p Checkpoint=3600 --step Render -tp First=1 > "$work/canceled.log" 2>&1 &
within 120 grep -q openjd_progress "$work/canceled.log" || fail "no progress in two minutes"
kill -TERM $!
! wait $! || fail "a canceled run did not fail"
grep -q 'exited with code: 143 ' "$work/canceled.log" || fail "covbeam was not stopped by SIGTERM"
"${run[@]}" --step Render -tp First=1 > "$work/afterwards.log" 2>&1
gone_on "$work/afterwards.log" 0 8
"${run[@]}" --step Merge > "$work/merged.log" 2>&1
same "$out"
echo "openjd.sh: all as expected, in $SECONDS s"
