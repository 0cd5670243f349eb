#!/usr/bin/env python3
"""Subscribes to a topic and prints messages, one JSON line each.

    peer_echo.py --domain 0 /auv/state planesman_msgs/msg/VehicleState --count 3

Exit status 1 when fewer than --count messages came within --timeout seconds.
"""

import json
import sys

import arguments
from peer import Peer


def main() -> int:
    args = arguments.echo(__doc__)
    received = 0

    with Peer(args.domain) as peer:
        messages = peer.subscribe(args.topic, args.type, args.reliability, args.durability)

        def enough() -> bool:
            nonlocal received
            for message in messages.take(args.count - received):
                print(json.dumps(message), flush=True)
                received += 1
            return received >= args.count

        if peer.wait_until(enough, args.timeout):
            return 0
    print(f"{args.topic}: {received} of {args.count} messages within {args.timeout:g} s", file=sys.stderr)
    return 1


if __name__ == "__main__":
    sys.exit(main())
