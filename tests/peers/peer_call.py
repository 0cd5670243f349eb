#!/usr/bin/env python3
"""Calls a service as a Cyclone DDS peer and prints the response as one JSON line.

    peer_call.py --domain 0 /auv/plant_sim/pause std_srvs/srv/SetBool --json '{"data": true}'

Exit status 1 when no answer came within --timeout seconds.
"""

import json
import sys

import arguments
from cyclone import Peer
from ros_service import Client, NoAnswer


def main() -> int:
    args = arguments.call(__doc__)
    try:
        print(json.dumps(Client(Peer(args.domain), args.service, args.type).call(args.json, args.timeout)))
    except NoAnswer as failure:
        print(failure, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
