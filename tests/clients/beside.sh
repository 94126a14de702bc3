# Commands two at a time, or at_once, for scripts that source this: most of what they run has one thread.
# shellcheck shell=bash
running=0 failed=0 at_once=2

# ended: waits until a command has ended.
ended() {
    wait -n || failed=1
    running=$((running - 1))
}

# beside NAME COMMAND...: runs it beside what runs already. Its name and all that it says come when it has ended.
beside() {
    [ "$running" -lt "$at_once" ] || ended
    {
        status=0 started=$SECONDS
        said="$("${@:2}" 2>&1 < /dev/null)" || status=$?
        printf '\n== %s (%d s to %d s)\n%s\n' "$1" "$started" "$SECONDS" "$said"
        [ "$status" -eq 0 ] || printf 'FAILED: %s (exit code %d)\n' "$1" "$status"
        exit "$status"
    } &
    running=$((running + 1))
}

# joined: waits for all of them; fails if one has failed.
joined() {
    while [ "$running" -gt 0 ]; do ended; done
    [ "$failed" -eq 0 ]
}
