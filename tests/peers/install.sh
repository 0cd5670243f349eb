#!/bin/bash
# Makes the Python of the foreign peers and readers: `.venv` in the repository's root, or a folder of your choice.
#
#     tests/peers/install.sh [FOLDER]
#
# Cyclone DDS 0.10.5, of the series that ROS 2 Jazzy ships, has no wheel for Debian 12's Python 3.11: it is built
# here against Debian's Cyclone DDS. Its build looks for `include`, `bin` and `lib` in one folder, which Debian
# does not have; such a folder of links is made beside the packages, where the module finds the library later.
#
# Needs the packages of apt-packages.txt.
set -euo pipefail

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
venv=$(realpath -m "${1:-$here/../../.venv}")

/usr/bin/python3 -m venv "$venv"

cyclone=$venv/cyclonedds
libraries=/usr/lib/$(gcc -print-multiarch)
if [[ ! -e $libraries/libddsc.so ]]; then
    echo "$libraries/libddsc.so is not there: install Debian's cyclonedds-dev" >&2
    exit 1
fi
mkdir -p "$cyclone/lib"
ln -sfn /usr/include "$cyclone/include"
ln -sfn /usr/bin "$cyclone/bin"
ln -sf "$libraries"/libddsc.so "$libraries"/libcycloneddsidl.so "$cyclone/lib/"

# As a constraint the file also pins what builds the module. A module built for another folder, as pip may
# have kept one, would look for its library there: no cache.
export CYCLONEDDS_HOME=$cyclone PIP_CONSTRAINT=$here/requirements.txt PIP_DISABLE_PIP_VERSION_CHECK=1
"$venv/bin/pip" install --quiet --no-cache-dir --requirement "$here/requirements.txt"
"$venv/bin/python" -c 'import cyclonedds.domain'
