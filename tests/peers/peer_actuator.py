#!/usr/bin/env python3
"""Stands in for the actuator as a Cyclone DDS peer: answers every plane command with a JointState alone.

    peer_actuator.py --domain 0 --namespace /auv --rate 0.2 --timeout 60

The planes go where they are asked to, at most --rate rad/s fast; the answer bears the command's stamp, as a
plant_sim with `actuator_answer:=planes` wants it. Ends after --timeout seconds, or when it is killed.
"""

import sys

import arguments
import ros_types
from cyclone import Peer, dds_topic_name, topic_qos, wait_until

TICK = 0.05
"""s, from one command to the next."""


def main() -> int:
    args = arguments.actuator(__doc__)

    joint_state = ros_types.message("sensor_msgs/msg/JointState")
    command = ros_types.message("planesman_msgs/msg/PlaneCommand")
    peer = Peer(args.domain)
    planes = peer.writer(dds_topic_name(f"{args.namespace}/planes"), joint_state, topic_qos())
    commands = peer.reader(dds_topic_name(f"{args.namespace}/plane_command"), command, topic_qos())
    angle = 0.0

    def answer() -> bool:
        nonlocal angle
        for asked in commands.take(N=100):
            if asked.sample_info.valid_data:
                step = max(-args.rate * TICK, min(args.rate * TICK, asked.dive_planes - angle))
                angle += step
                planes.write(
                    joint_state(
                        header=asked.header, name=["dive_planes"], position=[angle], velocity=[step / TICK], effort=[]
                    )
                )
        return False

    wait_until(answer, args.timeout, interval=0.002)
    return 0


if __name__ == "__main__":
    sys.exit(main())
