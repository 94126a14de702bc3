#!/usr/bin/env bash
# The extension for Blender as an artist gets it: zip built, accepted by Blender's own tool, and all its tests in two versions of Blender.
#   tests/clients/blender.sh [--fetch]     --fetch: makes the environments alone
# Blender is its bpy package, in environments of its own (350 MB each); BLENDER_VENVS names a folder that has them, as bpy-VERSION, or gets them.
set -euo pipefail

repository="$(realpath "$(dirname "$0")/../..")"
versions=(5.0.1 4.2.23)
work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT
export PYTHONDONTWRITEBYTECODE=1 PIP_DISABLE_PIP_VERSION_CHECK=1
unset PYTHONPATH COVBEAM_LIBRARY

fail() { echo "blender: $*" >&2; exit 1; }
# shellcheck source=tests/clients/beside.sh
. "$repository/tests/clients/beside.sh"

python="$(python3 -c 'import sys; print(sys.version_info[0], sys.version_info[1], sep=".")')"
[ "$python" = 3.11 ] || fail "bpy ${versions[*]} is for Python 3.11, and python3 is $python"

# environment VERSION: makes the environment of a version.
environment() {
    python3 -m venv "$venvs/bpy-$1"
    "$venvs/bpy-$1/bin/pip" install --quiet "bpy==$1"
}

venvs="${BLENDER_VENVS:-$work}"
jobs=()
for version in "${versions[@]}"; do
    if [ ! -e "$venvs/bpy-$version" ]; then
        environment "$version" > "$work/pip-$version" 2>&1 &
        jobs+=("$! $version")
    fi
done

# fetched: waits until all environments are there.
fetched() {
    local job
    for job in "${jobs[@]}"; do
        wait "${job% *}" || { cat "$work/pip-${job#* }"; fail "bpy ${job#* } cannot be installed (above)"; }
    done
}
if [ "${1:-}" = --fetch ]; then
    fetched
    exit
fi

# Meanwhile, the zip.
python3 -m venv "$work/build"
"$work/build/bin/pip" install --quiet hatchling
"$work/build/bin/python" "$repository/examples/blender/build.py" --output "$work"
zip=("$work"/covbeam-*.zip)
# What the extension brings: for the tests that do not install it.
"$work/build/bin/python" -m zipfile -e "${zip[0]}" "$work/zip"
"$work/build/bin/pip" install --quiet --no-deps --target "$work/site" "$work"/zip/wheels/*.whl

fetched

# Once is enough for what does not depend on Blender, and for the long comparison of brightness with Cycles.
once=" test_host.py test_host_hard.py test_session.py test_calibration.py "
# What takes longest begins first, so that nothing long is left to the end. What measures time, and waits most of it, comes last.
long=(test_calibration.py test_export_sky.py test_host_hard.py test_export_smoke.py test_export_vdb.py test_export_density.py test_host.py)
timed=(test_robustness.py test_session.py test_engine.py test_viewport.py test_view3d.py test_export.py)

# try VERSION TEST: runs it, and tells what has come of it.
try() {
    local log="$work/log-$1-$2" ran
    PYTHONPATH="$work/site" COVBEAM_ZIP="${zip[0]}" "$venvs/bpy-$1/bin/python" -X faulthandler "$2" > "$log" 2>&1 < /dev/null ||
        { cat "$log"; fail "$2 fails in Blender $1 (above)"; }
    # A program that ends early, without its tests, is no success.
    ran="$(grep -E '^Ran [1-9][0-9]* tests? in' "$log")" || { cat "$log"; fail "$2 ran no test in Blender $1 (above)"; }
    echo "blender $1: $2: $ran"
    grep -E '^(figures|20 renders|cancelled): ' "$log" || true
}

cd "$repository/examples/blender/tests"
for version in "${versions[@]}"; do
    "$venvs/bpy-$version/bin/python" -c 'import bpy' || fail "bpy $version cannot be imported (above)"
done
others=()
for test in test_*.py; do
    [[ " ${long[*]} ${timed[*]} " = *" $test "* ]] || others+=("$test")
done
for test in "${long[@]}" "${others[@]}" "${timed[@]}"; do
    for version in "${versions[@]}"; do
        if [ "$version" != "${versions[0]}" ] && [[ "$once" = *" $test "* ]]; then continue; fi
        beside "$test in Blender $version" try "$version" "$test"
    done
done
joined || fail "tests have failed (above)"
