#!/usr/bin/env python3
"""Publishes a message on a topic as a Cyclone DDS peer: once, or at a rate for a while.

    peer_pub.py --domain 0 /auv/depth_setpoint std_msgs/msg/Float64 --json '{"data": 0.914}'
    peer_pub.py --domain 0 /auv/depth_setpoint std_msgs/msg/Float64 --json '{"data": 0.914}' --rate 10 --duration 2

It waits for a subscriber first; exit status 1 when none came within --timeout seconds. JSON's NaN
and Infinity are taken, to try what a node does with them. Prints one line: how many were sent.
"""

import json
import sys
import time

import arguments
import ros_types
from cyclone import SETTLE_SECONDS, Peer, dds_topic_name, topic_qos, wait_matched
from cyclonedds.util import duration


def main() -> int:
    args = arguments.pub(__doc__)

    message = ros_types.from_json(args.type, args.json)
    peer = Peer(args.domain)
    writer = peer.writer(dds_topic_name(args.topic), ros_types.message(args.type), topic_qos(args.reliability))
    if not wait_matched([writer], args.timeout):
        print(f"no subscriber of {args.topic} within {args.timeout:g} s", file=sys.stderr)
        return 1

    count = max(1, round(args.rate * args.duration))
    start = time.monotonic()
    for sent in range(count):
        time.sleep(max(0.0, start + sent / args.rate - time.monotonic()))
        writer.write(message)
    if args.reliability == "reliable":
        if not writer.wait_for_acks(duration(seconds=args.timeout)):
            print(f"{args.topic}: not acknowledged within {args.timeout:g} s", file=sys.stderr)
            return 1
    else:
        time.sleep(SETTLE_SECONDS)
    print(json.dumps({"topic": args.topic, "sent": count}))
    return 0


if __name__ == "__main__":
    sys.exit(main())
