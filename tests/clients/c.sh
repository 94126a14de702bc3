#!/bin/bash
# Clients in C against an installed library: tests/clients/c.sh PREFIX
# The header alone, then examples/c: the commands of its README, pkg-config, the static library.
set -euo pipefail
root="$(cd "$(dirname "$0")/../.." && pwd)"
[ $# -ge 1 ] || { echo "usage: $0 PREFIX [PROGRAM]    PROGRAM: same of covbeam-tests" >&2; exit 1; }
prefix="$(cd "$1" && pwd)"
work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT
export PKG_CONFIG_PATH="$prefix/lib/pkgconfig"
strict="-Wall -Wextra -Wpedantic -Werror"

fail() { echo "c: $*" >&2; exit 1; }

# The headers, with nothing before them and nothing after them.
printf '#include <covbeam_extra.h>\n#include <covbeam_session.h>\n' | tee "$work/alone.c" > "$work/alone.cpp"
known=()
for compiler in gcc clang g++ clang++; do
    case "$compiler" in
        *++) file=alone.cpp standards="c++11 c++14 c++17 c++20 c++2b" ;;
        *) file=alone.c standards="c99 c11 c17 c2x" ;;
    esac
    for standard in $standards; do
        : > "$work/empty.${file#*.}"
        if ! "$compiler" "-std=$standard" -E "$work/empty.${file#*.}" -o "$work/probe" 2> "$work/log"; then
            # Only some compilers know the newest standard by this name.
            [[ "$standard" == *2[xb] ]] && continue
            cat "$work/log"
            fail "$compiler does not know $standard"
        fi
        "$compiler" "-std=$standard" $strict -Wconversion -I"$prefix/include" -c "$work/$file" -o "$work/alone.o"
        known+=("$compiler:$standard")
    done
done
echo "c: covbeam.h, covbeam_extra.h and covbeam_session.h alone, without a warning: ${known[*]}"

# The example of the README at the root.
readme() { awk -v wanted="$1" '/^```c$/ { n++; inside = 1; next } /^```$/ { inside = 0 } inside && n == wanted' "$root/README.md"; }
readme 2 > "$work/readme.c"
# shellcheck disable=SC2046
gcc -std=c99 $strict "$work/readme.c" -o "$work/readme" $(pkg-config --cflags --libs covbeam)
LD_LIBRARY_PATH="$prefix/lib" "$work/readme" > "$work/log" || { cat "$work/log"; fail "the example of README.md"; }
grep -qE '^[0-9.e-]*[1-9][0-9.e-]* W' "$work/log" || fail "the example of README.md prints: $(cat "$work/log")"
echo "c: the example of README.md: $(cat "$work/log")"

# Its session: the same bits in C99, by the shared library and by the static one, and those of the reference renderer (session.sh).
readme 1 > "$work/session.c"
# shellcheck disable=SC2046
gcc -std=c99 $strict "$work/session.c" -o "$work/session" $(pkg-config --cflags --libs covbeam)
(cd "$work" && LD_LIBRARY_PATH="$prefix/lib" ./session) || fail "the session of README.md"
mv "$work/fog.pfm" "$work/shared.pfm"
# shellcheck disable=SC2046
clang -std=c99 $strict "$work/session.c" -o "$work/session" $(pkg-config --cflags covbeam) "$prefix/lib/libcovbeam.a" \
    $(pkg-config --static --libs covbeam | tr ' ' '\n' | grep -vE '^-L|^-lcovbeam$')
(cd "$work" && ./session) || fail "the session of README.md, static"
cmp "$work/fog.pfm" "$work/shared.pfm" || fail "the session of README.md: shared and static differ"
[ $# -eq 1 ] || "$2" "$root/tests/scenes/session.toml" 16 "$work/fog.pfm" || fail "the session of README.md and the renderer differ"

# A picture has light in it, and every number of it is one.
check_picture() {
    local values
    values="$(tail -n +4 "$1" | od -A n -v -t f4 -w12 |
        awk '/[nN]/ { bad++ } $1 <= 0 || $1 != $2 || $2 != $3 { dark++ } { n++; sum += $1 }
            END { print n, bad + 0, dark + 0, (sum / n > 0.03 && sum / n < 0.15) ? "lit" : sum / n }')"
    [ "$values" = "$2 0 0 lit" ] || fail "$1: pixels, not finite, black or coloured, mean: $values"
}

# block N: the lines of the Nth sh block of the README.
block() { awk -v wanted="$1" '/^```sh$/ { n++; inside = 1; next } /^```$/ { inside = 0 } inside && n == wanted' \
    "$root/examples/c/README.md"; }

# The four commands, in a folder that has nothing of the repository but examples/c.
mkdir -p "$work/newcomer/examples"
cp -r "$root/examples/c" "$work/newcomer/examples/"
block 1 | sed "s|=PREFIX|=$prefix|g" > "$work/commands"
[ "$(wc -l < "$work/commands")" -eq 4 ] || fail "examples/c/README.md does not have four commands"
sed '4s/$/ --passes 1/' "$work/commands" > "$work/newcomer/commands.sh"
(cd "$work/newcomer" && env -u PKG_CONFIG_PATH bash -euo pipefail commands.sh) > "$work/log" 2>&1 ||
    { cat "$work/log"; fail "the commands of examples/c/README.md"; }
check_picture "$work/newcomer/glass_ball.pfm" 65536
echo "c: the four commands of the README: $(tail -n 1 "$work/log")"

# Its command without CMake.
block 2 | sed "s|=PREFIX|=$prefix|g" > "$work/pkg-config.sh"
[ "$(wc -l < "$work/pkg-config.sh")" -eq 1 ] || fail "examples/c/README.md does not have one command for pkg-config"
cp "$root"/examples/c/*.[ch] "$work/"
(cd "$work" && bash -euo pipefail pkg-config.sh && mv glass_ball cc-shared)

# The same by hand, without a warning: two compilers, the shared and the static library.
for compiler in gcc clang; do
    # shellcheck disable=SC2046
    "$compiler" -std=c99 -O2 $strict "$work/glass_ball.c" -o "$work/$compiler-shared" \
        $(pkg-config --cflags --libs covbeam) -lm
    # shellcheck disable=SC2046
    "$compiler" -std=c99 -O2 $strict "$work/glass_ball.c" -o "$work/$compiler-static" \
        $(pkg-config --cflags covbeam) "$prefix/lib/libcovbeam.a" \
        $(pkg-config --static --libs covbeam | tr ' ' '\n' | grep -vE '^-L|^-lcovbeam$')
    if ldd "$work/$compiler-static" | grep covbeam; then fail "$compiler-static needs the shared library"; fi
    ldd "$work/$compiler-shared" | grep 'libcovbeam\.so\.[0-9]* => not found' > /dev/null || fail "$compiler-shared has no SONAME"
done
# And the static target of CMake.
sed 's/covbeam::covbeam)/covbeam::covbeam_static)/' "$root/examples/c/CMakeLists.txt" > "$work/CMakeLists.txt"
cmake -S "$work" -B "$work/build" -DCMAKE_PREFIX_PATH="$prefix" > "$work/log" && cmake --build "$work/build" >> "$work/log" ||
    { cat "$work/log"; fail "covbeam::covbeam_static"; }
cp "$work/build/glass_ball" "$work/cmake-static"
if ldd "$work/cmake-static" | grep covbeam; then fail "cmake-static needs the shared library"; fi

for program in cc-shared gcc-shared gcc-static clang-shared clang-static cmake-static; do
    LD_LIBRARY_PATH="$prefix/lib" "$work/$program" "$work/$program.pfm" --passes 1 --size 64 > "$work/log"
    check_picture "$work/$program.pfm" 4096
done
# One compiler, one optimisation: the library makes no difference.
for compiler in gcc clang; do
    cmp "$work/$compiler-shared.pfm" "$work/$compiler-static.pfm" || fail "$compiler: shared and static differ"
done
# Arguments that make no sense are refused.
for arguments in "--size 12" "--passes 0" "--passes" "--seed x" "--photons -" "--unknown"; do
    # shellcheck disable=SC2086
    if "$work/gcc-static" $arguments > "$work/log" 2>&1; then fail "glass_ball takes $arguments"; fi
    grep -q '^usage' "$work/log" || fail "glass_ball $arguments: no usage"
done
if "$work/gcc-static" "$work/no-folder/x.pfm" --passes 1 --size 8 > "$work/log" 2>&1; then fail "a picture nowhere"; fi
# Memory that runs out, and objects in use.
library=("$prefix/lib/libcovbeam.a" -lpthread -ldl -lm)
# shellcheck disable=SC2086
gcc -std=gnu99 -O2 $strict -I"$prefix/include" "$root"/tests/clients/{memory,scarce}.c "${library[@]}" \
    -Wl,--wrap=malloc,--wrap=calloc,--wrap=realloc,--wrap=posix_memalign,--wrap=free -o "$work/memory"
"$work/memory"
# shellcheck disable=SC2086
gcc -std=c99 -O2 $strict -I"$prefix/include" "$root/tests/clients/reentry.c" "${library[@]}" -o "$work/reentry"
"$work/reentry"
echo "c: pkg-config and CMake, shared and static, gcc and clang: pictures made"
