#!/bin/bash
# The page of examples/web: the module's bits are the native ones, and what headless Chromium makes of the page:
# tests/clients/web.sh [PICTURE]
# With a file, a screenshot goes there, in 256 colours (needs pngquant), and errors are measured at equal time too, against more photons.
set -euo pipefail
cd "$(dirname "$0")/../.."
target="$(realpath -m "${CARGO_TARGET_DIR:-target}")"

work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT
examples/web/build.sh "$work/page"
echo "module: $(base64 -d <<< "$(sed "s/.*'\(.*\)'.*/\1/" "$work/page/module.js")" | wc -c) bytes"

cargo build --quiet --locked --release --package covbeam-web --bin native
"$target/release/native" 3 > "$work/native"
node tests/clients/web.js module "$work/page" 3 > "$work/module"
same() { cut -d ' ' -f 1,2 "$1"; }
diff <(same "$work/native") <(same "$work/module") || { echo "the module's pictures are not the native ones" >&2; exit 1; }
for method in "1 plain" "2 covbeam"; do
    line="${method%% *}"
    echo "${method#* }: $(sed -n "${line}p" "$work/native" | cut -d ' ' -f 3) s a pass natively," \
        "$(sed -n "${line}p" "$work/module" | cut -d ' ' -f 3) s in node, the same bits"
done

timeout 900 node tests/clients/web.js page "$work/page" "$work/profile" "$work/picture.png" ${1:+measured}
[ $# -eq 0 ] || pngquant 256 --force --output "$1" "$work/picture.png"
