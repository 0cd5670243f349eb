#!/usr/bin/env python3
"""Stands in for the actuator: answers every plane command with a JointState alone.

    peer_actuator.py --domain 0 --namespace /auv --rate 0.2 --timeout 60

The planes go where they are asked to, at most --rate rad/s fast; the answer bears the command's stamp, as
plant_sim wants it. Ends after --timeout seconds, or when it is killed.
"""

import sys

import arguments
from peer import Peer

TICK = 0.05
"""s, from one command to the next."""


def main() -> int:
    args = arguments.actuator(__doc__)
    angle, step, answered = 0.0, 0.0, None

    with Peer(args.domain) as peer:
        planes = peer.publisher(f"{args.namespace}/planes", "sensor_msgs/msg/JointState")
        commands = peer.subscribe(f"{args.namespace}/plane_command", "planesman_msgs/msg/PlaneCommand")

        def answer() -> bool:
            nonlocal angle, step, answered
            for asked in commands.take(100):
                # A stamp that comes again moves nothing.
                if asked["header"]["stamp"] != answered:
                    step = max(-args.rate * TICK, min(args.rate * TICK, asked["dive_planes"] - angle))
                    angle, answered = angle + step, asked["header"]["stamp"]
                planes.publish(
                    {
                        "header": asked["header"],
                        "name": ["dive_planes"],
                        "position": [angle],
                        "velocity": [step / TICK],
                    }
                )
            return False

        peer.wait_until(answer, args.timeout)
    return 0


if __name__ == "__main__":
    sys.exit(main())
