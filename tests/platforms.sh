#!/bin/bash
# Packages as those who get them see them: tests/platforms.sh PACKAGES [PLATFORM...]
#   PACKAGES: the folder that ffi/package.sh has filled; PLATFORM: as there (all whose packages are there, if none is named)
# Unpacked, with no Rust in reach: README's examples in C and Python, examples/cpp, the program. Linux runs here, Windows under Wine, aarch64 under QEMU, and
# all make the same bits; their shards add up to one machine's. Of macOS only what the files say is checked: nothing here can run them.
# Debian's packages: gcc, g++, cmake, make, pkg-config, python3-venv, llvm; gcc-mingw-w64-x86-64, g++-mingw-w64-x86-64, wine64;
# gcc-aarch64-linux-gnu, g++-aarch64-linux-gnu, qemu-user.
set -euo pipefail
root="$(cd "$(dirname "$0")/.." && pwd)"
fail() { echo "platforms: $*" >&2; exit 1; }
# shellcheck source=tests/clients/systems.sh
. "$root/tests/clients/systems.sh"
[ $# -gt 0 ] || { sed -n '2,3s/^# *//p' "$0" >&2; exit 1; }
packages="$(cd "$1" && pwd)"
shift
version="$(sed -n 's/^version = "\(.*\)"/\1/p' "$root/Cargo.toml")"
if [ $# -eq 0 ]; then
    # shellcheck disable=SC2046
    set -- $(cd "$packages" && ls "covbeam-$version"-* | sed -E "s/^covbeam-$version-//; s/\.(tar\.gz|zip)$//" | grep -v '\.whl$')
fi
temporary="$(mktemp -d)"
# Wine's server outlives its programs, and writes into its folder.
ended() {
    [ ! -e "$temporary/wine" ] || WINEPREFIX="$temporary/wine" wineserver -k || true
    rm -rf "$temporary"
}
trap ended EXIT
# As people name folders.
work="$temporary/Licht und Größe"
mkdir -p "$work" "$temporary/tools"

(cd "$packages" && sha256sum --quiet --check SHA256SUMS) || fail "SHA256SUMS does not fit"

# Where no Rust is in reach.
for tool in bash sh env cat cp mv rm mkdir ls sed awk grep tr sort head tail cut dirname basename uname find cmp install chmod ln touch gcc g++ cc c++ ld as ar ranlib nm strip \
    objcopy make cmake pkg-config python3; do
    ln -s "$(command -v "$tool" || fail "$tool is missing")" "$temporary/tools/$tool"
done
bare() { env -i HOME="$temporary" PATH="$temporary/tools" LANG=C.UTF-8 "$@"; }
if bare sh -c 'command -v cargo rustc'; then fail "Rust is in reach"; fi

# said_of PLATFORM FILE: the oldest system that a file says it runs on.
said_of() {
    case "$1" in
        linux-*) grep -aoE 'GLIBC_[0-9.]+' "$2" | sort -Vu | tail -n 1 ;;
        windows-*) echo "$(x86_64-w64-mingw32-objdump -p "$2" | sed -n 's/.*DLL Name: //p' | LC_ALL=C sort -f | xargs)" ;;
        macos-*) echo "macOS $(llvm-objdump --macho --private-headers "$2" | awk '/LC_BUILD_VERSION/ { found = 1 } found && $1 == "minos" { print $2; exit }')" ;;
    esac
}

# unpacked PLATFORM: its files are those that belong there, and its library is what the headers declare.
unpacked() {
    local archive="$packages/covbeam-$version-$1" library wheel
    case "$1" in
        windows-*) (cd "$work" && cmake -E tar xf "$archive.zip") ;;
        *) tar -C "$work" -xf "$archive.tar.gz" ;;
    esac
    tree="$work/covbeam-$version-$1"
    case "$1" in
        windows-*) library="$tree/bin/covbeam.dll" program="$tree/bin/covbeam.exe" ;;
        macos-*) library="$(realpath "$tree/lib/libcovbeam.dylib")" program="$tree/bin/covbeam" ;;
        *) library="$(realpath "$tree/lib/libcovbeam.so")" program="$tree/bin/covbeam" ;;
    esac
    for file in LICENSE-MIT LICENSE-APACHE THIRD-PARTY CHANGELOG.md include/covbeam_session.hpp lib/pkgconfig/covbeam.pc lib/cmake/covbeam/covbeam-config.cmake; do
        [ -s "$tree/$file" ] || fail "$1: no $file"
    done
    diff <(declared) <(exports "$1" "$library") || fail "$1: the library exports (>) other functions than the headers declare (<)"
    case "$1" in
        linux-*)
            for file in "$library" "$program"; do
                [ "$(printf '%s\nGLIBC_2.17\n' "$(said_of "$1" "$file")" | sort -V | tail -n 1)" = GLIBC_2.17 ] || fail "$1: $file asks for $(said_of "$1" "$file")"
            done ;;
        macos-*)
            for file in "$library" "$program"; do
                [ "$(said_of "$1" "$file")" = "macOS 11.0" ] || fail "$1: $file is for '$(said_of "$1" "$file")'"
            done
            # Macs with ARM run nothing that is not signed.
            llvm-objdump --macho --private-headers "$program" | grep LC_CODE_SIGNATURE > "$temporary/signed" || [ "$1" = macos-x86_64 ] || fail "$1: the program is not signed" ;;
    esac
    case "$1" in
        linux-x86_64) wheel=manylinux_2_17_x86_64 ;;
        linux-aarch64) wheel=manylinux_2_17_aarch64 ;;
        windows-x86_64) wheel=win_amd64 ;;
        macos-aarch64) wheel=macosx_11_0_arm64 ;;
        macos-x86_64) wheel=macosx_11_0_x86_64 ;;
    esac
    python3 -m zipfile -l "$packages/covbeam-$version-py3-none-$wheel.whl" > "$temporary/wheel" || fail "$1: no wheel for $wheel"
    grep -q "covbeam/\(lib\)\?covbeam\.\(so\|dll\|dylib\) " "$temporary/wheel" || fail "$1: no library in the wheel"
    echo "platforms: $1: $(exports "$1" "$library" | wc -l) functions, as declared; asks for $(said_of "$1" "$library"); bytes: library $(stat -c %s "$library")," \
        "static $(stat -c %s "$tree"/lib/libcovbeam.a), program $(stat -c %s "$program"), archive $(stat -c %s "$archive".*), wheel $(stat -c %s "$packages/covbeam-$version-py3-none-$wheel.whl")"
}

# readme LANGUAGE N: the Nth example of the README in it.
readme() { awk -v begin="^\`\`\`$1\$" -v wanted="$2" '$0 ~ begin { n++; inside = 1; next } /^```$/ { inside = 0 } inside && n == wanted' "$root/README.md"; }

# The scenes whose pictures all machines make, and how: small, and with all that the golden pictures have.
small=(--passes 2 --photons 1000 --seed 1)

# runs PLATFORM COMPILER RUNNER...: README's C, examples/cpp and the program, on $tree.
runs() {
    local platform="$1" compiler="$2" here="$work/$1" suffix="" started=$SECONDS
    shift 2
    mkdir -p "$here"
    [[ "$platform" != windows-* ]] || suffix=.exe
    readme c 1 > "$here/session.c"
    readme c 2 > "$here/kernels.c"
    for example in session kernels; do
        bare PKG_CONFIG_PATH="$tree/lib/pkgconfig" "$temporary/tools/bash" -c 'cd "$1" && eval "$2 -std=c99 $3.c -o $3$4 $(pkg-config --cflags --libs covbeam) -lm"' \
            - "$here" "$(command -v "$compiler")" "$example" "$suffix" || fail "$platform: README's C ($example)"
    done
    local own=()
    [[ "$platform" != windows-* ]] || own=(-static-libstdc++ -static-libgcc)
    bare "$(command -v "${compiler/gcc/g++}")" -std=c++14 -O2 -I"$tree/include" "$root"/examples/cpp/*.cpp -L"$tree/lib" -lcovbeam -pthread "${own[@]}" \
        -o "$here/shaft$suffix" || fail "$platform: examples/cpp"
    # A program finds the library beside itself, or where the loader is told to look.
    [[ "$platform" != windows-* ]] || cp "$tree/bin/covbeam.dll" "$("$compiler" -print-file-name=libwinpthread-1.dll)" "$here/"
    (
        cd "$here"
        export LD_LIBRARY_PATH="$tree/lib" WINEPREFIX="$temporary/wine" WINEDEBUG=-all
        "$@" "./session$suffix" > said 2> warned || { cat said warned; fail "$platform: README's session"; }
        "$@" "./kernels$suffix" > said 2> warned || { cat said warned; fail "$platform: README's kernels"; }
        tr -d '\r' < said > kernels.txt
        "$@" "./shaft$suffix" --passes 1 --photons 300 --out shaft.pfm > said 2> warned || { cat said warned; fail "$platform: examples/cpp"; }
        [ "$(stat -c %s shaft.pfm)" -gt 700000 ] || fail "$platform: examples/cpp makes no picture"
        "$@" "$program" --version > said 2> warned || { cat said warned; fail "$platform: covbeam --version"; }
        grep -q "^covbeam $version" said || fail "$platform: covbeam --version says $(cat said)"
        for scene in glass-ball shaft smoke; do
            sed -E 's/^(width|height) = .*/\1 = 48/' "$root/examples/scenes/$scene.toml" > "$scene.toml"
            for folder in meshes volumes; do [ -e "$folder" ] || cp -r "$root/examples/scenes/$folder" .; done
            "$@" "$program" render "$scene.toml" "${small[@]}" --out "$scene.exr" > said 2> warned || { cat said warned; fail "$platform: $scene"; }
        done
        # A part of a picture that others have the rest of.
        "$@" "$program" render glass-ball.toml --photons 1000 --seed 1 --passes 1..2 --out part.shard > said 2> warned || { cat said warned; fail "$platform: a shard"; }
    )
    echo "platforms: $platform: README's C, examples/cpp, covbeam $version, three pictures and a shard in $((SECONDS - started)) s"
}

# same PLATFORM: its pictures, and its shard, are those of this machine.
same() {
    local file
    for file in fog.pfm kernels.txt glass-ball.exr shaft.exr smoke.exr part.shard; do
        cmp "$work/linux-x86_64/$file" "$work/$1/$file" || fail "$1: $file has other bits than on linux-x86_64"
    done
    (
        cd "$work/linux-x86_64"
        cp "../$1/part.shard" foreign.shard
        "$native" render glass-ball.toml --photons 1000 --seed 1 --passes 0..1 --out first.shard > said 2>&1 || { cat said; fail "a shard"; }
        "$native" merge first.shard foreign.shard --out merged.exr > said 2>&1 || { cat said; fail "merge with the shard of $1"; }
        cmp merged.exr glass-ball.exr || fail "$1: its shard and one of linux-x86_64 do not add up to the picture of one machine"
    )
    echo "platforms: $1: the bits of linux-x86_64: session, kernels, three pictures; a shard of it and one of linux-x86_64 are one machine's picture"
}

linux_x86_64() {
    native="$program"
    runs linux-x86_64 gcc env
    # As on a processor without AVX and FMA.
    (cd "$work/linux-x86_64" && GLIBC_TUNABLES=glibc.cpu.hwcaps=-AVX,-AVX2,-AVX512F,-FMA,-FMA4 "$program" render shaft.toml "${small[@]}" --out other.exr > said 2>&1 &&
        cmp other.exr shaft.exr) || fail "linux-x86_64: without AVX and FMA"
    cp -r "$root/examples/cpp" "$work/cpp"
    bare "$temporary/tools/bash" -c 'cmake -S "$1/cpp" -B "$1/cpp/build" -DCMAKE_PREFIX_PATH="$2" && cmake --build "$1/cpp/build"' - "$work" "$tree" > "$temporary/log" 2>&1 ||
        { cat "$temporary/log"; fail "linux-x86_64: examples/cpp"; }
    bare "$work/cpp/build/covbeam-shaft" --passes 1 --photons 1000 --out "$work/cpp/shaft.pfm" 2> "$temporary/log" || { cat "$temporary/log"; fail "linux-x86_64: covbeam-shaft"; }
    # Python, in an environment of its own.
    python3 -m venv "$temporary/venv"
    "$temporary/venv/bin/pip" install --quiet --disable-pip-version-check numpy "$packages/covbeam-$version-py3-none-manylinux_2_17_x86_64.whl"
    for example in 1 2; do
        readme python "$example" > "$work/example.py"
        (cd "$work" && bare "$temporary/venv/bin/python" example.py) > "$temporary/log" 2>&1 || { cat "$temporary/log"; fail "linux-x86_64: README's Python ($example)"; }
    done
    # A wheel for another platform is refused.
    local wheel
    for wheel in "$packages"/covbeam-*-win_amd64.whl "$packages"/covbeam-*-macosx_*_arm64.whl; do
        [ -e "$wheel" ] || continue
        if "$temporary/venv/bin/pip" install --disable-pip-version-check "$wheel" > "$temporary/log" 2>&1; then fail "pip takes $wheel"; fi
        grep -q 'not a supported wheel on this platform' "$temporary/log" || { cat "$temporary/log"; fail "$wheel"; }
    done
    echo "platforms: linux-x86_64: the same without AVX and FMA; examples/cpp; README's Python from the wheel; other platforms' wheels are refused"
}

windows_x86_64() {
    mkdir -p "$work/windows-x86_64"
    random_numbers "$work/windows-x86_64"
    cp "$work/windows-x86_64/bcryptprimitives.dll" "$tree/bin/"
    runs windows-x86_64 x86_64-w64-mingw32-gcc-posix wine
    # Paths with backslashes, and names that Windows forbids or keeps for devices.
    (
        cd "$work/windows-x86_64"
        export WINEPREFIX="$temporary/wine" WINEDEBUG=-all
        mkdir -p "öffentlich"
        wine "$program" render '.\glass-ball.toml' "${small[@]}" --out '.\öffentlich\a b.exr' > said 2>&1 || { cat said; fail "windows-x86_64: backslashes"; }
        cmp "öffentlich/a b.exr" glass-ball.exr || fail "windows-x86_64: another picture by backslashes"
        for name in 'a<b.exr' 'a?.exr' 'missing\a.exr'; do
            if wine "$program" render glass-ball.toml "${small[@]}" --out "$name" > said 2>&1; then fail "windows-x86_64: --out '$name' is taken"; fi
            grep -qF "$name" said || { cat said; fail "windows-x86_64: --out '$name' is not named"; }
        done
    )
    echo "platforms: windows-x86_64: backslashes, spaces and umlauts; names that Windows forbids are refused by name"
}

native=""
case " $* " in *" linux-x86_64 "*) ;; *) set -- linux-x86_64 "$@" ;; esac
for platform in linux-x86_64 "${@/linux-x86_64/}"; do
    case "$platform" in
        "") continue ;;
        linux-x86_64) unpacked "$platform"; linux_x86_64 ;;
        linux-aarch64) unpacked "$platform"; runs "$platform" aarch64-linux-gnu-gcc qemu-aarch64 -L /usr/aarch64-linux-gnu; same "$platform" ;;
        windows-x86_64) unpacked "$platform"; windows_x86_64; same "$platform" ;;
        macos-*) unpacked "$platform"; echo "platforms: $platform: linked and looked at; nothing here can run it" ;;
        *) fail "'$platform' is no platform" ;;
    esac
done
