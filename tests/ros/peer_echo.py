#!/usr/bin/env python3
"""Subscribes to a topic with rclpy and prints messages, one JSON line each, as ../peers/peer_echo.py does.

    peer_echo.py --domain 0 /auv/state planesman_msgs/msg/VehicleState --count 3

Exit status 1 when fewer than --count messages came within --timeout seconds.
"""

import json
import sys

import ros
import arguments


def main() -> int:
    args = arguments.echo(__doc__)
    received = 0

    def show(message) -> None:
        nonlocal received
        if received < args.count:
            print(json.dumps(ros.to_json(message)), flush=True)
            received += 1

    with ros.node(args.domain) as node:
        node.create_subscription(
            ros.interface(args.type), args.topic, show, ros.topic_qos(args.reliability, args.durability)
        )
        if ros.spin_until(node, lambda: received >= args.count, args.timeout):
            return 0
    print(f"{args.topic}: {received} of {args.count} messages within {args.timeout:g} s", file=sys.stderr)
    return 1


if __name__ == "__main__":
    sys.exit(main())
