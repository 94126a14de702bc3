#!/bin/bash
# Memory errors, undefined behaviour, leaks and data races of the C library, under hosts that do everything wrong.
#   tests/clients/sanitizers.sh PREFIX            20,000 random sequences of calls
#   tests/clients/sanitizers.sh PREFIX --full     1,000,000 of them, and of the beams whose calls are cancelled
# The library itself is built with AddressSanitizer and ThreadSanitizer, by the stable compiler; Rust's standard library comes
# without, and is seen by valgrind. (Sessions are seen by sanitizers alone: valgrind runs one thread at a time.) Needs clang with its sanitizers, and valgrind. What is missing is a failure.
set -euo pipefail
here="$(cd "$(dirname "$0")" && pwd)"
root="$here/../.."
target="$(realpath -m "${CARGO_TARGET_DIR:-$root/target}")/sanitizers"
[ $# -ge 1 ] || { echo "usage: $0 PREFIX [--full]" >&2; exit 1; }
released="$(cd "$1" && pwd)/lib/libcovbeam.a"
# Random sequences of a process; and states of objects on which everything is spoiled under valgrind, which is 50 times as slow.
sequences=10000 states=1
# The same of sessions; and passes of hosts that lie.
sessions=40 passes=72
# Beams of the latency's check. What the system takes to have memory back grows with them, and fivefold beside other work.
beams=250000
[ "${2:-}" != --full ] || { sequences=500000 states=6 sessions=4000 passes=9000 beams=1000000; }

build="$(mktemp -d)"
trap 'rm -rf "$build"' EXIT
host="$(rustc -vV | sed -n 's/^host: //p')"
runtimes="$(rustc --print sysroot)/lib/rustlib/$host/lib"
warnings=(-std=c99 -gdwarf-4 -O1 -fno-omit-frame-pointer -Wall -Wextra -Wpedantic -Werror -I"$root/include")
libraries=(-lpthread -ldl -lm)
hostile=("$here"/hostile.c "$here"/hostile/*.c)
hostile_session=("$here"/hostile_session.c "$here"/hostile_session/*.c "$here/hosted.c" "$here/hostile/types.c")

# library NAME FEATURES FLAGS...: the static library, built with these flags of rustc, as $target/NAME/$host/release/libcovbeam.a
library() {
    local name="$1" features="$2"
    shift 2
    # Sanitizers are unstable flags of a stable compiler; the standard library is that of the toolchain.
    # Optimised less than a release: these builds are made to be checked, not to be fast.
    (cd "$root" && RUSTC_BOOTSTRAP=1 RUSTFLAGS="$*" CARGO_PROFILE_RELEASE_LTO=off CARGO_PROFILE_RELEASE_CODEGEN_UNITS=16 \
        cargo build --quiet --locked --release --package covbeam-ffi --no-default-features --features "$features" \
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

CARGO_PROFILE_RELEASE_OPT_LEVEL=0 library not-optimised ""
# With sessions, which are ten times as much code: no more is optimised than pays in their checks.
export CARGO_PROFILE_RELEASE_OPT_LEVEL=1
library address session -Zsanitizer=address -Coverflow-checks=on -Cdebug-assertions=on
library thread session -Zsanitizer=thread -Cunsafe-allow-abi-mismatch=sanitizer
unset CARGO_PROFILE_RELEASE_OPT_LEVEL

echo "-- every function of the headers is called"
clang "${warnings[@]}" -O2 "${hostile[@]}" "$released" "${libraries[@]}" -o "$build/hostile"
clang "${warnings[@]}" -O2 "${hostile_session[@]}" "$released" "${libraries[@]}" -o "$build/hostile-session"
{ "$build/hostile" --list; "$build/hostile-session" --list; } | sort > "$build/called"
# Declarations begin a line; comments do not.
cat "$root"/include/covbeam{,_extra,_session}.h | grep -E '^[a-z]' | grep -vE '^(typedef|static inline)' | grep -oE 'covbeam_[a-z0-9_]+\(' | tr -d '(' | sort > "$build/declared"
diff "$build/declared" "$build/called"
wc -l < "$build/called"

echo "-- the kth request for memory is refused, for every k"
wrapped=(-Wl,--wrap=malloc,--wrap=calloc,--wrap=realloc,--wrap=posix_memalign,--wrap=free)
clang "${warnings[@]}" -O2 -DSCARCE "${hostile[@]}" "$here/scarce.c" "$released" "${libraries[@]}" "${wrapped[@]}" -o "$build/scarce"
"$build/scarce" 2000 5
clang "${warnings[@]}" -O2 "$here/scarce_session.c" "$here/hosted.c" "$here/scarce.c" "$released" "${libraries[@]}" "${wrapped[@]}" \
    -o "$build/scarce-session"
"$build/scarce-session"

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
address=(clang "${warnings[@]}" -fsanitize=address,undefined -fno-sanitize-recover=all)
"${address[@]}" "$here/reentry.c" "$(archive address)" "${libraries[@]}" -o "$build/reentry"
"$build/reentry"
echo "no findings in $((SECONDS - started)) s"

echo "-- the same of sessions: $sessions sequences, calls inside of calls, and a host that lies"
started=$SECONDS
"${address[@]}" "${hostile_session[@]}" "$(archive address)" "${libraries[@]}" -o "$build/hostile-session-address"
for program in reentry_session liar; do
    "${address[@]}" "$here/$program.c" "$here/hosted.c" "$(archive address)" "${libraries[@]}" -o "$build/$program"
done
"$build/liar" "$passes" 1 > "$build/first" 2>&1 &
first=$!
"$build/hostile-session-address" "$sessions" 1 > "$build/second" 2>&1 || { tail -60 "$build/second"; exit 1; }
"$build/reentry_session"
wait "$first" || { tail -60 "$build/first"; exit 1; }
cat "$build/first" "$build/second"
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
# Of the standard library, which comes without: the mangled name of a function, by the end of it.
mangled() { nm "$(archive thread)" 2> /dev/null | grep -oE "_RNv[A-Za-z0-9_]*$1\$" | sort -u; }
locks=(LOCK="$(mangled mutex5futexNtB2_5Mutex14lock_contended)" WAIT="$(mangled condvar5futexNtB2_7Condvar4wait)"
    WAIT_LONG="$(mangled condvar5futexNtB2_7Condvar12wait_timeout)" ONCE="$(mangled once5futexNtB5_4Once4call)")
clang "${warnings[@]}" "${locks[@]/#/-D}" -c "$here/unseen.c" -o "$build/unseen.o"
# threaded PROGRAM SOURCES...: the compiler's runtime is newer than clang's and has all that its code calls.
threaded() {
    local program="$1" source objects=()
    shift
    for source in "$@"; do
        clang "${warnings[@]}" -fsanitize=thread -c "$here/$source.c" -o "$build/$source.o"
        objects+=("$build/$source.o")
    done
    clang -g "${objects[@]}" "$build/unseen.o" "$(archive thread)" "${locks[@]/#*=/-Wl,--wrap=}" -Wl,--wrap=__tsan_atomic64_fetch_sub \
        -Wl,--whole-archive "$runtimes/librustc-stable_rt.tsan.a" -Wl,--no-whole-archive -Wl,--export-dynamic "${libraries[@]}" -lrt -lresolv \
        -o "$build/$program"
}
threaded threads-thread threads
threaded sessions-thread threads_session hosted
threaded reentry-thread reentry_session hosted
refused "two threads that change one light field" "data race" "$build/threads-thread" race
for _ in 1 2 3; do "$build/threads-thread"; "$build/threads-thread" busy; done
refused "a function of a host's that two threads call" "data race" "$build/sessions-thread" race
for _ in 1 2 3; do "$build/sessions-thread"; done
"$build/reentry-thread"

echo "-- helgrind, which sees the standard library too"
clang "${warnings[@]}" "$here/threads.c" "$released" "${libraries[@]}" -o "$build/threads"
race=(valgrind --quiet --tool=helgrind --error-exitcode=9)
refused "two threads that change one light field" "Possible data race" "${race[@]}" "$build/threads" race
"${race[@]}" "$build/threads"

echo "-- latency"
clang "${warnings[@]}" -O2 "$here/latency.c" "$released" "${libraries[@]}" -o "$build/latency"
"$build/latency" "$beams"
