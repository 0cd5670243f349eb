#!/usr/bin/env python3
"""Lists a domain's nodes as `ros2 node list` does, one JSON list each time they are others, for --timeout seconds.

    peer_nodes.py --domain 0
"""

import json
import sys

import ros
import arguments


def main() -> int:
    args = arguments.parser(__doc__).parse_args()
    seen = None

    with ros.node(args.domain) as node:

        def tell() -> bool:
            nonlocal seen
            nodes = sorted(f"{space.rstrip('/')}/{name}" for name, space in node.get_node_names_and_namespaces())
            if nodes != seen:
                print(json.dumps(nodes), flush=True)
                seen = nodes
            return False

        ros.spin_until(node, tell, args.timeout)
    return 0


if __name__ == "__main__":
    sys.exit(main())
