#!/bin/bash
# Memory errors, undefined behaviour, leaks and data races of the C library, under hosts that do everything wrong.
#   tests/clients/sanitizers.sh PREFIX            20,000 random sequences of calls
#   tests/clients/sanitizers.sh PREFIX --full     1,000,000 of them
# The library itself is built with AddressSanitizer and ThreadSanitizer, by the stable compiler; Rust's standard library comes
# without, and is seen by valgrind. Needs clang with its sanitizers, and valgrind. What is missing is a failure.
set -euo pipefail
here="$(cd "$(dirname "$0")" && pwd)"
root="$here/../.."
target="$(realpath -m "${CARGO_TARGET_DIR:-$root/target}")/sanitizers"
[ $# -ge 1 ] || { echo "usage: $0 PREFIX [--full]" >&2; exit 1; }
released="$(cd "$1" && pwd)/lib/libcovbeam.a"
# Random sequences of a process; and states of objects on which everything is spoiled under valgrind, which is 50 times as slow.
sequences=10000 states=1
[ "${2:-}" != --full ] || { sequences=500000 states=6; }

build="$(mktemp -d)"
trap 'rm -rf "$build"' EXIT
host="$(rustc -vV | sed -n 's/^host: //p')"
runtimes="$(rustc --print sysroot)/lib/rustlib/$host/lib"
warnings=(-std=c99 -gdwarf-4 -O1 -fno-omit-frame-pointer -Wall -Wextra -Wpedantic -Werror -I"$root/include")
libraries=(-lpthread -ldl -lm)
hostile=("$here"/hostile.c "$here"/hostile/*.c)

# library NAME FLAGS...: the static library, built with these flags of rustc, as $target/NAME/$host/release/libcovbeam.a
library() {
    local name="$1"
    shift
    # Sanitizers are unstable flags of a stable compiler; the standard library is that of the toolchain.
    # Optimised less than a release: these builds are made to be checked, not to be fast.
    (cd "$root" && RUSTC_BOOTSTRAP=1 RUSTFLAGS="$*" CARGO_PROFILE_RELEASE_LTO=off CARGO_PROFILE_RELEASE_CODEGEN_UNITS=16 cargo build --quiet --locked --release --package covbeam-ffi --no-default-features \
        --target "$host" --target-dir "$target/$name")
}
archive() { echo "$target/$1/$host/release/libcovbeam.a"; }

# refused WHAT PATTERN COMMAND...: a control that must be reported, or the checker checks nothing.
refused() {
    local what="$1" pattern="$2"
    shift 2
    if "$@" > "$build/control" 2>&1 || ! grep -q "$pattern" "$build/control"; then
        tail -20 "$build/control" >&2
        echo "sanitizers: $what was not reported" >&2
        exit 1
    fi
}

CARGO_PROFILE_RELEASE_OPT_LEVEL=0 library not-optimised
library address -Zsanitizer=address -Coverflow-checks=on -Cdebug-assertions=on
library thread -Zsanitizer=thread -Cunsafe-allow-abi-mismatch=sanitizer

echo "-- every function of the headers is called"
clang "${warnings[@]}" -O2 "${hostile[@]}" "$released" "${libraries[@]}" -o "$build/hostile"
"$build/hostile" --list | sort > "$build/called"
# Declarations begin a line; comments do not.
cat "$root"/include/covbeam.h "$root"/include/covbeam_extra.h | grep -E '^[a-z]' | grep -vE '^(typedef|static inline)' | grep -oE 'covbeam_[a-z0-9_]+\(' | tr -d '(' | sort > "$build/declared"
diff "$build/declared" "$build/called"
wc -l < "$build/called"

echo "-- the kth request for memory is refused, for every k"
wrapped=(-Wl,--wrap=malloc,--wrap=calloc,--wrap=realloc,--wrap=posix_memalign,--wrap=free)
clang "${warnings[@]}" -O2 -DSCARCE "${hostile[@]}" "$here/scarce.c" "$released" "${libraries[@]}" "${wrapped[@]}" -o "$build/scarce"
"$build/scarce" 2000 5

echo "-- AddressSanitizer, UndefinedBehaviorSanitizer, LeakSanitizer, overflow checks: two processes, $sequences sequences each"
clang "${warnings[@]}" -fsanitize=address,undefined -fno-sanitize-recover=all "${hostile[@]}" "$(archive address)" \
    "${libraries[@]}" -o "$build/hostile-address"
refused "an array that is too short" "heap-buffer-overflow" "$build/hostile-address" --lie
started=$SECONDS
export ASAN_OPTIONS=detect_leaks=1:malloc_context_size=4:quarantine_size_mb=32
"$build/hostile-address" "$sequences" 1 > "$build/first" 2>&1 &
first=$!
"$build/hostile-address" "$sequences" 2 > "$build/second" 2>&1 || { tail -60 "$build/second"; exit 1; }
wait "$first" || { tail -60 "$build/first"; exit 1; }
cat "$build/first" "$build/second"
clang "${warnings[@]}" -fsanitize=address,undefined -fno-sanitize-recover=all "$here/reentry.c" "$(archive address)" "${libraries[@]}" \
    -o "$build/reentry"
"$build/reentry"
echo "no findings in $((SECONDS - started)) s"

echo "-- valgrind memcheck, two processes: the library as it is released, and one that is not optimised"
started=$SECONDS
clang "${warnings[@]}" "${hostile[@]}" "$(archive not-optimised)" "${libraries[@]}" -o "$build/hostile-slow"
check=(valgrind --quiet --error-exitcode=9 --partial-loads-ok=no --leak-check=full --show-leak-kinds=definite,indirect,possible
    --errors-for-leak-kinds=definite,indirect,possible)
refused "an array that is too short" "Invalid read" "${check[@]}" "$build/hostile" --lie
# The optimiser computes with the fields of an enum before it asks which variant it is (and drops the result): of values that have
# never been written, memcheck can judge only code that is not optimised.
"${check[@]}" --undef-value-errors=no "$build/hostile" 200 3 "$states" > "$build/first" 2>&1 &
first=$!
"${check[@]}" "$build/hostile-slow" 40 4 "$states" > "$build/second" 2>&1 || { tail -60 "$build/second"; exit 1; }
wait "$first" || { tail -60 "$build/first"; exit 1; }
cat "$build/first" "$build/second"
echo "no findings in $((SECONDS - started)) s"

echo "-- ThreadSanitizer"
# The compiler's runtime is newer than clang's and has all that its code calls.
clang "${warnings[@]}" -fsanitize=thread -c "$here/threads.c" -o "$build/threads.o"
clang -g "$build/threads.o" "$(archive thread)" -Wl,--whole-archive "$runtimes/librustc-stable_rt.tsan.a" -Wl,--no-whole-archive \
    -Wl,--export-dynamic "${libraries[@]}" -lrt -lresolv -o "$build/threads-thread"
refused "two threads that change one light field" "data race" "$build/threads-thread" race
for _ in 1 2 3; do "$build/threads-thread"; "$build/threads-thread" busy; done

echo "-- helgrind, which sees the standard library too"
clang "${warnings[@]}" "$here/threads.c" "$released" "${libraries[@]}" -o "$build/threads"
race=(valgrind --quiet --tool=helgrind --error-exitcode=9)
refused "two threads that change one light field" "Possible data race" "${race[@]}" "$build/threads" race
"${race[@]}" "$build/threads"

echo "-- latency"
clang "${warnings[@]}" -O2 "$here/latency.c" "$released" "${libraries[@]}" -o "$build/latency"
"$build/latency"
