#!/bin/sh
# One picture with GNU parallel, on this machine or, through ssh, on others that share the folder:
#
#   parallel.sh SCENE.toml OUT.exr PASSES PASSES_A_PIECE [option of parallel]...
#   parallel.sh scene.toml scene.exr 256 8 --sshlogin node1,node2,node3 --workdir .
#
# A piece that fails is tried again, and goes on from its shard. The same command, given again, makes what is missing: so
# there is no need for --resume, which would also believe its log about a scene that was changed since, where covbeam
# looks at the scene. COVBEAM says where covbeam is.
set -eu

if [ $# -lt 4 ]; then
    echo "usage: $0 SCENE.toml OUT.exr PASSES PASSES_A_PIECE [option of parallel]..." >&2
    exit 2
fi
covbeam=${COVBEAM:-covbeam} scene=$1 out=$2 passes=$3 each=$4
shift 4
case $passes,$each in
    *[!0-9,]* | 0* | *,0* | ,* | *,) echo "$0: PASSES and PASSES_A_PIECE must be whole numbers from 1 on" >&2; exit 2 ;;
esac
case $out in
    *.exr) ;;
    *) echo "$0: the picture is '$out'; it must end in .exr" >&2; exit 2 ;;
esac
pieces=${out%.exr}.pieces
mkdir -p "$pieces"

# cuts: a line "FROM TO" for each piece; the last may be shorter.
cuts() {
    from=0
    while [ "$from" -lt "$passes" ]; do
        to=$((from + each < passes ? from + each : passes))
        echo "$from $to"
        from=$to
    done
}

# One piece at a time on a machine: covbeam uses all its cores. --termseq leaves it the time to write what it has.
cuts | parallel --jobs 1 --retries 3 --joblog "$pieces/joblog" --termseq TERM,60000,KILL,25 --line-buffer --tag \
    --colsep ' ' --quote "$@" \
    "$covbeam" render "$scene" --passes '{1}..{2}' --out "$pieces/{1}-{2}.shard" || {
    echo "$0: pieces are missing; see $pieces/joblog, and give the same command again" >&2
    exit 1
}

set --
for cut in $(cuts | tr ' ' -); do
    set -- "$@" "$pieces/$cut.shard"
done
"$covbeam" merge "$@" --passes "$passes" --out "$out"
