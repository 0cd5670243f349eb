#!/usr/bin/env python3
"""Publishes a message with rclpy: once, or at a rate for a while, as ../peers/peer_pub.py does.

    peer_pub.py --domain 0 /auv/depth_setpoint std_msgs/msg/Float64 --json '{"data": 0.914}'

It waits for subscribers first, until no more come; exit status 1 when none came within --timeout seconds. Prints one line:
how many were sent.
"""

import json
import sys
import time

import ros
import arguments
from rclpy.duration import Duration

SETTLE_SECONDS = 0.5
"""How long the subscribers have to be the same."""


def main() -> int:
    args = arguments.pub(__doc__)

    kind = ros.interface(args.type)
    message = ros.fill(kind(), args.json)
    messages = max(1, round(args.rate * args.duration))
    with ros.node(args.domain) as node:
        publisher = node.create_publisher(kind, args.topic, ros.topic_qos(args.reliability))
        count, since = 0, time.monotonic()

        def all_match() -> bool:
            nonlocal count, since
            if publisher.get_subscription_count() != count:
                count, since = publisher.get_subscription_count(), time.monotonic()
            return count > 0 and time.monotonic() - since >= SETTLE_SECONDS

        if not ros.spin_until(node, all_match, args.timeout):
            print(f"no subscriber of {args.topic} within {args.timeout:g} s", file=sys.stderr)
            return 1
        start = time.monotonic()
        for sent in range(messages):
            time.sleep(max(0.0, start + sent / args.rate - time.monotonic()))
            publisher.publish(message)
        if not publisher.wait_for_all_acked(Duration(seconds=args.timeout)):
            print(f"{args.topic}: not acknowledged within {args.timeout:g} s", file=sys.stderr)
            return 1
    print(json.dumps({"topic": args.topic, "sent": messages}))
    return 0


if __name__ == "__main__":
    sys.exit(main())
