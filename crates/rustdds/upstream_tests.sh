#!/bin/bash
# Runs RustDDS' own tests, with those that the patches add, on the patched sources:
#
#     crates/rustdds/upstream_tests.sh [ARGUMENT OF cargo test ...]
#
# The published crate is taken from where `cargo fetch` has put it. Loopback only.
set -euo pipefail
cd "$(dirname "$0")"

published=$(cargo metadata --format-version 1 --offline --manifest-path "$(find ../../target -path '*/out/published/Cargo.toml' | head -n 1)" |
    python3 -c 'import json, sys; print(next(p["manifest_path"] for p in json.load(sys.stdin)["packages"] if p["name"] == "rustdds"))')
work=$(mktemp --directory)
trap 'rm -rf "$work"' EXIT
cp -r "$(dirname "$published")/." "$work"
for patch in patches/*.patch; do
    patch --directory "$work" --strip 1 --quiet --fuzz 0 <"$patch"
done
cd "$work"
CARGO_TARGET_DIR=${CARGO_TARGET_DIR:-$work/target} cargo test --lib "$@"
