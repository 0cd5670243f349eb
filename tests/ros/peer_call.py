#!/usr/bin/env python3
"""Calls a service with rclpy and prints the response as one JSON line, as ../peers/peer_call.py does.

    peer_call.py --domain 0 /auv/plant_sim/pause std_srvs/srv/SetBool --json '{"data": true}'

Exit status 1 when no answer came within --timeout seconds.
"""

import json
import sys

import ros
import arguments


def main() -> int:
    args = arguments.call(__doc__)
    with ros.node(args.domain) as node:
        try:
            print(json.dumps(ros.call(node, args.service, args.type, args.json, args.timeout)))
        except ros.NoAnswer as failure:
            print(failure, file=sys.stderr)
            return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
