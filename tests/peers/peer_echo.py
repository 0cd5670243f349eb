#!/usr/bin/env python3
"""Subscribes to a topic as a Cyclone DDS peer and prints messages, one JSON line each.

    peer_echo.py --domain 0 /auv/state planesman_msgs/msg/VehicleState --count 3

Exit status 1 when fewer than --count messages came within --timeout seconds.
"""

import json
import sys

import arguments
import ros_types
from cyclone import Peer, dds_topic_name, topic_qos, wait_until


def main() -> int:
    args = arguments.echo(__doc__)

    peer = Peer(args.domain)
    reader = peer.reader(
        dds_topic_name(args.topic), ros_types.message(args.type), topic_qos(args.reliability, args.durability)
    )
    received = 0

    def enough() -> bool:
        nonlocal received
        for sample in reader.take(N=args.count - received):
            if sample.sample_info.valid_data:
                print(json.dumps(ros_types.to_json(args.type, sample)), flush=True)
                received += 1
        return received >= args.count

    if wait_until(enough, args.timeout, interval=0.005):
        return 0
    print(f"{args.topic}: {received} of {args.count} messages within {args.timeout:g} s", file=sys.stderr)
    return 1


if __name__ == "__main__":
    sys.exit(main())
