#!/bin/bash
# Builds covbeam without std, links it into a freestanding C program and runs that.
set -euo pipefail
here="$(cd "$(dirname "$0")" && pwd)"
CARGO_TARGET_DIR="$(realpath -m "${CARGO_TARGET_DIR:-$here/../../target}")/bare-metal"
export CARGO_TARGET_DIR
cd "$here"

command -v "${CC:=gcc}" > /dev/null || { echo "bare metal: no C compiler ('$CC')" >&2; exit 1; }

tree="$(cargo tree --quiet --locked --edges normal --prefix none)"
if grep -vE '^(covbeam(-bare-metal)?|glam|libm) v' <<< "$tree"; then
    echo "bare metal: the core has a dependency besides glam and libm (above)" >&2
    exit 1
fi
cargo build --quiet --locked --release
program="$CARGO_TARGET_DIR/bare-metal"
"$CC" -O2 -std=c11 -Wall -Wextra -Werror -ffreestanding -nostdlib -static -Wl,--gc-sections \
    main.c "$CARGO_TARGET_DIR/release/libcovbeam_bare_metal.a" -o "$program"

status=0
"$program" || status=$?
if [ "$status" -ne 0 ]; then
    echo "bare metal: check $status of main.c failed" >&2
    exit 1
fi
echo "bare metal: a program of $(stat -c %s "$program") bytes without std and without a C library: ok"
