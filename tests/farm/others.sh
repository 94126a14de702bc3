#!/usr/bin/env bash
# The examples for GNU parallel, Slurm and Flamenco, as far as they run without a cluster: tests/farm/others.sh BINARY
# shellcheck source=tests/farm/common.sh
. "$(dirname "$0")/common.sh"

[[ $(parallel --version 2> /dev/null) == "GNU parallel"* ]] ||
    fail "GNU parallel is missing: install the Debian package parallel"
command -v node > /dev/null || fail "node is missing: install the Debian package nodejs"

# The scripts leave --checkpoint alone, but here a kill shall lose a pass and not a minute.
cat > "$work/covbeam" << END
#!/bin/sh
test "\$1" != render || set -- "\$@" --checkpoint 0
exec '$covbeam' "\$@"
END
chmod +x "$work/covbeam"
export COVBEAM=$work/covbeam
mkdir "$work/a picture"
cd "$work/a picture"
whole 20

# GNU parallel: a killed piece is tried again by parallel itself.
"$farm/parallel.sh" "$work/scene.toml" "it's parallel.exr" 20 8 > "$work/parallel.log" 2>&1 &
kill_piece "$PWD/it's parallel.pieces/8-16.shard"
wait $! || fail "parallel.sh failed"
gone_on "$work/parallel.log" 8 16
test "$(awk -F '\t' 'NR > 1 && $7 == 0' "it's parallel.pieces/joblog" | wc -l)" -eq 3 || fail "the job log has not three done"
same "it's parallel.exr"
# Given again with nothing to do, and with what cannot be done.
"$farm/parallel.sh" "$work/scene.toml" "it's parallel.exr" 20 8 > "$work/parallel.log" 2>&1
test "$(grep -c 'finished before' "$work/parallel.log")" -eq 3 || fail "finished pieces were not seen as such"
sed 's/^photons = .*/photons = 10000/' "$work/scene.toml" > "$work/changed.toml"
! "$farm/parallel.sh" "$work/changed.toml" "it's parallel.exr" 20 8 > "$work/parallel.log" 2>&1 ||
    fail "a changed scene was taken"
grep -q 'it holds passes of another render' "$work/parallel.log" || fail "no reason was given"
same "it's parallel.exr"

# Both scripts refuse what would end in an endless loop, or fail after all the pieces.
for wrong in "x.exr 20 0" "x.exr 0 8" "x.exr 20 -8" "x.exr 08 8" "x.exr 20 8x" "x.png 20 8" "x.exr 20"; do
    for script in parallel slurm; do
        code=0
        # shellcheck disable=SC2086
        "$farm/$script.sh" "$work/scene.toml" $wrong 2> "$work/wrong.log" || code=$?
        test "$code" -eq 2 || fail "the exit code of $script.sh with $wrong is $code"
    done
done

# Slurm, with stand-ins for its two commands that write down how they are called.
mkdir "$work/slurm"
cat > "$work/slurm/sbatch" << END
#!/bin/sh
echo "sbatch \$*" >> '$work/slurm/called'
wc -l < '$work/slurm/called' | sed 's/.*/4&;cluster/'
END
cat > "$work/slurm/scontrol" << END
#!/bin/sh
echo "scontrol \$*" >> '$work/slurm/called'
END
chmod +x "$work/slurm/sbatch" "$work/slurm/scontrol"
export PATH=$work/slurm:$PATH
job=("$farm/slurm.sh" "$work/scene.toml" "it's slurm.exr" 20 8)

"${job[@]}" --partition=night > "$work/submitted.log"
grep -q '^job 41 renders 3 pieces, job 42 merges them' "$work/submitted.log" || fail "slurm.sh does not say what it submitted"
diff - "$work/slurm/called" << END
sbatch --parsable --array=0-2 --output=covbeam-%A-%a.log --partition=night ${job[*]}
sbatch --parsable --dependency=afterok:41 --kill-on-invalid-dep=yes --partition=night ${job[*]}
END

export SLURM_JOB_ID=41 SLURM_ARRAY_JOB_ID=41 SLURM_CPUS_ON_NODE=1
# Time is nearly up: the piece is queued again and goes on.
: > "$work/slurm/called"
SLURM_ARRAY_TASK_ID=1 sh "${job[@]}" > "$work/time-up.log" 2>&1 &
within 120 begun "$PWD/it's slurm.pieces/8-16.shard" || fail "the piece was not begun"
kill -USR1 $!
code=0
wait $! || code=$?
test "$code" -eq 143 || fail "the exit code at the time limit is $code"
test "$(cat "$work/slurm/called")" = "scontrol requeue 41_1" || fail "the piece was not queued again"
SLURM_ARRAY_TASK_ID=1 sh "${job[@]}" > "$work/again.log" 2>&1
gone_on "$work/again.log" 8 16
# scancel: it keeps its work, but does not come back. Nor does what was killed.
for signal in TERM KILL; do
    : > "$work/slurm/called"
    rm -f "it's slurm.pieces/0-8.shard"
    SLURM_ARRAY_TASK_ID=0 sh "${job[@]}" > "$work/canceled.log" 2>&1 &
    within 120 begun "$PWD/it's slurm.pieces/0-8.shard" || fail "the piece was not begun"
    case $signal in
        TERM) kill -TERM $! ;;
        KILL) kill_piece "$PWD/it's slurm.pieces/0-8.shard" ;;
    esac
    code=0
    wait $! || code=$?
    test "$code" -eq $((128 + $(kill -l $signal))) || fail "the exit code at SIG$signal is $code"
    test ! -s "$work/slurm/called" || fail "the piece was queued again"
    SLURM_ARRAY_TASK_ID=0 sh "${job[@]}" > "$work/again.log" 2>&1
    gone_on "$work/again.log" 0 8
done
# A time limit in which no pass gets done must not come back for ever.
cat > "$work/slow" << END
#!/bin/sh
trap 'kill %1; exit 143' TERM
sleep 60 &
touch '$work/slow.begun'
wait
END
chmod +x "$work/slow"
: > "$work/slurm/called"
COVBEAM=$work/slow SLURM_ARRAY_TASK_ID=2 sh "${job[@]}" > "$work/slow.log" 2>&1 &
within 10 test -e "$work/slow.begun" || fail "the slow stand-in did not begin"
kill -USR1 $!
! wait $! || fail "a piece without a pass is taken for done"
grep -q 'not a single pass .* --time' "$work/slow.log" || fail "the time limit is not named"
test ! -s "$work/slurm/called" || fail "a piece without a pass was queued again"
# The merge, first with a piece missing.
! sh "${job[@]}" > "$work/missing.log" 2>&1 || fail "merged with a piece missing"
grep -q '16-20.shard' "$work/missing.log" || fail "the missing piece is not named"
SLURM_ARRAY_TASK_ID=2 sh "${job[@]}" > "$work/last.log" 2>&1
sh "${job[@]}" > "$work/merged.log" 2>&1
same "it's slurm.exr"
unset SLURM_JOB_ID SLURM_ARRAY_JOB_ID SLURM_CPUS_ON_NODE

# Flamenco.
node "$tests/flamenco_test.js" "$farm/flamenco/covbeam.js" "$work/scene.toml" "$PWD/flamenco.exr" "$COVBEAM"
same flamenco.exr
echo "others.sh: all as expected, in $SECONDS s"
