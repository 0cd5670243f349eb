#!/usr/bin/env python3
"""Lists a domain's nodes and topics as rclpy discovers them, one JSON line per endpoint, as ../peers/peer_topics.py does.

    peer_topics.py --domain 0 --expect publication:/auv/state=planesman_msgs/msg/VehicleState

Ends as soon as every expected endpoint was seen and nothing changed for --quiet seconds, otherwise after --timeout
seconds with exit status 1. Every line: kind, topic, type, node, reliability, durability, type_hash.
"""

import json
import sys
import time

import ros
import arguments

POLICIES = {
    "RELIABLE": "Reliable",
    "BEST_EFFORT": "BestEffort",
    "VOLATILE": "Volatile",
    "TRANSIENT_LOCAL": "TransientLocal",
}


def endpoints(node) -> list[dict]:
    """All publications and subscriptions but this node's own."""
    found = []
    for topic, _ in node.get_topic_names_and_types():
        for kind, infos in (
            ("publication", node.get_publishers_info_by_topic(topic)),
            ("subscription", node.get_subscriptions_info_by_topic(topic)),
        ):
            for info in infos:
                full_name = f"{info.node_namespace.rstrip('/')}/{info.node_name}"
                if full_name != "/peer":
                    found.append(
                        {
                            "kind": kind,
                            "topic": topic,
                            "type": info.topic_type,
                            "node": full_name,
                            "reliability": POLICIES.get(info.qos_profile.reliability.name),
                            "durability": POLICIES.get(info.qos_profile.durability.name),
                            "type_hash": str(info.topic_type_hash),
                        }
                    )
    return found


def main() -> int:
    args = arguments.topics(__doc__)
    expected = set(args.expect)

    with ros.node(args.domain) as node:
        seen, since, missing = [], time.monotonic(), expected

        def all_seen() -> bool:
            nonlocal seen, since, missing
            now = endpoints(node)
            if now != seen:
                seen, since = now, time.monotonic()
            missing = expected - {(line["kind"], line["topic"], line["type"]) for line in seen}
            return bool(expected) and not missing and time.monotonic() - since >= args.quiet

        complete = ros.spin_until(node, all_seen, args.timeout)
    for line in seen:
        print(json.dumps(line))
    for kind, topic, type_name in sorted(missing):
        print(f"not discovered within {args.timeout:g} s: {kind} of {topic}, {type_name}", file=sys.stderr)
    return 0 if complete or not expected else 1


if __name__ == "__main__":
    sys.exit(main())
