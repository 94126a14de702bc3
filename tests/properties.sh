#!/bin/bash
# Property tests with cases of their own, and more of them: tests/properties.sh [TIMES [SEED]]
# TIMES (100): as many cases as `cargo test` tries. SEED: another one each day by default. A find prints its input: make a named test of it.
set -euo pipefail
cd "$(dirname "$0")/.."
times="${1:-100}"
seed="${2:-$(date +%Y%m%d)}"
# Names of tests in blocks of proptest!, from all files that have one.
names="$(git grep -l '^ *proptest! {' -- '*.rs' | xargs awk '
    /^ *proptest! \{$/ { end = $0; sub(/proptest.*/, "}", end) }
    $0 == end { end = "" }
    end != "" && /^ *fn [a-z0-9_]+\(/ { sub(/^ *fn /, ""); sub(/\(.*/, ""); print }')"
echo "seed $seed, $times times as many cases, $(wc -w <<< "$names") tests"
# 256 is what proptest tries by itself, and tests that try more say so in multiples of that; 1024 of all cases may be refused.
# shellcheck disable=SC2086
PROPTEST_RNG_SEED="$seed" PROPTEST_CASES=$((256 * times)) PROPTEST_MAX_GLOBAL_REJECTS=$((1024 * times)) PROPTEST_DISABLE_FAILURE_PERSISTENCE=1 \
    cargo test -p covbeam-tests -p covbeam-render -p covbeam-session --lib --tests --no-fail-fast -- $names
