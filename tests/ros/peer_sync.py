#!/usr/bin/env python3
"""Brings messages of several topics together by their stamps, as the synchronizers of message_filters do, of which there is
no wheel.

    peer_sync.py --domain 0 --timeout 20 --sets 40

Exactly: `/auv/state`, `/auv/plane_motion` and `/auv/imu` of one stamp. Approximately: `/auv/imu` with a sensor of this
program's own, stamped now by its clock 20 times a second, within 50 ms.

Prints one line: the sets found of each kind, once each has --sets of them. Exit status 1 when they do not come in time.
"""

import json
import sys
from collections import deque

import ros
import arguments
from planesman_msgs.msg import PlaneMotion, VehicleState
from rclpy.qos import qos_profile_sensor_data
from rclpy.time import Time
from sensor_msgs.msg import Imu

QUEUE = 40
"""Messages that wait on each topic."""

TICK = 50_000_000
"""ns"""


class Synchronizer:
    """Sets of one stamp from each source, no two of them further apart than `slop` ns."""

    def __init__(self, sources: list[str], slop: int):
        self.sets = 0
        self._slop = slop
        self._waiting = {source: deque(maxlen=QUEUE) for source in sources}

    def add(self, source: str, stamp: int) -> None:
        self._waiting[source].append(stamp)
        nearest = [min(queue, key=lambda it: abs(it - stamp), default=None) for queue in self._waiting.values()]
        if None in nearest or max(nearest) - min(nearest) > self._slop:
            return
        self.sets += 1
        # What is older than a set cannot be of a later one.
        for queue, taken in zip(self._waiting.values(), nearest):
            while queue and queue[0] <= taken:
                queue.popleft()


def main() -> int:
    parser = arguments.parser(__doc__, timeout=20.0)
    parser.add_argument("--sets", type=int, default=40)
    args = parser.parse_args()
    exact = Synchronizer(["state", "plane_motion", "imu"], 0)
    approximate = Synchronizer(["imu", "own"], TICK)

    with ros.node(args.domain) as node:

        def listen(topic: str, kind: type, qos, synchronizers: list[Synchronizer]) -> None:
            def receive(message) -> None:
                for synchronizer in synchronizers:
                    synchronizer.add(topic, Time.from_msg(message.header.stamp).nanoseconds)

            node.create_subscription(kind, f"/auv/{topic}", receive, qos)

        listen("state", VehicleState, 10, [exact])
        listen("plane_motion", PlaneMotion, 10, [exact])
        listen("imu", Imu, qos_profile_sensor_data, [exact, approximate])
        node.create_timer(1e-9 * TICK, lambda: approximate.add("own", node.get_clock().now().nanoseconds))
        is_done = ros.spin_until(node, lambda: min(exact.sets, approximate.sets) >= args.sets, args.timeout)
    print(json.dumps({"exact": exact.sets, "approximate": approximate.sets}))
    return 0 if is_done else 1


if __name__ == "__main__":
    sys.exit(main())
