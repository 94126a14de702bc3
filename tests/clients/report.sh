#!/bin/bash
# The page of `covbeam report` in a browser, as wide as on a laptop and as on a phone: tests/clients/report.sh BINARY [FOLDER]
# Screenshots go into the folder, if one is given.
set -euo pipefail
[ $# -ge 1 ] || { echo "usage: $0 BINARY [FOLDER]" >&2; exit 1; }
covbeam="$(realpath "$1")"
cd "$(dirname "$0")/../.."

work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT
shots="${2:-$work}"
mkdir -p "$shots"

"$covbeam" report examples/scenes/glass-ball.toml examples/scenes/shaft.toml --quick --out "$work/report" < /dev/null

browse() {
    # No name is ever resolved: nothing outside this machine can be reached, and trying it is a message on the console.
    timeout 120 chromium --headless --no-sandbox --disable-gpu --disable-background-networking --no-first-run \
        --user-data-dir="$work/profile" --host-resolver-rules='MAP * ~NOTFOUND' --allow-file-access-from-files \
        --hide-scrollbars --enable-logging=stderr "$@" < /dev/null
}

# frame PAGE WIDTH HEIGHT: a page that shows PAGE in a frame of that size, since a window cannot be as narrow as a phone, and
# writes down what is wrong with it.
frame() {
    cat > "$work/frame.html" << END
<!DOCTYPE html><meta charset="utf-8"><body style="margin:0">
<iframe src="file://$1" style="width:${2}px;height:${3}px;border:0"></iframe><pre hidden></pre>
<script>
const frame = document.querySelector('iframe');
frame.onload = () => {
    const page = frame.contentDocument, found = [];
    page.querySelectorAll('details').forEach(part => { part.open = true; });
    const root = page.documentElement;
    if (root.scrollWidth > root.clientWidth)
        found.push('sideways: ' + root.scrollWidth + ' pixels in ' + root.clientWidth);
    const pictures = [...page.images];
    const broken = pictures.filter(picture => picture.naturalWidth === 0).length;
    if (broken > 0) found.push('pictures that do not decode: ' + broken);
    if (pictures.some(picture => !picture.alt)) found.push('a picture without a text for those who cannot see it');
    for (const entry of frame.contentWindow.performance.getEntriesByType('resource'))
        if (!entry.name.startsWith('data:')) found.push('request: ' + entry.name);
    let smallest = 99;
    const texts = page.createTreeWalker(page.body, NodeFilter.SHOW_TEXT);
    while (texts.nextNode()) {
        const of = texts.currentNode.parentElement, svg = of.closest('svg');
        if (!texts.currentNode.data.trim()) continue;
        const scale = svg ? svg.getBoundingClientRect().width / svg.viewBox.baseVal.width : 1;
        smallest = Math.min(smallest, scale * parseFloat(getComputedStyle(of).fontSize));
    }
    if (smallest < 14) found.push('text of ' + smallest.toFixed(1) + ' pixels');
    const counts = 'looked at ' + pictures.length + ' pictures and ' + page.querySelectorAll('svg').length + ' plots';
    document.querySelector('pre').textContent = [counts, ...found.map(line => 'WRONG ' + line), 'END'].join('\n');
};
</script>
END
}

# look PAGE WIDTH HEIGHT: prints what is wrong, fails if anything is.
look() {
    frame "$@"
    browse --virtual-time-budget=20000 --window-size=1400,800 --dump-dom "file://$work/frame.html" \
        2> "$work/log" | sed -n '/<pre hidden/,/<\/pre>/p' > "$work/found"
    grep -q 'END</pre>' "$work/found" || { echo "the page was not looked at"; cat "$work/log"; return 1; }
    ! { grep 'WRONG' "$work/found" || true; grep 'CONSOLE' "$work/log" || true; } | grep .
}

page="$work/report/report.html"
for size in "1366 768" "390 844"; do
    read -r width height <<< "$size"
    look "$page" "$width" "$height" || { echo "report.html, $width pixels wide: see above" >&2; exit 1; }
    frame "$page" "$width" 6000
    browse --window-size="$((width < 500 ? 500 : width)),6000" --screenshot="$shots/report-$width.png" \
        "file://$work/frame.html" > /dev/null 2>&1
    test -s "$shots/report-$width.png"
    echo "report.html, $width pixels wide: $(grep -o 'looked at .*' "$work/found")"
done

# What must be noticed: each of these, put into the page, is.
broken() {
    local says="$1" markup="$2"
    sed "s|<h1>|$markup<h1>|" "$page" > "$work/broken.html"
    if look "$work/broken.html" 390 844 > "$work/said"; then
        echo "not noticed: $markup" >&2
        exit 1
    fi
    grep -q "$says" "$work/said" || { echo "noticed as something else: $markup" >&2; cat "$work/said" >&2; exit 1; }
}
broken 'CONSOLE.*a message' "<script>console.warn('a message')</script>"
broken 'CONSOLE.*Uncaught' "<script>nothing.there()</script>"
broken 'request: https' '<img alt="x" src="https://example.invalid/x.png">'
broken 'request: https' '<p style="background: url(https://example.invalid/x.png)">x</p>'
broken 'do not decode: 1' '<img alt="x" src="data:image/png;base64,iVBORw0KGgo=">'
broken 'sideways: 2' '<div style="width: 2000px">x</div>'
broken 'text of 9.0' '<p style="font-size: 9px">x</p>'
broken 'cannot see' '<img src="data:image/gif;base64,R0lGODlhAQABAAAAACwAAAAAAQABAAAC">'
echo "eight broken pages: noticed"
