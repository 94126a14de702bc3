#!/usr/bin/env bash
# The Python module as a user gets it: wheel built, installed into a fresh environment, tested. Prints figures.
#   tests/clients/python.sh PREFIX [FOLDER]     PREFIX: where install.sh has installed; FOLDER: for what is built, else a temporary one
set -euo pipefail

prefix=$(realpath "$1")
repository=$(realpath "$(dirname "$0")/../..")
if [ $# -ge 2 ]; then
    work=$(realpath "$2")
else
    work=$(mktemp -d)
    trap 'rm -rf "$work"' EXIT
fi
export PYTHONDONTWRITEBYTECODE=1 PIP_DISABLE_PIP_VERSION_CHECK=1
unset PYTHONPATH

library=$(find "$prefix" -name 'libcovbeam.so' -o -name 'libcovbeam.dylib' | head -n 1)
test -n "$library" || { echo "python.sh: no shared library under $prefix" >&2; exit 1; }

python3 -m venv "$work/venv"
python="$work/venv/bin/python"
"$python" -m pip install --quiet numpy build hatchling auditwheel twine

COVBEAM_LIBRARY="$library" "$python" -m build --wheel --no-isolation --outdir "$work/dist" "$repository/ffi/python" > "$work/build.log" ||
    { cat "$work/build.log"; exit 1; }
wheel=("$work"/dist/covbeam-*-py3-none-*.whl)
test "${#wheel[@]}" -eq 1
echo "$(basename "${wheel[0]}"): $(stat -c %s "${wheel[0]}") bytes"
# Its tag is what auditwheel finds in the library, and the licences those of what is linked into it.
tag=$(basename "${wheel[0]}" .whl | sed 's/.*-none-//')
"$python" -m auditwheel show "${wheel[0]}" | tr '\n' ' ' > "$work/auditwheel"
grep -q "constrains the platform tag to \"$tag\"" "$work/auditwheel" || { cat "$work/auditwheel"; exit 1; }
"$python" -m twine check --strict "${wheel[0]}" > "$work/twine" || { cat "$work/twine"; exit 1; }
"$python" -m zipfile -e "${wheel[0]}" "$work/wheel"
for licence in LICENSE-MIT LICENSE-APACHE; do
    cmp "$repository/$licence" "$work/wheel"/covbeam-*.dist-info/licenses/"$licence"
done
# What no wheel can be made of ends with one sentence: a library that is none, and sources.
refused() {
    local words="$1"
    shift
    ! "$python" -m build --no-isolation --outdir "$work/refused" "$@" "$repository/ffi/python" > "$work/refusal" 2>&1 &&
        grep -q "$words" "$work/refusal" && ! grep -q Traceback "$work/refusal" || { cat "$work/refusal"; echo "python.sh: not refused: $words" >&2; exit 1; }
}
COVBEAM_LIBRARY="$repository/README.md" refused "README.md is no shared library of Linux, macOS or Windows" --wheel
COVBEAM_LIBRARY="$library.gone" refused "where there is no file" --wheel
refused "Build wheels, in a checkout" --sdist
# A compiler without the notices of its standard library: a wheel all the same, with a summary of them.
compiler="$(cd "$repository" && rustc --print sysroot)/bin/rustc"
printf '#!/bin/sh\ncase "$*" in "--print sysroot") echo /nowhere ;; *) exec "%s" "$@" ;; esac\n' "$compiler" > "$work/distribution"
chmod +x "$work/distribution"
RUSTC="$work/distribution" COVBEAM_LIBRARY="$library" "$python" -m build --wheel --no-isolation --outdir "$work/short" "$repository/ffi/python" \
    > "$work/build.log" || { cat "$work/build.log"; exit 1; }
"$python" -m zipfile -e "$work"/short/*.whl "$work/short/wheel"
grep -q "^Rust's standard library, in short" "$work/short/wheel/covbeam/THIRD-PARTY" || { echo "python.sh: no summary of Rust's licences" >&2; exit 1; }
crates=$(sed -nE 's/^([a-z0-9_-]+) v[0-9.]+ \(.*\), [A-Z].*/\1/p' "$work/wheel/covbeam/THIRD-PARTY" | sort -u | xargs)
test "$crates" = "arbitrary-chunks arrayvec blake3 bytemuck cfg-if constant_time_eq cpufeatures crc32fast crossbeam-deque \
crossbeam-epoch crossbeam-utils either fearless_simd glam half libm log obvhs partition rayon rayon-core rdst smallvec static_assertions \
thiserror tobj zerocopy" || { echo "python.sh: THIRD-PARTY is of $crates" >&2; exit 1; }
"$python" -m pip install --quiet --no-deps "${wheel[0]}"
# From here on the library in the wheel is used, and nothing else.
unset COVBEAM_LIBRARY

cd "$work"
"$python" "$repository/tests/clients/vectors.py" "$repository/tests/vectors.txt"
COVBEAM_INCLUDE="$prefix/include" "$python" "$repository/tests/clients/test_python.py" --verbose
"$python" "$repository/tests/clients/python_cost.py"

# The oldest numpy that the wheel promises, or that this Python has.
case $("$python" -c 'import sys; print(*sys.version_info[:2], sep=".")') in
    3.10 | 3.11) oldest=1.24.4 ;;
    3.12) oldest=1.26.0 ;;
    3.13) oldest=2.1.0 ;;
    *) echo "python.sh: say here which numpy is the oldest for this Python" >&2; exit 1 ;;
esac
"$python" -m pip install --quiet "numpy==$oldest"
echo "numpy $oldest:"
"$python" "$repository/tests/clients/vectors.py" "$repository/tests/vectors.txt"
COVBEAM_INCLUDE="$prefix/include" "$python" "$repository/tests/clients/test_python.py" Arrays Objects
