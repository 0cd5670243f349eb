#!/bin/bash
# Runs a command in a network namespace of its own, whose only interface is a loopback with multicast:
#
#     tests/netns.sh COMMAND [ARGUMENT...]
#
# There any number of DDS participants find each other by multicast, and nothing they send leaves the
# namespace. (A usual `lo` lacks multicast: RustDDS then finds only the first twelve, by unicast.)
# The command replaces this script, so signals and the exit status are its own, and the namespace goes
# when its last process does. Another process joins with `nsenter --net --target PID COMMAND`.
#
# Needs util-linux's `unshare`, iproute2's `ip`, and root or unprivileged user namespaces.
# Exit status 125: the namespace could not be made.
set -euo pipefail

if (($# == 0)); then
    sed -n '2,11s/^# \{0,1\}//p' "$0" >&2
    exit 125
fi

# shellcheck disable=SC2016  # the inner shell expands "$@"
inside='
    ip link set lo up multicast on && ip route add 224.0.0.0/4 dev lo || exit 125
    exec "$@"'

as_root=()
((EUID == 0)) || as_root=(--map-root-user)
if ! unshare "${as_root[@]}" --net true; then
    exit 125
fi
exec unshare "${as_root[@]}" --net bash -c "$inside" netns "$@"
