#!/usr/bin/env bash
# What would go to crates.io: packed as `cargo publish` packs it, then unpacked, and libraries, programs and tests of all packages compile there,
# with nothing of this repository around them: tests/packages.sh
set -euo pipefail
cd "$(dirname "$0")/.."

target="$(realpath -m "${CARGO_TARGET_DIR:-target}")"
work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT
fail() { echo "packages: $*" >&2; exit 1; }

export CARGO_TARGET_DIR="$target"
version="$(sed -n 's/^version = "\(.*\)"/\1/p' Cargo.toml)"
names=(covbeam covbeam-geometry covbeam-session covbeam-render)
cargo package --quiet --locked --no-verify --allow-dirty "${names[@]/#/--package=}" > "$work/log" 2>&1 || { cat "$work/log"; fail "cargo package refuses (above)"; }
{
    echo '[workspace]'
    echo 'members = ["*-[0-9]*"]'
    echo 'resolver = "3"'
    echo '[patch.crates-io]'
    for name in "${names[@]}"; do
        echo "$name = { path = \"$name-$version\" }"
    done
} > "$work/Cargo.toml"
for name in "${names[@]}"; do
    # With the time of now: cargo must see that they are new, wherever they were checked before.
    tar -xmf "$target/package/$name-$version.crate" -C "$work"
    for file in README.md LICENSE-MIT LICENSE-APACHE; do
        [ -f "$work/$name-$version/$file" ] || fail "$name has no $file"
    done
done
# The versions of what they need are those that the tests here have been through.
cp Cargo.lock "$work"
(cd "$work" && CARGO_TARGET_DIR="$target/packages" cargo check --quiet --workspace --all-targets --all-features) || fail "a package lacks something (above)"
echo "packages: $(cd "$target/package" && stat -c '%n %s' "${names[@]/%/-$version.crate}" | xargs)"
