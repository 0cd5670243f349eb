#!/usr/bin/env python3
"""Calls a service with rclpy and prints the response as one JSON line, as ../peers/peer_call.py does.

    peer_call.py --domain 0 /auv/plant_sim/pause std_srvs/srv/SetBool --json '{"data": true}'

Exit status 1 when no answer came within --timeout seconds.
"""

import argparse
import json
import sys

import ros


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--domain", type=int, required=True)
    parser.add_argument("service")
    parser.add_argument("type", help="package/srv/Type")
    parser.add_argument("--json", default="{}", help="the request; fields left out are zero")
    parser.add_argument("--timeout", type=float, default=10.0, help="s (default %(default)s)")
    args = parser.parse_args()
    with ros.node(args.domain) as node:
        try:
            print(json.dumps(ros.call(node, args.service, args.type, json.loads(args.json), args.timeout)))
        except ros.NoAnswer as failure:
            print(failure, file=sys.stderr)
            return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
