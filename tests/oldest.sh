#!/usr/bin/env bash
# The oldest Rusts that Cargo.toml promises, checked with Debian's Rust 1.85, which is taken beside the one installed: tests/oldest.sh [FOLDER]
# 1. Package covbeam without its feature bvh, and the program without std, build with it and pass their tests.
# 2. The rest promises a Rust that no package is at hand of. Clippy's incompatible_msrv, which is on by default, names what the standard library
#    got later. Here 1.85 reads every source and names syntax that it does not know, other than what came since and is listed below.
# Not seen: what 1.89's compiler refuses or infers otherwise though the syntax is old, and modules that only other systems have.
set -euo pipefail
cd "$(dirname "$0")/.."

# What is syntax since: let chains, 1.88. What else Rust has had by 1.89 may be added, and nothing later.
since=let_chains

if [ $# -ge 1 ]; then
    work="$(realpath "$1")"
else
    work="$(mktemp -d)"
    trap 'rm -rf "$work"' EXIT
fi
fail() { echo "oldest: $*" >&2; exit 1; }

oldest="$(sed -n 's/^rust-version = "\(.*\)"/\1/p' core/Cargo.toml)"
if [ ! -e "$work/usr/bin/rustc" ]; then
    version="$(apt-cache madison rustc-web | awk -v oldest="$oldest." 'index($3, oldest) == 1 { print $3; exit }')"
    [ -n "$version" ] || fail "Debian's package index has no rustc-web of version $oldest: apt-get update, or another source of it"
    # The compiler with its libraries, and cargo's.
    packages=("rustc-web=$version" "cargo-web=$version" "libstd-rust-web-$oldest=$version" "libstd-rust-web-dev=$version"
        libllvm19 libhttp-parser2.9 libpcre3 libssh2-1)
    (cd "$work" && apt-get download -qq "${packages[@]}") > "$work/apt" 2>&1 || { cat "$work/apt"; fail "no download (above)"; }
    for package in "$work"/*.deb; do
        dpkg -x "$package" "$work"
    done
fi
machine="$(gcc -dumpmachine)"
export LD_LIBRARY_PATH="$work/usr/lib/$machine:$work/lib/$machine" RUSTC="$work/usr/bin/rustc" RUSTDOC="$work/usr/bin/rustdoc"
target="$(realpath -m "${CARGO_TARGET_DIR:-target}")"
old() { CARGO_TARGET_DIR="$target/oldest" "$work/usr/bin/cargo" "$@"; }
[[ "$(old --version) $("$RUSTC" --version)" = "cargo $oldest."*" rustc $oldest."* ]] || fail "this is no Rust $oldest: $("$RUSTC" --version)"

old test --quiet --locked --package covbeam 2>&1 < /dev/null
(cd tests/bare-metal && old check --quiet --locked)

# unknown ROOT [OPTION...]: what 1.85 says of syntax in a source and its modules. Without the crates that they use most names are unknown to it,
# macros of property tests too; what these take is not read.
unknown() {
    { RUSTC_BOOTSTRAP=1 "$RUSTC" --edition 2024 --test -Zcrate-attr="feature($since)" --error-format short --emit metadata -o "$work/none" "$@" 2>&1 ||
        true; } | grep -E '^[^ ]+: error(\[E0658\])?: ' |
        grep -vE ': (use of unstable library feature|cannot find (attribute|derive macro|macro `prop(test|_oneof))|environment variable)' || true
}
# What must be found, or this sees nothing: syntax of 1.95, and what is none.
for planted in 'fn f(x: Option<u8>) { match x { _ if let Some(_) = x => {} _ => {} } }' 'fn f() { let x = }'; do
    echo "$planted" > "$work/planted.rs"
    [ -n "$(unknown "$work/planted.rs")" ] || fail "not seen: $planted"
done
echo 'fn f(x: Option<u8>) { if let Some(y) = x && y > 1 { crate_of_another::g() } }' > "$work/fine.rs"
[ -z "$(unknown "$work/fine.rs")" ] || fail "a let chain is no longer fine"

# Roots of all targets, behind the features of their packages.
roots="$(old metadata --locked --no-deps --format-version 1 | python3 -c '
import json, sys
for package in json.load(sys.stdin)["packages"]:
    features = "".join(f"\t--cfg\tfeature=\"{feature}\"" for feature in package["features"])
    for target in package["targets"]:
        print(target["src_path"] + features)
')"
count=0
while IFS=$'\t' read -ra root; do
    found="$(unknown "${root[@]}")"
    [ -z "$found" ] || { echo "$found"; fail "newer than $since and Rust $oldest (above)"; }
    count=$((count + 1))
done <<< "$roots"
[ "$count" -ge 20 ] || fail "only $count roots"
echo "$oldest: covbeam's tests; syntax of $count targets"
