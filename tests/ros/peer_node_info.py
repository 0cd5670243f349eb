#!/usr/bin/env python3
"""What `ros2 node info NODE` shows, one JSON object: publishers, subscribers, service servers, action servers, each name with its type.

    peer_node_info.py --domain 0 /auv/plant_sim

Ends as soon as the node is discovered and nothing changed for a second, otherwise after --timeout seconds with exit status 1.
The object also has `nodes`, all of the domain, as `ros2 node list` shows them.
"""

import json
import sys
import time

import ros
import arguments
from rclpy.action import get_action_server_names_and_types_by_node
from rclpy.node import NodeNameNonExistentError

QUIET = 1.0  # s


def info(node, name: str, namespace: str) -> dict:
    def listed(names_and_types) -> dict:
        return {topic: types[0] for topic, types in names_and_types}

    nodes = [f"{space.rstrip('/')}/{one}" for one, space in node.get_node_names_and_namespaces()]
    return {
        "nodes": sorted(nodes),
        "publishers": listed(node.get_publisher_names_and_types_by_node(name, namespace)),
        "subscribers": listed(node.get_subscriber_names_and_types_by_node(name, namespace)),
        "services": listed(node.get_service_names_and_types_by_node(name, namespace)),
        "actions": listed(get_action_server_names_and_types_by_node(node, name, namespace)),
    }


def main() -> int:
    parser = arguments.parser(__doc__)
    parser.add_argument("node")
    args = parser.parse_args()
    namespace, _, name = args.node.rpartition("/")

    with ros.node(args.domain) as node:
        seen, since = None, time.monotonic()

        def settled() -> bool:
            nonlocal seen, since
            try:
                now = info(node, name, namespace or "/")
            except NodeNameNonExistentError:
                now = None
            if now != seen:
                seen, since = now, time.monotonic()
            return seen is not None and time.monotonic() - since >= QUIET

        complete = ros.spin_until(node, settled, args.timeout)
    if complete:
        print(json.dumps(seen))
    return 0 if complete else 1


if __name__ == "__main__":
    sys.exit(main())
