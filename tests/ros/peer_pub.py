#!/usr/bin/env python3
"""Publishes a message with rclpy: once, or at a rate for a while, as ../peers/peer_pub.py does.

    peer_pub.py --domain 0 /auv/depth_setpoint std_msgs/msg/Float64 --json '{"data": 0.914}'

It waits for a subscriber first; exit status 1 when none came within --timeout seconds. Prints one line: how many were sent.
"""

import json
import sys
import time

import ros
import arguments
from rclpy.duration import Duration


def main() -> int:
    args = arguments.pub(__doc__)

    kind = ros.interface(args.type)
    message = ros.fill(kind(), args.json)
    count = max(1, round(args.rate * args.duration))
    with ros.node(args.domain) as node:
        publisher = node.create_publisher(kind, args.topic, ros.topic_qos(args.reliability))
        if not ros.spin_until(node, lambda: publisher.get_subscription_count() > 0, args.timeout):
            print(f"no subscriber of {args.topic} within {args.timeout:g} s", file=sys.stderr)
            return 1
        start = time.monotonic()
        for sent in range(count):
            time.sleep(max(0.0, start + sent / args.rate - time.monotonic()))
            publisher.publish(message)
        if not publisher.wait_for_all_acked(Duration(seconds=args.timeout)):
            print(f"{args.topic}: not acknowledged within {args.timeout:g} s", file=sys.stderr)
            return 1
    print(json.dumps({"topic": args.topic, "sent": count}))
    return 0


if __name__ == "__main__":
    sys.exit(main())
