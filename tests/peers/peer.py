"""A peer of the loop on Cyclone DDS or on ROS 2's rclpy, whichever this Python has; messages are JSON objects for both.

    with Peer(domain) as peer:
        messages = peer.subscribe("/auv/state", "planesman_msgs/msg/VehicleState")
        peer.wait_until(lambda: messages.take(1), timeout=5.0)

`Peer.subscribe(topic, type, reliability, durability)` has `take(count)`; `Peer.publisher(topic, type, reliability)` has
`wait_matched(timeout)`, `publish(message)` and `wait_acked(timeout)`; `Peer.call(service, type, request, timeout)` returns the response or
raises NoAnswer; `Peer.wait_until(condition, timeout)` serves callbacks meanwhile.
"""

import importlib.util
import sys
from pathlib import Path

if importlib.util.find_spec("rclpy"):
    sys.path.append(str(Path(__file__).resolve().parent.parent / "ros"))
    from ros import NoAnswer, Peer
else:
    from cyclone_peer import NoAnswer, Peer

__all__ = ["NoAnswer", "Peer"]
