#!/bin/bash
# Runs RustDDS' own tests, with those that the patches add, on the patched sources:
#
#     crates/ros/rustdds/upstream_tests.sh [ARGUMENT OF cargo test ...]
#
# The published crate is taken from where building this crate has put it. Loopback only.
set -euo pipefail
cd "$(dirname "$0")"

version=$(sed -n 's/^version = "\(.*\)"/\1/p' Cargo.toml)
published=$(find "${CARGO_HOME:-$HOME/.cargo}/registry/src" -maxdepth 2 -name "rustdds-$version" | head -n 1)
[[ -n $published ]] || { echo "rustdds $version is not in Cargo's registry: build the workspace first" >&2; exit 1; }
work=$(mktemp --directory)
trap 'rm -rf "$work"' EXIT
cp -r "$published/." "$work"
for patch in patches/*.patch; do
    patch --directory "$work" --strip 1 --quiet --fuzz 0 <"$patch"
done
cd "$work"
# What patch 59 needs of nix.
sed -i '/^\[target."cfg(unix)".dependencies.nix\]/,/^]/ s/"net",/"net", "poll", "signal",/' Cargo.toml
CARGO_TARGET_DIR=${CARGO_TARGET_DIR:-$work/target} cargo test --lib "$@"
