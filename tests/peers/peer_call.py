#!/usr/bin/env python3
"""Calls a service and prints the response as one JSON line.

    peer_call.py --domain 0 /auv/plant_sim/pause std_srvs/srv/SetBool --json '{"data": true}'

Exit status 1 when no answer came within --timeout seconds.
"""

import json
import sys

import arguments
from peer import NoAnswer, Peer


def main() -> int:
    args = arguments.call(__doc__)
    with Peer(args.domain) as peer:
        try:
            print(json.dumps(peer.call(args.service, args.type, args.json, args.timeout)))
        except NoAnswer as failure:
            print(failure, file=sys.stderr)
            return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
