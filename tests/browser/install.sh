#!/bin/bash
# Puts axe-core, which finds what keeps people from using a page, where the tests of the pages look for it: `.venv/share/axe.min.js`
# in the repository's root, or that of a folder of your choice.
#
#     tests/browser/install.sh [FOLDER]
#
# Needs npm and openssl.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
venv=$(realpath -m "${1:-$here/../../.venv}")
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
"$here/npm.sh" axe-core 4.14.1 sha512-FHfa+lmNjQZfJz1q8wKqIDwC6DExcHt/pkjNQb09a3NPjCKg2rhu5qb2S4r76ASyFNNtuFooJpZe37OgudVGtQ== "$scratch"
mkdir -p "$venv/share"
cp "$scratch/package/axe.min.js" "$venv/share/"
