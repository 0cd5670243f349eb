#!/usr/bin/env python3
"""Publishes a message on a topic: once, or at a rate for a while.

    peer_pub.py --domain 0 /auv/depth_setpoint std_msgs/msg/Float64 --json '{"data": 0.914}'
    peer_pub.py --domain 0 /auv/depth_setpoint std_msgs/msg/Float64 --json '{"data": 0.914}' --rate 10 --duration 2

It waits for a subscriber first; exit status 1 when none came within --timeout seconds. JSON's NaN
and Infinity are taken, to try what a node does with them. Prints one line: how many were sent.
"""

import json
import sys
import time

import arguments
from peer import Peer


def main() -> int:
    args = arguments.pub(__doc__)
    count = max(1, round(args.rate * args.duration))

    with Peer(args.domain) as peer:
        publisher = peer.publisher(args.topic, args.type, args.reliability)
        if not publisher.wait_matched(args.timeout):
            print(f"no subscriber of {args.topic} within {args.timeout:g} s", file=sys.stderr)
            return 1
        start = time.monotonic()
        for sent in range(count):
            time.sleep(max(0.0, start + sent / args.rate - time.monotonic()))
            publisher.publish(args.json)
        if not publisher.wait_acked(args.timeout):
            print(f"{args.topic}: not acknowledged within {args.timeout:g} s", file=sys.stderr)
            return 1
    print(json.dumps({"topic": args.topic, "sent": count}))
    return 0


if __name__ == "__main__":
    sys.exit(main())
