#!/usr/bin/env python3
"""Lists the topics of a domain as a Cyclone DDS peer discovers them, one JSON line per endpoint.

    peer_topics.py --domain 0 --expect publication:/auv/state=planesman_msgs/msg/VehicleState

Ends as soon as every expected endpoint was seen and nothing new came for --quiet seconds, otherwise after --timeout
seconds with exit status 1. Every line: kind, topic, type, reliability, durability, type_hash (null if not told).
"""

import json
import re
import sys
import time

import arguments
from cyclonedds.builtin import (
    BuiltinDataReader,
    BuiltinTopicDcpsPublication,
    BuiltinTopicDcpsSubscription,
)
from cyclonedds.core import InstanceState, Policy, Qos, ReadCondition, SampleState, ViewState

import ros_types
from cyclone import Peer, ros_topic_name, wait_until


def policy_name(qos: Qos, kind) -> str | None:
    """The name of the policy of a kind in `qos`, such as `Reliable` of Policy.Reliability."""
    return type(qos[kind]).__name__.rsplit(".", 1)[-1] if kind in qos else None


def type_hash(qos: Qos) -> str | None:
    """The RIHS01 hash that a Jazzy endpoint tells in its user data, `typehash=RIHS01_<hex>;`."""
    if Policy.Userdata not in qos:
        return None
    found = re.search(rb"typehash=([^;]*);", qos[Policy.Userdata].data)
    return found.group(1).decode("ascii", "replace") if found else None


def describe(kind: str, endpoint) -> dict:
    """What the endpoint tells about itself, in ROS terms; services keep their DDS topic name."""
    return {
        "kind": kind,
        "topic": ros_topic_name(endpoint.topic_name) or endpoint.topic_name,
        "type": ros_types.ros_type_name(endpoint.type_name),
        "reliability": policy_name(endpoint.qos, Policy.Reliability),
        "durability": policy_name(endpoint.qos, Policy.Durability),
        "type_hash": type_hash(endpoint.qos),
    }


def main() -> int:
    args = arguments.topics(__doc__)

    peer = Peer(args.domain)
    missing = set(args.expect)
    readers = {
        "publication": BuiltinDataReader(peer.participant, BuiltinTopicDcpsPublication),
        "subscription": BuiltinDataReader(peer.participant, BuiltinTopicDcpsSubscription),
    }
    alive = {
        kind: ReadCondition(reader, ViewState.Any | SampleState.Any | InstanceState.Alive)
        for kind, reader in readers.items()
    }

    latest = time.monotonic()

    def all_seen() -> bool:
        nonlocal latest
        for kind, reader in readers.items():
            for endpoint in reader.take(N=100, condition=alive[kind]):
                if endpoint.topic_name.startswith("DCPS"):  # this reader's own
                    continue
                line = describe(kind, endpoint)
                latest = time.monotonic()
                print(json.dumps(line), flush=True)
                missing.discard((line["kind"], line["topic"], line["type"]))
        return bool(args.expect) and not missing and time.monotonic() - latest >= args.quiet

    seen = wait_until(all_seen, args.timeout)
    for kind, topic, type_name in sorted(missing):
        print(f"not discovered within {args.timeout:g} s: {kind} of {topic}, {type_name}", file=sys.stderr)
    return 0 if seen or not args.expect else 1


if __name__ == "__main__":
    sys.exit(main())
