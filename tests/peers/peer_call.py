#!/usr/bin/env python3
"""Calls a service as a Cyclone DDS peer and prints the response as one JSON line.

    peer_call.py --domain 0 /auv/plant_sim/pause std_srvs/srv/SetBool --json '{"data": true}'

Exit status 1 when no answer came within --timeout seconds.
"""

import argparse
import json
import sys

from cyclone import Peer
from ros_service import Client, NoAnswer


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--domain", type=int, required=True)
    parser.add_argument("service")
    parser.add_argument("type", help="package/srv/Type")
    parser.add_argument("--json", default="{}", help="the request; fields left out are zero")
    parser.add_argument("--timeout", type=float, default=10.0, help="s (default %(default)s)")
    args = parser.parse_args()
    try:
        print(json.dumps(Client(Peer(args.domain), args.service, args.type).call(json.loads(args.json), args.timeout)))
    except NoAnswer as failure:
        print(failure, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
