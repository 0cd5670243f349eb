#!/usr/bin/env python3
"""Stands in for the actuator as an rclpy node: answers every plane command with a JointState alone, as
../peers/peer_actuator.py does.

    peer_actuator.py --domain 0 --namespace /auv --rate 0.2 --timeout 60

The planes go where they are asked to, at most --rate rad/s fast; the answer bears the command's stamp, as a
plant_sim with `actuator_answer:=planes` wants it. Ends after --timeout seconds, or when it is killed.
"""

import sys

import ros
import arguments
from planesman_msgs.msg import PlaneCommand
from sensor_msgs.msg import JointState

TICK = 0.05
"""s, from one command to the next."""


def main() -> int:
    args = arguments.actuator(__doc__)
    angle = 0.0

    with ros.node(args.domain) as node:
        planes = node.create_publisher(JointState, f"{args.namespace}/planes", ros.topic_qos())

        def answer(asked: PlaneCommand) -> None:
            nonlocal angle
            step = max(-args.rate * TICK, min(args.rate * TICK, asked.dive_planes - angle))
            angle += step
            planes.publish(
                JointState(header=asked.header, name=["dive_planes"], position=[angle], velocity=[step / TICK])
            )

        node.create_subscription(PlaneCommand, f"{args.namespace}/plane_command", answer, ros.topic_qos())
        ros.spin_until(node, lambda: False, args.timeout)
    return 0


if __name__ == "__main__":
    sys.exit(main())
