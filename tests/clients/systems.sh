# Libraries of other systems, for scripts that source this: what they give away, and what Wine lacks. `root` is the repository.
# shellcheck shell=bash

# What the headers declare: declarations begin a line, comments do not.
declared() {
    cat "$root"/include/covbeam{,_extra,_session}.h | grep -E '^[a-z]' | grep -vE '^(typedef|static inline)' |
        grep -oE 'covbeam_[a-z0-9_]+\(' | tr -d '(' | LC_ALL=C sort
}

# exports SYSTEM LIBRARY: the functions that a shared library of linux, windows or macos gives away.
exports() {
    case "$1" in
        linux*) nm -D --defined-only "$2" | awk '{ print $NF }' ;;
        windows*)
            x86_64-w64-mingw32-objdump -p "$2" |
                awk '/^\[Ordinal\/Name Pointer\] Table/ { table = 1; next } table && /^$/ { table = 0 } table { print $NF }' ;;
        macos*) llvm-nm -gU "$2" | awk '{ print substr($NF, 2) }' ;;
    esac | LC_ALL=C sort
}

# random_numbers FOLDER: puts a DLL there that Wine 8 lacks, from which Rust's standard library gets random numbers.
random_numbers() {
    printf '#include <windows.h>\n#include <ntsecapi.h>\nBOOL WINAPI ProcessPrng(PBYTE data, SIZE_T size) { return RtlGenRandom(data, (ULONG)size); }\n' |
        x86_64-w64-mingw32-gcc -shared -x c - -o "$1/bcryptprimitives.dll" -ladvapi32
}
