#!/bin/sh
#SBATCH --job-name=covbeam
#SBATCH --output=covbeam-%j.log
#SBATCH --open-mode=append
#SBATCH --requeue
#SBATCH --signal=B:USR1@120
#SBATCH --time=04:00:00
# One picture as a Slurm job array, an index a piece, and a job that merges the pieces when all are there:
#
#   slurm.sh SCENE.toml OUT.exr PASSES PASSES_A_TASK [option of sbatch]...
#
# Two minutes before its time limit a piece is stopped and queued again; it goes on from its shard. So is one whose node
# fails or is taken away. The same command, given again, makes what is missing. COVBEAM says where covbeam is.
set -eu

if [ $# -lt 4 ]; then
    echo "usage: $0 SCENE.toml OUT.exr PASSES PASSES_A_TASK [option of sbatch]..." >&2
    exit 2
fi
covbeam=${COVBEAM:-covbeam} scene=$1 out=$2 passes=$3 each=$4
shift 4
case $passes,$each in
    *[!0-9,]* | 0* | *,0* | ,* | *,) echo "$0: PASSES and PASSES_A_TASK must be whole numbers from 1 on" >&2; exit 2 ;;
esac
case $out in
    *.exr) ;;
    *) echo "$0: the picture is '$out'; it must end in .exr" >&2; exit 2 ;;
esac
pieces=${out%.exr}.pieces

# to FROM: where the piece that begins with this pass ends; the last may be shorter.
to() {
    echo $(($1 + each < passes ? $1 + each : passes))
}

# By hand: submits the array and the merge.
if [ -z "${SLURM_JOB_ID:-}" ]; then
    last=$(((passes - 1) / each))
    array=$(sbatch --parsable --array="0-$last" --output=covbeam-%A-%a.log "$@" "$0" "$scene" "$out" "$passes" "$each")
    array=${array%%;*}
    merge=$(sbatch --parsable --dependency="afterok:$array" --kill-on-invalid-dep=yes "$@" \
        "$0" "$scene" "$out" "$passes" "$each")
    echo "job $array renders $((last + 1)) pieces, job ${merge%%;*} merges them into $out"
    exit
fi

# The last job.
if [ -z "${SLURM_ARRAY_TASK_ID:-}" ]; then
    from=0
    set --
    while [ "$from" -lt "$passes" ]; do
        set -- "$@" "$pieces/$from-$(to "$from").shard"
        from=$(to "$from")
    done
    exec "$covbeam" merge "$@" --passes "$passes" --out "$out"
fi

# An index of the array.
from=$((SLURM_ARRAY_TASK_ID * each))
shard=$pieces/$from-$(to "$from").shard
mkdir -p "$pieces"
before=$(cksum 2> /dev/null < "$shard" || true)
"$covbeam" render "$scene" --passes "$from..$(to "$from")" --out "$shard" --threads "${SLURM_CPUS_ON_NODE:-0}" &
child=$!
# USR1 says that time is up (B: in --signal: this shell gets it). SIGTERM says that somebody else wants the end: scancel,
# after which a piece must not come back, or a preemption, after which Slurm itself queues it again.
signalled='' again=''
trap 'signalled=yes again=yes; kill -TERM "$child" 2> /dev/null' USR1
trap 'signalled=yes; kill -TERM "$child" 2> /dev/null' TERM
code=0
wait "$child" || code=$?
while [ -n "$signalled" ]; do
    # That wait was broken off by the signal.
    signalled='' code=0
    wait "$child" || code=$?
done
if [ -n "$again" ] && [ "$code" -ne 0 ]; then
    if [ "$(cksum 2> /dev/null < "$shard" || true)" = "$before" ]; then
        echo "$0: not a single pass is done in the time limit: raise it with --time" >&2
        exit 1
    fi
    scontrol requeue "${SLURM_ARRAY_JOB_ID}_$SLURM_ARRAY_TASK_ID"
fi
exit "$code"
