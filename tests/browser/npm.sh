#!/bin/bash
# Unpacks a package of npm as it is served under its version and integrity; another one is refused. Nothing in it is run.
#
#     tests/browser/npm.sh PACKAGE VERSION INTEGRITY FOLDER
set -euo pipefail
package=$1 version=$2 integrity=$3
cd "$4"
npm pack --silent "$package@$version" >/dev/null
archive="$package-$version.tgz"
found="sha512-$(openssl dgst -sha512 -binary "$archive" | base64 -w0)"
[[ "$found" == "$integrity" ]] || { echo "$package $version has the integrity $found, not $integrity" >&2; exit 1; }
tar xzf "$archive"
rm "$archive"
