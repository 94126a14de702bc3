#!/bin/bash
# The ABI that programs are compiled for, as libabigail sees it, is what tests/covbeam.abi says.
#   tests/clients/abi.sh PREFIX     of what install.sh has installed there: headers, SONAME, exported symbols
#   tests/clients/abi.sh --write    remakes tests/covbeam.abi from include/ and ffi/Cargo.toml
# Types are those of the header, which is what a C program sees; that the library's are the same, layout.rs and
# abi.c assert. The library's own debug information also tells of its insides, and changes with the compiler.
set -euo pipefail
root="$(cd "$(dirname "$0")/../.." && pwd)"
[ $# -eq 1 ] || { echo "usage: $0 PREFIX | --write" >&2; exit 1; }
kept="$root/tests/covbeam.abi"
work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT

fail() { echo "abi: $*" >&2; exit 1; }

# describe FOLDER SONAME: of the headers in it, into $work/covbeam.abi, from a library whose functions do nothing.
describe() {
    cp "$1"/covbeam.h "$1"/covbeam_extra.h "$1"/covbeam_session.h "$work"
    printf '#include "covbeam_extra.h"\n#include "covbeam_session.h"\n' > "$work/all.h"
    # A declaration begins a line and may go on; one that ends without a body gets one.
    (cd "$work" && cc -E -P all.h | awk '
        /^[a-z]/ { text = ""; open = !/^(typedef|static|extern)/ }
        { text = text $0 "\n" }
        /;$/ && open && text ~ /covbeam_[a-z0-9_]+\(/ { sub(/;\n$/, " { __builtin_trap(); }\n", text) }
        /;$|}$/ { printf "%s", text; text = "" }' > covbeam.c
        cc -std=c11 -w -g -shared -fPIC "-Wl,-soname,$2" covbeam.c -o covbeam.so
        abidw --no-corpus-path --no-comp-dir-path --no-show-locs --no-elf-needed --type-id-style hash \
            covbeam.so > covbeam.abi)
}

if [ "$1" = --write ]; then
    abi="$(sed -n 's/^version = "\([0-9]*\)\..*/\1/p' "$root/ffi/Cargo.toml")"
    describe "$root/include" "libcovbeam.so.$abi"
    cp "$work/covbeam.abi" "$kept"
    exit
fi

library="$1/lib/libcovbeam.so"
describe "$1/include" "$(readelf -d "$library" | sed -n 's/.*SONAME.*\[\(.*\)\]/\1/p')"
functions() { nm -D --defined-only "$1" | awk '$NF ~ /^covbeam_/ { print $NF }' | LC_ALL=C sort; }
diff <(functions "$work/covbeam.so") <(functions "$library") || fail "the library (>) has other functions than its headers (<)"
abidiff "$kept" "$work/covbeam.abi" || fail "the ABI has changed (above). Meant? tests/clients/abi.sh --write
and, where a program must be compiled anew, another COVBEAM_ABI_VERSION and version in ffi/Cargo.toml"

# What must be noticed: a field more, another type, a function less.
# broken HEADER CHANGE PATTERN
broken() {
    mkdir -p "$work/broken"
    cp "$root"/include/covbeam{,_extra,_session}.h "$work/broken"
    sed "$2" "$root/include/$1" > "$work/broken/$1"
    ! cmp -s "$work/broken/$1" "$root/include/$1" || fail "'$2' changes nothing"
    describe "$work/broken" "libcovbeam.so.0"
    if abidiff "$kept" "$work/covbeam.abi" > "$work/said"; then fail "not noticed: $2"; fi
    grep -q "$3" "$work/said" || { cat "$work/said"; fail "noticed as something else: $2"; }
}
broken covbeam.h 's/^typedef struct covbeam_beam {/&\n    float added;/' "'float added'"
broken covbeam.h 's/^uint32_t covbeam_abi_version(void)/uint64_t covbeam_abi_version(void)/' 'return type changed'
broken covbeam.h '/^uint32_t covbeam_abi_version(void)/d' '1 Removed'
# Of a struct that is passed, of one that only a function of the host's gets, and of one that other structs hold.
broken covbeam_session.h 's/^typedef struct covbeam_host {/&\n    float added;/' "'float added'"
broken covbeam_session.h 's/^typedef struct covbeam_host_photon {/&\n    float added;/' "'float added'"
broken covbeam_session.h 's/^typedef struct covbeam_camera {/&\n    float added;/' "'float added'"
echo "abi: $(functions "$library" | wc -l) functions, as in tests/covbeam.abi; six broken headers noticed"
